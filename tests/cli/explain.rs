//! `play --explain`: the plan of a stream's last draw, and where its view comes from.

use crate::play::{err, out, run};

#[test]
fn a_streams_last_draw_is_explained_with_its_view() {
    let explained = |stream: &str| {
        let played = run(&["play", "-", "--headless", "--size", "64x48", "--explain"], stream.as_bytes());
        assert_eq!(played.status.code(), Some(0), "{}", err(&played));
        (out(&played).to_owned(), err(&played).to_owned())
    };
    let (framed, _) = explained("MESH pot TEAPOT 2\nMESH box BOX\nDRAW pot\nDRAW box\nCLEAR\n");
    assert!(framed.starts_with("DRAW box\nview: default: the first mesh framed"), "{framed}");
    assert!(framed.contains("\nplan: draw of 12 faces") && framed.contains("  + light pixels"), "{framed}");
    for own in
        ["LOOKAT 0 0 9 0 0 0 0 1 0", "AMBIENT 1 1 1", "LIGHT 0 DIR 0 0 -1 1 1 1", "ORTHO -2 2 -2 2 1 9"]
    {
        let (seen, _) = explained(&format!("MESH box BOX\n{own}\nSHADE flat\nDRAW box\n"));
        assert!(
            seen.starts_with("DRAW box\nview: the stream's own camera and lights\nplan: "),
            "{own}: {seen}"
        );
        assert!(seen.contains("  - light pixels"), "{own}: {seen}");
    }
    let (nothing, said) = explained("MESH pot TEAPOT 2\n");
    assert_eq!((nothing.as_str(), said.as_str()), ("", "fbptr: --explain: there was no draw of faces\n"));
    let both = run(&["play", "-", "--headless", "--movie", "-", "--explain"], b"");
    assert_eq!(both.status.code(), Some(2));
}

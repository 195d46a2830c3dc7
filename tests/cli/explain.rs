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

#[test]
fn figures_are_traced_at_a_pixel_and_the_last_one_counts() {
    let stream = "LINE 2 5 12 8 gold\nFILL 20 5 40 8 25 20 teal\nCIRCLE 30 12 6 white\nFILLRECT 44 1 3 3 red\n\
                  LINEAA 1 1 15 20 red\nFILLPOLY blue 3 15 10 15 10 22 3 22\nCLIP 0 0 9 9\nLINE 0 20 40 20 red\n";
    let traced = |place: &str, stream: &str| {
        let played =
            run(&["play", "-", "--headless", "--size", "48x24", "--trace", place], stream.as_bytes());
        (played.status.code(), out(&played).to_owned())
    };
    for (place, words) in [
        ("9,7", "decision    d = 2m - n = -4"),
        ("25,10", "edge 1      e1 = 3604480, a left edge: inside"),
        ("34,8", "circle of radius 6"),
        ("45,2", "FILLRECT made it 255 0 0 255"),
        ("5,6", "200 of 255"),
        // Outside of the clip rectangle the later line is not drawn.
        ("6,20", "1 crossings before it, odd: inside"),
    ] {
        let (status, text) = traced(place, stream);
        assert!(status == Some(0) && text.contains(words), "{place}: {status:?} {text}");
    }
    let (status, text) = traced("9,7", &format!("{stream}CLIP OFF\nCLEAR navy\n"));
    assert_eq!((status, text.as_str()), (Some(1), ""), "nothing is drawn there after CLEAR");
}

#[test]
fn a_small_picture_is_printed_as_a_table() {
    let table = |words: &[&str], stream: &str| {
        let all = [&["play", "-", "--headless"], words].concat();
        let played = run(&all, stream.as_bytes());
        (played.status.code(), out(&played).to_owned())
    };
    let (status, text) = table(&["--size", "3x2", "--table"], "PX 1 0 ff8000\n");
    assert_eq!(status, Some(0));
    assert_eq!(text, "         0      1      2\n  0 000000 ff8000 000000\n  1 000000 000000 000000\n");
    let (_, text) = table(&["--size", "2x1", "--table=depth"], "");
    assert_eq!(text, "           0        1\n  0 1.000000 1.000000\n");
    assert_eq!(table(&["--size", "65x2", "--table"], "").0, Some(1));
    let rendered = run(&["render", "teapot", "--size", "8x6", "--table=depth"], b"");
    assert!(rendered.status.success() && out(&rendered).lines().count() == 7, "{}", err(&rendered));
    assert!(out(&rendered).contains(" 0."), "{}", out(&rendered));
}

//! `fbptr compare` and `--expect` of `render` and `play`: exit status, words, files.
//!
//! Right is: 0 for equal pictures, 1 for others, with the cause that was put in, and 2 for what
//! cannot be compared.

use crate::folder::Folder;
use crate::play::{err, out, run};

const EXACT: &str = "SIZE 64 48\nCLEAR black\nLINE 2 5 52 18 red\nFILL 10 20 40 20 40 44 lime\n";
/// The line's last pixel is missing, and the diagonal's pixels went to the other side.
const MINE: &str =
    "SIZE 64 48\nCLEAR black\nLINE 2 5 52 18 red\nPX 52 18 000000\nFILL 10 20 40 20 40 44 lime\n";

const SCENE: &str = "<Scene><Viewpoint position='0 0 4'/><Background skyColor='0 0 0.2'/>\
    <Shape><Appearance><Material diffuseColor='0 0 0' emissiveColor='1 0.5 0'/></Appearance>\
    <Box size='1 2 0.5'/></Shape></Scene>";

fn draw(folder: &Folder, name: &str, stream: &str) -> String {
    let picture = folder.path(name);
    let stream = folder.file(&format!("{name}.fbs"), stream);
    let played = run(&["play", &stream, "--headless", "--snap", &picture], b"");
    assert!(played.status.success(), "{}", err(&played));
    picture
}

#[test]
fn a_picture_beside_the_stream_that_it_should_show() {
    let folder = Folder::new("compare");
    let (mine, exact) = (draw(&folder, "mine.png", MINE), folder.file("exact.fbs", EXACT));
    let other = run(&["compare", &mine, &exact], b"");
    assert_eq!(other.status.code(), Some(1), "{}", err(&other));
    let text = out(&other);
    assert!(text.starts_with("1 pixel of 3072 is wrong, by 255 of 255\n"), "{text}");
    assert!(
        text.contains("missing at the end") && text.contains("the line from (2, 5) to (52, 18)"),
        "{text}"
    );
    assert!(text.contains("at (52, 18)"), "{text}");
    let json = run(&["compare", &mine, &exact, "--json"], b"");
    let value: serde_json::Value = serde_json::from_str(out(&json)).unwrap();
    assert_eq!((value["wrong"].as_u64(), value["equal"].as_bool()), (Some(1), Some(false)));
    assert_eq!(value["findings"][0]["class"], "missing-at-end");
    let page = folder.path("wrong.html");
    run(&["compare", &mine, &exact, "--page", &page], b"");
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("data:image/png;base64") && page.contains("missing-at-end"), "{}", page.len());
    // One pixel may differ, and then the pictures count as equal.
    assert_eq!(run(&["compare", &mine, &exact, "--tolerance", "0,1"], b"").status.code(), Some(0));
    let same = draw(&folder, "same.png", EXACT);
    let equal = run(&["compare", &same, &exact], b"");
    assert_eq!((equal.status.code(), out(&equal)), (Some(0), "equal: no pixel of 3072 is wrong\n"));
}

#[test]
fn a_picture_beside_a_scene_and_its_render_beside_the_picture() {
    let folder = Folder::new("compare-scene");
    let (scene, picture) = (folder.file("s.x3d", SCENE), folder.path("s.png"));
    let rendered = run(&["render", &scene, "-o", &picture, "--size", "64x48"], b"");
    assert!(rendered.status.success(), "{}", err(&rendered));
    assert_eq!(run(&["compare", &picture, &scene], b"").status.code(), Some(0));
    let equal = run(&["render", &scene, "--size", "64x48", "--expect", &picture], b"");
    assert_eq!(equal.status.code(), Some(0), "{}", err(&equal));
    let other = folder.file("t.x3d", SCENE.replace("1 0.5 0'", "0.5 0.25 0'"));
    let dark = run(&["render", &other, "--size", "64x48", "--expect", &picture], b"");
    assert_eq!(dark.status.code(), Some(1));
    assert!(err(&dark).contains("off by a factor: 0.50"), "{}", err(&dark));
    assert!(std::fs::exists(folder.path("s.diff.png")).unwrap());
    let beside = run(&["render", &other, "--size", "64x48", "--expect", &scene], b"");
    assert_eq!(beside.status.code(), Some(1));
    assert!(err(&beside).contains("off by a factor: 0.50"), "{}", err(&beside));
}

#[test]
fn play_expects_a_picture_or_a_stream() {
    let folder = Folder::new("expect");
    let (mine, exact) = (folder.file("mine.fbs", MINE), folder.file("exact.fbs", EXACT));
    let picture = draw(&folder, "exact.png", EXACT);
    for expected in [&picture, &exact] {
        let equal = run(&["play", &exact, "--headless", "--expect", expected], b"");
        assert_eq!(equal.status.code(), Some(0), "{}", err(&equal));
        let other = run(&["play", &mine, "--headless", "--expect", expected], b"");
        assert_eq!(other.status.code(), Some(1));
        assert!(err(&other).contains("1 pixel of 3072 is wrong"), "{}", err(&other));
    }
}

#[test]
fn what_cannot_be_compared_has_status_2() {
    let folder = Folder::new("compare-bad");
    let exact = folder.file("exact.fbs", EXACT);
    let broken = folder.file("broken.png", b"no picture");
    for words in [
        vec!["compare", "none.png", &exact],
        vec!["compare", &broken, &exact],
        vec!["compare", &exact],
        vec!["compare", &exact, &exact, "--tolerance", "x"],
        vec!["compare", &exact, &exact, "--page", "none/page.html"],
        vec!["play", &exact, "--headless", "--expect", "none.x3d"],
        vec!["render", "teapot", "--expect", "a.png", "--frames", "2"],
    ] {
        let bad = run(&words, b"");
        assert_eq!(bad.status.code(), Some(2), "{words:?}: {}", err(&bad));
    }
    let bad = folder.file("bad.fbs", "LINE 1\n");
    let refused = run(&["compare", &exact, &bad], b"");
    assert_eq!(refused.status.code(), Some(2), "{}", err(&refused));
    assert!(err(&refused).contains("bad.fbs:1"), "{}", err(&refused));
}

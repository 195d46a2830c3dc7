//! Draws that show nothing are counted, and explained once to clients that receive errors.

use crate::folder::Folder;
use crate::process::fbptr;
use crate::support::Serving;
use std::process::Stdio;

const LIGHT: &str = "LIGHT 0 DIR 0 0 -1 1 1 1\n";
/// A triangle that shows its back to the initial camera.
const BACK: &str = "MESH m OBJ :32\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 3 2\n";
const EMPTY_SCENE: &str = "SCENE X3D :40\n<X3D version='3.3'><Scene></Scene></X3D>\nDRAWSCENE\n";
const CLEAR_SCENE: &str = "SCENE X3D :120\n<X3D version='3.3'><Scene><Shape><Appearance>\
    <Material transparency='1'/></Appearance><Box/></Shape></Scene></X3D>      \nDRAWSCENE\n";
/// A scene of one shape far behind the camera, with X3D's headlight.
const SCENE_BEHIND: &str = "SCENE X3D :170\n<X3D version='3.3'><Scene><Viewpoint position='0 0 5'/>\
    <Transform translation='0 0 50'><Shape><Appearance><Material/></Appearance><Box/></Shape></Transform>\
    </Scene></X3D>\nDRAWSCENE\n";

/// Streams that draw once, each with its explanation.
const CASES: [(&str, &str); 18] = [
    // To take a light away is to have a view of one's own.
    ("LIGHT 0 OFF\nMESH m BOX\nDRAW m\n", "all of it is black: there is no light"),
    ("AMBIENT 1 1 1\nMESH m BOX\nDRAW m\n", "all of it is black: there is no light"),
    ("*MESH m BOX\nTRANSLATE 0 0 20\nDRAW m\n", "nothing is drawn: all of it lies behind the eye"),
    ("*MESH m BOX\nTRANSLATE 50 0 0\nDRAW m\n", "nothing is drawn: all of it lies outside the view"),
    (
        "*MESH m BOX\nTRANSLATE 50 0 0\nSHADE wire\nDRAW m\n",
        "nothing is drawn: all of it lies outside the view",
    ),
    ("*<BACK>DRAW m\n", "nothing is drawn: CULL leaves out all faces in view"),
    ("*MESH m BOX\nSCALE 1e-5 1e-5 1e-5\nTRANSLATE 12345 0 0\nDRAW m\n", "nothing is drawn: no face covers"),
    (
        "*MESH m BOX\nVIEWPORT 900 0 10 10\nDRAW m\n",
        "nothing is drawn: no pixel of the frame lies in its viewport",
    ),
    (
        "*MESH m BOX\nVIEWPORT 0 0 0 10\nDRAW m\n",
        "nothing is drawn: no pixel of the frame lies in its viewport",
    ),
    // A clip rectangle without a pixel, one beside the view, one beside the box, and one on it.
    ("*MESH m BOX\nCLIP 5 5 0 0\nDRAW m\n", "nothing is drawn: no pixel of it lies in the clip rectangle"),
    (
        "*MESH m BOX\nVIEWPORT 0 0 9 9\nCLIP 20 20 9 9\nDRAW m\n",
        "nothing is drawn: no pixel of it lies in the",
    ),
    ("*MESH m BOX\nCLIP 0 0 2 2\nDRAW m\n", "nothing is drawn: no pixel of it lies in the clip rectangle"),
    ("*MESH m BOX\nCLIP 0 0 40 40\nTRANSLATE 0 0 20\nDRAW m\n", "nothing is drawn: all of it lies behind"),
    ("CLIP 63 0 9 1\n<SCENE_BESIDE>", "nothing is drawn: no pixel of it lies in the clip rectangle"),
    ("<CLEAR_SCENE>", "nothing is seen: all of it is fully transparent"),
    ("<EMPTY_SCENE>", "nothing is drawn: there are no faces, lines or points in it"),
    ("<SCENE_BEHIND>", "nothing is drawn: all of it lies behind the eye"),
    ("*MESH m BOX\nDEPTH u16\nHIDE zbuffer\nPERSPECTIVE 0.7 1 3\nDRAW m\n", "nothing is drawn: "),
];

/// Returns the stream of a case after a CLEAR: the depth buffer is shared by all clients.
fn stream(case: &str) -> String {
    format!("CLEAR\n{case}")
        .replace('*', LIGHT)
        .replace("<BACK>", BACK)
        .replace("<EMPTY_SCENE>", EMPTY_SCENE)
        .replace("<CLEAR_SCENE>", CLEAR_SCENE)
        .replace("<SCENE_BESIDE>", &SCENE_BEHIND.replace("0 0 50", "0 0 -9"))
        .replace("<SCENE_BEHIND>", SCENE_BEHIND)
}

#[test]
fn each_reason_is_explained_at_the_draw() {
    let serving = Serving::start(64, 48);
    for (case, reason) in CASES {
        let stream = stream(case);
        let verb = if stream.contains("DRAWSCENE") { "DRAWSCENE" } else { "DRAW" };
        let byte = stream.rfind(verb).unwrap();
        let line = 1 + stream[..byte].matches('\n').count();
        let told = serving.say(&format!("{stream}STATS\n"));
        assert!(told.starts_with(&format!("WARN {line} {byte} {verb}: {reason}")), "{case}: {told}");
        assert!(told.contains(" empty_draws=1 ") && told.contains(" errors=0 "), "{case}: {told}");
    }
}

#[test]
fn an_eye_off_the_frame_and_what_is_hidden_are_told_too() {
    let serving = Serving::start(64, 48);
    let eye = fbptr().args(["eye", "--make", "tesseract"]).output().unwrap().stdout;
    let mut request = format!("EYE e :{}\n", eye.len()).into_bytes();
    request.extend_from_slice(&eye);
    request.extend_from_slice(b"\nDRAWEYE e 64 0 9 9\nDRAWEYE e 0 0 9 9\nSTATS\n");
    let told = String::from_utf8(serving.talk(&request)).unwrap();
    assert!(
        told.contains(" DRAWEYE: nothing is drawn: no pixel of the frame")
            && told.contains(" empty_draws=1 "),
        "{told}"
    );
    let told = serving.say(&format!("CLEAR\n{LIGHT}MESH m BOX\nDRAW m\nTRANSLATE 0 0 -3\nDRAW m\nSTATS\n"));
    assert!(
        told.starts_with("WARN 6 ") && told.contains("all its pixels lie behind what is there"),
        "{told}"
    );
    assert!(told.contains(" empty_draws=1 "), "{told}");
}

#[test]
fn what_shows_something_is_not_explained() {
    let serving = Serving::start(64, 48);
    for case in [
        "*MESH m BOX\nDRAW m\n",
        // Framed and lit by default.
        "MESH m BOX\nDRAW m\n",
        // Visible without light: edges, emissive colours, ambient light.
        "MESH m BOX\nSHADE wire\nDRAW m\n",
        "MESH m BOX\nMATERIAL 0 0 0 1 1 1 0 0 0 1 .5 0 0\nDRAW m\n",
        "AMBIENT .5 .5 .5\nMATERIAL 1 1 1 1 1 1 0 0 0 1\nMESH m BOX\nDRAW m\n",
    ] {
        let told = serving.say(&format!("{}STATS\n", stream(case)));
        assert!(told.starts_with("STATS ") && told.contains(" empty_draws=0 "), "{case}: {told}");
    }
}

#[test]
fn a_reason_is_told_once_and_only_where_errors_are_told() {
    let serving = Serving::start(64, 48);
    let twice = "LIGHT 0 OFF\nMESH m BOX\nDRAW m\nCLEAR\nDRAW m\nTRANSLATE 0 0 20\nDRAW m\nDRAW m\n";
    let told = serving.say(&format!("{twice}STATS\n"));
    assert_eq!(told.matches("WARN ").count(), 2, "{told}");
    assert!(told.contains(" empty_draws=4 ") && told.contains(" total_empty_draws=4 "), "{told}");
    let told = serving.say(&format!("CLEAR\nERRORS count\n{twice}STATS\n"));
    assert!(told.starts_with("STATS ") && told.contains(" empty_draws=4 "), "{told}");
    // A client that asks for reports later is told at its next empty draw.
    let told =
        serving.say("CLEAR\nERRORS count\nLIGHT 0 OFF\nMESH m BOX\nDRAW m\nERRORS report\nCLEAR\nDRAW m\n");
    assert_eq!(told.matches("WARN ").count(), 1, "{told}");
}

#[test]
fn play_names_file_and_line_and_ends_well() {
    let folder = Folder::new("empty-draws");
    let file = folder.join("pot.fbs");
    std::fs::write(&file, "LIGHT 0 OFF\nMESH pot TEAPOT 4\nDRAW pot\n").unwrap();
    let out =
        fbptr().args(["play", file.to_str().unwrap(), "--headless"]).stdin(Stdio::null()).output().unwrap();
    let told = String::from_utf8(out.stderr).unwrap();
    let want = format!("fbptr: {}:3: DRAW: all of it is black: there is no light", file.display());
    assert!(told.starts_with(&want) && told.lines().count() == 1, "{told}");
    assert_eq!(out.status.code(), Some(0));
}

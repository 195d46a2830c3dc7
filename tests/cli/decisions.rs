//! `fbptr report --scene`: files of every kind, what is refused, and that the recommended command
//! draws the picture of its row.
//!
//! Right is: a decision of each file, with its pictures; status 2 for what is no file and 1 for what
//! shows nothing. No time is asserted.

use crate::folder::Folder;
use crate::play::{err, out, run};
use serde_json::Value;
use std::process::Command;

/// A ball under a light, and six that add too little to be seen, which a budget leaves out.
fn scene() -> String {
    let dim = "<DirectionalLight direction='0 0 -1' intensity='0.0002'/>".repeat(6);
    format!(
        "<Scene><NavigationInfo headlight='false'/><DirectionalLight direction='-0.3 -0.4 -1'/>{dim}\
         <Viewpoint position='0 0 4'/><Shape><Appearance><Material diffuseColor='0.7 0.6 0.5'/></Appearance><Sphere/>\
         </Shape></Scene>"
    )
}

const STREAM: &str =
    "# a stream\nSIZE 64 48\nMESH m TEAPOT\nCLEAR black\nDRAW m\nPRESENT\nCLEAR black\nDRAW m\nPRESENT\n";

/// Returns the first decision of a report on a file, which is written to the folder `name`.
fn decided(folder: &Folder, name: &str, words: &[&str]) -> Value {
    let into = folder.path(name);
    let mut all = vec!["report", "--quick", "--out", &into];
    all.extend(words);
    let ran = run(&all, b"");
    assert!(ran.status.success(), "{words:?}: {}", err(&ran));
    let text = std::fs::read_to_string(format!("{into}/report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    let page = std::fs::read_to_string(format!("{into}/report.html")).unwrap();
    assert!(page.contains("data:image/png;base64") && page.contains("<svg"), "{name}");
    report["decisions"][0].clone()
}

fn setting<'a>(decision: &'a Value, name: &str) -> &'a Value {
    let rows = decision["rows"].as_array().unwrap();
    rows.iter().find(|row| row["setting"] == name).unwrap_or_else(|| panic!("no {name} in {rows:?}"))
}

/// Runs a command line in the folder, with this build of the program.
fn shell(folder: &Folder, line: &str) {
    let line = line.replace("fbptr ", &format!("{} ", env!("CARGO_BIN_EXE_fbptr")));
    let ran = Command::new("sh").arg("-c").arg(&line).current_dir(&folder.0).output().unwrap();
    assert!(ran.status.success(), "{line}: {}", err(&ran));
}

#[test]
fn a_scene_is_decided_and_each_command_draws_its_row() {
    let folder = Folder::new("decide-scene");
    let file = folder.file("a ball.x3d", scene());
    let words = ["--scene", &file, "--size", "160x120", "--background", "navy", "--max-error", "4"];
    let decision = decided(&folder, "report", &words);
    assert_eq!(
        (&decision["size"], &decision["limit"]),
        (&serde_json::json!([160, 120]), &serde_json::json!(4.0))
    );
    for name in ["exact", "max-error 4", "gouraud"] {
        let row = setting(&decision, name);
        assert_eq!(row["errors"]["coverage off, pixels"], 0.0, "{row}");
        let drawn = format!("report/a-ball-{}.png", name.replace(' ', "-"));
        // What has exact's errors and is no faster has no picture.
        if row["time_left_out"] == false {
            shell(&folder, row["command"].as_str().unwrap());
            let [drawn, own] =
                [drawn, "a ball.png".into()].map(|f| image::open(folder.path(&f)).unwrap().to_rgba8());
            assert!(drawn == own, "{name}: {}", row["command"]);
        }
    }
    let sentence = decision["time_recommendation"].as_str().unwrap();
    let command = sentence.split('`').nth(1).unwrap();
    assert!(command.contains("--size 160x120 --background navy"), "{command}");
    shell(&folder, command);
}

#[test]
fn a_budget_of_the_same_work_is_named_and_has_no_row() {
    let folder = Folder::new("decide-same");
    let ran = run(&["report", "--quick", "--scene", "cornell", "--size", "40x30", "--max-error", "0.5"], b"");
    assert!(ran.status.success(), "{}", err(&ran));
    assert!(out(&ran).contains("| max-error 0.5 | the same work as exact |"), "{}", out(&ran));
    let file = folder.file("ball.x3d", scene());
    // The time of an animation is the given one; a camera within the ball sees its inside or nothing.
    let inside = folder.file("inside.x3d", scene().replace("0 0 4", "0 0 0"));
    let ran = run(&["report", "--quick", "--scene", &file, "--scene", &inside, "--size", "40x30"], b"");
    assert_eq!(ran.status.code(), Some(1));
    assert!(err(&ran).contains("inside.x3d: nothing to compare, the picture is empty: "), "{}", err(&ran));
}

#[test]
fn streams_and_scenes_of_n_dimensions_are_decided() {
    let folder = Folder::new("decide-others");
    let stream = folder.file("pot.fbs", STREAM);
    let decision = decided(&folder, "stream", &["--scene", &stream, "--max-error", "30"]);
    shell(&folder, setting(&decision, "max-error 30")["command"].as_str().unwrap());
    let play = setting(&decision, "exact")["command"].as_str().unwrap();
    shell(&folder, play);
    let [own, drawn] =
        ["frame.png", "stream/pot-exact.png"].map(|f| image::open(folder.path(f)).unwrap().to_rgba8());
    assert!(own == drawn && decision["size"] == serde_json::json!([64, 48]));
    let eye = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/nd-cases/c06_4to2_tesseract.json");
    let decision = decided(&folder, "eye", &["--scene", eye]);
    assert!(setting(&decision, "exact")["errors"]["largest error, 1/255"].as_f64().unwrap() < 1e-6);
    assert!(setting(&decision, "fan of 3 rays")["errors"]["coverage off, pixels"].as_f64().unwrap() > 0.0);
    shell(&folder, setting(&decision, "fan of 3 rays")["command"].as_str().unwrap());
}

#[test]
fn what_is_no_picture_is_refused_with_its_reason() {
    let folder = Folder::new("decide-refused");
    let empty = folder.file("empty.x3d", "<Scene/>");
    let broken = folder.file("broken.fbs", "LINE 1\n");
    let nothing = folder.file("nothing.fbs", "");
    let eye = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/nd-cases/c06_4to2_tesseract.json");
    for (words, status, said) in [
        (vec!["--scene", "none.obj"], 2, "none.obj: No such file"),
        (vec!["--scene", &empty], 1, "empty.x3d: nothing to compare"),
        (vec!["--scene", &nothing], 1, "nothing.fbs: nothing to compare"),
        (vec!["--scene", &broken], 1, "broken.fbs:1"),
        (vec!["--scene", "teapot", "--size", "0x10"], 2, "a size is WxH"),
        (vec!["--scene", "teapot", "--near", "5", "--far", "1"], 2, "--near 5 must be less"),
        (vec!["--scene", eye, "--max-error", "4"], 2, "--max-error is for scenes in three dimensions"),
        (vec!["--max-error", "4"], 2, "--scene"),
    ] {
        let ran = run(&[&["report", "--quick"], &words[..]].concat(), b"");
        assert_eq!(ran.status.code(), Some(status), "{words:?}: {}", err(&ran));
        assert!(err(&ran).contains(said), "{words:?}: {}", err(&ran));
    }
}

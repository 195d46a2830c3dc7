//! Verifies that pictures and errors of `fbptr eye` suit a script.

use fbptr::eye::{EyePicture, EyeScene};
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn fbptr(arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_fbptr"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A program that has refused its arguments does not read its input.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    child.wait_with_output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

#[test]
fn the_worked_cases_come_out_as_json() {
    for name in ["c01_2to1_parallel", "c05_3to1_cubes", "c06_4to2_tesseract", "h10_room_3to2"] {
        let path = data(&format!("nd-cases/{name}.json"));
        let case: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let scene = EyeScene::from_value(&case).unwrap();
        let expected = EyePicture::from_value(&case["expected"], &scene).unwrap();
        // The whole case by its file name; its scene alone through a pipe, on three threads.
        let piped = case["scene"].to_string();
        let ways = [(vec!["eye", path.to_str().unwrap()], ""), (vec!["eye", "-", "--threads", "3"], &piped)];
        for (arguments, input) in ways {
            let output = fbptr(&arguments, input);
            assert!(output.status.success() && output.stderr.is_empty(), "{name}: {}", text(&output.stderr));
            let value: Value = serde_json::from_slice(&output.stdout).unwrap();
            let keys: Vec<&String> = value.as_object().unwrap().keys().collect();
            assert_eq!(keys, ["color", "dist", "facet", "lit", "skipped_facets"]);
            let picture = EyePicture::from_value(&value, &scene).unwrap();
            assert!(picture.differences(&expected, &[]).are_none(), "{name}");
        }
    }
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let good = std::fs::read_to_string(data("nd-cases/c01_2to1_parallel.json")).unwrap();
    for (from, to, want) in [
        ("[3.2, 2.1]", "[3.2]", "fbptr: -: EFORMAT: scene.facets[0].v[1]: expected 2 entries, found 1\n"),
        ("\"I_d\"", "\"I_q\"", "fbptr: -: EFORMAT: scene.I_q: unknown field"),
        ("[20]", "[99999999]", "fbptr: -: ETOOBIG: scene.pixels: 99999999 is over the limit of 67108864\n"),
        ("[3.2, 2.1]", "[3.2, 1e999]", "fbptr: -: EFORMAT: line 1 column"),
    ] {
        let output = fbptr(&["eye", "-"], &good.replacen(from, to, 1));
        assert_eq!((output.status.code(), text(&output.stdout)), (Some(1), ""));
        assert!(text(&output.stderr).starts_with(want), "{}", text(&output.stderr));
    }
    for arguments in [
        &["eye"][..],
        &["eye", "no such file.json"],
        &["eye", "-", "--fan", "0"],
        &["eye", "--make", "dodecahedron"],
        &["eye", "--make", "cube", "--dim", "9"],
        &["eye", "--make", "cube", "--pixels", "3x0"],
        &["eye", "--make", "cube", "--pixels", "3x3x3x3"],
        &["eye", "--make", "cube", "--turn", "0,0,5"],
        &["eye", "--make", "prism"],
        &["eye", "--make", "cube", "--bench"],
    ] {
        let input = std::fs::read_to_string(data("nd-cases/c05_3to1_cubes.json")).unwrap();
        let output = fbptr(arguments, &input);
        assert_eq!(output.status.code(), Some(2), "{arguments:?} {}", text(&output.stdout));
        assert!(!output.stderr.is_empty());
    }
}

#[test]
fn what_is_made_can_be_seen() {
    let makes: [&[&str]; 7] = [
        &["simplex", "--dim", "5", "--pixels", "12x9"],
        &["cube", "--dim", "3", "--pixels", "40"],
        &["tesseract", "--pixels", "16x12"],
        &["cross-polytope", "--dim", "6", "--pixels", "5x4x3"],
        &["24-cell", "--pixels", "6x6x6", "--turn", "0,3,-30"],
        &["cube", "--dim", "2", "--pixels", "9"],
        &["cube", "--dim", "6", "--pixels", "3x3"],
    ];
    for make in makes {
        let made = fbptr(&[&["eye", "--make"], make].concat(), "");
        assert!(made.status.success(), "{make:?}: {}", text(&made.stderr));
        let seen = fbptr(&["eye", "--explain", "-"], text(&made.stdout));
        assert!(seen.status.success() && text(&seen.stderr).starts_with("space      "), "{make:?}");
        let value: Value = serde_json::from_slice(&seen.stdout).unwrap();
        let hits = value["facet"].as_array().unwrap().iter().filter(|f| f.as_i64().unwrap() >= 0).count();
        assert!(hits > 0, "{make:?} shows nothing");
        assert_eq!(value["skipped_facets"].as_array().unwrap().len(), 0);
    }
}

#[test]
fn a_prism_over_a_mesh_is_seen_as_the_mesh() {
    let obj = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("eye_prism.obj");
    std::fs::write(&obj, "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").unwrap();
    let make = |dim: &str| {
        let mesh = obj.to_str().unwrap();
        let arguments = [
            "eye", "--make", "prism", "--mesh", mesh, "--dim", dim, "--pixels", "20x15", "--turn", "0,1,40",
            "--half", "0.0001",
        ];
        let made = fbptr(&arguments, "");
        assert!(made.status.success(), "{}", text(&made.stderr));
        let seen = fbptr(&["eye", "-"], text(&made.stdout));
        serde_json::from_slice::<Value>(&seen.stdout).unwrap()
    };
    let (flat, drawn_out) = (make("3"), make("4"));
    // A prism this short does not move the eye away.
    let facets = |value: &Value, parts: i64| -> Vec<i64> {
        let list = value["facet"].as_array().unwrap();
        list.iter().map(|f| f.as_i64().unwrap()).map(|f| if f < 0 { f } else { f / parts }).collect()
    };
    assert!(facets(&flat, 1).iter().any(|&f| f >= 0));
    assert_eq!(facets(&flat, 1), facets(&drawn_out, 3));
}

#[test]
fn render_writes_the_sheet_and_a_line_as_a_band() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    for (name, want) in [("c01_2to1_parallel", [20, 3]), ("c06_4to2_tesseract", [16, 12])] {
        let case = data(&format!("nd-cases/{name}.json"));
        let out = folder.join(format!("{name}.ppm"));
        let output = fbptr(&["render", case.to_str().unwrap(), "-o", out.to_str().unwrap()], "");
        assert!(output.status.success(), "{}", text(&output.stderr));
        let picture = std::fs::read(&out).unwrap();
        let [w, h] = want;
        assert!(picture.starts_with(format!("P6\n{w} {h}\n255\n").as_bytes()), "{name}");
        let expected: Value = serde_json::from_slice(&std::fs::read(&case).unwrap()).unwrap();
        let colors = expected["expected"]["color"].as_array().unwrap();
        let first_row = &picture[picture.len() - 3 * w * h..][..3 * w];
        for (i, byte) in first_row.iter().enumerate() {
            let real = colors[i / 3][i % 3].as_f64().unwrap();
            assert_eq!(*byte, (real + 0.5).floor() as u8, "{name} byte {i}");
        }
    }
}

#[test]
fn what_belongs_to_scenes_of_faces_is_refused() {
    let case = data("nd-cases/c06_4to2_tesseract.json");
    for flag in [["--near", "1"], ["--far", "9"], ["--shade", "flat"]] {
        let arguments = ["render", case.to_str().unwrap(), "-o", "never.png", flag[0], flag[1]];
        let output = fbptr(&arguments, "");
        assert_eq!(output.status.code(), Some(2), "{flag:?}");
        let said = text(&output.stderr);
        assert!(said.contains(flag[0]) && said.contains("N-dimensional"), "{said}");
    }
}

#[test]
fn what_belongs_to_the_bench_alone_is_refused_elsewhere() {
    for arguments in [
        &["eye", "--make", "tesseract", "--out", "x.html"][..],
        &["eye", "--make", "tesseract", "--quick"],
        &["eye", "scene.json", "--out", "x.html"],
        &["eye", "--out", "x.html"],
    ] {
        let output = fbptr(arguments, "");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{arguments:?}");
    }
}

#[test]
fn the_table_of_fans_has_every_space_and_screen() {
    let page = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("fan.html");
    let output = fbptr(&["eye", "--bench", "--quick", "--out", page.to_str().unwrap()], "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    for subject in [
        "3 dimensions on 1",
        "4 dimensions on 2",
        "5 dimensions on 3",
        "4 dimensions on 1",
        "5 dimensions on 1",
    ] {
        assert!(text(&output.stdout).contains(&format!("| {subject} | **exact** | 0 |")), "{subject}");
    }
    assert!(std::fs::read_to_string(page).unwrap().contains("<svg"));
    for part in ["## The N-dimensional eye on threads", "facets^", "## Goals"] {
        assert!(text(&output.stdout).contains(part), "{part}");
    }
}

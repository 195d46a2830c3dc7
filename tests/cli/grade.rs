//! `fbptr grade`: points, status and words; programs that crash, hang, print nonsense or start too
//! much lose their item, and leave nothing.
//!
//! Programs are lines of a shell, which the device's library reaches, and which print streams.

use crate::folder::Folder;
use crate::play::{err, out, run};

const SHEET: &str = "\
title: a sheet
size: 32x24
by: stdout
time: 5s
memory: 64M
input: exact

item: same
points: 2
exact:
    LINE 2 3 20 9 ff0000

item: other
points: 4
partly: 50%
exact:
    FILLRECT 4 4 10 10 00ff00
    LINE 2 3 20 9 ff0000

item: numbers
input: none
numbers: 1 2 3
";

/// Runs a script for each item: it knows the item by its input.
fn grade(folder: &Folder, sheet: &str, options: &[&str], script: &str) -> (Option<i32>, String, String) {
    let sheet = folder.file("a.sheet", sheet);
    let mut words = vec!["grade", &sheet];
    words.extend(options);
    words.extend(["--", "/bin/sh", "-c", script]);
    let ended = run(&words, b"");
    (ended.status.code(), out(&ended).to_owned(), err(&ended).to_owned())
}

#[test]
fn points_are_whole_partly_or_none_and_the_status_says_so() {
    let folder = Folder::new("grade");
    let right = "read first rest; case $first in none) echo 1 2, 3;; *) echo $first $rest; cat;; esac";
    let (status, text, said) = grade(&folder, SHEET, &[], right);
    assert_eq!(status, Some(0), "{text}{said}");
    assert!(text.ends_with("7 of 7 points\n"), "{text}");
    // One row of the square and the last pixel of the line are missing; numbers come in another order.
    let wrong = "read first rest; case $first in none) echo 1 3 2;; FILLRECT) echo FILLRECT 4 4 10 9 lime; cat;; \
                 *) echo LINE 2 3 19 9 ff0000;; esac";
    let page = folder.path("result.html");
    let (status, text, _) = grade(&folder, SHEET, &["--page", &page], wrong);
    assert_eq!(status, Some(1), "{text}");
    assert!(text.contains("0 of 2     same:") && text.contains("missing at the end"), "{text}");
    assert!(
        text.contains("3.6 of 4     other: 90.8 % right") && text.contains("number 2: 2 is expected, 3 was"),
        "{text}"
    );
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("data:image/png;base64") && page.contains("3.6 of 7 points"), "{}", page.len());
    let (_, json, _) = grade(&folder, SHEET, &["--json", "--item", "other"], wrong);
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (value["points"].as_f64(), value["of"].as_f64(), value["full"].as_bool()),
        (Some(3.6), Some(4.0), Some(false))
    );
    assert_eq!(value["items"][0]["difference"]["wrong"], 10);
}

#[test]
fn a_program_that_goes_wrong_loses_its_item_and_leaves_nothing() {
    let folder = Folder::new("grade-wrong");
    let short = SHEET.replace("time: 5s", "time: 1s");
    let mark = format!("86400.{}", std::process::id());
    for (script, sheet, said) in [
        ("kill -SEGV $$", SHEET, "crashed: an access outside of its memory"),
        ("exit 3", SHEET, "printed nothing; it ended with status 3"),
        ("echo nonsense", SHEET, "no stream of commands: the program's output:1: "),
        ("echo SIZE 8 8; echo PX 1 1 red", SHEET, "the picture has 8x8 pixels, the exact one 32x24"),
        ("echo CLEAR black", SHEET, "nothing is drawn"),
        (&format!("sleep {mark} & sleep {mark}"), &short, "did not end within 1s"),
        ("yes", SHEET, "printed more than 64 MiB"),
        (
            &format!("i=0; while [ $i -lt 80 ]; do sleep {mark} & i=$((i+1)); done; wait"),
            SHEET,
            "more than 64 processes",
        ),
        (
            &format!("x=aaaaaaaaaaaaaaaa; while [ ${{#x}} -lt 200000000 ]; do x=$x$x; done; sleep {mark}"),
            SHEET,
            "more than 64 MiB of memory",
        ),
    ] {
        let (status, text, error) = grade(&folder, sheet, &["--item", "same"], script);
        assert_eq!(status, Some(1), "{script}: {text}{error}");
        assert!(text.contains(said) && text.ends_with("0 of 2 points\n"), "{script}: {text}");
    }
    let left = std::fs::read_dir("/proc").unwrap().flatten().any(|process| {
        let line = std::fs::read(process.path().join("cmdline")).unwrap_or_default();
        String::from_utf8_lossy(&line).starts_with(&format!("sleep\0{mark}"))
    });
    assert!(!left, "a process is left");
}

#[test]
fn a_wrong_sheet_or_use_has_status_2_and_its_line() {
    let folder = Folder::new("grade-use");
    for (sheet, said) in [
        ("item: a\npointz: 2\n", "a.sheet:2: \"pointz\" is no key of a sheet"),
        ("item: a\nsize: 8x8\nexact:\n    LINE 1 2\n", "a.sheet:1: item a: "),
        ("item: a\nsize: 8x8\nexact:\n    CLEAR red\n", "nothing is drawn in it"),
        ("item: a\nsize: 8x8\nexact: no.png\n", "no.png"),
        ("item: a\noptions: --no-such\nexact:\n    PX 1 1 red\n", "options: "),
    ] {
        let (status, _, error) = grade(&folder, sheet, &[], "true");
        assert_eq!(status, Some(2), "{sheet}: {error}");
        assert!(error.contains(said), "{sheet}: {error}");
    }
    for (words, said) in [
        (&["grade", "T1"][..], "a program is expected after --"),
        (&["grade", "T1", "--", "./no-such-program"], "no-such-program"),
        (&["grade", "no-such-sheet", "--", "true"], "fbptr grade --list"),
        (&["grade", "T1", "--item", "no", "--", "true"], "the sheet's items are points, octants"),
        (&["grade", "R1", "--", "true"], "a folder with the student's gl.py"),
    ] {
        let ended = run(words, b"");
        assert_eq!(ended.status.code(), Some(2), "{words:?}: {}", err(&ended));
        assert!(err(&ended).contains(said), "{words:?}: {}", err(&ended));
    }
    let list = run(&["grade", "--list"], b"");
    assert!(out(&list).starts_with("T1 - ") && list.status.success(), "{}", err(&list));
}

/// The exact stream itself, and the shared file, have all points of the first assignments.
#[test]
fn the_sheets_give_all_points_to_what_is_right() {
    for sheet in ["T1", "T1b"] {
        let ended = run(&["grade", sheet, "--by", "stdout", "--", "cat"], b"");
        assert_eq!(ended.status.code(), Some(0), "{sheet}: {}{}", out(&ended), err(&ended));
    }
    let folder = Folder::new("grade-memory");
    let sheet = folder.file("m.sheet", "item: m\nsize: 2x1\nexact:\n    PX 1 0 ff0000\n");
    let draw = "printf '\\377\\000\\000\\377' | dd of=\"$1\" bs=1 seek=4100 conv=notrunc 2>/dev/null";
    let ended = run(&["grade", &sheet, "--", "/bin/sh", "-c", draw, "sh", "{memory}"], b"");
    assert_eq!(ended.status.code(), Some(0), "{}{}", out(&ended), err(&ended));
}

/// By other options, and as the mean of several samples, a picture is right as well.
#[test]
fn what_is_right_may_be_several_pictures() {
    let folder = Folder::new("grade-several");
    let scene = "<X3D><Scene><Shape><Polyline2D lineSegments='2 2  6 2'/><Appearance>\
                 <Material emissiveColor='1 1 1'/></Appearance></Shape></Scene></X3D>";
    let sheet = format!(
        "size: 16x8\nby: stdout\noptions: --dialect renderizador\nor: --dialect renderizador --camera diagonal\nsamples: 2\n\
         item: line\nexact:\n    {scene}\n"
    );
    let line = grade(&folder, &sheet, &[], "echo LINE 2 2 6 2 white");
    assert!(line.1.contains("1 of 1     line: right\n"), "{line:?}");
    let mean = grade(&folder, &sheet, &[], "echo LINE 2 2 5 2 808080; echo PX 6 2 404040");
    assert!(mean.1.contains("line: with 2x2 samples a pixel: right\n"), "{mean:?}");
    let none = grade(&folder, &sheet, &[], "echo LINE 2 2 6 2 808080");
    assert!(none.0 == Some(1) && none.1.contains("line: with 2x2 samples a pixel: 1 pixel"), "{none:?}");
    let (status, _, error) = grade(&folder, &sheet.replace(scene, "PX 1 1 red"), &[], "true");
    assert!(status == Some(2) && error.contains("an X3D scene is expected"), "{error}");
}

/// An interpreter without the package is named with the command that installs it, before anything runs.
#[test]
fn sheets_of_the_python_framework_need_its_package_and_others_do_not() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("grade-python");
    for (script, said) in [
        ("echo numpy", "has no numpy: "),
        ("echo fbptr", "-m pip install 'fbptr[numpy]'"),
        ("exit 1", "it is no Python 3 that runs"),
    ] {
        let python = folder.file("python", format!("#!/bin/sh\n{script}\n"));
        std::fs::set_permissions(&python, PermissionsExt::from_mode(0o755)).unwrap();
        let ended = run(&["grade", "R1", "--python", &python, "--", "tests"], b"");
        assert!(ended.status.code() == Some(2) && err(&ended).contains(said), "{script}: {}", err(&ended));
        assert_eq!(err(&ended).lines().count(), 1, "{}", err(&ended));
    }
    let ended = run(&["grade", "T1", "--python", "/no/such/python", "--by", "stdout", "--", "cat"], b"");
    assert_eq!(ended.status.code(), Some(0), "{}", err(&ended));
}

/// Sheets and folders as other systems write and name them.
#[test]
fn a_sheet_may_have_lines_of_windows_and_a_folder_any_name() {
    let folder = Folder::new("grade größe 1");
    let right = "read first rest; case $first in none) echo 1 2, 3;; *) echo $first $rest; cat;; esac";
    let (status, text, said) =
        grade(&folder, &format!("\u{feff}{}", SHEET.replace('\n', "\r\n")), &[], right);
    assert_eq!(status, Some(0), "{text}{said}");
}

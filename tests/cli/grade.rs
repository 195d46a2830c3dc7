//! `fbptr grade`: points, words, exit status, and programs that crash, hang or print nonsense.
//!
//! Right is: a right program has all points, one with a known fault loses the item of that fault
//! alone and is told of it, and what a program does to one item does nothing to the next.

use crate::folder::Folder;
use crate::play::{err, out, run};
use crate::tools;
use std::process::Command;

/// Each item's name is the program's last word.
const SHEET: &str = "title: Faults\nsize: 48x32\nby: stdout\narguments: {item}\ninput: exact\ntime: 20s\n\
    memory: 256M\npartly: 50%\n\
    item: line\npoints: 2\nexact:\n    CLEAR black\n    LINE 2 3 40 20 red\n\
    item: square\npoints: 4\nexact:\n    CLEAR black\n    FILL 4 4 24 4 24 24 red\n    FILL 4 4 24 24 4 24 lime\n\
    item: turn\ninput: none\nnumbers: 0 -1 0 0  1 0 0 0  0 0 1 0  0 0 0 1\n";

/// The line's end is missing, the square's diagonal goes to the other triangle, the matrix is transposed.
const WRONG: &str = "case $1 in line) cat; echo PX 40 20 000000;;\n\
    square) cat; i=4; while [ $i -lt 24 ]; do echo PX $i $i 00ff00; i=$((i+1)); done;;\n\
    turn) echo 'turn: 0 1 0 0  -1 0 0 0  0 0 1 0  0 0 0 1';; esac\n";

const RIGHT: &str = "case $1 in turn) echo 0 -1 0 0 1 0 0 0 0 0 1 0 0 0 0 1;; *) cat;; esac\n";

/// Faults that must not reach the item after them.
const ROUGH: &str = "title: Faults\nsize: 48x32\nby: stdout\narguments: {item}\ninput: exact\nmemory: 256M\ntime: 30s\n\
    exact:\n    CLEAR black\n    LINE 2 3 40 20 red\n\
    item: crash\nitem: hang\ntime: 1s\nitem: flood\nitem: nonsense\nitem: nothing\nitem: silent\nitem: right\n";

const ROUGH_PROGRAM: &str = "case $1 in crash) kill -SEGV $$;; hang) sleep 100 & wait;; flood) yes LINE 0 0 1 1 red;;\n\
    nonsense) echo CIRCLES everywhere;; nothing) echo CLEAR black;; silent) ;; *) cat;; esac\n";

fn is_served() -> bool {
    cfg!(all(target_os = "linux", target_env = "gnu")) && tools::are_there(&["sh"])
}

#[test]
fn a_right_program_has_all_points_and_a_wrong_one_is_told_why() {
    if !is_served() {
        return;
    }
    let folder = Folder::new("grade");
    let sheet = folder.file("faults.sheet", SHEET);
    let (right, wrong) = (folder.file("right.sh", RIGHT), folder.file("wrong.sh", WRONG));
    let full = run(&["grade", &sheet, "--", "sh", &right], b"");
    assert_eq!(full.status.code(), Some(0), "{}{}", out(&full), err(&full));
    assert!(out(&full).ends_with("7 of 7 points\n"), "{}", out(&full));
    let page = folder.path("result.html");
    let part = run(&["grade", &sheet, "--json", "--page", &page, "--", "sh", &wrong], b"");
    assert_eq!(part.status.code(), Some(1), "{}", err(&part));
    let value: serde_json::Value = serde_json::from_str(out(&part)).unwrap();
    let items = value["items"].as_array().unwrap();
    let classes: Vec<_> = items.iter().map(|item| &item["difference"]["findings"][0]["class"]).collect();
    assert_eq!((classes[0].as_str(), classes[1].as_str()), (Some("missing-at-end"), Some("edge")));
    assert_eq!(items[1]["difference"]["wrong"], 20);
    // One of 39 pixels, and 20 of 400, rounded down to tenths of a point.
    assert_eq!((items[0]["points"].as_f64(), items[1]["points"].as_f64()), (Some(1.9), Some(3.8)));
    assert_eq!(items[2]["points"].as_f64(), Some(0.0));
    assert!(items[2]["text"].as_str().unwrap().contains("transposed"), "{}", items[2]["text"]);
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("data:image/png;base64") && page.contains("transposed"), "{}", page.len());
    assert!(!page.contains("http"), "the page needs nothing else");
}

#[test]
fn a_program_that_crashes_hangs_or_floods_loses_its_item_alone() {
    if !is_served() {
        return;
    }
    let folder = Folder::new("grade-rough");
    let (sheet, program) = (folder.file("rough.sheet", ROUGH), folder.file("rough.sh", ROUGH_PROGRAM));
    let rough = run(&["grade", &sheet, "--", "sh", &program], b"");
    let text = out(&rough);
    assert_eq!(rough.status.code(), Some(1), "{text}{}", err(&rough));
    assert!(text.ends_with("1 of 7 points\n"), "{text}");
    for (item, words) in [
        ("crash", "SIGSEGV"),
        ("hang", "did not end within 1s"),
        ("flood", "printed more than"),
        ("nonsense", "no stream of commands"),
        ("nothing", "nothing is drawn"),
        ("silent", "printed nothing"),
        ("right", "right"),
    ] {
        let line = text.lines().find(|line| line.contains(&format!(" {item}: "))).unwrap_or_default();
        assert!(line.contains(words), "{item}: {text}");
    }
}

#[test]
fn a_program_of_the_framebuffer_is_graded_by_its_memory() {
    if !is_served() || !tools::are_there(&["cc"]) {
        return;
    }
    let folder = Folder::new("grade-fb0");
    let source = folder.file(
        "main.c",
        "#include <fcntl.h>\n#include <string.h>\n#include <unistd.h>\n\
         int main(int argc, char **argv) { unsigned char row[64]; int y, fb = open(\"/dev/fb0\", O_RDWR);\n\
         memset(row, 255, 64); for (y = 0; y < (strcmp(argv[argc - 1], \"half\") ? 12 : 6); y++) write(fb, row, 64);\n\
         if (!strcmp(argv[argc - 1], \"stays\")) pause(); return 0; }\n",
    );
    let program = folder.path("main");
    assert!(Command::new("cc").args(["-w", "-o", &program, &source]).status().unwrap().success());
    let sheet = folder.file(
        "fb0.sheet",
        "title: White\nsize: 16x12\nby: run\narguments: {item}\ntime: 30s\nexact:\n    \
         FILLRECT 0 0 16 12 ffffff\nitem: ends\nitem: stays\n\
         item: half\npoints: 4\nitem: upper\nregion: 0 0 16 6\n",
    );
    let graded = run(&["grade", &sheet, "--", &program], b"");
    let text = out(&graded);
    assert_eq!(graded.status.code(), Some(1), "{text}{}", err(&graded));
    assert!(text.contains("1 of 1     ends") && text.contains("1 of 1     stays"), "{text}");
    assert!(text.contains("1 of 1     upper"), "{text}");
    assert!(text.contains("0 of 4     half: 96 pixels of 192 are wrong"), "{text}");
    let one = run(&["grade", &sheet, "--item", "stays", "--", &program], b"");
    assert_eq!((one.status.code(), out(&one).lines().last()), (Some(0), Some("1 of 1 points")));
}

#[test]
fn what_is_wrong_in_a_sheet_or_in_its_use_has_status_2() {
    let folder = Folder::new("grade-bad");
    let sheet = folder.file("bad.sheet", "title: T\nsise: 3x3\n");
    let none = folder.file("none.sheet", "title: T\nitem: a\nexact: none.png\n");
    for (words, message) in [
        (vec!["grade", &sheet, "--", "true"], "bad.sheet:2"),
        (vec!["grade", &none, "--", "true"], "none.sheet:2"),
        (vec!["grade", "T9", "--", "true"], "T9"),
        (vec!["grade", "T1"], "program"),
        (vec!["grade", "T1", "--", "./no-such-program"], "no-such-program"),
        (vec!["grade", "T1", "--item", "x", "--", "true"], "octants"),
        (vec!["grade", "R1", "--", "true"], "gl.py"),
    ] {
        let bad = run(&words, b"");
        assert_eq!(bad.status.code(), Some(2), "{words:?}: {}", err(&bad));
        let is_told = err(&bad).contains(message) || cfg!(not(all(target_os = "linux", target_env = "gnu")));
        assert!(is_told, "{words:?}: {}", err(&bad));
    }
}

#[test]
fn a_picture_that_is_never_still_is_taken_at_its_limit() {
    if !is_served() {
        return;
    }
    let script = "while :; do head -c 64 /dev/urandom > /dev/fb0; done";
    let words = ["run", "--headless", "--size", "16x12", "--after", "still", "--limit", "1s", "--", "sh", "-c", script];
    let random = run(&words, b"");
    assert_eq!(random.status.code(), Some(124), "{}", err(&random));
    assert!(err(&random).contains("limit"), "{}", err(&random));
}

#[test]
fn sheets_that_come_with_the_program_are_shown() {
    if !is_served() {
        return;
    }
    let list = run(&["grade", "--list"], b"");
    for name in ["T1", "T1b", "T2", "R1", "R2", "R3", "R4", "R5", "R6", "R7", "R8", "R9"] {
        assert!(out(&list).lines().any(|line| line.split_whitespace().next() == Some(name)), "{}", out(&list));
        let shown = run(&["grade", name, "--show"], b"");
        assert!(shown.status.success() && out(&shown).contains("item: "), "{name}: {}", err(&shown));
    }
}

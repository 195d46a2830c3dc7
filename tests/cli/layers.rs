//! Imports go down the layers only: a module uses what lies below it or beside it, never what lies
//! above. Also checked: the tests are few programs, because each is linked with the whole crate.

use std::fs;
use std::path::{Path, PathBuf};

const LAYERS: [&[&str]; 8] = [
    &["math", "simd", "error", "cancel"],
    &["memory", "scene"],
    &["draw2d", "pipeline", "eye", "truth"],
    &["command", "load", "save"],
    &["server"],
    &["viewer", "measure"],
    &["window"],
    &["cli"],
];

fn layer(room: &str) -> Option<usize> {
    LAYERS.iter().position(|rooms| rooms.contains(&room))
}

fn sources(dir: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(dir).expect("src is readable").map(|e| e.expect("entry").path()) {
        match entry.is_dir() {
            true => sources(&entry, found),
            false if entry.extension().is_some_and(|e| e == "rs") => found.push(entry),
            false => {}
        }
    }
}

/// Returns every module that a source text names as `crate::module`, including grouped imports.
fn rooms_used(text: &str) -> Vec<String> {
    let mut rooms = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        let rest = &text[at + "crate::".len()..];
        let names = match rest.strip_prefix('{') {
            Some(group) => group.split('}').next().unwrap_or("").split(',').collect(),
            None => vec![rest],
        };
        for name in names {
            rooms.push(name.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect());
        }
    }
    rooms
}

#[test]
fn imports_go_down_the_layers_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let mut seen = 0;
    let mut upward = Vec::new();
    for file in &files {
        let inside = file.strip_prefix(&root).expect("under src");
        let room = inside.iter().next().expect("a component").to_string_lossy().replace(".rs", "");
        let Some(own) = layer(&room) else { continue };
        let code = fs::read_to_string(file).expect("readable");
        let code: String =
            code.lines().filter(|l| !l.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
        for used in rooms_used(&code) {
            let Some(theirs) = layer(&used) else { continue };
            seen += 1;
            if theirs > own {
                upward
                    .push(format!("{}: {room} (layer {own}) uses {used} (layer {theirs})", inside.display()));
            }
        }
    }
    assert!(seen > 3, "the test found only {seen} imports: it no longer reads them");
    assert!(upward.is_empty(), "upward imports:\n{}", upward.join("\n"));
}

#[test]
fn the_reader_of_imports_sees_groups() {
    assert_eq!(rooms_used("use crate::{math, memory::X};\nuse crate::eye::Y;"), ["math", "memory", "eye"]);
}

#[test]
fn the_integration_tests_are_at_most_eight_programs() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let entries = fs::read_dir(&tests).expect("tests is readable").map(|e| e.expect("entry").path());
    // Files and folders that Cargo takes for test programs.
    let programs: Vec<PathBuf> =
        entries.filter(|p| p.extension().is_some_and(|e| e == "rs") || p.join("main.rs").is_file()).collect();
    assert!(programs.len() > 3, "the test found only {programs:?}: it no longer sees them");
    assert!(programs.len() <= 8, "a new test is a module of one of the others: {programs:#?}");
}

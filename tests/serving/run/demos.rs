//! The programs of `demos/fb`, some frames of each.

use super::{picture_of, text};
use crate::folder::Folder;
use crate::tools;
use fbptr::memory::VideoMemory;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Returns the demos with this ending, but not what they share.
fn demos(ending: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("demos/fb");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_demo = |path: &PathBuf| {
        path.extension().is_some_and(|e| e == ending) && path.file_stem().is_some_and(|name| name != "fb")
    };
    entries.filter(is_demo).collect()
}

/// Checks that a demo ends well and that its picture has several colours.
fn check(folder: &Folder, program: &[&str]) {
    let (output, picture) = picture_of(folder, &["--size", "64x48", "--hz", "200"], program);
    assert_eq!(output.status.code(), Some(0), "{program:?}: {}", text(&output.stderr));
    let colors: HashSet<[u8; 4]> = picture.bytes().as_chunks::<4>().0.iter().copied().collect();
    assert!(colors.len() > 1, "{program:?} shows one colour");
    let dark = picture.bytes().as_chunks::<4>().0.iter().filter(|p| **p == VideoMemory::CLEAR).count();
    assert!(dark < 64 * 48, "{program:?} shows nothing");
}

#[test]
fn every_demo_in_c_draws() {
    if !tools::are_there(&["cc"]) {
        return;
    }
    let folder = Folder::new("run-demos-c");
    let sources = demos("c");
    assert_eq!(sources.len(), 5);
    for source in sources {
        let program = folder.join("demo");
        let compiled = Command::new("cc").arg("-o").args([&program, &source]).arg("-lm").output().unwrap();
        assert!(compiled.status.success(), "{}: {compiled:?}", source.display());
        check(&folder, &[program.to_str().unwrap(), "6"]);
    }
}

#[test]
fn every_demo_in_python_draws() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    let folder = Folder::new("run-demos-python");
    let sources = demos("py");
    assert_eq!(sources.len(), 6);
    for source in sources {
        check(&folder, &["python3", source.to_str().unwrap(), "12"]);
    }
}

//! `fbptr run`: programs that know nothing of fbptr, on the emulated framebuffer device.

mod console;
mod demos;
mod device;
mod endings;
mod glut;
mod input;
mod packages;
mod places;

use crate::folder::Folder;
use crate::tools;
use fbptr::memory::VideoMemory;
use fbptr::save::golden::read_png;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Returns `fbptr run --headless` with options.
fn run(options: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbptr"));
    command.args(["run", "--headless"]).args(options);
    command.stdin(Stdio::null()).env_remove("BLESS").env_remove("LD_PRELOAD");
    command
}

/// Runs a program with options and returns what it has written, its status, and the picture.
fn picture_of(folder: &Folder, options: &[&str], program: &[&str]) -> (Output, VideoMemory) {
    let snap = folder.join("snap.png");
    let mut command = run(options);
    command.arg("--snap").arg(&snap).arg("--").args(program);
    let output = command.output().unwrap();
    let picture = read_png(&snap).unwrap_or_else(|e| panic!("{e}: {output:?}"));
    (output, picture)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Compiles a C program of `tests/serving/run`, or returns `None` where there is no compiler.
fn compiled(folder: &Folder, name: &str, options: &[&str]) -> Option<PathBuf> {
    if !tools::are_there(&["cc"]) {
        return None;
    }
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/serving/run").join(name);
    let program = folder.join(&name.replace(".c", ""));
    let output = Command::new("cc").args(options).arg("-o").arg(&program).arg(source).output().unwrap();
    if !output.status.success() {
        tools::skip(&format!("{name} does not compile here: {}", text(&output.stderr)));
        return None;
    }
    Some(program)
}

//! Ends of a run: exit statuses, `--expect`, `--after`, programs that cannot be served, kills.

use super::{compiled, run, text};
use crate::folder::Folder;
use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::time::{Duration, Instant};

fn status(options: &[&str], script: &str) -> Option<i32> {
    run(options).args(["--size", "16x8", "--", "sh", "-c", script]).output().unwrap().status.code()
}

#[test]
fn the_status_is_the_programs_own() {
    assert_eq!(status(&[], "exit 0"), Some(0));
    assert_eq!(status(&[], "exit 42"), Some(42));
    assert_eq!(status(&[], "kill -9 $$"), Some(137));
    assert_eq!(status(&[], "kill -SEGV $$"), Some(139));
}

#[test]
fn programs_that_cannot_be_served_are_told_so() {
    let folder = Folder::new("run-refused");
    let said = |program: &str| {
        let output = run(&["--", program]).output().unwrap();
        (output.status.code(), text(&output.stderr))
    };
    let (code, message) = said("no-such-program-anywhere");
    assert!(code == Some(127) && message.contains("no such program"), "{message}");
    let (code, message) = said("/etc/passwd");
    assert!(code == Some(126) && message.contains("not an executable"), "{message}");
    let Some(program) = compiled(&folder, "tutorial.c", &["-static"]) else { return };
    let (code, message) = said(program.to_str().unwrap());
    assert!(code == Some(126) && message.contains("statically linked"), "{message}");
    for arguments in [
        &["--format", "cmyk"][..],
        &["--after", "soon"],
        &["--snap", "x.doc"],
        &["--serve", "0.0.0.0:0"],
        &["--keys", "/nowhere"],
        &["--tolerance", "300", "--expect", "x.png"],
    ] {
        let output = run(arguments).args(["--", "true"]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {output:?}");
    }
}

#[test]
fn a_picture_is_compared_and_the_difference_left_beside_it() {
    let folder = Folder::new("run-expect");
    let golden = folder.join("golden.png");
    let golden = golden.to_str().unwrap();
    let draw = |value: u8| format!("printf '\\{value:03o}' > /dev/fb0; exit 5");
    assert_eq!(status(&["--snap", golden], &draw(9)), Some(5));
    assert_eq!(status(&["--expect", golden], &draw(9)), Some(0), "equal, whatever the program's status");
    assert_eq!(status(&["--expect", golden], &draw(12)), Some(1));
    assert!(folder.join("golden.actual.png").exists() && folder.join("golden.diff.png").exists());
    assert_eq!(status(&["--expect", golden, "--tolerance", "3"], &draw(12)), Some(0));
    assert!(!folder.join("golden.actual.png").exists(), "a leftover of the earlier run");
    assert_eq!(status(&["--expect", golden, "--tolerance", "2"], &draw(12)), Some(1));
    assert_eq!(status(&["--expect", golden, "--tolerance", "2,1"], &draw(12)), Some(0));
    let missing = folder.join("missing.png");
    assert_eq!(status(&["--expect", missing.to_str().unwrap()], &draw(1)), Some(1));
}

#[test]
fn files_have_the_look_of_a_tube_only_if_asked() {
    let folder = Folder::new("run-crt");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let script = "printf '\\377\\200\\100' > /dev/fb0";
    let picture = |name: &str, options: &[&str]| {
        let path = path(name);
        assert_eq!(status(&[options, &["--snap", &path]].concat(), script), Some(0));
        fbptr::save::golden::read_png(path.as_ref()).unwrap()
    };
    let (plain, window) = (picture("plain.png", &[]), picture("window.png", &["--crt"]));
    assert!(plain.bytes() == window.bytes() && plain.get_pixel(0, 0).unwrap() == [64, 128, 255, 255]);
    let movie = path("movie.png");
    let tube = picture("tube.png", &["--crt=files", "--movie", &movie, "--movie-fps", "100"]);
    assert_eq!((tube.width(), tube.height()), (48, 24));
    let center = tube.get_pixel(1, 1).unwrap();
    assert!(center[2] > 180 && center[0] < 80 && center != [64, 128, 255, 255], "{center:?}");
    let frames: Vec<_> = std::fs::read_dir(folder.join("")).unwrap().map(|e| e.unwrap().path()).collect();
    let last = frames.iter().filter(|p| p.to_string_lossy().contains("movie-")).max().expect("a frame");
    assert_eq!(fbptr::save::golden::read_png(last).unwrap().bytes(), tube.bytes());
    // Comparisons are of the frame itself.
    assert_eq!(status(&["--crt=files", "--expect", &path("plain.png")], script), Some(0));
    assert_eq!(status(&["--crt=tube"], script), Some(2));
}

#[test]
fn a_program_that_does_not_end_is_ended_at_its_moment() {
    let folder = Folder::new("run-after");
    let golden = folder.join("golden.png");
    let golden = golden.to_str().unwrap();
    let endless = "printf '\\007' > /dev/fb0; while :; do sleep 1; done";
    assert_eq!(status(&["--after", "still:50ms", "--snap", golden], endless), Some(0));
    for after in ["1", "still", "1500ms"] {
        assert_eq!(status(&["--after", after, "--expect", golden], endless), Some(0), "{after}");
    }
    // One that ignores SIGTERM.
    let deaf = format!("trap '' TERM; {endless}");
    assert_eq!(status(&["--after", "still", "--expect", golden], &deaf), Some(0));
}

#[test]
fn nothing_is_left_when_either_side_is_killed() {
    let script = "echo $$; printf '\\007' > /dev/fb0; exec sleep 1000";
    let mut child =
        run(&["--size", "16x8", "--", "sh", "-c", script]).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let pid: u32 = line.trim().parse().unwrap();
    let is_alive = |pid: u32| {
        let state = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        !state.is_empty() && !state.contains(") Z ")
    };
    assert!(is_alive(pid));
    child.kill().unwrap();
    child.wait().unwrap();
    let started = Instant::now();
    while is_alive(pid) {
        assert!(started.elapsed() < Duration::from_secs(60), "the program outlives fbptr");
        std::thread::sleep(Duration::from_millis(20));
    }
    let sockets = std::fs::read_to_string("/proc/net/unix").unwrap_or_default();
    assert!(!sockets.contains(&format!("@fbptr-run-{}-", child.id())), "{sockets}");
}

#[test]
fn a_program_that_writes_beyond_its_map_harms_itself_only() {
    let folder = Folder::new("run-beyond");
    let Some(program) = compiled(&folder, "beyond.c", &[]) else { return };
    let snap = folder.join("snap.png");
    let mut command = run(&["--size", "16x8", "--snap", snap.to_str().unwrap(), "--"]);
    let output = command.arg(program).output().unwrap();
    assert_eq!(output.status.code(), Some(128 + 11), "{output:?}");
    let picture = fbptr::save::golden::read_png(&snap).unwrap();
    assert_eq!(picture.get_pixel(0, 0).unwrap(), [77, 77, 77, 255]);
}

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

/// Returns whether a process has not ended.
fn is_alive(pid: u32) -> bool {
    let state = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    !state.is_empty() && !state.contains(") Z ")
}

/// Waits for the end of a process.
fn assert_ended(pid: u32) {
    let started = Instant::now();
    while is_alive(pid) {
        assert!(started.elapsed() < Duration::from_secs(60), "the program outlives fbptr");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Returns the numbers of processes that a program has printed.
fn pids(output: &[u8]) -> Vec<u32> {
    text(output).split_whitespace().map(|word| word.parse().unwrap()).collect()
}

/// Leaves its group or its session as it is told, twice over with a parent that ends, and draws on.
const LEAVING: &str = "
import os, signal, sys, time
way = sys.argv[1]
if 'deaf' in way:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
for _ in range(2 if 'orphan' in way else 0):
    if os.fork():
        time.sleep(0.1)
        os._exit(0)
os.setpgid(0, 0) if 'group' in way else os.setsid()
print(os.getpid(), flush=True)
f = open('/dev/fb0', 'r+b', buffering=0)
f.write(b'\\7')
while True:
    time.sleep(1)
";

#[test]
fn what_leaves_its_group_or_session_is_ended_with_the_run() {
    if !crate::tools::are_there(&["python3"]) {
        return;
    }
    for way in ["session", "group", "orphan session", "orphan group", "deaf orphan session"] {
        let program = ["python3", "-c", LEAVING, way];
        let output = run(&["--size", "16x8", "--after", "still:100ms", "--"]).args(program).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{way}: {output:?}");
        let [pid] = pids(&output.stdout)[..] else { panic!("{way}: {output:?}") };
        assert!(!is_alive(pid), "{way}: it outlives the run");
    }
    let program = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/serving/run/setsid_only.py");
    let script = format!("echo $$; exec python3 {}", program.display());
    let mut command = run(&["--after", "1s", "--", "sh", "-c", &script]);
    let output = command.output().unwrap();
    let [pid] = pids(&output.stdout)[..] else { panic!("{output:?}") };
    assert!(output.status.code() == Some(0) && !is_alive(pid), "{output:?}");
}

#[test]
fn what_leaves_its_session_is_ended_when_fbptr_or_its_starter_is_killed() {
    if !crate::tools::are_there(&["python3"]) {
        return;
    }
    for is_starter in [false, true] {
        let mut command = run(&["--size", "16x8", "--", "python3", "-c", LEAVING, "orphan session"]);
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let pid: u32 = line.trim().parse().unwrap();
        assert!(is_alive(pid));
        if is_starter {
            let threads = std::fs::read_dir(format!("/proc/{}/task", child.id())).unwrap();
            let children = threads.map(|thread| thread.unwrap().path().join("children"));
            let starter: String = children.map(|path| std::fs::read_to_string(path).unwrap()).collect();
            let killed = std::process::Command::new("kill").args(["-9", starter.trim()]).status().unwrap();
            assert!(killed.success());
            assert_eq!(child.wait().unwrap().code(), Some(137));
        } else {
            child.kill().unwrap();
            child.wait().unwrap();
        }
        assert_ended(pid);
    }
}

#[test]
fn children_that_draw_are_waited_for_and_others_ended() {
    let folder = Folder::new("run-children");
    let draws = "(sleep 1; printf '\\011') > /dev/fb0 & exit 4";
    let (output, picture) = super::picture_of(&folder, &["--size", "16x8"], &["sh", "-c", draws]);
    assert_eq!(output.status.code(), Some(4), "the program's own status");
    assert_eq!(picture.get_pixel(0, 0).unwrap(), [0, 0, 9, 255], "the child has drawn");
    if !crate::tools::are_there(&["setsid"]) {
        return;
    }
    let daemon = "setsid sleep 1000 > /dev/null 2>&1 & echo $!; sleep 0.2; exit 5";
    for leaves in [false, true] {
        let options: &[&str] = if leaves { &["--leave-daemons"] } else { &[] };
        let output = run(options).args(["--", "sh", "-c", daemon]).output().unwrap();
        let [pid] = pids(&output.stdout)[..] else { panic!("{output:?}") };
        assert_eq!((output.status.code(), is_alive(pid)), (Some(5), leaves), "{output:?}");
        if leaves {
            assert!(std::process::Command::new("kill").arg(pid.to_string()).status().unwrap().success());
        }
    }
}

#[test]
fn nothing_is_left_when_either_side_is_killed() {
    let script = "echo $$; printf '\\007' > /dev/fb0; exec sleep 1000";
    let mut child =
        run(&["--size", "16x8", "--", "sh", "-c", script]).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let pid: u32 = line.trim().parse().unwrap();
    assert!(is_alive(pid));
    child.kill().unwrap();
    child.wait().unwrap();
    assert_ended(pid);
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

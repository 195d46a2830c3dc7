//! Files that a server reads, writes and shares, while others truncate them, block them or fill
//! their disk.

#![cfg(unix)]

use crate::folder::Folder;
use crate::process::{Process, fbptr, play, text};
use crate::support::{Serving, Wire};
use crate::tools;
use fbptr::load::SandboxDir;
use fbptr::server::{Engine, Limits};
use std::os::unix::fs::FileExt;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Waits until the reply to `STATS` contains `word`.
fn wait_for_stats(wire: &mut Wire, word: &str) {
    let until = Instant::now() + Duration::from_secs(30);
    loop {
        let stats = wire.ask("STATS\n");
        if stats.contains(word) {
            return;
        }
        assert!(Instant::now() < until, "{word} does not come: {stats}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_second_server_leaves_the_first_ones_recording_alone() {
    let folder = Folder::new("record-twice");
    let (recording, end, replay) = (folder.join("r"), folder.join("end.raw"), folder.join("replay.raw"));
    let arguments = ["--listen", ":0", "--size", "20x10", "--record", text(&recording), "--snap", text(&end)];
    let mut first = Process::start(&arguments);
    let address = first.address();
    let mut wire = Wire::connect(address);
    assert_eq!(wire.ask("PX 3 3 ff8000\nSYNC a\n"), "SYNC a\n");
    wait_for_stats(&mut wire, " record_queue=0 ");
    for listen in [address.to_string(), ":0".to_owned()] {
        let mut second = fbptr();
        second.args(["serve", "--headless", "--listen", &listen, "--record", text(&recording)]);
        let out = second.output().unwrap();
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(2), "{said}");
        let why = if listen == ":0" { "another process records into it" } else { "cannot listen" };
        assert!(said.contains(why) && said.lines().count() == 1, "{said}");
    }
    assert_eq!(wire.ask("PX 4 4 00ff00\nSYNC b\n"), "SYNC b\n");
    assert_eq!(first.ends_after("TERM"), Some(0));
    assert_eq!(play(&recording, &replay).status.code(), Some(0));
    let replayed = std::fs::read(&replay).unwrap();
    assert_eq!(replayed[(20 * 3 + 3) * 4..][..4], [255, 128, 0, 255]);
    assert!(replayed == std::fs::read(&end).unwrap());
}

#[test]
fn a_recording_that_cannot_be_written_is_said_at_once_and_in_the_status() {
    if !std::path::Path::new("/dev/full").exists() {
        return tools::skip("there is no /dev/full");
    }
    let mut process = Process::start(&["--listen", ":0", "--size", "20x10", "--record", "/dev/full"]);
    let lines = [process.says(), process.says()];
    let listening = lines.iter().find_map(|l| l.strip_prefix("fbptr: listening on tcp ")).unwrap();
    assert!(lines.iter().any(|l| l.starts_with("fbptr: /dev/full: the recording ends early: ")), "{lines:?}");
    let mut wire = Wire::connect(listening.parse().unwrap());
    wait_for_stats(&mut wire, " record=failed ");
    assert_eq!(wire.ask("PX 3 3 ff8000\nPX 3 3\n"), "PX 3 3 ff8000\n", "clients go on");
    assert_eq!(process.ends_after("TERM"), Some(1));
}

#[test]
fn a_pipe_that_nobody_drains_holds_no_client_up() {
    let folder = Folder::new("record-pipe");
    let pipe = folder.join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let refused =
        fbptr().args(["serve", "--headless", "--listen", ":0", "--record", text(&pipe)]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("a pipe that nobody reads"));
    // A process that opens the pipe and reads nothing.
    let mut reader = Command::new("sh").args(["-c", "exec sleep 100 < $0", text(&pipe)]).spawn().unwrap();
    let mut process = Process::start(&["--listen", ":0", "--size", "200x100", "--record", text(&pipe)]);
    let mut wire = Wire::connect(process.address());
    let mut flood = b"BLIT 0 0 200 100 :80000\n".to_vec();
    flood.extend([7; 80_000]);
    let begun = Instant::now();
    for _ in 0..600 {
        wire.send(&flood);
    }
    assert_eq!(wire.ask("SYNC a\n"), "SYNC a\n");
    assert!(begun.elapsed() < Duration::from_secs(20), "clients waited {:?}", begun.elapsed());
    let said = process.says();
    assert!(said.contains("the recording ends early: ") && said.contains("no room was made"), "{said}");
    wait_for_stats(&mut wire, " record=failed ");
    assert_eq!(process.ends_after("TERM"), Some(1));
    reader.kill().unwrap();
    reader.wait().unwrap();
}

#[test]
fn a_loaded_file_that_becomes_a_pipe_holds_no_client_up() {
    let folder = Folder::new("load-pipe");
    std::fs::write(folder.join("kept.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(folder.join("side.obj"), "mtllib a.obj\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let pipe = folder.join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut engine = Engine::new(8, 8).unwrap();
    engine.set_load_dir(SandboxDir::open(&folder.0).unwrap());
    let serving = Serving::with(engine);
    let [kept, a] = ["kept.obj", "a.obj"].map(|name| folder.join(name));
    let is_over = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_over.load(std::sync::atomic::Ordering::Relaxed) {
                let _ = std::fs::rename(&kept, &a).and_then(|()| std::fs::rename(&a, &kept));
                let _ = std::fs::rename(&pipe, &a).and_then(|()| std::fs::rename(&a, &pipe));
            }
        });
        let mut wire = serving.connect();
        wire.send(b"ERRORS count\n");
        let end = (0..40).try_for_each(|_| {
            wire.send("LOAD MESH m a.obj\nLOAD MESH m side.obj\n".repeat(100).as_bytes());
            wire.try_ask("SYNC a\n").filter(|reply| reply == "SYNC a\n").map(drop)
        });
        is_over.store(true, std::sync::atomic::Ordering::Relaxed);
        assert_eq!(end, Some(()), "the server waits for a pipe");
    });
}

#[test]
fn snapshots_have_a_quota() {
    let folder = Folder::new("snap-quota");
    std::fs::write(folder.join("theirs.png"), [0; 30_000]).unwrap();
    let limits = Limits { snap_bytes: 20_000, ..Limits::default() };
    let mut engine = Engine::with_limits(40, 40, limits).unwrap();
    engine.set_snap_dir(SandboxDir::open(&folder.0).unwrap());
    let serving = Serving::with(engine);
    let mut wire = serving.connect();
    assert!(wire.ask("SNAP a.raw\n").starts_with("SNAP a.raw 40 40 "));
    assert!(wire.ask("SNAP b.raw\n").starts_with("SNAP b.raw 40 40 "));
    assert!(wire.ask("STATS\n").contains(" snap_bytes=16384 "));
    for name in ["c.raw", "c.ppm"] {
        let told = wire.ask(&format!("SNAP {name}\n"));
        assert!(told.contains(" EQUOTA SNAP: ") && told.contains("16384 of 20000 bytes"), "{told}");
        assert!(!folder.join(name).exists());
    }
    assert!(wire.ask("SNAP a.raw\n").starts_with("SNAP a.raw 40 40 "), "a file makes room for its successor");
    std::fs::remove_file(folder.join("b.raw")).unwrap();
    assert!(wire.ask("SNAP c.ppm\n").starts_with("SNAP c.ppm 40 40 "), "a file that is gone makes room");
}

#[test]
fn a_full_disk_is_a_quota_in_every_format_and_no_place_for_a_shared_file() {
    if !tools::are_there(&["unshare", "mount"]) {
        return;
    }
    let folder = Folder::new("small-disk");
    // A disk of 64 KiB, visible to these processes alone, and noise that no format compresses.
    let script = r#"
        mount -t tmpfs -o size=64k small "$1" || exit 77
        "$0" serve --headless --listen :0 --size 640x480 --shm "$1/fb" && exit 1
        test -e "$1/fb" && exit 2
        exec "$0" serve --headless --stdin --size 200x200 --snap-dir "$1"
    "#;
    let mut child = Command::new("unshare")
        .args(["--map-root-user", "--mount", "sh", "-c", script])
        .args([env!("CARGO_BIN_EXE_fbptr"), text(&folder.0)])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut noise = crate::support::Numbers(9);
    let mut request = b"BLIT 0 0 200 200 :160000\n".to_vec();
    request.extend((0..160_000).map(|_| noise.below(256) as u8));
    request.extend(b"SNAP a.png\nSNAP a.ppm\nSNAP a.raw\nCLEAR\nSNAP b.png\n");
    let mut stdin = child.stdin.take().unwrap();
    // If the disk cannot be mounted, nothing reads this.
    let _ = std::io::Write::write_all(&mut stdin, &request);
    drop(stdin);
    let out = child.wait_with_output().unwrap();
    let (replies, said) = (String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr));
    if out.status.code() == Some(77) || said.contains("unshare") {
        return tools::skip("no disk can be made here");
    }
    assert_eq!(out.status.code(), Some(0), "{said}{replies}");
    assert!(said.contains("/fb: no room for the file's 1232896 bytes"), "{said}");
    let codes: Vec<&str> = replies.lines().take(3).filter_map(|l| l.split(' ').nth(3)).collect();
    assert_eq!(codes, ["EQUOTA"; 3], "{replies}");
    assert!(replies.lines().nth(3).is_some_and(|l| l.starts_with("SNAP b.png 200 200 ")), "{replies}");
}

#[test]
fn a_shared_file_that_others_truncate_ends_the_sharing_and_nothing_else() {
    let folder = Folder::new("shm-cut");
    for round in 0..12 {
        let shm = folder.join("fb");
        let _ = std::fs::remove_file(&shm);
        let mut process = Process::start(&["--listen", ":0", "--size", "300x200", "--shm", text(&shm)]);
        let address = process.address();
        let mut wire = Wire::connect(address);
        assert!(wire.ask("STATS\n").contains(" shm=ok "));
        let drawing = std::thread::spawn(move || {
            let mut wire = Wire::connect(address);
            for i in 0..400 {
                wire.send(format!("FILLRECT 0 0 300 200 {i:06x}\nPX {} 1 ffffff\n", i % 300).as_bytes());
                assert_eq!(wire.ask("SYNC a\n"), "SYNC a\n");
            }
            wire.ask("PX 0 0\n")
        });
        let file = std::fs::OpenOptions::new().write(true).open(&shm).unwrap();
        std::thread::sleep(Duration::from_millis(round * 3));
        // Truncated, restored and truncated again, as fast as possible.
        for i in 0..round * 20 + 1 {
            file.set_len(i * 997 % 200_000).unwrap();
            let _ = file.write_all_at(b"x", 239_000);
        }
        file.set_len(0).unwrap();
        let said = process.says();
        assert!(said.contains(": another program truncated it from 244096 to "), "round {round}: {said}");
        assert!(said.ends_with(" bytes: no longer shared"), "round {round}: {said}");
        assert_eq!(drawing.join().unwrap(), "PX 0 0 00018f\n", "round {round}");
        assert!(wire.ask("STATS\n").contains(" shm=failed "));
        assert_eq!(process.ends_after("TERM"), Some(1), "round {round}");
    }
}

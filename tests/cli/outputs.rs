//! Tests of what becomes of outputs on the command line: closed pipes, missing folders, options that
//! would do nothing, and numbers of bytes.

use crate::folder::Folder;
use crate::play::{err, out, run};
use std::io::{Read, Write};
use std::net::TcpListener;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Runs a program whose input goes on for as long as it reads, and whose reader leaves after the
/// first line; returns whether it ended by itself.
fn ends_when_its_reader_has_gone(arguments: &[&str]) -> bool {
    let mut child = Command::new(env!("CARGO_BIN_EXE_fbptr"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut answers = child.stdout.take().unwrap();
    let writer = std::thread::spawn(move || while input.write_all(b"CRC\n").is_ok() {});
    answers.read_exact(&mut [0; 9]).unwrap();
    drop(answers);
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            child.wait().unwrap();
            writer.join().unwrap();
            return false;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    writer.join().unwrap();
    true
}

#[test]
#[cfg(unix)]
fn a_closed_pipe_ends_a_program_that_only_answers() {
    for arguments in
        [&["play", "-", "--headless", "--size", "8x8"][..], &["draw", "--headless", "--size", "8x8"]]
    {
        assert!(ends_when_its_reader_has_gone(arguments), "{arguments:?}");
    }
}

#[test]
fn outputs_into_missing_folders_are_refused_before_anything_is_drawn() {
    let folder = Folder::new("outputs");
    let (stream, model) =
        (folder.file("s", "CRC\n"), folder.file("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    let (picture, depth) = (folder.path("no/a.png"), folder.path("no/a.pfm"));
    for arguments in [
        &["play", &stream, "--headless", "--snap", &picture][..],
        &["play", &stream, "--headless", "--depth-out", &depth],
        &["draw", "--headless", "--snap", &picture],
        &["view", &model, "--headless", "--snap", &picture],
        &["view", &model, "--headless", "--save-dir", &folder.path("no")],
        &["serve", "--headless", "--listen", "127.0.0.1:0", "--snap", &picture],
        &["snap", "127.0.0.1:1", &picture],
    ] {
        let refused = run(arguments, b"CRC\n");
        assert_eq!((refused.status.code(), out(&refused)), (Some(2), ""), "{arguments:?}");
        assert!(
            err(&refused).starts_with("fbptr: ") && err(&refused).contains("there is no"),
            "{}",
            err(&refused)
        );
    }
}

#[test]
fn options_that_do_nothing_for_n_dimensions_are_refused() {
    let folder = Folder::new("nd-options");
    let scene = folder.file("t.json", &run(&["eye", "--make", "tesseract", "--pixels", "8x6"], b"").stdout);
    let picture = folder.path("a.png");
    for arguments in [
        &["eye", &scene, "--pixels", "3x3"][..],
        &["eye", &scene, "--aperture", "0.2"],
        &["eye", &scene, "--dim", "5"],
        &["eye", &scene, "--mesh", "a.obj"],
        &["eye", "--make", "cube", "--mesh", "a.obj"],
        &["eye", "--make", "simplex", "--half", "3"],
        &["render", &scene, "-o", &picture, "--max-error", "4"],
        &["view", &scene, "--headless", "--snap", &picture, "--cull", "back"],
        &["view", &scene, "--headless", "--snap", &picture, "--split", "depth"],
    ] {
        let refused = run(arguments, b"");
        assert_eq!((refused.status.code(), out(&refused)), (Some(2), ""), "{arguments:?}: {}", err(&refused));
        assert!(!std::path::Path::new(&picture).exists());
    }
    assert!(run(&["eye", &scene], b"").status.success());
}

#[test]
fn a_pixel_outside_the_frame_is_not_traced() {
    let folder = Folder::new("trace-outside");
    let model = folder.file("m.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    for (pixel, status) in [("8,5", 1), ("-1,0", 1), ("0,6", 1), ("4,3", 0)] {
        let traced = run(&["render", &model, "--size", "8x6", &format!("--trace={pixel}")], b"");
        assert_eq!(traced.status.code(), Some(status), "{pixel}: {}", err(&traced));
        assert_eq!(err(&traced).contains("is outside the frame of 8 x 6"), status == 1, "{}", err(&traced));
    }
}

#[test]
fn what_is_no_server_is_told() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let other = std::thread::spawn(move || {
        let (mut client, _) = listener.accept().unwrap();
        client.write_all(b"HTTP/1.0 400 Bad Request\r\n\r\n<html>\n").unwrap();
        // Until the client has said all, so that its end is no reset.
        let _ = client.read_to_end(&mut Vec::new());
    });
    let sent = run(&["send", &address], b"CRC\n");
    other.join().unwrap();
    assert_eq!((sent.status.code(), out(&sent)), (Some(1), ""));
    let expected = "expected a fbptr server, found \"HTTP/1.0 400 Bad Request\"";
    assert_eq!(err(&sent), format!("fbptr: {address}: {expected}\n"));
}

//! Tests of the window on a real X server: the screen equals the snapshot byte for byte, and every
//! key does what its description says.
//!
//! Skipped, with the reason printed, if Xvfb or xdotool is not installed. Built only with the
//! `window` feature.
#![cfg(feature = "window")]

mod events;
#[path = "../support/folder.rs"]
mod folder;
mod fullscreen;
mod program;
#[cfg(target_os = "linux")]
mod run;
mod screen;
mod serve;
#[path = "../support/tools.rs"]
mod tools;
mod view;

use folder::Folder;
use screen::{Guard, Screen, wait_for};
use std::process::Command;
use std::time::Duration;

const STREAM: &str = "CLEAR 203040\nFILL 20 20 600 80 300 460 ff0000 00ff00 0000ff\nLINE 0 0 639 479 ffffff\nCIRCLE 320 240 200 ffff00\n";
const SIZE: [usize; 2] = [640, 480];

#[test]
fn the_screen_is_the_snapshot_and_the_keys_work() {
    let folder = Folder::new("window");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let (stream, snap) = (folder.0.join("picture.fbs"), folder.0.join("picture.png"));
    std::fs::write(&stream, STREAM).expect("stream");
    let headless = Command::new(env!("CARGO_BIN_EXE_fbptr"))
        .args(["play", "picture.fbs", "--size", "640x480", "--headless", "--snap", "picture.png"])
        .current_dir(&folder.0)
        .status()
        .expect("the player runs");
    assert!(headless.success());
    let mut player = Guard(
        Command::new(env!("CARGO_BIN_EXE_fbptr"))
            .args(["play", "picture.fbs", "--size", "640x480", "--snap", "at-end.png"])
            .current_dir(&folder.0)
            .env("DISPLAY", &screen.display)
            .env_remove("WAYLAND_DISPLAY")
            .spawn()
            .expect("the player starts"),
    );
    let id = screen.window();
    let place = || screen.place(&id);
    let [x, y, w, h] = place();
    assert_eq!([w, h], SIZE, "the frame opens at a scale of 1");
    let shown = || screen.pixels(x, y, w, h);

    let picture = image::open(&snap).expect("the headless snapshot").to_rgb8();
    let expected: Vec<[u8; 3]> = picture.pixels().map(|p| p.0).collect();
    wait_for("the snapshot on the screen", || (shown() == expected).then_some(()));

    let (px, py) = (format!("{}", x + 300), format!("{}", y + 400));
    screen.xdotool(&["mousemove", &px, &py]);
    for key in ["F1", "F3", "i"] {
        screen.xdotool(&["key", key]);
        wait_for(&format!("{key} to show its overlay"), || (shown() != expected).then_some(()));
        screen.xdotool(&["key", key]);
        wait_for(&format!("{key} to hide its overlay"), || (shown() == expected).then_some(()));
    }
    screen.xdotool(&["key", "space"]);
    wait_for("space to say that the stream is paused", || (shown() != expected).then_some(()));
    screen.xdotool(&["key", "period"]);
    screen.xdotool(&["key", "space"]);
    wait_for("space to go on", || (shown() == expected).then_some(()));

    screen.xdotool(&["key", "F12"]);
    let saved = folder.0.join("fbptr-0001.png");
    let saved: Vec<[u8; 3]> =
        wait_for("F12's file", || Some(image::open(&saved).ok()?.to_rgb8().pixels().map(|p| p.0).collect()));
    assert!(saved == expected, "F12 saves what is shown, without overlays");

    // A larger window scales by whole factors only, centred; a smaller one keeps the aspect ratio.
    screen.xdotool(&["windowmove", "--sync", &id, "0", "0"]);
    screen.xdotool(&["windowsize", "--sync", &id, "1280", "1000"]);
    wait_for("the doubled picture", || {
        let [x, y, w, h] = place();
        let pixels = ([x, y, w, h] == [0, 0, 1280, 1000]).then(|| screen.pixels(x, y, w, h))?;
        let is_doubled = (0..960).all(|row| {
            (0..1280).all(|column| pixels[(row + 20) * 1280 + column] == expected[row / 2 * 640 + column / 2])
        });
        is_doubled.then_some(())
    });
    for size in [["1", "1"], ["37", "600"], ["640", "480"]] {
        screen.xdotool(&["windowsize", &id, size[0], size[1]]);
        std::thread::sleep(Duration::from_millis(100));
        screen.xdotool(&["key", "F1"]);
        screen.xdotool(&["key", "F1"]);
    }
    assert!(player.0.try_wait().expect("a child").is_none(), "no size ends the player");
    screen.xdotool(&["mousemove", "320", "240"]);
    screen.xdotool(&["key", "q"]);
    let status = wait_for("Q to end the player", || player.0.try_wait().expect("a child"));
    assert!(status.success(), "{status}");
    let at_end = std::fs::read(folder.0.join("at-end.png")).expect("the snapshot at the end");
    assert!(
        at_end == std::fs::read(&snap).expect("the headless snapshot"),
        "with and without a window: one file"
    );
}

#[test]
fn without_a_display_play_says_so_and_goes_on_headless() {
    let folder = Folder::new("no-display");
    std::fs::write(folder.0.join("a.fbs"), STREAM).expect("stream");
    let output = Command::new(env!("CARGO_BIN_EXE_fbptr"))
        .args(["play", "a.fbs", "--size", "640x480", "--snap", "a.png"])
        .current_dir(&folder.0)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .expect("the player runs");
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("headless"), "{output:?}");
    assert!(folder.0.join("a.png").is_file());
}

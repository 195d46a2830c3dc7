//! The window of `fbptr run`: its size, and its end by others.

use crate::folder::Folder;
use crate::screen::{Guard, Screen};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Starts a program that draws, and ends with status 7 when it is asked to; waits until it has drawn.
fn start(screen: &Screen, folder: &Folder, options: &[&str]) -> Guard {
    let script =
        "trap 'exit 7' TERM; printf '\\377\\200\\100' > /dev/fb0; : > drawn; while :; do sleep 0.05; done";
    let drawn = folder.0.join("drawn");
    let _ = std::fs::remove_file(&drawn);
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbptr"));
    command.arg("run").args(options).args(["--", "sh", "-c", script]);
    command.current_dir(&folder.0).env("DISPLAY", &screen.display).env_remove("WAYLAND_DISPLAY");
    let program = Guard(command.stdin(Stdio::null()).spawn().expect("it starts"));
    let until = Instant::now() + Duration::from_secs(60);
    while !drawn.exists() {
        assert!(Instant::now() < until, "it draws");
        sleep(Duration::from_millis(10));
    }
    program
}

#[test]
fn a_window_that_others_destroy_ends_the_program_in_order() {
    let folder = Folder::new("run-window");
    let Some(screen) = Screen::start(&folder.0) else { return };
    // The first ends the connection to the window system, as xkill does; the other the window
    // alone.
    for how in ["windowkill", "windowclose"] {
        let snap = folder.0.join(format!("{how}.png"));
        let mut run =
            start(&screen, &folder, &["--size", "320x200", "--snap", snap.to_str().expect("a name")]);
        screen.xdotool(&[how, &screen.window()]);
        assert_eq!(run.0.wait().expect("it ends").code(), Some(7), "{how}: the program's own status");
        let picture = image::open(&snap).expect("the frame at the end").to_rgb8();
        assert_eq!(picture.get_pixel(0, 0).0, [64, 128, 255], "{how}");
    }
}

#[test]
fn a_tubes_window_opens_with_room_for_its_lines() {
    let folder = Folder::new("run-tube");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let _run = start(&screen, &folder, &["--crt", "--size", "600x400"]);
    let [_, _, w, h] = screen.place(&screen.window());
    assert_eq!([w, h], [1800, 1200], "three window pixels for each of the frame's");
}

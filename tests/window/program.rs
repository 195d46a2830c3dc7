//! `fbptr::run`: a program that draws by itself shows its frame, and gets keys, mouse and the end.
//!
//! Each test is two programs: started again with [`PROGRAM`] in its environment it is the one that draws.

use crate::folder::Folder;
use crate::screen::{Guard, Screen, wait_for};
use std::collections::HashSet;
use std::process::Command;

/// Variable of the environment that makes a test the program that draws.
const PROGRAM: &str = "FBPTR_TEST_PROGRAM";

const SIZE: [usize; 2] = [64, 48];
const GREEN: [u8; 3] = [0, 128, 0];
const RED: [u8; 3] = [255, 0, 0];

fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, 255]
}

/// Returns whether this process was started to draw.
fn is_program() -> bool {
    std::env::var_os(PROGRAM).is_some()
}

/// Returns the command that starts this executable as the program of a test.
fn program_of(test: &str) -> Command {
    let mut command = Command::new(std::env::current_exe().expect("this program"));
    command.args(["--exact", test, "--"]).env(PROGRAM, "1").env_remove("WAYLAND_DISPLAY");
    command
}

/// Draws in the colour of the key that was pressed last, until Escape.
fn draw_until_escape() {
    let mut color = GREEN;
    fbptr::run(SIZE[0] as u32, SIZE[1] as u32, |fb, input| {
        color = if input.was_pressed("r") { RED } else { color };
        fb.clear(opaque(color));
        if input.buttons[0] {
            fb.put_pixel(input.mouse[0], input.mouse[1], [255; 4]);
        }
        // A tap may be shorter than a frame.
        input.close = input.was_pressed("escape");
    })
    .expect("there is a screen");
}

#[test]
fn a_program_draws_its_frames_without_a_window_and_saves_the_last() {
    if is_program() {
        return draw_twenty_frames();
    }
    let folder = Folder::new("program-headless");
    let run = |arguments: &[&str]| {
        program_of("program::a_program_draws_its_frames_without_a_window_and_saves_the_last")
            // After -- the test harness leaves the words alone.
            .args(arguments)
            .env_remove("DISPLAY")
            .current_dir(&folder.0)
            .output()
            .expect("it starts")
    };
    let blue = |name: &str| {
        let picture = image::open(folder.0.join(name)).expect("a picture").to_rgb8();
        assert_eq!(picture.dimensions(), (SIZE[0] as u32, SIZE[1] as u32));
        picture.get_pixel(5, 5).0[2]
    };
    for (arguments, frames) in [
        (&["--headless", "--snap", "a.png"][..], 1),
        (&["--headless", "--frames", "7", "--snap", "a.png"], 7),
        (&["--frames", "99", "--snap", "a.png", "--headless"], 20),
    ] {
        let output = run(arguments);
        assert!(output.status.success(), "{output:?}");
        assert_eq!(blue("a.png"), frames, "{arguments:?}");
    }
    for bad in [&["--headless", "--frames", "none"][..], &["--headless", "--snap", "no-folder/a.png"]] {
        assert!(!run(bad).status.success(), "{bad:?}");
    }
}

/// Draws frames whose blue is their number, at sixty a second, and ends after twenty.
fn draw_twenty_frames() {
    let mut seconds = 0.0;
    fbptr::run(SIZE[0] as u32, SIZE[1] as u32, |fb, input| {
        seconds += input.delta_s;
        assert!((seconds - input.frame as f64 / 60.0).abs() < 1e-9, "a sixtieth of a second a frame");
        fb.clear(opaque([0, 0, input.frame as u8 + 1]));
        // A program may end before its last frame.
        input.close = input.frame == 19;
    })
    .expect("no window is needed");
}

#[test]
fn a_program_shows_its_frame_and_gets_keys_mouse_and_the_end() {
    if is_program() {
        return draw_until_escape();
    }
    let folder = Folder::new("program");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let mut program = Guard(
        program_of("program::a_program_shows_its_frame_and_gets_keys_mouse_and_the_end")
            .env("DISPLAY", &screen.display)
            .spawn()
            .expect("it starts"),
    );
    let id = screen.window();
    screen.xdotool(&["windowmove", "--sync", &id, "0", "0"]);
    let [_, _, width, height] = screen.place(&id);
    let scale = width / SIZE[0];
    assert!(scale > 1 && [width, height] == SIZE.map(|side| side * scale), "{width}x{height}");
    let shown = || (screen.place(&id)[..2] == [0, 0]).then(|| screen.pixels(0, 0, width, height));
    let is_all = |color| shown().is_some_and(|pixels| pixels.iter().all(|p| *p == color)).then_some(());
    wait_for("the first color", || is_all(GREEN));
    screen.xdotool(&["mousemove", "8", "8"]);
    screen.xdotool(&["key", "r"]);
    wait_for("the color of the key", || is_all(RED));
    screen.xdotool(&["key", "k"]);
    // Stripes of the mask and lines of the beam, in red.
    wait_for("the look of a tube", || {
        let pixels = shown()?;
        let reds: HashSet<u8> = pixels.iter().map(|p| p[0]).collect();
        (reds.len() > 4 && pixels.iter().all(|p| p[1] == 0 && p[2] == 0)).then_some(())
    });
    screen.xdotool(&["key", "F8"]);
    wait_for("the pixels as they are", || is_all(RED));
    let at = |pixel: usize| (pixel * scale + scale / 2).to_string();
    screen.xdotool(&["mousemove", &at(10), &at(20), "mousedown", "1"]);
    wait_for("the pixel under the pointer", || {
        let pixels = shown()?;
        let is_right = (0..width * height).all(|i| {
            let is_pointed = [i % width / scale, i / width / scale] == [10, 20];
            pixels[i] == if is_pointed { [255; 3] } else { RED }
        });
        is_right.then_some(())
    });
    screen.xdotool(&["mouseup", "1"]);
    screen.xdotool(&["key", "Escape"]);
    let status = wait_for("the program's end", || program.0.try_wait().expect("a child"));
    assert!(status.success(), "{status}");
}

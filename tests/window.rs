//! The window on a real X server: the screen is the snapshot byte for byte, and every key does what it says.
//!
//! Skipped, with the reason printed, where Xvfb or xdotool is not installed or the crate was built without `window`.
#![cfg(feature = "window")]

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(30);

/// A temporary folder that goes when the test ends.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("fbptr-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("temporary folder");
        Folder(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A process that ends with the test.
struct Guard(Child);

impl Drop for Guard {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

struct Screen {
    _server: Guard,
    display: String,
    memory_file: PathBuf,
}

impl Screen {
    /// An X server without hardware whose screen is a file, or `None` with the reason printed.
    fn start(folder: &Path) -> Option<Screen> {
        for tool in ["Xvfb", "xdotool"] {
            let is_there = std::env::var_os("PATH")
                .is_some_and(|paths| std::env::split_paths(&paths).any(|dir| dir.join(tool).is_file()));
            if !is_there {
                eprintln!("skipped: {tool} is not installed");
                return None;
            }
        }
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x1024x24", "-nolisten", "tcp", "-fbdir"])
            .arg(folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut number = String::new();
        let stdout = server.stdout.take().expect("piped");
        BufReader::new(stdout).read_line(&mut number).expect("Xvfb tells its display");
        let display = format!(":{}", number.trim());
        Some(Screen { _server: Guard(server), display, memory_file: folder.join("Xvfb_screen0") })
    }

    fn xdotool(&self, args: &[&str]) -> String {
        let output =
            Command::new("xdotool").args(args).env("DISPLAY", &self.display).output().expect("xdotool runs");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// The R, G, B of a rectangle of the screen, from the server's XWD file.
    fn pixels(&self, x: usize, y: usize, w: usize, h: usize) -> Vec<[u8; 3]> {
        let file = std::fs::read(&self.memory_file).expect("the screen's file");
        let word =
            |i: usize| u32::from_be_bytes(file[i * 4..i * 4 + 4].try_into().expect("4 bytes")) as usize;
        let (header_bytes, is_big_endian, bits, stride, colors) =
            (word(0), word(7) == 1, word(11), word(12), word(19));
        assert_eq!(bits, 32, "a 24-bit screen has 32-bit pixels");
        let start = header_bytes + colors * 12;
        let at = |column: usize, row: usize| {
            let p = &file[start + row * stride + column * 4..][..4];
            if is_big_endian { [p[1], p[2], p[3]] } else { [p[2], p[1], p[0]] }
        };
        (y..y + h)
            .flat_map(|row| (x..x + w).map(move |column| (column, row)))
            .map(|(c, r)| at(c, r))
            .collect()
    }
}

fn wait_for<T>(what: &str, mut probe: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = probe() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

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
    let id = wait_for("the window", || {
        let found = screen.xdotool(&["search", "--onlyvisible", "--name", "fbptr"]);
        found.lines().next().map(str::to_string)
    });
    let place = || {
        let geometry = screen.xdotool(&["getwindowgeometry", "--shell", &id]);
        let value = |key: &str| {
            let line = geometry.lines().find_map(|l| l.strip_prefix(key)).expect("geometry");
            line.parse::<usize>().expect("a number")
        };
        [value("X="), value("Y="), value("WIDTH="), value("HEIGHT=")]
    };
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

    // A larger window shows whole factors only, in the middle; a smaller one keeps the aspect.
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

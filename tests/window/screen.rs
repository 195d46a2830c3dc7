//! A virtual X server (Xvfb) for the tests of the window.

use crate::tools;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

pub const PATIENCE: Duration = Duration::from_secs(30);

/// A process that is killed when the test ends.
pub struct Guard(pub Child);

impl Drop for Guard {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

pub struct Screen {
    server: Guard,
    pub display: String,
    memory_file: PathBuf,
}

impl Screen {
    /// Starts an X server without hardware whose screen is a file, or returns `None` with the
    /// reason printed.
    pub fn start(folder: &Path) -> Option<Screen> {
        if !tools::are_there(&["Xvfb", "xdotool"]) {
            return None;
        }
        // Servers that start at once may take the same display number, and the other one ends with
        // its own test. Each therefore has its own screen height, and starts again if another one
        // answers.
        static SERVERS: AtomicUsize = AtomicUsize::new(0);
        for _ in 0..5 {
            let height = 1024 + SERVERS.fetch_add(1, Ordering::Relaxed);
            let screen = Screen::run(folder, height);
            let size = screen.xdotool(&["getdisplaygeometry"]);
            if size.trim() == format!("1280 {height}") {
                return Some(screen);
            }
        }
        panic!("no X server is reached");
    }

    fn run(folder: &Path, height: usize) -> Screen {
        let mut server = Command::new("Xvfb")
            // No reset when the last client leaves: the next client would be refused.
            .args(["-displayfd", "1", "-noreset", "-nolisten", "tcp", "-screen", "0"])
            .arg(format!("1280x{height}x24"))
            .arg("-fbdir")
            .arg(folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut number = String::new();
        let stdout = server.stdout.take().expect("piped");
        BufReader::new(stdout).read_line(&mut number).expect("Xvfb tells its display");
        let display = format!(":{}", number.trim());
        Screen { server: Guard(server), display, memory_file: folder.join("Xvfb_screen0") }
    }

    /// Ends the server without a word to its clients.
    pub fn kill(&mut self) {
        self.server.0.kill().expect("it runs");
        self.server.0.wait().expect("it ends");
    }

    pub fn xdotool(&self, args: &[&str]) -> String {
        let output =
            Command::new("xdotool").args(args).env("DISPLAY", &self.display).output().expect("xdotool runs");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Returns the R, G, B of a rectangle of the screen, from the server's XWD file.
    pub fn pixels(&self, x: usize, y: usize, w: usize, h: usize) -> Vec<[u8; 3]> {
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

pub fn wait_for<T>(what: &str, mut probe: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = probe() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

impl Screen {
    /// Waits for a window whose title contains "fbptr" and returns its number.
    pub fn window(&self) -> String {
        wait_for("the window", || {
            let found = self.xdotool(&["search", "--onlyvisible", "--name", "fbptr"]);
            found.lines().next().map(str::to_string)
        })
    }

    /// Returns x, y, width and height of a window on the screen.
    pub fn place(&self, window: &str) -> [usize; 4] {
        let geometry = self.xdotool(&["getwindowgeometry", "--shell", window]);
        let value = |key: &str| {
            let line = geometry.lines().find_map(|l| l.strip_prefix(key)).expect("geometry");
            line.parse::<usize>().expect("a number")
        };
        [value("X="), value("Y="), value("WIDTH="), value("HEIGHT=")]
    }
}

//! Window events reach the program that subscribed to them: a drawing program in Python, driven by
//! a mouse and keys.

use crate::folder::Folder;
use crate::screen::{Guard, Screen, wait_for};
use crate::serve::serve;
use crate::tools;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

const DRAW: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/clients/python/draw.py");

fn pixel(address: &str, x: i32, y: i32) -> String {
    let mut wire = TcpStream::connect(address).expect("the server listens");
    write!(wire, "PX {x} {y}\nQUIT\n").expect("a command");
    let mut reply = String::new();
    wire.read_to_string(&mut reply).expect("a reply");
    reply.trim_end().rsplit(' ').next().unwrap_or_default().to_owned()
}

/// A server in a window, and the drawing program that is connected to it.
struct Drawing<'a> {
    screen: &'a Screen,
    server: Guard,
    program: Guard,
    address: String,
    /// Lines that the program has printed.
    heard: Arc<Mutex<Vec<String>>>,
    listener: JoinHandle<()>,
    /// Number of the window.
    id: String,
    /// Screen pixels of a pixel of the frame.
    scale: usize,
}

impl Drawing<'_> {
    /// Starts both, and moves the window to the screen's corner.
    fn start(screen: &Screen) -> Drawing<'_> {
        let (server, address) = serve(screen, &[]);
        let mut program = Guard(
            Command::new("python3")
                .args([DRAW, &address, "--print"])
                .stdout(Stdio::piped())
                .spawn()
                .expect("the program starts"),
        );
        let heard = Arc::new(Mutex::new(Vec::<String>::new()));
        let output = BufReader::new(program.0.stdout.take().expect("piped"));
        let listener = std::thread::spawn({
            let heard = heard.clone();
            move || output.lines().map_while(Result::ok).for_each(|l| heard.lock().expect("no panic").push(l))
        });
        let mut drawing =
            Drawing { screen, server, program, address, heard, listener, id: String::new(), scale: 1 };
        drawing.has_heard("ready");
        drawing.id = screen.window();
        screen.xdotool(&["windowmove", "--sync", &drawing.id, "0", "0"]);
        wait_for("the window at the corner", || (screen.place(&drawing.id)[..2] == [0, 0]).then_some(()));
        drawing.scale = screen.place(&drawing.id)[2] / 320;
        drawing
    }

    fn has_heard(&self, what: &str) {
        wait_for(&format!("{what:?} in {:?}", self.heard.lock().expect("no panic")), || {
            (self.count(what) > 0).then_some(())
        });
    }

    fn count(&self, what: &str) -> usize {
        self.heard.lock().expect("no panic").iter().filter(|l| *l == what).count()
    }

    /// Moves the pointer to the middle of a pixel of the frame.
    fn move_to(&self, x: usize, y: usize) {
        let at = |v: usize| (v * self.scale + self.scale / 2).to_string();
        self.screen.xdotool(&["mousemove", &at(x), &at(y)]);
    }

    fn wait_for_pixel(&self, what: &str, x: i32, y: i32, color: &str) {
        wait_for(what, || (pixel(&self.address, x, y) == color).then_some(()));
    }

    /// Draws a line by the mouse.
    fn drag(&self) {
        self.move_to(40, 30);
        self.has_heard("mouse 40 30 0");
        self.screen.xdotool(&["mousedown", "1"]);
        self.has_heard("mouse 40 30 1");
        self.move_to(90, 30);
        self.has_heard("mouse 90 30 1");
        self.screen.xdotool(&["mouseup", "1"]);
        self.has_heard("mouse 90 30 0");
        for x in [40, 65, 90] {
            self.wait_for_pixel("the line", x, 30, "ffffff");
        }
        let beside = [[39, 30], [91, 30], [65, 31]].map(|[x, y]| pixel(&self.address, x, y));
        assert_eq!(beside, ["101820"; 3]);
    }

    /// Presses keys, and draws in the colour that one of them chose.
    fn press_keys(&self) {
        // Q does not close the window while a program subscribes to keys.
        for key in ["2", "q", "Left"] {
            self.screen.xdotool(&["key", key]);
            self.has_heard(&format!("key down {}", key.to_lowercase()));
            self.has_heard(&format!("key up {}", key.to_lowercase()));
        }
        self.has_heard("text u+0071 q");
        // A new position, so that earlier events do not count.
        self.move_to(120, 30);
        self.has_heard("mouse 120 30 0");
        self.screen.xdotool(&["mousedown", "1"]);
        self.has_heard("mouse 120 30 1");
        self.move_to(120, 80);
        self.has_heard("mouse 120 80 1");
        self.screen.xdotool(&["mouseup", "1", "click", "4"]);
        self.wait_for_pixel("a line in the colour of key 2", 120, 60, "ff4040");
        self.has_heard("wheel 0 1");
    }

    /// Clicks: each is over within microseconds, much less than the time of a frame.
    fn click_fast(&self) {
        self.move_to(60, 60);
        self.has_heard("mouse 60 60 0");
        let releases = self.count("mouse 60 60 0");
        for _ in 0..20 {
            self.screen.xdotool(&["click", "1"]);
        }
        wait_for("twenty presses", || (self.count("mouse 60 60 1") >= 20).then_some(()));
        wait_for("their releases", || (self.count("mouse 60 60 0") >= releases + 20).then_some(()));
        self.screen.xdotool(&["click", "--repeat", "5", "--delay", "0", "3"]);
        wait_for("five of the right button", || (self.count("mouse 60 60 4") >= 5).then_some(()));
        assert_eq!([self.count("mouse 60 60 1"), self.count("mouse 60 60 4")], [20, 5], "each is sent once");
    }

    /// Closes the window, and waits until both programs have ended.
    fn close(mut self) {
        self.screen.xdotool(&["windowsize", "--sync", &self.id, "700", "500"]);
        self.has_heard("resize 700 500");
        self.screen.xdotool(&["key", "Escape"]);
        self.has_heard("close");
        let status = wait_for("the program to end", || self.program.0.try_wait().expect("a child"));
        assert!(status.success(), "{status}");
        let status = wait_for("the server to end", || self.server.0.try_wait().expect("a child"));
        assert!(status.success(), "{status}");
        self.listener.join().expect("no panic");
    }
}

#[test]
fn a_drawing_program_hears_mouse_keys_text_resize_and_close() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    let folder = Folder::new("events");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let drawing = Drawing::start(&screen);
    drawing.drag();
    drawing.press_keys();
    drawing.click_fast();
    drawing.close();
}

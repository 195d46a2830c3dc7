//! Window events reach the program that subscribed to them: a drawing program in Python, driven by
//! a mouse and keys.

use crate::screen::{Folder, Guard, Screen, wait_for};
use crate::tools;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};

const DRAW: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/clients/python/draw.py");

fn pixel(address: &str, x: i32, y: i32) -> String {
    let mut wire = TcpStream::connect(address).expect("the server listens");
    write!(wire, "PX {x} {y}\nQUIT\n").expect("a command");
    let mut reply = String::new();
    wire.read_to_string(&mut reply).expect("a reply");
    reply.trim_end().rsplit(' ').next().unwrap_or_default().to_owned()
}

#[test]
fn a_drawing_program_hears_mouse_keys_text_resize_and_close() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    let folder = Folder::new("events");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let mut server = Guard(
        Command::new(env!("CARGO_BIN_EXE_fbptr"))
            .args(["serve", "--listen", ":0", "--size", "320x200"])
            .env("DISPLAY", &screen.display)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(Stdio::piped())
            .spawn()
            .expect("the server starts"),
    );
    let mut says = BufReader::new(server.0.stderr.take().expect("piped"));
    let mut line = String::new();
    says.read_line(&mut line).expect("the server tells its address");
    let address = line.trim_end().rsplit(' ').next().expect("an address").to_owned();

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
    let has_heard = |what: &str| {
        wait_for(&format!("{what:?} in {:?}", heard.lock().expect("no panic")), || {
            heard.lock().expect("no panic").iter().any(|l| l == what).then_some(())
        });
    };
    has_heard("ready");

    let id = screen.window();
    screen.xdotool(&["windowmove", "--sync", &id, "0", "0"]);
    wait_for("the window at the corner", || (screen.place(&id)[..2] == [0, 0]).then_some(()));
    let scale = screen.place(&id)[2] / 320;
    let move_to = |x: usize, y: usize| {
        // The middle of a pixel of the frame.
        let at = |v: usize| (v * scale + scale / 2).to_string();
        screen.xdotool(&["mousemove", &at(x), &at(y)]);
    };
    move_to(40, 30);
    has_heard("mouse 40 30 0");
    screen.xdotool(&["mousedown", "1"]);
    has_heard("mouse 40 30 1");
    move_to(90, 30);
    has_heard("mouse 90 30 1");
    screen.xdotool(&["mouseup", "1"]);
    has_heard("mouse 90 30 0");
    for x in [40, 65, 90] {
        wait_for("the line", || (pixel(&address, x, 30) == "ffffff").then_some(()));
    }
    assert_eq!([pixel(&address, 39, 30), pixel(&address, 91, 30), pixel(&address, 65, 31)], ["101820"; 3]);

    // Q does not close the window while a program subscribes to keys.
    for key in ["2", "q", "Left"] {
        screen.xdotool(&["key", key]);
        has_heard(&format!("key down {}", key.to_lowercase()));
        has_heard(&format!("key up {}", key.to_lowercase()));
    }
    has_heard("text u+0071 q");
    // A new position, so that earlier events do not count.
    move_to(120, 30);
    has_heard("mouse 120 30 0");
    screen.xdotool(&["mousedown", "1"]);
    has_heard("mouse 120 30 1");
    move_to(120, 80);
    has_heard("mouse 120 80 1");
    screen.xdotool(&["mouseup", "1", "click", "4"]);
    wait_for("a line in the colour of key 2", || (pixel(&address, 120, 60) == "ff4040").then_some(()));
    has_heard("wheel 0 1");

    // Each click is over within microseconds, much less than the time of a frame.
    move_to(60, 60);
    has_heard("mouse 60 60 0");
    let count = |what: &str| heard.lock().expect("no panic").iter().filter(|l| *l == what).count();
    let releases = count("mouse 60 60 0");
    for _ in 0..20 {
        screen.xdotool(&["click", "1"]);
    }
    wait_for("twenty presses", || (count("mouse 60 60 1") >= 20).then_some(()));
    wait_for("their releases", || (count("mouse 60 60 0") >= releases + 20).then_some(()));
    screen.xdotool(&["click", "--repeat", "5", "--delay", "0", "3"]);
    wait_for("five of the right button", || (count("mouse 60 60 4") >= 5).then_some(()));
    assert_eq!([count("mouse 60 60 1"), count("mouse 60 60 4")], [20, 5], "each is sent once");

    screen.xdotool(&["windowsize", "--sync", &id, "700", "500"]);
    has_heard("resize 700 500");
    screen.xdotool(&["key", "Escape"]);
    has_heard("close");
    let status = wait_for("the program to end", || program.0.try_wait().expect("a child"));
    assert!(status.success(), "{status}");
    let status = wait_for("the server to end", || server.0.try_wait().expect("a child"));
    assert!(status.success(), "{status}");
    listener.join().expect("no panic");
}

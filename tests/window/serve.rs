//! A server's window: it says how to draw until a client has drawn, takes a client's title, and
//! shows the frame of a client that waits.

use crate::folder::Folder;
use crate::screen::{Guard, Screen, wait_for};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Starts a server with a window of 320x200; returns it and the address that it listens on.
pub fn serve(screen: &Screen, more: &[&str]) -> (Guard, String) {
    let mut server = Guard(
        Command::new(env!("CARGO_BIN_EXE_fbptr"))
            .args(["serve", "--listen", ":0", "--size", "320x200"])
            .args(more)
            .env("DISPLAY", &screen.display)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(Stdio::piped())
            .spawn()
            .expect("the server starts"),
    );
    let mut says = BufReader::new(server.0.stderr.take().expect("piped"));
    let mut line = String::new();
    says.read_line(&mut line).expect("the server tells its address");
    // Later messages need a reader, or the server would block.
    std::thread::spawn(move || {
        says.lines().map_while(Result::ok).for_each(|line| eprintln!("server: {line}"))
    });
    (server, line.trim_end().rsplit(' ').next().expect("an address").to_owned())
}

/// Returns the pixels of a window that are not black.
fn lit(screen: &Screen, id: &str) -> Vec<[u8; 3]> {
    let [x, y, w, h] = screen.place(id);
    screen.pixels(x, y, w, h).into_iter().filter(|pixel| *pixel != [0; 3]).collect()
}

fn connect(address: &str) -> TcpStream {
    TcpStream::connect(address).expect("the server listens")
}

#[test]
fn the_window_says_how_to_draw_until_a_client_has_drawn() {
    let folder = Folder::new("welcome");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let (_server, address) = serve(&screen, &[]);
    let id = screen.window();
    let letters = wait_for("lines of text", || {
        let letters = lit(&screen, &id).len();
        (letters > 1000).then_some(letters)
    });
    // A query is no drawing.
    let mut wire = connect(&address);
    wire.write_all(b"SIZE\nQUIT\n").expect("a command");
    let mut reply = String::new();
    wire.read_to_string(&mut reply).expect("a reply");
    assert_eq!(reply, "SIZE 320 200\n");
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert_eq!(lit(&screen, &id).len(), letters);

    connect(&address).write_all(b"PX 5 5 ff0000\n").expect("a command");
    let [_, _, w, _] = screen.place(&id);
    let factor = w / 320;
    wait_for("the frame alone", || (lit(&screen, &id) == vec![[255, 0, 0]; factor * factor]).then_some(()));
}

#[test]
fn a_title_names_the_window_and_a_client_that_waits_holds_up_no_other() {
    let folder = Folder::new("title");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let (_server, address) = serve(&screen, &[]);
    let id = screen.window();
    let [_, _, w, h] = screen.place(&id);
    let is_all = |color: [u8; 3]| {
        let lit = lit(&screen, &id);
        (lit.len() == w * h && lit.iter().all(|pixel| *pixel == color)).then_some(())
    };
    let mut waiting = connect(&address);
    let stream = "TITLE two moons :3\nCLEAR ff0000\nPRESENT\nWAIT 6\nCLEAR 00ff00\nPRESENT\nSYNC end\n";
    waiting.write_all(stream.as_bytes()).expect("commands");
    let has_ended = Arc::new(AtomicBool::new(false));
    let ended = has_ended.clone();
    let listener = std::thread::spawn(move || {
        let mut line = String::new();
        BufReader::new(waiting).read_line(&mut line).expect("a reply");
        ended.store(true, Ordering::Release);
        line
    });
    wait_for("the title", || {
        (screen.xdotool(&["getwindowname", &id]).trim() == "two moons :3").then_some(())
    });
    wait_for("the first frame", || is_all([255, 0, 0]));

    let mut other = connect(&address);
    other.write_all(b"PX 9 9\nQUIT\n").expect("commands");
    let mut reply = String::new();
    other.read_to_string(&mut reply).expect("a reply");
    assert_eq!(reply, "PX 9 9 ff0000\n");
    assert!(!has_ended.load(Ordering::Acquire), "the other client was answered during the wait");
    wait_for("the second frame", || is_all([0, 255, 0]));
    assert_eq!(listener.join().expect("it read"), "SYNC end\n");
}

#[test]
#[cfg(target_os = "linux")]
fn an_x_server_that_dies_under_the_window_ends_the_server_in_order() {
    // The moment decides what of Xlib notices first, so several are tried, each while frames are
    // uploaded.
    for round in 0..5u64 {
        let folder = Folder::new("x-dies");
        let Some(mut screen) = Screen::start(&folder.0) else { return };
        let [snap, recording] = ["s.png", "r.fbr"].map(|name| folder.0.join(name));
        let [snap_name, recording_name] = [&snap, &recording].map(|path| path.to_str().expect("a name"));
        let (mut server, address) = serve(&screen, &["--snap", snap_name, "--record", recording_name]);
        let mut wire = connect(&address);
        wire.write_all(b"CLEAR 102030\n").expect("a command");
        screen.window();
        let floods = std::thread::spawn(move || {
            let mut number = 0u32;
            while wire.write_all(format!("PX 9 9 {number:06x}\n").as_bytes()).is_ok() {
                number = (number + 1) % (1 << 24);
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
        });
        std::thread::sleep(std::time::Duration::from_millis(300 + 13 * round));
        screen.kill();
        assert_eq!(server.0.wait().expect("it ends").code(), Some(0), "round {round}");
        floods.join().expect("the connection is closed");
        let picture = image::open(&snap).expect("the frame at the end").to_rgb8();
        assert_eq!(picture.get_pixel(0, 0).0, [16, 32, 48], "round {round}");
        let text = String::from_utf8_lossy(&std::fs::read(&recording).expect("a recording")).into_owned();
        assert!(text.lines().last().is_some_and(|line| line.starts_with("#!end ")), "round {round}");
    }
}

#[test]
fn what_another_window_has_covered_is_shown_again() {
    let folder = Folder::new("covered");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let (_server, address) = serve(&screen, &[]);
    let id = screen.window();
    let [x, y, w, h] = screen.place(&id);
    let pixels = || screen.pixels(x, y, w, h);
    let is_all = |color: [u8; 3]| pixels().iter().all(|pixel| *pixel == color).then_some(());
    connect(&address).write_all(b"CLEAR 00ffff\n").expect("a command");
    wait_for("one colour", || is_all([0, 255, 255]));
    let (other, _) = serve(&screen, &[]);
    wait_for("another window above it", || is_all([0, 255, 255]).is_none().then_some(()));
    drop(other);
    wait_for("the colour again", || is_all([0, 255, 255]));
}

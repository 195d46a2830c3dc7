//! A public server: connections per address, idle connections, browsers, and the first bytes of a
//! connection.

#![cfg(unix)]

use crate::folder::Folder;
use crate::process::{Process, fbptr, play, text};
use crate::support::{Serving, Wire};
use fbptr::server::{Display, DisplayObserver, Engine, Limits, ListenAddress};
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Repeats `probe` until it returns a value; panics after 30 seconds.
fn wait_for<T>(what: &str, mut probe: impl FnMut() -> Option<T>) -> T {
    let until = std::time::Instant::now() + Duration::from_secs(30);
    loop {
        if let Some(found) = probe() {
            return found;
        }
        assert!(std::time::Instant::now() < until, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn an_address_has_its_share_of_connections_and_unix_sockets_are_exempt() {
    let folder = Folder::new("share");
    let limits = Limits { connections_per_address: 2, ..Limits::default() };
    let mut serving = Serving::limited(8, 8, limits);
    let mut inside: Vec<Wire> = (0..2).map(|_| serving.connect()).collect();
    for wire in &mut inside {
        assert_eq!(wire.ask("SIZE\n"), "SIZE 8 8\n");
    }
    let told = serving.say("SIZE\n");
    assert_eq!(told, "ERR 0 0 EQUOTA CONNECT: no more than 2 connections at one time from 127.0.0.1\n");
    let socket = folder.join("s");
    serving.server.listen(ListenAddress::Unix(socket.clone())).unwrap();
    let mut others: Vec<UnixStream> = (0..5).map(|_| UnixStream::connect(&socket).unwrap()).collect();
    for other in &mut others {
        let mut reply = [0; 9];
        other.write_all(b"SIZE\n").unwrap();
        other.read_exact(&mut reply).unwrap();
        assert_eq!(&reply, b"SIZE 8 8\n");
    }
    inside.pop();
    wait_for("the place that became free", || (serving.talk(b"SIZE\n") == b"SIZE 8 8\n").then_some(()));
}

/// Clears the flag on drop, so that the working thread ends.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

#[test]
fn idle_connections_end_and_those_that_wait_or_work_stay() {
    let limits =
        Limits { idle_timeout: Some(Duration::from_secs(2)), reply_bytes: 100_000, ..Limits::default() };
    let mut engine = Engine::with_limits(100, 100, limits).unwrap();
    let display = Display::new(100, 100);
    engine.attach(DisplayObserver::new(display.clone()));
    let serving = Serving::with(engine);
    let connect = |first: &[u8]| {
        let mut wire = serving.connect();
        wire.send(first);
        wire
    };
    let silent = connect(b"");
    let once = connect(b"SYNC a\n");
    let unfinished = connect(b"TEXT 1 1 ffffff :10\nabc");
    // More replies than the system's buffers hold, of which none is read.
    let deaf = connect(b"READ 0 0 100 100\n".repeat(2000).as_slice());
    let mut waiting = connect(b"PRESENT wait\n");
    let mut listening = connect(b"EVENTS on\n");
    let mut busy = connect(b"");
    let at_work = AtomicBool::new(true);
    std::thread::scope(|scope| {
        let at_work = &at_work;
        // The other thread ends even if this one panics.
        let _ends = Ends(at_work);
        let work = scope.spawn(|| {
            while at_work.load(Ordering::Relaxed) {
                busy.send(b"PX 1 1 ff0000\n");
                std::thread::sleep(Duration::from_millis(50));
            }
        });
        let rest = |wire: &mut Wire| {
            let mut rest = Vec::new();
            // A reset counts as the end: the server did not read all bytes.
            let _ = wire.0.read_to_end(&mut rest);
            String::from_utf8_lossy(&rest).into_owned()
        };
        let [mut silent, mut once, mut unfinished, mut deaf] = [silent, once, unfinished, deaf];
        assert_eq!(rest(&mut silent), "", "a connection that used Pixelflut alone is told nothing");
        assert_eq!(rest(&mut once), "SYNC a\nERR 2 7 EQUOTA CONNECT: idle for 2 seconds\n");
        assert_eq!(rest(&mut unfinished), "", "and no more is one in the middle of its first command");
        // Longer than the idle timeout of all connections.
        std::thread::sleep(Duration::from_secs(4));
        at_work.store(false, Ordering::Relaxed);
        work.join().unwrap();
        let bytes = rest(&mut deaf).len();
        assert!(bytes < 2000 * 40_000, "{bytes}: the deaf one was closed before its replies were out");
    });
    display.note_shown(1);
    assert_eq!(waiting.line(), "FRAME 1\n");
    assert_eq!(listening.ask("SYNC b\n"), "SYNC b\n");
    assert_eq!(busy.ask("SIZE\n"), "SIZE 100 100\n");
}

#[test]
fn nobody_is_idle_unless_a_time_is_given_and_no_address_takes_all_places() {
    let limits = Limits::default();
    assert_eq!(limits.idle_timeout, None);
    assert!(limits.connections_per_address < limits.connections);
}

/// A request that a page can make a browser send: lines of commands as the body of a form or a
/// fetch.
const REQUEST: &str = "POST / HTTP/1.1\r\nHost: 127.0.0.1:1234\r\nOrigin: http://evil.example\r\n\
                       Content-Type: text/plain\r\nContent-Length: 32\r\n\r\nPX 1 1 ff0000\nPX 2 2 ff0000\nSIZE\n";

#[test]
fn a_page_in_a_browser_sends_no_commands() {
    let serving = Serving::start(8, 8);
    for cut in (1..24).chain([REQUEST.len()]) {
        let mut wire = serving.connect();
        for piece in REQUEST.as_bytes().chunks(cut) {
            // The server may have closed the connection already.
            if wire.0.write_all(piece).is_err() {
                break;
            }
        }
        let mut reply = Vec::new();
        let _ = wire.0.read_to_end(&mut reply);
        let reply = String::from_utf8_lossy(&reply).into_owned();
        assert!(reply.starts_with("HTTP/1.1 400 Bad Request\r\n"), "pieces of {cut}: {reply}");
        let (head, body) = reply.split_once("\r\n\r\n").unwrap();
        assert!(head.contains(&format!("Content-Length: {}", body.len())), "{head}");
        assert!(body.contains("fbptr") && body.lines().count() == 1, "{body}");
    }
    let methods = ["GET", "HEAD", "PUT", "OPTIONS", "DELETE", "PATCH", "TRACE", "CONNECT", "get", "Post"];
    for method in methods {
        let told = serving.say(&format!("{method} /\nPX 1 1 ff0000\nSIZE\n"));
        assert!(told.starts_with("HTTP/1.1 400 ") && !told.contains("SIZE 8 8"), "{method}: {told}");
    }
    let told = serving.say("brew / HTTP/1.1\r\n\r\nPX 1 1 ff0000\nSIZE\n");
    assert!(told.starts_with("HTTP/1.1 400 ") && !told.contains("SIZE 8 8"), "{told}");
    assert!(serving.say("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n").starts_with("HTTP/1.1 400 "));
    let told = serving.talk(b"\x16\x03\x01\x02\x00\nPX 1 1 ff0000\nSIZE\n");
    assert_eq!(told, b"ERR 1 0 EPROTO CONNECT: this port speaks plain text, not TLS\n");
    assert!(serving.memory().bytes().as_chunks::<4>().0.iter().all(|p| *p == [0, 0, 0, 255]));
    let stats = serving.say("STATS\n");
    assert!(stats.contains(" total_errors=37 ") && stats.contains(" total_pixels=0 "), "{stats}");
}

#[test]
fn other_words_at_the_beginning_are_what_they_were() {
    let folder = Folder::new("words");
    let mut serving = Serving::start(8, 8);
    for first in
        ["GETTER 1\n", "gets / HTTP\n", "GET\n", "# GET /\n", "POSTER\n", "SIZED\nGET /\n", "\nPOST /\n"]
    {
        assert!(serving.say(&format!("{first}SIZE\n")).ends_with("SIZE 8 8\n"), "{first}");
    }
    // No browser reaches a Unix socket.
    let socket = folder.join("s");
    serving.server.listen(ListenAddress::Unix(socket.clone())).unwrap();
    let mut stream = UnixStream::connect(&socket).unwrap();
    stream.write_all(b"GET / HTTP/1.1\nSIZE\nQUIT\n").unwrap();
    let mut reply = String::new();
    stream.read_to_string(&mut reply).unwrap();
    assert_eq!(reply, "SIZE 8 8\n");
}

#[test]
fn alpha_over_composes_until_a_client_says_blend_and_is_recorded() {
    let folder = Folder::new("alpha");
    let (recording, end, replay) = (folder.join("r"), folder.join("end.raw"), folder.join("replay.raw"));
    let arguments = [
        "--listen",
        ":0",
        "--size",
        "9x9",
        "--alpha",
        "over",
        "--record",
        text(&recording),
        "--snap",
        text(&end),
    ];
    let mut process = Process::start(&arguments);
    let address = process.address();
    let mut simple = Wire::connect(address);
    simple.send(b"PX 1 1 ffffff80\nPB\x02\x00\x01\x00\xff\xff\xff\x80PX 3 1 ff0000\n");
    assert_eq!(simple.ask("PX 1 1\n"), "PX 1 1 808080\n");
    assert_eq!(simple.ask("PX 2 1\n"), "PX 2 1 808080\n");
    assert_eq!(simple.ask("PX 3 1\n"), "PX 3 1 ff0000\n");
    let mut other = Wire::connect(address);
    other.send(b"BLEND replace\nPX 1 2 ffffff80\n");
    assert_eq!(other.ask("PX 1 2\n"), "PX 1 2 ffffff\n");
    simple.send(b"GET is no request here\n");
    assert_eq!(simple.ask("PX 4 1 00ff0080\nPX 4 1\n"), "PX 4 1 008000\n");
    assert!(Wire::connect(address).talk(REQUEST.as_bytes()).starts_with(b"HTTP/1.1 400 "));
    assert_eq!(process.ends_after("TERM"), Some(0));
    let out = play(&recording, &replay);
    assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
    assert!(
        std::fs::read(&end).unwrap() == std::fs::read(&replay).unwrap(),
        "the recording plays to the same"
    );
}

#[test]
fn one_hex_digit_is_a_grey_where_the_server_says_so() {
    let request =
        b"PX 1 1 f\nPX 1 1\nOFFSET 1 0\nPX 1 1 8\nPX 1 1\nOFFSET 0 0\nPX 3 3 g\nPX 3 3\nPX 3 x 1\nSTATS\n";
    for (arguments, greys, errors) in [
        (&["--listen", ":0", "--grey-digit"][..], ["ffffff", "888888"], 2),
        (&["--listen", ":0"][..], ["000000", "000000"], 4),
    ] {
        let mut process = Process::start(arguments);
        let reply = String::from_utf8(Wire::connect(process.address()).talk(request)).unwrap();
        let want = format!("PX 1 1 {}\nPX 1 1 {}\nPX 3 3 000000\nSTATS ", greys[0], greys[1]);
        assert!(reply.starts_with(&want), "{reply}");
        assert!(reply.contains(&format!(" errors={errors} ")), "{reply}");
    }
}

#[test]
fn pictures_are_taken_by_the_clock_within_their_bound() {
    let folder = Folder::new("snap-every");
    let pictures = folder.join("pictures");
    std::fs::create_dir(&pictures).unwrap();
    std::fs::write(pictures.join("mine.png"), vec![1; 100_000]).unwrap();
    let arguments = [
        "--listen",
        ":0",
        "--size",
        "64x48",
        "--snap-dir",
        text(&pictures),
        "--snap-every",
        "1s",
        "--snap-keep",
        "32K",
    ];
    let mut process = Process::start(&arguments);
    let mut wire = Wire::connect(process.address());
    // Bytes that do not compress: about 12 KB per picture, so that two of them fit.
    let mut state = 1u32;
    let noise: Vec<u8> = (0..64 * 48 * 4)
        .map(|_| {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            (state >> 24) as u8
        })
        .collect();
    wire.send(b"BLIT 0 0 64 48 :12288\n");
    wire.send(&noise);
    let refused = wire.ask("SNAP wall-20260101-000000.png\n");
    assert!(refused.contains(" EPERM SNAP: names like wall-"), "{refused}");
    assert!(wire.ask("SNAP own.png\n").starts_with("SNAP own.png 64 48 "));
    let own = || -> Vec<std::path::PathBuf> {
        let paths = std::fs::read_dir(&pictures).unwrap().map(|entry| entry.unwrap().path());
        let mut own: Vec<_> =
            paths.filter(|p| p.file_name().unwrap().to_str().unwrap().starts_with("wall-2")).collect();
        own.sort();
        own
    };
    let first = wait_for("a picture", || own().first().cloned());
    // A listing may see a picture between its creation and its removal.
    wait_for("the first one to go", || (!first.exists()).then_some(()));
    let newest = wait_for("two pictures", || own().get(1).cloned());
    let picture = image::open(&newest).map(|picture| picture.to_rgba8().into_raw());
    assert!(picture.is_ok_and(|bytes| bytes == noise) || !newest.exists(), "it holds the frame");
    assert_eq!(std::fs::read(pictures.join("mine.png")).unwrap().len(), 100_000);
    assert_eq!(process.ends_after("TERM"), Some(0));
    let bytes: u64 = own().iter().map(|p| std::fs::metadata(p).unwrap().len()).sum();
    assert!((12_000..=32 << 10).contains(&bytes), "{bytes}");
    for arguments in [&["--snap-every", "1s"][..], &["--snap-dir", text(&pictures), "--snap-every", "0s"]] {
        let out = fbptr().args(["serve", "--headless", "--listen", ":0"]).args(arguments).output().unwrap();
        assert_eq!(out.status.code(), Some(2), "{arguments:?}");
    }
}

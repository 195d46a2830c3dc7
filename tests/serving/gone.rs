//! Clients that are gone, or do not read: what only they would receive is not made, and their waits
//! hold no place.

use crate::support::Serving;
use fbptr::server::{Display, DisplayObserver, Engine, Limits};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Time in which a server forgets closed connections; running what they asked for takes minutes.
const SOON: Duration = Duration::from_secs(30);

/// Sends bytes and closes the connection without reading.
fn send_and_close(serving: &Serving, bytes: &[u8]) {
    let mut stream = TcpStream::connect(serving.address).unwrap();
    stream.write_all(bytes).unwrap();
}

/// Returns the number of a key in the reply to `STATS`, or `None` if the client was not admitted.
fn stat(serving: &Serving, key: &str) -> Option<u64> {
    let stats = String::from_utf8(serving.talk(b"STATS\n")).unwrap();
    let key = format!("{key}=");
    stats.split_whitespace().find_map(|word| word.strip_prefix(&key)?.parse().ok())
}

fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let until = Instant::now() + SOON;
    while !is_so() {
        assert!(Instant::now() < until, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn pictures_for_closed_connections_are_not_made_and_drawing_takes_effect() {
    let serving = Serving::start(640, 360);
    // Noise, so that each picture is longer than what is sent at once.
    let mut state = 1u32;
    let noise = (0..640 * 360 * 4).map(|_| {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        (state >> 24) as u8
    });
    let mut blit = b"BLIT 0 0 640 360 :921600\n".to_vec();
    blit.extend(noise);
    blit.extend_from_slice(b"PX 3 4 000000\nSYNC a\n");
    assert_eq!(serving.talk(&blit), b"SYNC a\n");
    let before = stat(&serving, "memory_used").unwrap();
    let request = ["SNAP :\n".repeat(200).as_str(), "PX 3 4 123456\n"].concat();
    for _ in 0..100 {
        send_and_close(&serving, request.as_bytes());
    }
    wait_for("the connections to end", || stat(&serving, "connections").is_some_and(|n| n <= 2));
    wait_for("their memory", || stat(&serving, "memory_used").is_some_and(|n| n <= before + (1 << 20)));
    assert_eq!(serving.say("PX 3 4\n"), "PX 3 4 123456\n");
}

#[test]
fn queries_do_not_run_ahead_of_a_client_that_does_not_read() {
    let serving = Serving::start(64, 64);
    let mut silent = serving.connect();
    // 128 MiB of replies: more than sockets hold, and than a reply queue may.
    let rounds = 8192;
    silent.send("READ 0 0 64 64\n".repeat(rounds).as_bytes());
    let waiting = || stat(&serving, "memory_replies").unwrap();
    wait_for("unread replies", || waiting() >= 100_000);
    for _ in 0..100 {
        let bytes = waiting();
        assert!(bytes < 4 << 20, "{bytes} bytes of replies wait");
        std::thread::sleep(Duration::from_millis(5));
    }
    // Once it reads, all of them are made.
    let mut left = rounds * ("READ 0 0 64 64 :16384\n".len() + 64 * 64 * 4);
    let mut room = vec![0; 1 << 16];
    while left > 0 {
        left -= silent.0.read(&mut room).unwrap();
    }
}

#[test]
fn waits_of_closed_connections_hold_no_place() {
    let limits = Limits { connections: 20, ..Limits::default() };
    let mut engine = Engine::with_limits(8, 8, limits).unwrap();
    engine.attach(DisplayObserver::new(Display::new(8, 8)));
    let serving = Serving::with(engine);
    for _ in 0..20 {
        send_and_close(&serving, b"WAIT 60\n".repeat(10).as_slice());
    }
    wait_for("a place", || serving.talk(b"SIZE\n") == b"SIZE 8 8\n");
    wait_for("half of the places", || stat(&serving, "connections").is_some_and(|n| n <= 11));
}

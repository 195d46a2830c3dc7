//! Nothing is lost or broken by odd writes, cuts, resets, or clients that do not read.

use crate::support::{Numbers, Serving, Wire};
use fbptr::command::EndOfInput;
use fbptr::server::{Audience, Budget, Engine, Output, Stream};
use std::io::{Read, Write};
use std::time::{Duration, Instant};

/// Returns a stream with every kind of framing.
fn mixed_stream() -> Vec<u8> {
    let mut s =
        b"PX 1 1 ff0000\r\n# a comment\n\nOFFSET 2 1\nPX 3 3 00ff00\nPB\x09\x00\x05\x00\n\nPB".to_vec();
    s.extend_from_slice(
        b"PXMULTI\x1e\x00\x02\x00\x03\x00\x00\x00\nPX 0 0 ff\nBLIT 4 4 2 2 :16\nLINE 0 0 9 9\nabc",
    );
    s.extend_from_slice(b"TEXT 2 9 ffff00 :5\nP\nB:9LINE 0 0 31 15 0000ff ff0000\nNOPE :7\nPX 1 1 POINTS :8\n\x05\x00\x06\x00qrst");
    s.extend_from_slice(
        b"BLEND over\nPX 5 5 ffffff40\nFILL 3 3 20 4 9 14.5 ff0000 00ff00 0000ff\nCRC\nPX 7 7\n",
    );
    s
}

fn engine_answers(pieces: &[&[u8]]) -> (Vec<u8>, Vec<u8>) {
    let mut engine = Engine::new(32, 16).unwrap();
    let mut stream = Stream::new(&engine, 1, Audience::Connection);
    let mut out = Output::default();
    for piece in pieces {
        let _ = stream.feed(&mut engine, piece, &mut out, Budget::NONE);
    }
    let _ = stream.finish(&mut engine, EndOfInput::Stream, &mut out);
    (engine.memory().bytes().to_vec(), out.replies)
}

#[test]
fn every_split_point_gives_the_same_memory_and_replies() {
    let stream = mixed_stream();
    let whole = engine_answers(&[&stream]);
    assert!(whole.1.starts_with(b"ERR ") && whole.1.windows(4).any(|w| w == b"CRC "));
    for cut in 0..=stream.len() {
        let (a, b) = stream.split_at(cut);
        assert!(engine_answers(&[a, b]) == whole, "cut at {cut}");
        for second in cut..stream.len().min(cut + 40) {
            let (b, c) = b.split_at(second - cut);
            assert!(engine_answers(&[a, b, c]) == whole, "cut at {cut} and {second}");
        }
    }
}

#[test]
fn every_split_point_over_a_socket() {
    let stream = mixed_stream();
    let (memory, replies) = engine_answers(&[&stream]);
    let serving = Serving::start(32, 16);
    for cut in (0..=stream.len()).step_by(3) {
        let mut wire = serving.connect();
        wire.send(b"CLEAR 000000ff\n");
        assert_eq!(wire.ask("SYNC x\n"), "SYNC x\n");
        drop(wire);
        let mut wire = serving.connect();
        wire.send(&stream[..cut]);
        std::thread::sleep(Duration::from_micros(300));
        wire.send(&stream[cut..]);
        assert_eq!(wire.rest(), replies, "cut at {cut}");
        assert!(serving.memory().bytes() == memory, "cut at {cut}");
    }
}

/// Returns 200,000 different pixels in a shuffled order.
fn pixels() -> Vec<(u16, u16, [u8; 4])> {
    let mut numbers = Numbers(0x1234_5678);
    let mut all: Vec<(u16, u16, [u8; 4])> = (0..200_000u32)
        .map(|i| ((i % 500) as u16, (i / 500) as u16, [(i >> 16) as u8 + 1, (i >> 8) as u8, i as u8, 255]))
        .collect();
    for i in (1..all.len()).rev() {
        all.swap(i, numbers.below(i as u32 + 1) as usize);
    }
    all
}

fn send_in_writes_of(serving: &Serving, bytes: &[u8], size: usize) {
    let mut wire = serving.connect();
    for piece in bytes.chunks(size) {
        wire.send(piece);
    }
    assert_eq!(wire.ask("SYNC done\n"), "SYNC done\n");
}

fn assert_all_there(serving: &Serving) {
    let memory = serving.memory();
    let mut lost = 0;
    for (x, y, color) in pixels() {
        lost += usize::from(memory.get_pixel(x.into(), y.into()).unwrap() != color);
    }
    let stray =
        memory.bytes().as_chunks::<4>().0[500 * 400..].iter().filter(|p| **p != [0, 0, 0, 255]).count();
    assert_eq!((lost, stray), (0, 0), "pixels lost, and stray ones");
}

#[test]
fn two_hundred_thousand_binary_pixels_in_writes_of_1448_bytes() {
    let serving = Serving::start(500, 420);
    let mut bytes = Vec::new();
    for (x, y, color) in pixels() {
        bytes.extend_from_slice(b"PB");
        bytes.extend_from_slice(&x.to_le_bytes());
        bytes.extend_from_slice(&y.to_le_bytes());
        bytes.extend_from_slice(&color);
    }
    send_in_writes_of(&serving, &bytes, 1448);
    assert_all_there(&serving);
}

#[test]
fn two_hundred_thousand_text_pixels_in_writes_of_7_bytes() {
    let serving = Serving::start(500, 420);
    let mut bytes = Vec::new();
    for (x, y, [r, g, b, _]) in pixels() {
        writeln!(bytes, "PX {x} {y} {r:02x}{g:02x}{b:02x}").unwrap();
    }
    send_in_writes_of(&serving, &bytes, 7);
    assert_all_there(&serving);
}

#[test]
fn a_client_that_dies_in_the_middle_leaves_no_trace_of_it() {
    let serving = Serving::start(32, 16);
    let before = serving.memory();
    let commands: [&[u8]; 5] = [
        b"PX 1 1 ff0000\n",
        b"PB\x01\x00\x01\x00abcd",
        b"PXMULTI\x01\x00\x01\x00\x02\x00\x00\x0012345678",
        b"BLIT 0 0 2 2 :16\n0123456789abcdef",
        b"LINE 0 0 31 15 ffffff\n",
    ];
    for command in commands {
        for cut in 1..command.len() {
            let mut wire = serving.connect();
            wire.send(&command[..cut]);
            if cut % 2 == 0 {
                wire.reset();
            }
        }
    }
    // All of them have ended when a new client is answered and is the only one.
    let until = Instant::now() + Duration::from_secs(10);
    while !serving.say("STATS\n").contains(" connections=1 ") {
        assert!(Instant::now() < until, "connections are left over");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(serving.memory().bytes() == before.bytes());
}

#[test]
fn a_client_that_never_reads_stalls_itself_alone() {
    let limits = fbptr::server::Limits { reply_bytes: 100_000, ..Default::default() };
    let serving = Serving::limited(64, 64, limits);
    let mut mute = serving.connect();
    mute.0.set_write_timeout(Some(Duration::from_millis(300))).unwrap();
    // A hundred thousand replies of 16 kilobytes, of which the client reads no byte.
    let request = "READ 0 0 64 64\n".repeat(1000);
    let mut sent = 0;
    while sent < 100 {
        match mute.0.write_all(request.as_bytes()) {
            Ok(()) => sent += 1,
            // The server stops reading this client.
            Err(_) => break,
        }
    }
    let mut other = serving.connect();
    for i in 0..200 {
        let begun = Instant::now();
        assert_eq!(other.ask(&format!("PX 1 1 {i:06x}\nPX 1 1\n")), format!("PX 1 1 {i:06x}\n"));
        assert!(begun.elapsed() < Duration::from_secs(2), "another client waited {:?}", begun.elapsed());
    }
    // Once the client reads, all replies arrive, in order.
    let want = "READ 0 0 64 64 :16384\n".len() + 16384;
    let mut reply = vec![0; want];
    for i in 0..500 {
        mute.0.read_exact(&mut reply).unwrap();
        assert!(reply.starts_with(b"READ 0 0 64 64 :16384\n"), "reply {i}");
    }
}

#[test]
fn a_slow_trickle_is_a_command_in_the_end() {
    let serving = Serving::start(8, 8);
    let mut slow = serving.connect();
    for byte in b"PX 3 3 abcdef\nSYNC a\n" {
        slow.send(&[*byte]);
        std::thread::sleep(Duration::from_millis(2));
    }
    assert_eq!(slow.line(), "SYNC a\n");
    assert_eq!(serving.say("PX 3 3\n"), "PX 3 3 abcdef\n");
}

#[test]
fn random_bytes_neither_stop_nor_crash_the_server() {
    let serving = Serving::start(32, 16);
    let mut numbers = Numbers(99);
    for round in 0..60 {
        let length = numbers.below(5000) as usize;
        let alphabet: &[u8] = match round % 3 {
            0 => b"PXB 0123456789\n:abcdef",
            1 => b"PXMULTI\x00\x01\x02\nLINE :9",
            _ => b"",
        };
        let noise: Vec<u8> = (0..length)
            .map(|_| match alphabet {
                b"" => numbers.below(256) as u8,
                letters => letters[numbers.below(letters.len() as u32) as usize],
            })
            .collect();
        let mut wire = serving.connect();
        // The server may disconnect in the middle: a length beyond 64 bits ends a stream.
        let _ = wire.0.write_all(&noise);
        if round % 2 == 0 {
            wire.reset();
        }
    }
    let mut wire = Wire::connect(serving.address);
    assert_eq!(wire.ask("SYNC alive\n"), "SYNC alive\n");
}

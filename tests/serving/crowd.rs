//! Many connections at once, each with its own state.

use crate::support::{Serving, Wire};
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

#[test]
fn fifty_connections_at_once_keep_their_own_states() {
    let serving = Serving::start(500, 100);
    let address = serving.address;
    let draw = move |i: i32| {
        let mut wire = Wire::connect(address);
        wire.send(format!("OFFSET {} {}\n", i % 10 * 50, i / 10 * 20).as_bytes());
        if i % 2 == 0 {
            wire.send(b"BLEND over\n");
        }
        wire.send(
            format!("MESH m {}\nTRANSLATE {i} 0 0\n", if i % 3 == 0 { "BOX" } else { "SPHERE" }).as_bytes(),
        );
        for y in 0..20 {
            for x in 0..50 {
                wire.send(format!("PX {x} {y} {i:02x}ffff80\n").as_bytes());
            }
            assert_eq!(wire.ask(&format!("SYNC {i}.{y}\n")), format!("SYNC {i}.{y}\n"));
        }
        assert_eq!(wire.ask("FREE m\nFREE m\n").split(' ').nth(3), Some("ENOENT"), "one m each");
    };
    let clients: Vec<_> = (0..50).map(|i| std::thread::spawn(move || draw(i))).collect();
    clients.into_iter().for_each(|c| c.join().unwrap());
    let memory = serving.memory();
    for i in 0..50 {
        let (x, y) = (i % 10 * 50, i / 10 * 20);
        let over = |s: i32| ((s * 128 + 127) / 255) as u8;
        let want = match i % 2 == 0 {
            true => [over(i), over(255), over(255), 255],
            false => [i as u8, 255, 255, 128],
        };
        for (dx, dy) in [(0, 0), (49, 0), (0, 19), (49, 19), (25, 10)] {
            assert_eq!(memory.get_pixel(x + dx, y + dy).unwrap(), want, "client {i} at ({dx},{dy})");
        }
    }
}

#[test]
fn names_are_private_but_for_those_with_an_at_sign() {
    let serving = Serving::start(32, 16);
    let mut one = serving.connect();
    let mut two = serving.connect();
    assert_eq!(one.ask("MESH m BOX\nMESH @s SPHERE\nSYNC a\n"), "SYNC a\n");
    assert!(two.ask("LIGHT 0 DIR 0 0 -1 1 1 1\nDRAW m\n").contains("ENOENT DRAW"));
    assert_eq!(two.ask("DRAW @s\nSYNC b\n"), "SYNC b\n");
    drop(one);
    assert_eq!(two.ask("CLEAR\nDRAW @s\nSYNC c\n"), "SYNC c\n", "shared names stay");
    assert_eq!(serving.say("CLEAR\nLIGHT 0 DIR 0 0 -1 1 1 1\nDRAW @s\nFREE @s\nSYNC d\n"), "SYNC d\n");
    assert!(two.ask("DRAW @s\n").contains("ENOENT DRAW"));
}

#[test]
fn what_a_connection_had_is_freed_with_it() {
    let serving = Serving::start(32, 16);
    for _ in 0..20 {
        serving.say("MESH a TEAPOT 30\nMESH b KNOT 300 40\nLIGHT 0 DIR 0 0 -1 1 1 1\nPUSH\nPUSH\n");
    }
    let mut wire = serving.connect();
    let stats = wire.ask("HELLO\nSTATS\n") + &wire.line();
    assert!(stats.contains(" names=0 resource_bytes=0 shared_names=0 "), "{stats}");
}

#[test]
fn none_waits_long_for_a_sync_while_others_flood() {
    let serving = Serving::start(640, 480);
    let address = serving.address;
    let until = Instant::now() + Duration::from_millis(1500);
    let flood = move |i: usize| {
        let mut wire = Wire::connect(address);
        let bytes: Vec<u8> = match i % 2 {
            0 => {
                (0..4000).flat_map(|n| format!("PX {} {} ff00ff\n", n % 640, n % 480).into_bytes()).collect()
            }
            // Costly commands: a slice of these is bounded by time, not by bytes.
            _ => b"FILLRECT 0 0 640 480 00ff00\n".repeat(400),
        };
        // The server stops reading a flood of costly commands, so a write may well time out.
        wire.0.set_write_timeout(Some(Duration::from_millis(50))).unwrap();
        while Instant::now() < until {
            let _ = wire.0.write_all(&bytes);
        }
        wire.reset();
    };
    let floods: Vec<_> = (0..8).map(|i| std::thread::spawn(move || flood(i))).collect();
    let mut wire = serving.connect();
    let (mut waits, mut count) = (Duration::ZERO, 0);
    while Instant::now() < until {
        let begun = Instant::now();
        assert_eq!(wire.ask("SYNC me\n"), "SYNC me\n");
        waits += begun.elapsed();
        count += 1;
    }
    floods.into_iter().for_each(|f| f.join().unwrap());
    // Eight slices of two milliseconds lie between two replies; the rest is for a busy machine and
    // a slow profile.
    assert!(count > 5 && waits / count < Duration::from_millis(250), "{count} syncs took {waits:?}");
}

#[test]
fn connections_come_and_go_without_a_leak() {
    let serving = Serving::start(64, 64);
    let crowd = |count: usize| {
        for i in 0..count {
            let mut wire = serving.connect();
            match i % 4 {
                0 => {}
                1 => wire.send(b"PX 1 1 ff0000\nLINE 0 0"),
                2 => wire.send(b"BLIT 0 0 1000 1000 :4000000\nhalf"),
                _ => assert_eq!(wire.ask("SYNC a\n"), "SYNC a\n"),
            }
            if i % 8 == 2 {
                wire.reset();
            }
        }
        let until = Instant::now() + Duration::from_secs(10);
        while !serving.say("STATS\n").contains(" connections=1 ") {
            assert!(Instant::now() < until, "connections are left over: {}", serving.say("STATS\n"));
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    crowd(300);
    let threads = thread_count();
    crowd(900);
    if let (Some(before), Some(after)) = (threads, thread_count()) {
        // Other tests of this program run at the same time.
        assert!(after < before + 200, "{before} threads before 900 connections, {after} after");
    }
}

/// Returns the number of threads of this process, if the system tells it.
fn thread_count() -> Option<usize> {
    std::fs::read_dir("/proc/self/task").ok().map(|tasks| tasks.count())
}

#[test]
fn large_payloads_of_many_at_once_are_whole_and_one_that_stops_holds_nobody_up() {
    const WIDTH: u32 = 2048;
    const ROWS: u32 = 256;
    const SENDERS: u32 = 8;
    const FRAMES: u8 = 4;
    let serving = Serving::start(WIDTH, ROWS * (SENDERS + 2));
    let bytes = (WIDTH * ROWS * 4) as usize;
    let head = |i: u32| format!("BLIT 0 {} {WIDTH} {ROWS} :{bytes}\n", i * ROWS).into_bytes();
    // One client stops within its payload, one disconnects there.
    let (mut stopped, mut dying) = (serving.connect(), serving.connect());
    stopped.send(&[head(SENDERS), vec![99; bytes / 4 * 3]].concat());
    dying.send(&[head(SENDERS + 1), vec![98; bytes / 4 * 3]].concat());
    std::thread::scope(|scope| {
        for i in 0..SENDERS {
            let mut wire = serving.connect();
            scope.spawn(move || {
                for frame in 1..=FRAMES {
                    wire.send(&[head(i), vec![10 * frame + i as u8; bytes]].concat());
                }
                assert_eq!(wire.ask("SYNC all\n"), "SYNC all\n");
            });
        }
        let mut small = serving.connect();
        for _ in 0..50 {
            assert_eq!(small.ask("PX 0 0 00\nSYNC a\n"), "SYNC a\n");
        }
    });
    let row_of = |memory: &fbptr::memory::VideoMemory, i: u32| {
        let band = WIDTH as usize * ROWS as usize * 4;
        let bytes = &memory.bytes()[i as usize * band..][..band];
        assert!(bytes[8..].chunks(4).all(|p| p == &bytes[4..8]), "band {i} is of one piece");
        bytes[4]
    };
    let memory = serving.memory();
    for i in 0..SENDERS {
        assert_eq!(row_of(&memory, i), 10 * FRAMES + i as u8);
    }
    assert_eq!(
        (row_of(&memory, SENDERS), row_of(&memory, SENDERS + 1)),
        (0, 0),
        "nothing of what is not whole"
    );
    dying.reset();
    stopped.send(&vec![99; bytes - bytes / 4 * 3]);
    assert_eq!(stopped.ask("SYNC b\n"), "SYNC b\n");
    let memory = serving.memory();
    assert_eq!((row_of(&memory, SENDERS), row_of(&memory, SENDERS + 1)), (99, 0));
}

#[test]
fn a_large_payload_goes_on_beside_a_client_that_needs_no_socket() {
    const SIDE: u32 = 640;
    const FRAMES: u8 = 160;
    /// Ends the flood on drop, even if the test fails.
    struct Stop<'a>(&'a AtomicBool);
    impl Drop for Stop<'_> {
        fn drop(&mut self) {
            self.0.store(true, Ordering::Relaxed);
        }
    }
    const BELOW: u32 = 256;
    // It depends on timing that the socket waits in the queue when the flood begins: every other
    // run fails on a server that never passes the socket to a reader thread.
    let serving = Serving::start(SIDE, SIDE + BELOW);
    let client = serving.server.client();
    let (is_over, is_flooding) = (AtomicBool::new(false), AtomicBool::new(false));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_over.load(Ordering::Relaxed) {
                match is_flooding.load(Ordering::Relaxed) {
                    // Each takes longer to draw than to send, so that some are always queued.
                    true => client.fill_rect([0, SIDE as i32, SIDE as i32, BELOW as i32], [1, 2, 3, 255]),
                    false => std::thread::yield_now(),
                }
            }
        });
        let _stop = Stop(&is_over);
        let mut wire = serving.connect();
        let bytes = (SIDE * SIDE * 4) as usize;
        for frame in 1..=FRAMES {
            let head = format!("BLIT 0 0 {SIDE} {SIDE} :{bytes}\n").into_bytes();
            // The render thread is idle and reads this part itself, until the flood gives it other
            // work at some point of the payload.
            let (first, rest) = (usize::from(frame) * bytes / usize::from(FRAMES + 1), vec![frame; bytes]);
            wire.send(&[&head, &rest[..first]].concat());
            is_flooding.store(true, Ordering::Relaxed);
            wire.send(&rest[first..]);
            assert_eq!(wire.ask("SYNC frame\n"), "SYNC frame\n");
            is_flooding.store(false, Ordering::Relaxed);
        }
    });
    let memory = serving.memory();
    assert!(memory.bytes()[..(SIDE * SIDE * 4) as usize].iter().all(|&b| b == FRAMES));
}

#[test]
fn a_client_that_sends_no_more_and_reads_late_gets_all_of_a_long_reply() {
    let serving = Serving::start(1920, 1080);
    let bytes = 1920 * 1080 * 4;
    let mut wire = serving.connect();
    wire.send(b"READ 0 0 1920 1080\n".repeat(4).as_slice());
    wire.0.shutdown(std::net::Shutdown::Write).unwrap();
    // The writer waits for space by then, and nothing more is read of this client.
    std::thread::sleep(Duration::from_millis(300));
    let mut all = Vec::new();
    std::io::Read::read_to_end(&mut wire.0, &mut all).unwrap();
    assert_eq!(all.len(), 4 * (format!("READ 0 0 1920 1080 :{bytes}\n").len() + bytes));
}

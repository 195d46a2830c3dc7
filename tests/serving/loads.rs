//! Loads that reveal leaks and stalls, on a server in its own process, so that memory and processor
//! time are the server's alone.
//!
//! The counts are a tenth of the full ones unless `FBPTR_LOADS=full` is set.
#![cfg(target_os = "linux")]

use crate::process::Process;
use crate::support::Wire;
use std::io::Write;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

/// Returns the full count, or a tenth of it.
fn count(full: usize) -> usize {
    let is_full = std::env::var("FBPTR_LOADS").is_ok_and(|v| v == "full");
    if is_full { full } else { full / 10 }
}

/// Returns the resident memory of a process in kilobytes.
fn resident(process: &Process) -> usize {
    let status = std::fs::read_to_string(format!("/proc/{}/status", process.id())).unwrap();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

/// Returns the resident memory once it shrinks no further: pages are freed with a delay.
fn settled(process: &Process) -> usize {
    let mut least = resident(process);
    for _ in 0..10 {
        std::thread::sleep(Duration::from_millis(50));
        least = least.min(resident(process));
    }
    least
}

/// Returns the processor time of a process in hundredths of a second.
fn processor_ticks(process: &Process) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", process.id())).unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    fields[11].parse::<u64>().unwrap() + fields[12].parse::<u64>().unwrap()
}

/// Waits until the asking connection is the only one.
fn all_gone(address: SocketAddr) {
    let until = Instant::now() + Duration::from_secs(30);
    loop {
        let stats = String::from_utf8(Wire::connect(address).talk(b"STATS\n")).unwrap();
        if stats.contains(" connections=1 ") {
            return;
        }
        assert!(Instant::now() < until, "connections are left over: {stats}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Opens connections of every kind, one after the other; returns the longest wait for a reply.
fn crowd(address: SocketAddr, count: usize) -> Duration {
    let half_a_payload = [b"CRC\nBLIT 0 0 500 500 :1000000\n".as_slice(), &[7; 20_000]].concat();
    let mut longest = Duration::ZERO;
    for i in 0..count {
        let mut wire = Wire::connect(address);
        match i % 8 {
            0 => {}
            1 => wire.send(b"PX 1 1 ff0000\nLINE 0 0"),
            2 | 3 => {
                // Closed with a reply unread: the system sends a reset for bytes that still arrive.
                wire.send(&half_a_payload);
                if i % 64 == 2 {
                    std::thread::sleep(Duration::from_millis(1));
                }
                wire.reset();
            }
            4 => wire.send(b"MESH m KNOT 40 10\nTEXT 1 1 white :5\nhelloQUIT\n"),
            5 => drop(wire.rest()),
            _ => {
                let begun = Instant::now();
                assert_eq!(wire.ask("PX 2 2 00ff00\nSYNC a\n"), "SYNC a\n");
                longest = longest.max(begun.elapsed());
            }
        }
    }
    all_gone(address);
    longest
}

/// Verifies that a process holds at most a twentieth more than before, within ten seconds: pages
/// are freed with a delay.
fn assert_memory_is_back(process: &Process, before: usize) {
    let until = Instant::now() + Duration::from_secs(10);
    while resident(process) > before + before / 20 {
        assert!(Instant::now() < until, "{before} kB before, {} kB after", resident(process));
        std::thread::sleep(Duration::from_millis(50));
    }
    println!("{before} kB before, {} kB after", resident(process));
}

#[test]
fn ten_thousand_connections_leave_nothing_behind() {
    let mut process = Process::start(&["--listen", ":0", "--size", "640x480"]);
    let address = process.address();
    // The first connections allocate what stays: the allocator's arenas, the threads' stacks.
    crowd(address, 400);
    let (count, begun) = (count(10_000), Instant::now());
    let mut held = vec![resident(&process)];
    // A leak grows in each round; an arena that the allocator adds because threads happened to
    // collide grows in one.
    for _ in 0..3 {
        let longest = crowd(address, count / 2);
        assert!(longest < Duration::from_secs(2), "a reply took {longest:?}");
        held.push(settled(&process));
    }
    println!("{} connections in {:?}, kB held after each round: {held:?}", 3 * (count / 2), begun.elapsed());
    let least = held.windows(2).map(|w| w[1].saturating_sub(w[0])).min().unwrap();
    let each = least * 1024 / (count / 2);
    assert!(each <= 128, "each connection leaves {each} bytes: {held:?} kB");
    let back = held[1..].iter().min().unwrap();
    assert!(*back <= held[0] + held[0] / 20, "it never comes back to within a twentieth: {held:?} kB");
    assert_eq!(process.ends_after("TERM"), Some(0));
}

#[test]
fn a_hundred_thousand_replies_that_nobody_reads_are_held_and_let_go() {
    let mut process = Process::start(&["--listen", ":0", "--size", "640x480", "--max-replies", "4000000"]);
    let address = process.address();
    let mute_round = |replies: usize| {
        let mut mute = Wire::connect(address);
        mute.0.set_write_timeout(Some(Duration::from_millis(200))).unwrap();
        for _ in 0..replies / 100 {
            // The server stops reading this client: its commands wait.
            if mute.0.write_all(&b"READ 0 0 20 20\n".repeat(100)).is_err() {
                break;
            }
        }
        let mut other = Wire::connect(address);
        for i in 0..50 {
            let begun = Instant::now();
            assert_eq!(other.ask(&format!("SYNC {i}\n")), format!("SYNC {i}\n"));
            assert!(begun.elapsed() < Duration::from_secs(2), "another client waited {:?}", begun.elapsed());
        }
        drop((mute, other));
        all_gone(address);
    };
    mute_round(count(100_000));
    let before = resident(&process);
    for _ in 0..3 {
        mute_round(count(100_000));
    }
    assert_memory_is_back(&process, before);
    assert_eq!(process.ends_after("TERM"), Some(0));
}

#[test]
fn an_idle_server_takes_no_processor_time() {
    let mut process = Process::start(&["--listen", ":0"]);
    let address = process.address();
    let mut wires: Vec<Wire> = (0..50).map(|_| Wire::connect(address)).collect();
    for wire in &mut wires {
        assert_eq!(wire.ask("PX 1 1 ff0000\nSYNC a\n"), "SYNC a\n");
    }
    std::thread::sleep(Duration::from_millis(1500));
    let (before, seconds) = (processor_ticks(&process), count(100) as u64 / 5);
    std::thread::sleep(Duration::from_secs(seconds));
    let used = processor_ticks(&process) - before;
    println!("{used} of {} hundredths of a second while idle", seconds * 100);
    assert!(used <= seconds, "{used} hundredths of a second of processor in {seconds} idle seconds");
    assert_eq!(process.ends_after("TERM"), Some(0));
}

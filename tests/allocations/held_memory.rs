//! The bytes that the memory budget counts for objects of connections, against the allocator's.
//!
//! Guards against objects whose pixels are counted and whose small blocks are not: a thousand small
//! ones would take ten times what is counted.

use crate::TURN;
use crate::counting::HELD;
use fbptr::server::{Audience, Budget, Engine, Limits, Notice, Output, Stream};
use std::sync::PoisonError;
use std::sync::atomic::Ordering::Relaxed;

/// Number of objects: the default limit of a connection's canvases.
const OBJECTS: usize = 4096;

/// Returns the bytes that are counted and those that are held for the objects that `command` makes.
fn counted_and_held(before: &str, command: impl Fn(usize) -> String) -> [f64; 2] {
    let limits = Limits { memory_bytes: 1 << 30, ..Limits::default() };
    let mut engine = Engine::with_limits(16, 16, limits).expect("a small frame");
    let mut stream = Stream::new(&engine, 1, Audience::Owner);
    let mut run = |engine: &mut Engine, commands: &str| {
        let mut out = Output::default();
        let (used, _) = stream.feed(engine, commands.as_bytes(), &mut out, Budget::NONE);
        assert_eq!(used, commands.len());
        let refused = out.notices.iter().find(|notice| matches!(notice, Notice::Refused(_)));
        assert!(refused.is_none(), "{refused:?}");
    };
    // What the renderer keeps for any draw is made by a draw on the frame.
    run(&mut engine, before);
    let idle = (engine.memory_budget().used(), HELD.load(Relaxed));
    (0..OBJECTS).for_each(|i| run(&mut engine, &command(i)));
    let counted = engine.memory_budget().used() - idle.0;
    [counted as f64, (HELD.load(Relaxed) - idle.1) as f64]
}

#[test]
fn canvases_are_counted_with_their_small_blocks() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let mesh = "MESH m BOX 1 1 1\nDRAW m\n";
    let cases: [(&str, [u32; 2], &str); 4] = [
        ("a pixel", [1, 1], ""),
        ("a pixel with a draw", [1, 1], "DRAW m\n"),
        ("a small one with a draw", [20, 10], "DRAW m\n"),
        ("a row with a draw by painter", [64, 1], "HIDE painter\nDRAW m\nHIDE zbuffer\n"),
    ];
    for (what, [w, h], draw) in cases {
        let one = |i: usize| format!("CANVAS c{i} {w} {h}\nTARGET c{i}\n{draw}");
        let [counted, held] = counted_and_held(mesh, one);
        println!("{what}: {counted} bytes counted, {held} held, {:.2}", held / counted);
        assert!(
            held < 1.35 * counted && counted < 1.35 * held,
            "{what}: {counted} bytes counted, {held} held, {:.2}",
            held / counted
        );
    }
}

/// Returns the bytes of the process that are resident.
#[cfg(target_os = "linux")]
fn resident() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").expect("Linux has it");
    let pages: u64 = statm.split(' ').nth(1).and_then(|word| word.parse().ok()).expect("a number");
    pages * 4096
}

#[test]
#[cfg(target_os = "linux")]
fn a_large_canvas_touches_none_of_its_pixels_when_it_is_made() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let mut engine = Engine::new(16, 16).expect("a small frame");
    let mut stream = Stream::new(&engine, 1, Audience::Owner);
    let mut run = |commands: &str| {
        let mut out = Output::default();
        let (used, _) = stream.feed(&mut engine, commands.as_bytes(), &mut out, Budget::NONE);
        assert_eq!(used, commands.len());
        out.replies
    };
    let before = resident();
    // 400 MB, of which one pixel is read.
    let pixel = run("CANVAS k 10000 10000\nTARGET k\nREAD 9999 9999 1 1\n");
    assert!(pixel.ends_with(&[0; 4]), "{pixel:?}");
    let more = resident().saturating_sub(before);
    assert!(more < 20 << 20, "{more} bytes are resident");
}

//! The bytes that the memory budget counts for objects of connections, against the allocator's.
//!
//! Guards against objects whose pixels are counted and whose small blocks are not: a thousand small
//! ones would take ten times what is counted.

use crate::TURN;
use crate::counting::HELD;
use fbptr::command::{ParameterKind, Verb};
use fbptr::server::{Audience, Budget, Engine, Limits, Notice, Output, Stream};
use std::sync::PoisonError;
use std::sync::atomic::Ordering::Relaxed;
#[cfg(target_os = "linux")]
use std::time::{Duration, Instant};

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

/// A kind of object: what is sent before all of them, and the commands that make number `i`.
struct Kind {
    what: &'static str,
    before: &'static str,
    one: fn(usize) -> String,
}

fn with_payload(head: String, payload: &str) -> String {
    format!("{head} :{}\n{payload}\n", payload.len())
}

const MESH: &str = "MESH m BOX 1 1 1\nDRAW m\n";
const WORLD: &str = r#"{"dim":2,"pixels":[4],"d":1,"S":[1],"I_d":0.5,"facets":[{"v":[[2,-3],[2,0.01]],"color":[250,100,50]}]}"#;
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// Objects of every verb that makes some, the smallest of their kind and larger ones.
const KINDS: [Kind; 14] = [
    Kind { what: "CANVAS of a pixel", before: MESH, one: |i| format!("CANVAS c{i} 1 1\n") },
    Kind {
        what: "CANVAS of a pixel with a draw",
        before: MESH,
        one: |i| format!("CANVAS c{i} 1 1\nTARGET c{i}\nDRAW m\n"),
    },
    Kind {
        what: "CANVAS, a small one with a draw",
        before: MESH,
        one: |i| format!("CANVAS c{i} 20 10\nTARGET c{i}\nDRAW m\n"),
    },
    Kind {
        what: "CANVAS of a row with a draw by painter",
        before: MESH,
        one: |i| format!("CANVAS c{i} 64 1\nTARGET c{i}\nHIDE painter\nDRAW m\nHIDE zbuffer\n"),
    },
    Kind {
        what: "CANVAS with narrow depths",
        before: "MESH m BOX 1 1 1\nDRAW m\nDEPTH u16\nDRAW m\n",
        one: |i| format!("CANVAS c{i} 20 10\nTARGET c{i}\nDEPTH u16\nDRAW m\n"),
    },
    Kind { what: "MESH BOX", before: "", one: |i| format!("MESH m{i} BOX 1 1 1\n") },
    Kind { what: "MESH of a knot", before: "", one: |i| format!("MESH m{i} KNOT 3 3\n") },
    Kind {
        what: "MESH OBJ of a triangle",
        before: "",
        one: |i| with_payload(format!("MESH m{i} OBJ"), TRIANGLE),
    },
    Kind {
        what: "MESH OBJ of nothing",
        before: "",
        one: |i| with_payload(format!("MESH m{i} OBJ"), "v 0 0 0\n"),
    },
    Kind {
        what: "MESH with a long name",
        before: "",
        one: |i| with_payload(format!("MESH {}{i} OBJ", "m".repeat(200)), TRIANGLE),
    },
    Kind {
        what: "TEX of a pixel",
        before: "",
        one: |i| with_payload(format!("TEX t{i}"), "P6 1 1 255\nabc"),
    },
    Kind {
        what: "TEX of 8 by 8 pixels",
        before: "",
        one: |i| with_payload(format!("TEX t{i}"), &format!("P5 8 8 255\n{}", "a".repeat(64))),
    },
    Kind { what: "EYE", before: "", one: |i| with_payload(format!("EYE e{i}"), WORLD) },
    Kind {
        what: "EYE with a picture",
        before: "",
        one: |i| with_payload(format!("EYE e{i}"), WORLD) + &format!("DRAWEYE e{i} 0 0 4 4\n"),
    },
];

#[test]
fn objects_of_every_kind_are_counted_with_their_small_blocks() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let mut wrong = Vec::new();
    for Kind { what, before, one } in KINDS {
        let [counted, held] = counted_and_held(before, one);
        println!("{what}: {counted} bytes counted, {held} held, {:.2}", held / counted);
        if !(held < 1.35 * counted && counted < 1.35 * held) {
            wrong.push(format!("{what}: {counted} bytes counted, {held} held, {:.2}", held / counted));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Verbs that give a name to nothing of their own: they use, load (as `MESH`, `TEX` and `SCENE` do) or
/// forget. The scene of a connection is one object, not one for each name.
const OTHERS: [&str; 10] =
    ["TEXTURE", "SNAP", "HELP", "FREE", "LOAD", "DRAW", "DRAWEYE", "STAMP", "TARGET", "SYNC"];

#[test]
fn every_verb_that_takes_a_name_is_among_the_kinds_or_makes_nothing() {
    let takes_name = |verb: &&Verb| verb.parameters.iter().any(|p| p.kind == ParameterKind::Name);
    for verb in Verb::all().iter().filter(takes_name) {
        let makes = KINDS.iter().any(|kind| kind.what.split(' ').next() == Some(verb.name));
        assert!(makes != OTHERS.contains(&verb.name), "{}: are its objects counted?", verb.name);
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
    let held = HELD.load(Relaxed);
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
    drop((stream, engine));
    // A thread of its own frees the canvas: the next test must not count that.
    let until = Instant::now() + Duration::from_secs(60);
    while HELD.load(Relaxed) > held + (1 << 20) && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// The numbers of the faces that PICK asks for.
#[test]
fn faces_are_numbered_only_where_depth_says_which_one_is_seen() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let pixels = 1200 * 900;
    let mut engine = Engine::new(1200, 900).expect("a frame");
    let mut stream = Stream::new(&engine, 1, Audience::Owner);
    let mut growth = |commands: &str| {
        let before = [engine.memory_budget().used() as isize, HELD.load(Relaxed)];
        let mut out = Output::default();
        let (used, _) = stream.feed(&mut engine, commands.as_bytes(), &mut out, Budget::NONE);
        assert_eq!(used, commands.len());
        [engine.memory_budget().used() as isize - before[0], HELD.load(Relaxed) - before[1]]
    };
    for hide in ["none", "painter"] {
        let [counted, held] = growth(&format!("MESH m BOX\nLOOKAT 2 3 4 0 0 0 0 1 0\nHIDE {hide}\nDRAW m\n"));
        assert!(counted < pixels && held < pixels, "HIDE {hide}: {counted} bytes counted, {held} held");
    }
    let [counted, held] = growth("HIDE zbuffer\nDRAW m\n");
    // Depths of 4 bytes, and numbers of 8; the renderer holds lists of its own besides.
    assert!((12 * pixels..13 * pixels).contains(&counted) && held > 12 * pixels, "{counted}, {held} held");
    let [counted, held] = growth("DRAW m\nPICK 600 450\nDRAW m\n");
    assert!(counted < pixels && held < pixels, "{counted} bytes counted, {held} held");
}

//! Whole streams on a whole server, without sockets: every verb, extreme numbers, changed payloads, odd files, several
//! connections in turns, resets and cuts.
//!
//! What must hold: nothing panics, inside a command or out of it; no command takes long; each query is answered in its order;
//! other cuts, threads and vectors give the same replies and memories; the recording, played, gives the same pixels. On a
//! failure the streams are written beside the input that made them: `STREAM_OUT=file` writes those of any input.
#![no_main]

#[path = "streams/case.rs"]
mod case;
#[path = "streams/dice.rs"]
mod dice;
#[path = "streams/files.rs"]
mod files;
#[path = "streams/payloads.rs"]
mod payloads;
#[path = "streams/replies.rs"]
mod replies;
#[path = "streams/run.rs"]
mod run;
#[path = "streams/verbs.rs"]
mod verbs;
#[path = "streams/words.rs"]
mod words;

use case::Case;
use files::Folders;
use libfuzzer_sys::fuzz_target;
use run::{Cuts, Tape};
use std::sync::{Mutex, OnceLock, PoisonError};

/// The streams that run now, for the report of a failure.
static CURRENT: Mutex<String> = Mutex::new(String::new());
static FOLDERS: OnceLock<Folders> = OnceLock::new();

/// Once: the folders, and what is to happen before libFuzzer ends the process at a panic.
fn prepare() -> Folders {
    let known: Vec<&str> = verbs::VERBS.iter().copied().chain(["SYNC"]).collect();
    for verb in fbptr::command::Verb::all() {
        assert!(known.contains(&verb.name), "no stream has {}", verb.name);
    }
    let next = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let current = CURRENT.lock().unwrap_or_else(PoisonError::into_inner);
        let path = format!("artifacts/streams-{}.txt", std::process::id());
        match std::fs::write(&path, format!("# {panic}\n{current}")) {
            Ok(()) => eprintln!("the streams are in {path}"),
            Err(_) => eprintln!("{current}"),
        }
        drop(current);
        next(panic);
    }));
    Folders::new().expect("a temporary folder")
}

fuzz_target!(|input: &[u8]| {
    let folders = FOLDERS.get_or_init(prepare);
    let case = Case::new(input);
    *CURRENT.lock().unwrap_or_else(PoisonError::into_inner) = case.told();
    if let Ok(path) = std::env::var("STREAM_OUT") {
        std::fs::write(&path, case.told()).expect("the file for the streams");
    }
    let tape = Tape::default();
    let first = run::run(&case, Cuts::NONE, &case.options[0], folders, Some(tape.clone()));
    let second = run::run(&case, Cuts::of(case.pieces), &case.options[1], folders, None);
    for (id, life) in case.lives.iter().enumerate() {
        let [a, b] = [&first, &second].map(|o| o.replies[id].escape_ascii().to_string());
        assert!(a == b, "connection {id} hears {a}, and with other cuts {b}");
        if life.is_matched {
            replies::check(life, &first.replies[id], first.is_ended[id], !life.is_finished);
        }
    }
    assert!(first.memory == second.memory, "other pixels with other cuts");
    assert!(first.depth == second.depth, "other depths with other cuts");
    if !case.reads_more {
        let (memory, notices) = run::replay(&case, tape.bytes());
        assert!(notices.is_empty(), "the recording is refused: {notices:?}");
        assert!(memory == first.memory, "the recording gives other pixels");
    }
});

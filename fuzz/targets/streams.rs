//! Runs complete streams on a complete server: every verb, extreme numbers, mutated payloads, odd
//! files, several connections interleaved and concurrent, resets and cuts.
//!
//! An input is a list of choices (`streams/data.rs`) that determine a case (`streams/case.rs`). For
//! each:
//! - nothing panics, inside a command or outside of one, and no turn takes long;
//! - each query is answered once and in order, and each error names a command;
//! - other cuts, threads and vector levels give the same replies, pixels and depths;
//! - nothing is written outside the snapshot folder;
//! - a recording, when played, gives the same pixels and depths, both of a run turn by turn and of
//!   a concurrent one on a server's threads.
//!
//! On a failure the streams are written to `artifacts/streams-PID.txt` beside the input that made
//! them; `STREAM_OUT=file` writes those of any input.
#![no_main]

#[path = "streams/case.rs"]
mod case;
#[path = "streams/data.rs"]
mod data;
#[path = "streams/files.rs"]
mod files;
#[path = "streams/payloads.rs"]
mod payloads;
#[path = "streams/replies.rs"]
mod replies;
#[path = "streams/run.rs"]
mod run;
#[path = "streams/space.rs"]
mod space;
#[path = "streams/verbs.rs"]
mod verbs;
#[path = "streams/words.rs"]
mod words;

use case::Case;
use files::Folders;
use libfuzzer_sys::fuzz_target;
use run::{Cuts, Outcome, SharedBuffer};
use std::sync::{Mutex, OnceLock, PoisonError};

/// The streams under test, for the report of a failure.
static CURRENT: Mutex<String> = Mutex::new(String::new());
static FOLDERS: OnceLock<Folders> = OnceLock::new();

/// Makes the folders, and installs a panic hook that writes the streams before libFuzzer ends the
/// process.
fn prepare() -> Folders {
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
    *CURRENT.lock().unwrap_or_else(PoisonError::into_inner) = case.to_text();
    if let Ok(path) = std::env::var("STREAM_OUT") {
        std::fs::write(&path, case.to_text()).expect("the file for the streams");
    }
    let first = check_turns(&case, folders);
    if case.is_served {
        check_served(&case, &first, folders);
    }
    folders.check();
});

/// Runs a case twice, turn by turn, and replays the first run.
fn check_turns(case: &Case, folders: &Folders) -> Outcome {
    let recording = SharedBuffer::default();
    let first = run::run(case, Cuts::NONE, &case.options[0], folders, &recording);
    let cuts = Cuts::of(case.piece_bytes);
    let second = run::run(case, cuts, &case.options[1], folders, &SharedBuffer::default());
    for (id, connection) in case.connections.iter().enumerate() {
        let [a, b] = [&first, &second].map(|outcome| replies::without_usage(&outcome.replies[id]));
        let text = |bytes: &[u8]| bytes.escape_ascii().to_string();
        assert!(a == b, "connection {id} hears {}, and with other cuts {}", text(&a), text(&b));
        if connection.is_matched {
            replies::check(connection, &first.replies[id], first.is_ended[id]);
        }
    }
    assert!(first.frame.memory == second.frame.memory, "other pixels with other cuts");
    assert!(first.frame.depth == second.frame.depth, "other depths with other cuts");
    check_replay(case, &recording, &first.frame);
    first
}

/// Runs a case with all connections concurrent, and replays its recording.
fn check_served(case: &Case, first: &Outcome, folders: &Folders) {
    let recording = SharedBuffer::default();
    let (replies, frame) = run::serve(case, folders, &recording);
    for (id, connection) in case.connections.iter().enumerate() {
        // A reset may lose replies, and who has gone does not read them.
        if connection.is_matched && connection.is_finished && connection.reads.is_none() {
            replies::check(connection, &replies[id], first.is_ended[id]);
        }
    }
    check_replay(case, &recording, &frame);
}

fn check_replay(case: &Case, recording: &SharedBuffer, frame: &run::Frame) {
    let (replayed, notices) = run::replay(case, recording);
    assert!(notices.is_empty(), "the replay refuses {notices:?}");
    assert!(replayed.memory == frame.memory, "the recording gives other pixels");
    assert!(replayed.depth == frame.depth, "the recording gives other depths");
}

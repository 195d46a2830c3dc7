//! A case on a server without sockets: what it answers, and what its memories hold at the end.

use super::case::Case;
use super::files::Folders;
use fbptr::command::EndOfInput;
use fbptr::load::Folder;
use fbptr::pipeline::{RenderOptions, Renderer};
use fbptr::server::{
    Audience, Budget, Engine, Finish, Notice, Output, Pace, Player, Recorder, RenderThread, Standing, Stream,
};
use std::io::{Cursor, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// CPU time of one piece of work, beyond which it counts as a hang. The build checks each sum and counts each branch.
const TOO_LONG_NS: u64 = 20_000_000_000;

/// What came of a run.
#[derive(PartialEq)]
pub struct Outcome {
    /// The replies of each life.
    pub replies: Vec<Vec<u8>>,
    /// Whether each was ended by the server.
    pub is_ended: Vec<bool>,
    pub memory: Vec<u8>,
    pub depth: Option<Vec<u32>>,
}

/// A recording in memory.
#[derive(Clone, Default)]
pub struct Tape(Arc<Mutex<Vec<u8>>>);

impl Tape {
    pub fn bytes(&self) -> Vec<u8> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Write for Tape {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// How a run is cut into pieces.
#[derive(Clone, Copy)]
pub struct Cuts {
    pub pieces: usize,
    pub budget: Budget,
}

impl Cuts {
    /// Whole commands.
    pub const NONE: Cuts = Cuts { pieces: usize::MAX, budget: Budget::NONE };

    /// Pieces of at most so many bytes; the smallest run command by command.
    pub fn of(pieces: usize) -> Cuts {
        let pace = if pieces == 2 { Pace::OneCommand } else { Pace::Free };
        let reply_bytes = if pieces == 7 { 1 } else { usize::MAX };
        Cuts { pieces, budget: Budget { pace, reply_bytes, ..Budget::NONE } }
    }
}

fn engine(case: &Case, options: RenderOptions) -> Engine {
    let mut engine = Engine::with_limits(case.size[0], case.size[1], case.limits).expect("a small frame");
    engine.set_renderer(Renderer::new(options));
    engine
}

/// Runs a case.
pub fn run(
    case: &Case,
    cuts: Cuts,
    options: &RenderOptions,
    folders: &Folders,
    tape: Option<Tape>,
) -> Outcome {
    let mut engine = engine(case, options.clone());
    engine.set_load_dir(Folder::open(&folders.load()).expect("the folder was made"));
    engine.set_snap_dir(Folder::open(&folders.snap()).expect("the folder was made"));
    if let Some(tape) = tape {
        let recorder = Recorder::new(Box::new(tape), case.size[0], case.size[1]).expect("a Vec takes all");
        engine.set_recorder(recorder);
    }
    let mut streams: Vec<Option<Stream>> = Vec::new();
    for id in 0..case.lives.len() {
        engine.open();
        streams.push(Some(Stream::new(&engine, id as u64 + 1, Audience::Connection)));
    }
    let mut replies = vec![Vec::new(); case.lives.len()];
    let mut is_ended = vec![false; case.lives.len()];
    let mut out = Output::default();
    let begun = Instant::now();
    for turn in &case.turns {
        let Some(stream) = &mut streams[turn.life] else { continue };
        engine.set_time(begun);
        let clock = Clock::now();
        let mut standing = Standing::Ready;
        if turn.bytes.is_empty() {
            if case.lives[turn.life].is_finished {
                let _ = stream.finish(&mut engine, EndOfInput::Stream, &mut out);
            }
        } else {
            let bytes = &case.lives[turn.life].stream[turn.bytes.clone()];
            standing = feed(stream, &mut engine, bytes, cuts, &mut out, &mut replies[turn.life]);
        }
        clock.check(|| format!("connection {}, bytes {:?}", turn.life, turn.bytes));
        replies[turn.life].append(&mut out.replies);
        engine.count(stream.session_mut());
        if turn.bytes.is_empty() || standing == Standing::Ended {
            is_ended[turn.life] = standing == Standing::Ended;
            engine.close(stream.session_mut());
            streams[turn.life] = None;
        }
    }
    for (life, stream) in streams.iter_mut().enumerate() {
        if let Some(stream) = stream {
            let _ = stream.finish(&mut engine, EndOfInput::Stream, &mut out);
            replies[life].append(&mut out.replies);
            engine.close(stream.session_mut());
        }
    }
    engine.end();
    let pixels = case.size[0] as usize * case.size[1] as usize;
    Outcome {
        replies,
        is_ended,
        memory: engine.memory().bytes().to_vec(),
        depth: engine.depth().map(|d| (0..pixels).map(|i| d.word(i)).collect()),
    }
}

/// One turn's bytes, piece by piece.
fn feed(
    stream: &mut Stream,
    engine: &mut Engine,
    bytes: &[u8],
    cuts: Cuts,
    out: &mut Output,
    replies: &mut Vec<u8>,
) -> Standing {
    for piece in bytes.chunks(cuts.pieces) {
        let mut used = 0;
        // The last call may find nothing left but a command that paused.
        let mut calls = 0;
        while used < piece.len() {
            let (taken, standing) = stream.feed(engine, &piece[used..], out, cuts.budget);
            used += taken;
            replies.append(&mut out.replies);
            calls += 1;
            assert!(calls < 1_000_000, "a stream that does not go on");
            match standing {
                Standing::Ready | Standing::Rests => {}
                Standing::Ended => return standing,
                Standing::WaitsFor(frame) => panic!("waits for frame {frame} without a display"),
            }
        }
    }
    Standing::Ready
}

/// Plays a recording on the render thread; the memory afterwards, and what was refused.
pub fn replay(case: &Case, tape: Vec<u8>) -> (Vec<u8>, Vec<Notice>) {
    let engine = Engine::new(case.size[0], case.size[1]).expect("a small frame");
    let thread = RenderThread::start(engine).expect("a thread");
    let notices = Arc::new(Mutex::new(Vec::new()));
    let told = notices.clone();
    let notify = move |notice| told.lock().unwrap_or_else(PoisonError::into_inner).push(notice);
    let sink = Box::new(std::io::sink());
    let player = Player::start(&thread, Box::new(Cursor::new(tape)), sink, EndOfInput::File, notify)
        .expect("a thread");
    player.wait();
    let engine = thread.finish(Finish::WhenAllEnded);
    let notices = std::mem::take(&mut *notices.lock().unwrap_or_else(PoisonError::into_inner));
    (engine.memory().bytes().to_vec(), notices)
}

/// The CPU time of this thread, in nanoseconds; 0 where the system does not tell.
struct Clock(u64);

impl Clock {
    fn read() -> u64 {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
        text.split(' ').next().and_then(|ns| ns.parse().ok()).unwrap_or(0)
    }

    fn now() -> Clock {
        Clock(Clock::read())
    }

    fn check(&self, what: impl Fn() -> String) {
        let taken = Clock::read() - self.0;
        assert!(taken < TOO_LONG_NS, "{} ms for {}", taken / 1_000_000, what());
    }
}

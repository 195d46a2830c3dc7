//! Runs a case: turn by turn on an engine, or with concurrent connections on a server's threads.
//!
//! Out: the replies, the memory and the depth, and the recording. A run on an engine uses the
//! calling thread and the case's order, and is deterministic; the order of one on a server is up to
//! its scheduler.

use super::case::{Case, Connection};
use super::files::Folders;
use fbptr::command::EndOfInput;
use fbptr::load::SandboxDir;
use fbptr::pipeline::{RenderOptions, Renderer};
use fbptr::server::{
    Audience, Budget, Engine, Finish, Notice, Output, Pace, Player, Recorder, RenderThread, Server, Stream,
    StreamState,
};
use std::io::{self, Cursor, Read, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// CPU time of one turn in nanoseconds, beyond which it counts as a hang. The build checks
/// overflows and counts branches, so it is far slower than a release build.
const TOO_LONG_NS: u64 = 20_000_000_000;

/// Video memory and depth at the end of a run.
#[derive(PartialEq)]
pub struct Frame {
    pub memory: Vec<u8>,
    pub depth: Option<Vec<u32>>,
}

impl Frame {
    fn of(engine: &Engine) -> Frame {
        let memory = engine.memory();
        let pixels = memory.width() as usize * memory.height() as usize;
        let depth = engine.depth().map(|d| (0..pixels).map(|i| d.word(i)).collect());
        Frame { memory: memory.bytes().to_vec(), depth }
    }
}

/// Result of a run on an engine.
pub struct Outcome {
    /// Replies to each connection.
    pub replies: Vec<Vec<u8>>,
    /// True for each connection that the server ended.
    pub is_ended: Vec<bool>,
    pub frame: Frame,
}

/// A byte buffer shared by several threads.
#[derive(Clone, Default)]
pub struct SharedBuffer(Arc<Mutex<Vec<u8>>>);

impl SharedBuffer {
    pub fn bytes(&self) -> Vec<u8> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Write for SharedBuffer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Division of a run into pieces.
#[derive(Clone, Copy)]
pub struct Cuts {
    piece_bytes: usize,
    budget: Budget,
}

impl Cuts {
    /// One piece per turn.
    pub const NONE: Cuts = Cuts { piece_bytes: usize::MAX, budget: Budget::NONE };

    /// Returns pieces of at most this many bytes; some lengths also pause after each command or
    /// each reply.
    pub fn of(piece_bytes: usize) -> Cuts {
        let pace = if piece_bytes == 2 { Pace::OneCommand } else { Pace::Free };
        let reply_bytes = if piece_bytes == 7 { 1 } else { usize::MAX };
        Cuts { piece_bytes, budget: Budget { pace, reply_bytes, ..Budget::NONE } }
    }
}

fn engine(case: &Case, options: &RenderOptions, folders: &Folders, recording: &SharedBuffer) -> Engine {
    let [width, height] = case.size;
    let mut engine = Engine::with_limits(width, height, case.limits).expect("a small frame");
    engine.set_renderer(Renderer::new(options.clone()));
    engine.set_load_dir(SandboxDir::open(&folders.load()).expect("the folder was made"));
    engine.set_snap_dir(SandboxDir::open(&folders.snap()).expect("the folder was made"));
    let recorder = Recorder::new(Box::new(recording.clone()), width, height).expect("a thread");
    engine.attach(recorder);
    engine
}

/// Runs a case turn by turn, and writes its recording.
pub fn run(
    case: &Case,
    cuts: Cuts,
    options: &RenderOptions,
    folders: &Folders,
    recording: &SharedBuffer,
) -> Outcome {
    let mut engine = engine(case, options, folders, recording);
    let mut streams: Vec<Option<Stream>> = Vec::new();
    for id in 0..case.connections.len() {
        engine.open(id as u64 + 1);
        streams.push(Some(Stream::new(&engine, id as u64 + 1, Audience::Connection)));
    }
    let mut replies = vec![Vec::new(); case.connections.len()];
    let mut is_ended = vec![false; case.connections.len()];
    let mut out = Output::default();
    let begun = Instant::now();
    for turn in &case.turns {
        let id = turn.connection;
        let Some(stream) = &mut streams[id] else { continue };
        engine.begin_slice(begun);
        let clock = Clock::now();
        let mut state = StreamState::Ready;
        if !turn.bytes.is_empty() {
            let bytes = &case.connections[id].stream[turn.bytes.clone()];
            state = feed(stream, &mut engine, bytes, cuts, &mut out, &mut replies[id]);
        } else if case.connections[id].is_finished {
            let _ = stream.finish(&mut engine, EndOfInput::Stream, &mut out);
        }
        clock.check(|| format!("connection {id}, bytes {:?}", turn.bytes));
        replies[id].append(&mut out.replies);
        engine.count(stream.session_mut());
        is_ended[id] = state == StreamState::Ended;
        if turn.bytes.is_empty() || is_ended[id] {
            engine.close(stream.session_mut());
            streams[id] = None;
        }
    }
    for (id, stream) in streams.iter_mut().enumerate() {
        if let Some(stream) = stream {
            let _ = stream.finish(&mut engine, EndOfInput::Stream, &mut out);
            replies[id].append(&mut out.replies);
            engine.close(stream.session_mut());
        }
    }
    engine.end();
    Outcome { replies, is_ended, frame: Frame::of(&engine) }
}

/// Feeds the bytes of one turn, piece by piece.
fn feed(
    stream: &mut Stream,
    engine: &mut Engine,
    bytes: &[u8],
    cuts: Cuts,
    out: &mut Output,
    replies: &mut Vec<u8>,
) -> StreamState {
    for piece in bytes.chunks(cuts.piece_bytes) {
        let (mut used, mut calls) = (0, 0);
        while used < piece.len() {
            let (taken, state) = stream.feed(engine, &piece[used..], out, cuts.budget);
            used += taken;
            replies.append(&mut out.replies);
            calls += 1;
            assert!(calls < 1_000_000, "a stream that does not go on");
            match state {
                StreamState::Ready | StreamState::Yields | StreamState::Pauses(_) => {}
                StreamState::Ended => return state,
                StreamState::WaitsFor(_) | StreamState::Works | StreamState::InPieces => {
                    panic!("{state:?} without a display and without leave to suspend")
                }
            }
        }
    }
    StreamState::Ready
}

/// Runs a case on a server's threads, with all connections concurrent; returns the replies of each,
/// and the frame.
pub fn serve(case: &Case, folders: &Folders, recording: &SharedBuffer) -> (Vec<Vec<u8>>, Frame) {
    let engine = engine(case, &case.options[1], folders, recording);
    let server = Server::start(engine).expect("a thread");
    let replies: Vec<SharedBuffer> = case.connections.iter().map(|_| SharedBuffer::default()).collect();
    for (connection, replies) in case.connections.iter().zip(&replies) {
        let input = Box::new(Pipe::new(connection, case.piece_bytes));
        let output = ClosingPipe { replies: replies.clone(), left: connection.reads };
        server.serve_pipe(input, Box::new(output), || {}).expect("a thread");
    }
    let engine = server.finish();
    (replies.iter().map(SharedBuffer::bytes).collect(), Frame::of(&engine))
}

/// Output of a connection, whose client may close it after some bytes.
struct ClosingPipe {
    replies: SharedBuffer,
    /// Bytes until then.
    left: Option<usize>,
}

impl Write for ClosingPipe {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.left.unwrap_or(usize::MAX));
        if taken == 0 && !bytes.is_empty() {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        self.left = self.left.map(|left| left - taken);
        self.replies.write(&bytes[..taken])
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Input of a connection: its stream in pieces, then its end or a reset.
struct Pipe {
    stream: Cursor<Vec<u8>>,
    piece_bytes: usize,
    is_finished: bool,
}

impl Pipe {
    fn new(connection: &Connection, piece_bytes: usize) -> Pipe {
        let stream = Cursor::new(connection.stream.clone());
        Pipe { stream, piece_bytes: piece_bytes.max(16), is_finished: connection.is_finished }
    }
}

impl Read for Pipe {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = buffer.len().min(self.piece_bytes);
        match self.stream.read(&mut buffer[..most]) {
            Ok(0) if !self.is_finished => Err(io::ErrorKind::ConnectionReset.into()),
            other => other,
        }
    }
}

/// Plays a recording on a render thread; returns the frame afterwards, and the refused commands.
pub fn replay(case: &Case, recording: &SharedBuffer) -> (Frame, Vec<Notice>) {
    let engine = Engine::new(case.size[0], case.size[1]).expect("a small frame");
    let thread = RenderThread::start(engine).expect("a thread");
    let notices = Arc::new(Mutex::new(Vec::new()));
    let heard = notices.clone();
    let notify = move |notice| {
        if matches!(notice, Notice::Refused(_)) {
            heard.lock().unwrap_or_else(PoisonError::into_inner).push(notice);
        }
    };
    let (input, sink) = (Cursor::new(recording.bytes()), Box::new(io::sink()));
    let player = Player::start(&thread, Box::new(input), sink, EndOfInput::File, notify).expect("a thread");
    player.wait();
    let engine = thread.finish_engine(Finish::WhenAllEnded);
    let notices = std::mem::take(&mut *notices.lock().unwrap_or_else(PoisonError::into_inner));
    (Frame::of(&engine), notices)
}

/// CPU time of this thread at its creation, in nanoseconds; 0 if the system does not tell.
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

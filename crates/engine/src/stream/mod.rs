//! The command stream of one connection: its decoder and its session, run on the engine in pieces.
//!
//! In: bytes as they arrive, split anywhere, or typed commands. Out: replies in order, and beside
//! them notices of errors and warnings for the owner. A stream yields when its [`Budget`] is used
//! up: a time, a number of reply bytes, or one command.

mod command_executor;

use super::budget::{Budget, Pace};
use super::engine::Pieces;
use super::engine::{Job, JobResult};
use super::{Audience, Engine, Session};
use command_executor::CommandExecutor;
use fbptr_command::{
    BYTE_ORDER_MARK, Command, Decoder, EndOfInput, Flow, LentPayload, Limits as StreamLimits, Rect, Sink,
    StreamPosition, Verb, format_play_error, format_play_fault,
};
use fbptr_core::error::Fault;
use std::time::Duration;

/// A refused command, as it is reported to its owner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CommandError {
    /// Position of the command's first byte.
    pub place: StreamPosition,
    /// Verb of the command.
    pub verb: String,
    /// Reason for the refusal.
    pub fault: Fault,
    /// Bytes of the offending token, if they are not UTF-8.
    pub raw_token: Option<Vec<u8>>,
}

impl CommandError {
    /// Formats the error as `play` prints it after the program's name: `FILE:LINE: CODE VERB:
    /// message`.
    pub fn play_line(&self, file: &str) -> String {
        match &self.raw_token {
            Some(token) => {
                let Fault { code, message, .. } = &self.fault;
                format_play_error(file, self.place, &self.verb, *code, message, Some(token))
            }
            None => format_play_fault(file, self.place, &self.verb, &self.fault),
        }
    }
}

/// Message to the owner of a stream, beside the replies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// A command was refused.
    Refused(CommandError),
    /// A file was read, and something in it was skipped or corrected.
    Warning(String),
    /// A command ran, but probably not as it was meant.
    Remark {
        /// Position of the command's first byte.
        place: StreamPosition,
        /// Verb of the command.
        verb: &'static str,
        /// Explanation in one line.
        text: &'static str,
    },
}

impl Notice {
    /// Formats the notice as `play` prints it after the program's name.
    pub fn play_line(&self, file: &str) -> String {
        match self {
            Notice::Refused(refused) => refused.play_line(file),
            Notice::Warning(warning) => warning.clone(),
            Notice::Remark { place, verb, text } => format!("{file}:{}: {verb}: {text}", place.line),
        }
    }
}

/// Output of a stream.
#[derive(Debug, Default)]
pub struct Output {
    /// Replies to the connection, in order.
    pub replies: Vec<u8>,
    /// Notices for the owner.
    pub notices: Vec<Notice>,
    /// The job of a stream in the state [`StreamState::Works`].
    pub job: Option<Job>,
}

/// State of a stream after a piece of it has run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum StreamState {
    /// It can continue.
    Ready,
    /// It can continue, but its budget is used up.
    Yields,
    /// It waits until this frame is shown, and is then sent `FRAME n`.
    WaitsFor(u64),
    /// It pauses for this time where a window shows what was drawn, and can continue elsewhere.
    Pauses(Duration),
    /// It waits for the job in [`Output`] and is resumed with the result.
    Works,
    /// It has begun a command that must be resumed before anything else runs.
    InPieces,
    /// It has ended: nothing more of it is run.
    Ended,
}

/// Command stream of one connection.
pub struct Stream {
    decoder: Decoder,
    session: Session,
    /// The suspended command, if there is one.
    suspended: Option<Suspended>,
}

/// A command that has begun and is not complete.
struct Suspended {
    place: StreamPosition,
    verb: &'static str,
    /// The rest of the command, unless it waits for a job.
    pieces: Option<Box<Pieces>>,
}

/// Feeds bytes part by part, until all of them are consumed or a part ends in another state than
/// [`StreamState::Ready`]. Returns the number of bytes consumed and the state.
pub fn feed_parts(
    bytes: &[u8],
    mut feed_part: impl FnMut(&[u8]) -> (usize, StreamState),
) -> (usize, StreamState) {
    let mut used = 0;
    while used < bytes.len() {
        let (taken, state) = feed_part(&bytes[used..]);
        used += taken;
        if state != StreamState::Ready {
            return (used, state);
        }
    }
    (used, StreamState::Ready)
}

/// Returns the width and height that a stream states by `SIZE w h` as its first command, as they are
/// written.
pub fn stated_size(stream: &[u8]) -> Option<[&str; 2]> {
    let stream = stream.strip_prefix(BYTE_ORDER_MARK).unwrap_or(stream);
    let is_command = |line: &&[u8]| !line.starts_with(b"#") && !line.trim_ascii().is_empty();
    let first = stream.split(|&b| b == b'\n').find(is_command)?;
    match std::str::from_utf8(first).ok()?.split_ascii_whitespace().collect::<Vec<_>>()[..] {
        [verb, w, h] if verb.eq_ignore_ascii_case("SIZE") => Some([w, h]),
        _ => None,
    }
}

/// Event that resumes a suspended stream.
pub enum Resume {
    /// Result of its job.
    Job(JobResult),
    /// Time to run more pieces.
    Pieces,
}

impl Stream {
    /// Creates the stream of connection `id`, with the engine's payload limit and dialect.
    pub fn new(engine: &Engine, id: u64, audience: Audience) -> Self {
        let limits = StreamLimits { payload_bytes: engine.limits().payload_bytes };
        let dialect = engine.dialect();
        let mut decoder = Decoder::with_payload_pool(limits, engine.quotas.payload_pool());
        decoder.set_grey_digits(dialect.grey_digits);
        Stream {
            decoder,
            session: Session { blend: dialect.blend, ..Session::new(id, audience) },
            suspended: None,
        }
    }

    /// Returns the session.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Returns the session for changes.
    pub fn session_mut(&mut self) -> &mut Session {
        &mut self.session
    }

    /// Returns the position of the next byte to be fed.
    pub fn place(&self) -> StreamPosition {
        self.decoder.place()
    }

    /// Returns the number of bytes held for an incomplete command.
    pub fn pending_bytes(&self) -> usize {
        self.decoder.pending_bytes()
    }

    /// Returns the number of bytes that the payload being received still lacks.
    pub fn missing_bytes(&self) -> usize {
        self.decoder.missing_bytes()
    }

    /// Runs the complete commands in `bytes` until the budget is used up. Returns the number of
    /// bytes consumed and the state.
    pub fn feed(
        &mut self,
        engine: &mut Engine,
        bytes: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> (usize, StreamState) {
        let fed = feed_parts(bytes, |bytes| self.feed_part(engine, bytes, out, budget));
        // Not after each part: a STATS does not count its own bytes.
        self.session.stats.bytes = self.decoder.place().byte;
        fed
    }

    /// Runs a part of the complete commands in `bytes`.
    fn feed_part(
        &mut self,
        engine: &mut Engine,
        bytes: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> (usize, StreamState) {
        let part = match budget.pace {
            // Beside another connection's command in pieces: up to the first command that changes
            // something.
            _ if budget.only_asks => match self.decoder.next_asks(bytes) {
                Some(length) => &bytes[..length],
                None => return (0, StreamState::Yields),
            },
            // A step must end at the right pixel, but pixel commands cannot pause the decoder: so it
            // is fed byte by byte.
            Pace::OneCommand => &bytes[..1],
            Pace::OneFrame | Pace::Free => bytes,
        };
        self.decode(engine, out, budget, |decoder, executor| decoder.feed_some(part, executor))
    }

    /// Lends the buffer of the payload that is being received, if there is one and memory for all of
    /// it: see [`Decoder::lend_payload`].
    pub fn lend_payload(&mut self) -> Option<LentPayload> {
        self.decoder.lend_payload()
    }

    /// Takes a lent payload back, and runs its command if it is complete. Returns the number of bytes
    /// that were read, and the state.
    pub fn take_back(
        &mut self,
        engine: &mut Engine,
        payload: LentPayload,
        out: &mut Output,
        budget: Budget,
    ) -> (usize, StreamState) {
        let taken =
            self.decode(engine, out, budget, |decoder, executor| decoder.take_back(payload, executor));
        self.session.stats.bytes = self.decoder.place().byte;
        taken
    }

    /// Runs the commands that `decode` completes.
    fn decode(
        &mut self,
        engine: &mut Engine,
        out: &mut Output,
        budget: Budget,
        decode: impl FnOnce(&mut Decoder, &mut CommandExecutor<'_>) -> (usize, Flow),
    ) -> (usize, StreamState) {
        let before = self.session.stats.commands;
        let mut executor = CommandExecutor::new(engine, &mut self.session, out, budget);
        executor.batches = budget.pace == Pace::Free && !budget.only_asks;
        let (taken, flow) = decode(&mut self.decoder, &mut executor);
        executor.flush();
        let mut state = executor.state_after(flow);
        self.suspended = executor.suspended.take();
        let is_step = budget.pace == Pace::OneCommand && !budget.only_asks;
        if is_step && state == StreamState::Ready && self.session.stats.commands > before {
            state = StreamState::Yields;
        }
        (taken, state)
    }

    /// Abandons the command that is in pieces, if there is one.
    pub fn abandon(&mut self, engine: &mut Engine) {
        if let Some(Suspended { verb, pieces: Some(pieces), .. }) = self.suspended.take() {
            engine.abandon(&mut self.session, verb, *pieces);
        }
    }

    /// Ends the input: runs or refuses what the decoder still holds.
    pub fn finish(&mut self, engine: &mut Engine, end: EndOfInput, out: &mut Output) -> StreamState {
        let mut executor = CommandExecutor::new(engine, &mut self.session, out, Budget::NONE);
        let _ = self.decoder.finish(end, &mut executor);
        executor.flush();
        match executor.state {
            StreamState::WaitsFor(frame) => StreamState::WaitsFor(frame),
            _ => StreamState::Ended,
        }
    }

    /// Continues the command that left the stream in the state [`StreamState::Works`] or
    /// [`StreamState::InPieces`].
    pub fn resume(
        &mut self,
        engine: &mut Engine,
        resume: Resume,
        out: &mut Output,
        budget: Budget,
    ) -> StreamState {
        let Some(suspended) = self.suspended.take() else { return StreamState::Ready };
        let mut executor = CommandExecutor::new(engine, &mut self.session, out, budget);
        let flow = executor.resume(resume, suspended);
        let state = executor.state_after(flow);
        self.suspended = executor.suspended.take();
        state
    }

    /// Runs one typed command, after the checks that the decoder would make.
    pub fn run(
        &mut self,
        engine: &mut Engine,
        command: Command,
        out: &mut Output,
        budget: Budget,
    ) -> StreamState {
        let place = self.place_of_next();
        let checked = command.validate();
        let mut executor = CommandExecutor::new(engine, &mut self.session, out, budget);
        let flow = match checked {
            Ok(()) => executor.command(command, place),
            Err(fault) => {
                let is_pixelflut = Verb::named(command.verb()).is_some_and(Verb::is_pixelflut);
                executor.count_refused(is_pixelflut);
                executor.refuse(place, command.verb(), fault)
            }
        };
        let state = executor.state_after(flow);
        self.suspended = executor.suspended.take();
        state
    }

    /// Runs `BLIT` with bytes that somebody else holds, as [`Stream::run`] does.
    pub fn blit(
        &mut self,
        engine: &mut Engine,
        rect: Rect,
        rgba: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> StreamState {
        let place = self.place_of_next();
        let mut executor = CommandExecutor::new(engine, &mut self.session, out, budget);
        let flow = executor.blit(rect, rgba, place);
        executor.state_after(flow)
    }

    /// Returns the position of the next typed command: typed commands are counted as lines.
    fn place_of_next(&self) -> StreamPosition {
        StreamPosition { line: self.session.stats.commands + 1, byte: 0 }
    }
}

#[cfg(test)]
mod tests;

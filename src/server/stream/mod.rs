//! One connection's stream: its decoder and its session, run on the engine piece by piece.
//!
//! In: bytes as they come, cut anywhere, or typed commands. Out: replies in order, and beside them
//! what the owner is to know of errors. It yields by a budget: after a time, after so many reply
//! bytes, after one command.

mod command_executor;

use super::engine::Pieces;
use super::jobs::{Job, JobResult};
use super::{Audience, Engine, Session};
use crate::command::{
    Command, Decoder, EndOfInput, Limits as StreamLimits, Sink, StreamPosition, format_play_error,
    format_play_fault,
};
use crate::error::Fault;
use command_executor::CommandExecutor;
use std::time::{Duration, Instant};

/// A refused command, as its owner is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CommandError {
    /// Where the command begins.
    pub place: StreamPosition,
    /// Its verb.
    pub verb: String,
    /// Why it was refused.
    pub fault: Fault,
    /// The token's bytes as they came, where they are no text.
    pub raw_token: Option<Vec<u8>>,
}

impl CommandError {
    /// `FILE:LINE: CODE VERB: message`, as `play` says it.
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

/// What the owner of a stream is told beside the replies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// A command was refused.
    Refused(CommandError),
    /// A file was read, and something in it skipped or put right.
    Warning(String),
    /// A command ran, and probably not as it was meant.
    Remark {
        /// Where the command begins.
        place: StreamPosition,
        /// Its verb.
        verb: &'static str,
        /// The explanation, one line.
        text: &'static str,
    },
}

/// What a stream answers.
#[derive(Debug, Default)]
pub struct Output {
    /// For the connection, in order.
    pub replies: Vec<u8>,
    /// For the owner.
    pub notices: Vec<Notice>,
    /// The job of a stream that stands as [`StreamState::Works`].
    pub(super) job: Option<Job>,
}

/// The budget of a stream, after which it yields.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// At this time at the latest, up to one command more.
    pub until: Option<Instant>,
    /// When this many reply bytes wait.
    pub reply_bytes: usize,
    /// After how much.
    pub pace: Pace,
    /// Whether long commands may be suspended: the stream then stands as [`StreamState::Works`] or
    /// [`StreamState::InPieces`]. Otherwise they are run at once.
    pub suspends: bool,
    /// Whether those commands alone may run that only ask: another connection's command is in pieces.
    pub only_asks: bool,
    /// The time after which a command in pieces is given up. None for a recording: what was recorded was not.
    pub command_time: Option<Duration>,
}

/// How much a stream runs at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// As much as time allows.
    Free,
    /// One command, for stepping.
    OneCommand,
    /// Up to the next `PRESENT`, for stepping.
    OneFrame,
}

impl Budget {
    /// No limit.
    pub const NONE: Budget = Budget {
        until: None,
        reply_bytes: usize::MAX,
        pace: Pace::Free,
        suspends: false,
        only_asks: false,
        command_time: None,
    };
}

/// The state of a stream after a piece of it was run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum StreamState {
    /// It can go on.
    Ready,
    /// It can go on, and has used its budget up.
    Yields,
    /// It waits for this frame to be on the screen; then it is owed `FRAME n`.
    WaitsFor(u64),
    /// It waits for the job in [`Output`], whose result is to be given to it.
    Works,
    /// It is in the middle of a command, and is to be resumed before all else.
    InPieces,
    /// It is over: nothing more of it is run.
    Ended,
}

/// The stream of one connection.
pub struct Stream {
    decoder: Decoder,
    session: Session,
    /// The command that waits for its job.
    suspended: Option<Suspended>,
}

/// A command in the middle of which the stream stands.
struct Suspended {
    place: StreamPosition,
    verb: &'static str,
    /// What is left of it, unless it waits for a job.
    pieces: Option<Box<Pieces>>,
}

/// What lets a suspended stream go on.
pub(super) enum Resume {
    /// The result of its job.
    Job(JobResult),
    /// Time for more pieces.
    Pieces,
}

impl Stream {
    /// The stream of connection `id`, with the engine's payload limit.
    pub fn new(engine: &Engine, id: u64, audience: Audience) -> Self {
        let limits = StreamLimits { payload_bytes: engine.limits().payload_bytes };
        let dialect = engine.dialect();
        let mut decoder = Decoder::with_payload_pool(limits, engine.payload_pool());
        decoder.set_grey_digits(dialect.grey_digits);
        Stream {
            decoder,
            session: Session { blend: dialect.blend, ..Session::new(id, audience) },
            suspended: None,
        }
    }

    /// The session.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The session, for the end of it.
    pub fn session_mut(&mut self) -> &mut Session {
        &mut self.session
    }

    /// Where the next byte to be fed stands.
    pub fn place(&self) -> StreamPosition {
        self.decoder.place()
    }

    /// Bytes held for a command that is not whole.
    pub fn pending_bytes(&self) -> usize {
        self.decoder.pending_bytes()
    }

    /// Bytes that the payload which has begun is waiting for.
    pub fn missing_bytes(&self) -> usize {
        self.decoder.missing_bytes()
    }

    /// Runs what is whole in `bytes`, until the budget is used up. Answers how many bytes were taken.
    pub fn feed(
        &mut self,
        engine: &mut Engine,
        bytes: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> (usize, StreamState) {
        if budget.only_asks {
            return self.feed_asks(engine, bytes, out, budget);
        }
        let (mut used, mut state) = (0, StreamState::Ready);
        // Stepping shall end at the right pixel: those are not commands that can pause the decoder.
        let portion = if budget.pace == Pace::OneCommand { 1 } else { usize::MAX };
        while used < bytes.len() && state == StreamState::Ready {
            let piece = &bytes[used..used.saturating_add(portion).min(bytes.len())];
            let before = self.session.stats.commands;
            let mut executor = CommandExecutor::new(engine, &mut self.session, out, budget);
            executor.batches_lines = budget.pace == Pace::Free;
            let (taken, flow) = self.decoder.feed_some(piece, &mut executor);
            executor.flush();
            state = executor.state_after(flow);
            self.suspended = executor.suspended.take();
            used += taken;
            if portion == 1 && state == StreamState::Ready && self.session.stats.commands > before {
                state = StreamState::Yields;
            }
        }
        self.session.stats.bytes = self.decoder.place().byte;
        (used, state)
    }

    /// Runs commands that only ask, up to the first other one.
    fn feed_asks(
        &mut self,
        engine: &mut Engine,
        bytes: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> (usize, StreamState) {
        let mut used = 0;
        while let Some(length) = self.decoder.next_asks(&bytes[used..]) {
            let mut executor = CommandExecutor::new(engine, &mut self.session, out, budget);
            let (taken, flow) = self.decoder.feed_some(&bytes[used..used + length], &mut executor);
            let state = executor.state_after(flow);
            used += taken;
            self.session.stats.bytes = self.decoder.place().byte;
            if state != StreamState::Ready {
                return (used, state);
            }
        }
        (used, if used < bytes.len() { StreamState::Yields } else { StreamState::Ready })
    }

    /// The verb of the command that is in pieces.
    pub(super) fn verb_in_pieces(&self) -> Option<&'static str> {
        self.suspended.as_ref().filter(|s| s.pieces.is_some()).map(|s| s.verb)
    }

    /// Says that no more bytes come.
    pub fn finish(&mut self, engine: &mut Engine, end: EndOfInput, out: &mut Output) -> StreamState {
        let mut executor = CommandExecutor::new(engine, &mut self.session, out, Budget::NONE);
        let _ = self.decoder.finish(end, &mut executor);
        executor.flush();
        match executor.state {
            StreamState::WaitsFor(frame) => StreamState::WaitsFor(frame),
            _ => StreamState::Ended,
        }
    }

    /// Goes on with the command for which the stream stood as [`StreamState::Works`] or
    /// [`StreamState::InPieces`].
    pub(super) fn resume(
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

    /// Runs one typed command, checked as the decoder would.
    pub fn run(
        &mut self,
        engine: &mut Engine,
        command: Command,
        out: &mut Output,
        budget: Budget,
    ) -> StreamState {
        let place = StreamPosition { line: self.session.stats.commands + 1, byte: 0 };
        let checked = command.validate();
        let mut executor = CommandExecutor::new(engine, &mut self.session, out, budget);
        let flow = match checked {
            Ok(()) => executor.command(command, place),
            Err(fault) => {
                executor.session.stats.commands += 1;
                executor.session.stats.errors += 1;
                executor.refuse(place, command.verb(), fault)
            }
        };
        let state = executor.state_after(flow);
        self.suspended = executor.suspended.take();
        state
    }
}

#[cfg(test)]
mod tests;

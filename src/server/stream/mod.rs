//! One connection's stream: its decoder and its session, run on the engine piece by piece.
//!
//! In: bytes as they come, cut anywhere, or typed commands. Out: replies in order, and beside them what the owner is to
//! know of errors. It can be told to rest: after a time, after so many reply bytes, after one command.

mod runner;

use super::{Audience, Engine, Session};
use crate::command::{
    Command, Decoder, EndOfInput, Flow, Limits as StreamLimits, Place, Sink, format_play_error,
    format_play_fault,
};
use crate::error::Fault;
use runner::Runner;
use std::time::Instant;

/// A refused command, as its owner is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Complaint {
    /// Where the command begins.
    pub place: Place,
    /// Its verb.
    pub verb: String,
    /// Why it was refused.
    pub fault: Fault,
    /// The token's bytes as they came, where they are no text.
    pub raw_token: Option<Vec<u8>>,
}

impl Complaint {
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
    Refused(Complaint),
    /// A file was read, and something in it skipped or put right.
    Warning(String),
}

/// What a stream answers.
#[derive(Debug, Default)]
pub struct Output {
    /// For the connection, in order.
    pub replies: Vec<u8>,
    /// For the owner.
    pub notices: Vec<Notice>,
}

/// When a stream is to rest.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// At this time at the latest, up to one command more.
    pub until: Option<Instant>,
    /// When this many reply bytes wait.
    pub reply_bytes: usize,
    /// After how much.
    pub pace: Pace,
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
    /// No rest.
    pub const NONE: Budget = Budget { until: None, reply_bytes: usize::MAX, pace: Pace::Free };
}

/// How a stream stands after a piece of it was run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Standing {
    /// It can go on.
    Ready,
    /// It can go on, and has had its share.
    Rests,
    /// It waits for this frame to be on the screen; then it is owed `FRAME n`.
    WaitsFor(u64),
    /// It is over: nothing more of it is run.
    Ended,
}

/// The stream of one connection.
pub struct Stream {
    decoder: Decoder,
    session: Session,
}

impl Stream {
    /// The stream of connection `id`, with the engine's payload limit.
    pub fn new(engine: &Engine, id: u64, audience: Audience) -> Self {
        let limits = StreamLimits { payload_bytes: engine.limits().payload_bytes };
        Stream { decoder: Decoder::with_spare(limits, engine.spare()), session: Session::new(id, audience) }
    }

    /// The session.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The session, for the end of it.
    pub fn session_mut(&mut self) -> &mut Session {
        &mut self.session
    }

    /// Bytes held for a command that is not whole.
    pub fn pending_bytes(&self) -> usize {
        self.decoder.pending_bytes()
    }

    /// Bytes that the payload which has begun is waiting for.
    pub fn wanted_bytes(&self) -> usize {
        self.decoder.wanted_bytes()
    }

    /// Runs what is whole in `bytes`, until the budget is used up. Answers how many bytes were taken.
    pub fn feed(
        &mut self,
        engine: &mut Engine,
        bytes: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> (usize, Standing) {
        let (mut used, mut standing) = (0, Standing::Ready);
        // Stepping shall end at the right pixel: those are not commands that can pause the decoder.
        let portion = if budget.pace == Pace::OneCommand { 1 } else { usize::MAX };
        while used < bytes.len() && standing == Standing::Ready {
            let piece = &bytes[used..used.saturating_add(portion).min(bytes.len())];
            let before = self.session.stats.commands;
            let mut runner = Runner::new(engine, &mut self.session, out, budget);
            runner.gathers_lines = budget.pace == Pace::Free;
            let (taken, flow) = self.decoder.feed_some(piece, &mut runner);
            runner.settle();
            standing = match (runner.standing, flow) {
                (Standing::Ready, Flow::Stop) => Standing::Ended,
                (standing, _) => standing,
            };
            used += taken;
            if portion == 1 && standing == Standing::Ready && self.session.stats.commands > before {
                standing = Standing::Rests;
            }
        }
        self.session.stats.bytes = self.decoder.place().byte;
        (used, standing)
    }

    /// Says that no more bytes come.
    pub fn finish(&mut self, engine: &mut Engine, end: EndOfInput, out: &mut Output) -> Standing {
        let mut runner = Runner::new(engine, &mut self.session, out, Budget::NONE);
        let _ = self.decoder.finish(end, &mut runner);
        runner.settle();
        match runner.standing {
            Standing::WaitsFor(frame) => Standing::WaitsFor(frame),
            _ => Standing::Ended,
        }
    }

    /// Runs one typed command, checked as the decoder would.
    pub fn run(
        &mut self,
        engine: &mut Engine,
        command: Command,
        out: &mut Output,
        budget: Budget,
    ) -> Standing {
        let place = Place { line: self.session.stats.commands + 1, byte: 0 };
        let checked = command.check();
        let mut runner = Runner::new(engine, &mut self.session, out, budget);
        let flow = match checked {
            Ok(()) => runner.command(command, place),
            Err(fault) => {
                runner.session.stats.commands += 1;
                runner.session.stats.errors += 1;
                runner.refuse(place, command.verb(), fault)
            }
        };
        match (runner.standing, flow) {
            (Standing::Ready, Flow::Stop) => Standing::Ended,
            (standing, _) => standing,
        }
    }
}

#[cfg(test)]
mod tests;

//! The budget of a slice: what a stream may do before it yields to the others.

use super::clock::Instant;
use std::time::Duration;

/// Limits after which a running stream yields.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Time at which the stream yields, after at most one command more.
    pub until: Option<Instant>,
    /// Number of queued reply bytes at which it yields.
    pub reply_bytes: usize,
    /// Amount of work after which it yields.
    pub pace: Pace,
    /// True if long commands may be suspended, which leaves the stream in a state that says so.
    /// Otherwise they run to their end.
    pub suspends: bool,
    /// True if only queries may run, because another connection's command is in pieces.
    pub only_asks: bool,
    /// Time limit of a command in pieces. `None` for a recording, whose commands have no limit.
    pub command_time: Option<Duration>,
}

/// Amount of work that a stream does before it yields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// As much as time allows.
    Free,
    /// One command, when the display is stepped.
    OneCommand,
    /// Up to the next `PRESENT`, when the display is stepped.
    OneFrame,
}

impl Budget {
    /// No limit at all.
    pub const NONE: Budget = Budget {
        until: None,
        reply_bytes: usize::MAX,
        pace: Pace::Free,
        suspends: false,
        only_asks: false,
        command_time: None,
    };
}

//! The render thread's means to read sockets by itself, where the system has none: each socket has a reader of its own.

use crate::server::thread::message::Message;

/// Nothing to read with.
#[derive(Default)]
pub(crate) struct Hand;

/// There is none.
pub(crate) enum Next {}

impl Hand {
    pub fn next(&mut self) -> Option<Next> {
        None
    }

    pub fn pass_on(&self, _: Option<u64>) {}

    pub fn next_brief(&mut self) -> Option<Next> {
        None
    }

    pub fn read(&mut self, next: Next) -> Option<Message> {
        match next {}
    }
}

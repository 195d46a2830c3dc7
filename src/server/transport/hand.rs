//! The render thread's means to read sockets by itself: those of the poller, one at a time and without waiting.

use super::lease::Lease;
use super::poll::{FEW_BYTES, Shared, Watched, bytes_of};
use crate::server::thread::message::{Batch, Message};
use std::sync::Arc;

/// The render thread's means to read by itself.
pub(crate) struct Hand(Arc<Shared>);

/// A socket that the render thread is about to read, into a lease or, where it said little last, into a small buffer. What
/// came of it before must be out of the channel first.
pub(crate) struct Next(Arc<Watched>, Option<Lease>);

impl Hand {
    pub(super) fn new(shared: Arc<Shared>) -> Self {
        Hand(shared)
    }

    /// A socket that can be read now, if there is one and a buffer for it.
    pub fn next(&mut self) -> Option<Next> {
        let lease = self.0.buffers.try_lease()?;
        // One at a time: the reader asks for the others.
        let watched = self.0.next::<1>(false).ok()??;
        Some(Next(watched, Some(lease)))
    }

    /// The render thread will not ask for the next one for a while: the poller reads those that were left to it, but for
    /// the connection that it is going to run.
    pub fn pass_on(&self, but_for: Option<u64>) {
        self.0.pass_on(but_for);
    }

    /// A socket that said little last and can be read now, if there is one.
    pub fn next_brief(&mut self) -> Option<Next> {
        self.0.next_brief().ok()?.map(|watched| Next(watched, None))
    }

    /// What it says.
    pub fn read(&mut self, Next(watched, lease): Next) -> Option<Message> {
        let message = match lease {
            Some(lease) => self.0.read(&watched, lease, &mut None),
            None => {
                let mut buffer = vec![0; FEW_BYTES];
                match self.0.fill(&watched, &mut buffer) {
                    Err(message) => message,
                    Ok(filled) => {
                        buffer.truncate(filled);
                        Some(Message::Bytes(watched.id, Batch { buffer, lease: None, filled }))
                    }
                }
            }
        };
        self.0.done(&watched, bytes_of(&message));
        message
    }
}

//! Reads sockets on the render thread, where that would sleep otherwise.
//!
//! In: the poller's queue of readable sockets. Out: messages, as the reader thread sends them. Runs
//! on the render thread. Promises that it waits for nothing, and that a socket is read by one
//! thread at a time.

use super::buffer_pool::PooledBuffer;
use super::poll::{FEW_BYTES, Registered, Shared, bytes_of, lock};
use super::report::{Trouble, report};
use crate::server::thread::message::{Batch, Message};
use std::sync::Arc;

/// The render thread's means to read sockets by itself: those in line, one at a time and without
/// waiting.
pub(crate) struct InlineReader(pub(super) Arc<Shared>);

/// A socket that the render thread is about to read, into a pooled buffer or, where it said little
/// last, into a small buffer. What came of it before must be out of the channel first.
pub(crate) struct Next(Arc<Registered>, Option<PooledBuffer>);

impl InlineReader {
    /// A socket that can be read now, if there is one and a buffer for it.
    pub fn next(&mut self) -> Option<Next> {
        let pooled = self.0.buffers.try_acquire()?;
        self.ask();
        let registered = lock(&self.0.ready).next()?;
        Some(Next(registered, Some(pooled)))
    }

    /// A socket that said little last and can be read now, if there is one.
    pub fn next_interactive(&mut self) -> Option<Next> {
        let next = || lock(&self.0.ready).next_interactive();
        let registered = next().or_else(|| {
            self.ask();
            next()
        });
        Some(Next(registered?, None))
    }

    fn ask(&self) {
        if let Err(e) = self.0.ask(false) {
            report(Trouble::Watching, format_args!("cannot ask for connections' bytes: {e}"));
        }
    }

    /// The render thread will not ask for the next one for a while: the poller reads those that
    /// were left to it, but for the connection that it is going to run.
    pub fn pass_on(&self, but_for: Option<u64>) {
        let ready = lock(&self.0.ready);
        if ready.holds(|registered| Some(registered.id) != but_for) {
            self.0.wake();
        }
    }

    /// Reads it.
    pub fn read(&mut self, Next(registered, pooled): Next) -> Option<Message> {
        let message = match pooled {
            Some(pooled) => self.0.read(&registered, pooled, &mut None),
            None => {
                let mut buffer = vec![0; FEW_BYTES];
                match self.0.fill(&registered, &mut buffer) {
                    Err(message) => message,
                    Ok(filled) => {
                        buffer.truncate(filled);
                        Some(Message::Bytes(registered.id, Batch { buffer, pooled: None, filled }))
                    }
                }
            }
        };
        self.0.done(&registered, bytes_of(&message));
        message
    }
}

//! Reads sockets on the render thread, when it would sleep otherwise.
//!
//! In: the poller's queue of readable sockets. Out: messages, as the reader thread sends them. Runs
//! on the render thread. Promises that it never blocks, and that a socket is read by one thread at
//! a time.

use super::poll::{FEW_BYTES, Registered, Shared, bytes_of, lock};
use super::report::{Trouble, report};
use crate::buffer_pool::PooledBuffer;
use crate::message::{Batch, Message};
use std::sync::Arc;

/// The render thread's reader of sockets in the ready queue: one at a time, without blocking.
pub(crate) struct InlineReader(pub(super) Arc<Shared>);

/// A socket that the render thread is about to read, into a pooled buffer or, if its last read was
/// short, into a small one. Its earlier bytes must be taken from the channel first.
pub(crate) struct Next(Arc<Registered>, Option<PooledBuffer>);

impl InlineReader {
    /// Takes the next readable socket, if there is one and a free buffer.
    pub fn next(&mut self) -> Option<Next> {
        let pooled = self.0.buffers.try_acquire()?;
        self.ask();
        let registered = lock(&self.0.ready).next()?;
        Some(Next(registered, Some(pooled)))
    }

    /// Takes the next readable socket whose last read was short, if there is one.
    pub fn next_interactive(&mut self) -> Option<Next> {
        let next = || lock(&self.0.ready).next_interactive();
        let registered = next().or_else(|| {
            self.ask();
            next()
        });
        Some(Next(registered?, None))
    }

    fn ask(&self) {
        match self.0.ask(None) {
            Ok(false) => {}
            // It was meant for the poller's thread, which may be about to sleep.
            Ok(true) => self.0.selector.wake(),
            Err(e) => report(Trouble::Watching, format_args!("cannot ask for connections' bytes: {e}")),
        }
    }

    /// Wakes the poller's thread to read the queued sockets, because the render thread will not
    /// read for a while. Does nothing if only the connection `but_for`, which runs next, is queued.
    pub fn pass_on(&self, but_for: Option<u64>) {
        if !self.0.is_asleep() {
            return;
        }
        let ready = lock(&self.0.ready);
        if ready.holds(|registered| Some(registered.id) != but_for && ready.may_read(registered)) {
            self.0.wake();
        }
    }

    /// Reads the socket once. Returns the message for the render thread, if there is one.
    pub fn read(&mut self, Next(registered, pooled): Next) -> Option<Message> {
        let message = match pooled {
            Some(pooled) => self.0.read(&registered, pooled, &mut None),
            None => {
                let mut buffer = [0; FEW_BYTES];
                match self.0.fill(&registered, &mut buffer) {
                    Err(message) => message,
                    Ok(filled) => {
                        let buffer = buffer[..filled].to_vec();
                        Some(Message::Bytes(registered.id, Batch { buffer, pooled: None, filled }))
                    }
                }
            }
        };
        self.0.done(&registered, bytes_of(&message));
        message
    }
}

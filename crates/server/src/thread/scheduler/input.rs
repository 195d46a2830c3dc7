//! Input of the render thread: the sockets that it reads itself, the messages of other threads, and
//! its sleep when there are none.
//!
//! In: readable sockets, messages, the display's inputs. Out: received messages. Runs on the render
//! thread. Promises that it sleeps only when there is nothing to do, and not past the next
//! deadline. Tested by the latencies of `benches/socket.rs`.

use super::{INTERACTIVE_AT_ONCE, INTERACTIVE_EVERY, Scheduler};
use crate::message::Finish;
use crate::transport::Next;
use crossbeam_channel::select;
use std::time::{Duration, Instant};

impl Scheduler {
    /// Reads, between slices, the sockets whose last read was short. Short requests then do not
    /// wait for the reader thread, which the system may schedule after many senders.
    pub(super) fn read_interactive(&mut self) {
        if self.ran_since < INTERACTIVE_EVERY {
            return;
        }
        self.ran_since = Duration::ZERO;
        for _ in 0..INTERACTIVE_AT_ONCE {
            let Some(next) = self.inline_reader.next_interactive() else { return };
            self.read_now(next);
        }
    }

    fn read_now(&mut self, next: Next) {
        // Earlier bytes of this socket may still be in the channel: they come first.
        self.receive_all();
        if let Some(message) = self.inline_reader.read(next) {
            self.receive(message);
        }
    }

    /// Reads a socket that is ready; if there is none, sleeps until a message, input or a deadline.
    pub(super) fn wait(&mut self) {
        let until = self.next_deadline();
        if let Some(next) = self.inline_reader.next() {
            self.read_now(next);
            return;
        }
        // No socket is ready, or no buffer is free.
        self.inline_reader.pass_on(None);
        let timeout = match until {
            Some(until) => until.saturating_duration_since(Instant::now()),
            None => Duration::from_secs(3600),
        };
        select! {
            recv(self.messages) -> message => match message {
                Ok(message) => self.receive(message),
                // Unreachable: the scheduler holds a sender itself.
                Err(_) => self.finish = Some(Finish::Now),
            },
            recv(self.inputs) -> input => if let Ok(input) = input {
                self.input(input);
            },
            default(timeout) => {}
        }
    }
}

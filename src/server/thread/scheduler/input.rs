//! Input of the render thread: sockets that it reads by itself, messages of other threads, and its
//! sleep when there are none.
//!
//! In: readable sockets, messages, the display's inputs. Out: received messages. Runs on the render
//! thread. Promises that it sleeps only when there is nothing to do, and not past the next due time.
//! Tested by the latencies of `benches/socket.rs`.

use super::{INTERACTIVE_AT_ONCE, INTERACTIVE_EVERY, Scheduler};
use crate::server::thread::Finish;
use crate::server::transport::Next;
use crossbeam_channel::select;
use std::time::{Duration, Instant};

impl Scheduler {
    /// Reads, between slices, the sockets whose last read was short. This keeps short requests from
    /// waiting for the reader thread, which the system may run after many senders.
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
        // What came of this socket before comes first.
        self.receive_all();
        if let Some(message) = self.inline_reader.read(next) {
            self.receive(message);
        }
    }

    /// Sleeps until there is something to do.
    pub(super) fn wait(&mut self) {
        let until = self.next_deadline();
        if let Some(next) = self.inline_reader.next() {
            self.read_now(next);
            return;
        }
        // There was none, or no buffer for it.
        self.inline_reader.pass_on(None);
        let timeout = match until {
            Some(until) => until.saturating_duration_since(Instant::now()),
            None => Duration::from_secs(3600),
        };
        select! {
            recv(self.messages) -> message => match message {
                Ok(message) => self.receive(message),
                // The loop holds a sender itself: this cannot be.
                Err(_) => self.finish = Some(Finish::Now),
            },
            recv(self.inputs) -> input => if let Ok(input) = input {
                self.input(input);
            },
            default(timeout) => {}
        }
    }
}

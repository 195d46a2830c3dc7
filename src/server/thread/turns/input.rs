//! Where input comes from: sockets that the render thread reads by itself, and its sleep when there is
//! none.
//!
//! In: the sockets that can be read, messages, the display's inputs. Out: messages received. Runs on the
//! render thread. Promises that it sleeps only when there is nothing to do, and not past what is due.
//! One would know by the latencies of `benches/socket.rs`.

use super::{BRIEF_AT_ONCE, BRIEF_EVERY, Loop};
use crate::server::thread::Finish;
use crate::server::transport::Next;
use crossbeam_channel::select;
use std::time::{Duration, Instant};

impl Loop {
    /// Between turns of others, reads the sockets of those who ask for little: neither the readers' round nor the system,
    /// which may let many senders run before a reader, shall keep them waiting.
    pub(super) fn read_brief(&mut self) {
        if self.ran_since < BRIEF_EVERY {
            return;
        }
        self.ran_since = Duration::ZERO;
        for _ in 0..BRIEF_AT_ONCE {
            let Some(next) = self.hand.next_brief() else { return };
            self.read_now(next);
        }
    }

    fn read_now(&mut self, next: Next) {
        // What came of this socket before comes first.
        self.receive_all();
        if let Some(message) = self.hand.read(next) {
            self.receive(message);
        }
    }

    /// Sleeps until there is something to do.
    pub(super) fn wait(&mut self) {
        let until = self.next_deadline();
        if let Some(next) = self.hand.next() {
            self.read_now(next);
            return;
        }
        // There was none, or no buffer for it.
        self.hand.pass_on(None);
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

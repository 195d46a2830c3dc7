//! WHO READS: when the render thread reads sockets by itself.
//!
//! Two threads are faster than one where both have enough to do. With long rows, which are copied and no more, running a
//! batch takes less time than waking up the thread that is to run it, and than reading it: then the render thread reads
//! where it would sleep otherwise. What counts is how long reading and running a byte took of late, where bytes come in bulk.

use super::message::Message;
use crate::server::transport::{Hand, Next};
use std::time::{Duration, Instant};

/// Running is light when it takes less than so many times what reading takes.
const LIGHT: f64 = 1.5;
/// Fewer bytes say nothing about how long a byte takes.
const BULK_BYTES: u64 = 16 << 10;

pub(super) struct Reading {
    hand: Hand,
    /// Nanoseconds a byte.
    read_cost: f64,
    run_cost: f64,
}

/// A mean that forgets; a thread that was pushed aside does not spoil it.
fn learn(mean: &mut f64, bytes: u64, took: Duration) {
    let sample = took.as_nanos() as f64 / bytes as f64;
    *mean += (sample.min(4.0 * *mean + 0.02) - *mean) / 8.0;
}

impl Reading {
    pub fn new(hand: Hand) -> Self {
        // As measured where this was written; better is known soon.
        Reading { hand, read_cost: 0.12, run_cost: 0.1 }
    }

    /// A turn ran so many bytes in this time.
    pub fn note_turn(&mut self, bytes: u64, took: Duration) {
        if bytes >= BULK_BYTES {
            learn(&mut self.run_cost, bytes, took);
        }
    }

    /// A socket that the render thread may read when it has nothing to run.
    pub fn next(&mut self) -> Option<Next> {
        match self.run_cost < LIGHT * self.read_cost {
            true => self.hand.next(),
            false => None,
        }
    }

    /// Reads it.
    pub fn read(&mut self, next: Next) -> Option<Message> {
        let begun = Instant::now();
        let message = self.hand.read(next);
        if let Some(Message::Bytes(_, batch)) = &message
            && batch.filled as u64 >= BULK_BYTES
        {
            learn(&mut self.read_cost, batch.filled as u64, begun.elapsed());
        }
        message
    }
}

//! The run queues: which connection runs next, and how much where the display is paused.
//!
//! In: the queues of connections that can run, and what the user asked of a paused display. Out:
//! one connection and its pace. Runs on the render thread. Promises that interactive connections
//! have every other slice at most, and that a paused display runs single steps alone. One would
//! know by `tests/serving/display.rs` and `tests/serving/fairness.rs`.

use super::Scheduler;
use crate::server::Pace;
use crate::server::thread::connection::Connection;
use crate::server::thread::message::Id;

impl Scheduler {
    /// Takes the connection that runs next, and how much it may run: none while the display is
    /// paused, but for single steps.
    pub(super) fn next_slice(&mut self) -> Option<(Id, Pace)> {
        if self.run_queue.is_empty() && self.interactive_queue.is_empty() {
            return None;
        }
        match self.engine.display() {
            Some(display) if display.is_paused() && !display.is_closed() => {
                return self.continue_step().or_else(|| self.begin_step());
            }
            _ => self.step = None,
        }
        Some((self.pop_next()?, Pace::Free))
    }

    /// Goes on with the step that has begun, if its connection has something to run.
    fn continue_step(&mut self) -> Option<(Id, Pace)> {
        let Step { id, pace, .. } = self.step?;
        self.take_from_queue(id).then_some((id, pace))
    }

    /// Takes this connection from its queue. Returns whether it was there.
    fn take_from_queue(&mut self, id: Id) -> bool {
        for queue in [&mut self.interactive_queue, &mut self.run_queue] {
            if let Some(at) = queue.iter().position(|queued| *queued == id) {
                queue.remove(at);
                return true;
            }
        }
        false
    }

    /// Begins the step that the user asked for: a frame where `AUTO` is off, else a command. One that waits for a client
    /// to go on is given up.
    fn begin_step(&mut self) -> Option<(Id, Pace)> {
        if !self.engine.display().is_some_and(|display| display.take_step()) {
            return None;
        }
        // While a command is in pieces only its connection can do a step.
        let id = match self.in_pieces {
            Some(id) => self.take_from_queue(id).then_some(id)?,
            None => self.pop_next()?,
        };
        let pace = if self.engine.is_frozen() { Pace::OneFrame } else { Pace::OneCommand };
        let before = self.progress_of(id, pace);
        self.step = Some(Step { id, pace, before });
        Some((id, pace))
    }

    /// Counts a step's connection up to its end.
    pub(super) fn progress_of(&self, id: Id, pace: Pace) -> u64 {
        match pace {
            Pace::OneFrame => self.engine.frames(),
            _ => self.connections.get(&id).map_or(0, Connection::commands),
        }
    }

    /// Takes the next connection from the queues.
    fn pop_next(&mut self) -> Option<Id> {
        self.was_interactive =
            !self.interactive_queue.is_empty() && (!self.was_interactive || self.run_queue.is_empty());
        let queue = if self.was_interactive { &mut self.interactive_queue } else { &mut self.run_queue };
        queue.pop_front()
    }
}

/// A step of a paused display: a frame or a command of one connection.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub(super) id: Id,
    pub(super) pace: Pace,
    /// The connection's progress when it began.
    pub(super) before: u64,
}

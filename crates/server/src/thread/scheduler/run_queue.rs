//! The run queues: selects the connection that runs next, and its pace while the display is paused.
//!
//! In: the queues of runnable connections, and the steps that the user asks of a paused display.
//! Out: one connection and its pace. Runs on the render thread. Promises that interactive
//! connections get every other slice at most, and that a paused display runs single steps only.
//! Tested by `tests/serving/display.rs` and `tests/serving/fairness.rs`.

use super::Scheduler;
use crate::Pace;
use crate::message::Id;
use crate::thread::connection::Connection;

impl Scheduler {
    /// Takes the connection that runs next from its queue, with its pace. While the display is
    /// paused, returns connections for single steps only.
    pub(super) fn next_slice(&mut self) -> Option<(Id, Pace)> {
        if self.run_queue.is_empty() && self.interactive_queue.is_empty() {
            return None;
        }
        match &self.display {
            Some(display) if display.is_paused() && !display.is_closed() => {
                return self.continue_step().or_else(|| self.begin_step());
            }
            _ => self.step = None,
        }
        Some((self.pop_next()?, Pace::Free))
    }

    /// Continues the unfinished step, if its connection is runnable.
    fn continue_step(&mut self) -> Option<(Id, Pace)> {
        let Step { id, pace, .. } = self.step?;
        self.take_from_queue(id).then_some((id, pace))
    }

    /// Removes a connection from its queue. Returns whether it was in one.
    fn take_from_queue(&mut self, id: Id) -> bool {
        for queue in [&mut self.interactive_queue, &mut self.run_queue] {
            if let Some(at) = queue.iter().position(|queued| *queued == id) {
                queue.remove(at);
                return true;
            }
        }
        false
    }

    /// Begins a step if the user asked for one: a frame if `AUTO` is off, a command otherwise. An
    /// unfinished step, which waits for its client, is dropped.
    fn begin_step(&mut self) -> Option<(Id, Pace)> {
        if !self.display.as_ref().is_some_and(|display| display.take_step()) {
            return None;
        }
        // While a command is in pieces, only its connection can do a step.
        let id = match self.in_pieces {
            Some(id) => self.take_from_queue(id).then_some(id)?,
            None => self.pop_next()?,
        };
        let pace = if self.engine.is_frozen() { Pace::OneFrame } else { Pace::OneCommand };
        let before = self.progress_of(id, pace);
        self.step = Some(Step { id, pace, before });
        Some((id, pace))
    }

    /// Returns a count that grows when a step of this connection is complete: frames or commands.
    pub(super) fn progress_of(&self, id: Id, pace: Pace) -> u64 {
        match pace {
            Pace::OneFrame => self.engine.frames(),
            _ => self.connections.get(&id).map_or(0, Connection::commands),
        }
    }

    /// Takes the next connection from the queues; interactive ones get every other slice.
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
    /// The connection's count of frames or commands when the step began.
    pub(super) before: u64,
}

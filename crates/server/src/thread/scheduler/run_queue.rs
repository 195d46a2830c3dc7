//! The run queues: selects the connection that runs next, and its pace while the display is paused.
//!
//! In: the queues of runnable connections, and the steps that the user asks of a paused display.
//! Out: one connection and its pace. Runs on the render thread. Promises that interactive
//! connections get every other slice at most, and that a paused display runs single steps only: a
//! step ends when the display shows something new, so commands that only set something are part of
//! the step that follows them.
//! Tested by `tests/serving/display.rs` and `tests/serving/fairness.rs`.

use super::Scheduler;
use crate::Pace;
use crate::message::Id;

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
        let Step { id, .. } = self.step?;
        self.take_from_queue(id).then_some((id, self.step_pace()))
    }

    /// Returns the pace of a slice of a step: to the next frame while `AUTO` is off, else one command.
    fn step_pace(&self) -> Pace {
        if self.engine.is_frozen() { Pace::OneFrame } else { Pace::OneCommand }
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

    /// Begins a step if the user asked for one. An unfinished step, which waits for its client, is
    /// dropped.
    fn begin_step(&mut self) -> Option<(Id, Pace)> {
        if !self.display.as_ref().is_some_and(|display| display.take_step()) {
            return None;
        }
        // While a command is in pieces, only its connection can do a step.
        let id = match self.in_pieces {
            Some(id) => self.take_from_queue(id).then_some(id)?,
            None => self.pop_next()?,
        };
        self.step = Some(Step { id, before: self.shown_version() });
        Some((id, self.step_pace()))
    }

    /// Returns the version of the shown frame, which grows when a step is complete.
    pub(super) fn shown_version(&self) -> u64 {
        self.display.as_ref().map_or(0, |display| display.version())
    }

    /// Takes the next connection from the queues; interactive ones get every other slice.
    fn pop_next(&mut self) -> Option<Id> {
        self.was_interactive =
            !self.interactive_queue.is_empty() && (!self.was_interactive || self.run_queue.is_empty());
        let queue = if self.was_interactive { &mut self.interactive_queue } else { &mut self.run_queue };
        queue.pop_front()
    }
}

/// A step of a paused display: commands of one connection until the display shows something new.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub(super) id: Id,
    /// The version of the shown frame when the step began.
    pub(super) before: u64,
}

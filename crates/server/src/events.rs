//! Messages from the window to the render thread.

use fbptr_core::input::InputEvent;

/// Input from the window to the render thread.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// An event for the clients that listen to events.
    Event(InputEvent),
    /// A flag of the display has changed (paused, step, closed, frame shown, probe) and must be
    /// read.
    Look,
}

//! A function that is called with each frame that `PRESENT` ends, as an observer of the engine.

use fbptr_core::memory::VideoMemory;
use fbptr_engine::engine::{Event, FrameView, Observer};
use std::fmt;

/// Calls a function with the memory at every `PRESENT`, before any later command runs.
pub struct OnPresent(Box<dyn FnMut(&VideoMemory) + Send>);

impl OnPresent {
    /// Creates the observer that calls `action`.
    pub fn new(action: impl FnMut(&VideoMemory) + Send + 'static) -> Self {
        OnPresent(Box::new(action))
    }
}

impl fmt::Debug for OnPresent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "OnPresent")
    }
}

impl Observer for OnPresent {
    fn event(&mut self, event: &Event<'_>, frame: FrameView<'_>) {
        if let Event::Presented = event {
            (self.0)(frame.memory);
        }
    }

    fn follows_figures(&self) -> bool {
        false
    }
}

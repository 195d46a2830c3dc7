//! The display as an observer of the engine: shows finished frames, and what was drawn between them.
//!
//! In: the engine's events. Out: rows of the frame on the [`Display`]. Runs on the render thread.
//! Promises that a display which no connection has frozen follows the memory, with at most one
//! frame in [`SHOW_EVERY`] beside those of `PRESENT`.

use super::Display;
use fbptr_command::Command;
use fbptr_engine::engine::{Event, FrameView, Observer, PendingRows, Request};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Shortest time between two frames, except those of `PRESENT`.
const SHOW_EVERY: Duration = Duration::from_millis(15);

/// Shows an engine's memory on a display of the frame's size.
#[derive(Debug)]
pub struct DisplayObserver {
    display: Arc<Display>,
    /// Rows that have changed since the display was last updated.
    unshown: PendingRows,
    shown_at: Instant,
}

impl DisplayObserver {
    /// Creates the observer, to which all rows are new.
    pub fn new(display: Arc<Display>) -> Self {
        let mut unshown = PendingRows::default();
        unshown.add(&(0..display.height()));
        DisplayObserver { display, unshown, shown_at: Instant::now() }
    }

    /// Returns the display.
    pub fn display(&self) -> &Arc<Display> {
        &self.display
    }

    /// Shows the changed rows, and the number of the frame.
    fn show(&mut self, frame: FrameView<'_>) {
        self.display.publish(frame.memory, self.unshown.take(), frame.frames, frame.depth);
    }

    /// Shows the changed rows unless a connection has frozen the display.
    fn follow(&mut self, frame: FrameView<'_>) {
        if !frame.is_frozen && !self.unshown.is_empty() {
            self.show(frame);
        }
    }
}

impl Observer for DisplayObserver {
    fn event(&mut self, event: &Event<'_>, frame: FrameView<'_>) {
        match event {
            Event::Attached(budget) => {
                let display = (self.display.width(), self.display.height());
                assert_eq!(display, (frame.memory.width(), frame.memory.height()));
                self.display.reserve_copy(budget);
                // So that whatever is shown later is a change.
                self.show(frame);
            }
            Event::Changed(rows) => self.unshown.add(rows),
            Event::Presented => self.show(frame),
            Event::Show => self.follow(frame),
            Event::Tick(now) if *now >= self.shown_at + SHOW_EVERY && !self.unshown.is_empty() => {
                self.follow(frame);
                self.shown_at = *now;
            }
            Event::Begins { request: Request::Command(Command::Title { text }), .. } => {
                self.display.set_title(text.clone());
            }
            Event::Listeners(count) => self.display.set_listeners(*count),
            _ => {}
        }
    }

    fn follows_figures(&self) -> bool {
        false
    }

    fn is_shown(&self, frame: u64) -> bool {
        self.display.is_closed() || self.display.frame_on_screen() >= frame
    }

    fn deadline(&self, _: Instant, is_frozen: bool) -> Option<Instant> {
        (!is_frozen && !self.unshown.is_empty()).then(|| self.shown_at + SHOW_EVERY)
    }
}

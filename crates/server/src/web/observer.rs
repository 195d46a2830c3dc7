//! The feed of the browsers as an observer of the engine.
//!
//! In: the engine's events. Out: rows of the frame on the feed's display. Runs on the render
//! thread. Promises: without a viewer that is ready for a frame, nothing is copied, except frames
//! of a display that a connection has frozen (`AUTO off`): those end with `PRESENT`, and the memory
//! does not keep them. `PRESENT wait` never waits for a browser.

use super::WebFeed;
use fbptr_command::Command;
use fbptr_core::memory::{MemoryUse, Reservation};
use fbptr_engine::engine::{Event, FrameView, Observer, PendingRows, Request};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Shortest time between two frames, except those of a frozen display.
const SHOW_EVERY: Duration = Duration::from_millis(30);
/// Copies of the frame that the page needs at most: the display's, the web thread's two, and the
/// tiles as they are sent.
const COPIES: u64 = 4;

/// Puts an engine's memory on a feed of the frame's size.
#[derive(Debug)]
pub struct WebObserver {
    feed: Arc<WebFeed>,
    /// Rows that have changed since the feed was last updated.
    unshown: PendingRows,
    /// Set if a `PRESENT` has come since then.
    is_new_frame: bool,
    shown_at: Instant,
    held: Option<Reservation>,
}

impl WebObserver {
    /// Creates the observer, to which all rows are new.
    pub fn new(feed: Arc<WebFeed>) -> Self {
        let mut unshown = PendingRows::default();
        unshown.add(&(0..feed.display().height()));
        WebObserver { feed, unshown, is_new_frame: true, shown_at: Instant::now(), held: None }
    }

    fn show(&mut self, frame: FrameView<'_>) {
        self.is_new_frame = false;
        self.feed.display().publish(frame.memory, self.unshown.take(), frame.frames, None);
        self.feed.note_frame();
    }

    fn has_news(&self) -> bool {
        self.is_new_frame || !self.unshown.is_empty()
    }
}

impl Observer for WebObserver {
    fn event(&mut self, event: &Event<'_>, frame: FrameView<'_>) {
        match event {
            Event::Attached(budget) => {
                let display = (self.feed.display().width(), self.feed.display().height());
                assert_eq!(display, (frame.memory.width(), frame.memory.height()));
                // Not refused if memory is short: whoever runs the server asked for it.
                let mut held = budget.empty(MemoryUse::Frame);
                held.set(COPIES * frame.memory.bytes().len() as u64);
                self.held = Some(held);
            }
            Event::Changed(rows) => self.unshown.add(rows),
            Event::Presented => {
                self.is_new_frame = true;
                if frame.is_frozen {
                    self.show(frame);
                }
            }
            Event::Show if !frame.is_frozen && self.has_news() && self.feed.is_requested() => {
                self.show(frame)
            }
            Event::Tick(now) if !frame.is_frozen && self.has_news() && *now >= self.shown_at + SHOW_EVERY => {
                // The flag first: a wish that comes after it finds it, and wakes this thread.
                self.feed.hold_back(true);
                if self.feed.is_requested() {
                    self.show(frame);
                    self.shown_at = *now;
                    self.feed.hold_back(false);
                }
            }
            Event::Begins { request: Request::Command(Command::Title { text }), .. } => {
                self.feed.display().set_title(text.clone());
                self.feed.wake_web();
            }
            Event::Listeners(count) => {
                self.feed.display().set_listeners(*count);
                self.feed.wake_web();
            }
            _ => {}
        }
    }

    fn follows_figures(&self) -> bool {
        false
    }

    fn deadline(&self, now: Instant, is_frozen: bool) -> Option<Instant> {
        let due = self.shown_at + SHOW_EVERY;
        // Once it is due and not wanted, the web thread wakes this one.
        (!is_frozen && self.has_news() && (now < due || self.feed.is_requested())).then_some(due)
    }
}

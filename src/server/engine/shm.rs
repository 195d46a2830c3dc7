//! The shared file: reads what other processes wrote, and writes what the engine drew.
//!
//! Foreign pixels are taken in when the doorbell has rung, before a slice if the last scan is some
//! milliseconds old, and at least every [`LOOK_EVERY`]. Drawn pixels are given out before replies
//! are sent, and soon after drawing if there are none.

use super::Engine;
use super::queries::{NO_ROWS, join};
use crate::error::Fault;
use crate::memory::{SharedError, SharedFile};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Longest time between two scans, so that foreign writes are seen within 50 ms: this, one scan and
/// one slice.
const LOOK_EVERY: Duration = Duration::from_millis(35);
/// Time between two checks of the doorbell.
const LISTEN_EVERY: Duration = Duration::from_millis(8);
/// Shortest time between two scans before slices, and the same as a multiple of a scan's duration.
const LOOK_APART: Duration = Duration::from_millis(4);
const LOOK_SHARE: u32 = 10;

/// The function to call when sharing ends.
#[derive(Default)]
pub(super) struct OnSharedFailure(Option<SharedFailureAction>);

type SharedFailureAction = Box<dyn FnMut(&SharedError) + Send>;

impl std::fmt::Debug for OnSharedFailure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "OnSharedFailure({})", self.0.is_some())
    }
}

/// The shared file, and when it was last read and written.
#[derive(Debug)]
pub(super) struct Shared {
    file: SharedFile,
    /// Rows that have changed and are not in the file yet.
    ungiven: Range<u32>,
    given_at: Instant,
    looked_at: Instant,
    look_took: Duration,
    bell: u64,
}

impl Engine {
    /// Shares the video memory in a file: the memory takes the file's contents.
    ///
    /// # Panics
    /// If the file's size differs from the frame's.
    pub fn set_shared_file(&mut self, mut file: SharedFile) {
        assert_eq!((file.width(), file.height()), (self.memory.width(), self.memory.height()));
        file.load_into(&mut self.memory);
        let (now, bell) = (Instant::now(), file.doorbell());
        let shared =
            Shared { file, ungiven: NO_ROWS, given_at: now, looked_at: now, look_took: Duration::ZERO, bell };
        self.shared_file = Some(shared);
        self.record_memory();
    }

    /// Takes in foreign writes to the shared file if that is due. Called before each slice.
    pub fn before_slice(&mut self, now: Instant) {
        let Some(shared) = &self.shared_file else { return };
        let apart = LOOK_APART.max(shared.look_took * LOOK_SHARE).min(LOOK_EVERY);
        if shared.file.doorbell() != shared.bell || now >= shared.looked_at + apart {
            self.take_in();
        }
    }

    /// Writes what was drawn to the shared file. Called before replies are sent.
    pub fn before_replies(&mut self) {
        if self.shared_file.is_some() {
            self.give_out();
        }
    }

    /// Does the work on the shared file that is due at `now`.
    pub(super) fn tick_shared(&mut self, now: Instant) {
        let Some(shared) = &self.shared_file else { return };
        let (has_rung, is_old) =
            (shared.file.doorbell() != shared.bell, now >= shared.looked_at + LOOK_EVERY);
        let gives = now >= shared.given_at + LISTEN_EVERY;
        if (has_rung || is_old) && !self.is_in_pieces {
            self.take_in();
        }
        if has_rung && !self.is_in_pieces {
            self.show();
        }
        if gives {
            self.give_out();
        }
    }

    /// Returns the time of the next [`Engine::tick_shared`], if there is a shared file.
    pub(super) fn shared_deadline(&self, now: Instant) -> Option<Instant> {
        self.shared_file.as_ref().map(|_| now + LISTEN_EVERY)
    }

    fn take_in(&mut self) {
        let Some(shared) = &mut self.shared_file else { return };
        let begun = Instant::now();
        // The doorbell is read first: a write after this scan will ring it again.
        shared.bell = shared.file.doorbell();
        let taken = match &mut self.recorder {
            None => shared.file.take_in(&mut self.memory, |_| ()),
            Some(recorder) => {
                let mut changed = Vec::new();
                let taken = shared.file.take_in(&mut self.memory, |pixel| changed.push(pixel));
                recorder.foreign_pixels(&changed, &self.memory);
                taken
            }
        };
        shared.looked_at = Instant::now();
        shared.look_took = shared.looked_at - begun;
        taken.unwrap_or_else(|error| self.stop_sharing(&error));
    }

    fn give_out(&mut self) {
        self.collect_damage();
        let Some(shared) = &mut self.shared_file else { return };
        let rows = std::mem::replace(&mut shared.ungiven, NO_ROWS);
        shared.given_at = Instant::now();
        if rows.start < rows.end {
            let given = shared.file.give_out(&self.memory, rows);
            given.unwrap_or_else(|error| self.stop_sharing(&error));
        }
    }

    /// Ends the sharing; the engine continues without the file.
    fn stop_sharing(&mut self, error: &SharedError) {
        self.shared_file = None;
        self.shared_failure = Some(error.to_string());
        if let Some(notify) = &mut self.on_shared_failure.0 {
            notify(error);
        }
    }

    /// Sets the function to call when sharing ends early; the engine continues without the file.
    pub fn set_on_shared_failure(&mut self, action: impl FnMut(&SharedError) + Send + 'static) {
        self.on_shared_failure = OnSharedFailure(Some(Box::new(action)));
    }

    /// Returns the reason why sharing has ended early, if it has.
    pub fn shared_failure(&self) -> Option<&str> {
        self.shared_failure.as_deref()
    }

    /// Returns the shared file's state, for `STATS`.
    pub(super) fn shared_word(&self) -> &'static str {
        match (&self.shared_file, &self.shared_failure) {
            (Some(_), _) => "ok",
            (None, Some(_)) => "failed",
            (None, None) => "off",
        }
    }

    /// Marks rows as not yet written to the file.
    pub(super) fn owe_shared(&mut self, rows: &Range<u32>) {
        if let Some(shared) = &mut self.shared_file {
            shared.ungiven = join(&shared.ungiven, rows);
        }
    }

    /// Publishes the frame's number to the processes that map the file, after its pixels.
    pub(super) fn publish_frame(&mut self) {
        self.give_out();
        if let Some(shared) = &self.shared_file {
            shared.file.set_frame(self.frames);
        }
    }

    /// Writes the last pixels and closes the shared file.
    pub(super) fn leave_shared(&mut self) {
        self.give_out();
        self.shared_file = None;
    }
}

/// Converts an error of the shared file to a fault.
impl From<crate::memory::SharedError> for Fault {
    fn from(e: crate::memory::SharedError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

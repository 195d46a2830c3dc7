//! The engine's side of the shared file: when foreign writes are taken in, and when ours are given out.
//!
//! Taken in: when the bell rang, before a slice if the last look is some milliseconds old, and at least every
//! [`LOOK_EVERY`]. Given out: before replies leave, and soon after drawing where there are none.

use super::Engine;
use super::queries::{NO_ROWS, join};
use crate::error::Fault;
use crate::memory::{SharedError, SharedFile};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Foreign writes are seen within 50 ms: this, and what a look and a slice take.
const LOOK_EVERY: Duration = Duration::from_millis(35);
/// How often the bell is listened for.
const LISTEN_EVERY: Duration = Duration::from_millis(8);
/// Between looks before slices, at least; and so many times what a look takes.
const LOOK_APART: Duration = Duration::from_millis(4);
const LOOK_SHARE: u32 = 10;

/// The function that is told of the end of sharing.
#[derive(Default)]
pub(super) struct OnSharedFailure(Option<SharedFailureAction>);

type SharedFailureAction = Box<dyn FnMut(&SharedError) + Send>;

impl std::fmt::Debug for OnSharedFailure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "OnSharedFailure({})", self.0.is_some())
    }
}

/// The shared file and what is known of it.
#[derive(Debug)]
pub(super) struct Shared {
    file: SharedFile,
    /// Rows drawn that are not in the file yet.
    ungiven: Range<u32>,
    given_at: Instant,
    looked_at: Instant,
    look_took: Duration,
    bell: u64,
}

impl Engine {
    /// Puts the video memory into a shared file: the memory becomes what the file holds.
    ///
    /// # Panics
    /// When the file has another size than the frame.
    pub fn set_shared_file(&mut self, mut file: SharedFile) {
        assert_eq!((file.width(), file.height()), (self.memory.width(), self.memory.height()));
        file.load_into(&mut self.memory);
        let (now, bell) = (Instant::now(), file.doorbell());
        let shared =
            Shared { file, ungiven: NO_ROWS, given_at: now, looked_at: now, look_took: Duration::ZERO, bell };
        self.shared_file = Some(shared);
        self.record_memory();
    }

    /// To be called before a slice of commands: takes in what others wrote into the shared file.
    pub fn before_slice(&mut self, now: Instant) {
        let Some(shared) = &self.shared_file else { return };
        let apart = LOOK_APART.max(shared.look_took * LOOK_SHARE).min(LOOK_EVERY);
        if shared.file.doorbell() != shared.bell || now >= shared.looked_at + apart {
            self.take_in();
        }
    }

    /// To be called before replies go out: what was drawn is in the shared file then.
    pub fn before_replies(&mut self) {
        if self.shared_file.is_some() {
            self.give_out();
        }
    }

    /// What is due at `now` for the shared file.
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

    /// When the shared file wants to be looked at next.
    pub(super) fn shared_deadline(&self, now: Instant) -> Option<Instant> {
        self.shared_file.as_ref().map(|_| now + LISTEN_EVERY)
    }

    fn take_in(&mut self) {
        let Some(shared) = &mut self.shared_file else { return };
        let begun = Instant::now();
        // The bell first: what is written after this look will ring again.
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

    /// Goes on without the shared file, which is of no use any more.
    fn stop_sharing(&mut self, error: &SharedError) {
        self.shared_file = None;
        self.shared_failure = Some(error.to_string());
        if let Some(notify) = &mut self.on_shared_failure.0 {
            notify(error);
        }
    }

    /// Calls `action` when the shared file can be shared no more; the engine goes on without it.
    pub fn set_on_shared_failure(&mut self, action: impl FnMut(&SharedError) + Send + 'static) {
        self.on_shared_failure = OnSharedFailure(Some(Box::new(action)));
    }

    /// Why the shared file is shared no more, if that is so.
    pub fn shared_failure(&self) -> Option<&str> {
        self.shared_failure.as_deref()
    }

    /// The shared file's state, for `STATS`.
    pub(super) fn shared_word(&self) -> &'static str {
        match (&self.shared_file, &self.shared_failure) {
            (Some(_), _) => "ok",
            (None, Some(_)) => "failed",
            (None, None) => "off",
        }
    }

    /// Remembers rows that the file has not got yet.
    pub(super) fn owe_shared(&mut self, rows: &Range<u32>) {
        if let Some(shared) = &mut self.shared_file {
            shared.ungiven = join(&shared.ungiven, rows);
        }
    }

    /// Tells those who map the file that a frame has ended: its pixels are there first.
    pub(super) fn publish_frame(&mut self) {
        self.give_out();
        if let Some(shared) = &self.shared_file {
            shared.file.set_frame(self.frames);
        }
    }

    /// The last pixels and nobody at work any more.
    pub(super) fn leave_shared(&mut self) {
        self.give_out();
        self.shared_file = None;
    }
}

/// A `Fault` for a shared file that cannot be used.
impl From<crate::memory::SharedError> for Fault {
    fn from(e: crate::memory::SharedError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

//! The shared file as an observer of the engine: takes in what other processes wrote, and gives out
//! what the engine drew.
//!
//! In: the engine's events, and foreign writes to the file. Out: the same pixels in the memory and
//! in the file. Foreign pixels are taken in when the doorbell has rung, before a slice if the last
//! scan is some milliseconds old, and at least every [`LOOK_EVERY`]. Drawn pixels are given out
//! before replies are sent, and soon after drawing if there are none. Runs on the render thread. If
//! the file fails, the sharing ends and the engine continues.

use fbptr_core::memory::{SHARED_HEADER_BYTES, SharedError, SharedFile, VideoMemory};
use fbptr_engine::engine::{
    Event, FrameView, Observer, Occasion, OutputState, OutputStatus, PendingRows, PixelRuns,
};
use std::fmt;
use std::time::{Duration, Instant};

/// Longest time between two scans, so that foreign writes are seen within 50 ms: this, one scan and
/// one slice.
const LOOK_EVERY: Duration = Duration::from_millis(35);
/// Time between two checks of the doorbell.
const LISTEN_EVERY: Duration = Duration::from_millis(8);
/// Shortest time between two scans before slices, and the same as a multiple of a scan's duration.
const LOOK_APART: Duration = Duration::from_millis(4);
const LOOK_SHARE: u32 = 10;

type OnFailure = Box<dyn FnMut(&SharedError) + Send>;

/// Returns the state of the output: with or without a file, programs learn its layout.
pub(super) fn output(state: OutputState, memory: &VideoMemory) -> OutputStatus {
    let figures =
        vec![("shm_offset", SHARED_HEADER_BYTES as u64), ("shm_stride", memory.stride_bytes() as u64)];
    OutputStatus { name: "shm", state, figures }
}

/// Shares an engine's video memory in a file, whose contents the memory takes first.
pub struct FileSharing {
    /// `None` once the sharing has ended.
    file: Option<SharedFile>,
    has_failed: bool,
    on_failure: OnFailure,
    /// Rows that have changed and are not in the file yet.
    ungiven: PendingRows,
    given_at: Instant,
    looked_at: Instant,
    look_took: Duration,
    bell: u64,
}

impl fmt::Debug for FileSharing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FileSharing({:?})", self.file)
    }
}

impl FileSharing {
    /// Shares in `file`, which must have the frame's size. `on_failure` is called if the sharing
    /// ends early.
    pub fn new(file: SharedFile, on_failure: impl FnMut(&SharedError) + Send + 'static) -> Self {
        let (now, bell) = (Instant::now(), file.doorbell());
        FileSharing {
            file: Some(file),
            has_failed: false,
            on_failure: Box::new(on_failure),
            ungiven: PendingRows::default(),
            given_at: now,
            looked_at: now,
            look_took: Duration::ZERO,
            bell,
        }
    }

    /// Copies all of the file into the memory.
    fn load(&mut self, memory: &mut VideoMemory, changed: Option<&mut PixelRuns>) {
        let Some(file) = &mut self.file else { return };
        assert_eq!((file.width(), file.height()), (memory.width(), memory.height()));
        file.load_into(memory);
        if let Some(changed) = changed {
            (0..memory.width() * memory.height()).for_each(|pixel| changed.push(pixel));
        }
    }

    /// Copies foreign writes into the memory.
    fn scan(&mut self, memory: &mut VideoMemory, changed: Option<&mut PixelRuns>) {
        let Some(file) = &mut self.file else { return };
        let begun = Instant::now();
        // The doorbell is read first: a write after this scan will ring it again.
        self.bell = file.doorbell();
        let taken = match changed {
            None => file.take_in(memory, |_| ()),
            Some(changed) => file.take_in(memory, |pixel| changed.push(pixel as u32)),
        };
        self.looked_at = Instant::now();
        self.look_took = self.looked_at - begun;
        taken.unwrap_or_else(|error| self.stop(&error));
    }

    /// Copies what was drawn into the file.
    fn give_out(&mut self, memory: &VideoMemory) {
        let Some(file) = &mut self.file else { return };
        self.given_at = Instant::now();
        let rows = self.ungiven.take();
        if !rows.is_empty() {
            file.give_out(memory, rows).unwrap_or_else(|error| self.stop(&error));
        }
    }

    /// Ends the sharing early.
    fn stop(&mut self, error: &SharedError) {
        (self.file, self.has_failed) = (None, true);
        (self.on_failure)(error);
    }
}

impl Observer for FileSharing {
    fn event(&mut self, event: &Event<'_>, frame: FrameView<'_>) {
        match event {
            Event::Changed(rows) => self.ungiven.add(rows),
            Event::Replies => self.give_out(frame.memory),
            Event::Tick(now) if *now >= self.given_at + LISTEN_EVERY => self.give_out(frame.memory),
            Event::Presented => {
                self.give_out(frame.memory);
                // The number of the frame comes after its pixels.
                self.file.iter().for_each(|file| file.set_frame(frame.frames));
            }
            Event::End => {
                self.give_out(frame.memory);
                self.file = None;
            }
            _ => {}
        }
    }

    fn follows_figures(&self) -> bool {
        false
    }

    fn take_in(
        &mut self,
        memory: &mut VideoMemory,
        occasion: Occasion,
        changed: Option<&mut PixelRuns>,
    ) -> bool {
        let Some(file) = &self.file else { return false };
        let has_rung = file.doorbell() != self.bell;
        match occasion {
            Occasion::Attached => self.load(memory, changed),
            Occasion::Slice(now) => {
                let apart = LOOK_APART.max(self.look_took * LOOK_SHARE).min(LOOK_EVERY);
                if has_rung || now >= self.looked_at + apart {
                    self.scan(memory, changed);
                }
            }
            Occasion::Tick(now) => {
                if has_rung || now >= self.looked_at + LOOK_EVERY {
                    self.scan(memory, changed);
                }
                return has_rung;
            }
        }
        false
    }

    fn deadline(&self, now: Instant, _: bool) -> Option<Instant> {
        self.file.as_ref().map(|_| now + LISTEN_EVERY)
    }

    fn output(&self, frame: FrameView<'_>) -> Option<OutputStatus> {
        let state = match (&self.file, self.has_failed) {
            (Some(_), _) => OutputState::On,
            (None, true) => OutputState::Failed,
            (None, false) => OutputState::Off,
        };
        Some(output(state, frame.memory))
    }
}

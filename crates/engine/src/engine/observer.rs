//! Observers of the engine: whatever follows its commands and frames, such as a recording or a
//! display.
//!
//! In: events, in the order in which they happen, each with the frame at that moment. Out: what the
//! observer makes of them; pixels of other writers, if it has any; its state for `STATS`. Everything
//! runs on the thread that has the engine, which waits meanwhile. The engine knows observers by this
//! trait alone: `tests/cli/layers/lists.rs` holds that it imports none of them.

use super::request::Request;
use super::status::OutputStatus;
use crate::clock::Instant;
use crate::read_files::ReadFile;
use fbptr_core::draw2d::Blend;
use fbptr_core::memory::{DepthMemory, MemoryBudget, VideoMemory};
use std::any::Any;
use std::fmt::Debug;
use std::ops::Range;

/// Something that follows what an engine does.
pub trait Observer: Any + Debug + Send {
    /// Handles an event.
    fn event(&mut self, event: &Event<'_>, frame: FrameView<'_>);

    /// Stores into the memory, if that is due, what others than clients have written, and adds the
    /// pixels that it changes to `changed`, if they are asked for. Returns whether they must be
    /// shown at once.
    fn take_in(
        &mut self,
        _memory: &mut VideoMemory,
        _occasion: Occasion,
        _changed: Option<&mut PixelRuns>,
    ) -> bool {
        false
    }

    /// Returns whether it needs the contents of the files that commands read, and the pixels that
    /// others write. They are not collected if no observer does.
    fn wants_contents(&self) -> bool {
        false
    }

    /// Returns whether it needs the events of every figure. Where no observer does, figures are drawn
    /// without a request of their own, and several at once; their rows come as [`Event::Changed`].
    fn follows_figures(&self) -> bool {
        true
    }

    /// Returns whether `PRESENT wait` for this frame can be answered.
    fn is_shown(&self, _frame: u64) -> bool {
        true
    }

    /// Returns the time of the next [`Event::Tick`], if it needs one.
    fn deadline(&self, _now: Instant, _is_frozen: bool) -> Option<Instant> {
        None
    }

    /// Returns the state of its output, if it has one that `STATS` should name.
    fn output(&self, _frame: FrameView<'_>) -> Option<OutputStatus> {
        None
    }
}

/// The engine's frame at the moment of an event.
#[derive(Clone, Copy, Debug)]
pub struct FrameView<'a> {
    /// The video memory.
    pub memory: &'a VideoMemory,
    /// The depth buffer, if any draw has needed one.
    pub depth: Option<&'a DepthMemory>,
    /// Number of `PRESENT` commands so far.
    pub frames: u64,
    /// True if a connection has frozen the display until its next `PRESENT`.
    pub is_frozen: bool,
}

/// An event of an engine.
///
/// A request is `Received` once. `Begins` stands before each part of it that may change anything,
/// and is followed by `Done` if the request has then taken effect, otherwise by `Undone`. If a
/// defect left a part of it in the memory, `Pixels` follow.
#[derive(Debug)]
pub enum Event<'a> {
    /// The observer was attached. What it holds may be reserved from this budget.
    Attached(&'a MemoryBudget),
    /// A connection begins.
    Opened {
        /// Number of the connection.
        connection: u64,
        /// Its initial blend mode.
        blend: Blend,
    },
    /// A connection has ended.
    Closed {
        /// Number of the connection.
        connection: u64,
    },
    /// A request was received. It may still be refused.
    Received(&'a Request<'a>),
    /// A request is about to run.
    Begins {
        /// Number of the connection, 0 for the engine itself.
        connection: u64,
        /// Its OFFSET.
        offset: [i32; 2],
        /// The request.
        request: &'a Request<'a>,
    },
    /// The request that began has taken effect.
    Done {
        /// Number of the connection.
        connection: u64,
        /// Files that it has read, if any observer wants contents.
        files: &'a [ReadFile],
    },
    /// The request that began was refused, or has left its effect to a later part.
    Undone,
    /// The contents of pixels, in runs of consecutive pixel numbers, do not come from requests
    /// alone.
    Pixels(&'a [Range<u32>]),
    /// Rows of the memory have changed.
    Changed(Range<u32>),
    /// A frame was ended by `PRESENT`.
    Presented,
    /// Changed rows are to be shown at once, unless the display is frozen.
    Show,
    /// Replies will be sent: what was drawn before them must be seen by whoever reads them.
    Replies,
    /// The number of clients that listen to events of the window has changed.
    Listeners(usize),
    /// A slice begins: the time of the requests that follow.
    Slice(Instant),
    /// A moment between two slices, at the next deadline at the latest.
    Tick(Instant),
    /// The engine ends.
    End,
}

/// Moment at which an observer may take in pixels.
#[derive(Clone, Copy, Debug)]
pub enum Occasion {
    /// The moment of its attachment.
    Attached,
    /// Before a slice.
    Slice(Instant),
    /// Between two slices.
    Tick(Instant),
}

/// Pixels by their numbers, in runs of consecutive ones.
#[derive(Debug, Default)]
pub struct PixelRuns(Vec<Range<u32>>);

impl PixelRuns {
    /// Adds a pixel.
    #[inline]
    pub fn push(&mut self, pixel: u32) {
        match self.0.last_mut() {
            Some(run) if run.end == pixel => run.end += 1,
            _ => self.0.push(pixel..pixel + 1),
        }
    }

    /// Returns the runs.
    pub fn runs(&self) -> &[Range<u32>] {
        &self.0
    }
}

/// Changed rows that an observer has not handled yet: the smallest range that contains them.
#[derive(Debug, Default)]
pub struct PendingRows(Range<u32>);

impl PendingRows {
    /// Adds rows.
    pub fn add(&mut self, rows: &Range<u32>) {
        self.0 = match self.0.is_empty() {
            true => rows.clone(),
            false => self.0.start.min(rows.start)..self.0.end.max(rows.end),
        };
    }

    /// Returns whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Takes the rows, of which none are left.
    pub fn take(&mut self) -> Range<u32> {
        std::mem::take(self).0
    }
}

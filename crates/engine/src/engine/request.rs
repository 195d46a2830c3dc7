//! Requests: one command, or a batch of them whose bytes stay in the decoder's buffer.
//!
//! In: commands and batches, decoded and valid. Out: the same, with what all kinds have in common:
//! how many commands they are, of which verb. A batch passes the engine's door once.

use super::dispatch::{is_made_by_job, is_pixelflut};
use fbptr_command::{BINARY_PIXEL_BYTES, Command, Rect};
use fbptr_core::draw2d::Line;
use fbptr_core::memory::Rgba;

/// A connection's request, which the engine runs as one.
#[derive(Debug)]
pub enum Request<'a> {
    /// One command.
    Command(Command),
    /// A text `PX`, before OFFSET, without a [`Command`].
    Pixel {
        /// Column.
        x: i32,
        /// Row.
        y: i32,
        /// Its colour.
        color: Rgba,
    },
    /// Text pixels, before OFFSET: x and y as little-endian u16, r, g, b, a.
    Pixels(&'a [[u8; 8]]),
    /// Complete `PB` records of 10 bytes each.
    BinaryPixels(&'a [u8]),
    /// Consecutive `LINE`s.
    Lines(&'a [Line]),
    /// `PXMULTI`.
    PixelRun {
        /// Column of the first pixel.
        x: u16,
        /// Row of the first pixel.
        y: u16,
        /// RGBA bytes.
        rgba: &'a [u8],
    },
    /// `BLIT`.
    Blit {
        /// The rectangle.
        rect: Rect,
        /// Its rows of RGBA bytes.
        rgba: &'a [u8],
    },
    /// `POINTS`: x and y as little-endian u16, r, g, b, a.
    Points(&'a [u8]),
}

impl Request<'_> {
    /// Returns the number of commands.
    #[inline]
    pub fn count(&self) -> usize {
        match self {
            Request::Pixels(records) => records.len(),
            Request::BinaryPixels(records) => records.len() / BINARY_PIXEL_BYTES,
            Request::Lines(lines) => lines.len(),
            _ => 1,
        }
    }

    /// Returns the verb of the commands.
    pub fn verb(&self) -> &'static str {
        match self {
            Request::Command(command) => command.verb(),
            Request::Pixel { .. } | Request::Pixels(_) => "PX",
            Request::BinaryPixels(_) => "PB",
            Request::Lines(_) => "LINE",
            Request::PixelRun { .. } => "PXMULTI",
            Request::Blit { .. } => "BLIT",
            Request::Points(_) => "POINTS",
        }
    }

    /// Returns whether a connection that sends this may be a plain Pixelflut client.
    #[inline]
    pub(super) fn is_pixelflut(&self) -> bool {
        match self {
            Request::Command(command) => is_pixelflut(command),
            Request::Pixel { .. }
            | Request::Pixels(_)
            | Request::BinaryPixels(_)
            | Request::PixelRun { .. } => true,
            Request::Lines(_) | Request::Blit { .. } | Request::Points(_) => false,
        }
    }

    /// Returns whether a job always makes the effect of this request: its result is what is
    /// recorded.
    #[inline]
    pub(super) fn is_made_by_job(&self) -> bool {
        matches!(self, Request::Command(command) if is_made_by_job(command))
    }
}

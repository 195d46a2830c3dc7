//! What takes the commands that a decoder makes.

use super::commands::{Command, Rect};
use super::stream_error::StreamError;
use crate::memory::{Reservation, Rgba};

/// Where a command begins in its stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StreamPosition {
    /// 1 + the LF bytes before it, those in payloads and binary commands included.
    pub line: u64,
    /// Bytes before it.
    pub byte: u64,
}

impl StreamPosition {
    /// Where every stream begins.
    pub const START: StreamPosition = StreamPosition { line: 1, byte: 0 };
}

/// Whether the decoder shall go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[must_use]
pub enum Flow {
    /// Go on.
    Continue,
    /// Read nothing more for now: [`super::Decoder::feed_some`] returns with what it has taken.
    Pause,
    /// Read nothing more of this stream, ever: QUIT came, or the connection is to close.
    Stop,
}

/// What takes the commands of a stream, in order.
///
/// A flood of pixels comes through [`Sink::pixels`] and [`Sink::binary_pixels`], without a [`Command`] being made. A
/// connection's OFFSET is not applied here: the sink does that, to text pixels and to `Command::GetPixel` alone.
pub trait Sink {
    /// A text `PX x y colour`, not moved by OFFSET yet.
    fn pixel(&mut self, x: i32, y: i32, color: Rgba);

    /// Several of them, in order, where they were written plainly: x and y as u16 little-endian, r, g, b, a.
    #[inline]
    fn pixels(&mut self, records: &[[u8; 8]]) {
        for &[x0, x1, y0, y1, color @ ..] in records {
            self.pixel(u16::from_le_bytes([x0, x1]).into(), u16::from_le_bytes([y0, y1]).into(), color);
        }
    }

    /// Whole binary pixels in a row, 10 bytes each as they came: `PB`, x and y as u16 little-endian, r, g, b, a.
    /// [`binary_pixel`] reads one.
    fn binary_pixels(&mut self, records: &[u8]);

    /// Any other command, whole and checked.
    fn command(&mut self, command: Command, place: StreamPosition) -> Flow;

    /// Takes over what the payload of the next [`Sink::command`] holds of the memory budget, where
    /// the bytes go to that command: they are counted once, by whoever holds them.
    fn payload_held(&mut self, held: Reservation) {
        drop(held);
    }

    /// A command that was refused, or a stream that is out of order. After one that closes the stream
    /// ([`StreamError::closes`]) the decoder stops by itself.
    fn error(&mut self, error: StreamError) -> Flow;

    /// `PXMULTI`: RGBA bytes of a run of pixels, linear from (x, y). The bytes are the decoder's: what is kept is copied.
    fn pixel_run(&mut self, x: u16, y: u16, rgba: &[u8], place: StreamPosition) -> Flow {
        self.command(Command::PixelRun { x, y, rgba: rgba.to_vec() }, place)
    }

    /// `BLIT`: RGBA rows, as many bytes as the rectangle has.
    fn blit(&mut self, rect: Rect, rgba: &[u8], place: StreamPosition) -> Flow {
        self.command(Command::Blit { rect, rgba: rgba.to_vec() }, place)
    }

    /// `POINTS`: 8 bytes a pixel, see [`Command::Points`].
    fn points(&mut self, packed: &[u8], place: StreamPosition) -> Flow {
        self.command(Command::Points { packed: packed.to_vec() }, place)
    }
}

/// Bytes of a binary pixel.
pub const BINARY_PIXEL_BYTES: usize = 10;

/// The x, y and colour of one `PB` record.
#[inline]
pub fn binary_pixel(record: &[u8; BINARY_PIXEL_BYTES]) -> (u16, u16, Rgba) {
    let [_, _, x0, x1, y0, y1, r, g, b, a] = *record;
    (u16::from_le_bytes([x0, x1]), u16::from_le_bytes([y0, y1]), [r, g, b, a])
}

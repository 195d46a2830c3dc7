//! The interface between a decoder and the consumer of its commands.

use super::commands::{Command, Figure, Rect};
use super::stream_error::{StreamError, StreamPosition};
use fbptr_core::memory::{Reservation, Rgba};

/// Tells the decoder whether to continue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[must_use]
pub enum Flow {
    /// Continue with the next command.
    Continue,
    /// Stop reading for the moment: [`super::Decoder::feed_some`] returns with what it has
    /// consumed.
    Pause,
    /// Read nothing more of this stream: QUIT was received, or the connection is to be closed.
    Stop,
}

/// Consumer of a stream's commands, in order.
///
/// Pixels arrive in bulk through [`Sink::pixels`] and [`Sink::binary_pixels`], without a
/// [`Command`] for each. The connection's OFFSET is not applied by the decoder: the sink applies
/// it, to text pixels and to `Command::GetPixel` only.
pub trait Sink {
    /// Receives a text `PX x y colour`, before OFFSET.
    fn pixel(&mut self, x: i32, y: i32, color: Rgba);

    /// Receives several plainly written text pixels in order, before OFFSET, 8 bytes each: x and y
    /// as u16 little-endian, r, g, b, a.
    #[inline]
    fn pixels(&mut self, records: &[[u8; 8]]) {
        for &[x0, x1, y0, y1, color @ ..] in records {
            self.pixel(u16::from_le_bytes([x0, x1]).into(), u16::from_le_bytes([y0, y1]).into(), color);
        }
    }

    /// Receives consecutive complete binary pixels, 10 bytes each as on the wire: `PB`, x and y as
    /// u16 little-endian, r, g, b, a. [`binary_pixel`] decodes one.
    fn binary_pixels(&mut self, records: &[u8]);

    /// Receives any other command, complete and validated. `place` is where it begins.
    fn command(&mut self, command: Command, place: StreamPosition) -> Flow;

    /// Receives a figure that was written plainly; others are commands.
    #[inline]
    fn figure(&mut self, figure: Figure, place: StreamPosition) -> Flow {
        self.command(Command::Figure(figure), place)
    }

    /// Receives the reservation of the memory budget that covers the payload of the next
    /// [`Sink::command`], when that command takes over the buffer: the bytes are counted once, by
    /// the owner of the buffer.
    fn payload_held(&mut self, held: Reservation) {
        drop(held);
    }

    /// Receives the error of a refused command or of a stream that breaks the protocol. After an
    /// error that closes the stream ([`StreamError::closes`]) the decoder stops by itself.
    fn error(&mut self, error: StreamError) -> Flow;

    /// Receives `PXMULTI`: RGBA bytes of a run of pixels, linear from (x, y). `rgba` is the
    /// decoder's buffer, valid during the call only.
    fn pixel_run(&mut self, x: u16, y: u16, rgba: &[u8], place: StreamPosition) -> Flow {
        self.command(Command::PixelRun { x, y, rgba: rgba.to_vec() }, place)
    }

    /// Receives `BLIT`, unless it is longer than 16 MiB, which is a command: RGBA rows, exactly as many bytes as the rectangle has. `rgba` is the
    /// decoder's buffer, valid during the call only.
    fn blit(&mut self, rect: Rect, rgba: &[u8], place: StreamPosition) -> Flow {
        self.command(Command::Blit { rect, rgba: rgba.to_vec() }, place)
    }

    /// Receives `POINTS`: 8 bytes per pixel, see [`Command::Points`]. `packed` is the decoder's
    /// buffer, valid during the call only.
    fn points(&mut self, packed: &[u8], place: StreamPosition) -> Flow {
        self.command(Command::Points { packed: packed.to_vec() }, place)
    }
}

/// Bytes of one binary pixel.
pub const BINARY_PIXEL_BYTES: usize = 10;

/// Returns x, y and colour of one `PB` record.
#[inline]
pub fn binary_pixel(record: &[u8; BINARY_PIXEL_BYTES]) -> (u16, u16, Rgba) {
    let [_, _, x0, x1, y0, y1, r, g, b, a] = *record;
    (u16::from_le_bytes([x0, x1]), u16::from_le_bytes([y0, y1]), [r, g, b, a])
}

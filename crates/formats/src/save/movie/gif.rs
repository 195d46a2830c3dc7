//! Animated GIF: blocks after a header, and one byte, 3b, that ends it.
//!
//! A frame is written after that byte, followed by another 3b; then the old 3b is overwritten by
//! the frame's own first byte. Before that one-byte write the file ends where it ended; after it,
//! the frame is included. There is no state between.
//!
//! Source: CompuServe, Graphics Interchange Format, version 89a (1990).

use super::quantize::indexed;
use super::{FrameWriter, Growing, Ticks, changed_box, cut_rgb};
use fbptr_core::memory::VideoMemory;
use gif::{DisposalMethod, Encoder, Frame, Repeat};
use std::io;

/// Last byte of a GIF.
const TRAILER: u8 = 0x3b;

/// Writer of a GIF that grows by frames.
pub(super) struct GifMovie {
    file: Growing,
    size: [u16; 2],
    ticks: Ticks,
    last: Vec<u8>,
    /// Offset of the last frame's delay in the file, and its value in 1/100 second.
    delay_offset: u64,
    delay: u64,
}

impl GifMovie {
    pub fn new(file: Growing, width: u32, height: u32, rate: f64) -> Self {
        // The sides were checked against u16::MAX by `Movie::create`.
        let size = [width, height].map(|n| n as u16);
        let ticks = Ticks::new(100.0, rate);
        GifMovie { file, size, ticks, last: Vec::new(), delay_offset: 0, delay: 0 }
    }

    /// Returns a complete GIF with one frame, and the length of its header.
    fn encode(&self, frame: &Frame<'_>) -> io::Result<(Vec<u8>, usize)> {
        let refused = |e: gif::EncodingError| io::Error::other(e);
        let mut encoder = Encoder::new(Vec::new(), self.size[0], self.size[1], &[]).map_err(refused)?;
        encoder.set_repeat(Repeat::Infinite).map_err(refused)?;
        let header_bytes = encoder.get_ref().len();
        encoder.write_frame(frame).map_err(refused)?;
        let bytes = encoder.into_inner()?;
        Ok((bytes, header_bytes))
    }
}

impl FrameWriter for GifMovie {
    fn frame(&mut self, memory: &VideoMemory) -> io::Result<()> {
        let width = memory.width();
        let ticks = self.ticks.next();
        let whole = [0, 0, width, memory.height()];
        let area = match self.last.is_empty() {
            true => whole,
            false => match changed_box(&self.last, memory.bytes(), width) {
                Some(area) => area,
                None if self.delay + ticks <= u64::from(u16::MAX) => {
                    self.delay += ticks;
                    let delay = (self.delay as u16).to_le_bytes();
                    return self.file.write_at(self.delay_offset, &delay);
                }
                None => [0, 0, 1, 1],
            },
        };
        let (indices, palette) = indexed(&cut_rgb(memory.bytes(), width, area));
        let mut frame = Frame::from_palette_pixels(area[2] as u16, area[3] as u16, indices, palette, None);
        (frame.left, frame.top) = (area[0] as u16, area[1] as u16);
        (frame.delay, frame.dispose) = (ticks as u16, DisposalMethod::Keep);
        let (bytes, header_bytes) = self.encode(&frame)?;
        let start = match self.last.is_empty() {
            true => {
                self.file.begin(&bytes)?;
                header_bytes as u64
            }
            false => {
                let (trailer, block) = (self.file.length - 1, &bytes[header_bytes..]);
                self.file.write_at(trailer + 1, &block[1..])?;
                self.file.write_at(trailer, &block[..1])?;
                self.file.length += block.len() as u64 - 1;
                trailer
            }
        };
        debug_assert_eq!(bytes[header_bytes..header_bytes + 3], [0x21, 0xf9, 4]);
        debug_assert_eq!(bytes.last(), Some(&TRAILER));
        // The block is 21 f9 04, one byte of flags, then the delay.
        (self.delay_offset, self.delay) = (start + 4, ticks);
        self.last.clear();
        self.last.extend_from_slice(memory.bytes());
        Ok(())
    }
}

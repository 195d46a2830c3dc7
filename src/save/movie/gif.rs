//! GIF: blocks after a header, and one byte, 3b, that ends it.
//!
//! A frame is written behind that byte, with another 3b behind itself; then the old 3b is overwritten by the frame's own
//! first byte. Before that one-byte write the file ends where it ended; after it, the frame is in. No moment between.
//! Source: CompuServe, Graphics Interchange Format, version 89a (1990).

use super::{FrameWriter, Growing, Ticks, changed_box, cut_rgb};
use crate::memory::VideoMemory;
use gif::{DisposalMethod, Encoder, Frame, Repeat};
use std::collections::HashMap;
use std::io;

/// Ends a GIF.
const TRAILER: u8 = 0x3b;
/// So many pixels for each step of NeuQuant's sampling: 1 is the best, 20 fast enough for the largest frames.
const PIXELS_PER_SPEED: usize = 25_000;

/// A GIF that grows.
pub(super) struct GifMovie {
    file: Growing,
    size: [u16; 2],
    ticks: Ticks,
    last: Vec<u8>,
    /// Where the last frame's delay stands, and what it is.
    delay_offset: u64,
    delay: u64,
}

impl GifMovie {
    pub fn new(file: Growing, width: u32, height: u32, rate: f64) -> Self {
        // The sides were checked.
        let size = [width, height].map(|n| n as u16);
        let ticks = Ticks::new(100.0, rate);
        GifMovie { file, size, ticks, last: Vec::new(), delay_offset: 0, delay: 0 }
    }

    /// The bytes of a whole GIF with one frame; the header's length.
    fn encode(&self, frame: &Frame<'_>) -> io::Result<(Vec<u8>, usize)> {
        let refused = |e: gif::EncodingError| io::Error::other(e);
        let mut encoder = Encoder::new(Vec::new(), self.size[0], self.size[1], &[]).map_err(refused)?;
        encoder.set_repeat(Repeat::Infinite).map_err(refused)?;
        let header_bytes = encoder.get_ref().len();
        encoder.write_frame(frame).map_err(refused)?;
        let bytes = encoder.into_inner().map_err(refused)?;
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
        let mut frame = indexed(&cut_rgb(memory.bytes(), width, area), area[2] as u16, area[3] as u16);
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
        // 21 f9 04 flags, then the delay.
        (self.delay_offset, self.delay) = (start + 4, ticks);
        self.last.clear();
        self.last.extend_from_slice(memory.bytes());
        Ok(())
    }
}

/// A frame of at most 256 colours: the very ones where there are no more, else chosen by NeuQuant.
fn indexed(rgb: &[u8], width: u16, height: u16) -> Frame<'static> {
    let mut palette: Vec<u8> = Vec::new();
    let mut numbers: HashMap<[u8; 3], u8> = HashMap::new();
    let mut indices = Vec::with_capacity(rgb.len() / 3);
    let mut last = ([0; 3], None);
    for &pixel in rgb.as_chunks::<3>().0 {
        if last.0 != pixel || last.1.is_none() {
            let number = match (numbers.get(&pixel), numbers.len()) {
                (Some(&number), _) => number,
                (None, 256..) => {
                    let speed = (rgb.len() / 3 / PIXELS_PER_SPEED).clamp(1, 20) as i32;
                    return Frame::from_rgb_speed(width, height, rgb, speed);
                }
                (None, count) => {
                    palette.extend_from_slice(&pixel);
                    numbers.insert(pixel, count as u8);
                    count as u8
                }
            };
            last = (pixel, Some(number));
        }
        indices.extend(last.1);
    }
    Frame::from_palette_pixels(width, height, indices, palette, None)
}

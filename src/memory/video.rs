//! The frame itself: one flat array of R,G,B,A bytes.

use super::FbPtr;
use super::aligned::Aligned;
use crate::error::Code;
use crate::simd::fill_pixels;
use std::ops::Range;

/// A pixel as it lies in memory: R, G, B, A.
pub type Rgba = [u8; 4];

/// The largest width or height of a frame, in pixels.
pub const MAX_SIDE: u32 = 32_768;

/// Why video memory could not be made, read or written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MemoryError {
    /// A frame needs 1 to [`MAX_SIDE`] pixels a side.
    #[error("a frame has 1 to {MAX_SIDE} pixels a side, not {width}x{height}")]
    BadSize {
        /// Pixels asked for, across.
        width: u32,
        /// Pixels asked for, down.
        height: u32,
    },
    /// The system has no room for the frame.
    #[error("no room for {bytes} bytes of video memory")]
    NoRoom {
        /// Bytes asked for.
        bytes: u64,
    },
    /// Bytes outside the memory.
    #[error("bytes {offset}..{} are outside the memory's 0..{size}", .offset.saturating_add(*.len))]
    Outside {
        /// First byte asked for.
        offset: u64,
        /// Bytes asked for.
        len: u64,
        /// Bytes there are.
        size: u64,
    },
    /// A pixel outside the frame.
    #[error("pixel ({x},{y}) is outside the frame's {width}x{height}")]
    NoPixel {
        /// Column asked for.
        x: i64,
        /// Row asked for.
        y: i64,
        /// The frame's width in pixels.
        width: u32,
        /// The frame's height in pixels.
        height: u32,
    },
}

impl MemoryError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            MemoryError::BadSize { .. } | MemoryError::NoRoom { .. } => Code::TooBig,
            MemoryError::Outside { .. } | MemoryError::NoPixel { .. } => Code::Range,
        }
    }
}

/// An empty damage range: every row is below its start and above its end.
const NO_ROWS: Range<u32> = Range { start: u32::MAX, end: 0 };

/// The emulated video memory: `width * height * 4` bytes, cleared to opaque black.
///
/// Drawing that leaves the frame is clipped silently; asking for a byte or a pixel outside is an error.
/// Rows that were written are remembered until [`VideoMemory::take_damage`] asks for them.
#[derive(Clone, Debug)]
pub struct VideoMemory {
    width: u32,
    height: u32,
    bytes: Aligned<u8>,
    /// Rows written since the damage was last taken; empty when start >= end.
    damage: Range<u32>,
    /// The rows that figures are drawn on; all but where a figure is drawn in bands.
    window: Range<u32>,
}

impl VideoMemory {
    /// What every byte group is cleared to: opaque black.
    pub const CLEAR: Rgba = [0, 0, 0, 255];

    /// A frame of `width` x `height` pixels, opaque black.
    pub fn new(width: u32, height: u32) -> Result<Self, MemoryError> {
        let side = 1..=MAX_SIDE;
        if !side.contains(&width) || !side.contains(&height) {
            return Err(MemoryError::BadSize { width, height });
        }
        let size = width as u64 * height as u64 * 4;
        let no_room = MemoryError::NoRoom { bytes: size };
        let len = usize::try_from(size).map_err(|_| no_room.clone())?;
        let bytes = Aligned::new(len, 0).ok_or(no_room)?;
        let mut memory = VideoMemory { width, height, bytes, damage: 0..height, window: 0..height };
        memory.clear(Self::CLEAR);
        Ok(memory)
    }

    /// Width in pixels.
    #[inline]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    #[inline]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Bytes from one row to the next: `width * 4`, no padding.
    pub fn stride_bytes(&self) -> usize {
        self.width as usize * 4
    }

    /// All bytes, row 0 first.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// All bytes, for writing. The caller says which rows it wrote with [`VideoMemory::mark_rows`].
    #[inline]
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }

    /// The bytes of row `y`, or `None` below the frame.
    pub fn row(&self, y: u32) -> Option<&[u8]> {
        self.bytes.chunks_exact(self.stride_bytes()).nth(y as usize)
    }

    /// Fills rows of the frame with `color`.
    pub fn clear_rows(&mut self, rows: Range<u32>, color: Rgba) {
        let stride = self.stride_bytes();
        let bytes =
            rows.start.min(self.height) as usize * stride..rows.end.min(self.height) as usize * stride;
        if bytes.start < bytes.end {
            fill_pixels(self.bytes[bytes].as_chunks_mut().0, color);
            self.mark_rows(rows.start..rows.end.min(self.height));
        }
    }

    /// The rows that filled figures of `draw2d` are drawn on.
    #[inline]
    pub fn window(&self) -> Range<u32> {
        self.window.clone()
    }

    /// Draws filled figures on these rows alone from now on.
    pub fn set_window(&mut self, rows: Range<u32>) {
        self.window = rows.start.min(self.height)..rows.end.min(self.height);
    }

    /// Fills the frame with `color`.
    pub fn clear(&mut self, color: Rgba) {
        fill_pixels(self.bytes.as_chunks_mut().0, color);
        self.damage = 0..self.height;
    }

    /// The byte offset of pixel (x, y), or `None` off the frame.
    #[inline]
    pub fn offset_of(&self, x: i64, y: i64) -> Option<usize> {
        ((0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y))
            .then(|| (self.width as usize * y as usize + x as usize) * 4)
    }

    /// Stores one pixel; off the frame it does nothing.
    #[doc(alias = "putPixel")]
    #[inline]
    pub fn put_pixel(&mut self, x: i32, y: i32, color: Rgba) {
        let (x, y) = (x as u32, y as u32);
        let at = u64::from(self.width) * u64::from(y) + u64::from(x);
        // With x inside, the index is outside just where y is: one question fewer on the hot path.
        if x < self.width
            && let Some(pixel) =
                self.bytes.as_chunks_mut::<4>().0.get_mut(usize::try_from(at).unwrap_or(usize::MAX))
        {
            *pixel = color;
            self.mark_row(y);
        }
    }

    /// Reads one pixel; asking outside the frame is an error.
    pub fn get_pixel(&self, x: i32, y: i32) -> Result<Rgba, MemoryError> {
        let (width, height) = (self.width, self.height);
        let at = self.offset_of(x.into(), y.into()).ok_or(MemoryError::NoPixel {
            x: x.into(),
            y: y.into(),
            width,
            height,
        })?;
        Ok(std::array::from_fn(|i| self.bytes[at + i]))
    }

    /// Reads `len` bytes at `ptr`.
    pub fn peek(&self, ptr: FbPtr, len: usize) -> Result<&[u8], MemoryError> {
        let range = self.checked_range(ptr, len)?;
        Ok(&self.bytes[range])
    }

    /// Writes `data` at `ptr`, all of it or nothing.
    pub fn poke(&mut self, ptr: FbPtr, data: &[u8]) -> Result<(), MemoryError> {
        let range = self.checked_range(ptr, data.len())?;
        let stride = self.stride_bytes();
        if !data.is_empty() {
            self.mark_rows((range.start / stride) as u32..((range.end - 1) / stride) as u32 + 1);
        }
        self.bytes[range].copy_from_slice(data);
        Ok(())
    }

    /// Reads the pixel whose first byte is at `ptr` (which need not be aligned to a pixel).
    pub fn peek_pixel(&self, ptr: FbPtr) -> Result<Rgba, MemoryError> {
        let range = self.checked_range(ptr, 4)?;
        Ok(std::array::from_fn(|i| self.bytes[range.start + i]))
    }

    /// Writes four bytes at `ptr` (which need not be aligned to a pixel).
    pub fn poke_pixel(&mut self, ptr: FbPtr, color: Rgba) -> Result<(), MemoryError> {
        self.poke(ptr, &color)
    }

    /// Remembers that row `y` was written.
    #[inline]
    pub fn mark_row(&mut self, y: u32) {
        // Written only when it grows, which is seldom: a store a pixel would crowd out the pixels' own. One question does
        // for `start..end` and for the empty range.
        let (start, end) = (self.damage.start, self.damage.end);
        if y.wrapping_sub(start) >= end.wrapping_sub(start) {
            self.grow_damage(y);
        }
    }

    #[cold]
    #[inline(never)]
    fn grow_damage(&mut self, y: u32) {
        self.damage.start = self.damage.start.min(y);
        self.damage.end = self.damage.end.max(y + 1);
    }

    /// Remembers that `rows` were written.
    #[inline]
    pub fn mark_rows(&mut self, rows: Range<u32>) {
        if rows.start < rows.end {
            self.mark_row(rows.start);
            self.mark_row(rows.end.min(self.height) - 1);
        }
    }

    /// The rows written since the last call: one half-open range, empty when nothing was written.
    pub fn take_damage(&mut self) -> Range<u32> {
        std::mem::replace(&mut self.damage, NO_ROWS)
    }

    /// Whether anything was written since the damage was last taken.
    pub fn is_damaged(&self) -> bool {
        self.damage.start < self.damage.end
    }

    fn checked_range(&self, ptr: FbPtr, len: usize) -> Result<Range<usize>, MemoryError> {
        let (offset, size) = (ptr.offset_bytes(), self.bytes.len() as u64);
        match offset.checked_add(len as u64) {
            Some(end) if end <= size => Ok(offset as usize..end as usize),
            _ => Err(MemoryError::Outside { offset, len: len as u64, size }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_opaque_black_with_all_rows_damaged() {
        let mut m = VideoMemory::new(3, 2).unwrap();
        assert_eq!(m.bytes(), [0, 0, 0, 255].repeat(6));
        assert_eq!(m.take_damage(), 0..2);
        assert!(!m.is_damaged());
    }

    #[test]
    fn sizes_that_cannot_be_had_are_refused() {
        for (w, h) in [(0, 1), (1, 0), (MAX_SIDE + 1, 1), (u32::MAX, u32::MAX)] {
            assert_eq!(VideoMemory::new(w, h).unwrap_err(), MemoryError::BadSize { width: w, height: h });
        }
    }

    #[test]
    fn pixels_off_the_frame_are_dropped_and_bytes_outside_are_errors() {
        let mut m = VideoMemory::new(4, 4).unwrap();
        m.take_damage();
        for (x, y) in [(-1, 0), (4, 0), (0, -1), (0, 4), (i32::MIN, i32::MAX)] {
            m.put_pixel(x, y, [9; 4]);
            assert!(m.get_pixel(x, y).is_err());
        }
        assert!(!m.is_damaged());
        assert!(m.bytes().iter().all(|&b| b == 0 || b == 255));
        assert_eq!(m.poke(FbPtr::new(62), &[1, 2, 3]).unwrap_err().code(), Code::Range);
        assert_eq!(m.peek(FbPtr::new(u64::MAX), 2).unwrap_err().code(), Code::Range);
        assert_eq!(m.peek(FbPtr::new(64), 0).unwrap(), &[] as &[u8]);
        m.poke(FbPtr::new(15), &[1, 2]).unwrap();
        assert_eq!(m.take_damage(), 0..2);
        assert_eq!(m.peek_pixel(FbPtr::new(13)).unwrap(), [0, 0, 1, 2]);
    }
}

//! The frame: a flat array of R, G, B, A bytes.

use super::FbPtr;
use super::aligned::Aligned;
use crate::error::{Code, Fault};
use crate::simd::fill_pixels;
use std::fmt;
use std::ops::Range;

/// Pixel in memory order: R, G, B, A.
pub type Rgba = [u8; 4];

/// Largest width or height of a frame, in pixels.
pub const MAX_SIDE: u32 = 32_768;

/// Error of creating, reading or writing video memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MemoryError {
    /// A side is not in 1..=[`MAX_SIDE`] pixels.
    BadSize {
        /// Requested width in pixels.
        width: u32,
        /// Requested height in pixels.
        height: u32,
    },
    /// The system has no memory for the frame.
    NoRoom {
        /// Requested size in bytes.
        bytes: u64,
    },
    /// The bytes are not all inside the memory.
    Outside {
        /// Offset of the first requested byte.
        offset: u64,
        /// Number of requested bytes.
        len: u64,
        /// Size of the memory in bytes.
        size: u64,
    },
    /// The pixel is outside the frame.
    NoPixel {
        /// Requested column.
        x: i64,
        /// Requested row.
        y: i64,
        /// Width of the frame in pixels.
        width: u32,
        /// Height of the frame in pixels.
        height: u32,
    },
}

impl fmt::Display for MemoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MemoryError::BadSize { width, height } => {
                write!(f, "a frame has 1 to {MAX_SIDE} pixels a side, not {width}x{height}")
            }
            MemoryError::NoRoom { bytes } => write!(f, "no room for {bytes} bytes of video memory"),
            MemoryError::Outside { offset, len, size } => {
                let end = offset.saturating_add(*len);
                write!(f, "bytes {offset}..{end} are outside the memory's 0..{size}")
            }
            MemoryError::NoPixel { x, y, width, height } => {
                write!(f, "pixel ({x},{y}) is outside the frame's {width}x{height}")
            }
        }
    }
}

impl std::error::Error for MemoryError {}

impl MemoryError {
    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            MemoryError::BadSize { .. } | MemoryError::NoRoom { .. } => Code::TooBig,
            MemoryError::Outside { .. } | MemoryError::NoPixel { .. } => Code::Range,
        }
    }
}

impl From<MemoryError> for Fault {
    fn from(e: MemoryError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

/// Empty damage range: `start` is above and `end` below every row, so that any row grows it.
const NO_ROWS: Range<u32> = Range { start: u32::MAX, end: 0 };

/// Emulated video memory: `width * height * 4` bytes, initially opaque black.
///
/// Drawing outside the frame is clipped silently; reading or writing single bytes outside is an
/// error. Written rows are recorded until [`VideoMemory::take_damage`] returns them.
#[derive(Clone, Debug)]
pub struct VideoMemory {
    width: u32,
    height: u32,
    bytes: Aligned<u8>,
    /// Rows written since the last `take_damage`; empty when start >= end.
    damage: Range<u32>,
    /// Rows that figures may touch: all, except while a figure is drawn in bands of rows.
    window: Range<u32>,
    /// Columns and rows that drawing may touch: all, unless a clip rectangle is set.
    clip: [Range<u32>; 2],
    /// Columns whose pixels may be drawn without a look at the clip rectangle and the band of rows: all
    /// or none.
    unclipped_columns: u32,
}

impl VideoMemory {
    /// Initial colour of every pixel: opaque black.
    pub const CLEAR: Rgba = [0, 0, 0, 255];

    /// Allocates a frame of `width` x `height` pixels, opaque black.
    ///
    /// # Errors
    /// If a side is not in 1..=[`MAX_SIDE`], or the system has no memory for the frame.
    pub fn new(width: u32, height: u32) -> Result<Self, MemoryError> {
        let mut memory = Self::zeroed(width, height, Aligned::zeroed)?;
        memory.clear(Self::CLEAR);
        Ok(memory)
    }

    /// Allocates a frame of `width` x `height` pixels, all of them zero. No pixel is touched.
    ///
    /// # Errors
    /// Those of [`VideoMemory::new`].
    #[doc(hidden)]
    pub fn transparent(width: u32, height: u32) -> Result<Self, MemoryError> {
        // A line across rows that were never used takes a page for each of its pixels.
        Self::zeroed(width, height, Aligned::sparse)
    }

    /// Allocates a frame in what `allocate` returns.
    fn zeroed(
        width: u32,
        height: u32,
        allocate: fn(usize) -> Option<Aligned<u8>>,
    ) -> Result<Self, MemoryError> {
        let side = 1..=MAX_SIDE;
        if !side.contains(&width) || !side.contains(&height) {
            return Err(MemoryError::BadSize { width, height });
        }
        let size = width as u64 * height as u64 * 4;
        let no_room = MemoryError::NoRoom { bytes: size };
        let len = usize::try_from(size).map_err(|_| no_room.clone())?;
        let bytes = allocate(len).ok_or(no_room)?;
        let clip = [0..width, 0..height];
        Ok(VideoMemory {
            width,
            height,
            bytes,
            damage: 0..height,
            window: 0..height,
            clip,
            unclipped_columns: width,
        })
    }

    /// Creates a frame without pixels, in the place of one that is lent.
    #[doc(hidden)]
    pub fn vacant() -> Self {
        let (bytes, clip) = (Aligned::default(), [0..0, 0..0]);
        VideoMemory { width: 0, height: 0, bytes, damage: NO_ROWS, window: 0..0, clip, unclipped_columns: 0 }
    }

    /// Returns the width in pixels.
    #[inline]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    #[inline]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the bytes from one row to the next: `width * 4`, no padding.
    pub fn stride_bytes(&self) -> usize {
        self.width as usize * 4
    }

    /// Returns all bytes, row 0 first.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns all bytes for writing. The caller reports the rows it wrote to
    /// [`VideoMemory::mark_rows`].
    #[inline]
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }

    /// Returns the bytes of row `y`, or `None` below the frame.
    pub fn row(&self, y: u32) -> Option<&[u8]> {
        self.bytes.chunks_exact(self.stride_bytes()).nth(y as usize)
    }

    /// Fills `rows` with `color`, where the clip rectangle lets it; rows below the frame are ignored.
    pub fn clear_rows(&mut self, rows: Range<u32>, color: Rgba) {
        let stride = self.stride_bytes();
        if self.is_clipped() {
            let [columns, clip_rows] = self.clip();
            let rows = rows.start.max(clip_rows.start)..rows.end.min(clip_rows.end);
            for row in self.bytes.chunks_exact_mut(stride).take(rows.end as usize).skip(rows.start as usize) {
                let (start, end) = (columns.start as usize * 4, columns.end as usize * 4);
                fill_pixels(row[start..end].as_chunks_mut().0, color);
            }
            return self.mark_rows(rows);
        }
        let bytes =
            rows.start.min(self.height) as usize * stride..rows.end.min(self.height) as usize * stride;
        if bytes.start < bytes.end {
            fill_pixels(self.bytes[bytes].as_chunks_mut().0, color);
            self.mark_rows(rows.start..rows.end.min(self.height));
        }
    }

    /// Returns the rows that figures of `draw2d` may touch.
    #[inline]
    pub fn window(&self) -> Range<u32> {
        self.window.clone()
    }

    /// Restricts figures of `draw2d` to `rows`, clamped to the frame.
    pub fn set_window(&mut self, rows: Range<u32>) {
        self.window = rows.start.min(self.height)..rows.end.min(self.height);
        self.note_limits();
    }

    /// Notes whether drawing may touch all pixels.
    fn note_limits(&mut self) {
        let is_whole = self.clip == [0..self.width, 0..self.height] && self.window == (0..self.height);
        self.unclipped_columns = if is_whole { self.width } else { 0 };
    }

    /// Returns the columns and the rows that drawing may touch: those of the frame, or of the clip
    /// rectangle.
    #[inline]
    pub fn clip(&self) -> [Range<u32>; 2] {
        self.clip.clone()
    }

    /// Returns whether a clip rectangle or a band of rows leaves out a part of the frame.
    #[inline]
    pub fn is_clipped(&self) -> bool {
        self.unclipped_columns != self.width
    }

    /// Restricts all drawing, of `draw2d` and of the pipeline, to these columns and rows, clamped to
    /// the frame. Methods of this type that write bytes or single pixels are not restricted.
    pub fn set_clip(&mut self, columns: Range<u32>, rows: Range<u32>) {
        let within = |range: Range<u32>, size: u32| {
            let start = range.start.min(size);
            start..range.end.clamp(start, size)
        };
        self.clip = [within(columns, self.width), within(rows, self.height)];
        self.note_limits();
    }

    /// Ends the restriction of [`VideoMemory::set_clip`].
    pub fn end_clip(&mut self) {
        self.clip = [0..self.width, 0..self.height];
        self.note_limits();
    }

    /// Returns whether drawing may touch pixel (x, y).
    #[inline]
    pub fn is_drawable(&self, x: i32, y: i32) -> bool {
        let [columns, rows] = &self.clip;
        columns.contains(&(x as u32)) && rows.contains(&(y as u32))
    }

    /// Fills the frame with `color`.
    pub fn clear(&mut self, color: Rgba) {
        fill_pixels(self.bytes.as_chunks_mut().0, color);
        self.damage = 0..self.height;
    }

    /// Returns the byte offset of pixel (x, y), or `None` off the frame.
    #[inline]
    pub fn offset_of(&self, x: i64, y: i64) -> Option<usize> {
        ((0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y))
            .then(|| (self.width as usize * y as usize + x as usize) * 4)
    }

    /// Stores one pixel; does nothing off the frame.
    #[doc(alias = "putPixel")]
    #[inline]
    pub fn put_pixel(&mut self, x: i32, y: i32, color: Rgba) {
        self.store_pixel(x, y, self.width, color);
    }

    /// Stores one pixel; does nothing off the frame or outside the clip rectangle.
    #[inline]
    pub fn draw_pixel(&mut self, x: i32, y: i32, color: Rgba) {
        if !self.store_pixel(x, y, self.unclipped_columns, color) {
            self.draw_clipped_pixel(x, y, color);
        }
    }

    /// Stores one pixel that may be off the frame or outside the clip rectangle.
    #[cold]
    #[inline(never)]
    fn draw_clipped_pixel(&mut self, x: i32, y: i32, color: Rgba) {
        if self.is_drawable(x, y) {
            self.put_pixel(x, y, color);
        }
    }

    /// Stores one pixel if it is on the frame and left of column `columns`, at most the width.
    /// Returns whether it is.
    #[inline]
    fn store_pixel(&mut self, x: i32, y: i32, columns: u32, color: Rgba) -> bool {
        let (x, y) = (x as u32, y as u32);
        let at = u64::from(self.width) * u64::from(y) + u64::from(x);
        // With x inside, the index is out of range exactly when y is: one comparison fewer on the
        // hot path.
        if x < columns
            && let Some(pixel) =
                self.bytes.as_chunks_mut::<4>().0.get_mut(usize::try_from(at).unwrap_or(usize::MAX))
        {
            *pixel = color;
            self.mark_row(y);
            return true;
        }
        false
    }

    /// Reads one pixel.
    ///
    /// # Errors
    /// If the pixel is outside the frame.
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
    ///
    /// # Errors
    /// If a byte is outside the memory.
    pub fn peek(&self, ptr: FbPtr, len: usize) -> Result<&[u8], MemoryError> {
        let range = self.checked_range(ptr, len)?;
        Ok(&self.bytes[range])
    }

    /// Writes all of `data` at `ptr`.
    ///
    /// # Errors
    /// If a byte is outside the memory; nothing is then written.
    pub fn poke(&mut self, ptr: FbPtr, data: &[u8]) -> Result<(), MemoryError> {
        let range = self.checked_range(ptr, data.len())?;
        let stride = self.stride_bytes();
        if !data.is_empty() {
            self.mark_rows((range.start / stride) as u32..((range.end - 1) / stride) as u32 + 1);
        }
        self.bytes[range].copy_from_slice(data);
        Ok(())
    }

    /// Reads four bytes at `ptr`, which need not be aligned to a pixel.
    ///
    /// # Errors
    /// If a byte is outside the memory.
    pub fn peek_pixel(&self, ptr: FbPtr) -> Result<Rgba, MemoryError> {
        let range = self.checked_range(ptr, 4)?;
        Ok(std::array::from_fn(|i| self.bytes[range.start + i]))
    }

    /// Writes four bytes at `ptr`, which need not be aligned to a pixel.
    ///
    /// # Errors
    /// If a byte is outside the memory; nothing is then written.
    pub fn poke_pixel(&mut self, ptr: FbPtr, color: Rgba) -> Result<(), MemoryError> {
        self.poke(ptr, &color)
    }

    /// Records that row `y` was written.
    #[inline]
    pub fn mark_row(&mut self, y: u32) {
        // Stored only when the range grows, which is seldom: a store per pixel would compete with
        // the pixels' own. One comparison serves both `start..end` and the empty range.
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

    /// Records that `rows` were written.
    #[inline]
    pub fn mark_rows(&mut self, rows: Range<u32>) {
        if rows.start < rows.end {
            self.mark_row(rows.start);
            self.mark_row(rows.end.min(self.height) - 1);
        }
    }

    /// Returns the rows written since the last call as one half-open range, and resets it to empty.
    pub fn take_damage(&mut self) -> Range<u32> {
        std::mem::replace(&mut self.damage, NO_ROWS)
    }

    /// Returns whether anything was written since the last `take_damage`.
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
    fn a_pixel_is_drawn_where_the_clip_rectangle_and_the_frame_let_it() {
        for clip in [None, Some([1..3, 1..2]), Some([0..0, 0..3]), Some([0..4, 0..3])] {
            let mut m = VideoMemory::new(4, 3).unwrap();
            if let Some([columns, rows]) = clip.clone() {
                m.set_clip(columns, rows);
            }
            let [columns, rows] = clip.clone().unwrap_or([0..4, 0..3]);
            for (x, y) in (-1..6).flat_map(|x| (-1..5).map(move |y| (x, y))).chain([(i32::MIN, i32::MAX)]) {
                m.clear(VideoMemory::CLEAR);
                m.draw_pixel(x, y, [9; 4]);
                let lit = m.bytes().as_chunks::<4>().0.iter().filter(|p| **p == [9; 4]).count();
                let is_inside = columns.contains(&(x as u32)) && rows.contains(&(y as u32));
                assert_eq!(lit, usize::from(is_inside), "({x}, {y}) in {clip:?}");
                assert!(!is_inside || m.get_pixel(x, y) == Ok([9; 4]));
            }
        }
    }

    #[test]
    fn a_clip_rectangle_is_clamped_to_the_frame_and_bounds_a_clear() {
        let mut m = VideoMemory::new(5, 4).unwrap();
        assert!(!m.is_clipped());
        m.set_clip(3..99, 1..3);
        assert_eq!((m.is_clipped(), m.clip()), (true, [3..5, 1..3]));
        assert!(m.is_drawable(4, 2) && !m.is_drawable(2, 2) && !m.is_drawable(4, 3) && !m.is_drawable(-1, 2));
        m.take_damage();
        m.clear_rows(0..2, [7; 4]);
        assert_eq!(m.take_damage(), 1..2);
        let lit = m.bytes().as_chunks::<4>().0.iter().map(|p| *p == [7; 4]).collect::<Vec<_>>();
        assert_eq!(lit.iter().enumerate().filter(|(_, l)| **l).map(|(i, _)| i).collect::<Vec<_>>(), [8, 9]);
        #[expect(clippy::reversed_empty_ranges, reason = "hostile numbers")]
        m.set_clip(9..2, 7..1);
        assert!(m.clip().iter().all(|range| range.is_empty()) && !m.is_drawable(0, 0));
        m.clear_rows(0..4, [9; 4]);
        assert!(!m.is_damaged());
        m.end_clip();
        assert!(!m.is_clipped());
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

//! Depth memory: one stored depth per pixel, in the format that the stream chose. Allocated only
//! when a scene needs it.
//!
//! Depth z runs from 0 (near) to 1 (far) and is cleared to 1. A fragment passes if its encoded
//! depth is strictly nearer than the stored one.
//!
//! Formats: u16 = round(65535 z), u24 = round((2^24-1) z), u32 = round((2^32-1) z), f32, and
//! reversed f32, which stores 1-z as the caller computed it without cancellation.
//!
//! Clears are deferred: runs of pixels of a row (cells) are marked, and their words are stored when
//! a cell is first written. Reads always return the cleared value.

use super::aligned::Aligned;
use super::pending_clear::PendingClear;
use std::ops::Range;

/// Format of stored depths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum DepthFormat {
    /// round(65535 z).
    U16,
    /// round((2^24 - 1) z).
    U24,
    /// round((2^32 - 1) z).
    U32,
    /// z as f32.
    #[default]
    F32,
    /// 1 - z as f32, larger is nearer.
    Reversed,
}

impl DepthFormat {
    /// All formats, in the protocol's order.
    pub const ALL: [DepthFormat; 5] =
        [DepthFormat::U16, DepthFormat::U24, DepthFormat::U32, DepthFormat::F32, DepthFormat::Reversed];

    /// Returns the keyword of the command language.
    pub const fn as_str(self) -> &'static str {
        match self {
            DepthFormat::U16 => "u16",
            DepthFormat::U24 => "u24",
            DepthFormat::U32 => "u32",
            DepthFormat::F32 => "f32",
            DepthFormat::Reversed => "reversed",
        }
    }

    /// Returns the bytes of one pixel's depth.
    pub const fn bytes_per_pixel(self) -> usize {
        match self {
            DepthFormat::U16 => 2,
            _ => 4,
        }
    }

    /// Encodes depth `z` in 0..=1, given with its complement `one_minus_z` (computed without
    /// cancellation), as a word. Smaller words are nearer in every format.
    #[inline]
    pub fn encode(self, z: f64, one_minus_z: f64) -> u32 {
        match self {
            DepthFormat::U16 => (z * 65535.0 + 0.5) as u32,
            DepthFormat::U24 => (z * 16_777_215.0 + 0.5) as u32,
            DepthFormat::U32 => (z * 4_294_967_295.0 + 0.5) as u32,
            // The bits of non-negative floats order as the floats do.
            DepthFormat::F32 => ((z + 0.0) as f32).to_bits(),
            DepthFormat::Reversed => !((one_minus_z + 0.0) as f32).to_bits(),
        }
    }

    /// Decodes a stored word to its depth z in 0..=1.
    pub fn decode(self, word: u32) -> f64 {
        match self {
            DepthFormat::U16 => word as f64 / 65535.0,
            DepthFormat::U24 => word as f64 / 16_777_215.0,
            DepthFormat::U32 => word as f64 / 4_294_967_295.0,
            DepthFormat::F32 => f32::from_bits(word) as f64,
            DepthFormat::Reversed => 1.0 - f32::from_bits(!word) as f64,
        }
    }
}

/// One stored depth per pixel, row 0 at the top, as words that order near to far in every format.
#[derive(Clone, Debug)]
pub struct DepthMemory {
    width: u32,
    height: u32,
    format: DepthFormat,
    words: Words,
    pending_clear: PendingClear,
}

/// Words of a depth memory with the pending clears of its cells. Whoever writes a cell must clear
/// it first.
#[derive(Debug)]
pub(crate) struct DepthCells<'a> {
    /// Words, row by row; empty in the format of 16 bits.
    pub words: &'a mut [i32],
    /// Words of the format of 16 bits, row by row; empty in the others.
    pub narrow: &'a mut [u16],
    /// One bit per cell of each row, leftmost cell in bit 0; empty if no clear is pending.
    pub pending_clear: &'a mut [u128],
    /// Word of a cleared pixel.
    pub far: i32,
}

/// Stored words of a run of pixels; see [`DepthFormat::encode`].
#[derive(Debug)]
pub enum DepthWords<'a> {
    /// Words of `U16`.
    Narrow(&'a mut [u16]),
    /// Words of every other format: the bits of the `u32`.
    Wide(&'a mut [i32]),
}

impl<'a> DepthWords<'a> {
    /// Returns the stored word of pixel number `index`.
    ///
    /// # Panics
    /// If there is no such pixel.
    #[inline]
    pub fn word(&self, index: usize) -> u32 {
        match self {
            DepthWords::Narrow(w) => w[index] as u32,
            DepthWords::Wide(w) => w[index] as u32,
        }
    }

    /// Stores the word of pixel number `index`.
    ///
    /// # Panics
    /// If there is no such pixel.
    #[inline]
    pub fn set_word(&mut self, index: usize, word: u32) {
        match self {
            DepthWords::Narrow(w) => w[index] = word as u16,
            DepthWords::Wide(w) => w[index] = word as i32,
        }
    }

    /// Splits the words before pixel number `mid`.
    ///
    /// # Panics
    /// If there are fewer than `mid` pixels.
    pub fn split_at(self, mid: usize) -> (DepthWords<'a>, DepthWords<'a>) {
        match self {
            DepthWords::Narrow(w) => {
                let (a, b) = w.split_at_mut(mid);
                (DepthWords::Narrow(a), DepthWords::Narrow(b))
            }
            DepthWords::Wide(w) => {
                let (a, b) = w.split_at_mut(mid);
                (DepthWords::Wide(a), DepthWords::Wide(b))
            }
        }
    }
}

#[derive(Clone, Debug)]
enum Words {
    Narrow(Aligned<u16>),
    Wide(Aligned<i32>),
}

impl Words {
    /// Stores a word in these pixels.
    fn fill(&mut self, pixels: Range<usize>, word: u32) {
        match self {
            Words::Narrow(w) => w[pixels].fill(word as u16),
            Words::Wide(w) => w[pixels].fill(word as i32),
        }
    }
}

impl DepthMemory {
    /// Allocates a depth memory of `width` x `height` pixels, cleared to z = 1.
    ///
    /// # Panics
    /// If the system has no memory for it.
    pub fn new(width: u32, height: u32, format: DepthFormat) -> Self {
        let len = width as usize * height as usize;
        let far = format.encode(1.0, 0.0);
        let room = "room for a frame's depths";
        let mut pending_clear = PendingClear::of_tiles(width, height);
        let words = match format {
            // The first clear is deferred as every other one.
            DepthFormat::U16 if pending_clear.add_all() => Words::Narrow(Aligned::zeroed(len).expect(room)),
            DepthFormat::U16 => Words::Narrow(Aligned::new(len, far as u16).expect(room)),
            _ if pending_clear.add_all() => Words::Wide(Aligned::zeroed(len).expect(room)),
            _ => Words::Wide(Aligned::new(len, far as i32).expect(room)),
        };
        DepthMemory { width, height, format, words, pending_clear }
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the format of the stored depths.
    pub fn format(&self) -> DepthFormat {
        self.format
    }

    /// Returns the size of the depths in bytes.
    pub fn size_bytes(&self) -> usize {
        self.width as usize * self.height as usize * self.format.bytes_per_pixel()
    }

    /// Sets every depth to 1.
    pub fn clear(&mut self) {
        let far = self.format.encode(1.0, 0.0);
        match &mut self.words {
            _ if self.pending_clear.add_all() => {}
            Words::Narrow(w) => w.fill(far as u16),
            Words::Wide(w) => w.fill(far as i32),
        }
    }

    /// Sets the depths of these columns and rows to 1; those beyond the frame are ignored.
    pub fn clear_within(&mut self, columns: &Range<u32>, rows: &Range<u32>) {
        let far = self.format.encode(1.0, 0.0);
        let end = columns.end.min(self.width) as usize;
        let columns = (columns.start as usize).min(end)..end;
        for row in rows.start..rows.end.min(self.height) {
            let words = &mut self.words;
            self.pending_clear.add_within(row as usize, columns.clone(), |pixels| words.fill(pixels, far));
        }
    }

    /// Stores the words of all pending clears.
    fn finish_clears(&mut self) {
        let far = self.format.encode(1.0, 0.0);
        let words = &mut self.words;
        self.pending_clear.take(|pixels| words.fill(pixels, far));
    }

    /// Returns the stored word of pixel number `index` (= width * y + x); smaller is nearer.
    ///
    /// # Panics
    /// If `index` is not a pixel of this memory.
    #[inline]
    pub fn word(&self, index: usize) -> u32 {
        if self.pending_clear.contains(index) {
            return self.format.encode(1.0, 0.0);
        }
        match &self.words {
            Words::Narrow(w) => w[index] as u32,
            Words::Wide(w) => w[index] as u32,
        }
    }

    /// Stores a word that [`DepthFormat::encode`] returned.
    ///
    /// # Panics
    /// If `index` is not a pixel of this memory.
    #[inline]
    pub fn set_word(&mut self, index: usize, word: u32) {
        let (words, far) = (&mut self.words, self.format.encode(1.0, 0.0));
        self.pending_clear.open(index, |pixels| words.fill(pixels, far));
        match words {
            Words::Narrow(w) => w[index] = word as u16,
            Words::Wide(w) => w[index] = word as i32,
        }
    }

    /// Returns all stored words for writing, row 0 first.
    pub fn words_mut(&mut self) -> DepthWords<'_> {
        self.finish_clears();
        match &mut self.words {
            Words::Narrow(w) => DepthWords::Narrow(w),
            Words::Wide(w) => DepthWords::Wide(w),
        }
    }

    /// Returns all stored words with their pending clears.
    pub(crate) fn cells_mut(&mut self) -> DepthCells<'_> {
        let far = self.format.encode(1.0, 0.0) as i32;
        let pending_clear = self.pending_clear.words_mut();
        match &mut self.words {
            Words::Narrow(narrow) => DepthCells { words: &mut [], narrow, pending_clear, far },
            Words::Wide(words) => DepthCells { words, narrow: &mut [], pending_clear, far },
        }
    }

    /// Returns the depth z in 0..=1 of pixel (x, y), or `None` off the frame.
    pub fn z(&self, x: i32, y: i32) -> Option<f64> {
        let inside = (x as u32) < self.width && (y as u32) < self.height;
        inside.then(|| self.format.decode(self.word(self.width as usize * y as usize + x as usize)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_order_near_to_far_and_decode_within_half_a_step() {
        for format in DepthFormat::ALL {
            let mut last = None;
            for i in 0..=1000 {
                let z = i as f64 / 1000.0;
                let word = format.encode(z, 1.0 - z);
                assert!(last.is_none_or(|l| l < word), "{format:?} at {z}");
                assert!((format.decode(word) - z).abs() < 0.5001 / 65535.0);
                last = Some(word);
            }
            assert_eq!(format.encode(-0.0, 1.0), format.encode(0.0, 1.0), "{format:?} has one zero");
            let far = DepthMemory::new(2, 2, format);
            assert_eq!((far.z(1, 1), far.z(2, 0), far.z(0, -1)), (Some(1.0), None, None));
        }
    }

    #[test]
    fn its_size_is_that_of_all_words() {
        let bytes = |format| DepthMemory::new(30, 20, format).size_bytes();
        assert_eq!([DepthFormat::F32, DepthFormat::U24, DepthFormat::U16].map(bytes), [2400, 2400, 1200]);
    }

    #[test]
    fn a_rectangle_is_cleared_alone() {
        for format in [DepthFormat::F32, DepthFormat::U16] {
            let mut depth = DepthMemory::new(300, 4, format);
            depth.clear();
            (0..1200).for_each(|i| depth.set_word(i, 5));
            depth.clear_within(&(250..999), &(1..3));
            let far = format.encode(1.0, 0.0);
            let is_inside = |i: usize| i % 300 >= 250 && (1..3).contains(&(i / 300));
            assert!((0..1200).all(|i| depth.word(i) == if is_inside(i) { far } else { 5 }));
            depth.clear_within(&(400..500), &(7..9));
        }
    }

    #[test]
    fn a_clear_is_seen_at_once_however_late_the_words_are_stored() {
        for (width, format) in [
            (5, DepthFormat::F32),
            (700, DepthFormat::U24),
            (300, DepthFormat::U16),
            (17_000, DepthFormat::F32),
        ] {
            let far = format.encode(1.0, 0.0);
            let near = |i: usize| far - 9 - i as u32 % 7;
            let len = width as usize * 4;
            let mut depth = DepthMemory::new(width, 4, format);
            (0..len).for_each(|i| depth.set_word(i, near(i)));
            depth.clear();
            assert!((0..len).all(|i| depth.word(i) == far), "{format:?}");
            // The first cell of row 2 is cleared directly, as the tile renderer does, then a word
            // of it is set.
            let mut want = vec![far; len];
            let columns = depth.pending_clear.columns_of(0);
            let cells = depth.cells_mut();
            if !cells.pending_clear.is_empty() {
                let row = width as usize * 2;
                match format {
                    DepthFormat::U16 => {
                        cells.narrow[row..row + columns.end].fill(cells.far as u16);
                        cells.narrow[row + 1] = 77;
                    }
                    _ => {
                        cells.words[row..row + columns.end].fill(cells.far);
                        cells.words[row + 1] = 77;
                    }
                }
                cells.pending_clear[2] &= !1;
                want[row + 1] = 77;
            }
            assert!((0..len).all(|i| depth.word(i) == want[i]), "{format:?}");
            depth.set_word(3, 5);
            want[3] = 5;
            assert!((0..len).all(|i| depth.word(i) == want[i]), "{format:?}");
            let words = depth.words_mut();
            assert!((0..len).all(|i| words.word(i) == want[i]), "{format:?}");
        }
    }
}

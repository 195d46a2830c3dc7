//! Depth memory: one stored depth a pixel, in the format that the stream chose. Made only when a scene needs it.
//!
//! Depth z runs from 0 (near) to 1 (far) and is cleared to 1. A fragment passes when what it would store is strictly
//! nearer than what is stored. Formats: u16 = round(65535 z), u24 = round((2^24-1) z), u32 = round((2^32-1) z),
//! f32, and reversed f32, which stores 1-z computed without cancellation by the caller.
//!
//! Clearing costs next to nothing: runs of a row (cells) are marked as stale, and get their words when somebody first
//! writes near them. What is read is always as if the words had been stored at once.

use super::aligned::Aligned;

/// How a depth is stored.
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

    /// The keyword of the command language.
    pub const fn as_str(self) -> &'static str {
        match self {
            DepthFormat::U16 => "u16",
            DepthFormat::U24 => "u24",
            DepthFormat::U32 => "u32",
            DepthFormat::F32 => "f32",
            DepthFormat::Reversed => "reversed",
        }
    }

    /// Bytes that one pixel's depth takes.
    pub const fn bytes_per_pixel(self) -> usize {
        match self {
            DepthFormat::U16 => 2,
            _ => 4,
        }
    }

    /// The stored word for depth `z` in 0..=1 and its complement `one_minus_z` (computed without cancellation):
    /// smaller words are nearer in every format.
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

    /// The depth z in 0..=1 that a stored word stands for.
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

/// One stored depth a pixel, row 0 at the top, as words that order near to far in every format.
#[derive(Clone, Debug)]
pub struct DepthMemory {
    width: u32,
    height: u32,
    format: DepthFormat,
    words: Words,
    /// For each row the cells whose words are still to be cleared, a bit each; empty where clearing is done at once.
    pending_clear: Vec<u128>,
    /// Whether some bit of `pending_clear` may be set.
    has_pending_clear: bool,
}

/// Columns of a cell; the last cell of a row goes on to its end.
pub(crate) const DEPTH_CELL: usize = 128;

/// The first column of cell number `cell` of a row, and the one beyond its last.
fn cell_columns(cell: usize, width: usize) -> std::ops::Range<usize> {
    cell * DEPTH_CELL..if cell + 1 == cells_in(width) { width } else { (cell + 1) * DEPTH_CELL }
}

fn cells_in(width: usize) -> usize {
    (width / DEPTH_CELL).max(1)
}

/// All words of a depth memory, and which of them are still to be cleared: whoever writes a cell clears it first.
#[derive(Debug)]
pub(crate) struct DepthCells<'a> {
    /// The words, row by row; empty in the format of 16 bits.
    pub words: &'a mut [i32],
    /// The words of that format; else empty.
    pub narrow: &'a mut [u16],
    /// For each row a bit a cell, from the left; empty where nothing is to be cleared.
    pub pending_clear: &'a mut [u128],
    /// What a cleared word is.
    pub far: i32,
}

impl DepthCells<'_> {
    /// The same cells for a shorter time.
    pub fn reborrow(&mut self) -> DepthCells<'_> {
        DepthCells {
            words: &mut *self.words,
            narrow: &mut *self.narrow,
            pending_clear: &mut *self.pending_clear,
            far: self.far,
        }
    }
}

/// The stored words of some pixels; see [`DepthFormat::encode`].
#[derive(Debug)]
pub enum DepthWords<'a> {
    /// Of u16.
    Narrow(&'a mut [u16]),
    /// Of every other format: the bits of the u32 word.
    Wide(&'a mut [i32]),
}

impl<'a> DepthWords<'a> {
    /// The stored word of pixel number `index`.
    ///
    /// # Panics
    /// When there is no such pixel.
    #[inline]
    pub fn word(&self, index: usize) -> u32 {
        match self {
            DepthWords::Narrow(w) => w[index] as u32,
            DepthWords::Wide(w) => w[index] as u32,
        }
    }

    /// Stores a word.
    ///
    /// # Panics
    /// When there is no such pixel.
    #[inline]
    pub fn set_word(&mut self, index: usize, word: u32) {
        match self {
            DepthWords::Narrow(w) => w[index] = word as u16,
            DepthWords::Wide(w) => w[index] = word as i32,
        }
    }

    /// The words before pixel number `mid`, and those from it on.
    ///
    /// # Panics
    /// When there are fewer.
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

impl DepthMemory {
    /// A depth memory of `width` x `height` pixels, cleared to z = 1.
    ///
    /// # Panics
    /// When the system has no room for it.
    pub fn new(width: u32, height: u32, format: DepthFormat) -> Self {
        let len = width as usize * height as usize;
        let far = format.encode(1.0, 0.0);
        let room = "room for a frame's depths";
        let words = match format {
            DepthFormat::U16 => Words::Narrow(Aligned::new(len, far as u16).expect(room)),
            _ => Words::Wide(Aligned::new(len, far as i32).expect(room)),
        };
        let is_lazy = matches!(words, Words::Wide(_)) && cells_in(width as usize) <= u128::BITS as usize;
        let pending_clear = vec![0; if is_lazy { height as usize } else { 0 }];
        DepthMemory { width, height, format, words, pending_clear, has_pending_clear: false }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The format in which depths are stored.
    pub fn format(&self) -> DepthFormat {
        self.format
    }

    /// Bytes that the depths take.
    pub fn size_bytes(&self) -> usize {
        self.width as usize * self.height as usize * self.format.bytes_per_pixel()
    }

    /// Sets every depth to 1.
    pub fn clear(&mut self) {
        let far = self.format.encode(1.0, 0.0);
        match &mut self.words {
            Words::Narrow(w) => w.fill(far as u16),
            Words::Wide(w) if self.pending_clear.is_empty() => w.fill(far as i32),
            Words::Wide(_) => {
                self.pending_clear.fill(u128::MAX);
                self.has_pending_clear = true;
            }
        }
    }

    /// Whether the word of a pixel is still to be cleared.
    fn is_pending_clear(&self, index: usize) -> bool {
        let (row, column) = (index / self.width as usize, index % self.width as usize);
        let cell = (column / DEPTH_CELL).min(cells_in(self.width as usize) - 1);
        self.pending_clear[row] >> cell & 1 == 1
    }

    /// Clears what is still to be cleared.
    fn finish_clears(&mut self) {
        let (far, width) = (self.format.encode(1.0, 0.0) as i32, self.width as usize);
        if let (true, Words::Wide(words)) = (self.has_pending_clear, &mut self.words) {
            let all = u128::MAX;
            for (row, pending_clear) in words.chunks_exact_mut(width).zip(&mut self.pending_clear) {
                match std::mem::take(pending_clear) {
                    0 => {}
                    bits if bits == all => row.fill(far),
                    bits => (0..cells_in(width))
                        .filter(|cell| bits >> cell & 1 == 1)
                        .for_each(|cell| row[cell_columns(cell, width)].fill(far)),
                }
            }
        }
        self.has_pending_clear = false;
    }

    /// The stored word of pixel number `index` (= width * y + x); smaller is nearer.
    ///
    /// # Panics
    /// When `index` is not a pixel of this memory.
    #[inline]
    pub fn word(&self, index: usize) -> u32 {
        if self.has_pending_clear && self.is_pending_clear(index) {
            return self.format.encode(1.0, 0.0);
        }
        match &self.words {
            Words::Narrow(w) => w[index] as u32,
            Words::Wide(w) => w[index] as u32,
        }
    }

    /// Stores a word that [`DepthFormat::encode`] made.
    ///
    /// # Panics
    /// When `index` is not a pixel of this memory.
    #[inline]
    pub fn set_word(&mut self, index: usize, word: u32) {
        self.finish_clears();
        match &mut self.words {
            Words::Narrow(w) => w[index] = word as u16,
            Words::Wide(w) => w[index] = word as i32,
        }
    }

    /// All stored words, row 0 first, for writing.
    pub fn words_mut(&mut self) -> DepthWords<'_> {
        self.finish_clears();
        match &mut self.words {
            Words::Narrow(w) => DepthWords::Narrow(w),
            Words::Wide(w) => DepthWords::Wide(w),
        }
    }

    /// All stored words and which are still to be cleared.
    pub(crate) fn cells_mut(&mut self) -> DepthCells<'_> {
        let far = self.format.encode(1.0, 0.0) as i32;
        let pending_clear: &mut [u128] =
            if self.has_pending_clear { &mut self.pending_clear } else { &mut [] };
        match &mut self.words {
            Words::Narrow(narrow) => DepthCells { words: &mut [], narrow, pending_clear, far },
            Words::Wide(words) => DepthCells { words, narrow: &mut [], pending_clear, far },
        }
    }

    /// The depth z in 0..=1 of pixel (x, y), or `None` off the frame.
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
    fn a_clear_is_seen_at_once_however_late_the_words_are_stored() {
        for (width, format) in [(5, DepthFormat::F32), (700, DepthFormat::U24), (300, DepthFormat::U16)] {
            let far = format.encode(1.0, 0.0);
            let near = |i: usize| far - 9 - i as u32 % 7;
            let len = width as usize * 4;
            let mut depth = DepthMemory::new(width, 4, format);
            (0..len).for_each(|i| depth.set_word(i, near(i)));
            depth.clear();
            assert!((0..len).all(|i| depth.word(i) == far), "{format:?}");
            // One cell's words are stored by hand, as the tile renderer does it, then one word by its number.
            let mut want = vec![far; len];
            let cells = depth.cells_mut();
            if !cells.words.is_empty() {
                let row = width as usize * 2;
                let columns = cell_columns(0, width as usize);
                cells.words[row..row + columns.end].fill(cells.far);
                cells.words[row + 1] = 77;
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

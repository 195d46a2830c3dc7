//! The CRT look: a frame as a cathode ray tube shows it, with scan lines, a phosphor mask and the
//! aspect ratio of the tube.
//!
//! In: a frame and the size of the screen that shows it. Out: rows of 0x00RRGGBB words, or a
//! picture. The beam's profile and the mask are as strong as the enlargement has room for: where a
//! line of the frame has 1.5 rows of the screen or fewer, no scan lines are drawn, and where a pixel
//! has one column, no mask. Integers throughout: the same words at every vector level.

use crate::memory::{MemoryError, VideoMemory};
use crate::simd::{CrtColumns, Level, ONE, STRIPES, crt_row};
use std::ops::Range;

/// Modes of the graphics adapters whose pixels were no squares: their frame filled a tube of 4:3.
const MODES_OF_TUBES: [[usize; 2]; 8] =
    [[160, 200], [320, 200], [640, 200], [640, 350], [640, 400], [720, 348], [720, 350], [720, 400]];
/// Weight of a mask's stripe for its own colour, and for the other two.
const OWN_STRIPE: i32 = 352;
const OTHER_STRIPE: i32 = 216;
/// Largest enlargement of a picture, and its largest side.
const PICTURE_SCALE: usize = 3;
const PICTURE_SIDE: usize = 4096;

/// Returns the smallest size at which square pixels show a frame at the aspect ratio that it has on
/// a tube.
pub fn square_size(frame: [usize; 2]) -> [usize; 2] {
    let [width, height] = frame;
    match MODES_OF_TUBES.contains(&frame) {
        true if height * 4 <= width * 3 => [width, width * 3 / 4],
        true => [(height * 4).div_ceil(3), height],
        false => frame,
    }
}

/// Tables of a frame's size on a screen.
#[derive(Clone, Debug)]
pub struct Crt {
    frame: [usize; 2],
    shown: [usize; 2],
    columns: CrtColumns,
    /// Strength of the scan lines, 0 to [`ONE`].
    depth: i64,
    /// Working memory: a line of the frame.
    mixed: Vec<u8>,
}

impl Crt {
    /// Creates the tables of a frame that is shown on `shown` columns and rows. Neither size may be
    /// 0.
    pub fn new(frame: [usize; 2], shown: [usize; 2]) -> Crt {
        let [frame, shown] = [frame, shown].map(|size| size.map(|side| side.max(1)));
        let columns = shown[0] as i64 * 256 / frame[0] as i64;
        let rows = shown[1] as i64 * 256 / frame[1] as i64;
        // Pixels have soft edges of the width of one column or so: wide ones keep a plateau.
        let slope = (columns / 2).clamp(256, 768);
        let place = |x: usize| {
            let (left, weight) = place(x, frame[0], shown[0]);
            let weight = ((((weight - 128) * slope) >> 8) + 128).clamp(0, 256);
            match left {
                ..0 => (0, 0),
                left => (left as usize, weight as i32),
            }
        };
        let mask = mask(((columns - 256) / 2).clamp(0, 256) as i32);
        Crt {
            frame,
            shown,
            columns: CrtColumns::new(frame[0], (0..shown[0]).map(place), mask),
            depth: ((rows - 384) * 256 / 384).clamp(0, 256),
            mixed: Vec::new(),
        }
    }

    /// Returns whether these are the tables of the sizes.
    pub fn is_of(&self, frame: [usize; 2], shown: [usize; 2]) -> bool {
        self.frame == frame && self.shown == shown
    }

    /// Returns the rows of the screen that depend on rows `rows` of the frame.
    pub fn screen_rows(&self, rows: Range<usize>) -> Range<usize> {
        let [height, shown] = [self.frame[1], self.shown[1]];
        // A row of the screen shows the two lines next to its centre.
        let first = (rows.start.saturating_sub(1)) * shown / height;
        let end = ((rows.end + 1) * shown).div_ceil(height).min(shown);
        first.min(end)..end
    }

    /// Writes row `y` of the screen. `rgba` is the entire frame; nothing is written for a row, or a
    /// frame, that is smaller than the tables'.
    pub fn row(&mut self, rgba: &[u8], y: usize, words: &mut [u32]) {
        let [width, height] = self.frame;
        let (line, below) = place(y, height, self.shown[1]);
        let last = height as i64 - 1;
        let bytes = |line: i64| {
            let line = line.clamp(0, last) as usize;
            rgba.get(line * width * 4..(line + 1) * width * 4)
        };
        let (Some(upper), Some(lower)) = (bytes(line), bytes(line + 1)) else { return };
        let weights = [256 - below, below].map(|weight| self.beam(weight));
        crt_row(Level::best(), &self.columns, [upper, lower], weights, &mut self.mixed, words);
    }

    /// Returns the beam's weight at a place whose weight by distance alone is `near` (0 to 256).
    fn beam(&self, near: i64) -> i32 {
        let distance = 256 - near;
        // (1 - distance^2)^5 is a bell of half the height at 0.36 of the distance to the next line.
        let bell = (1 << 16) - distance * distance;
        let bell = (0..4).fold(bell, |power, _| (power * bell) >> 16) >> 8;
        (near + (((bell - near) * self.depth) >> 8)) as i32
    }

    /// Returns the frame as a picture, enlarged three times where that has at most 4096 pixels a
    /// side, else twice or not at all; the CRT look of a file.
    ///
    /// # Errors
    /// If the system has no memory for it.
    pub fn picture(memory: &VideoMemory) -> Result<VideoMemory, MemoryError> {
        let frame = [memory.width() as usize, memory.height() as usize];
        let shown = picture_size(frame);
        let mut picture = VideoMemory::new(shown[0] as u32, shown[1] as u32)?;
        let mut crt = Crt::new(frame, shown);
        let mut words = vec![0; shown[0]];
        for (y, row) in picture.bytes_mut().chunks_exact_mut(shown[0] * 4).enumerate() {
            crt.row(memory.bytes(), y, &mut words);
            for (pixel, word) in row.as_chunks_mut::<4>().0.iter_mut().zip(&words) {
                let [_, red, green, blue] = word.to_be_bytes();
                *pixel = [red, green, blue, 255];
            }
        }
        Ok(picture)
    }
}

/// Returns the size of the picture of [`Crt::picture`].
pub fn picture_size(frame: [usize; 2]) -> [usize; 2] {
    let square = square_size(frame);
    let fits = |scale: &usize| square.iter().all(|side| side * scale <= PICTURE_SIDE);
    let scale = (1..=PICTURE_SCALE).rev().find(fits).unwrap_or(1);
    square.map(|side| side * scale)
}

/// Returns, for the centre of place `at` of `shown`, the element of `frame` whose centre is left of
/// it or above (-1 before the first), and the weight of the next one, 0 to 255.
fn place(at: usize, frame: usize, shown: usize) -> (i64, i64) {
    let center = (2 * at as i64 + 1) * frame as i64 * 128 / shown as i64 - 128;
    (center.div_euclid(256), center.rem_euclid(256))
}

/// Returns the mask's weights at a strength of 0 to [`ONE`], by column and channel.
fn mask(strength: i32) -> [[i32; 3]; STRIPES] {
    std::array::from_fn(|column| {
        std::array::from_fn(|channel| {
            let full = if column == channel { OWN_STRIPE } else { OTHER_STRIPE };
            ONE + (((full - ONE) * strength) >> 8)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(width: usize, height: usize) -> Vec<u8> {
        (0..width * height).flat_map(|i| [i as u8, (i * 7) as u8, (i * 13) as u8, 77]).collect()
    }

    fn screen_of(rgba: &[u8], frame: [usize; 2], shown: [usize; 2]) -> Vec<u32> {
        let (mut crt, mut words) = (Crt::new(frame, shown), vec![0; shown[0] * shown[1]]);
        words.chunks_exact_mut(shown[0]).enumerate().for_each(|(y, row)| crt.row(rgba, y, row));
        words
    }

    #[test]
    fn modes_of_tubes_are_shown_at_their_aspect_and_others_as_they_are() {
        for (frame, square, picture) in [
            ([320, 200], [320, 240], [960, 720]),
            ([640, 200], [640, 480], [1920, 1440]),
            ([160, 200], [267, 200], [801, 600]),
            ([720, 400], [720, 540], [2160, 1620]),
            ([640, 480], [640, 480], [1920, 1440]),
            ([1920, 1080], [1920, 1080], [3840, 2160]),
            ([5000, 10], [5000, 10], [5000, 10]),
        ] {
            assert_eq!((square_size(frame), picture_size(frame)), (square, picture), "{frame:?}");
        }
    }

    #[test]
    fn scan_lines_are_bright_in_their_middle_and_the_mask_has_three_stripes() {
        let white = vec![255; 8 * 6 * 4];
        let words = screen_of(&white, [8, 6], [8 * 6, 6 * 5]);
        let row = |y: usize| &words[y * 48..(y + 1) * 48];
        for line in 0..6 {
            let bright = row(line * 5 + 2);
            // Red, green and blue stripes, each lit by its own colour.
            assert_eq!(bright[..3], [0x00ff_d7d7, 0x00d7_ffd7, 0x00d7_d7ff]);
            assert!(bright.chunks(3).all(|stripes| stripes == &bright[..3]));
            let dim = row(line * 5);
            assert!(dim[0] & 0xff < 0x90 && dim[0] >> 16 < 0xd0, "{:#x}", dim[0]);
        }
    }

    #[test]
    fn above_and_below_its_middle_a_line_fades_alike() {
        let gray = vec![100; 8 * 6 * 4];
        for scale in [2, 3, 5] {
            let width = 8 * scale;
            let words = screen_of(&gray, [8, 6], [width, 6 * scale]);
            let row = |y: usize| &words[y * width..(y + 1) * width];
            // The frame's first and last line have a neighbour on one side only.
            for (line, k) in (1..5).flat_map(|line| (0..scale / 2).map(move |k| (line, k))) {
                let words = row(line * scale + k).iter().zip(row((line + 1) * scale - 1 - k));
                let mut bytes = words.flat_map(|(a, b)| a.to_be_bytes().into_iter().zip(b.to_be_bytes()));
                assert!(bytes.all(|(a, b)| a.abs_diff(b) <= 2), "scale {scale}, line {line}, row {k}");
            }
        }
    }

    #[test]
    fn a_frame_without_room_for_lines_and_mask_is_shown_plainly() {
        let rgba = frame(21, 9);
        let words = screen_of(&rgba, [21, 9], [21, 9]);
        for (word, pixel) in words.iter().zip(rgba.as_chunks::<4>().0) {
            assert_eq!(word.to_be_bytes()[1..], pixel[..3]);
        }
    }

    #[test]
    fn the_mean_brightness_of_a_gray_stays_near_three_quarters() {
        let gray = vec![120; 30 * 20 * 4];
        for scale in [3, 4, 5] {
            let words = screen_of(&gray, [30, 20], [30 * scale, 20 * scale]);
            let sum: u64 = words.iter().flat_map(|w| w.to_be_bytes()).map(u64::from).sum();
            let mean = sum as f64 / (words.len() * 3) as f64 / 120.0;
            assert!((0.68..0.82).contains(&mean), "{scale}: {mean}");
        }
    }

    #[test]
    fn rows_of_the_screen_that_are_not_named_do_not_change() {
        for (size, shown) in
            [([5, 7], [5, 7]), ([5, 7], [17, 30]), ([5, 7], [11, 9]), ([9, 20], [4, 7]), ([3, 1], [9, 5])]
        {
            let mut rgba = frame(size[0], size[1]);
            let before = screen_of(&rgba, size, shown);
            let crt = Crt::new(size, shown);
            for row in 0..size[1] {
                let kept = rgba.clone();
                rgba[row * size[0] * 4..(row + 1) * size[0] * 4].iter_mut().for_each(|b| *b ^= 0xff);
                let after = screen_of(&rgba, size, shown);
                let named = crt.screen_rows(row..row + 1);
                assert!(named.end <= shown[1]);
                for y in (0..shown[1]).filter(|y| !named.contains(y)) {
                    let words = y * shown[0]..(y + 1) * shown[0];
                    assert_eq!(after[words.clone()], before[words], "{size:?} {shown:?} row {row}, {y}");
                }
                rgba = kept;
            }
            assert_eq!(crt.screen_rows(0..size[1]), 0..shown[1]);
        }
    }

    #[test]
    fn a_picture_is_the_screen_of_its_size() {
        let mut memory = VideoMemory::new(32, 20).unwrap();
        memory.put_pixel(3, 4, [250, 120, 7, 9]);
        let picture = Crt::picture(&memory).unwrap();
        assert_eq!((picture.width(), picture.height()), (96, 60));
        let words = screen_of(memory.bytes(), [32, 20], [96, 60]);
        for (pixel, word) in picture.bytes().as_chunks::<4>().0.iter().zip(words) {
            assert_eq!([0, pixel[0], pixel[1], pixel[2]], word.to_be_bytes());
            assert_eq!(pixel[3], 255);
        }
        assert!(picture.get_pixel(10, 13).unwrap()[0] > 200);
    }

    #[test]
    fn frames_that_are_too_small_write_nothing() {
        let mut words = [7; 4];
        Crt::new([4, 4], [4, 4]).row(&[0; 16], 3, &mut words);
        assert_eq!(words, [7; 4]);
        Crt::new([0, 0], [0, 0]).row(&[], 0, &mut words);
        assert_eq!(words, [7; 4]);
    }
}

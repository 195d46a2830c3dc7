//! Drawing a picture of the eye into video memory.
//!
//! In: an [`EyePicture`] and a rectangle of the frame in pixels. Out: opaque pixels, colours
//! clamped to 0..=255 and rounded half up. A 1-D screen is drawn as a band (each pixel a column), a
//! 2-D one as a picture, a 3-D one as a contact sheet of its layers along axis 3, in reading order;
//! further axes likewise. If the rectangle is not of the sheet's size the nearest pixel is taken:
//! column i of w shows column floor((i + 1/2) n / w). Cells of the sheet without a layer are black.

use super::picture::EyePicture;
use crate::memory::{Rgba, VideoMemory};

/// Colour of a cell of the sheet without a layer.
const EMPTY: Rgba = VideoMemory::CLEAR;

/// Layout of a screen on a contact sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactSheet {
    /// Number of layers side by side.
    pub columns: u32,
    /// Number of rows of layers.
    pub rows: u32,
    /// Width and height of a layer in pixels.
    pub layer: [u32; 2],
}

impl ContactSheet {
    /// Returns the layout of a screen of `pixels`, as near to a square as complete layers allow.
    pub fn of(pixels: &[u32]) -> Self {
        let layer = [pixels.first().copied().unwrap_or(1), pixels.get(1).copied().unwrap_or(1)];
        let layers: u32 = pixels.iter().skip(2).product();
        // The longer side of the sheet with this many columns; the smallest one is near the square.
        let longer = |columns: u32| {
            let (w, h) = (
                u64::from(columns) * u64::from(layer[0]),
                u64::from(layers.div_ceil(columns)) * u64::from(layer[1]),
            );
            w.max(h)
        };
        let square = (f64::from(layers) * f64::from(layer[1]) / f64::from(layer[0])).sqrt() as u32;
        let near = square.saturating_sub(2).clamp(1, layers)..=square.saturating_add(2).clamp(1, layers);
        let columns = near.min_by_key(|&c| (longer(c), std::cmp::Reverse(c))).unwrap_or(1);
        ContactSheet { columns, rows: layers.div_ceil(columns), layer }
    }

    /// Returns the width and height of the entire sheet in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.columns * self.layer[0], self.rows * self.layer[1]]
    }

    /// Returns the size in pixels of a picture of the sheet: a line becomes a band an eighth as
    /// high as it is long.
    pub fn picture_size(&self) -> [u32; 2] {
        match self.size() {
            [w, 1] if self.columns == 1 => [w, w.div_ceil(8)],
            size => size,
        }
    }

    /// Returns the flat index of the screen's pixel at (x, y) of the sheet, or `None` in an empty
    /// cell. `count` is the screen's number of pixels.
    pub fn pixel(&self, x: u32, y: u32, count: usize) -> Option<usize> {
        let [w, h] = self.layer;
        let layer = (y / h * self.columns + x / w) as usize;
        let flat = (layer * h as usize + (y % h) as usize) * w as usize + (x % w) as usize;
        (flat < count).then_some(flat)
    }
}

/// Returns the picture as a sheet of opaque pixels, row after row, and its size,
/// [`ContactSheet::size`].
pub fn contact_sheet(picture: &EyePicture) -> ([u32; 2], Vec<Rgba>) {
    let contact_sheet = ContactSheet::of(&picture.pixels);
    let [w, h] = contact_sheet.size();
    let pixel = |x, y| {
        contact_sheet.pixel(x, y, picture.color.len()).map_or(EMPTY, |flat| opaque(picture.color[flat]))
    };
    ([w, h], (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect())
}

/// Returns the pixel of `n` that pixel `i` of `length` shows: the nearest, floor((i + 1/2) n /
/// length).
pub fn nearest(i: u32, length: u32, n: u32) -> u32 {
    ((2 * u64::from(i) + 1) * u64::from(n) / (2 * u64::from(length.max(1)))) as u32
}

/// Clamps to 0..=255 and rounds half up.
fn opaque(color: [f64; 3]) -> Rgba {
    let [r, g, b] = color.map(|c| (c.clamp(0.0, 255.0) + 0.5).floor() as u8);
    [r, g, b, 255]
}

/// Draws the picture into the rectangle of `w` x `h` pixels at (x, y). Sizes of 0 or less draw
/// nothing.
pub fn blit(picture: &EyePicture, memory: &mut VideoMemory, x: i32, y: i32, w: i32, h: i32) {
    let contact_sheet = ContactSheet::of(&picture.pixels);
    let size = contact_sheet.size();
    // Only the visible part is iterated over.
    let visible = |from: i32, length: i32, limit: u32| {
        let (from, length) = (i64::from(from), i64::from(length.max(0)));
        (-from).clamp(0, length)..(i64::from(limit) - from).clamp(0, length)
    };
    // Both are at least 0 here: the loops cover the visible part of a non-empty rectangle.
    let source = |i: i64, length: i32, n: u32| nearest(i as u32, length as u32, n);
    for j in visible(y, h, memory.height()) {
        let row = source(j, h, size[1]);
        for i in visible(x, w, memory.width()) {
            let flat = contact_sheet.pixel(source(i, w, size[0]), row, picture.color.len());
            let color = flat.map_or(EMPTY, |flat| opaque(picture.color[flat]));
            memory.put_pixel((i64::from(x) + i) as i32, (i64::from(y) + j) as i32, color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(pixels: &[u32]) -> EyePicture {
        let count: u32 = pixels.iter().product();
        EyePicture {
            pixels: pixels.to_vec(),
            lights: 0,
            facet: vec![0; count as usize],
            dist: vec![1.0; count as usize],
            lit: vec![],
            color: (0..count).map(|i| [f64::from(i), 0.49, 254.5]).collect(),
            skipped_facets: vec![],
        }
    }

    /// Prints the red bytes of the frame, one row for each line; -- where nothing was drawn.
    fn reds(memory: &VideoMemory) -> String {
        let pixel = |p: &[u8]| if p[2] == 255 { format!("{:2} ", p[0]) } else { "-- ".into() };
        let row = |y| memory.row(y).unwrap().chunks(4).map(pixel).collect::<String>();
        (0..memory.height()).map(|y| format!("{}\n", row(y).trim_end())).collect()
    }

    #[test]
    fn a_line_is_a_band_of_nearest_columns() {
        let mut memory = VideoMemory::new(7, 3).unwrap();
        blit(&picture(&[3]), &mut memory, 1, 1, 5, 2);
        assert_eq!(reds(&memory), "-- -- -- -- -- -- --\n--  0  0  1  2  2 --\n--  0  0  1  2  2 --\n");
        assert_eq!(memory.get_pixel(1, 1), Ok([0, 0, 255, 255]));
    }

    #[test]
    fn a_volume_is_a_sheet_of_its_layers() {
        let mut memory = VideoMemory::new(6, 4).unwrap();
        let contact_sheet = ContactSheet::of(&[2, 2, 5]);
        assert_eq!((contact_sheet.columns, contact_sheet.rows, contact_sheet.size()), (3, 2, [6, 4]));
        blit(&picture(&[2, 2, 5]), &mut memory, 0, 0, 6, 4);
        let want = " 0  1  4  5  8  9\n 2  3  6  7 10 11\n12 13 16 17 -- --\n14 15 18 19 -- --\n";
        assert_eq!(reds(&memory), want);
        let (size, pixels) = super::contact_sheet(&picture(&[2, 2, 5]));
        assert_eq!((size, pixels.as_flattened()), ([6, 4], memory.bytes()));
    }

    #[test]
    fn what_is_off_the_frame_costs_nothing_and_harms_nobody() {
        let mut memory = VideoMemory::new(2, 2).unwrap();
        let plane = picture(&[2, 2]);
        blit(&plane, &mut memory, i32::MIN, i32::MIN, i32::MAX, i32::MAX);
        blit(&plane, &mut memory, 5, 5, i32::MAX, i32::MAX);
        blit(&plane, &mut memory, 0, 0, -4, 7);
        assert_eq!(reds(&memory), "-- --\n-- --\n");
        blit(&plane, &mut memory, -1_000_000_000, -1_000_000_000, 2_000_000_000, 2_000_000_000);
        assert_eq!(reds(&memory), " 3  3\n 3  3\n");
    }
}

//! A picture of the eye in video memory.
//!
//! In: an [`EyePicture`] and a rectangle of the frame in pixels. Out: opaque bytes, colours clamped to 0..=255 and rounded half up.
//! A 1-D screen is a band (each pixel a column), a 2-D one a picture, a 3-D one a contact sheet of its layers along axis 3, in
//! reading order; of further axes likewise. Where the rectangle is not the sheet's size the nearest pixel is taken: column i of w
//! shows column floor((i + 1/2) n / w). Cells of the sheet without a layer are black.

use super::picture::EyePicture;
use crate::memory::{Rgba, VideoMemory};

/// A cell of the sheet without a layer.
const EMPTY: Rgba = VideoMemory::CLEAR;

/// How a screen is laid out on a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactSheet {
    /// Layers side by side.
    pub columns: u32,
    /// Rows of layers.
    pub rows: u32,
    /// Pixels of a layer, across and down.
    pub layer: [u32; 2],
}

impl ContactSheet {
    /// The layout of a screen of these pixels: as near to a square as whole layers allow.
    pub fn of(pixels: &[u32]) -> Self {
        let layer = [pixels.first().copied().unwrap_or(1), pixels.get(1).copied().unwrap_or(1)];
        let layers: u32 = pixels.iter().skip(2).product();
        // The longer side of the sheet with so many columns; the shortest is near the square.
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

    /// Pixels of the whole sheet, across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.columns * self.layer[0], self.rows * self.layer[1]]
    }

    /// The size of a picture of the sheet on its own: a line is a band an eighth as high as it is long.
    pub fn picture_size(&self) -> [u32; 2] {
        match self.size() {
            [w, 1] if self.columns == 1 => [w, w.div_ceil(8)],
            size => size,
        }
    }

    /// The flat index of the screen's pixel at a place of the sheet, given how many there are, or `None` in an empty cell.
    pub fn pixel(&self, x: u32, y: u32, count: usize) -> Option<usize> {
        let [w, h] = self.layer;
        let layer = (y / h * self.columns + x / w) as usize;
        let flat = (layer * h as usize + (y % h) as usize) * w as usize + (x % w) as usize;
        (flat < count).then_some(flat)
    }
}

/// The picture as a sheet of opaque pixels, row after row, of the size of [`ContactSheet::size`].
pub fn contact_sheet(picture: &EyePicture) -> ([u32; 2], Vec<Rgba>) {
    let contact_sheet = ContactSheet::of(&picture.pixels);
    let [w, h] = contact_sheet.size();
    let pixel = |x, y| {
        contact_sheet.pixel(x, y, picture.color.len()).map_or(EMPTY, |flat| opaque(picture.color[flat]))
    };
    ([w, h], (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect())
}

/// The pixel of `n` that pixel `i` of `length` shows: the nearest, floor((i + 1/2) n / length).
pub fn nearest(i: u32, length: u32, n: u32) -> u32 {
    ((2 * u64::from(i) + 1) * u64::from(n) / (2 * u64::from(length.max(1)))) as u32
}

/// Clamped and rounded half up.
fn opaque(color: [f64; 3]) -> Rgba {
    let [r, g, b] = color.map(|c| (c.clamp(0.0, 255.0) + 0.5).floor() as u8);
    [r, g, b, 255]
}

/// Draws the picture into the rectangle of `w` x `h` pixels at (x, y); sizes of 0 or less draw nothing.
pub fn blit(picture: &EyePicture, memory: &mut VideoMemory, x: i32, y: i32, w: i32, h: i32) {
    let contact_sheet = ContactSheet::of(&picture.pixels);
    let size = contact_sheet.size();
    // The visible part alone is walked.
    let visible = |from: i32, length: i32, limit: u32| {
        let (from, length) = (i64::from(from), i64::from(length.max(0)));
        (-from).clamp(0, length)..(i64::from(limit) - from).clamp(0, length)
    };
    // Both are at least 0 here: the loops walk the visible part of a rectangle that has one.
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

    /// The red bytes of the frame, a row a line; -- where nothing was drawn.
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

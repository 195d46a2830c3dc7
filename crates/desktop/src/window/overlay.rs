//! Text over the picture: help, frame rate, inspector. Drawn only into the window's pixels, never
//! into video memory.

use super::scanout::word;
use fbptr_core::draw2d::font::{CELL, glyph};
use fbptr_core::draw2d::look::{GOLD, TEXT};

/// A picture of 0x00RRGGBB words, `width` x `height`.
pub struct Canvas<'a> {
    /// The words, row after row.
    pub words: &'a mut [u32],
    /// Number of words in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
}

/// A corner of a canvas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corner {
    TopLeft,
    TopRight,
    BottomLeft,
    BottomRight,
}

/// Margin in pixels between a box and the canvas's edges.
const EDGE: usize = 4;

impl Corner {
    /// All corners.
    pub const ALL: [Corner; 4] = [Corner::TopLeft, Corner::TopRight, Corner::BottomLeft, Corner::BottomRight];

    /// Returns the corner of `among` in which a box of `size` covers the least detail: where the
    /// fewest words differ from their left neighbours. So text in the picture, a caption for
    /// instance, stays readable if another corner is blank. The current corner is kept as long as
    /// it has about as little detail, so that boxes do not move around.
    pub fn choose(
        current: Option<Corner>,
        among: &[Corner],
        canvas: &Canvas<'_>,
        size: [usize; 2],
    ) -> Corner {
        let quietest = among.iter().copied().min_by_key(|corner| corner.changes(canvas, size));
        let quietest = quietest.unwrap_or(Corner::TopLeft);
        let is_quiet_enough = |corner: &Corner| {
            corner.changes(canvas, size) <= 2 * quietest.changes(canvas, size) + Self::FEW_CHANGES
        };
        current.filter(|corner| among.contains(corner)).filter(is_quiet_enough).unwrap_or(quietest)
    }

    /// Less detail than one letter has.
    const FEW_CHANGES: usize = 8;

    /// Counts the words under a box of `size` in this corner that differ from their left
    /// neighbours.
    fn changes(self, canvas: &Canvas<'_>, size: [usize; 2]) -> usize {
        let [x, y] = self.place([canvas.width, canvas.height], size);
        let end = (x + size[0]).min(canvas.width);
        let in_row = |row: usize| {
            let words = canvas.words.get(row * canvas.width + x.min(end)..row * canvas.width + end);
            words.unwrap_or(&[]).windows(2).filter(|pair| pair[0] != pair[1]).count()
        };
        (y..(y + size[1]).min(canvas.height)).map(in_row).sum()
    }

    /// Returns the upper left corner of a box of `size` in this corner of a canvas.
    pub fn place(self, canvas: [usize; 2], size: [usize; 2]) -> [usize; 2] {
        let far = |axis: usize| canvas[axis].saturating_sub(size[axis] + EDGE);
        match self {
            Corner::TopLeft => [EDGE, EDGE],
            Corner::TopRight => [far(0), EDGE],
            Corner::BottomLeft => [EDGE, far(1)],
            Corner::BottomRight => [far(0), far(1)],
        }
    }
}

/// Margin in pixels around the text, before scaling.
const MARGIN: usize = 4;

/// Returns the size in pixels of the box that `lines` need at `scale`.
pub fn box_size(lines: &[String], scale: usize) -> [usize; 2] {
    let columns = lines.iter().map(|l| l.chars().count()).max().unwrap_or(0);
    [(columns * CELL + 2 * MARGIN) * scale, (lines.len() * (CELL + 2) + 2 * MARGIN) * scale]
}

/// Draws `lines` in a darkened box whose upper left corner is `at`, clipped to the canvas.
pub fn draw_box(canvas: &mut Canvas<'_>, at: [usize; 2], lines: &[String], scale: usize) {
    let [w, h] = box_size(lines, scale);
    for y in at[1]..(at[1] + h).min(canvas.height) {
        let row = &mut canvas.words[y * canvas.width..(y + 1) * canvas.width];
        let end = (at[0] + w).min(row.len());
        for word in row.get_mut(at[0]..end).unwrap_or(&mut []) {
            // A quarter of each channel remains, so that the picture is visible below.
            *word = (*word >> 2) & 0x003f_3f3f;
        }
    }
    draw_lines(canvas, at, lines, scale);
}

/// Draws the letters of `lines` as in a box whose upper left corner is `at`, clipped to the canvas.
pub fn draw_lines(canvas: &mut Canvas<'_>, at: [usize; 2], lines: &[String], scale: usize) {
    for (i, line) in lines.iter().enumerate() {
        let y = at[1] + (MARGIN + i * (CELL + 2)) * scale;
        for (j, c) in line.chars().enumerate() {
            draw_glyph(canvas, [at[0] + (MARGIN + j * CELL) * scale, y], c, scale, word(TEXT));
        }
    }
}

/// Draws lines in the middle of the canvas, the first of them in gold; as large as there is room.
pub fn draw_middle(canvas: &mut Canvas<'_>, lines: &[String]) {
    let size = [canvas.width, canvas.height];
    let fits = |scale: &usize| {
        let needed = box_size(lines, *scale);
        needed[0] <= size[0] && needed[1] <= size[1]
    };
    let scale = (1..=3).rev().find(fits).unwrap_or(1);
    let needed = box_size(lines, scale);
    let [left, top] = [0, 1].map(|i| size[i].saturating_sub(needed[i]) / 2);
    for (i, line) in lines.iter().enumerate() {
        let color = word(if i == 0 { GOLD } else { TEXT });
        for (j, c) in line.chars().enumerate() {
            let at = [left + (MARGIN + j * CELL) * scale, top + (MARGIN + i * (CELL + 2)) * scale];
            draw_glyph(canvas, at, c, scale, color);
        }
    }
}

/// Draws a character in a colour, whose cell's upper left corner is `at`, clipped to the canvas.
fn draw_glyph(canvas: &mut Canvas<'_>, at: [usize; 2], c: char, scale: usize, color: u32) {
    for (r, bits) in glyph(c).iter().enumerate() {
        for column in (0..CELL).filter(|column| bits & (0x80 >> column) != 0) {
            for y in (at[1] + r * scale..).take(scale).take_while(|&y| y < canvas.height) {
                let x = at[0] + column * scale;
                let end = (x + scale).min(canvas.width);
                if x < end {
                    canvas.words[y * canvas.width + x..y * canvas.width + end].fill(color);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corner_with_the_least_in_it_is_taken_and_kept() {
        let (width, height) = (100, 80);
        let busy = |current: Option<Corner>, is_busy: &dyn Fn(usize, usize) -> bool| {
            let word = |i: usize| u32::from(is_busy(i % width, i / width)) * (i as u32 % 2);
            let mut words: Vec<u32> = (0..width * height).map(word).collect();
            Corner::choose(current, &Corner::ALL, &Canvas { words: &mut words, width, height }, [40, 30])
        };
        assert_eq!(busy(None, &|_, _| false), Corner::TopLeft);
        assert_eq!(busy(None, &|_, y| y < 40), Corner::BottomLeft);
        assert_eq!(busy(None, &|x, _| x < 50), Corner::TopRight);
        assert_eq!(busy(None, &|x, y| x < 50 || y < 40), Corner::BottomRight);
        let last = Some(Corner::BottomRight);
        assert_eq!(busy(last, &|_, _| false), Corner::BottomRight, "no reason to move");
        assert_eq!(busy(last, &|_, _| true), Corner::BottomRight, "nowhere better");
        assert_eq!(busy(last, &|x, y| x > 60 && y > 60), Corner::TopLeft, "a caption");
        for (width, height) in [(1, 1), (3, 50), (50, 3)] {
            let mut words = vec![0; width * height];
            let canvas = Canvas { words: &mut words, width, height };
            assert_eq!(Corner::choose(None, &Corner::ALL, &canvas, [40, 30]), Corner::TopLeft);
        }
    }

    #[test]
    fn text_is_drawn_and_cut_at_the_edges() {
        let lines = vec!["Hg".to_string(), "I".to_string()];
        for (width, height, at) in [(64, 64, [2, 2]), (10, 10, [4, 4]), (3, 3, [9, 9]), (1, 1, [0, 0])] {
            let mut words = vec![0x0080_8080; width * height];
            draw_box(&mut Canvas { words: &mut words, width, height }, at, &lines, 2);
            if width == 64 {
                assert!(words.contains(&word(TEXT)) && words.contains(&0x0020_2020));
                assert_eq!(words[0], 0x0080_8080, "outside the box nothing changes");
            }
        }
    }
}

//! Text over the picture: help, frame rate, inspector. Drawn into the window's words only, never into video memory.

use crate::draw2d::font::{CELL, glyph};

/// A picture of 0x00RRGGBB words, `width` x `height`.
pub struct Canvas<'a> {
    /// The words, row after row.
    pub words: &'a mut [u32],
    /// Words in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// Blank pixels around the text, before enlarging.
const MARGIN: usize = 4;

/// The size in pixels of the box that `lines` need at `scale`.
pub fn box_size(lines: &[String], scale: usize) -> [usize; 2] {
    let columns = lines.iter().map(|l| l.chars().count()).max().unwrap_or(0);
    [(columns * CELL + 2 * MARGIN) * scale, (lines.len() * (CELL + 2) + 2 * MARGIN) * scale]
}

/// Draws `lines` in a darkened box whose upper left corner is `at`; what leaves the canvas is cut.
pub fn draw_box(canvas: &mut Canvas<'_>, at: [usize; 2], lines: &[String], scale: usize) {
    let [w, h] = box_size(lines, scale);
    for y in at[1]..(at[1] + h).min(canvas.height) {
        let row = &mut canvas.words[y * canvas.width..(y + 1) * canvas.width];
        let end = (at[0] + w).min(row.len());
        for word in row.get_mut(at[0]..end).unwrap_or(&mut []) {
            // A quarter of each channel stays, so that the picture shines through.
            *word = (*word >> 2) & 0x003f_3f3f;
        }
    }
    for (i, line) in lines.iter().enumerate() {
        let y = at[1] + (MARGIN + i * (CELL + 2)) * scale;
        for (j, c) in line.chars().enumerate() {
            draw_glyph(canvas, [at[0] + (MARGIN + j * CELL) * scale, y], c, scale);
        }
    }
}

fn draw_glyph(canvas: &mut Canvas<'_>, at: [usize; 2], c: char, scale: usize) {
    for (r, bits) in glyph(c).iter().enumerate() {
        for column in (0..CELL).filter(|column| bits & (0x80 >> column) != 0) {
            for y in (at[1] + r * scale..).take(scale).take_while(|&y| y < canvas.height) {
                let x = at[0] + column * scale;
                let end = (x + scale).min(canvas.width);
                if x < end {
                    canvas.words[y * canvas.width + x..y * canvas.width + end].fill(0x00ff_ffff);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_drawn_and_cut_at_the_edges() {
        let lines = vec!["Hg".to_string(), "I".to_string()];
        for (width, height, at) in [(64, 64, [2, 2]), (10, 10, [4, 4]), (3, 3, [9, 9]), (1, 1, [0, 0])] {
            let mut words = vec![0x0080_8080; width * height];
            draw_box(&mut Canvas { words: &mut words, width, height }, at, &lines, 2);
            if width == 64 {
                assert!(words.contains(&0x00ff_ffff) && words.contains(&0x0020_2020));
                assert_eq!(words[0], 0x0080_8080, "outside the box nothing changes");
            }
        }
    }
}

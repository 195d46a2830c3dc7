//! The look of what the program draws by itself, as `docs/look.md` states it: one palette, one grid
//! of letters, one margin.

use super::font::{CELL, glyph};
use crate::memory::{Rgba, VideoMemory};

/// Paper behind pictures.
pub const PAPER: Rgba = [0x0e, 0x14, 0x20, 255];
/// Text.
pub const TEXT: Rgba = [0xe8, 0xe8, 0xf0, 255];
/// Text that matters less.
pub const LESSER: Rgba = [0x80, 0x8c, 0xa5, 255];
/// First accent.
pub const GOLD: Rgba = [0xff, 0xb0, 0x00, 255];
/// Margin in pixels, on every side and between columns.
pub const MARGIN: usize = 16;

/// Draws a line in letters of `scale` times the font's size, clipped to the frame.
pub fn letters(memory: &mut VideoMemory, at: [usize; 2], line: &str, color: Rgba, scale: usize) {
    for (i, c) in line.chars().enumerate() {
        for (row, bits) in glyph(c).iter().enumerate() {
            for column in (0..CELL).filter(|column| bits & (0x80 >> column) != 0) {
                let x = at[0] + (i * CELL + column) * scale;
                let y = at[1] + row * scale;
                for (dx, dy) in (0..scale).flat_map(|dy| (0..scale).map(move |dx| (dx, dy))) {
                    memory.put_pixel((x + dx) as i32, (y + dy) as i32, color);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_those_of_text_enlarged() {
        let mut small = VideoMemory::new(40, 8).expect("small");
        crate::draw2d::text(&mut small, [0, 0], b"Look!", TEXT, crate::draw2d::Blend::Replace)
            .expect("ASCII");
        for scale in [1, 2, 3] {
            let mut memory = VideoMemory::new(40 * scale as u32, 8 * scale as u32).expect("small");
            letters(&mut memory, [0, 0], "Look!", TEXT, scale);
            for (x, y) in (0..8 * scale).flat_map(|y| (0..40 * scale).map(move |x| (x, y))) {
                let seen = memory.get_pixel(x as i32, y as i32);
                assert_eq!(seen, small.get_pixel((x / scale) as i32, (y / scale) as i32));
            }
        }
        let mut tiny = VideoMemory::new(3, 3).expect("small");
        letters(&mut tiny, [1, 1], "clipped", GOLD, 2);
    }
}

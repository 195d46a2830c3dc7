//! Text in the built-in font.

use super::blend::Paint;
use super::font::{CELL, glyph};
use super::{Blend, DrawError, Rect, run_mut, visible};
use crate::memory::{Rgba, VideoMemory};

/// Draws UTF-8 text. (x, y) is the upper left corner of the first character's 8x8 cell.
///
/// A line feed moves to the next line, 8 pixels down, at x again; a carriage return does nothing; a
/// character that the font lacks is drawn as a box. Only the glyph's own pixels are painted, not
/// the cell's background. Bytes that are not UTF-8 are an error, and nothing is drawn.
pub fn text(
    memory: &mut VideoMemory,
    [x, y]: [i32; 2],
    utf8: &[u8],
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    scaled_text(memory, [x, y], utf8, 1, color, blend)
}

/// Draws UTF-8 text as [`text`] does, each pixel of the font as a square of `scale` x `scale`
/// pixels. A scale of 0 counts as 1.
pub fn scaled_text(
    memory: &mut VideoMemory,
    [x, y]: [i32; 2],
    utf8: &[u8],
    scale: u8,
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    str::from_utf8(utf8).map_err(|e| DrawError::NotUtf8 { at: e.valid_up_to() as u64 })?;
    let mut cursor = TextCursor::scaled([x, y], scale);
    text_piece(memory, &mut cursor, utf8, color, blend, usize::MAX).map(drop)
}

/// Position of a text that is drawn in pieces.
#[derive(Clone, Copy, Debug)]
pub struct TextCursor {
    left: i64,
    cell: [i64; 2],
    /// Side in pixels of a pixel of the font.
    scale: i32,
    /// Number of bytes already drawn.
    at: usize,
}

impl TextCursor {
    /// Creates the cursor of a text whose upper left corner is (x, y).
    pub fn new([x, y]: [i32; 2]) -> Self {
        TextCursor::scaled([x, y], 1)
    }

    /// Creates the cursor of a text that is `scale` times as large, as [`scaled_text`] draws it.
    pub fn scaled([x, y]: [i32; 2], scale: u8) -> Self {
        TextCursor { left: x.into(), cell: [x.into(), y.into()], scale: i32::from(scale.max(1)), at: 0 }
    }

    /// Returns the number of bytes already drawn.
    pub fn bytes(&self) -> usize {
        self.at
    }
}

/// Draws about `most` bytes of a text (a character more or less) from the cursor on. Returns
/// whether the text is finished.
///
/// # Errors
/// Returns [`DrawError::NotUtf8`] if the next bytes are not UTF-8. Earlier pieces remain drawn: a
/// caller that must not draw part of an invalid text validates it before the first piece.
pub fn text_piece(
    memory: &mut VideoMemory,
    cursor: &mut TextCursor,
    utf8: &[u8],
    color: Rgba,
    blend: Blend,
    most: usize,
) -> Result<bool, DrawError> {
    let Some(paint) = Paint::new(color, blend) else { return Ok(true) };
    let mut end = cursor.at.saturating_add(most.max(4)).min(utf8.len());
    while end < utf8.len() && utf8[end] & 0xc0 == 0x80 {
        end -= 1;
    }
    let not_utf8 = |e: std::str::Utf8Error| DrawError::NotUtf8 { at: (cursor.at + e.valid_up_to()) as u64 };
    let text = str::from_utf8(&utf8[cursor.at..end]).map_err(not_utf8)?;
    let height = i64::from(memory.height());
    let scale = cursor.scale;
    let side = i64::from(scale) * CELL as i64;
    let [cell_x, cell_y] = &mut cursor.cell;
    for character in text.chars() {
        match character {
            '\n' => (*cell_x, *cell_y) = (cursor.left, *cell_y + side),
            '\r' => {}
            _ => {
                if let (Ok(x), Ok(y)) = (i32::try_from(*cell_x), i32::try_from(*cell_y)) {
                    draw_cell(memory, [x, y], scale, character, paint);
                }
                *cell_x += side;
            }
        }
        if *cell_y >= height {
            return Ok(true);
        }
    }
    cursor.at = end;
    Ok(end == utf8.len())
}

/// Draws one character whose cell's upper left corner is (x, y), clipped to the frame.
fn draw_cell(memory: &mut VideoMemory, [x, y]: [i32; 2], scale: i32, character: char, paint: Paint) {
    let side = scale * CELL as i32;
    let [xs, ys] = visible(memory, Rect { x, y, w: side, h: side });
    if xs.is_empty() || ys.is_empty() {
        return;
    }
    let rows = glyph(character);
    for row in ys {
        let inked = rows[((row - y) / scale) as usize];
        if inked == 0 {
            continue;
        }
        let pixels = run_mut(memory, row, xs.clone());
        match scale {
            1 => draw_row(pixels, inked << (xs.start - x), paint),
            _ => draw_scaled_row(pixels, inked, [x - xs.start, scale], paint),
        }
        memory.mark_row(row as u32);
    }
}

/// Draws a row of a glyph: a pixel for each bit of `inked`, the highest first, as far as there are
/// pixels.
#[inline]
fn draw_row(pixels: &mut [Rgba], inked: u8, paint: Paint) {
    let mut left = inked;
    while left != 0 {
        let column = left.leading_zeros();
        let Some(pixel) = pixels.get_mut(column as usize) else { return };
        paint.one(pixel);
        left &= !(0x80 >> column);
    }
}

/// Draws a row of a glyph whose pixels are `scale` columns wide; `start` is the index of the first of
/// them in `pixels`, which may be negative.
fn draw_scaled_row(pixels: &mut [Rgba], inked: u8, [start, scale]: [i32; 2], paint: Paint) {
    let most = pixels.len() as i32;
    for column in (0..CELL as i32).filter(|column| inked & 0x80 >> column != 0) {
        let [from, to] = [column, column + 1].map(|column| (start + column * scale).clamp(0, most) as usize);
        paint.run(&mut pixels[from..to]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::raster::{extremes, lit, memory, picture};

    #[test]
    fn words_look_like_this() {
        let mut m = memory(32, 16);
        text(&mut m, [0, 0], "Olá,\r\n\u{1F600}ç!".as_bytes(), [255; 4], Blend::Replace).unwrap();
        assert_eq!(picture(&m), WORDS);
    }

    #[test]
    fn large_letters_are_squares_of_the_small_ones() {
        let utf8 = "aW\nß".as_bytes();
        for scale in 1..=8u8 {
            for at in [[0, 0], [-11, -5], [7, 3]] {
                let (mut small, mut large) = (memory(60, 40), memory(40, 30));
                // Alpha 100 over black is red 100: drawn twice, it would be more.
                let color = [255, 255, 255, 100];
                text(&mut small, [0, 0], utf8, color, Blend::Over).unwrap();
                scaled_text(&mut large, at, utf8, scale, color, Blend::Over).unwrap();
                let inked = lit(&small, 100);
                let of = |v: i32, at: i32| (v - at).div_euclid(scale.into());
                let all = (0..30).flat_map(|y| (0..40).map(move |x| (x, y)));
                let want: Vec<_> =
                    all.filter(|&(x, y)| inked.contains(&(of(x, at[0]), of(y, at[1])))).collect();
                assert_eq!(lit(&large, 100), want, "{scale} {at:?}");
            }
        }
    }

    #[test]
    fn a_carriage_return_takes_no_room() {
        let drawn = |utf8: &[u8]| {
            let mut m = memory(40, 8);
            text(&mut m, [0, 0], utf8, [255; 4], Blend::Replace).unwrap();
            picture(&m)
        };
        assert_eq!(drawn(b"\ra\rb\r"), drawn(b"ab"));
    }

    #[test]
    fn pieces_of_a_text_are_the_text() {
        let utf8 = "Aé\u{1F600}b\ncçd".as_bytes();
        let (mut whole, mut pieces) = (memory(40, 16), memory(40, 16));
        text(&mut whole, [0, 0], utf8, [255; 4], Blend::Replace).unwrap();
        let mut cursor = TextCursor::new([0, 0]);
        let mut ends = vec![cursor.bytes()];
        while !text_piece(&mut pieces, &mut cursor, utf8, [255; 4], Blend::Replace, 4).unwrap() {
            ends.push(cursor.bytes());
        }
        // A piece of four bytes, or less by the character that would be cut.
        assert_eq!((ends, cursor.bytes()), (vec![0, 3, 7, 10], utf8.len()));
        assert_eq!(pieces.bytes(), whole.bytes());
    }

    #[test]
    fn text_is_cut_at_the_frame_and_composed_once() {
        let mut complete = memory(64, 48);
        text(&mut complete, [20, 20], b"Wg\nQ@", [255, 255, 255, 100], Blend::Over).unwrap();
        let inked = lit(&complete, 100);
        for (x, y) in (-20..12).step_by(3).flat_map(|x| (-20..12).step_by(3).map(move |y| (x, y))) {
            let mut m = memory(9, 10);
            text(&mut m, [x, y], b"Wg\nQ@", [255, 255, 255, 100], Blend::Over).unwrap();
            let moved = inked.iter().map(|&(px, py)| (px - 20 + x, py - 20 + y));
            let want: Vec<_> = moved.filter(|p| (0..9).contains(&p.0) && (0..10).contains(&p.1)).collect();
            assert_eq!(lit(&m, 100), want, "({x},{y})");
        }
    }

    #[test]
    fn odd_places_and_broken_bytes() {
        let long = "Aé\n".repeat(1000) + &"w".repeat(5000);
        for (x, y) in extremes().into_iter().flat_map(|x| extremes().map(|y| (x, y))) {
            text(&mut memory(7, 5), [x, y], long.as_bytes(), [255; 4], Blend::Over).unwrap();
        }
        let mut m = memory(7, 5);
        m.take_damage();
        let broken = text(&mut m, [0, 0], b"ab\xff", [255; 4], Blend::Replace).unwrap_err();
        assert_eq!(
            (broken.to_string().as_str(), broken.code().as_str()),
            ("utf-8 expected, broken at byte 2", "EFORMAT")
        );
        text(&mut m, [0, 0], b"", [255; 4], Blend::Replace).unwrap();
        text(&mut m, [0, 0], b"  \n ", [255; 4], Blend::Replace).unwrap();
        assert!(!m.is_damaged());
    }

    const WORDS: &str = "
..####.....##........#..........
.#....#.....#.......#...........
.#....#.....#.....####..........
.#....#.....#.........#.........
.#....#.....#.....#####.........
.#....#.....#....#....#....#....
..####.....###....#####....#....
..........................#.....
.######............#............
.#....#............#............
.#....#...####.....#............
.#....#..#....#....#............
.#....#..#.........#............
.#....#...#####.................
.######.....#......#............
..........##....................";
}

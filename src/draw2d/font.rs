//! The built-in font: 8x8 pixels a character, for printable ASCII and Latin-1 (U+0020..7E,
//! U+00A0..FF).
//!
//! The table is drawn as text in `font8x8.txt`, made for this project, and is parsed at compile
//! time.

/// Width and height of a character's cell, in pixels.
pub const CELL: usize = 8;

/// Eight rows, top first; the leftmost pixel of a row is its highest bit.
pub type Glyph = [u8; CELL];

/// Glyphs of U+0020 to U+007F, then of U+00A0 to U+00FF. The entry of U+007F is the box.
static GLYPHS: [Glyph; 192] = parse(include_bytes!("font8x8.txt"));

/// Index of the box in the table.
const BOX: usize = 0x7F - 0x20;

/// Returns the glyph of `character`, or a box if the font lacks it.
pub fn glyph(character: char) -> Glyph {
    let index = match character as u32 {
        code @ 0x20..=0x7F => code as usize - 0x20,
        code @ 0xA0..=0xFF => code as usize - 0x40,
        _ => BOX,
    };
    GLYPHS[index]
}

/// Parses the bands of eight characters. Lines that begin with neither `.` nor `#` are comments.
const fn parse(art: &[u8]) -> [Glyph; 192] {
    let mut glyphs = [[0; CELL]; 192];
    let (mut at, mut line) = (0, 0);
    while at < art.len() {
        if art[at] == b'.' || art[at] == b'#' {
            let mut column = 0;
            while column < CELL * (CELL + 1) - 1 {
                let (cell, bit) = (column / (CELL + 1), column % (CELL + 1));
                match (art[at + column], bit < CELL) {
                    (b'#', true) => glyphs[line / CELL * CELL + cell][line % CELL] |= 0x80 >> bit,
                    (b'.', true) | (b' ', false) => {}
                    _ => panic!("a row of the font is eight cells of eight pixels, with blanks between them"),
                }
                column += 1;
            }
            line += 1;
        }
        while at < art.len() && art[at] != b'\n' {
            at += 1;
        }
        at += 1;
    }
    assert!(line == 192, "the font has 24 bands of eight rows");
    glyphs
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn every_character_has_a_picture_of_its_own() {
        let mut seen: BTreeMap<Glyph, char> = BTreeMap::new();
        for c in (' '..='~').chain('\u{a1}'..='\u{ff}') {
            assert_ne!(glyph(c), glyph('\u{7f}'), "{c} is missing");
            assert!(c == ' ' || glyph(c) != [0; 8], "{c} is empty");
            if let Some(other) = seen.insert(glyph(c), c) {
                panic!("{c} looks like {other}");
            }
        }
        assert_eq!(glyph('\u{a0}'), [0; 8]);
    }

    #[test]
    fn what_the_font_lacks_is_a_box() {
        let a_box = [0x7E, 0x42, 0x42, 0x42, 0x42, 0x42, 0x7E, 0];
        for c in ['\u{7f}', '\u{80}', '\u{9f}', '\u{100}', '漢', '\u{10FFFF}', '\0'] {
            assert_eq!(glyph(c), a_box);
        }
    }
}

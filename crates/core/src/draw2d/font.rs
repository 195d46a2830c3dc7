//! The built-in font: 8x8 pixels a character, for printable ASCII, Latin-1 (U+0020..7E, U+00A0..FF)
//! and all of code page 437.
//!
//! The tables are drawn as text in `font8x8.txt` and `cp437.txt`, made for this project, and are
//! parsed at compile time.

/// Width and height of a character's cell, in pixels.
pub const CELL: usize = 8;

/// Eight rows, top first; the leftmost pixel of a row is its highest bit.
pub type Glyph = [u8; CELL];

/// Glyphs of U+0020 to U+007F, then of U+00A0 to U+00FF. The entry of U+007F is the box.
static GLYPHS: [Glyph; 192] = parse(include_bytes!("font8x8.txt"));

/// Characters of code page 437 that are neither ASCII nor Latin-1, in the order of their glyphs.
const BEYOND_LATIN: [char; 105] = [
    '☺', '☻', '♥', '♦', '♣', '♠', '•', '◘', '○', '◙', '♂', '♀', '♪', '♫', '☼', '►', '◄', '↕', '‼', '▬', '↨',
    '↑', '↓', '→', '←', '∟', '↔', '▲', '▼', '⌂', '₧', 'ƒ', '⌐', '░', '▒', '▓', '│', '┤', '╡', '╢', '╖', '╕',
    '╣', '║', '╗', '╝', '╜', '╛', '┐', '└', '┴', '┬', '├', '─', '┼', '╞', '╟', '╚', '╔', '╩', '╦', '╠', '═',
    '╬', '╧', '╨', '╤', '╥', '╙', '╘', '╒', '╓', '╫', '╪', '┘', '┌', '█', '▄', '▌', '▐', '▀', 'α', 'Γ', 'π',
    'Σ', 'σ', 'τ', 'Φ', 'Θ', 'Ω', 'δ', '∞', 'φ', 'ε', '∩', '≡', '≥', '≤', '⌠', '⌡', '≈', '∙', '√', 'ⁿ', '■',
];

/// Their glyphs; the last cells are unused.
static GLYPHS_BEYOND_LATIN: [Glyph; 112] = parse(include_bytes!("cp437.txt"));

/// Index of the box in the table.
const BOX: usize = 0x7F - 0x20;

/// Returns the glyph of `character`, or a box if the font lacks it.
pub fn glyph(character: char) -> Glyph {
    let index = match character as u32 {
        code @ 0x20..=0x7F => code as usize - 0x20,
        code @ 0xA0..=0xFF => code as usize - 0x40,
        _ => match BEYOND_LATIN.iter().position(|c| *c == character) {
            Some(index) => return GLYPHS_BEYOND_LATIN[index],
            None => BOX,
        },
    };
    GLYPHS[index]
}

/// Parses the bands of eight characters. Lines that begin with neither `.` nor `#` are comments.
const fn parse<const N: usize>(art: &[u8]) -> [Glyph; N] {
    let mut glyphs = [[0; CELL]; N];
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
    assert!(line == N, "a font has a band of eight rows for each eight characters");
    glyphs
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn every_character_has_a_picture_of_its_own() {
        let mut seen: BTreeMap<Glyph, char> = BTreeMap::new();
        for c in (' '..='~').chain('\u{a1}'..='\u{ff}').chain(BEYOND_LATIN) {
            assert_ne!(glyph(c), glyph('\u{7f}'), "{c} is missing");
            assert!(c == ' ' || glyph(c) != [0; 8], "{c} is empty");
            if let Some(other) = seen.insert(glyph(c), c) {
                panic!("{c} looks like {other}");
            }
        }
        assert_eq!(glyph('\u{a0}'), [0; 8]);
    }

    /// Code page 437, from 1 on: the pictures of control codes, ASCII, and the upper half.
    fn code_page_437() -> String {
        let ascii: String = (' '..='~').collect();
        let upper = "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜ¢£¥₧ƒáíóúñÑªº¿⌐¬½¼¡«»░▒▓│┤╡╢╖╕╣║╗╝╜╛┐└┴┬├─┼╞╟╚╔╩╦╠═╬╧╨╤╥╙╘╒╓╫╪┘┌\
            █▄▌▐▀αßΓπΣσµτΦΘΩδ∞φε∩≡±≥≤⌠⌡÷≈°∙·√ⁿ²■\u{a0}";
        format!("☺☻♥♦♣♠•◘○◙♂♀♪♫☼►◄↕‼¶§▬↨↑↓→←∟↔▲▼{ascii}⌂{upper}")
    }

    #[test]
    fn code_page_437_is_complete() {
        let page = code_page_437();
        assert_eq!(page.chars().count(), 255);
        for c in page.chars() {
            assert_ne!(glyph(c), glyph('\u{7f}'), "{c} is missing");
        }
        assert!(BEYOND_LATIN.iter().all(|c| page.contains(*c)));
    }

    #[test]
    fn lines_of_boxes_meet_at_the_edges_of_their_cells() {
        // Weights of the four arms: up, down, left, right.
        for (c, arms) in [
            ('│', [1, 1, 0, 0]),
            ('─', [0, 0, 1, 1]),
            ('┼', [1, 1, 1, 1]),
            ('║', [2, 2, 0, 0]),
            ('═', [0, 0, 2, 2]),
            ('╬', [2, 2, 2, 2]),
            ('┌', [0, 1, 0, 1]),
            ('╗', [0, 2, 2, 0]),
            ('╟', [2, 2, 0, 1]),
            ('╧', [1, 0, 2, 2]),
            ('╕', [0, 1, 2, 0]),
            ('╙', [2, 0, 0, 1]),
            ('╥', [0, 2, 1, 1]),
            ('╡', [1, 1, 2, 0]),
            ('╚', [2, 0, 0, 2]),
        ] {
            let rows = glyph(c);
            let column =
                |bit: u8| rows.iter().enumerate().fold(0u8, |sum, (y, row)| sum | (row >> bit & 1) << y);
            let across = |weight: usize| [0, 0b0001_1000, 0b0110_0110][weight];
            let along = |weight: usize| [0, 0b0000_1000, 0b0001_0100][weight];
            let found = [rows[0], rows[7], column(7), column(0)];
            let expected = [across(arms[0]), across(arms[1]), along(arms[2]), along(arms[3])];
            assert_eq!(found, expected, "{c}");
        }
    }

    #[test]
    fn what_the_font_lacks_is_a_box() {
        let a_box = [0x7E, 0x42, 0x42, 0x42, 0x42, 0x42, 0x7E, 0];
        for c in ['\u{7f}', '\u{80}', '\u{9f}', '\u{100}', '漢', '\u{10FFFF}', '\0'] {
            assert_eq!(glyph(c), a_box);
        }
    }
}

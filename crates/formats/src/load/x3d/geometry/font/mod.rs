//! Filled outlines of characters, for Text.
//!
//! In: a character. Out: its advance and simple polygons, in em: y = 0 is the baseline, x = 0 where the
//! character begins, counter-clockwise. No polygon of a glyph overlaps another, so that a transparent
//! Text is even. Letters with an accent are those of the letter and of the mark, centred over it;
//! other characters that the data lack are boxes.
//!
//! `glyphs.bin`, made by `make.py` from DejaVu Serif and Sans (`LICENSE`): the number of characters and
//! their codes as u16, little-endian; then for each face and character, as numbers of seven bits a byte,
//! low ones first, the sign in the lowest bit: advance, number of polygons, and for each the number of
//! points and their steps in x and y from the point before. The unit is 1/200 em.

use glam::DVec2;
use std::collections::HashMap;
use std::sync::LazyLock;

/// Height above the baseline and depth below it: together one em.
pub(super) const ASCENT: f64 = 0.76;
pub(super) const DESCENT: f64 = 0.24;
/// Height of capitals above small letters: marks are raised by it.
const CAPITAL_RAISE: f64 = 0.19;
/// Units of the data in one em.
const UNITS: f64 = 200.0;

/// Outline of a character.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Glyph {
    /// Distance to the next character.
    pub(super) advance: f64,
    pub(super) polygons: Vec<Vec<DVec2>>,
}

/// Typefaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Face {
    Serif,
    Sans,
}

static FACES: LazyLock<[HashMap<char, Glyph>; 2]> = LazyLock::new(|| read(include_bytes!("glyphs.bin")));

/// Letters with an accent: the letters, and for each mark the letters that it makes of them.
const ACCENTED: [(&str, char, &str); 14] = [
    ("AEIOU", '\u{300}', "ÀÈÌÒÙ"),
    ("aeıou", '\u{300}', "àèìòù"),
    ("AEIOUY", '\u{301}', "ÁÉÍÓÚÝ"),
    ("aeıouy", '\u{301}', "áéíóúý"),
    ("AEIOU", '\u{302}', "ÂÊÎÔÛ"),
    ("aeıou", '\u{302}', "âêîôû"),
    ("ANO", '\u{303}', "ÃÑÕ"),
    ("ano", '\u{303}', "ãñõ"),
    ("AEIOU", '\u{308}', "ÄËÏÖÜ"),
    ("aeıouy", '\u{308}', "äëïöüÿ"),
    ("A", '\u{30a}', "Å"),
    ("a", '\u{30a}', "å"),
    ("C", '\u{327}', "Ç"),
    ("c", '\u{327}', "ç"),
];

/// Returns the number that begins at `at`, and moves `at` behind it. The data end with the last one.
fn number(bytes: &[u8], at: &mut usize) -> i32 {
    let (mut value, mut shift) = (0_u32, 0);
    while let Some(byte) = bytes.get(*at) {
        *at += 1;
        value |= u32::from(byte & 127) << shift;
        if *byte < 128 {
            break;
        }
        shift += 7;
    }
    (value >> 1) as i32 ^ -((value & 1) as i32)
}

fn read(bytes: &[u8]) -> [HashMap<char, Glyph>; 2] {
    let code = |k: usize| u16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]);
    let codes: Vec<char> =
        (1..=usize::from(code(0))).filter_map(|k| char::from_u32(code(k).into())).collect();
    let mut at = 2 + 2 * codes.len();
    [(); 2].map(|()| {
        let mut face: HashMap<char, Glyph> = codes.iter().map(|c| (*c, glyph_at(bytes, &mut at))).collect();
        compose(&mut face);
        face
    })
}

fn glyph_at(bytes: &[u8], at: &mut usize) -> Glyph {
    let mut next = || number(bytes, at);
    let (advance, count) = (f64::from(next()) / UNITS, next());
    let mut pen = [0, 0];
    let mut point = |next: &mut dyn FnMut() -> i32| {
        pen = [pen[0] + next(), pen[1] + next()];
        DVec2::from(pen.map(f64::from)) / UNITS
    };
    let polygons = (0..count).map(|_| (0..next()).map(|_| point(&mut next)).collect()).collect();
    Glyph { advance, polygons }
}

/// Returns the middle of a glyph's width.
fn middle(glyph: &Glyph) -> f64 {
    let xs = || glyph.polygons.iter().flatten().map(|p| p.x);
    (xs().fold(f64::INFINITY, f64::min) + xs().fold(f64::NEG_INFINITY, f64::max)) / 2.0
}

/// Adds the letters with an accent to a face.
fn compose(face: &mut HashMap<char, Glyph>) {
    for (letters, mark, made) in ACCENTED {
        for (letter, made) in letters.chars().zip(made.chars()) {
            let (mut glyph, over) = (face[&letter].clone(), &face[&mark]);
            let raise = if letter.is_uppercase() && mark != '\u{327}' { CAPITAL_RAISE } else { 0.0 };
            let shift = DVec2::new(middle(&glyph) - middle(over), raise);
            let moved = over.polygons.iter().map(|p| p.iter().map(|at| *at + shift).collect());
            glyph.polygons.extend(moved.collect::<Vec<_>>());
            face.insert(made, glyph);
        }
    }
}

/// Returns a character of a face: a space for a line end and the like, a box where it is missing.
pub(super) fn glyph(face: Face, character: char) -> &'static Glyph {
    static BOX: LazyLock<Glyph> = LazyLock::new(|| {
        let bar = |x: [f64; 2], y: [f64; 2]| {
            [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]| DVec2::new(x[i], y[j])).to_vec()
        };
        let sides = [
            bar([0.05, 0.1], [0.0, 0.7]),
            bar([0.5, 0.55], [0.0, 0.7]),
            bar([0.1, 0.5], [0.0, 0.05]),
            bar([0.1, 0.5], [0.65, 0.7]),
        ];
        Glyph { advance: 0.6, polygons: sides.into() }
    });
    let character = if character.is_whitespace() { ' ' } else { character };
    FACES[face as usize].get(&character).unwrap_or(&BOX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(polygon: &[DVec2]) -> f64 {
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>() / 2.0
    }

    #[test]
    fn every_polygon_of_the_data_has_its_front_to_the_reader_and_lies_about_the_line() {
        let all = FACES.iter().flatten();
        let polygons: Vec<_> = all.flat_map(|(c, g)| g.polygons.iter().map(move |p| (c, p))).collect();
        assert!(polygons.len() > 400, "{}", polygons.len());
        for (character, polygon) in polygons {
            assert!(polygon.len() > 2 && area(polygon) > 0.0, "{character:?}: {polygon:?}");
            for p in polygon {
                assert!(p.x > -0.7 && p.x < 1.2 && p.y > -0.3 && p.y < 1.1, "{character:?}: {p}");
            }
        }
    }

    #[test]
    fn characters_have_their_own_widths() {
        let advance = |face, c| glyph(face, c).advance;
        for face in [Face::Serif, Face::Sans] {
            assert!(advance(face, 'i') < advance(face, 'n') && advance(face, 'n') < advance(face, 'W'));
            assert_eq!(advance(face, '\n'), advance(face, ' '));
            assert!(glyph(face, ' ').polygons.is_empty());
        }
        assert_ne!(glyph(Face::Serif, 'T'), glyph(Face::Sans, 'T'));
    }

    #[test]
    fn accents_stand_over_their_letter_and_the_rest_is_a_box() {
        let (plain, accented) = (glyph(Face::Sans, 'o'), glyph(Face::Sans, 'ô'));
        assert_eq!(accented.advance, plain.advance);
        let above: Vec<DVec2> = accented.polygons[plain.polygons.len()..].concat();
        assert!(!above.is_empty() && above.iter().all(|p| p.y > 0.55 && p.x > 0.0 && p.x < plain.advance));
        assert_eq!(glyph(Face::Sans, '語').polygons.len(), 4);
        let accented = ACCENTED.iter().flat_map(|(.., made)| made.chars());
        assert!({ accented }.all(|c| glyph(Face::Serif, c) != glyph(Face::Serif, '語')));
    }
}

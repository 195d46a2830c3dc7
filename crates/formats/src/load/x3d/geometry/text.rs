//! Text: the outlines of characters (`font`) as faces in the plane z = 0. Source of the layout:
//! ISO/IEC 19775-1 clause 15.
//!
//! Expected: a line is as high as `size`, of which 0.76 are above the baseline; characters of a
//! horizontal line follow at their own advances, or with the family TYPEWRITER at 0.6 each (wider ones
//! are narrowed); those of a vertical line stand centred in squares. `length` and `maxExtent` stretch
//! and shrink the characters along the line. ITALIC leans by 0.2, BOLD is fatter by 0.02 on each side.

use super::super::graph::{GraphView, NodeId};
use super::font::{self, ASCENT, DESCENT, Face, Glyph};
use super::{Built, MAX_MADE_FACES, Result, too_big};
use fbptr_core::scene::{Corner, Mesh, NONE};
use glam::{DVec2, DVec3};

/// Advance of every character of the family TYPEWRITER.
const FIXED_ADVANCE: f64 = 0.6;
/// Shift to the right by height, of ITALIC.
const LEAN: f64 = 0.2;
/// Distance that outlines of BOLD are moved outwards.
const FATTER: f64 = 0.02;

/// One of the alignments of FontStyle.justify.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Justify {
    First,
    Begin,
    Middle,
    End,
}

impl Justify {
    fn read(word: Option<&String>, default: Justify) -> Justify {
        match word.map(|w| w.to_ascii_uppercase()).as_deref() {
            Some("FIRST") => Justify::First,
            Some("BEGIN") => Justify::Begin,
            Some("MIDDLE") => Justify::Middle,
            Some("END") => Justify::End,
            _ => default,
        }
    }
}

/// Fields of a FontStyle, or their defaults.
struct Style {
    size: f64,
    spacing: f64,
    is_horizontal: bool,
    is_left_to_right: bool,
    is_top_to_bottom: bool,
    major: Justify,
    minor: Justify,
    face: Face,
    is_fixed: bool,
    is_bold: bool,
    is_italic: bool,
}

impl Style {
    const DEFAULT: Style = Style {
        size: 1.0,
        spacing: 1.0,
        is_horizontal: true,
        is_left_to_right: true,
        is_top_to_bottom: true,
        major: Justify::Begin,
        minor: Justify::First,
        face: Face::Serif,
        is_fixed: false,
        is_bold: false,
        is_italic: false,
    };

    fn read(view: &GraphView, id: Option<NodeId>) -> Style {
        let Some(id) = id else {
            return Style::DEFAULT;
        };
        let justify = view.texts(id, "justify");
        let families = view.texts(id, "family").iter().map(|f| f.to_ascii_uppercase());
        let family = { families }.find(|f| matches!(f.as_str(), "SERIF" | "SANS" | "TYPEWRITER"));
        let style = view.text(id, "style").to_ascii_uppercase();
        Style {
            face: if matches!(family.as_deref(), Some("SANS" | "TYPEWRITER")) {
                Face::Sans
            } else {
                Face::Serif
            },
            is_fixed: family.as_deref() == Some("TYPEWRITER"),
            is_bold: style.contains("BOLD"),
            is_italic: style.contains("ITALIC"),
            size: view.real(id, "size"),
            spacing: view.real(id, "spacing"),
            is_horizontal: view.bool(id, "horizontal"),
            is_left_to_right: view.bool(id, "leftToRight"),
            is_top_to_bottom: view.bool(id, "topToBottom"),
            major: Justify::read(justify.first(), Justify::Begin),
            minor: Justify::read(justify.get(1), Justify::First),
        }
    }

    /// Returns the advance of a character, and the factor of its own width.
    fn advance(&self, character: char) -> (f64, f64) {
        let fat = if self.is_bold { 2.0 * FATTER } else { 0.0 };
        let own = font::glyph(self.face, character).advance + fat;
        match self.is_fixed {
            true => (FIXED_ADVANCE, (FIXED_ADVANCE / own).min(1.0)),
            false => (own, 1.0),
        }
    }

    /// Returns the extent of a character along its line.
    fn along(&self, character: char) -> f64 {
        if self.is_horizontal { self.advance(character).0 } else { 1.0 }
    }

    /// Returns the beginning of each character on its baseline, line by line, in units of the size, and
    /// the stretch along the line.
    fn places(&self, lines: &[TextLine]) -> Vec<(DVec2, f64, char)> {
        let mut places = Vec::new();
        let is_forward = if self.is_horizontal { self.is_left_to_right } else { !self.is_top_to_bottom };
        let goes_up = if self.is_horizontal { !self.is_top_to_bottom } else { self.is_left_to_right };
        // Across the lines: from the first line's near edge over all of them.
        let whole = 1.0 + (lines.len().saturating_sub(1)) as f64 * self.spacing;
        let (near, first) = match (self.is_horizontal, goes_up) {
            (true, false) => (ASCENT, 0.0),
            (true, true) => (DESCENT, 0.0),
            (false, _) => (0.0, 0.0),
        };
        let shift = match self.minor {
            Justify::First => first,
            Justify::Begin => near,
            Justify::Middle => near - whole / 2.0,
            Justify::End => near - whole,
        };
        for (i, line) in lines.iter().enumerate() {
            let extent = line.text.chars().map(|c| self.along(c)).sum::<f64>() * line.stretch;
            let start = match self.major {
                Justify::First | Justify::Begin => 0.0,
                Justify::Middle => extent / 2.0,
                Justify::End => extent,
            };
            let across = shift + i as f64 * self.spacing;
            let across = if goes_up { across } else { -across };
            let mut pen = -start;
            for character in line.text.chars() {
                let step = self.along(character) * line.stretch;
                let along = if is_forward { pen } else { -pen - step };
                pen += step;
                let centred = (1.0 - self.advance(character).0) / 2.0;
                let place = match (self.is_horizontal, goes_up) {
                    (true, _) => DVec2::new(along, across),
                    (false, true) => DVec2::new(across + centred, along + DESCENT * line.stretch),
                    (false, false) => DVec2::new(across - 1.0 + centred, along + DESCENT * line.stretch),
                };
                places.push((place, line.stretch, character));
            }
        }
        places
    }

    /// Returns the outline of a character in em, as wide, fat and leaning as the style has it.
    fn outline(&self, character: char) -> Vec<Vec<DVec2>> {
        let Glyph { advance, polygons } = font::glyph(self.face, character);
        let (fixed, width) = self.advance(character);
        let fat = if self.is_bold { FATTER } else { 0.0 };
        // A narrow character of fixed advance stands in the middle of it.
        let first = fat + if self.is_fixed { (fixed - (advance + 2.0 * fat) * width) / 2.0 } else { 0.0 };
        let lean = if self.is_italic { LEAN } else { 0.0 };
        let shaped = |p: DVec2| DVec2::new(p.x * width + first + p.y * lean, p.y);
        let fattened =
            |ring: &Vec<DVec2>| if fat > 0.0 { moved_out(ring, polygons, fat) } else { ring.clone() };
        polygons.iter().map(|ring| fattened(ring).into_iter().map(shaped).collect()).collect()
    }
}

/// Returns whether any of these polygons has the side from `a` to `b`.
fn has_side(polygons: &[Vec<DVec2>], a: DVec2, b: DVec2) -> bool {
    let has = |ring: &Vec<DVec2>| (0..ring.len()).any(|k| ring[k] == a && ring[(k + 1) % ring.len()] == b);
    polygons.iter().any(has)
}

/// Returns a counter-clockwise polygon whose sides are moved outwards by a distance, except for the
/// cuts between it and the others of its glyph.
fn moved_out(ring: &[DVec2], glyph: &[Vec<DVec2>], distance: f64) -> Vec<DVec2> {
    let count = ring.len();
    // Direction of each side, and whether it is a cut.
    let side = |k: usize| {
        let [a, b] = [ring[k % count], ring[(k + 1) % count]];
        ((b - a).normalize_or_zero(), has_side(glyph, b, a))
    };
    let sides: Vec<(DVec2, bool)> = (0..count).map(side).collect();
    let outwards = |side: DVec2| DVec2::new(side.y, -side.x);
    let corner = |k: usize| {
        let [(before, is_cut_before), (after, is_cut_after)] = [sides[(k + count - 1) % count], sides[k]];
        // A sharp corner moves no farther than three distances.
        let moved = match (is_cut_before, is_cut_after) {
            (true, true) => DVec2::ZERO,
            (true, false) => before * (distance / before.dot(outwards(after)).max(0.3)),
            (false, true) => after * (-distance / (-after).dot(outwards(before)).max(0.3)),
            (false, false) => {
                let [before, after] = [outwards(before), outwards(after)];
                (before + after) * (distance / (1.0 + before.dot(after)).max(0.3))
            }
        };
        ring[k] + moved
    };
    (0..count).map(corner).collect()
}

/// One line of a Text.
struct TextLine<'a> {
    text: &'a str,
    /// Stretch factor along the line from `length` or `maxExtent`.
    stretch: f64,
}

/// Builds a Text.
pub(super) fn build(view: &GraphView, id: NodeId) -> Result<Built> {
    let style = Style::read(view, view.child(id, "fontStyle"));
    let texts = view.texts(id, "string");
    let mut built = Built::default();
    if style.size <= 0.0 {
        built.remarks.push(format!("<FontStyle> size {} shows nothing: it must be positive", style.size));
        return Ok(built);
    }
    let (lengths, max_extent) = (view.reals(id, "length"), view.real(id, "maxExtent"));
    let extent = |text: &str| text.chars().map(|c| style.along(c)).sum::<f64>() * style.size;
    let natural = |i: usize, text: &str| match lengths.get(i) {
        Some(length) if *length > 0.0 && !text.is_empty() => length / extent(text),
        _ => 1.0,
    };
    let longest = texts.iter().enumerate().map(|(i, t)| natural(i, t) * extent(t)).fold(0.0, f64::max);
    let shrink = if max_extent > 0.0 && longest > max_extent { max_extent / longest } else { 1.0 };
    let lines: Vec<TextLine> = texts
        .iter()
        .enumerate()
        .map(|(i, t)| TextLine { text: t, stretch: natural(i, t) * shrink })
        .collect();
    let faces = triangles(texts);
    if faces > MAX_MADE_FACES {
        return Err(too_big(id, "string", faces));
    }
    let mut mesh = Mesh { normals: vec![DVec3::Z], ..Mesh::default() };
    for (place, stretch, character) in style.places(&lines) {
        let along = if style.is_horizontal { DVec2::new(stretch, 1.0) } else { DVec2::new(1.0, stretch) };
        for polygon in style.outline(character) {
            let first = mesh.positions.len() as u32;
            let at = |p: DVec2| place + p * along;
            mesh.positions.extend(polygon.iter().map(|p| (at(*p) * style.size).extend(0.0)));
            mesh.texcoords.extend(polygon.iter().map(|p| at(*p)));
            let corner = |i: u32| Corner { position: i, normal: 0, texcoord: i, color: NONE };
            let corners: Vec<Corner> = (first..mesh.positions.len() as u32).map(corner).collect();
            mesh.push_polygon(&corners, NONE);
        }
    }
    built.mesh = mesh;
    Ok(built)
}

/// Returns the number of triangles that the characters of these texts consist of, at most.
pub(in super::super) fn triangles(texts: &[String]) -> u64 {
    let of_glyph = |c: char, face| {
        font::glyph(face, c).polygons.iter().map(|p| p.len().saturating_sub(2) as u64).sum::<u64>()
    };
    let most = |c: char| of_glyph(c, Face::Serif).max(of_glyph(c, Face::Sans));
    texts.iter().flat_map(|t| t.chars()).map(most).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn style(is_horizontal: bool, major: Justify, minor: Justify) -> Style {
        Style { is_horizontal, major, minor, ..Style { size: 2.0, spacing: 1.5, ..Style::DEFAULT } }
    }

    /// Returns the places of "ii" over "W".
    fn places(style: &Style) -> Vec<DVec2> {
        let lines = [TextLine { text: "ii", stretch: 1.0 }, TextLine { text: "W", stretch: 1.0 }];
        style.places(&lines).into_iter().map(|c| c.0).collect()
    }

    fn close(found: &[DVec2], expected: &[[f64; 2]]) {
        assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(expected) {
            assert!((*a - DVec2::from(*b)).length() < 1e-12, "{found:?} is not {expected:?}");
        }
    }

    #[test]
    fn lines_run_right_and_down_from_the_first_baseline() {
        let [i, w] = ['i', 'W'].map(|c| font::glyph(Face::Serif, c).advance);
        let at = places(&style(true, Justify::Begin, Justify::First));
        close(&at, &[[0.0, 0.0], [i, 0.0], [0.0, -1.5]]);
        let up = Style { is_top_to_bottom: false, ..style(true, Justify::End, Justify::First) };
        close(&places(&up), &[[-2.0 * i, 0.0], [-i, 0.0], [-w, 1.5]]);
        let left = Style { is_left_to_right: false, ..style(true, Justify::Begin, Justify::First) };
        close(&places(&left), &[[-i, 0.0], [-2.0 * i, 0.0], [-w, -1.5]]);
        let fixed = Style { is_fixed: true, ..style(true, Justify::Middle, Justify::First) };
        close(&places(&fixed), &[[-0.6, 0.0], [0.0, 0.0], [-0.3, -1.5]]);
    }

    #[test]
    fn the_block_is_set_about_the_origin() {
        let [i, w] = ['i', 'W'].map(|c| font::glyph(Face::Serif, c).advance);
        // 2.5 high in total: the top of the first line is at 1.25, the bottom of the second at
        // -1.25.
        let at = places(&style(true, Justify::Middle, Justify::Middle));
        close(&at, &[[-i, 0.49], [0.0, 0.49], [-w / 2.0, -1.01]]);
        let top = places(&style(true, Justify::Begin, Justify::Begin));
        close(&top[..1], &[[0.0, -0.76]]);
        let bottom = places(&style(true, Justify::Begin, Justify::End));
        close(&bottom[2..], &[[0.0, 0.24]]);
    }

    #[test]
    fn columns_run_down_and_right_with_their_characters_in_the_middle() {
        let [i, w] = ['i', 'W'].map(|c| (1.0 - font::glyph(Face::Serif, c).advance) / 2.0);
        let at = places(&style(false, Justify::Begin, Justify::Begin));
        close(&at, &[[i, -0.76], [i, -1.76], [1.5 + w, -0.76]]);
    }

    #[test]
    fn styles_shape_the_outlines() {
        let [low, high] = [|s: &Style, c| extent(s, c)[0], |s: &Style, c| extent(s, c)[1]];
        fn extent(style: &Style, character: char) -> [f64; 2] {
            let xs: Vec<f64> = style.outline(character).into_iter().flatten().map(|p| p.x).collect();
            [xs.iter().fold(9.0, |m: f64, x| m.min(*x)), xs.iter().fold(-9.0, |m: f64, x| m.max(*x))]
        }
        let plain = style(true, Justify::Begin, Justify::First);
        let bold = Style { is_bold: true, ..style(true, Justify::Begin, Justify::First) };
        let width = |s: &Style, c| high(s, c) - low(s, c);
        assert!((width(&bold, 'H') - width(&plain, 'H') - 2.0 * FATTER).abs() < 1e-12);
        assert!(low(&bold, 'H') > 0.0 && bold.advance('H').0 > plain.advance('H').0);
        let italic = Style { is_italic: true, ..style(true, Justify::Begin, Justify::First) };
        assert!((width(&italic, 'H') - width(&plain, 'H') - LEAN * 0.73).abs() < 0.01);
        let fixed = Style { is_fixed: true, face: Face::Sans, ..style(true, Justify::Begin, Justify::First) };
        for c in ['i', 'W', '@'] {
            assert!(low(&fixed, c) > -0.02 && high(&fixed, c) < FIXED_ADVANCE + 0.02, "{c}");
        }
    }
}

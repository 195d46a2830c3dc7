//! Text: the pixels of the built-in font as squares in the plane z = 0. Source of the layout:
//! ISO/IEC 19775-1 clause 15.
//!
//! A character cell is `size` high and wide; its lowest row is below the baseline (descenders).
//! Adjacent squares of a character share positions, so that no gap can appear between them.

use super::super::graph::{GraphView, NodeId};
use super::{Built, MAX_MADE_FACES, Result, too_big};
use fbptr_core::draw2d::font::{CELL, glyph};
use fbptr_core::scene::{Corner, Mesh, NONE};
use glam::{DVec2, DVec3};

/// Part of a cell above the baseline; its descent is the part below.
const ASCENT: f64 = 7.0 / 8.0;
const DESCENT: f64 = 1.0 / 8.0;

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
    };

    fn read(view: &GraphView, id: Option<NodeId>) -> Style {
        let Some(id) = id else {
            return Style::DEFAULT;
        };
        let justify = view.texts(id, "justify");
        Style {
            size: view.real(id, "size"),
            spacing: view.real(id, "spacing"),
            is_horizontal: view.bool(id, "horizontal"),
            is_left_to_right: view.bool(id, "leftToRight"),
            is_top_to_bottom: view.bool(id, "topToBottom"),
            major: Justify::read(justify.first(), Justify::Begin),
            minor: Justify::read(justify.get(1), Justify::First),
        }
    }

    /// Returns each character's cell, line by line: its lower left corner in units of the size, and
    /// the stretch along the line.
    fn cells(&self, lines: &[TextLine]) -> Vec<(DVec2, f64, char)> {
        let mut cells = Vec::new();
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
            let extent = line.text.chars().count() as f64 * line.stretch;
            let start = match self.major {
                Justify::First | Justify::Begin => 0.0,
                Justify::Middle => extent / 2.0,
                Justify::End => extent,
            };
            let across = shift + i as f64 * self.spacing;
            for (k, character) in line.text.chars().enumerate() {
                let k = k as f64 * line.stretch - start;
                let along = if is_forward { k } else { -k - line.stretch };
                let across = if goes_up { across } else { -across };
                let corner = match (self.is_horizontal, goes_up) {
                    (true, _) => DVec2::new(along, across - DESCENT),
                    (false, true) => DVec2::new(across, along),
                    (false, false) => DVec2::new(across - 1.0, along),
                };
                cells.push((corner, line.stretch, character));
            }
        }
        cells
    }
}

/// One line of a Text.
struct TextLine<'a> {
    text: &'a str,
    /// Stretch factor along the line from `length` or `maxExtent`.
    stretch: f64,
}

/// Builds a Text, one square per pixel of its characters.
pub(super) fn build(view: &GraphView, id: NodeId) -> Result<Built> {
    let style = Style::read(view, view.child(id, "fontStyle"));
    let texts = view.texts(id, "string");
    let mut built = Built::default();
    if style.size <= 0.0 {
        built.remarks.push(format!("<FontStyle> size {} shows nothing: it must be positive", style.size));
        return Ok(built);
    }
    let (lengths, max_extent) = (view.reals(id, "length"), view.real(id, "maxExtent"));
    let extent = |text: &str| text.chars().count() as f64 * style.size;
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
    let faces = squares(texts);
    if faces > MAX_MADE_FACES {
        return Err(too_big(id, "string", faces));
    }
    let mut mesh = Mesh { normals: vec![DVec3::Z], ..Mesh::default() };
    for (corner, stretch, character) in style.cells(&lines) {
        let along = if style.is_horizontal { DVec2::new(stretch, 1.0) } else { DVec2::new(1.0, stretch) };
        add(&mut mesh, glyph(character), corner, along / CELL as f64, style.size);
    }
    built.mesh = mesh;
    Ok(built)
}

/// Returns the number of squares that the characters of these texts consist of.
pub(in super::super) fn squares(texts: &[String]) -> u64 {
    let lit = |c: char| glyph(c).iter().map(|row| u64::from(row.count_ones())).sum::<u64>();
    texts.iter().flat_map(|t| t.chars()).map(lit).sum()
}

/// Adds one character; `corner` (lower left) and `pixel` (size of its pixels) are in units of
/// `size`.
fn add(mesh: &mut Mesh, rows: [u8; CELL], corner: DVec2, pixel: DVec2, size: f64) {
    let mut made = [[NONE; CELL + 1]; CELL + 1];
    for (row, bits) in rows.iter().enumerate() {
        for column in (0..CELL).filter(|c| bits & 0x80 >> c != 0) {
            let up = CELL - row - 1;
            let square = [(column, up), (column + 1, up), (column + 1, up + 1), (column, up + 1)];
            let corners = square.map(|(x, y)| {
                if made[y][x] == NONE {
                    made[y][x] = mesh.positions.len() as u32;
                    let at = corner + DVec2::new(x as f64, y as f64) * pixel;
                    mesh.positions.push((at * size).extend(0.0));
                    mesh.texcoords.push(at);
                }
                Corner { position: made[y][x], normal: 0, texcoord: made[y][x], color: NONE }
            });
            mesh.push_polygon(&corners, NONE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn style(is_horizontal: bool, major: Justify, minor: Justify) -> Style {
        Style { is_horizontal, major, minor, ..Style { size: 2.0, spacing: 1.5, ..Style::DEFAULT } }
    }

    /// Returns the lower left corners of the cells of "ab" over "c".
    fn corners(style: &Style) -> Vec<[f64; 2]> {
        let lines = [TextLine { text: "ab", stretch: 1.0 }, TextLine { text: "c", stretch: 1.0 }];
        style.cells(&lines).into_iter().map(|c| c.0.to_array()).collect()
    }

    #[test]
    fn lines_run_right_and_down_from_the_first_baseline() {
        let at = corners(&style(true, Justify::Begin, Justify::First));
        assert_eq!(at, [[0.0, -0.125], [1.0, -0.125], [0.0, -1.625]]);
        let up = Style { is_top_to_bottom: false, ..style(true, Justify::End, Justify::First) };
        assert_eq!(corners(&up), [[-2.0, -0.125], [-1.0, -0.125], [-1.0, 1.375]]);
        let left = Style { is_left_to_right: false, ..style(true, Justify::Begin, Justify::First) };
        assert_eq!(corners(&left), [[-1.0, -0.125], [-2.0, -0.125], [-1.0, -1.625]]);
    }

    #[test]
    fn the_block_is_set_about_the_origin() {
        // 2.5 high in total: the top of the first line is at 1.25, the bottom of the second at
        // -1.25.
        let at = corners(&style(true, Justify::Middle, Justify::Middle));
        assert_eq!(at, [[-1.0, 0.25], [0.0, 0.25], [-0.5, -1.25]]);
        let top = corners(&style(true, Justify::Begin, Justify::Begin));
        assert_eq!(top[0], [0.0, -1.0]);
        let bottom = corners(&style(true, Justify::Begin, Justify::End));
        assert_eq!(bottom[2], [0.0, 0.0]);
    }

    #[test]
    fn columns_run_down_and_right() {
        let at = corners(&style(false, Justify::Begin, Justify::Begin));
        assert_eq!(at, [[0.0, -1.0], [0.0, -2.0], [1.5, -1.0]]);
    }
}

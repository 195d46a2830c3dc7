//! Line, fill and point styles of an object (X3D's LineProperties, FillProperties and
//! PointProperties), and its textures beyond the first.
//!
//! Both are patterns on the frame, in pixels, at any distance. Source: ISO/IEC 19775-1 clauses
//! 12.4.3 (FillProperties) and 12.4.4 (LineProperties). The standard leaves the pixels of a pattern
//! to the browser; they are defined here.

use super::{SurfaceMaps, TextureStages};
use glam::DVec3;
use std::sync::Arc;

/// Style of an object beside its material.
#[derive(Clone, Debug, Default)]
pub struct Style {
    /// Style of its lines.
    pub line: LineStyle,
    /// Style of its faces.
    pub fill: FillStyle,
    /// Multitexture stages, in place of the object's own texture.
    pub stages: Option<Arc<TextureStages>>,
    /// Maps of emission, normals and occlusion.
    pub maps: Option<Arc<SurfaceMaps>>,
    /// Side of its points in pixels, up to [`MAX_POINT_SIZE`]: squares about the pixel of the point,
    /// the larger half below and to the right. 0 and 1 are that pixel.
    pub point_size: u32,
    /// Shape of its points.
    pub point_shape: PointShape,
}

/// Shape of points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PointShape {
    /// Squares of one size at every distance.
    #[default]
    Square,
    /// Discs: of the pixels of the square, those whose centres are inside it. In perspective their
    /// diameter is the point's size where the clip-space w is `at_w` and inversely proportional to
    /// w elsewhere, rounded, at least a pixel.
    Disc {
        /// The w of points that have their own size.
        at_w: f64,
    },
}

impl PointShape {
    /// Returns the side in pixels of a point of `size` at `w`, up to [`MAX_POINT_SIZE`].
    pub fn side_at(self, size: u32, w: f64, is_parallel: bool) -> u32 {
        let size = size.clamp(1, MAX_POINT_SIZE);
        match self {
            PointShape::Disc { at_w } if !is_parallel => {
                // A quotient that is not a number becomes 0.
                ((f64::from(size) * (at_w / w)).round() as u32).clamp(1, MAX_POINT_SIZE)
            }
            _ => size,
        }
    }

    /// Returns whether the pixel `dx` to the right of the point's own and `dy` below belongs to a
    /// point of `side` pixels, given that it belongs to the square.
    pub fn covers(self, side: u32, [dx, dy]: [i64; 2]) -> bool {
        let half_pixels = |d: i64| 2 * d - i64::from(side.is_multiple_of(2));
        let [x, y, n] = [half_pixels(dx), half_pixels(dy), i64::from(side)];
        self == PointShape::Square || x * x + y * y <= n * n
    }

    /// Returns the largest side that a point of `size` can have.
    pub fn largest_side(self, size: u32) -> u32 {
        if self == PointShape::Square { size.clamp(1, MAX_POINT_SIZE) } else { MAX_POINT_SIZE }
    }
}

/// Largest side of a point in pixels.
pub const MAX_POINT_SIZE: u32 = 64;

impl PartialEq for Style {
    /// Compares stages and maps by identity, not by value.
    fn eq(&self, other: &Self) -> bool {
        (self.line, self.fill) == (other.line, other.fill)
            && (self.point_size, self.point_shape) == (other.point_size, other.point_shape)
            && is_same(&self.stages, &other.stages)
            && is_same(&self.maps, &other.maps)
    }
}

/// Returns whether two references lead to the same value, or are both empty.
fn is_same<T>(a: &Option<Arc<T>>, b: &Option<Arc<T>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// Width and pattern of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineStyle {
    /// Width in pixels, at least 1. A line is thickened along its minor axis: each pixel of the
    /// thin line becomes `width` pixels, the larger half below or to the right.
    pub width: u32,
    /// Pattern of its pixels.
    pub kind: LineKind,
}

impl Default for LineStyle {
    fn default() -> Self {
        LineStyle { width: 1, kind: LineKind::Solid }
    }
}

/// Pattern of a line: the pixels drawn, with a period of 16 steps from the first pixel, in units of
/// the line's width.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum LineKind {
    /// All pixels.
    #[default]
    Solid,
    /// Eight on, eight off.
    Dashed,
    /// One on, three off.
    Dotted,
    /// A dash of eight and a dot of two, three off after each.
    DashDot,
    /// A dash of eight and two dots of one, two off after each.
    DashDotDot,
}

impl LineKind {
    /// Returns whether the pixel `step` steps from the line's first one is drawn.
    pub fn is_on(self, step: u64, width: u32) -> bool {
        let bits: u16 = match self {
            LineKind::Solid => return true,
            LineKind::Dashed => 0b0000_0000_1111_1111,
            LineKind::Dotted => 0b0001_0001_0001_0001,
            LineKind::DashDot => 0b0001_1000_1111_1111,
            LineKind::DashDotDot => 0b0010_0100_1111_1111,
        };
        bits >> (step / u64::from(width.max(1)) % 16) & 1 == 1
    }
}

/// Filling of faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillStyle {
    /// True if the face is drawn between the lines of a hatch; without a hatch, whether it is drawn
    /// at all.
    pub is_filled: bool,
    /// Hatch over the faces, with its unlit colour R, G, B.
    pub hatch: Option<(Hatch, DVec3)>,
}

impl Default for FillStyle {
    fn default() -> Self {
        FillStyle { is_filled: true, hatch: None }
    }
}

/// Content of a pixel of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filling {
    /// The face itself.
    Face,
    /// A hatch line of this colour.
    Hatch(DVec3),
    /// Nothing: the pixel is left unchanged.
    Nothing,
}

impl FillStyle {
    /// Returns the content of the pixel in column `x` and row `y` of the frame.
    pub fn at(&self, x: i32, y: i32) -> Filling {
        match self.hatch {
            Some((hatch, color)) if hatch.covers(x, y) => Filling::Hatch(color),
            _ if self.is_filled => Filling::Face,
            _ => Filling::Nothing,
        }
    }
}

/// Hatch pattern: lines one pixel wide, one every eight pixels along rows and columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hatch {
    /// Along rows.
    Horizontal,
    /// Along columns.
    Vertical,
    /// Up to the right.
    Rising,
    /// Down to the right.
    Falling,
    /// Along rows and columns.
    Square,
    /// Both diagonals.
    Diamond,
}

impl Hatch {
    /// Distance between lines in pixels.
    const SPACING: i32 = 8;

    /// Returns whether the pixel in column `x` and row `y` of the frame, y down, is on a line.
    pub fn covers(self, x: i32, y: i32) -> bool {
        let on = |at: i32| at.rem_euclid(Hatch::SPACING) == 0;
        match self {
            Hatch::Horizontal => on(y),
            Hatch::Vertical => on(x),
            Hatch::Rising => on(x.wrapping_add(y)),
            Hatch::Falling => on(x.wrapping_sub(y)),
            Hatch::Square => on(x) || on(y),
            Hatch::Diamond => on(x.wrapping_add(y)) || on(x.wrapping_sub(y)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_of_lines_are_as_they_are_said() {
        let drawn = |kind: LineKind, width: u32| -> String {
            (0..16 * u64::from(width)).map(|k| if kind.is_on(k, width) { '#' } else { '.' }).collect()
        };
        for (kind, expected) in [
            (LineKind::Solid, "################"),
            (LineKind::Dashed, "########........"),
            (LineKind::Dotted, "#...#...#...#..."),
            (LineKind::DashDot, "########...##..."),
            (LineKind::DashDotDot, "########..#..#.."),
        ] {
            assert_eq!(drawn(kind, 1), expected);
            assert!(kind.is_on(16, 1) && kind.is_on(16_000_000_000_000, 1));
        }
        assert_eq!(drawn(LineKind::Dotted, 2), "##......##......##......##......");
    }

    #[test]
    fn a_disc_is_round_and_shrinks_with_distance() {
        let disc = PointShape::Disc { at_w: 4.0 };
        let rows = |side: u32| -> Vec<String> {
            let n = i64::from(side);
            let around = -((n - 1) / 2)..=n / 2;
            let row =
                |dy| around.clone().map(|dx| if disc.covers(side, [dx, dy]) { '#' } else { '.' }).collect();
            around.clone().map(row).collect()
        };
        assert_eq!(rows(1), ["#"]);
        assert_eq!(rows(2), ["##", "##"]);
        assert_eq!(rows(4), [".##.", "####", "####", ".##."]);
        assert_eq!(rows(5), [".###.", "#####", "#####", "#####", ".###."]);
        let sides = [1.0, 2.0, 4.0, 8.0, 100.0, f64::INFINITY].map(|w| disc.side_at(6, w, false));
        assert_eq!(sides, [24, 12, 6, 3, 1, 1]);
        assert_eq!([disc.side_at(6, 1e-300, false), disc.side_at(6, 1.0, true)], [MAX_POINT_SIZE, 6]);
        assert_eq!(PointShape::Square.side_at(0, 9.0, false), 1);
    }

    #[test]
    fn hatches_run_as_they_are_called() {
        let fill = |hatch, is_filled| FillStyle { is_filled, hatch: Some((hatch, DVec3::X)) };
        let row = |hatch, y| -> String {
            let sign = |x| if fill(hatch, true).at(x, y) == Filling::Face { '.' } else { '#' };
            (-1..9).map(sign).collect()
        };
        assert_eq!([row(Hatch::Horizontal, 0), row(Hatch::Horizontal, 1)], ["##########", ".........."]);
        assert_eq!(row(Hatch::Vertical, 3), ".#.......#");
        // y runs down: a line that rises to the right has less x on a lower row.
        assert_eq!([row(Hatch::Rising, 8), row(Hatch::Rising, 9)], [".#.......#", "#.......#."]);
        assert_eq!([row(Hatch::Falling, 8), row(Hatch::Falling, 9)], [".#.......#", "..#......."]);
        assert_eq!([row(Hatch::Square, 0), row(Hatch::Square, 1)], ["##########", ".#.......#"]);
        assert_eq!(row(Hatch::Diamond, 1), "#.#.....#.");
        assert_eq!(fill(Hatch::Vertical, false).at(1, 0), Filling::Nothing);
        assert_eq!(fill(Hatch::Vertical, false).at(8, 0), Filling::Hatch(DVec3::X));
        assert_eq!(FillStyle::default().at(3, 4), Filling::Face);
    }
}

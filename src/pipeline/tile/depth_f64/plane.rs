//! Depth plane of a face in f64, its depths along a row, and their words.

use super::{DepthEncoder, DepthVertex};
use crate::pipeline::tile::exact_faces::ExactFace;
use crate::simd::Simd;

/// Depth over the screen, in the format's sense (z or 1 - z).
#[derive(Clone, Copy, Debug)]
pub struct DepthPlane {
    /// Position where depth is `base`, in pixels.
    origin: [f64; 2],
    base: f64,
    /// Depth steps per column and per row.
    run: [f64; 2],
    /// Least and greatest depth of the corners.
    range: [f64; 2],
}

impl DepthPlane {
    /// Returns the plane through three corners; their order does not matter.
    #[inline(always)]
    pub fn through(corners: [DepthVertex; 3]) -> DepthPlane {
        let [a, b, c] = corners;
        let (a, b) = in_order(a, b);
        let (b, c) = in_order(b, c);
        let (a, b) = in_order(a, b);
        let (bx, by, bd) = (b[0] - a[0], b[1] - a[1], b[2] - a[2]);
        let (cx, cy, cd) = (c[0] - a[0], c[1] - a[1], c[2] - a[2]);
        let det = bx * cy - cx * by;
        DepthPlane {
            origin: [a[0], a[1]],
            base: a[2],
            run: [(bd * cy - cd * by) / det, (cd * bx - bd * cx) / det],
            range: [lesser(lesser(a[2], b[2]), c[2]), greater(greater(a[2], b[2]), c[2])],
        }
    }

    /// Returns the plane that the plain path has set up.
    #[inline(always)]
    pub fn of_wide(exact_face: &ExactFace, encoder: &DepthEncoder) -> DepthPlane {
        let linear = &exact_face.plane;
        let ([base, x, y], range) = match encoder.is_reversed {
            true => (linear.complement, exact_face.exact_ranges[1]),
            false => (linear.z, exact_face.exact_ranges[0]),
        };
        DepthPlane { origin: linear.origin, base, run: [x, y], range }
    }

    /// Placeholder for unused elements.
    pub const NOWHERE: DepthPlane =
        DepthPlane { origin: [0.0; 2], base: 0.0, run: [0.0; 2], range: [0.0; 2] };

    /// Returns whether depth is constant along a row.
    #[inline(always)]
    pub fn is_level(&self) -> bool {
        self.run[0] == 0.0
    }

    /// Returns the term that row y adds to the base.
    #[inline(always)]
    pub fn down(&self, y: i32) -> f64 {
        self.run[1] * (y as f64 + 0.5 - self.origin[1])
    }

    /// Returns the depth at the centre of a pixel of column x and of a row that adds `down`,
    /// clamped to the corners' depths; NaN, on a face without area, becomes the nearest corner's.
    #[inline(always)]
    fn along(&self, x: i32, down: f64) -> f64 {
        let along = self.run[0] * (x as f64 + 0.5 - self.origin[0]);
        lesser(greater(self.base + (along + down), self.range[0]), self.range[1])
    }

    /// Returns the depth in 0..=1 at the centre of pixel (x, y).
    #[inline(always)]
    pub fn at(&self, x: i32, y: i32) -> f64 {
        within(self.along(x, self.down(y)))
    }

    /// Returns the depths in 0..=1 at LANES pixels from column x on.
    #[inline(always)]
    pub fn row<S: Simd>(&self, x: i32, down: f64) -> [f64; 16] {
        let mut out = [0.0; 16];
        for (i, lane) in out[..S::LANES].iter_mut().enumerate() {
            *lane = within(self.along(x + i as i32, down));
        }
        out
    }
}

/// Returns the lesser of two numbers; the second if one is NaN.
#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Returns the greater of two numbers; the second if one is NaN.
#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn in_order(p: DepthVertex, q: DepthVertex) -> (DepthVertex, DepthVertex) {
    let swap = p[0] > q[0] || (p[0] == q[0] && p[1] > q[1]);
    if swap { (q, p) } else { (p, q) }
}

/// Clamps a depth to 0..=1, beyond which rounding may have moved it slightly.
#[inline(always)]
fn within(depth: f64) -> f64 {
    lesser(greater(depth, 0.0), 1.0)
}

/// Returns the words of an exact face at LANES pixels from (x, y) on, and the lanes that lie
/// between near and far.
#[inline(always)]
pub fn exact_words<S: Simd>(
    s: S,
    encoder: &DepthEncoder,
    exact_face: &ExactFace,
    x: i32,
    y: i32,
) -> (S::I, S::M) {
    let plane = DepthPlane::of_wide(exact_face, encoder);
    let words = encoder.words(s, &plane.row::<S>(x, plane.down(y)));
    if exact_face.is_between {
        return (words, s.mask(u32::MAX));
    }
    let is_inside =
        |i: usize| exact_face.plane.is_between_near_and_far(exact_face.exact_ranges[0], x + i as i32, y);
    let inside = (0..S::LANES).fold(0u32, |bits, i| bits | u32::from(is_inside(i)) << i);
    (words, s.mask(inside))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_the_same_whatever_corner_comes_first() {
        let corners = [[3.25, 7.5, 0.25, 0.0], [90.0, 11.0, 0.75, 0.0], [3.25, 70.125, 0.5, 0.0]];
        let [a, b, c] = corners;
        let plane = DepthPlane::through(corners);
        for other in [[a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]] {
            let other = DepthPlane::through(other);
            for (x, y) in [(4, 8), (50, 20), (4, 60)] {
                assert_eq!(plane.at(x, y).to_bits(), other.at(x, y).to_bits());
            }
        }
        // Without area there is no plane, but there is a depth.
        let flat = DepthPlane::through([a, a, a]);
        assert_eq!(flat.at(100, 100), 0.25);
    }
}

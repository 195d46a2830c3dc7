//! Depth plane of a face in f64, and its depths along a row.

use super::encoder::DepthEncoder;
use super::vertices::DepthVertex;
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
    pub fn of_exact(exact_face: &ExactFace, encoder: &DepthEncoder) -> DepthPlane {
        let linear = &exact_face.plane;
        let ([base, x, y], range) = match encoder.is_reversed {
            true => (linear.complement, exact_face.exact_ranges[1]),
            false => (linear.z, exact_face.exact_ranges[0]),
        };
        DepthPlane { origin: linear.origin, base, run: [x, y], range }
    }

    /// Returns the depth's step per column.
    #[inline(always)]
    pub fn slope(&self) -> f64 {
        self.run[0]
    }

    /// Returns the term that row y adds to the base.
    #[inline(always)]
    pub fn down(&self, y: i32) -> f64 {
        self.run[1] * (y as f64 + 0.5 - self.origin[1])
    }

    /// Returns the depth in 0..=1 at the centre of a pixel of column x and of a row that adds `down`,
    /// clamped to the corners' depths; NaN, on a face without area, becomes the nearest corner's.
    #[inline(always)]
    pub fn depth(&self, x: i32, down: f64) -> f64 {
        let along = self.run[0] * (x as f64 + 0.5 - self.origin[0]);
        let depth = lesser(greater(self.base + (along + down), self.range[0]), self.range[1]);
        // Rounding may have moved it slightly beyond 0..=1.
        lesser(greater(depth, 0.0), 1.0)
    }

    /// Returns the depths in 0..=1 at LANES pixels from column x on.
    #[inline(always)]
    pub fn row<S: Simd>(&self, x: i32, down: f64) -> [f64; 16] {
        let mut out = [0.0; 16];
        for (i, lane) in out[..S::LANES].iter_mut().enumerate() {
            *lane = self.depth(x + i as i32, down);
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
                let [own, other] = [plane, other].map(|plane| plane.depth(x, plane.down(y)));
                assert_eq!(own.to_bits(), other.to_bits());
            }
        }
        // Without area there is no plane, but there is a depth.
        let flat = DepthPlane::through([a, a, a]);
        assert_eq!(flat.depth(100, flat.down(100)), 0.25);
    }
}

//! Exact faces: set up in f64 by the plain path, where screen vertices or f32 are insufficient
//! (behind the eye, huge, steep).
//!
//! Coverage is by exact spans; depth and barycentrics are linear functions of the pixel, in f64.
//! Along a row both are evaluated in f64 at the first column of each run of 16 columns and in f32
//! from there, so the values do not depend on the vector width.

use crate::math::coverage::{PixelRect, SnappedTriangle};
use crate::pipeline::plane_equation::PlaneEquation;
use crate::simd::{F32, I32, Mask, Part, Simd};

/// Columns that share a base value in f64.
pub(super) const RUN: i32 = 16;

/// Sum of the barycentrics, 1/w, up to which f32 does not decide: there the face's plane reaches the
/// horizon, or is seen edge-on.
pub(super) const LEAST_SUM: f32 = 1e-30;

/// Depth slope per column above which depth is evaluated in f64 at every pixel.
pub(super) const STEEP: f64 = 1.0 / 64.0;

/// Distance from 0 and from 1 within which rounding may put a depth in f32 on the wrong side.
const DEPTH_ROUNDING: f32 = 1e-6;

/// Face set up by the plain path.
#[derive(Clone, Debug)]
pub struct ExactFace {
    /// Index of the triangle in the mesh.
    pub face: u32,
    /// Columns and rows that may hold covered pixels, half-open, inside the clip rectangle.
    pub bounds: PixelRect,
    /// Covered area: the face, or the remains of a clipped one.
    pub outlines: [Option<SnappedTriangle>; 2],
    /// Plane equations of depth and barycentrics over the screen.
    pub plane: PlaneEquation,
    /// True if 0 <= z < 1 at every corner.
    pub is_between: bool,
    /// Nearest and farthest z of the corners; unbounded if the face is clipped. Depth is clamped to
    /// it, also at pixel centres outside the face.
    pub z_range: [f32; 2],
    /// These ranges in f64, of z and of 1 - z.
    pub exact_ranges: [[f64; 2]; 2],
    /// True if f32 depths are not those of the plain path at pixels beside the unsnapped face.
    pub is_rough: bool,
    /// True if some corner has w <= 0: barycentrics may then be negative.
    pub is_cut: bool,
    /// Factors from barycentrics to weights on the screen: each corner's w, or 1 where attributes
    /// are linear on the screen.
    pub corner_w: [f32; 3],
    /// True if the barycentrics' slopes are small enough for f32 along a run of columns.
    pub is_gentle: bool,
    /// True if their slopes are so small that f32 has all the digits that bytes need.
    pub is_smooth: bool,
    /// True if the face is back-facing.
    pub is_back: bool,
    /// True if the face's normals are flipped.
    pub is_normal_flipped: bool,
}

/// Returns where LANES pixels from (x, y) on, of depths `z`, lie between near (included) and far
/// (excluded): as f64 says wherever f32 may be wrong.
#[inline(always)]
pub(super) fn between_near_and_far<S: Simd>(s: S, exact_face: &ExactFace, z: S::F, x: i32, y: i32) -> S::M {
    let (zero, one) = (s.splat(0.0), s.splat(1.0));
    let inside = zero.le(z) & z.lt(one);
    let near_either = z.abs().lt(s.splat(DEPTH_ROUNDING)) | (z - one).abs().lt(s.splat(DEPTH_ROUNDING));
    let mut left = near_either.bits();
    if left == 0 {
        return inside;
    }
    let mut bits = inside.bits();
    while left != 0 {
        let lane = left.trailing_zeros();
        left &= left - 1;
        let is_inside =
            exact_face.plane.is_between_near_and_far(exact_face.exact_ranges[0], x + lane as i32, y);
        bits = (bits & !(1 << lane)) | (u32::from(is_inside) << lane);
    }
    s.mask(bits)
}

/// Returns the depths at LANES pixels from (x, y) on.
#[inline(always)]
pub(super) fn depths<S: Simd>(s: S, exact_face: &ExactFace, x: i32, y: i32) -> S::F {
    let (plane, [low, high]) = (&exact_face.plane, exact_face.z_range);
    let z = linear(s, plane, plane.z, plane.z[1].abs() <= STEEP, [x, y], 1);
    z.max(s.splat(low)).min(s.splat(high))
}

/// Returns the barycentrics b of an exact face at LANES pixels from (x, y) on, one in `step` columns:
/// b / sum(b) are the corners' weights, 1 / sum(b) is w.
#[inline(always)]
pub fn weights<S: Simd>(s: S, exact_face: &ExactFace, at: [i32; 2], step: i32) -> [S::F; 3] {
    let (plane, has_runs) = (&exact_face.plane, exact_face.is_gentle);
    [
        linear(s, plane, plane.barycentrics[0], has_runs, at, step),
        linear(s, plane, plane.barycentrics[1], has_runs, at, step),
        linear(s, plane, plane.barycentrics[2], has_runs, at, step),
    ]
}

/// Returns [`weights`] of a gentle face, x a multiple of LANES.
#[inline(always)]
pub(super) fn gentle_weights<S: Simd>(s: S, exact_face: &ExactFace, at: [i32; 2]) -> [S::F; 3] {
    let plane = &exact_face.plane;
    let [f0, f1, f2] = plane.barycentrics;
    [along_run(s, plane, f0, at), along_run(s, plane, f1, at), along_run(s, plane, f2, at)]
}

/// Returns [`weights`] at one pixel.
pub(super) fn weights_at(exact_face: &ExactFace, at: [i32; 2]) -> [f32; 3] {
    let plane = &exact_face.plane;
    plane.barycentrics.map(|function| linear_at(plane, function, exact_face.is_gentle, at))
}

/// Returns the lanes that lie well inside the unsnapped face, by their barycentrics.
#[inline(always)]
pub(super) fn inside<S: Simd>(s: S, exact_face: &ExactFace, [a, b, c]: [S::F; 3]) -> S::M {
    let [p, q, r] = exact_face.corner_w.map(f32::abs);
    let least = (a * s.splat(p)).min(b * s.splat(q)).min(c * s.splat(r));
    s.splat(BESIDE_SHARE).lt(least)
}

/// Evaluates a linear function at LANES pixels from (x, y) on, one in `step` columns, in f64, or in f32
/// along runs that begin in f64. The values depend neither on the vector width nor on its alignment.
#[inline(always)]
fn linear<S: Simd>(
    s: S,
    plane: &PlaneEquation,
    function: [f64; 3],
    has_runs: bool,
    [x, y]: [i32; 2],
    step: i32,
) -> S::F {
    let each = EachPixel { plane, function, has_runs, at: [x, y], step };
    if step != 1 {
        return each.run(s);
    }
    if has_runs && x & (S::LANES as i32 - 1) == 0 {
        return along_run(s, plane, function, [x, y]);
    }
    // Called: in line, its conversions would be made ahead of the loops over pixels that need none.
    s.call(s, each)
}

/// Evaluates a linear function at LANES pixels of a run, from (x, y) on.
#[inline(always)]
fn along_run<S: Simd>(s: S, plane: &PlaneEquation, function: [f64; 3], [x, y]: [i32; 2]) -> S::F {
    let base = x & !(RUN - 1);
    let along = (s.iota() + s.splat_i(x - base)).to_f32();
    s.splat(plane.at(function, base, y) as f32) + s.splat(function[1] as f32) * along
}

/// A linear function, evaluated pixel by pixel.
struct EachPixel<'a> {
    plane: &'a PlaneEquation,
    function: [f64; 3],
    has_runs: bool,
    at: [i32; 2],
    step: i32,
}

impl<S: Simd> Part<S> for EachPixel<'_> {
    type Output = S::F;

    #[inline(always)]
    fn run(self, s: S) -> S::F {
        let [x, y] = self.at;
        let mut lanes = [0f32; 16];
        for (i, lane) in lanes[..S::LANES].iter_mut().enumerate() {
            let at = [x + i as i32 * self.step, y];
            *lane = linear_at(self.plane, self.function, self.has_runs, at);
        }
        s.load(&lanes[..S::LANES])
    }
}

/// Returns [`linear`] at one pixel.
#[inline(always)]
fn linear_at(plane: &PlaneEquation, function: [f64; 3], has_runs: bool, [x, y]: [i32; 2]) -> f32 {
    let base = x & !(RUN - 1);
    match has_runs {
        true => plane.at(function, base, y) as f32 + function[1] as f32 * (x - base) as f32,
        false => plane.at(function, x, y) as f32,
    }
}

/// Share of a corner below which a pixel may lie beside the face.
const BESIDE_SHARE: f32 = 1e-4;

/// Returns the lanes that may lie beside the unsnapped face, of the pixels from (x, y) on.
#[inline(always)]
pub(super) fn beside<S: Simd>(s: S, exact_face: &ExactFace, x: i32, y: i32) -> S::M {
    let at = weights(s, exact_face, [x, y], 1);
    !inside(s, exact_face, at)
}

/// Returns whether the centres of a box of pixels all lie inside the unsnapped face.
pub(super) fn holds(exact_face: &ExactFace, clip: PixelRect) -> bool {
    let least = f64::from(BESIDE_SHARE);
    let inside = |x: i32, y: i32| {
        (0..3).all(|k| {
            exact_face.plane.barycentric_at(k, x, y) * f64::from(exact_face.corner_w[k].abs()) > least
        })
    };
    let (right, bottom) = (clip.x1 - 1, clip.y1 - 1);
    inside(clip.x0, clip.y0) && inside(right, clip.y0) && inside(clip.x0, bottom) && inside(right, bottom)
}

/// Returns the barycentrics of LANES pixels from (x, y) on in f64.
#[inline(always)]
pub(super) fn barycentrics<S: Simd>(exact_face: &ExactFace, x: i32, y: i32) -> [[f64; 16]; 3] {
    let mut b = [[0.0f64; 16]; 3];
    for (k, lanes) in b.iter_mut().enumerate() {
        for (i, lane) in lanes[..S::LANES].iter_mut().enumerate() {
            *lane = exact_face.plane.barycentric_at(k, x + i as i32, y);
        }
    }
    b
}

/// Returns the corners' weights at LANES pixels from (x, y) on, computed in f64, and the lanes
/// beside the face, which the plain path must compute.
#[inline(always)]
pub(super) fn exact_weights<S: Simd>(s: S, exact_face: &ExactFace, x: i32, y: i32) -> ([S::F; 3], S::M) {
    let b = barycentrics::<S>(exact_face, x, y);
    let mut out = [[0f32; 16]; 3];
    let mut inside = 0u32;
    for i in 0..S::LANES {
        let sum = b[0][i] + b[1][i] + b[2][i];
        let is_inside = b[0][i] >= 0.0 && b[1][i] >= 0.0 && b[2][i] >= 0.0 && sum > 0.0;
        inside |= (is_inside as u32) << i;
        for k in 0..3 {
            out[k][i] = (b[k][i] / sum) as f32;
        }
    }
    (out.map(|lanes| s.load(&lanes[..S::LANES])), !s.mask(inside))
}

/// Clamps barycentrics as the plain path does, where a centre lies beside the face: the weights on
/// the screen to 0..1, rescaled to a sum of 1. Inside the face they are unchanged.
#[inline(always)]
pub fn clamped<S: Simd>(s: S, exact_face: &ExactFace, b: [S::F; 3]) -> [S::F; 3] {
    let (zero, one) = (s.splat(0.0), s.splat(1.0));
    let is_beside = b[0].lt(zero) | b[1].lt(zero) | b[2].lt(zero);
    if !is_beside.any() {
        return b;
    }
    let w =
        [s.splat(exact_face.corner_w[0]), s.splat(exact_face.corner_w[1]), s.splat(exact_face.corner_w[2])];
    let share = [
        (b[0] * w[0]).max(zero).min(one),
        (b[1] * w[1]).max(zero).min(one),
        (b[2] * w[2]).max(zero).min(one),
    ];
    let sum = (share[0] + share[1]) + share[2];
    [
        s.select(is_beside, share[0] / (sum * w[0]), b[0]),
        s.select(is_beside, share[1] / (sum * w[1]), b[1]),
        s.select(is_beside, share[2] / (sum * w[2]), b[2]),
    ]
}

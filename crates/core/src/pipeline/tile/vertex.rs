//! Vertex stage: transforms, divides and snaps vertices in f64, and stores a 16-byte
//! [`ScreenVertex`] each.
//!
//! Positions equal those of the plain path to the bit: model, view and projection one after the
//! other, then the division. One combined matrix and one division give equal results unless the
//! position is within rounding error of a multiple of 1/65536 pixel; there the separate steps
//! decide (19 of 36,322 blocks of eight vertices in a mesh of a million faces).
//!
//! A screen vertex is {x, y, z, 1/w}: x and y in 1/65536 pixel rounded down (i32 bits in an f32), z
//! in f32, 1/w in f32. The position snapped to 1/256 pixel, ties to even, is x >> 8 or one more;
//! the last bits of 1/w say which (bit 0 for x, bit 1 for y), at a cost of 4e-7 of a weight. So
//! coverage reads exact snapped corners and everything else the unsnapped ones, from one cache line
//! per vertex. A vertex that this cannot represent (behind the eye, beyond 16,000 pixels, far
//! outside the depth range) has 1/w = 0: faces with such a corner take the plain path.

use crate::pipeline::indexed_mesh::BLOCK_VERTICES;
use crate::simd::{Kernel, Level, Simd};
use glam::{DMat4, DVec4};
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};

/// Projected vertex: {x, y, z, 1/w}, encoded as the module's documentation says.
pub type ScreenVertex = [f32; 4];

/// Largest distance from pixel (0,0), in pixels, that a screen vertex can represent.
const REACH: f64 = 16_000.0;

/// Bits of the planes beyond which a vertex lies; stored as the first number of a screen vertex
/// without position.
pub struct Outcode;

impl Outcode {
    /// w <= 0.
    pub const BEHIND: i32 = 1;
    /// z < 0.
    pub const NEAR: i32 = 2;
    /// z > w.
    pub const FAR: i32 = 4;
    /// More than a pixel beyond the clip rectangle: left, right, above, below.
    pub const SIDES: [i32; 4] = [8, 16, 32, 64];
    /// Mask of all planes: a face whose corners share one bit of it is invisible.
    pub const OUTSIDE: i32 = 127;
}

/// Transform from object space to the screen, in the steps of the plain path, so that both round
/// alike.
#[derive(Clone, Copy, Debug)]
pub struct ToScreen {
    /// Rows of the model matrix; the last row is 0 0 0 1.
    pub model: [[f64; 4]; 3],
    /// Rows of the view matrix; the last row is 0 0 0 1.
    pub view: [[f64; 4]; 3],
    /// Rows of the projection matrix.
    pub projection: [[f64; 4]; 4],
    /// Centre of the viewport in pixels, x then y: screen = center + ndc * half.
    pub center: [f64; 2],
    /// Half extents of the viewport in pixels; y's is negative, since rows grow downwards.
    pub half: [f64; 2],
    /// First column and row that may be drawn, and the ends of both ranges, by axis.
    pub sides: [[f64; 2]; 2],
}

impl ToScreen {
    /// Returns the matrix from object space to view space.
    pub fn to_view(self) -> DMat4 {
        affine_matrix(self.view) * affine_matrix(self.model)
    }

    /// Transforms from object space to view space in the plain path's steps: the model matrix, then
    /// the view matrix.
    #[inline(always)]
    pub(super) fn steps_to_view(&self, at: [&Lanes; 3]) -> [Lanes; 3] {
        let [m0, m1, m2] = self.model;
        let world = [affine(m0, at), affine(m1, at), affine(m2, at)];
        let world = [&world[0], &world[1], &world[2]];
        let [v0, v1, v2] = self.view;
        [affine(v0, world), affine(v1, world), affine(v2, world)]
    }

    /// Returns bounds on the sums of absolute terms on the way to view space, for positions whose
    /// coordinates are at most `farthest` in size.
    pub fn sizes_in_view(self, [x, y, z]: [f64; 3]) -> DVec4 {
        let sizes = |row: [f64; 4]| row.map(f64::abs);
        affine_matrix(self.view.map(sizes))
            * (affine_matrix(self.model.map(sizes)) * DVec4::new(x, y, z, 1.0))
    }
}

/// Returns the matrix of three rows, and 0 0 0 1.
fn affine_matrix([a, b, c]: [[f64; 4]; 3]) -> DMat4 {
    DMat4::from_cols_array_2d(&[a, b, c, [0.0, 0.0, 0.0, 1.0]]).transpose()
}

/// Combined matrix of all steps, and bounds on the difference between its results and theirs.
#[derive(Clone, Copy, Debug)]
pub struct Projector {
    /// The separate steps.
    pub steps: ToScreen,
    /// Rows of x, y, z and w over object space.
    rows: [[f64; 4]; 4],
    /// Bound, in 1/65536 pixel, x then y, on the error of a position by the rounding of x, y and w,
    /// times w.
    doubt: [f64; 2],
    /// Bound on the error by the rounding of the position itself.
    floor_doubt: [f64; 2],
}

/// Relative rounding error of both ways together, by the sum of absolute terms: fewer than 40 units
/// of 2^-53.
pub(super) const ROUNDINGS: f64 = 1e-14;

impl Projector {
    /// Combines `steps`, for positions whose coordinates are at most `farthest` in size.
    pub fn new(steps: ToScreen, to_view: &DMat4, farthest: [f64; 3]) -> Self {
        let back = to_view.transpose();
        let rows = steps.projection.map(|row| (back * DVec4::from_array(row)).to_array());
        let far = steps.sizes_in_view(farthest);
        let reach = steps.projection.map(|row| DVec4::from_array(row).abs().dot(far));
        let span = [0, 1].map(|axis| REACH + steps.center[axis].abs());
        let doubt = [0, 1].map(|axis| {
            let clip = steps.half[axis].abs() * reach[axis] + span[axis] * reach[3];
            65536.0 * ROUNDINGS * clip
        });
        let floor_doubt = span.map(|s| 65536.0 * ROUNDINGS * s);
        Projector { steps, rows, doubt, floor_doubt }
    }
}

/// Transforms a run of vertices.
pub struct VertexKernel<'a> {
    /// Object-space x, y and z of the vertices.
    pub positions: [&'a [f64]; 3],
    /// Matrices and error bounds.
    pub projector: &'a Projector,
    /// One byte for each block of [`WIDTH`] vertices: 1, or 0 if no visible face uses it; empty if
    /// all are used.
    pub marks: &'a [AtomicU8],
    /// Output: one for each vertex.
    pub screen_vertices: &'a mut [ScreenVertex],
}

/// Vertices in a block: one AVX-512 register of f64, two of AVX2.
pub const WIDTH: usize = BLOCK_VERTICES;

/// Coordinates of a block of vertices.
pub(super) type Lanes = [f64; WIDTH];

/// Returns whether a block of vertices is used.
#[inline(always)]
pub(super) fn is_marked(marks: &[AtomicU8], block: usize) -> bool {
    marks.get(block).is_none_or(|m| m.load(Relaxed) != 0)
}

impl Kernel for VertexKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let [xs, ys, zs] = self.positions.map(|p| p.as_chunks::<WIDTH>());
        let (chunks, tail) = self.screen_vertices.as_chunks_mut::<WIDTH>();
        for ((((i, out), x), y), z) in chunks.iter_mut().enumerate().zip(xs.0).zip(ys.0).zip(zs.0) {
            if is_marked(self.marks, i) {
                transform(self.projector, [x, y, z], out);
            }
        }
        if tail.is_empty() {
            return;
        }
        let mut last = [[0.0; WIDTH]; 3];
        for (lanes, from) in last.iter_mut().zip([xs.1, ys.1, zs.1]) {
            lanes[..from.len()].copy_from_slice(from);
        }
        let mut screen_vertices = [[0.0; 4]; WIDTH];
        transform(self.projector, [&last[0], &last[1], &last[2]], &mut screen_vertices);
        tail.copy_from_slice(&screen_vertices[..tail.len()]);
    }
}

/// Returns a row times (x, y, z, 1), rounded as glam does.
#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
#[inline(always)]
pub(super) fn affine([a, b, c, d]: [f64; 4], [x, y, z]: [&Lanes; 3]) -> Lanes {
    let mut out = [0.0; WIDTH];
    for i in 0..WIDTH {
        out[i] = ((a * x[i] + b * y[i]) + c * z[i]) + d;
    }
    out
}

/// 1.5 * 2^52: adding it rounds to an integer, ties to even, without a call or a branch, and leaves
/// the integer in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Encodes a screen coordinate: its floor in 1/65536 pixel, and 1 if it snaps upwards.
#[inline(always)]
fn held(pixels: f64) -> (u32, u32) {
    let t = pixels * 65536.0;
    let r = t + ROUND;
    let floor = (r.to_bits() as u32).wrapping_sub((r - ROUND > t) as u32);
    // The snapped value is the floor's 1/256 pixel or the next: the last bit of the difference
    // tells.
    (floor, ((pixels * 256.0 + ROUND).to_bits() as u32 ^ (floor >> 8)) & 1)
}

/// Returns the distance to the nearest multiple of 1/65536 pixel, in that unit: floors and snaps
/// change only there.
#[inline(always)]
fn from_whole(pixels: f64) -> f64 {
    let t = pixels * 65536.0;
    (t - ((t + ROUND) - ROUND)).abs()
}

/// Projects by the combined matrix; falls back to the steps where the error bound leaves their
/// result open.
#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
#[inline(always)]
fn transform(p: &Projector, at: [&Lanes; 3], out: &mut [ScreenVertex; WIDTH]) {
    let clip = [affine(p.rows[0], at), affine(p.rows[1], at), affine(p.rows[2], at), affine(p.rows[3], at)];
    let mut words = [[0u32; WIDTH]; 4];
    let (mut all_fit, mut in_doubt) = (true, false);
    for i in 0..WIDTH {
        let w = clip[3][i];
        let inv = 1.0 / w;
        let sx = p.steps.center[0] + clip[0][i] * inv * p.steps.half[0];
        let sy = p.steps.center[1] + clip[1][i] * inv * p.steps.half[1];
        // z goes to f32: the product's rounding is far below its own.
        let sz = clip[2][i] * inv;
        let fits = (w > 1e-30) & (w < 1e30) & (sx.abs() < REACH) & (sy.abs() < REACH) & (sz.abs() < 2.0);
        all_fit &= fits;
        in_doubt |= (from_whole(sx) <= p.doubt[0] * inv + p.floor_doubt[0])
            | (from_whole(sy) <= p.doubt[1] * inv + p.floor_doubt[1]);
        let kept = if fits { u32::MAX } else { 0 };
        let ((fx, up_x), (fy, up_y)) = (held(sx), held(sy));
        words[0][i] = fx & kept;
        words[1][i] = fy & kept;
        words[2][i] = (sz as f32).to_bits();
        words[3][i] = (((inv as f32).to_bits() & !3) | up_x | up_y << 1) & kept;
    }
    for i in 0..WIDTH {
        out[i] = [
            f32::from_bits(words[0][i]),
            f32::from_bits(words[1][i]),
            f32::from_bits(words[2][i]),
            f32::from_bits(words[3][i]),
        ];
    }
    if in_doubt | !all_fit {
        by_steps(&p.steps, at, out);
    }
}

/// Recomputes positions by the plain path's steps, with its rounding. Depth and w are left
/// unchanged, so that equal ones stay equal.
#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
#[inline(always)]
fn by_steps(t: &ToScreen, at: [&Lanes; 3], out: &mut [ScreenVertex; WIDTH]) {
    let view = t.steps_to_view(at);
    let view = [&view[0], &view[1], &view[2]];
    let [p0, p1, p2, p3] = t.projection;
    let clip = [affine(p0, view), affine(p1, view), affine(p2, view), affine(p3, view)];
    for i in 0..WIDTH {
        let [x, y, z, w] = [clip[0][i], clip[1][i], clip[2][i], clip[3][i]];
        let [sx, sy] = [t.center[0] + x / w * t.half[0], t.center[1] + y / w * t.half[1]];
        // Next to the eye the steps may put it on the other side.
        let fits = (w > 1e-30) & (w < 1e30) & (sx.abs() < REACH) & (sy.abs() < REACH);
        if out[i][3].to_bits() == 0 || !fits {
            out[i] = [f32::from_bits(outcode(t, [x, y, z, w]) as u32), 0.0, 0.0, 0.0];
            continue;
        }
        let ((fx, up_x), (fy, up_y)) = (held(sx), held(sy));
        let inv = (out[i][3].to_bits() & !3) | up_x | up_y << 1;
        out[i] = [f32::from_bits(fx), f32::from_bits(fy), out[i][2], f32::from_bits(inv)];
    }
}

/// Returns the planes beyond which a clip space point lies.
#[allow(clippy::needless_range_loop, reason = "an axis of several arrays")]
#[inline(never)]
fn outcode(t: &ToScreen, [x, y, z, w]: [f64; 4]) -> i32 {
    let mut code = 0;
    if w <= 0.0 {
        code |= Outcode::BEHIND;
    } else {
        let screen = [t.center[0] + x / w * t.half[0], t.center[1] + y / w * t.half[1]];
        for axis in 0..2 {
            if screen[axis] < t.sides[axis][0] - 1.0 {
                code |= Outcode::SIDES[axis * 2];
            }
            if screen[axis] > t.sides[axis][1] + 1.0 {
                code |= Outcode::SIDES[axis * 2 + 1];
            }
        }
    }
    if z < 0.0 {
        code |= Outcode::NEAR;
    }
    if z > w {
        code |= Outcode::FAR;
    }
    code
}

/// Returns the screen vertices of three points of object space.
pub(crate) fn screen_vertices_of(
    level: Level,
    to_screen: &ToScreen,
    points: [[f64; 3]; 3],
) -> [ScreenVertex; 3] {
    let axis = |axis: usize| points.map(|p| p[axis]);
    let (xs, ys, zs) = (axis(0), axis(1), axis(2));
    let mut screen_vertices = [[0.0; 4]; 3];
    let farthest = [0, 1, 2].map(|axis| points.iter().fold(0.0f64, |far, p| far.max(p[axis].abs())));
    let projector = &Projector::new(*to_screen, &to_screen.to_view(), farthest);
    level.dispatch(VertexKernel {
        positions: [&xs, &ys, &zs],
        projector,
        marks: &[],
        screen_vertices: &mut screen_vertices,
    });
    screen_vertices
}

#[cfg(test)]
mod tests;

//! Vertices to the screen: transformed, divided and snapped in f64, kept as one 16-byte record each.
//!
//! A record is {x, y, z, 1/w}: x and y in 1/65536 pixel rounded down (as i32 bits in f32's place), z in f32, 1/w in f32.
//! The position snapped to 1/256 pixel, ties to even, is x >> 8 or one more; which of the two is kept in the last bits of
//! 1/w (bit 0 for x, bit 1 for y), where it costs 4e-7 of a weight. So coverage has its exact corners and everything else
//! the unsnapped ones, out of one cache line a vertex. A vertex that this cannot hold (behind the eye, beyond 16,000
//! pixels, far outside the depth range) has 1/w = 0: faces with such a corner take the plain path.

use crate::simd::{Kernel, Simd};

/// A vertex on the screen; see the module's text.
pub type Record = [f32; 4];

/// The farthest from pixel (0,0) that a record can hold, in pixels.
const REACH: f64 = 16_000.0;

/// What stands in a record's first place where it has no position: beyond which planes the vertex is.
pub struct Outcode;

impl Outcode {
    /// w <= 0.
    pub const BEHIND: i32 = 1;
    /// z < 0.
    pub const NEAR: i32 = 2;
    /// z > w.
    pub const FAR: i32 = 4;
    /// More than a pixel left of the view, right of it, above, below.
    pub const SIDES: [i32; 4] = [8, 16, 32, 64];
    /// A face all of whose corners share one of these shows nothing.
    pub const OUTSIDE: i32 = 127;
}

/// Object space to the screen, in the steps of the plain path, so that both round alike.
#[derive(Clone, Copy, Debug)]
pub struct ToScreen {
    /// Rows of the model matrix; the last is 0 0 0 1.
    pub model: [[f64; 4]; 3],
    /// Rows of the view matrix; the last is 0 0 0 1.
    pub view: [[f64; 4]; 3],
    /// Rows of the projection.
    pub projection: [[f64; 4]; 4],
    /// Screen = center + ndc * half, x then y.
    pub center: [f64; 2],
    /// Half extents in pixels; y's is negative, since rows grow downwards.
    pub half: [f64; 2],
    /// The first column and row that may be drawn, and those beyond the last.
    pub sides: [[f64; 2]; 2],
}

impl ToScreen {
    /// Whether the projection is a perspective's: x and y from themselves and z, z and w from z alone.
    #[inline(always)]
    fn is_symmetric(&self) -> bool {
        let [p0, p1, p2, p3] = self.projection;
        [p0[1], p0[3], p1[0], p1[3], p2[0], p2[1], p3[0], p3[1]] == [0.0; 8]
    }
}

/// Transforms a run of vertices.
pub struct VertexKernel<'a> {
    /// Object-space x, y, z.
    pub positions: [&'a [f64]; 3],
    /// The matrices.
    pub to_screen: &'a ToScreen,
    /// One record a vertex.
    pub records: &'a mut [Record],
}

/// Vertices worked on at once: one AVX-512 register of f64, two of AVX2.
pub(super) const WIDTH: usize = 8;

pub(super) type Lanes = [f64; WIDTH];

impl Kernel for VertexKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let [xs, ys, zs] = self.positions.map(|p| p.as_chunks::<WIDTH>());
        let (chunks, tail) = self.records.as_chunks_mut::<WIDTH>();
        for (((out, x), y), z) in chunks.iter_mut().zip(xs.0).zip(ys.0).zip(zs.0) {
            transform(self.to_screen, x, y, z, out);
        }
        if tail.is_empty() {
            return;
        }
        let mut last = [[0.0; WIDTH]; 3];
        for (lanes, from) in last.iter_mut().zip([xs.1, ys.1, zs.1]) {
            lanes[..from.len()].copy_from_slice(from);
        }
        let mut records = [[0.0; 4]; WIDTH];
        transform(self.to_screen, &last[0], &last[1], &last[2], &mut records);
        tail.copy_from_slice(&records[..tail.len()]);
    }
}

/// A row times (x, y, z, 1), with glam's roundings.
#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
#[inline(always)]
pub(super) fn affine([a, b, c, d]: [f64; 4], [x, y, z]: [&Lanes; 3]) -> Lanes {
    let mut out = [0.0; WIDTH];
    for i in 0..WIDTH {
        out[i] = ((a * x[i] + b * y[i]) + c * z[i]) + d;
    }
    out
}

/// a x + b z.
#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
#[inline(always)]
fn pair(a: f64, x: &Lanes, b: f64, z: &Lanes) -> Lanes {
    let mut out = [0.0; WIDTH];
    for i in 0..WIDTH {
        out[i] = a * x[i] + b * z[i];
    }
    out
}

/// A row's z and constant.
#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
#[inline(always)]
fn depth_row([_, _, c, d]: [f64; 4], z: &Lanes) -> Lanes {
    let mut out = [0.0; WIDTH];
    for i in 0..WIDTH {
        out[i] = c * z[i] + d;
    }
    out
}

#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
#[inline(always)]
fn transform(t: &ToScreen, x: &Lanes, y: &Lanes, z: &Lanes, out: &mut [Record; WIDTH]) {
    let [m0, m1, m2] = t.model;
    let world = [affine(m0, [x, y, z]), affine(m1, [x, y, z]), affine(m2, [x, y, z])];
    let world = [&world[0], &world[1], &world[2]];
    let [v0, v1, v2] = t.view;
    let view = [affine(v0, world), affine(v1, world), affine(v2, world)];
    let view = [&view[0], &view[1], &view[2]];
    let [p0, p1, p2, p3] = t.projection;
    let clip = match t.is_symmetric() {
        // What the zeros would add changes no sum.
        true => [
            pair(p0[0], view[0], p0[2], view[2]),
            pair(p1[1], view[1], p1[2], view[2]),
            depth_row(p2, view[2]),
            depth_row(p3, view[2]),
        ],
        false => [affine(p0, view), affine(p1, view), affine(p2, view), affine(p3, view)],
    };
    // Adding 1.5 * 2^52 rounds to a whole number, ties to even, without a call or a branch, and leaves it in the low bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let mut words = [[0u32; WIDTH]; 4];
    let mut all_fit = true;
    for i in 0..WIDTH {
        let w = clip[3][i];
        let inv = 1.0 / w;
        // Divided, not multiplied by 1/w: the plain path's roundings, so that both snap alike.
        let sx = t.center[0] + clip[0][i] / w * t.half[0];
        let sy = t.center[1] + clip[1][i] / w * t.half[1];
        // z goes to f32: the product's rounding is far below its own.
        let sz = clip[2][i] * inv;
        let fits = (w > 1e-30) & (w < 1e30) & (sx.abs() < REACH) & (sy.abs() < REACH) & (sz.abs() < 2.0);
        all_fit &= fits;
        let kept = if fits { u32::MAX } else { 0 };
        let (tx, ty) = (sx * 65536.0, sy * 65536.0);
        let (rx, ry) = (tx + ROUND, ty + ROUND);
        let fx = (rx.to_bits() as u32).wrapping_sub((rx - ROUND > tx) as u32);
        let fy = (ry.to_bits() as u32).wrapping_sub((ry - ROUND > ty) as u32);
        // What is snapped is the floor's 1/256 pixel or the next: the last bit of the difference tells.
        let up_x = ((sx * 256.0 + ROUND).to_bits() as u32 ^ (fx >> 8)) & 1;
        let up_y = ((sy * 256.0 + ROUND).to_bits() as u32 ^ (fy >> 8)) & 1;
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
    if !all_fit {
        for i in (0..WIDTH).filter(|&i| words[3][i] == 0) {
            let code = outcode(t, std::array::from_fn(|k| clip[k][i]));
            out[i] = [f32::from_bits(code as u32), 0.0, 0.0, 0.0];
        }
    }
}

/// Beyond which planes a clip space point is.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Level;

    const UNIT: [[f64; 4]; 3] = [[1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 1., 0.]];

    #[test]
    fn records_hold_the_floor_and_the_snap_of_every_position() {
        let to_screen = ToScreen {
            model: UNIT,
            view: UNIT,
            projection: [[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 0.5, 0.], [0., 0., 0., 2.0]],
            center: [100.0, 50.0],
            half: [100.0, -50.0],
            sides: [[0.0, 200.0], [0.0, 100.0]],
        };
        let n = 1003;
        // Quarters of 1/256 pixel, so that ties and both neighbours come up, and values off the frame.
        let xs: Vec<f64> = (0..n).map(|i| (i as f64 - 300.0) / 51200.0).collect();
        let ys: Vec<f64> = (0..n).map(|i| (i as f64 * 7.0 - 300.0) / 25600.0 / 4.0).collect();
        let zs: Vec<f64> = (0..n).map(|i| i as f64 / n as f64).collect();
        let mut first: Option<Vec<Record>> = None;
        for level in Level::ALL {
            let mut records = vec![[0f32; 4]; n];
            level.dispatch(VertexKernel {
                positions: [&xs, &ys, &zs],
                to_screen: &to_screen,
                records: &mut records,
            });
            for i in 0..n {
                let sx = 100.0 + xs[i] * 0.5 * 100.0;
                let sy = 50.0 + ys[i] * 0.5 * -50.0;
                let bits = records[i].map(|v| v.to_bits());
                for (axis, s) in [sx, sy].into_iter().enumerate() {
                    assert_eq!(bits[axis] as i32, (s * 65536.0).floor() as i32);
                    let snapped = ((bits[axis] as i32) >> 8) + (bits[3] >> axis & 1) as i32;
                    assert_eq!(snapped as f64, (s * 256.0).round_ties_even(), "vertex {i} at {s}");
                }
                assert!((f32::from_bits(bits[3]) - 0.5).abs() < 3e-7);
            }
            let same = first.get_or_insert_with(|| records.clone());
            assert!(
                same.iter().zip(&records).all(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits)),
                "{level:?}"
            );
        }
    }

    #[test]
    fn what_a_record_cannot_hold_says_where_it_is() {
        let projection = [[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 1.0, 0.], [0., 0., 1.0, 0.]];
        let to_screen = ToScreen {
            model: UNIT,
            view: UNIT,
            projection,
            center: [0.0; 2],
            half: [10.0, -10.0],
            sides: [[0.0, 10.0], [0.0, 10.0]],
        };
        let xs = [1.0, 1.0, 1e9, f64::NAN, 1.0];
        let zs = [0.0, -1.0, 1.0, 1.0, 1e-300];
        let mut records = vec![[1f32; 4]; 5];
        Level::best().dispatch(VertexKernel {
            positions: [&xs, &[0.0; 5], &zs],
            to_screen: &to_screen,
            records: &mut records,
        });
        assert!(records.iter().all(|r| r[3] == 0.0), "{records:?}");
        let codes: Vec<i32> = records.iter().map(|r| r[0].to_bits() as i32).collect();
        let right = Outcode::SIDES[1];
        assert_eq!(codes, [Outcode::BEHIND, Outcode::BEHIND | Outcode::NEAR, right, 0, right]);
    }
}

//! Faces: culled, bounded and given their edge functions and depth plane, a vector of faces at a time.
//!
//! In: records of vertices, three indices a face. Out: for each face that may light a pixel one [`Setup`], in file order,
//! and for each band of rows the list of those that reach it. A face with up to [`SMALL_SIDE`] pixels a side has all its
//! edge functions exact in i32; larger ones are walked by exact spans; what a record cannot hold is left to the plain path.

use super::vertex::Record;
use crate::simd::{F32, I32, Kernel, Mask, Simd};

/// The largest side of a box whose edge functions are exact in i32: 2 * (64 * 256)^2 < 2^31.
pub const SMALL_SIDE: i32 = 62;

/// How much depth may run over a face, times its slenderness (longest side squared over doubled area), to be right in f32.
const STEEPEST: f32 = 1.0 / 512.0;

/// The steepest depth, per pixel, that may rest on positions known to 1/65536 pixel: an error below 5e-8.
const STEEPEST_SLOPE: f32 = 1.0 / 256.0;

/// How a face is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Edge functions in i32, depth plane in f32.
    Small,
    /// By exact spans, depth in f64: large faces, and those whose depth f32 does not carry.
    Large,
    /// By the plain path's own set-up and arithmetic.
    Plain,
}

/// A face ready to be drawn: where, and by which numbers.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The triangle's number in the mesh.
    pub face: u32,
    /// How it is drawn.
    pub kind: Kind,
    /// Columns and rows that may hold covered pixels, half-open, inside the view: x0, y0, x1, y1.
    pub bounds: [i16; 4],
    /// Edge functions at the centre of pixel (x0, y0), biased so that >= 0 is inside.
    pub edges: [i32; 3],
    /// Their steps from column to column.
    pub steps_x: [i32; 3],
    /// Their steps from row to row.
    pub steps_y: [i32; 3],
    /// Depth at the centre of pixel (x0, y0), and its steps.
    pub depth: [f32; 3],
}

/// Which faces are left out, by the sign of their area on the screen (rows grow downwards).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Those that are counter-clockwise as seen.
    CounterClockwise,
    /// Those that are clockwise as seen.
    Clockwise,
    /// Both.
    Both,
}

/// The pixels that may be drawn, half-open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// Left column.
    pub x0: i32,
    /// Top row.
    pub y0: i32,
    /// One beyond the right column.
    pub x1: i32,
    /// One beyond the bottom row.
    pub y1: i32,
}

/// What a chunk of faces became.
#[derive(Debug, Default)]
pub struct Chunk {
    /// The faces that may light a pixel, in file order.
    pub setups: Vec<Setup>,
    /// For each band, indices into `setups`, in order.
    pub bins: Vec<Vec<u32>>,
    /// Faces left out by their winding, without area or without a pixel centre, and handed on.
    pub culled: u64,
    /// Faces without area or without a pixel centre in their box.
    pub empty: u64,
}

impl Chunk {
    /// Makes room for `bands` bands and forgets the last frame; keeps its memory.
    pub fn reset(&mut self, bands: usize) {
        self.setups.clear();
        self.bins.iter_mut().for_each(Vec::clear);
        if self.bins.len() < bands {
            self.bins.resize_with(bands, Vec::new);
        }
        (self.culled, self.empty) = (0, 0);
    }

    fn push(&mut self, setup: Setup, view: &View, band_rows: i32) {
        let index = self.setups.len() as u32;
        let (first, last) = (setup.bounds[1] as i32 - view.y0, setup.bounds[3] as i32 - 1 - view.y0);
        for band in first / band_rows..=last / band_rows {
            self.bins[band as usize].push(index);
        }
        self.setups.push(setup);
    }
}

/// Sets up the faces `first_face..` of a chunk.
pub struct SetupKernel<'a> {
    /// The vertices.
    pub records: &'a [Record],
    /// Three vertices a face: this chunk's faces.
    pub indices: &'a [i32],
    /// Which of this chunk's faces only the plain path can draw.
    pub plain_only: &'a [bool],
    /// The number of the chunk's first face in the mesh.
    pub first_face: u32,
    /// Which windings are kept.
    pub keep: Keep,
    /// What may be drawn.
    pub view: View,
    /// Rows of a band.
    pub band_rows: i32,
    /// Where it goes.
    pub chunk: &'a mut Chunk,
}

/// What the vector stage hands to the scalar one, a row of lanes each.
const FIELDS: usize = 17;

impl Kernel for SetupKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let faces = self.indices.len() / 3;
        let mut lanes = [[0i32; 16]; FIELDS];
        let mut order = [0i32; 16];
        for start in (0..faces).step_by(S::LANES) {
            let count = (faces - start).min(S::LANES);
            let live = s.mask(u32::MAX >> (32 - count));
            let at = (s.iota() + s.splat_i(start as i32)) * s.splat_i(3);
            let r0 = s.gather4(live, self.records, s.gather_i(live, self.indices, at));
            let r1 = s.gather4(live, self.records, s.gather_i(live, self.indices, at + s.splat_i(1)));
            let r2 = s.gather4(live, self.records, s.gather_i(live, self.indices, at + s.splat_i(2)));
            let zero = s.splat(0.0);
            // A record without 1/w is one that the plain path must look at.
            let none = s.splat_i(0);
            let is_plain = live & (r0[3].bits().eq(none) | r1[3].bits().eq(none) | r2[3].bits().eq(none));
            let ((x0, y0), (x1, y1), (x2, y2)) = (snapped(s, r0), snapped(s, r1), snapped(s, r2));
            let (min_x, max_x) = (x0.min(x1).min(x2), x0.max(x1).max(x2));
            let (min_y, max_y) = (y0.min(y1).min(y2), y0.max(y1).max(y2));
            // Centres lie at 128 mod 256: the first at or after the low side, the last at or before the high one.
            let left = (min_x + s.splat_i(127)).sar::<8>().max(s.splat_i(self.view.x0));
            let top = (min_y + s.splat_i(127)).sar::<8>().max(s.splat_i(self.view.y0));
            let right = (max_x + s.splat_i(128)).sar::<8>().min(s.splat_i(self.view.x1));
            let bottom = (max_y + s.splat_i(128)).sar::<8>().min(s.splat_i(self.view.y1));
            let has_centres = right.gt(left) & bottom.gt(top);
            // The area's sign: exact in i32 for boxes of SMALL_SIDE; larger boxes ask in i64, one by one, below.
            let side = s.splat_i((SMALL_SIDE + 1) * 256);
            let is_small = side.gt(max_x - min_x) & side.gt(max_y - min_y);
            let (ux, uy, vx, vy) = (x1 - x0, y1 - y0, x2 - x0, y2 - y0);
            let area = ux * vy - vx * uy;
            let is_clockwise = area.gt(s.splat_i(0));
            let is_counter = s.splat_i(0).gt(area);
            let kept = match self.keep {
                Keep::CounterClockwise => is_counter,
                Keep::Clockwise => is_clockwise,
                Keep::Both => is_counter | is_clockwise,
            };
            let candidate = live & !is_plain & has_centres;
            let small = candidate & is_small & kept;
            let large = candidate & !is_small;
            let dropped = (live & !is_plain & !small & !large).bits().count_ones() as u64;
            let wrong_way =
                (candidate & is_small & !kept & (is_clockwise | is_counter)).bits().count_ones() as u64;
            self.chunk.culled += wrong_way;
            self.chunk.empty += dropped - wrong_way;
            let plain_bits = is_plain.bits();
            let work = small | large | is_plain;
            if !work.any() {
                continue;
            }
            // Edge k runs from corner k+1 to k+2; all turned so that the inside is >= 0.
            let sign = s.select_i(is_counter, s.splat_i(-1), s.splat_i(1));
            let px = left.shl::<8>() + s.splat_i(128);
            let py = top.shl::<8>() + s.splat_i(128);
            for (k, (xa, ya, xb, yb)) in
                [(x1, y1, x2, y2), (x2, y2, x0, y0), (x0, y0, x1, y1)].into_iter().enumerate()
            {
                let (dx, dy) = ((xb - xa) * sign, (yb - ya) * sign);
                // e(p) = dx * (py - ya) - dy * (px - xa), 1/65536 pixel^2; right and bottom edges do not own their centres.
                let e = dx * (py - ya) - dy * (px - xa);
                let is_left = none.gt(dy);
                let is_top = dy.eq(none) & dx.gt(none);
                let bias = s.select_i(is_left | is_top, none, s.splat_i(-1));
                s.store_i((e + bias).sar::<8>(), &mut lanes[k]);
                s.store_i(none - dy, &mut lanes[3 + k]);
                s.store_i(dx, &mut lanes[6 + k]);
            }
            // The depth plane of the unsnapped face, from its corners in an order of their own, so that faces with the
            // same corners in any order get the same plane.
            let [a, b, c] = sort_corners(s, [corner::<S>(r0), corner::<S>(r1), corner::<S>(r2)]);
            let (bx, by, cx, cy) =
                (pixels(s, a[0], b[0]), pixels(s, a[1], b[1]), pixels(s, a[0], c[0]), pixels(s, a[1], c[1]));
            let (za, zb, zc) = (a[2].as_f32(), b[2].as_f32(), c[2].as_f32());
            let (bz, cz) = (zb - za, zc - za);
            let det = bx * cy - cx * by;
            let (zx, zy) = ((bz * cy - cz * by) / det, (cz * bx - bz * cx) / det);
            let half_unit = s.splat(0.5 / 65536.0);
            let from_a =
                (pixels(s, a[0], px.shl::<8>()) - half_unit, pixels(s, a[1], py.shl::<8>()) - half_unit);
            let z = za + (zx * from_a.0 + zy * from_a.1);
            // f32 is enough where a rounding error of the plane's slope, times the box, stays below 1e-7.
            let reach2 =
                (bx * bx + by * by).max(cx * cx + cy * cy).max((cx - bx) * (cx - bx) + (cy - by) * (cy - by));
            let rise = bz.abs().max(cz.abs()).max((cz - bz).abs());
            let is_gentle = (rise * reach2).le(det.abs() * s.splat(STEEPEST))
                & zero.lt(det.abs())
                & (zx.abs() + zy.abs()).le(s.splat(STEEPEST_SLOPE));
            s.store_i(z.bits(), &mut lanes[9]);
            s.store_i(zx.bits(), &mut lanes[10]);
            s.store_i(zy.bits(), &mut lanes[11]);
            s.store_i(left, &mut lanes[12]);
            s.store_i(top, &mut lanes[13]);
            s.store_i(right, &mut lanes[14]);
            s.store_i(bottom, &mut lanes[15]);
            let small_bits = (small & is_gentle).bits();
            let n = s.compress_i(work, s.iota(), &mut order);
            for &lane in &order[..n] {
                let lane = lane as usize;
                let is_handed_on = plain_bits >> lane & 1 != 0 || self.plain_only[start + lane];
                let kind = match (is_handed_on, small_bits >> lane & 1 != 0) {
                    (true, _) => Kind::Plain,
                    (false, true) => Kind::Small,
                    (false, false) => Kind::Large,
                };
                let field = |k: usize| lanes[k][lane];
                let bounds = match plain_bits >> lane & 1 != 0 {
                    // Where it lies is not known here: every band looks.
                    true => [self.view.x0, self.view.y0, self.view.x1, self.view.y1].map(|v| v as i16),
                    false => [field(12), field(13), field(14), field(15)].map(|v| v as i16),
                };
                let setup = Setup {
                    face: self.first_face + (start + lane) as u32,
                    kind,
                    bounds,
                    edges: [field(0), field(1), field(2)],
                    steps_x: [field(3), field(4), field(5)],
                    steps_y: [field(6), field(7), field(8)],
                    depth: [field(9), field(10), field(11)].map(|v| f32::from_bits(v as u32)),
                };
                self.chunk.push(setup, &self.view, self.band_rows);
            }
        }
    }
}

// Helpers are functions marked for inlining, not closures: a closure would be compiled without the level's instructions.

/// A record's position snapped to 1/256 pixel.
#[inline(always)]
fn snapped<S: Simd>(s: S, r: [S::F; 4]) -> (S::I, S::I) {
    let (up, one) = (r[3].bits(), s.splat_i(1));
    (r[0].bits().sar::<8>() + (up & one), r[1].bits().sar::<8>() + (up.shr::<1>() & one))
}

/// A corner: position in 1/65536 pixel, and the bits of its depth.
type Corner<S> = [<S as Simd>::I; 3];

/// The corner of a record.
#[inline(always)]
fn corner<S: Simd>(r: [S::F; 4]) -> Corner<S> {
    [r[0].bits(), r[1].bits(), r[2].bits()]
}

/// From p to q, in pixels.
#[inline(always)]
fn pixels<S: Simd>(s: S, p: S::I, q: S::I) -> S::F {
    (q - p).to_f32() * s.splat(1.0 / 65536.0)
}

/// The corners in ascending order of (x, y), lane by lane.
#[inline(always)]
fn sort_corners<S: Simd>(s: S, [a, b, c]: [Corner<S>; 3]) -> [Corner<S>; 3] {
    let (a, b) = in_order(s, a, b);
    let (b, c) = in_order(s, b, c);
    let (a, b) = in_order(s, a, b);
    [a, b, c]
}

#[inline(always)]
fn in_order<S: Simd>(s: S, p: Corner<S>, q: Corner<S>) -> (Corner<S>, Corner<S>) {
    let swap = p[0].gt(q[0]) | (p[0].eq(q[0]) & p[1].gt(q[1]));
    let low = [s.select_i(swap, q[0], p[0]), s.select_i(swap, q[1], p[1]), s.select_i(swap, q[2], p[2])];
    let high = [s.select_i(swap, p[0], q[0]), s.select_i(swap, p[1], q[1]), s.select_i(swap, p[2], q[2])];
    (low, high)
}

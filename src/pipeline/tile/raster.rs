//! Visibility: for a band of rows, which face is seen at each pixel and how deep, in the faces' own order.
//!
//! In: the faces set up by every chunk, in order. Out: depth words (the bits of f32, which order as the numbers do) and the
//! number of the face that wrote each. A fragment passes when its depth is strictly less; nothing else decides, so the
//! result does not depend on threads, bands or lanes.

use super::setup::{Kind, Setup, View};
use super::vertex::{Record, ToScreen};
use crate::math::coverage::{PixelRect, SnappedTriangle};
use crate::simd::{F32, I32, Kernel, Mask, Simd};

/// In the memory of ids: no face of this draw.
pub const NO_FACE: i32 = -1;

/// A band of rows of the frame, the memories of one thread's work.
pub struct Band<'a> {
    /// The band's first row in the frame.
    pub y0: i32,
    /// Pixels in a row of the frame.
    pub width: usize,
    /// Depth words of the band's rows.
    pub depth: &'a mut [i32],
    /// Faces of the band's rows.
    pub ids: &'a mut [i32],
}

/// A face that only the plain path can draw: calls back with x, y and z of each covered pixel inside the rectangle.
pub type PlainFace<'a> = &'a (dyn Fn(u32, PixelRect, &mut dyn FnMut(i32, i32, f64)) + Sync);

/// Draws one chunk's share of a band.
pub struct RasterKernel<'a, 'b> {
    /// The chunk's faces.
    pub setups: &'a [Setup],
    /// Which of them reach this band, in order.
    pub bin: &'a [u32],
    /// The vertices, for faces drawn by spans.
    pub records: &'a [Record],
    /// Three vertices a face of the whole mesh.
    pub indices: &'a [i32],
    /// Object-space x, y, z of the vertices, for depth planes in f64.
    pub positions: [&'a [f64]; 3],
    /// Object space to the screen.
    pub to_screen: &'a ToScreen,
    /// Which windings are kept, for faces drawn by spans.
    pub keep: super::setup::Keep,
    /// What may be drawn.
    pub view: View,
    /// Rows in this band.
    pub rows: i32,
    /// The memories.
    pub band: &'a mut Band<'b>,
    /// The plain path's coverage and depth.
    pub plain: PlainFace<'a>,
}

impl Kernel for RasterKernel<'_, '_> {
    /// Fragments that passed.
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> u64 {
        let mut written = 0;
        let band_end = self.band.y0 + self.rows;
        for &index in self.bin {
            let setup = &self.setups[index as usize];
            let top = (setup.bounds[1] as i32).max(self.band.y0);
            let bottom = (setup.bounds[3] as i32).min(band_end);
            match setup.kind {
                Kind::Small => written += small(s, setup, top..bottom, &self.view, self.band),
                Kind::Large => {
                    let rows = PixelRect { x0: self.view.x0, y0: top, x1: self.view.x1, y1: bottom };
                    written += self.large(s, setup, rows);
                }
                Kind::Plain => {
                    let rows = PixelRect { x0: self.view.x0, y0: top, x1: self.view.x1, y1: bottom };
                    (self.plain)(setup.face, rows, &mut |x, y, z| {
                        let at = (y - self.band.y0) as usize * self.band.width + x as usize;
                        let word = ((z + 0.0) as f32).to_bits() as i32;
                        if word < self.band.depth[at] {
                            self.band.depth[at] = word;
                            self.band.ids[at] = setup.face as i32;
                            written += 1;
                        }
                    });
                }
            }
        }
        written
    }
}

/// A face whose edge functions fit i32: a vector of columns at a time, row by row.
#[inline(always)]
fn small<S: Simd>(s: S, setup: &Setup, rows: std::ops::Range<i32>, view: &View, band: &mut Band<'_>) -> u64 {
    let [x0, y0, x1, _] = setup.bounds.map(i32::from);
    let width = band.width as i32;
    let lanes = S::LANES as i32;
    let id = s.splat_i(setup.face as i32);
    let iota = s.iota();
    let is_clipped = x0 == view.x0 || x1 == view.x1;
    let [dx0, dx1, dx2] = setup.steps_x;
    let zx = s.splat(setup.depth[1]);
    let mut written = 0;
    let mut x = x0;
    while x < x1 {
        // A vector that would leave the row begins further left; what it sees there twice fails the depth test the
        // second time or is masked.
        let start = x.min(width - lanes);
        let column = iota + s.splat_i(start - x0);
        let (o0, o1, o2) = (s.splat_i(dx0) * column, s.splat_i(dx1) * column, s.splat_i(dx2) * column);
        let z_columns = zx * column.to_f32();
        let mut inside_columns = s.mask(u32::MAX);
        if is_clipped || start < x {
            let from = x.max(view.x0) - start;
            let to = (x1 - start).min(lanes);
            inside_columns = s.mask((u32::MAX << from) & (((1u64 << to) - 1) as u32));
        }
        for y in rows.clone() {
            let down = y - y0;
            let [e0, e1, e2] = [0, 1, 2].map(|k| setup.edges[k] + setup.steps_y[k] * down);
            let outside = (s.splat_i(e0) + o0) | (s.splat_i(e1) + o1) | (s.splat_i(e2) + o2);
            let covered = outside.gt(s.splat_i(-1)) & inside_columns;
            if !covered.any() {
                continue;
            }
            let at = (y - band.y0) as usize * band.width + start as usize;
            let row_depth = setup.depth[0] + setup.depth[2] * down as f32;
            let z = (s.splat(row_depth) + z_columns).bits();
            let depth = &mut band.depth[at..at + S::LANES];
            let passes = covered & s.load_i(depth).gt(z);
            if passes.any() {
                s.store_masked_i(passes, z, depth);
                s.store_masked_i(passes, id, &mut band.ids[at..at + S::LANES]);
                written += passes.bits().count_ones() as u64;
            }
        }
        x += lanes;
    }
    written
}

impl RasterKernel<'_, '_> {
    /// A face of any size, by its exact spans; its depth plane in f64.
    #[inline(always)]
    fn large<S: Simd>(&mut self, s: S, setup: &Setup, rows: PixelRect) -> u64 {
        let vertices = [0, 1, 2].map(|k| self.indices[setup.face as usize * 3 + k] as usize);
        let corners = vertices.map(|v| self.records[v]);
        let fixed = |r: &Record, axis: usize| r[axis].to_bits() as i32;
        let snapped = |r: &Record, axis: usize| (fixed(r, axis) >> 8) + (r[3].to_bits() >> axis & 1) as i32;
        let points = [0, 1, 2].map(|k| [0, 1].map(|axis| snapped(&corners[k], axis) as f64 / 256.0));
        let triangle = SnappedTriangle::new(points);
        let cross = |i: usize, j: usize| {
            let d = |k: usize, axis: usize| (snapped(&corners[k], axis) - snapped(&corners[0], axis)) as i64;
            d(i, 0) * d(j, 1) - d(j, 0) * d(i, 1)
        };
        let is_kept = match self.keep {
            super::setup::Keep::CounterClockwise => cross(1, 2) < 0,
            super::setup::Keep::Clockwise => cross(1, 2) > 0,
            super::setup::Keep::Both => true,
        };
        if !is_kept {
            return 0;
        }
        // The plane of the unsnapped corners, in f64 and in an order of their own: the same for every order that the face
        // may have them in.
        let mut sorted = vertices.map(|v| self.to_screen.point(self.positions.map(|axis| axis[v])));
        sorted.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
        let at = |k: usize, axis: usize| sorted[k][axis];
        let z = |k: usize| sorted[k][2];
        let (bx, by, cx, cy) =
            (at(1, 0) - at(0, 0), at(1, 1) - at(0, 1), at(2, 0) - at(0, 0), at(2, 1) - at(0, 1));
        let (bz, cz) = (z(1) - z(0), z(2) - z(0));
        let det = bx * cy - cx * by;
        let (zx, zy) = match det == 0.0 {
            true => (0.0, 0.0),
            false => ((bz * cy - cz * by) / det, (cz * bx - bz * cx) / det),
        };
        let origin = (at(0, 0), at(0, 1), z(0));
        let id = s.splat_i(setup.face as i32);
        let width = self.band.width as i32;
        let lanes = S::LANES as i32;
        let mut written = 0;
        let mut depths = [0f32; 16];
        // Spans first, vectors after: a closure would be compiled without the level's instructions.
        let mut spans = [const { (0, 0..0) }; SPANS];
        let mut count = 0;
        let mut next_row = rows.y0;
        while next_row < rows.y1 {
            let until = (next_row + SPANS as i32).min(rows.y1);
            triangle.for_each_span(PixelRect { y0: next_row, y1: until, ..rows }, |y, span| {
                spans[count] = (y, span);
                count += 1;
            });
            for (y, span) in &spans[..count] {
                let row_start = (y - self.band.y0) as usize * self.band.width;
                let row_depth = origin.2 + zy * (*y as f64 + 0.5 - origin.1);
                let mut x = span.start;
                while x < span.end {
                    let start = x.min(width - lanes);
                    for (i, d) in depths[..S::LANES].iter_mut().enumerate() {
                        *d = (row_depth + zx * ((start + i as i32) as f64 + 0.5 - origin.0)) as f32;
                    }
                    let z = s.load(&depths[..S::LANES]);
                    let from = x - start;
                    let to = (span.end - start).min(lanes);
                    let inside = s.mask((u32::MAX << from) & (((1u64 << to) - 1) as u32));
                    // Closed at 0: what rounding took just below it is 0.
                    let near = inside & s.splat(-NEAR_ROUNDING).lt(z);
                    let z = z.max(s.splat(0.0)).bits();
                    let at = row_start + start as usize;
                    let depth = &mut self.band.depth[at..at + S::LANES];
                    let passes = near & s.load_i(depth).gt(z);
                    if passes.any() {
                        s.store_masked_i(passes, z, depth);
                        s.store_masked_i(passes, id, &mut self.band.ids[at..at + S::LANES]);
                        written += passes.bits().count_ones() as u64;
                    }
                    x += lanes;
                }
            }
            count = 0;
            next_row = until;
        }
        written
    }
}

/// Spans of a large face that are worked on at once.
const SPANS: usize = 32;
/// What rounding may take off a depth of exactly 0.
const NEAR_ROUNDING: f32 = 6e-8;

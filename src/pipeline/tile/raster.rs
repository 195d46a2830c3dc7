//! Visibility: for a band of rows, which face is seen at each pixel and how deep, in the faces' own order.
//!
//! In: the faces set up by every chunk, in order. Out: depth words (the bits of f32, which order as the numbers do) and the
//! number of the face that wrote each. A fragment passes when its depth is strictly less; nothing else decides, so the
//! result does not depend on threads, bands or lanes. Without a depth memory every fragment passes.

use super::setup::{Chunk, INDEX, SMALL, Small, TINY, Tiny, View};
use super::wide;
use crate::simd::{F32, I32, Kernel, Mask, Simd};

/// In the memory of ids: no face of this draw.
pub const NO_FACE: i32 = -1;

/// A band of rows of the frame, the memories of one thread's work.
pub struct Band<'a> {
    /// The band's first row in the frame.
    pub y0: i32,
    /// Pixels in a row of the frame.
    pub width: usize,
    /// Depth words of the band's rows; empty where depth is neither tested nor kept.
    pub depth: &'a mut [i32],
    /// Faces of the band's rows.
    pub ids: &'a mut [i32],
}

/// Draws one chunk's share of a band.
pub struct RasterKernel<'a, 'b> {
    /// The chunk's faces.
    pub chunk: &'a Chunk,
    /// The band's number.
    pub bin: usize,
    /// What may be drawn.
    pub view: View,
    /// Rows in this band.
    pub rows: i32,
    /// The memories.
    pub band: &'a mut Band<'b>,
}

impl Kernel for RasterKernel<'_, '_> {
    /// Fragments tested (those of tiny faces were counted when they were set up) and passed.
    type Output = (u64, u64);

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> (u64, u64) {
        let (mut tested, mut passed) = (0, 0);
        for &entry in &self.chunk.bins[self.bin].entries {
            let index = (entry & INDEX) as usize;
            match entry & !INDEX {
                TINY => passed += tiny(s, &self.chunk.tiny[index], self.rows, self.band),
                SMALL => {
                    let (t, p) = small(s, &self.chunk.small[index], &self.view, self.rows, self.band);
                    (tested, passed) = (tested + t, passed + p);
                }
                _ => {
                    let face = &self.chunk.wide[index];
                    let (t, p) = wide::draw(s, face, &self.view, self.rows, self.band);
                    (tested, passed) = (tested + t, passed + p);
                }
            }
        }
        (tested, passed)
    }
}

/// The depth test at LANES pixels from `at` on, where `covered`; those that pass keep z and the face's number. How many passed.
#[inline(always)]
pub(super) fn write<S: Simd>(s: S, band: &mut Band<'_>, at: usize, covered: S::M, z: S::I, id: S::I) -> u64 {
    let mut passes = covered;
    if !band.depth.is_empty() {
        let depth = &mut band.depth[at..at + S::LANES];
        passes = covered & s.load_i(depth).gt(z);
        s.store_masked_i(passes, z, depth);
    }
    s.store_masked_i(passes, id, &mut band.ids[at..at + S::LANES]);
    passes.bits().count_ones() as u64
}

/// A face whose coverage is known: a row of up to eight pixels at a time.
#[inline(always)]
fn tiny<S: Simd>(s: S, face: &Tiny, band_rows: i32, band: &mut Band<'_>) -> u64 {
    let lanes = S::LANES as i32;
    let (x0, y0) = (face.at[0] as i32, face.at[1] as i32);
    let rows = (band.y0 - y0).max(0)..(face.size[1] as i32).min(band.y0 + band_rows - y0);
    let [z0, zx, zy] = face.depth;
    if face.mask & (face.mask - 1) == 0 {
        // One pixel, as most faces of a fine mesh have: the same sums without vectors.
        let bit = face.mask.trailing_zeros() as i32;
        let (row, column) = (bit >> 3, bit & 7);
        if !rows.contains(&row) {
            return 0;
        }
        let z = (z0 + zy * row as f32) + zx * column as f32;
        let z = (z.to_bits() as i32).max(0);
        let at = (y0 + row - band.y0) as usize * band.width + (x0 + column) as usize;
        if !band.depth.is_empty() {
            if band.depth[at] <= z {
                return 0;
            }
            band.depth[at] = z;
        }
        band.ids[at] = face.face as i32;
        return 1;
    }
    let id = s.splat_i(face.face as i32);
    let mut passed = 0;
    let mut column = 0;
    while column < face.size[0] as i32 {
        // A vector that would leave the row begins further left.
        let start = (x0 + column).min(band.width as i32 - lanes);
        let shift = x0 + column - start;
        let along = s.splat(zx) * (s.iota() + s.splat_i(start - x0)).to_f32();
        for row in rows.clone() {
            let bits = (face.mask >> (8 * row)) as u32 & 0xff;
            let covered = s.mask((bits >> column << shift) & (u32::MAX >> (32 - lanes)));
            let z = (s.splat(z0 + zy * row as f32) + along).bits().max(s.splat_i(0));
            let at = (y0 + row - band.y0) as usize * band.width + start as usize;
            passed += write(s, band, at, covered, z, id);
        }
        column += lanes;
    }
    passed
}

/// A face whose edge functions fit i32: a vector of columns at a time, row by row; fragments tested and passed.
#[inline(always)]
fn small<S: Simd>(s: S, face: &Small, view: &View, band_rows: i32, band: &mut Band<'_>) -> (u64, u64) {
    let [x0, y0, x1, y1] = face.bounds;
    let (x0, y0, x1, y1) = (x0 as i32, y0 as i32, x1 as i32, y1 as i32);
    let rows = y0.max(band.y0)..y1.min(band.y0 + band_rows);
    let width = band.width as i32;
    let lanes = S::LANES as i32;
    let id = s.splat_i(face.face as i32);
    let iota = s.iota();
    let is_clipped = x0 == view.x0 || x1 == view.x1;
    let [dx0, dx1, dx2] = face.steps_x;
    let [dy0, dy1, dy2] = face.steps_y;
    let [z0, zx, zy] = face.depth;
    let (mut tested, mut passed) = (0, 0);
    let mut x = x0;
    while x < x1 {
        let start = x.min(width - lanes);
        let column = iota + s.splat_i(start - x0);
        let down = rows.start - y0;
        let mut e0 = s.splat_i(dx0) * column + s.splat_i(face.edges[0] + dy0 * down);
        let mut e1 = s.splat_i(dx1) * column + s.splat_i(face.edges[1] + dy1 * down);
        let mut e2 = s.splat_i(dx2) * column + s.splat_i(face.edges[2] + dy2 * down);
        let along = s.splat(zx) * column.to_f32();
        let mut inside_columns = s.mask(u32::MAX);
        if is_clipped || start < x {
            let from = x.max(view.x0) - start;
            let to = (x1 - start).min(lanes);
            inside_columns = s.mask((u32::MAX << from) & (((1u64 << to) - 1) as u32));
        }
        for y in rows.clone() {
            let covered = (e0 | e1 | e2).gt(s.splat_i(-1)) & inside_columns;
            (e0, e1, e2) = (e0 + s.splat_i(dy0), e1 + s.splat_i(dy1), e2 + s.splat_i(dy2));
            if !covered.any() {
                continue;
            }
            tested += covered.bits().count_ones() as u64;
            let at = (y - band.y0) as usize * band.width + start as usize;
            let z = (s.splat(z0 + zy * (y - y0) as f32) + along).bits().max(s.splat_i(0));
            passed += write(s, band, at, covered, z, id);
        }
        x += lanes;
    }
    (tested, passed)
}

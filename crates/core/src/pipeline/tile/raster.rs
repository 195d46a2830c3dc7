//! Rasterization of fragments and of faces with screen vertices in a tile.
//!
//! In: the faces set up by every chunk, in order. Out: depth words and the index of the face that
//! wrote each. A fragment passes if its depth is strictly less; nothing else decides, so the result
//! does not depend on threads, tiles or lanes. Without a depth buffer every fragment passes. One
//! rasterizer serves every depth format: the [`DepthTest`] is a type parameter. Exact faces are
//! those of [`super::exact_raster`].

use super::bins::{Small, Tiny};
use super::depth_test::DepthTest;
use super::edges::Edges;
use super::tile_buffers::Tile;
use crate::simd::{Mask, Part, Simd};
use std::ops::Range;

/// Draws one fragment: position, word in f32, face. Returns whether it passed.
#[inline(always)]
pub(super) fn fragment<D: DepthTest>(test: &D, fragment: [i32; 3], tile: &mut Tile<'_>) -> bool {
    let [at, _, face] = fragment;
    test.write_one(tile, (at & 0xffff, at >> 16), test.fragment(fragment), face)
}

/// Returns the first column of the vector that draws column x and those on its right; one that
/// would leave the tile starts further left.
#[inline(always)]
fn vector_start<S: Simd, D: DepthTest>(x: i32, tile: &Tile<'_>) -> i32 {
    let lanes = S::LANES as i32;
    // Aligned to its width, a vector loads what one earlier vector stored, not parts of two; a face
    // may need one more of them.
    let start = if D::IS_COSTLY { x } else { x & -lanes };
    start.min(tile.x1 - lanes)
}

/// Returns the coverage of a tiny face from `across` columns right of its first one on, in rows of
/// eight bits, where `fresh` is set; at most seven columns left of it.
#[inline(always)]
fn columns_from(mask: u64, across: i32, fresh: u32) -> u64 {
    let (left, right) = ((-across).max(0), across.max(0));
    let row = (((0xff << left) & 0xff) >> right) & fresh & 0xff;
    ((mask << left) >> right) & (u64::from(row) * 0x0101_0101_0101_0101)
}

/// Draws a tiny face, a row of up to eight pixels at a time. Adds those that passed to `passed`, by
/// lane, but for those that are drawn one by one, whose number it returns.
#[inline(always)]
pub(super) fn tiny<S: Simd, D: DepthTest>(
    s: S,
    test: &D,
    face: &Tiny,
    tile: &mut Tile<'_>,
    passed: &mut S::I,
) -> u64 {
    let lanes = S::LANES as i32;
    let (x0, y0) = (face.at[0] as i32, face.at[1] as i32);
    let rows = (tile.y0 - y0).max(0)..(face.size[1] as i32).min(tile.y1 - y0);
    let plane = test.plane(face.face, [x0, y0], face.depth);
    if face.mask & (face.mask - 1) == 0 {
        // One pixel: equal sums without vectors.
        return u64::from(one_pixel(test, face, &plane, face.mask.trailing_zeros() as i32, tile));
    }
    let id = s.splat_i(face.face as i32);
    let mut x = x0.max(tile.x0);
    let right = (x0 + face.size[0] as i32).min(tile.x1);
    // Pixels of rows with close words, in the face's mask: drawn at the end, so that the loops call
    // nothing.
    let mut close = 0;
    while x < right {
        let start = vector_start::<S, D>(x, tile);
        let fresh = u32::MAX << (x - start) & (u32::MAX >> (32 - lanes));
        let narrow = if S::LANES <= 8 { columns_from(face.mask, start - x0, fresh) } else { 0 };
        for row in rows.clone() {
            let bits = if S::LANES <= 8 {
                (narrow >> (8 * row)) as u32 & 0xff
            } else {
                // The shift ranges from 7 columns right of the face's first to 15 columns left of it.
                (((face.mask >> (8 * row)) & 0xff) << 16 >> (16 + start - x0)) as u32 & fresh
            };
            if D::IS_COSTLY && bits == 0 {
                continue;
            }
            let word = test.words(s, &plane, start, y0 + row);
            let (at, covered) = ((start, y0 + row), s.mask(bits));
            if test.is_close_at(s, tile, at, covered, word) {
                let columns = (0xff << (x - x0)) & 0xff & ((1 << (start + lanes - x0).min(8)) - 1);
                close |= face.mask & (columns << (8 * row));
                continue;
            }
            let passes = test.write_apart(s, tile, at, covered, word, id);
            *passed = s.increment(passes, *passed);
        }
        x = start + lanes;
    }
    if close == 0 { 0 } else { one_by_one(test, face, close, tile) }
}

/// Draws pixel `bit` of a tiny face's mask, if it is in the tile; returns whether it passed.
#[inline(always)]
fn one_pixel<D: DepthTest>(test: &D, face: &Tiny, plane: &D::Plane, bit: i32, tile: &mut Tile<'_>) -> bool {
    let [x, y] = [i32::from(face.at[0]) + (bit & 7), i32::from(face.at[1]) + (bit >> 3)];
    let is_in_tile = (tile.x0..tile.x1).contains(&x) && (tile.y0..tile.y1).contains(&y);
    is_in_tile && test.write_one(tile, (x, y), test.word(plane, x, y), face.face as i32)
}

/// Draws pixels of a tiny face's mask one by one, some of which are close to what is stored. Returns the
/// number of those that passed.
#[cold]
#[inline(never)]
fn one_by_one<D: DepthTest>(test: &D, face: &Tiny, pixels: u64, tile: &mut Tile<'_>) -> u64 {
    let plane = test.plane(face.face, face.at.map(i32::from), face.depth);
    (0..64).filter(|bit| pixels >> bit & 1 != 0 && one_pixel(test, face, &plane, *bit, tile)).count() as u64
}

/// Draws a face whose edge functions fit i32: a vector of columns at a time, row by row. Returns
/// the fragments tested and passed.
#[inline(always)]
pub(super) fn small<S: Simd, D: DepthTest>(s: S, test: &D, face: &Small, tile: &mut Tile<'_>) -> (u64, u64) {
    let [x0, y0, x1, y1] = face.bounds.map(i32::from);
    let rows = y0.max(tile.y0)..y1.min(tile.y1);
    let right = x1.min(tile.x1);
    let id = s.splat_i(face.face as i32);
    let plane = test.plane(face.face, [x0, y0], face.depth);
    let (mut tested, mut passed, mut closely) = (s.splat_i(0), s.splat_i(0), 0);
    let mut x = x0.max(tile.x0);
    while x < right {
        let start = vector_start::<S, D>(x, tile);
        let mut edges = Edges::new(s, face, start, x..right, rows.start);
        // Rows with close words, drawn after the others, so that the loop calls nothing.
        let mut close = 0u64;
        for y in rows.clone() {
            let covered = edges.covered(s);
            if !covered.any() {
                continue;
            }
            tested = s.increment(covered, tested);
            let word = test.words(s, &plane, start, y);
            if test.is_close_at(s, tile, (start, y), covered, word) {
                close |= 1 << (y - rows.start);
                continue;
            }
            let passes = test.write_apart(s, tile, (start, y), covered, word, id);
            passed = s.increment(passes, passed);
        }
        if close != 0 {
            let columns = x..right;
            closely += s.call(s, CloseRows { test, face, start, columns, first: rows.start, close, tile });
        }
        x = start + S::LANES as i32;
    }
    (sum(s, tested), sum(s, passed) + closely)
}

/// Rows of a strip of a small face, some of whose words are close to those that are stored.
struct CloseRows<'k, 'b, D> {
    test: &'k D,
    face: &'k Small,
    /// First column of the vectors, and those that are drawn.
    start: i32,
    columns: Range<i32>,
    /// First row, and a bit for each row from there on that is drawn.
    first: i32,
    close: u64,
    tile: &'k mut Tile<'b>,
}

impl<S: Simd, D: DepthTest> Part<S> for CloseRows<'_, '_, D> {
    type Output = u64;

    #[inline(always)]
    fn run(self, s: S) -> u64 {
        let CloseRows { test, face, start, columns, first, close, tile } = self;
        let [x0, y0, ..] = face.bounds.map(i32::from);
        let plane = test.plane(face.face, [x0, y0], face.depth);
        let id = (s.splat_i(face.face as i32), face.face as i32);
        let (mut left, mut passed) = (close, 0);
        while left != 0 {
            let y = first + left.trailing_zeros() as i32;
            left &= left - 1;
            let covered = Edges::new(s, face, start, columns.clone(), y).covered(s);
            let word = test.words(s, &plane, start, y);
            passed += u64::from(test.write(s, tile, (start, y), covered, word, id).bits().count_ones());
        }
        passed
    }
}

/// Returns the sum of counts by lane.
#[inline(always)]
pub(super) fn sum<S: Simd>(s: S, counts: S::I) -> u64 {
    let mut lanes = [0; 16];
    s.store_i(counts, &mut lanes[..S::LANES]);
    let mut sum = 0;
    for lane in &lanes[..S::LANES] {
        sum += *lane as u64;
    }
    sum
}

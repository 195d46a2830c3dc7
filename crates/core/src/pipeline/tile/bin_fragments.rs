//! Binning of fragments into tiles: most vectors of faces lie in one tile, some in two or four.

use super::bins::Chunk;
use super::fragments::Fragments;
use super::grid::Grid;
use super::tile_buffers::NO_FACE;
use crate::simd::{I32, Mask, Simd};

/// Adds fragments to the tiles that they lie in. `tiles` holds the first column and row, then the
/// last ones; all fragments lie within `reach`.
#[inline(always)]
pub(super) fn bin_fragments<S: Simd>(
    s: S,
    chunk: &mut Chunk,
    grid: &Grid,
    vectors: &[Fragments<S>],
    tiles: [usize; 4],
    reach: [i16; 4],
) {
    let [first_column, first_row, last_column, last_row] = tiles;
    let mut all = [s.mask(0); 2];
    for (all, vector) in all.iter_mut().zip(vectors) {
        *all = vector.face.gt(s.splat_i(NO_FACE));
    }
    if (first_column == last_column) & (first_row == last_row) {
        chunk.add_fragments(s, vectors, all, first_row * grid.columns + first_column, reach);
        return;
    }
    for row in first_row..=last_row {
        let y0 = grid.y0 + row as i32 * Grid::TILE_ROWS;
        for column in first_column..=last_column {
            let columns = grid.pixels_of(column);
            let mut inside = all;
            for (inside, vector) in inside.iter_mut().zip(vectors) {
                let (x, y) = (vector.at & s.splat_i(0xffff), vector.at.sar::<16>());
                *inside = *inside
                    & y.gt(s.splat_i(y0 - 1))
                    & s.splat_i(y0 + Grid::TILE_ROWS).gt(y)
                    & x.gt(s.splat_i(columns.start - 1))
                    & s.splat_i(columns.end).gt(x);
            }
            if (inside[0] | inside[1]).any() {
                chunk.add_fragments(s, vectors, inside, row * grid.columns + column, reach);
            }
        }
    }
}

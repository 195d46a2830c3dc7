//! Hierarchical z: skips faces that lie behind everything in their part of a tile.
//!
//! A tile is divided into cells of 16x8 pixels, each with its farthest depth word. A fragment
//! passes if its word is strictly less than the stored one, so a face whose words cannot be less
//! than the farthest one of each cell that it reaches has no fragment that passes: the bytes are
//! equal with and without this test. Words only decrease while faces are drawn, so an outdated
//! farthest word is too far at worst, and no visible face is skipped. The words are computed when a
//! tile's faces are begun, and again after about as many fragments have passed as would cover the
//! tile twice; a face that fills the tile lowers all cells to its own farthest corner at once.
//! Fragments are drawn without the test, which would cost as much. Depth formats other than f32
//! are drawn without the test.

use super::bins::{BinEntry, Small, Tiny};
use super::depth_test::F32Depth;
use super::exact_faces::ExactFace;
use super::tile_buffers::{ID_STRIDE, Tile};
use super::traverse::{Occlusion, RasterKernel, RasterStats};
use crate::simd::{I32, Kernel, Simd};

/// Columns and rows of a cell in pixels.
const CELL: [i32; 2] = [16, 8];
/// Number of cells in a row of a tile.
const ROW: usize = ID_STRIDE / CELL[0] as usize;
/// Number of cells of the largest tile.
const CELLS: usize = ROW * (super::grid::Grid::TILE_ROWS / CELL[1]) as usize;

/// Bytes of one tile's cells, on the stack of each thread that draws.
pub(crate) const HIERARCHICAL_Z_BYTES: u64 = size_of::<Cells>() as u64;

/// Smallest number of tiny faces for which computing the cells pays.
const FEW_TINY: usize = 32;
/// Smallest number of larger faces for which computing the cells pays.
const FEW_LARGER: usize = 2;

/// Farthest depth words of a tile's cells.
struct Cells {
    far: [i32; CELLS],
    /// Farthest word of all cells.
    farthest: i32,
}

/// Rasterizes the faces of one chunk in a tile, except hidden ones.
pub(super) struct HierarchicalZKernel<'a, 'b>(pub RasterKernel<'a, 'b, F32Depth<'a>>);

impl HierarchicalZKernel<'_, '_> {
    /// Returns whether a bin has enough faces for the test to pay.
    pub fn pays(bin: &super::bins::Bin) -> bool {
        let larger = bin.larger.iter().filter(|l| l.entry != BinEntry::OrderBreak);
        bin.tiny.len() >= FEW_TINY || larger.take(FEW_LARGER).count() == FEW_LARGER
    }
}

impl Kernel for HierarchicalZKernel<'_, '_> {
    type Output = RasterStats;

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> RasterStats {
        let cells = Cells::of(s, self.0.tile);
        self.0.traverse(s, &mut HierarchicalZ { cells, surveyed: 0 })
    }
}

/// Test of faces against a tile's cells.
struct HierarchicalZ {
    cells: Cells,
    /// Number of fragments that had passed when the cells were computed.
    surveyed: u64,
}

impl Occlusion for HierarchicalZ {
    #[inline(always)]
    fn hides_tiny(&self, tile: &Tile<'_>, face: &Tiny) -> bool {
        let near = nearest(face.depth, face.size.map(i32::from), tile.tolerance);
        self.cells.hide(tile, face.bounds().map(i32::from), near)
    }
    #[inline(always)]
    fn hides_small(&self, tile: &Tile<'_>, face: &Small) -> bool {
        let [x0, y0, x1, y1] = face.bounds.map(i32::from);
        self.cells.hide(tile, [x0, y0, x1, y1], nearest(face.depth, [x1 - x0, y1 - y0], tile.tolerance))
    }
    #[inline(always)]
    fn hides_exact(&self, tile: &Tile<'_>, face: &ExactFace) -> bool {
        let b = face.bounds;
        // Depths stay between those of the corners; a clipped face has no nearest depth.
        self.cells.hide(tile, [b.x0, b.y0, b.x1, b.y1], word(face.z_range[0] - tile.tolerance))
    }
    #[inline(always)]
    fn will_fill(&mut self, face: &ExactFace) {
        self.cells.lower(face);
    }
    #[inline(always)]
    fn has_passed<S: Simd>(&mut self, s: S, tile: &Tile<'_>, passed: u64) {
        if passed - self.surveyed > 2 * tile.pixels() {
            self.cells = Cells::of(s, tile);
            self.surveyed = passed;
        }
    }
}

impl Cells {
    /// Computes the farthest words of a tile.
    #[inline(always)]
    fn of<S: Simd>(s: S, tile: &Tile<'_>) -> Cells {
        let mut far = [0; CELLS];
        let mut farthest = 0;
        let (columns, rows) = ((tile.x1 - tile.x0) as usize, (tile.y1 - tile.y0) as usize);
        let (across, down) = (CELL[0] as usize, CELL[1] as usize);
        let mut row = 0;
        while row < rows {
            let until = (row + down).min(rows);
            let mut column = 0;
            while column < columns {
                let width = across.min(columns - column);
                let mut most = s.splat_i(0);
                let mut rest = 0;
                for y in row..until {
                    let at = tile.depth_at(tile.x0 + column as i32, tile.y0 + y as i32);
                    let words = &tile.depth[at..at + width];
                    let (vectors, left) = words.split_at(width / S::LANES * S::LANES);
                    for vector in vectors.chunks_exact(S::LANES) {
                        most = most.max(s.load_i(vector));
                    }
                    for &word in left {
                        rest = word.max(rest);
                    }
                }
                let mut lanes = [0; 16];
                s.store_i(most, &mut lanes[..S::LANES]);
                for lane in lanes {
                    rest = lane.max(rest);
                }
                far[row / down * ROW + column / across] = rest;
                farthest = rest.max(farthest);
                column += across;
            }
            row = until;
        }
        Cells { far, farthest }
    }

    /// Returns whether a face is hidden that lies within these columns and rows (x0, y0, x1, y1)
    /// and has no word below `near`.
    #[inline(always)]
    fn hide(&self, tile: &Tile<'_>, [x0, y0, x1, y1]: [i32; 4], near: i32) -> bool {
        if near >= self.farthest {
            return true;
        }
        let (x0, x1) = (x0.max(tile.x0) - tile.x0, x1.min(tile.x1) - tile.x0);
        let (y0, y1) = (y0.max(tile.y0) - tile.y0, y1.min(tile.y1) - tile.y0);
        let mut row = y0 / CELL[1];
        while row * CELL[1] < y1 {
            let mut column = x0 / CELL[0];
            while column * CELL[0] < x1 {
                if near < self.far[row as usize * ROW + column as usize] {
                    return false;
                }
                column += 1;
            }
            row += 1;
        }
        true
    }

    /// Lowers the cells for a face that fills the tile: nothing is farther than its farthest
    /// corner.
    #[inline(always)]
    fn lower(&mut self, face: &ExactFace) {
        let most = word(face.z_range[1]);
        self.farthest = most.min(self.farthest);
        for far in &mut self.far {
            *far = most.min(*far);
        }
    }
}

/// Returns the word of a depth as faces are drawn with it: depths before the near plane are clamped
/// to it.
#[inline(always)]
fn word(z: f32) -> i32 {
    (z.to_bits() as i32).max(0)
}

/// Returns a lower bound on the words of a face in a box of this many columns and rows, less `margin`. Rounded
/// sums and products are monotonic, so the least value is at a corner, if it is computed as it is
/// for the pixels.
#[inline(always)]
fn nearest([z0, zx, zy]: [f32; 3], [columns, rows]: [i32; 2], margin: f32) -> i32 {
    let (right, bottom) = (zx * (columns - 1) as f32, zy * (rows - 1) as f32);
    let (along, down) = (if right < 0.0 { right } else { 0.0 }, if bottom < 0.0 { bottom } else { 0.0 });
    // NaN only if a slope is NaN; such words are among the largest, and the face is not to be
    // skipped.
    let z = (z0 + down) + along;
    if z.is_nan() { 0 } else { word(z - margin) }
}

//! Coarse depth: a face that lies behind everything in its part of a tile is left out before its pixels are looked at.
//!
//! A tile is cut into cells of 16x8 pixels, each with the farthest depth word in it. A fragment passes when its word is strictly
//! less than the one that is there, so a face no word of which can be less than the farthest one of each cell that it reaches has
//! none that passes: the same bytes with and without. Words only become less while faces are drawn, so a farthest word that was
//! found a while ago is too far at worst, and nothing is left out that would be seen. It is found anew from the tile's words where
//! a tile's faces are begun, and again when about as many fragments have passed as would cover the tile twice; a face that fills
//! the tile brings all cells down to its own farthest corner at once. Fragments are drawn as they are: asking would cost as much.
//! Depths that are not f32 words have none of this.

use super::bins::{BinEntry, Small, Tiny};
use super::exact_faces::ExactFace;
use super::raster::{ID_STRIDE, RasterKernel, Tile};
use super::traverse::{FaceRaster, RasterStats, traverse};
use crate::math::coverage::Filling;
use crate::simd::{I32, Kernel, Simd};

/// Columns and rows of a cell.
const CELL: [i32; 2] = [16, 8];
/// Cells in a row of a tile's.
const ROW: usize = ID_STRIDE / CELL[0] as usize;
/// Cells of the largest tile.
const CELLS: usize = ROW * (super::bins::Grid::TILE_ROWS / CELL[1]) as usize;

/// Bytes of one tile's cells, on the stack of each thread that draws.
pub(crate) const HIERARCHICAL_Z_BYTES: u64 = size_of::<Cells>() as u64;

/// Tiles with fewer faces than this are not worth their words' being read first: tiny ones,
const FEW_TINY: usize = 32;
/// and larger ones.
const FEW_LARGER: usize = 2;

/// The farthest word of each cell.
struct Cells {
    far: [i32; CELLS],
    /// The farthest of all.
    farthest: i32,
}

/// Draws one chunk's share of a tile, but for hidden faces.
pub struct HierarchicalZKernel<'a, 'b>(pub RasterKernel<'a, 'b>);

impl HierarchicalZKernel<'_, '_> {
    /// Whether a tile has faces enough.
    pub fn pays(bin: &super::bins::Bin) -> bool {
        let larger = bin.larger.iter().filter(|l| l.entry != BinEntry::OrderBreak);
        bin.tiny.len() >= FEW_TINY || larger.take(FEW_LARGER).count() == FEW_LARGER
    }
}

impl Kernel for HierarchicalZKernel<'_, '_> {
    type Output = RasterStats;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> RasterStats {
        let plain = self.0;
        let cells = Cells::of(s, plain.tile);
        traverse(s, plain.bin, plain.exact_faces, &mut HierarchicalZRaster { plain, cells, surveyed: 0 })
    }
}

/// The plain raster behind a tile's cells.
struct HierarchicalZRaster<'a, 'b> {
    plain: RasterKernel<'a, 'b>,
    cells: Cells,
    /// Fragments that had passed when the cells were found.
    surveyed: u64,
}

impl FaceRaster for HierarchicalZRaster<'_, '_> {
    #[inline(always)]
    fn fragment(&mut self, fragment: [i32; 3]) -> bool {
        self.plain.fragment(fragment)
    }
    #[inline(always)]
    fn tiny<S: Simd>(&mut self, s: S, face: &Tiny) -> u64 {
        self.plain.tiny(s, face)
    }
    #[inline(always)]
    fn small<S: Simd>(&mut self, s: S, face: &Small) -> (u64, u64) {
        self.plain.small(s, face)
    }
    #[inline(always)]
    fn exact_face<S: Simd>(&mut self, s: S, face: &ExactFace) -> (u64, u64) {
        self.plain.exact_face(s, face)
    }
    #[inline(always)]
    fn filling(&self, face: &ExactFace) -> Filling {
        self.plain.filling(face)
    }
    #[inline(always)]
    fn stack<S: Simd>(&mut self, s: S, faces: &[&ExactFace]) -> u64 {
        self.plain.stack(s, faces)
    }
    #[inline(always)]
    fn pixels(&self) -> u64 {
        self.plain.pixels()
    }
    #[inline(always)]
    fn hides_tiny(&self, face: &Tiny) -> bool {
        self.cells.hide(self.plain.tile, bounds_of_tiny(face), nearest_of_tiny(face))
    }
    #[inline(always)]
    fn hides_small(&self, face: &Small) -> bool {
        self.cells.hide(self.plain.tile, face.bounds.map(i32::from), nearest_of_small(face))
    }
    #[inline(always)]
    fn hides_exact(&self, face: &ExactFace) -> bool {
        let b = face.bounds;
        // Its depths stay between its corners'; a cut one has no nearest.
        self.cells.hide(self.plain.tile, [b.x0, b.y0, b.x1, b.y1], word(face.z_range[0]))
    }
    #[inline(always)]
    fn will_fill(&mut self, face: &ExactFace) {
        self.cells.lower(face);
    }
    #[inline(always)]
    fn has_passed<S: Simd>(&mut self, s: S, passed: u64) {
        if passed - self.surveyed > 2 * self.pixels() {
            self.cells = Cells::of(s, self.plain.tile);
            self.surveyed = passed;
        }
    }
}

impl Cells {
    /// The farthest words of a tile as they are.
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

    /// Whether nothing of a face is seen that has no word below `near` and lies within these columns and rows: x0, y0, x1, y1.
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

    /// A face that fills the tile is drawn: nothing is farther than its farthest corner any more.
    #[inline(always)]
    fn lower(&mut self, face: &ExactFace) {
        let most = word(face.z_range[1]);
        self.farthest = most.min(self.farthest);
        for far in &mut self.far {
            *far = most.min(*far);
        }
    }
}

/// The word of a depth, as faces are drawn with it: what is before the near plane is on it.
#[inline(always)]
fn word(z: f32) -> i32 {
    (z.to_bits() as i32).max(0)
}

#[inline(always)]
fn bounds_of_tiny(face: &Tiny) -> [i32; 4] {
    face.bounds().map(i32::from)
}

#[inline(always)]
fn nearest_of_tiny(face: &Tiny) -> i32 {
    nearest(face.depth, face.size.map(i32::from))
}

#[inline(always)]
fn nearest_of_small(face: &Small) -> i32 {
    let [x0, y0, x1, y1] = face.bounds.map(i32::from);
    nearest(face.depth, [x1 - x0, y1 - y0])
}

/// No pixel of a face in a box of so many columns and rows has a word below this: sums and products that are rounded run one way,
/// as they do without, so the least of all is at a corner, worked as it is worked there.
#[inline(always)]
fn nearest([z0, zx, zy]: [f32; 3], [columns, rows]: [i32; 2]) -> i32 {
    let (right, bottom) = (zx * (columns - 1) as f32, zy * (rows - 1) as f32);
    let (along, down) = (if right < 0.0 { right } else { 0.0 }, if bottom < 0.0 { bottom } else { 0.0 });
    // Not a number only where a slope is none; its word is among the largest, so it is asked for what it hides: nothing.
    let z = (z0 + down) + along;
    if z.is_nan() { 0 } else { word(z) }
}

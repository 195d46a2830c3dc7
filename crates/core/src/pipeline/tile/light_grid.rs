//! Light of a large face, computed at the corners of cells of 8x8, 4x4 or 2x2 pixels and interpolated
//! between them where that is proven to differ too little to be seen.
//!
//! In: a face that was set up in f64 and is lit per pixel, the tile, and the allowed error. Out: the
//! size of the cells, for each whether its pixels are interpolated, and the light at its corners. A
//! cell is interpolated if its corners lie inside the face and the bound of [`super::linear_light`]
//! for its block of 32x8 pixels is within the error. A face's cells have one size in a tile: that for
//! which corners and pixels take the least together, by a rough price. All this depends on the face,
//! the tile and the draw's clip rectangle alone: a pixel's colour depends neither on what hides its
//! neighbours nor on the vector width. One knows by pictures that stay within 1/255 of the reference,
//! and by the bound's own tests.
//!
//! Corners are the centres of the cells' first pixels, so a cell's last corners are those of the next
//! cells. Blocks are looked at for the whole tile when the first pixel of the face is shaded, before
//! any corner is lit; rows of corners are lit when the first of their cells is shaded.

use super::exact_faces::LEAST_SUM;
use super::grid::Grid;
use super::lighting::{FastLight, MaterialLighting, V3, scale, splat3};
use super::linear_light::{BLOCK, BlockCorners, errors_of_cells};
use crate::math::coverage::PixelRect;
use crate::simd::{F32, Kernel, Level, Mask, Simd};
use std::cell::Cell;

/// Columns and rows of the largest cells, and of the smallest.
const LARGEST_CELL: i32 = 8;
const LEAST_CELL: usize = 2;

/// Most rows of cells in a tile.
const CELL_ROWS: usize = Grid::TILE_ROWS as usize / LEAST_CELL;

/// Most blocks side by side in a tile, in a column, and in all.
const BLOCK_COLUMNS: usize = 2 * Grid::TILE_COLUMNS as usize / BLOCK[0];
const BLOCK_ROWS: usize = Grid::TILE_ROWS as usize / BLOCK[1];
const BLOCKS: usize = BLOCK_COLUMNS * BLOCK_ROWS;

/// Room for the pixels of a row, and for its corners: those of the widest tile, and the rest of a vector.
const PIXELS: usize = BLOCK_COLUMNS * BLOCK[0] + 16;
const COLUMNS: usize = BLOCK_COLUMNS * BLOCK[0] / LEAST_CELL + 16;

/// Limit of the numbers whose squares, and products of squares, the bound can represent.
const LARGEST: f32 = 1e9;

/// Error of interpolated light that cannot be seen: a quarter of a step of a byte.
pub const UNSEEN: f32 = 0.25 / 255.0;

/// Returns whether a grid pays for a face of these bounds in a tile: where the face fills a part of it,
/// looking at the blocks takes more than it saves.
pub(super) fn may_pay(bounds: PixelRect, tile: PixelRect) -> bool {
    bounds.x0 <= tile.x0 && bounds.x1 >= tile.x1 && bounds.y0 <= tile.y0 && bounds.y1 >= tile.y1
}

/// Returns the pixels up to whose neighbours the light of a tile's grids reaches: the whole tile,
/// whatever is seen of it, and its last cells.
pub(super) fn reach(tile: PixelRect) -> PixelRect {
    PixelRect { y1: tile.y0 + (tile.y1 - tile.y0 + LARGEST_CELL - 1) / LARGEST_CELL * LARGEST_CELL, ..tile }
}

/// Rows of corners that are kept.
const ROWS: usize = 4;

/// Light along a row of corners.
#[derive(Clone, Copy)]
struct CornerRow {
    /// Its number in the tile; `usize::MAX` before it is lit.
    number: usize,
    /// Light of its pixels, interpolated between the corners.
    light: [[f32; PIXELS]; 3],
    /// Bits of the corners that lie inside the face and are lit in f32.
    is_known: u128,
}

/// Light of one face over the cells of a tile.
pub(super) struct LightGrid {
    /// The face; below 0 for none.
    face: i32,
    /// True if the bounds of the blocks were looked at.
    is_decided: bool,
    /// Columns and rows of a cell, as a power of two: no vector of pixels waits for a division.
    shift: u32,
    /// The part of a cell's side that a pixel is: its reciprocal.
    pixel_part: f32,
    /// For each row of cells the bits of those that are interpolated; of a row whose corners were not
    /// lit yet, if these allow it.
    linear: [u128; CELL_ROWS],
    /// Bits of the rows of cells whose corners were looked at.
    finished: u32,
    /// Whole cells side by side.
    cell_columns: usize,
    /// Light at the corners of the row that is being lit.
    corners: [[f32; COLUMNS]; 3],
    /// Rows of corners: those that were lit last, each at the rest of its number. A tile is shaded from
    /// the top to the bottom, and a strip of pixels needs three.
    rows: [CornerRow; ROWS],
}

/// Grids of a tile: those of the faces that were shaded last. More of them side by side in a row of strips
/// would compute their grids again for each row.
const GRIDS: usize = 8;

thread_local! {
    /// Grids of the thread's last tile: tiles neither ask for memory nor clear it.
    static RECYCLED: Cell<Option<Box<[LightGrid; GRIDS]>>> = const { Cell::new(None) };
}

/// Grids of faces of a tile: 120 KB for each thread that has shaded large faces.
pub(super) struct LightGrids {
    grids: Option<Box<[LightGrid; GRIDS]>>,
    /// Number of grids that were opened, and for each grid what it was when it was opened last.
    opened: u64,
    opened_at: [u64; GRIDS],
}

impl LightGrids {
    /// Creates no grids.
    pub fn none() -> Self {
        LightGrids { grids: None, opened: 0, opened_at: [0; GRIDS] }
    }

    /// Returns the index of a face's grid. Nothing is computed in it if the face had none: then it was
    /// that of the face that was opened longest ago.
    pub fn open(&mut self, face: i32) -> usize {
        let grids = self.grids.get_or_insert_with(recycled_grids);
        let slot = match grids.iter().position(|grid| grid.face == face) {
            Some(slot) => slot,
            None => {
                let slot = (0..GRIDS).min_by_key(|slot| self.opened_at[*slot]).unwrap_or_default();
                grids[slot].set_face(face);
                slot
            }
        };
        self.opened += 1;
        self.opened_at[slot] = self.opened;
        slot
    }

    /// Returns a grid.
    #[inline(always)]
    pub fn get(&mut self, slot: usize) -> Option<&mut LightGrid> {
        self.grids.as_mut().map(|grids| &mut grids[slot])
    }
}

/// Returns the grids of the thread's last tile, or new ones, as grids of no face.
#[cold]
#[inline(never)]
fn recycled_grids() -> Box<[LightGrid; GRIDS]> {
    let mut grids = RECYCLED.take().unwrap_or_else(|| Box::new([const { LightGrid::new() }; GRIDS]));
    grids.iter_mut().for_each(|grid| grid.set_face(-1));
    grids
}

impl Drop for LightGrids {
    fn drop(&mut self) {
        if let Some(grids) = self.grids.take() {
            RECYCLED.set(Some(grids));
        }
    }
}

impl LightGrid {
    /// Creates a grid of no face.
    const fn new() -> Self {
        let row = CornerRow { number: usize::MAX, light: [[0.0; PIXELS]; 3], is_known: 0 };
        LightGrid {
            face: -1,
            is_decided: false,
            shift: LEAST_CELL.trailing_zeros(),
            pixel_part: 1.0 / LEAST_CELL as f32,
            linear: [0; CELL_ROWS],
            finished: 0,
            cell_columns: 0,
            corners: [[0.0; COLUMNS]; 3],
            rows: [row; ROWS],
        }
    }

    /// Makes it the grid of a face.
    fn set_face(&mut self, face: i32) {
        (self.face, self.is_decided, self.finished) = (face, false, 0);
        self.rows.iter_mut().for_each(|row| row.number = usize::MAX);
    }

    /// Returns whether the bounds of the blocks were looked at.
    #[inline(always)]
    pub fn is_decided(&self) -> bool {
        self.is_decided
    }

    /// Returns whether some cell is interpolated.
    #[inline(always)]
    pub fn has_linear_cells(&self) -> bool {
        self.linear.iter().any(|cells| *cells != 0)
    }

    /// Returns the columns and rows of a cell.
    #[inline(always)]
    pub fn cell(&self) -> usize {
        1 << self.shift
    }

    /// Returns the row of cells of a row of pixels.
    #[inline(always)]
    pub fn row_of(&self, line: usize) -> usize {
        line >> self.shift
    }

    /// Returns the cells side by side.
    pub fn cell_columns(&self) -> usize {
        self.cell_columns
    }

    /// Returns whether a row of cells can be interpolated: its corners are lit, and were looked at.
    #[inline(always)]
    pub fn has_cells(&self, row: usize) -> bool {
        self.finished >> row & 1 == 1 && self.has_corners(row) && self.has_corners(row + 1)
    }

    /// Returns whether a row of corners is lit.
    #[inline(always)]
    pub fn has_corners(&self, row: usize) -> bool {
        self.rows[row % ROWS].number == row
    }

    /// Returns bits of those pixels from `column` on that lie in interpolated cells of a row.
    #[inline(always)]
    pub fn linear_pixels<S: Simd>(&self, row: usize, column: usize) -> u32 {
        let cells = (self.linear[row] >> (column >> self.shift)) as u32;
        let pixels = match self.cell() {
            2 => pixels_of::<2, S>(cells),
            4 => pixels_of::<4, S>(cells),
            _ => pixels_of::<8, S>(cells),
        };
        (pixels >> (column & (self.cell() - 1))) as u32
    }

    /// Returns the light of LANES pixels from a column on of a row of the tile whose corners are lit.
    #[inline(always)]
    pub fn light<S: Simd>(&self, s: S, [column, line]: [usize; 2]) -> V3<S> {
        let row = self.row_of(line);
        let (upper, lower) = (&self.rows[row % ROWS].light, &self.rows[(row + 1) % ROWS].light);
        let part = s.splat((line & (self.cell() - 1)) as f32 * self.pixel_part);
        let mut light = [part; 3];
        let mut channel = 0;
        while channel < 3 {
            let from = s.load(&upper[channel][column..]);
            light[channel] = from + (s.load(&lower[channel][column..]) - from) * part;
            channel += 1;
        }
        light
    }

    /// Keeps the light at LANES corners of a row from column `first` on. `known` are those that lie
    /// inside the face and are lit in f32.
    #[inline(always)]
    pub fn keep<S: Simd>(&mut self, s: S, [row, first]: [usize; 2], light: V3<S>, known: S::M) {
        let mut channel = 0;
        while channel < 3 {
            s.store(light[channel], &mut self.corners[channel][first..first + S::LANES]);
            channel += 1;
        }
        let (lanes, to) = ((1u128 << S::LANES) - 1, &mut self.rows[row % ROWS]);
        to.is_known = (to.is_known & !(lanes << first)) | ((u128::from(known.bits()) & lanes) << first);
    }

    /// Interpolates the light along a row of corners, all of which are lit.
    #[inline(always)]
    pub fn finish_corners(&mut self, row: usize) {
        let (light, corners) = (&mut self.rows[row % ROWS].light, &self.corners);
        match 1 << self.shift {
            2 => along::<2>(light, corners, self.cell_columns),
            4 => along::<4>(light, corners, self.cell_columns),
            _ => along::<8>(light, corners, self.cell_columns),
        }
        self.rows[row % ROWS].number = row;
    }

    /// Leaves those cells of a row to be interpolated whose corners, all lit now, allow it.
    pub fn finish_cells(&mut self, row: usize) {
        let known = self.rows[row % ROWS].is_known & self.rows[(row + 1) % ROWS].is_known;
        self.linear[row] &= known & (known >> 1);
        self.finished |= 1 << row;
    }

    /// Decides which cells of a tile are interpolated with at most this error, in units of colour, if
    /// their corners allow it.
    pub fn decide(&mut self, inputs: &BlockInputs, lighting: &MaterialLighting, most: f32) {
        let within = Level::in_four_lanes(ErrorKernel { inputs, lighting, most });
        let price = |&(cell, within): &(usize, u32)| price(inputs, lighting, cell, within);
        let (cell, within) = within.into_iter().min_by_key(price).unwrap_or((LEAST_CELL, 0));
        (self.shift, self.pixel_part) = (cell.trailing_zeros(), 1.0 / cell as f32);
        (self.cell_columns, self.linear) = (inputs.width / cell, [0; CELL_ROWS]);
        // The frame's last columns may be less than a cell.
        let whole = (1 << self.cell_columns) - 1;
        let [columns, rows] = BLOCK.map(|pixels| pixels / cell);
        for block in (0..inputs.count()).filter(|block| within >> block & 1 == 1) {
            let (row, column) = (block / inputs.columns, block % inputs.columns);
            let cells = (((1 << columns) - 1) << (column * columns)) & whole;
            self.linear[row * rows..][..rows].iter_mut().for_each(|linear| *linear |= cells);
        }
        self.is_decided = true;
    }
}

/// Returns the bits of pixels of the first cells, as far as a vector that begins in the first of them.
#[inline(always)]
fn pixels_of<const CELL: usize, S: Simd>(cells: u32) -> u64 {
    let (mut bits, mut cell) = (0, 0);
    while cell <= S::LANES / CELL {
        bits |= (u64::from(cells >> cell & 1) * ((1 << CELL) - 1)) << (cell * CELL);
        cell += 1;
    }
    bits
}

/// Interpolates light between corners that are `CELL` pixels apart.
#[inline(always)]
fn along<const CELL: usize>(light: &mut [[f32; PIXELS]; 3], corners: &[[f32; COLUMNS]; 3], cells: usize) {
    for (light, corners) in light.iter_mut().zip(corners) {
        let (light, _) = light.as_chunks_mut::<CELL>();
        for (light, corners) in light.iter_mut().zip(corners.windows(2)).take(cells) {
            let (from, step) = (corners[0], (corners[1] - corners[0]) * (1.0 / CELL as f32));
            *light = std::array::from_fn(|i| from + step * i as f32);
        }
    }
}

/// Returns what the pixels of a tile take, in tens of instructions, about: corners lit by whole rows of the
/// tile wherever one of their blocks is interpolated, and pixels of the other blocks.
fn price(inputs: &BlockInputs, lighting: &MaterialLighting, cell: usize, within: u32) -> usize {
    let light_price = |light: &FastLight| 2 + 2 * usize::from(light.specular != [0.0; 3]);
    let lit = 2 + lighting.lights.iter().map(light_price).sum::<usize>();
    let of_row = |row: usize| within >> (row * inputs.columns) & ((1 << inputs.columns) - 1);
    let rows = (0..inputs.rows).filter(|row| of_row(*row) != 0).count();
    let corners = rows * (BLOCK[1] / cell) * (inputs.width / cell + 8);
    let interpolated = within.count_ones() as usize * BLOCK[0] * BLOCK[1];
    let others = inputs.count() * BLOCK[0] * BLOCK[1] - interpolated;
    corners * (lit + 2) + interpolated * (1 + 2 / cell) + others * lit
}

/// Inputs of a pixel's light, linear over the screen.
pub(super) struct LightInputs {
    /// 1/w.
    pub q: f32,
    /// Position in shading space, times q.
    pub point: [f32; 3],
    /// Normal towards the light, times q.
    pub normal: [f32; 3],
}

/// Inputs of the light at the corners of a tile's blocks, row by row: of each block at its upper left,
/// upper right, lower left and lower right corner.
pub(super) struct BlockInputs {
    /// Pixels side by side, and blocks side by side and below each other.
    width: usize,
    columns: usize,
    rows: usize,
    /// Unit vector towards a viewer at infinity; `None` if the viewer is at the origin.
    to_viewer: Option<[f32; 3]>,
    q: [[f32; BLOCKS]; 4],
    points: [[[f32; BLOCKS]; 3]; 4],
    normals: [[[f32; BLOCKS]; 3]; 4],
}

impl BlockInputs {
    /// Creates the inputs of a tile, `at` being those of a pixel.
    pub fn new(tile: PixelRect, to_viewer: Option<[f32; 3]>, at: impl Fn([i32; 2]) -> LightInputs) -> Self {
        let [width, height] = BLOCK.map(|pixels| pixels as i32);
        let none = [0.0; BLOCKS];
        let mut inputs = BlockInputs {
            width: (tile.x1 - tile.x0) as usize,
            columns: ((tile.x1 - tile.x0 + width - 1) / width) as usize,
            rows: ((tile.y1 - tile.y0 + height - 1) / height) as usize,
            to_viewer,
            q: [none; 4],
            points: [[none; 3]; 4],
            normals: [[none; 3]; 4],
        };
        for row in 0..=inputs.rows {
            for column in 0..=inputs.columns {
                let of_corner = at([tile.x0 + column as i32 * width, tile.y0 + row as i32 * height]);
                inputs.set(row, column, &of_corner);
            }
        }
        inputs
    }

    /// Returns the number of blocks.
    fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// Stores the inputs of a corner in the blocks around it.
    fn set(&mut self, row: usize, column: usize, inputs: &LightInputs) {
        for (corner, (down, right)) in [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter().enumerate() {
            let (Some(row), Some(column)) = (row.checked_sub(down), column.checked_sub(right)) else {
                continue;
            };
            if row == self.rows || column == self.columns {
                continue;
            }
            let block = row * self.columns + column;
            self.q[corner][block] = inputs.q;
            for axis in 0..3 {
                self.points[corner][axis][block] = inputs.point[axis];
                self.normals[corner][axis][block] = inputs.normal[axis];
            }
        }
    }
}

/// Finding the blocks of a tile whose bound is within an error, for cells of each size.
struct ErrorKernel<'a> {
    inputs: &'a BlockInputs,
    lighting: &'a MaterialLighting,
    most: f32,
}

impl Kernel for ErrorKernel<'_> {
    /// Sizes of cells, the largest first, each with the bits of the blocks.
    type Output = [(usize, u32); 3];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> [(usize, u32); 3] {
        let (inputs, most) = (self.inputs, s.splat(LARGEST));
        let mut within = [(LARGEST_CELL as usize, 0), (4, 0), (LEAST_CELL, 0)];
        let mut first = 0;
        while first < inputs.count() {
            let q = [s.load(&inputs.q[0][first..]); 4];
            let to_viewer = inputs.to_viewer.map(|v| splat3(s, v));
            let mut block = BlockCorners { q, points: [[q[0]; 3]; 4], normals: [[q[0]; 3]; 4], to_viewer };
            let mut is_known = s.mask(u32::MAX);
            let mut corner = 0;
            while corner < 4 {
                let q = s.load(&inputs.q[corner][first..]);
                is_known = is_known & s.splat(LEAST_SUM).lt(q) & q.lt(most);
                block.q[corner] = q;
                let mut axis = 0;
                while axis < 3 {
                    let point = s.load(&inputs.points[corner][axis][first..]);
                    let normal = s.load(&inputs.normals[corner][axis][first..]);
                    is_known = is_known & point.abs().lt(most) & normal.abs().lt(most);
                    block.points[corner][axis] = point;
                    block.normals[corner][axis] = normal;
                    axis += 1;
                }
                corner += 1;
            }
            // Normals are weighted by q: far away their squares would be lost.
            let far = s.splat(1.0) / block.q[0];
            let mut corner = 0;
            while corner < 4 {
                block.normals[corner] = scale::<S>(block.normals[corner], far);
                corner += 1;
            }
            let errors = errors_of_cells(s, self.lighting, &block);
            let mut size = 0;
            while size < within.len() {
                let error = errors.of_cell(s, within[size].0);
                within[size].1 |= (is_known & error.le(s.splat(self.most))).bits() << first;
                size += 1;
            }
            first += S::LANES;
        }
        within
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_of_cells_is_looked_at_though_its_neighbours_have_lit_its_corners() {
        let mut grid = LightGrid::new();
        (grid.cell_columns, grid.linear) = (4, [0b1111; CELL_ROWS]);
        for row in 0..4 {
            // The third corner of each row lies beside the face.
            grid.rows[row].is_known = 0b11011;
            grid.finish_corners(row);
        }
        grid.finish_cells(0);
        grid.finish_cells(2);
        assert_eq!([0, 1, 2].map(|row| grid.has_cells(row)), [true, false, true]);
        grid.finish_cells(1);
        assert!(grid.has_cells(1));
        assert_eq!(grid.linear[..4], [0b1001, 0b1001, 0b1001, 0b1111]);
        grid.set_face(1);
        assert!(!grid.has_cells(1));
    }
}

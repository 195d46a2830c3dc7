//! Light of a large face, computed at the corners of cells of 4x4 pixels and interpolated between them
//! where that is proven to differ too little to be seen.
//!
//! In: a face that was set up in f64 and is lit per pixel, the tile, and the allowed error. Out: for
//! each cell whether its pixels are interpolated, and the light at its corners. A cell is interpolated
//! if its corners lie inside the face and the bound of [`super::linear_light`] for its block of
//! 32x8 pixels is within the error. Both depend on the face, the cell and the draw's clip rectangle
//! alone: a pixel's colour depends neither on what hides its neighbours nor on the vector width. One knows by pictures that stay within
//! 1/255 of the reference, and by the bound's own tests.
//!
//! Corners are the centres of the cells' first pixels, so a cell's last corners are those of the next
//! cells. Rows of corners and of blocks are computed when the first of their pixels is shaded.

use super::attribute_fetch::blend;
use super::grid::Grid;
use super::interpolate::{FragmentInputs, ReflectedLight};
use super::lighting::{MaterialLighting, pack, scale, splat3};
use super::linear_light::{BlockCorners, CELL_PARTS, error_of_cells};
use super::shading_state::{ColorSource, Eye, FragmentShader};
use crate::math::coverage::PixelRect;
use crate::simd::{F32, I32, Kernel, Level, Mask, Simd};
use std::cell::Cell;

/// Columns and rows of a cell.
pub(super) const CELL: i32 = 4;

/// Cells side by side in a block, and in a column.
const BLOCK: [usize; 2] = [(1.0 / CELL_PARTS[0]) as usize, (1.0 / CELL_PARTS[1]) as usize];

/// Rows of cells in a tile.
const CELL_ROWS: usize = (Grid::TILE_ROWS / CELL) as usize;

/// Most blocks side by side in a tile.
const BLOCK_COLUMNS: usize = 2 * Grid::TILE_COLUMNS as usize / (CELL as usize * BLOCK[0]);

/// Room for the corners of a row: those of the widest tile, and the rest of a vector.
const COLUMNS: usize = BLOCK_COLUMNS * BLOCK[0] + 16;

/// Columns and rows of a face in a tile from which on a grid pays.
const LEAST_EXTENT: [i32; 2] = [24, 12];

/// Limit of the numbers whose squares, and products of squares, the bound can represent.
const LARGEST: f32 = 1e9;

/// Error of interpolated light that cannot be seen: a quarter of a step of a byte.
pub const UNSEEN: f32 = 0.25 / 255.0;

/// Returns whether a face of these bounds has so many pixels in a tile that a grid pays.
pub(super) fn may_pay(bounds: PixelRect, tile: PixelRect) -> bool {
    let columns = bounds.x1.min(tile.x1) - bounds.x0.max(tile.x0);
    let rows = bounds.y1.min(tile.y1) - bounds.y0.max(tile.y0);
    columns >= LEAST_EXTENT[0] && rows >= LEAST_EXTENT[1]
}

/// Returns the pixels up to whose neighbours the light of a tile's grids reaches: the whole tile,
/// whatever is seen of it, and its last cells.
pub(super) fn reach(tile: PixelRect) -> PixelRect {
    PixelRect { y1: tile.y0 + (tile.y1 - tile.y0 + CELL - 1) / CELL * CELL, ..tile }
}

/// Light at a row of corners, and what it was computed from at those of blocks.
#[derive(Clone, Copy)]
struct CornerRow {
    color: [[f32; COLUMNS]; 3],
    /// Positions in shading space times q.
    point: [[f32; BLOCK_COLUMNS + 1]; 3],
    normal: [[f32; BLOCK_COLUMNS + 1]; 3],
    /// 1/w.
    q: [f32; BLOCK_COLUMNS + 1],
    /// Bits of the corners that lie inside the face and are lit in f32.
    is_known: u128,
}

/// Light of one face over the cells of a tile.
pub(super) struct LightGrid {
    /// The face; below 0 for none.
    face: i32,
    /// Bits of the rows of corners, and of blocks, that are computed.
    has_corners: u32,
    has_blocks: u32,
    /// For each row of cells the bits of those that are interpolated.
    linear: [u64; CELL_ROWS],
    rows: [CornerRow; CELL_ROWS + 1],
}

/// Grids of a tile: those of the faces that were shaded last. So many faces that cut each other in one
/// vector of pixels would be needed for grids to be computed again and again.
const GRIDS: usize = 8;

thread_local! {
    /// Grids of the thread's last tile: tiles neither ask for memory nor clear it.
    static RECYCLED: Cell<Option<Box<[LightGrid; GRIDS]>>> = const { Cell::new(None) };
}

/// Grids of faces of a tile: 90 KB for each thread that has shaded large faces.
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
        let (row, corners) = ([0.0; COLUMNS], [0.0; BLOCK_COLUMNS + 1]);
        let row =
            CornerRow { color: [row; 3], point: [corners; 3], normal: [corners; 3], q: corners, is_known: 0 };
        LightGrid {
            face: -1,
            has_corners: 0,
            has_blocks: 0,
            linear: [0; CELL_ROWS],
            rows: [row; CELL_ROWS + 1],
        }
    }

    /// Makes it the grid of a face.
    fn set_face(&mut self, face: i32) {
        (self.face, self.has_corners, self.has_blocks) = (face, 0, 0);
    }

    /// Returns whether it is known which cells of a row are interpolated.
    #[inline(always)]
    pub fn has_cells(&self, row: usize) -> bool {
        self.has_blocks >> (row / BLOCK[1]) & 1 == 1
    }

    /// Returns the first row of corners that a row of cells, or its block, lacks.
    pub fn missing_corners(&self, row: usize) -> Option<usize> {
        let first = row / BLOCK[1] * BLOCK[1];
        (first..=first + BLOCK[1]).find(|row| self.has_corners >> row & 1 == 0)
    }

    /// Returns the number of corners of a row that `columns` pixels and their blocks need.
    pub fn corner_count(columns: i32) -> usize {
        (columns / CELL) as usize / BLOCK[0] * BLOCK[0]
            + if columns % (CELL * BLOCK[0] as i32) == 0 { 1 } else { BLOCK[0] + 1 }
    }

    /// Returns whether a cell is interpolated.
    #[inline(always)]
    pub fn is_linear(&self, [row, column]: [usize; 2]) -> bool {
        self.linear[row] >> column & 1 == 1
    }

    /// Returns the packed colours of a block of four columns of a cell, from its row `y` on.
    #[inline(always)]
    pub fn colors<S: Simd>(&self, s: S, [row, column]: [usize; 2], y: i32) -> S::I {
        let part = s.splat(1.0 / CELL as f32);
        let lane = s.iota();
        let across = (lane & s.splat_i(3)).to_f32() * part;
        let down = (lane.shr::<2>() + s.splat_i(y)).to_f32() * part;
        let (upper, lower) = (&self.rows[row].color, &self.rows[row + 1].color);
        let mut color = [across; 3];
        let mut channel = 0;
        while channel < 3 {
            let ([a, b], [c, d]) = (two(&upper[channel], column), two(&lower[channel], column));
            let top = s.splat(a) + s.splat(b - a) * across;
            let change = s.splat(c - a) + s.splat((d - c) - (b - a)) * across;
            color[channel] = top + change * down;
            channel += 1;
        }
        pack(s, color)
    }

    /// Keeps the light at LANES corners of a row from column `first` on. `known` are those that lie
    /// inside the face and are lit in f32.
    #[inline(always)]
    pub fn keep<S: Simd>(
        &mut self,
        s: S,
        [row, first]: [usize; 2],
        shader: &FragmentShader<'_>,
        inputs: &FragmentInputs<'_, S>,
        lit: &ReflectedLight<S>,
        known: S::M,
    ) {
        let to = &mut self.rows[row];
        let ColorSource::Pixels(normals) = shader.source else { return };
        let (all, p) = (s.mask(u32::MAX), inputs.barycentrics.p);
        let q = (p[0] + p[1]) + p[2];
        let turn = s.select(inputs.turn, s.splat(-1.0), s.splat(1.0));
        let normal = scale::<S>(blend(s, all, normals, &inputs.corners, p), turn);
        let point = shader.place_times_q(s, all, inputs, q);
        let color = lit.sum();
        let mut axis = 0;
        while axis < 3 {
            store(s, color[axis], first, &mut to.color[axis]);
            store_of_blocks(s, point[axis], first, &mut to.point[axis]);
            store_of_blocks(s, normal[axis], first, &mut to.normal[axis]);
            axis += 1;
        }
        store_of_blocks(s, q, first, &mut to.q);
        let lanes = (1u128 << S::LANES) - 1;
        to.is_known = (to.is_known & !(lanes << first)) | ((u128::from(known.bits()) & lanes) << first);
    }

    /// Notes that a row of corners is computed.
    pub fn finish_corners(&mut self, row: usize) {
        self.has_corners |= 1 << row;
    }

    /// Decides which cells of a row of blocks, of `columns` pixels, are interpolated with at most this
    /// error, in units of colour. `row` is that of any of the cells.
    pub fn decide(&mut self, row: usize, columns: i32, lighting: &MaterialLighting, eye: Eye, most: f32) {
        let first = row / BLOCK[1] * BLOCK[1];
        let to_viewer = match eye {
            Eye::Parallel { to_viewer } => Some(to_viewer),
            _ => None,
        };
        let corners = BlockRow::new(&self.rows[first], &self.rows[first + BLOCK[1]]);
        let count = (columns as usize).div_ceil(CELL as usize * BLOCK[0]);
        let within =
            Level::in_four_lanes(ErrorKernel { corners: &corners, count, lighting, to_viewer, most });
        let mut cells = 0u64;
        for block in (0..count).filter(|block| within >> block & 1 == 1) {
            cells |= ((1 << BLOCK[0]) - 1) << (block * BLOCK[0]);
        }
        // The frame's last columns may be less than a cell.
        let whole = u64::MAX.checked_shr(64 - (columns / CELL) as u32).unwrap_or(0);
        for row in first..first + BLOCK[1] {
            let known = self.rows[row].is_known & self.rows[row + 1].is_known;
            self.linear[row] = cells & whole & (known & (known >> 1)) as u64;
        }
        self.has_blocks |= 1 << (row / BLOCK[1]);
    }
}

/// Corners of a row of blocks: upper left, upper right, lower left, lower right.
struct BlockRow {
    q: [[f32; BLOCK_COLUMNS]; 4],
    points: [[[f32; BLOCK_COLUMNS]; 3]; 4],
    normals: [[[f32; BLOCK_COLUMNS]; 3]; 4],
}

impl BlockRow {
    fn new(upper: &CornerRow, lower: &CornerRow) -> Self {
        let none = [0.0; BLOCK_COLUMNS];
        let mut corners = BlockRow { q: [none; 4], points: [[none; 3]; 4], normals: [[none; 3]; 4] };
        for (corner, (row, right)) in [(upper, 0), (upper, 1), (lower, 0), (lower, 1)].into_iter().enumerate()
        {
            for block in 0..BLOCK_COLUMNS {
                let at = block + right;
                corners.q[corner][block] = row.q[at];
                for axis in 0..3 {
                    corners.points[corner][axis][block] = row.point[axis][at];
                    corners.normals[corner][axis][block] = row.normal[axis][at];
                }
            }
        }
        corners
    }
}

/// Finding the blocks of a row whose bound is within an error.
struct ErrorKernel<'a> {
    corners: &'a BlockRow,
    count: usize,
    lighting: &'a MaterialLighting,
    to_viewer: Option<[f32; 3]>,
    most: f32,
}

impl Kernel for ErrorKernel<'_> {
    /// Bits of the blocks.
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u32 {
        let most = s.splat(LARGEST);
        let (mut within, mut first) = (0, 0);
        while first < self.count {
            let q = [s.load(&self.corners.q[0][first..]); 4];
            let to_viewer = self.to_viewer.map(|v| splat3(s, v));
            let mut block = BlockCorners { q, points: [[q[0]; 3]; 4], normals: [[q[0]; 3]; 4], to_viewer };
            let mut is_known = s.mask(u32::MAX);
            let mut corner = 0;
            while corner < 4 {
                let q = s.load(&self.corners.q[corner][first..]);
                is_known = is_known & s.splat(1e-30).lt(q) & q.lt(most);
                block.q[corner] = q;
                let mut axis = 0;
                while axis < 3 {
                    let point = s.load(&self.corners.points[corner][axis][first..]);
                    let normal = s.load(&self.corners.normals[corner][axis][first..]);
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
            let error = error_of_cells(s, self.lighting, &block);
            within |= (is_known & error.le(s.splat(self.most))).bits() << first;
            first += S::LANES;
        }
        within
    }
}

/// Returns the numbers at a column and the next.
#[inline(always)]
fn two(row: &[f32; COLUMNS], column: usize) -> [f32; 2] {
    [row[column], row[column + 1]]
}

/// Stores those numbers of a vector, from a column of corners on, that are at blocks' corners.
#[inline(always)]
fn store_of_blocks<S: Simd>(s: S, v: S::F, first: usize, to: &mut [f32; BLOCK_COLUMNS + 1]) {
    let mut lanes = [0.0; 16];
    s.store(v, &mut lanes[..S::LANES]);
    let mut column = first.next_multiple_of(BLOCK[0]);
    while column < first + S::LANES && column / BLOCK[0] <= BLOCK_COLUMNS {
        to[column / BLOCK[0]] = lanes[column - first];
        column += BLOCK[0];
    }
}

/// Stores a vector from a column on.
#[inline(always)]
fn store<S: Simd>(s: S, v: S::F, first: usize, to: &mut [f32; COLUMNS]) {
    s.store(v, &mut to[first..first + S::LANES]);
}

//! Grid of the tiles that a clip rectangle is divided into.

use crate::math::coverage::PixelRect;
use crate::memory::TILE_CELL;

/// Division of the clip rectangle into tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Number of tiles side by side, at least 1.
    pub columns: usize,
    /// Number of rows of tiles.
    pub rows: usize,
    /// First pixel row of the first row of tiles.
    pub y0: i32,
    /// Width of the frame in pixels, where the last tile of a row ends.
    pub width: i32,
}

impl Grid {
    /// Columns of a tile, equal to those of a cell of depth memory; the last tile of a row has
    /// fewer than twice as many.
    pub const TILE_COLUMNS: i32 = TILE_CELL as i32;
    /// Pixel rows of a tile.
    pub const TILE_ROWS: i32 = 32;

    /// Creates the grid of a clip rectangle in a frame of `width` pixels.
    pub fn new(view: &PixelRect, width: usize) -> Self {
        Grid {
            columns: (width / Self::TILE_COLUMNS as usize).max(1),
            rows: ((view.y1 - view.y0).max(0) as usize).div_ceil(Self::TILE_ROWS as usize),
            y0: view.y0,
            width: width as i32,
        }
    }

    /// Creates the grid of a whole frame of this width and height.
    pub fn of_frame((width, height): (usize, usize)) -> Self {
        Grid::new(&PixelRect { x0: 0, y0: 0, x1: width as i32, y1: height as i32 }, width)
    }

    /// Returns the tiles that non-empty half-open bounds reach: first column and row, last column
    /// and row.
    #[inline(always)]
    pub fn tiles_of(&self, [x0, y0, x1, y1]: [i32; 4]) -> [usize; 4] {
        [self.column_of(x0), self.row_of(y0), self.column_of(x1 - 1), self.row_of(y1 - 1)]
    }

    /// Returns the tile column of a pixel column.
    #[inline(always)]
    fn column_of(&self, x: i32) -> usize {
        ((x / Self::TILE_COLUMNS) as usize).min(self.columns - 1)
    }

    /// Returns the tile row of a pixel row.
    #[inline(always)]
    fn row_of(&self, y: i32) -> usize {
        ((y - self.y0) / Self::TILE_ROWS) as usize
    }

    /// Returns the pixel columns of a tile column.
    pub fn pixels_of(&self, column: usize) -> std::ops::Range<i32> {
        let end =
            if column + 1 == self.columns { self.width } else { (column as i32 + 1) * Self::TILE_COLUMNS };
        column as i32 * Self::TILE_COLUMNS..end
    }
}

//! A tile, and the buffers that one thread writes while it draws the tile.

use super::grid::Grid;
use crate::math::coverage::PixelRect;

/// Face id of pixels that no face of this draw covers.
pub const NO_FACE: i32 = -1;

/// Depths of no face: the nearest is farther than the farthest.
pub const NO_DEPTHS: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// Bit set in a face id if the face was set up in f64.
pub const EXACT_FACE_BIT: i32 = 1 << 30;

/// Row stride of a tile's face ids; the last tile of a row has fewer columns than this.
pub const ID_STRIDE: usize = 2 * Grid::TILE_COLUMNS as usize;

/// Face ids of a tile, sized for the first-level cache; rows and columns beyond the tile stay
/// [`NO_FACE`].
pub type Ids = [i32; ID_STRIDE * Grid::TILE_ROWS as usize];

/// A tile and its buffers.
pub struct Tile<'a> {
    /// First pixel column; the tile has at least as many columns as a vector has lanes.
    pub x0: i32,
    /// End of the pixel columns.
    pub x1: i32,
    /// First pixel row.
    pub y0: i32,
    /// End of the pixel rows.
    pub y1: i32,
    /// Width of a row of the frame in pixels.
    pub width: usize,
    /// Depth words from the tile's first pixel on; empty where depth is neither tested nor stored.
    pub depth: &'a mut [i32],
    /// Number of depth words from a row to the next.
    pub depth_stride: usize,
    /// Face ids of the tile's pixels.
    pub ids: &'a mut Ids,
    /// Distance up to which two f32 depths of the draw are close.
    pub tolerance: f32,
    /// Nearest and farthest depth of the draw's faces in the tile; `None` if they are not known.
    pub depths: Option<[f32; 2]>,
}

impl Tile<'_> {
    /// Returns the tile's pixels.
    #[inline(always)]
    pub fn rect(&self) -> PixelRect {
        PixelRect { x0: self.x0, y0: self.y0, x1: self.x1, y1: self.y1 }
    }

    /// Adds the depths of a face to those that are known; not finite ones make them unknown.
    pub fn add_depths(&mut self, [near, far]: [f32; 2]) {
        let is_known = near.is_finite() && far.is_finite();
        let known = self.depths.filter(|_| is_known);
        self.depths = known.map(|[low, high]| [low.min(near.max(0.0)), high.max(far.max(0.0))]);
    }

    /// Returns whether depths in this range are farther than the tolerance from all of the draw's
    /// faces in the tile so far.
    pub fn is_apart(&self, [near, far]: [f32; 2]) -> bool {
        let margin = 2.0 * self.tolerance;
        self.depths.is_some_and(|[low, high]| near - margin > high || far.max(0.0) + margin < low)
    }

    /// Returns the nearest and the farthest depth of the pixels that show faces of the draw.
    pub fn range_of_depths(&self) -> [f32; 2] {
        let [mut low, mut high] = NO_DEPTHS;
        let columns = (self.x1 - self.x0) as usize;
        for y in self.y0..self.y1 {
            let (at, ids) = (self.depth_at(self.x0, y), self.id_at(self.x0, y));
            for (word, id) in self.depth[at..at + columns].iter().zip(&self.ids[ids..ids + columns]) {
                if *id != NO_FACE {
                    let depth = f32::from_bits(*word as u32);
                    (low, high) = (low.min(depth), high.max(depth));
                }
            }
        }
        [low, high]
    }

    /// Returns the number of pixels.
    #[inline(always)]
    pub fn pixels(&self) -> u64 {
        ((self.x1 - self.x0) * (self.y1 - self.y0)) as u64
    }

    /// Returns the index of a pixel in the face ids.
    #[inline(always)]
    pub fn id_at(&self, x: i32, y: i32) -> usize {
        (y - self.y0) as usize * ID_STRIDE + (x - self.x0) as usize
    }

    /// Returns the index of a pixel in the depth words.
    #[inline(always)]
    pub fn depth_at(&self, x: i32, y: i32) -> usize {
        (y - self.y0) as usize * self.depth_stride + (x - self.x0) as usize
    }

    /// Returns the index of a pixel in the frame's rows from the tile's first row on.
    #[inline(always)]
    pub fn pixel_at(&self, x: i32, y: i32) -> usize {
        (y - self.y0) as usize * self.width + x as usize
    }
}

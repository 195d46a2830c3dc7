//! Deferred shading of draws with surface maps: colours the pixels of a tile by the plain path, in
//! f64.
//!
//! In: the face ids of a tile. Out: the bytes of its pixels, each shaded once, and the pick buffer.
//! Neighbouring pixels of a row that show one face are handed over together, so that the face is set
//! up once for them. Nothing is done in vectors: the bytes are equal at every level. `ResolveKernel`
//! does the same for all other draws.

use super::resolve::{STRIP, keep_ids};
use super::shading_state::PlainRun;
use super::tile_buffers::{EXACT_FACE_BIT, ID_STRIDE, NO_FACE, Tile};
use crate::math::coverage::PixelRect;
use crate::memory::PickCells;

/// A tile whose visible pixels are shaded one by one.
pub struct PixelResolve<'a, 'b, 'c> {
    /// Shades the pixels of a run.
    pub shade: PlainRun<'a>,
    /// Columns and rows that may hold faces, inside the tile.
    pub reach: PixelRect,
    /// Tile to shade; its face ids are reset to [`NO_FACE`].
    pub tile: &'b mut Tile<'c>,
    /// RGBA bytes of the frame's rows from the tile's first row on.
    pub bytes: &'b mut [u8],
    /// Pick buffer of those rows (name and triangle); empty when picking is off.
    pub pick: PickCells<'b>,
    /// Name that is written to the pick buffer.
    pub name: u32,
}

impl PixelResolve<'_, '_, '_> {
    /// Shades the tile.
    pub fn run(mut self) {
        for y in self.reach.y0..self.reach.y1 {
            let first = self.tile.id_at(self.reach.x0, y);
            let ids = &self.tile.ids[first..first + (self.reach.x1 - self.reach.x0) as usize];
            let mut x = self.reach.x0;
            for run in ids.chunk_by(|a, b| a == b) {
                let (face, end) = (run[0], x + run.len() as i32);
                if face != NO_FACE {
                    let [from, to] = [x, end].map(|x| self.tile.pixel_at(x, y) * 4);
                    (self.shade)((face & !EXACT_FACE_BIT) as u32, [x, y], &mut self.bytes[from..to]);
                }
                x = end;
            }
        }
        if !self.pick.ids.is_empty() {
            self.keep_all_ids();
        }
        let rows = (self.reach.y0 - self.tile.y0) as usize..(self.reach.y1 - self.tile.y0) as usize;
        let columns = (self.reach.x0 - self.tile.x0) as usize..(self.reach.x1 - self.tile.x0) as usize;
        for row in rows {
            self.tile.ids[row * ID_STRIDE..][columns.clone()].fill(NO_FACE);
        }
    }

    /// Writes the ids of all strips that show a face to the pick buffer.
    fn keep_all_ids(&mut self) {
        let (x0, y0) = (self.tile.x0, self.tile.y0);
        let left = x0 + ((self.reach.x0 - x0) & !(STRIP[0] - 1));
        let top = y0 + ((self.reach.y0 - y0) & !(STRIP[1] - 1));
        for y in (top..self.reach.y1).step_by(STRIP[1] as usize) {
            for x in (left..self.reach.x1).step_by(STRIP[0] as usize) {
                let at = self.tile.id_at(x, y);
                let columns = ((x + STRIP[0]).min(self.tile.x1) - x) as usize;
                let rows = 0..((y + STRIP[1]).min(self.tile.y1) - y) as usize;
                let is_face = |id: &i32| *id != NO_FACE;
                if rows.into_iter().any(|row| {
                    let row = &self.tile.ids[at + row * ID_STRIDE..][..columns];
                    row.iter().any(is_face)
                }) {
                    keep_ids(self.tile, &mut self.pick, self.name, x, y);
                }
            }
        }
    }
}

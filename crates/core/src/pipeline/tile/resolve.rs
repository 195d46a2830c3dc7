//! Deferred shading: shades each pixel of a tile that a face of this draw won, once, in blocks of
//! four columns.
//!
//! Barycentrics come from the unsnapped corners: e_i is the doubled area that the pixel centre and
//! edge i span, clamped to the range between 0 and the face's doubled area, whose sign it has; b_i
//! = (e_i / w_i) / sum(e_j / w_j). The point itself lies on the eye's ray through the pixel, at
//! depth w = sum(e_i) / sum(e_i / w_i), so no positions are gathered. An exact face supplies e_i /
//! w_i as linear functions of the pixel. Where f32 lacks the digits (normals that cancel, a light
//! very near) the plain path shades the pixel in f64.

use super::attribute_fetch::Few;
use super::cached_face::CachedFace;
use super::exact_faces::ExactFace;
use super::face_tables::Faces;
use super::interpolate::FragmentInputs;
use super::light_grid::LightGrid;
use super::lighting::pack;
use super::texture_queue::{QUEUE_CAPACITY, TextureQueue};
use super::tile_buffers::{EXACT_FACE_BIT, ID_STRIDE, NO_FACE, Tile};
use crate::math::coverage::PixelRect;
use crate::memory::{NOT_PICKED, PickCells, STRIP_CELL};
use crate::simd::{I32, Kernel, Mask, Part, Simd, long_kernel};

/// Shades the visible pixels of a tile.
pub struct ResolveKernel<'a, 'b, 'c> {
    /// Tables of the faces' attributes.
    pub faces: Faces<'a>,
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

/// Columns and rows that are shaded together: four blocks of 4x4 pixels, so that each face needs
/// few vectors.
pub(super) const STRIP: [i32; 2] = [STRIP_CELL as i32, 4];

long_kernel!(ResolveKernel<'_, '_, '_>);

impl Kernel for ResolveKernel<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) {
        let mut cached = CachedFace::new(&self.faces);
        // Only textured pixels are queued.
        let is_textured = self.faces.shading.bindings.iter().any(|binding| binding.texture.is_some());
        let mut queue = if is_textured { Some(TextureQueue::new(s)) } else { None };
        let mut few = Few::new(s);
        let (x0, y0) = (self.tile.x0, self.tile.y0);
        let left = x0 + ((self.reach.x0 - x0) & !(STRIP[0] - 1));
        let mut y = y0 + ((self.reach.y0 - y0) & !(STRIP[1] - 1));
        while y < self.reach.y1 {
            let mut x = left;
            while x < self.reach.x1 {
                if self.is_full_of(s, &cached, x, y) {
                    x += STRIP[0];
                    continue;
                }
                let (has_narrow, has_exact) = self.look(s, x, y);
                if (has_narrow | has_exact) && !self.pick.ids.is_empty() {
                    keep_ids(self.tile, &mut self.pick, self.name, x, y);
                }
                if has_narrow {
                    self.blocks(s, x, y, &mut few, &mut queue);
                }
                if has_exact {
                    s.call(s, ExactStrip { kernel: &mut self, at: (x, y), cached: &mut cached });
                }
                x += STRIP[0];
            }
            y += STRIP[1];
        }
        if let Some(queue) = &mut queue {
            s.call(s, DrainQueue { kernel: &mut self, queue });
        }
        let rows = (self.reach.y0 - y0) as usize..(self.reach.y1 - y0) as usize;
        let columns = (self.reach.x0 - x0) as usize..(self.reach.x1 - x0) as usize;
        for row in rows {
            self.tile.ids[row * ID_STRIDE..][columns.clone()].fill(NO_FACE);
        }
    }
}

impl<'a> ResolveKernel<'a, '_, '_> {
    /// Returns whether some of a strip's pixels show faces that have screen vertices, and whether
    /// some show faces that were set up in f64.
    #[inline(always)]
    fn look<S: Simd>(&self, s: S, x: i32, y: i32) -> (bool, bool) {
        let at = self.tile.id_at(x, y);
        let (mut narrow, mut exact_face) = (s.mask(0), s.mask(0));
        let mut row = 0;
        while row < STRIP[1] as usize {
            let mut column = 0;
            while column < STRIP[0] as usize {
                let ids = s.load_i(&self.tile.ids[at + row * ID_STRIDE + column..]);
                let is_exact = ids.gt(s.splat_i(EXACT_FACE_BIT - 1));
                narrow = narrow | (ids.gt(s.splat_i(NO_FACE)) & !is_exact);
                exact_face = exact_face | is_exact;
                column += S::LANES;
            }
            row += 1;
        }
        (narrow.any(), exact_face.any())
    }

    /// Returns whether a whole strip shows the cached face and the face has one colour; the strip
    /// is then filled with it.
    #[inline(always)]
    fn is_full_of<S: Simd>(&mut self, s: S, cached: &CachedFace<'a, S>, x: i32, y: i32) -> bool {
        let Some(color) = cached.color else { return false };
        if !self.pick.ids.is_empty() || !self.shows_only(s, cached.face | EXACT_FACE_BIT, x, y) {
            return false;
        }
        let mut row = 0;
        while row < STRIP[1] {
            let at = self.tile.pixel_at(x, y + row) * 4;
            let bytes = &mut self.bytes[at..at + STRIP[0] as usize * 4];
            let mut column = 0;
            while column < STRIP[0] as usize {
                s.store_masked_bytes(s.mask(u32::MAX), color, &mut bytes[column * 4..]);
                column += S::LANES;
            }
            row += 1;
        }
        true
    }

    /// Returns whether a strip lies inside the tile and all its pixels show the face of an id.
    #[inline(always)]
    fn shows_only<S: Simd>(&self, s: S, id: i32, x: i32, y: i32) -> bool {
        if x + STRIP[0] > self.tile.x1 || y + STRIP[1] > self.tile.y1 {
            return false;
        }
        let (at, id) = (self.tile.id_at(x, y), s.splat_i(id));
        let mut same = s.mask(u32::MAX);
        let mut row = 0;
        while row < STRIP[1] as usize {
            let mut column = 0;
            while column < STRIP[0] as usize {
                same = same & s.load_i(&self.tile.ids[at + row * ID_STRIDE + column..]).eq(id);
                column += S::LANES;
            }
            row += 1;
        }
        !(!same).any()
    }

    /// Shades a strip's pixels whose faces have screen vertices, a block of four columns at a time.
    #[inline(always)]
    fn blocks<S: Simd>(
        &mut self,
        s: S,
        x: i32,
        y: i32,
        few: &mut Few<S>,
        queue: &mut Option<TextureQueue<S>>,
    ) {
        let height = S::LANES as i32 / 4;
        let mut row = y;
        while row < y + STRIP[1] {
            let mut column = x;
            while column < (x + STRIP[0]).min(self.tile.x1) {
                self.block(s, column.min(self.tile.x1 - 4), row, few, queue);
                column += 4;
            }
            row += height;
        }
    }

    /// Shades the pixels of one block whose faces have screen vertices.
    #[inline(always)]
    fn block<S: Simd>(
        &mut self,
        s: S,
        x: i32,
        y: i32,
        few: &mut Few<S>,
        queue: &mut Option<TextureQueue<S>>,
    ) {
        let ids = s.load_block(&self.tile.ids[self.tile.id_at(x, y)..], ID_STRIDE);
        let narrow = ids.gt(s.splat_i(NO_FACE)) & s.splat_i(EXACT_FACE_BIT).gt(ids);
        if !narrow.any() {
            return;
        }
        if self.faces.is_far_flung && x + 8 <= self.tile.x1 {
            let next = s.load_block(&self.tile.ids[self.tile.id_at(x + 4, y)..], ID_STRIDE);
            self.faces.prefetch(s, next);
        }
        let lane = s.iota();
        let at = (s.splat_i(x) + (lane & s.splat_i(3)), s.splat_i(y) + lane.shr::<2>());
        let first = self.tile.pixel_at(x, y);
        if let Some(color) = self.faces.unweighed_color(s, narrow, ids) {
            s.store_block_bytes(narrow, color, &mut self.bytes[first * 4..], self.tile.width);
            return;
        }
        let (inputs, bindings) = self.faces.fragment_inputs(s, narrow, ids, at, few);
        // One material after the other; most blocks show one.
        let is_only = self.faces.shading.bindings.len() == 1;
        let mut numbers = [0; 16];
        if !is_only {
            s.store_i(bindings, &mut numbers[..S::LANES]);
        }
        let mut left = narrow;
        while left.any() {
            let number = numbers[left.bits().trailing_zeros() as usize];
            let same = if is_only { left } else { left & bindings.eq(s.splat_i(number)) };
            left = left & !same;
            self.binding(s, same, number as usize, &inputs, (x, y), queue);
        }
    }

    /// Lights a block's pixels that show one material; stores them, or queues them for their
    /// texels.
    #[inline(always)]
    fn binding<S: Simd>(
        &mut self,
        s: S,
        mask: S::M,
        number: usize,
        inputs: &FragmentInputs<'_, S>,
        (x, y): (i32, i32),
        queue: &mut Option<TextureQueue<S>>,
    ) {
        let shader = &self.faces.shading.shader;
        let binding = &self.faces.shading.bindings[number];
        let (lit, needs_f64) = shader.lit(s, mask, &binding.lighting, inputs);
        let sure = mask & !needs_f64;
        if let (Some(texture), Some(queue)) = (&binding.texture, queue) {
            let place = &mut queue.vectors[queue.count];
            place.mask = sure;
            place.binding = number;
            place.corner = [x, y];
            place.lit = lit;
            place.sample_coord = shader.sample_coord(s, mask, texture, inputs);
            queue.count += 1;
            if queue.count == QUEUE_CAPACITY {
                s.call(s, DrainQueue { kernel: self, queue });
            }
        } else {
            let color = shader.finish(s, &lit);
            let first = self.tile.pixel_at(x, y);
            s.store_block_bytes(sure, color, &mut self.bytes[first * 4..], self.tile.width);
        }
        self.plain_pixels((mask & needs_f64).bits(), (x, y));
    }

    /// Fetches the texels of the queued pixels and stores their colours.
    #[inline(always)]
    fn drain_queue<S: Simd>(&mut self, s: S, queue: &mut TextureQueue<S>) {
        let shading = self.faces.shading;
        let vectors = &mut queue.vectors[..queue.count];
        for vector in &mut *vectors {
            if let Some(texture) = &shading.bindings[vector.binding].texture {
                vector.texel_addresses = texture.texel_addresses(s, vector.mask, &vector.sample_coord);
            }
        }
        for vector in &mut *vectors {
            if let Some(texture) = &shading.bindings[vector.binding].texture {
                vector.lit.multiply(texture.texel(
                    s,
                    vector.mask,
                    &vector.sample_coord,
                    &vector.texel_addresses,
                ));
            }
            let color = shading.shader.finish(s, &vector.lit);
            let [x, y] = vector.corner;
            let (first, needs_f64) =
                (self.tile.pixel_at(x, y), vector.texel_addresses.needs_f64() & vector.mask);
            let sure = vector.mask & !needs_f64;
            s.store_block_bytes(sure, color, &mut self.bytes[first * 4..], self.tile.width);
            self.plain_pixels(needs_f64.bits(), (x, y));
        }
        queue.count = 0;
    }

    /// Shades the pixels of a block given by the bits of `left` by the plain path.
    #[inline(always)]
    fn plain_pixels(&mut self, mut left: u32, (x, y): (i32, i32)) {
        while left != 0 {
            let lane = left.trailing_zeros() as i32;
            left &= left - 1;
            let (x, y) = (x + (lane & 3), y + (lane >> 2));
            self.plain_pixel(self.tile.ids[self.tile.id_at(x, y)], x, y);
        }
    }

    /// Shades one pixel by the plain path.
    fn plain_pixel(&mut self, id: i32, x: i32, y: i32) {
        let color = (self.faces.shading.plain)((id & !EXACT_FACE_BIT) as u32, x, y);
        let at = self.tile.pixel_at(x, y) * 4;
        self.bytes[at..at + 4].copy_from_slice(&color);
    }

    /// Shades a strip's pixels whose faces were set up in f64, face by face: most strips show one.
    #[inline(always)]
    fn exact_strip<S: Simd>(&mut self, s: S, x: i32, y: i32, cached: &mut CachedFace<'a, S>) {
        let size = [(x + STRIP[0]).min(self.tile.x1) - x, (y + STRIP[1]).min(self.tile.y1) - y];
        let mut left = self.exact_pixels(s, [x, y], size);
        while left != 0 {
            let first = left.trailing_zeros() as i32;
            let (mut row, column) = (first / STRIP[0], first % STRIP[0]);
            let vector = column & !(S::LANES as i32 - 1);
            let at = self.tile.id_at(self.vector_start::<S>(x + vector) + (column - vector), y + row);
            let id = self.tile.ids[at];
            cached.look_up(s, &self.faces, self.tile, id);
            while row < size[1] {
                let mut column = 0;
                while column < size[0] {
                    let (shift, start) = (row * STRIP[0] + column, self.vector_start::<S>(x + column));
                    let ids = s.load_i(&self.tile.ids[self.tile.id_at(start, y + row)..]);
                    let same = ids.eq(s.splat_i(id)) & s.mask((left >> shift) as u32);
                    left &= !(lanes_of::<S>(same) << shift);
                    if same.any() {
                        self.exact_vector(s, same, id, (start, y + row), cached);
                    }
                    column += S::LANES as i32;
                }
                row += 1;
            }
        }
    }

    /// Returns a bit for each pixel of a strip, of this size inside the tile, whose face was set up in
    /// f64: that of a lane is 16 times its row, plus its vector's column in the strip, plus the lane.
    #[inline(always)]
    fn exact_pixels<S: Simd>(&self, s: S, [x, y]: [i32; 2], size: [i32; 2]) -> u64 {
        let (mut bits, mut row) = (0, 0);
        while row < size[1] {
            let mut column = 0;
            while column < size[0] {
                let start = self.vector_start::<S>(x + column);
                let ids = s.load_i(&self.tile.ids[self.tile.id_at(start, y + row)..]);
                let fresh = s.mask(u32::MAX << (x + column - start));
                let exact_face = ids.gt(s.splat_i(EXACT_FACE_BIT - 1)) & fresh;
                bits |= lanes_of::<S>(exact_face) << (row * STRIP[0] + column);
                column += S::LANES as i32;
            }
            row += 1;
        }
        bits
    }

    /// Returns the first column of the vector for a column: one that would leave the tile starts further
    /// left.
    #[inline(always)]
    fn vector_start<S: Simd>(&self, x: i32) -> i32 {
        x.min(self.tile.x1 - S::LANES as i32)
    }

    /// Shades the lanes `left` of a vector of pixels, which show the cached face, of this id.
    #[inline(always)]
    fn exact_vector<S: Simd>(
        &mut self,
        s: S,
        mut left: S::M,
        id: i32,
        (x, y): (i32, i32),
        cached: &mut CachedFace<'a, S>,
    ) {
        let at = self.tile.pixel_at(x, y) * 4;
        if let Some(color) = cached.color {
            return s.store_masked_bytes(left, color, &mut self.bytes[at..at + S::LANES * 4]);
        }
        let mut plain = left;
        if let Some(exact_face) = cached.exact_face {
            if cached.has_grid {
                let (linear, color) = self.interpolated(s, exact_face, cached, (x, y));
                s.store_masked_bytes(left & linear, color, &mut self.bytes[at..at + S::LANES * 4]);
                left = left & !linear;
                if !left.any() {
                    return;
                }
            }
            let (color, needs_f64) = match &cached.matte {
                Some(matte) if x & (S::LANES as i32 - 1) == 0 => matte.colors(s, [x, y]),
                _ => self.faces.exact_face(s, left, exact_face, [x, y]),
            };
            s.store_masked_bytes(left & !needs_f64, color, &mut self.bytes[at..at + S::LANES * 4]);
            plain = left & needs_f64;
        }
        let mut plain = plain.bits();
        while plain != 0 {
            let lane = plain.trailing_zeros() as i32;
            plain &= plain - 1;
            self.plain_pixel(id, x + lane, y);
        }
    }
}

/// Returns the lanes of a mask as the low bits of a number.
#[inline(always)]
fn lanes_of<S: Simd>(mask: S::M) -> u64 {
    u64::from(mask.bits()) & ((1 << S::LANES) - 1)
}

impl<'a> ResolveKernel<'a, '_, '_> {
    /// Returns the lanes of a row of pixels of the cached face whose light is interpolated, and their
    /// packed colours.
    #[inline(always)]
    fn interpolated<S: Simd>(
        &mut self,
        s: S,
        exact_face: &'a ExactFace,
        cached: &mut CachedFace<'a, S>,
        (x, y): (i32, i32),
    ) -> (S::M, S::I) {
        let slot = match cached.grid {
            Some(slot) => slot,
            None => cached.grids.open(cached.face),
        };
        cached.grid = Some(slot);
        let Some(grid) = cached.grids.get(slot) else { return (s.mask(0), s.splat_i(0)) };
        if !grid.is_decided() {
            self.faces.decide_cells(grid, exact_face, self.tile.rect());
            cached.has_grid = grid.has_linear_cells();
        }
        let [column, line] = [(x - self.tile.x0) as usize, (y - self.tile.y0) as usize];
        let row = grid.row_of(line);
        let mut linear = grid.linear_pixels::<S>(row, column);
        if linear == 0 {
            return (s.mask(0), s.splat_i(0));
        }
        if !grid.has_cells(row) {
            s.call(s, LightCells { faces: &self.faces, exact_face, tile: self.tile.rect(), grid, row });
            linear = grid.linear_pixels::<S>(row, column);
        }
        (s.mask(linear), pack(s, grid.light(s, [column, line])))
    }
}

/// Lighting the corners of a row of cells.
struct LightCells<'k, 'a> {
    faces: &'k Faces<'a>,
    exact_face: &'k ExactFace,
    tile: PixelRect,
    grid: &'k mut LightGrid,
    row: usize,
}

impl<S: Simd> Part<S> for LightCells<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self, s: S) {
        let LightCells { faces, exact_face, tile, grid, row } = self;
        let cell = grid.cell() as i32;
        for corners in [row, row + 1] {
            if grid.has_corners(corners) {
                continue;
            }
            let mut column = 0;
            while column <= grid.cell_columns() {
                let pixel = [tile.x0 + column as i32 * cell, tile.y0 + corners as i32 * cell];
                faces.light_corners(s, exact_face, pixel, grid, [corners, column]);
                column += S::LANES;
            }
            grid.finish_corners(corners);
        }
        grid.finish_cells(row);
    }
}

/// Draining the queue of a kernel, from two places.
struct DrainQueue<'k, 'a, 'b, 'c, S: Simd> {
    kernel: &'k mut ResolveKernel<'a, 'b, 'c>,
    queue: &'k mut TextureQueue<S>,
}

impl<S: Simd> Part<S> for DrainQueue<'_, '_, '_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self, s: S) {
        self.kernel.drain_queue(s, self.queue);
    }
}

/// Shading those pixels of a strip whose faces were set up in f64: all that shades once more. Called for
/// a strip and not for a vector of it, which is 16 pixels and would pay for the call.
struct ExactStrip<'k, 'a, 'b, 'c, S: Simd> {
    kernel: &'k mut ResolveKernel<'a, 'b, 'c>,
    at: (i32, i32),
    cached: &'k mut CachedFace<'a, S>,
}

impl<S: Simd> Part<S> for ExactStrip<'_, '_, '_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self, s: S) {
        let (x, y) = self.at;
        self.kernel.exact_strip(s, x, y, self.cached);
    }
}

/// Writes name and triangle of a strip's pixels to the pick buffer. Inlined, so that the vectors of
/// the kernel's level serve it.
#[inline(always)]
pub(super) fn keep_ids(tile: &Tile<'_>, pick: &mut PickCells<'_>, name: u32, x: i32, y: i32) {
    let columns = ((x + STRIP[0]).min(tile.x1) - x) as usize;
    for row in y..(y + STRIP[1]).min(tile.y1) {
        let (from, to) = (tile.id_at(x, row), tile.pixel_at(x, row));
        let is_pending = pick.take_pending((row - tile.y0) as usize, x as usize);
        let picked = pick.ids[to..to + columns].iter_mut();
        let pixels = picked.zip(&tile.ids[from..from + columns]);
        let face = |id: i32| [name, (id & !EXACT_FACE_BIT) as u32];
        if is_pending {
            pixels.for_each(|(pick, &id)| *pick = if id == NO_FACE { NOT_PICKED } else { face(id) });
        } else {
            pixels.for_each(|(pick, &id)| *pick = if id == NO_FACE { *pick } else { face(id) });
        }
    }
}

//! Triangle set-up: culls and bounds faces and computes their edge functions and depth plane, a
//! vector of faces at a time.
//!
//! In: screen vertices, three indices a face. Out: the faces that may cover a pixel, in file order,
//! binned into tiles. There are three kinds of set-up:
//! - [`Tiny`]: at most 8 pixels a side; its coverage is computed here, one bit for each pixel, and
//!   a face without coverage is dropped. A vector of faces that cover one or two pixels each
//!   becomes [`fragments`].
//! - [`Small`]: edge functions that are exact in i32.
//! - [`ExactFace`]: all others, by the plain path's own set-up in f64.

use super::bin_fragments::bin_fragments;
use super::bins::{Chunk, ClipRect, Grid, Small, Winding};
use super::clusters::Visibility;
use super::edges::{bounds3, corner, coverage, edge, ones, pixels, snapped, sort_corners};
use super::exact_faces::ExactFace;
use super::fragments;
use super::vertex::{Outcode, ScreenVertex};
use crate::pipeline::draw_call::DrawStats;
use crate::pipeline::indexed_mesh::CLUSTER_FACES;
use crate::simd::{F32, I32, Kernel, Mask, Simd, prefetch};

/// Largest side in pixels of a box whose edge functions are exact in i32: 2 * (64 * 256)^2 < 2^31.
pub const SMALL_SIDE: i32 = 62;

/// Largest side in pixels of a face whose coverage is a word of bits.
pub const TINY_SIDE: i32 = 8;

/// Largest range of depth over a face, times its slenderness (longest side squared over doubled
/// area): the rounding of the slope then moves depth by less than 6e-8 over the face.
const STEEPEST: f32 = 1.0 / 2.0;

/// Largest slenderness for barycentrics in f32: longest side squared over doubled area.
const SLENDEREST: f32 = 4096.0;

/// Smallest thickness of a face in pixels. Snapping covers centres up to 1/360 pixel beside the
/// unsnapped face; there, the depth errors of its corners, 9e-8 at most, are amplified
/// 1 + 2 / (360 thickness) times: here 2.4 times.
const THINNEST: f32 = 1.0 / 256.0;

/// Largest depth slope per pixel for positions in 1/65536 pixel: an error below 1e-7.
const STEEPEST_SLOPE: f32 = 1.0 / 128.0;

/// Sets up one face, by its index, as the plain path does, if screen vertices cannot represent it;
/// `None` if nothing of it is drawn.
pub type PlainSetup<'a> = &'a (dyn Fn(u32, &mut DrawStats) -> Option<ExactFace> + Sync);

/// Sets up and bins the faces of a chunk.
pub struct SetupKernel<'a> {
    /// Vertices of the mesh on the screen.
    pub screen_vertices: &'a [ScreenVertex],
    /// Vertex indices of the three corners of this chunk's faces, padded to whole vectors.
    pub corners: [&'a [i32]; 3],
    /// Number of faces in this chunk.
    pub faces: usize,
    /// Visibility of this chunk's clusters; empty if all are open.
    pub visibilities: &'a [u8],
    /// Index of the chunk's first face in the mesh.
    pub first_face: u32,
    /// Windings that are drawn.
    pub winding: Winding,
    /// Pixels that may be drawn.
    pub view: ClipRect,
    /// Grid of tiles.
    pub grid: Grid,
    /// Set-up by the plain path.
    pub plain: PlainSetup<'a>,
    /// Limit in bytes of the lists of all chunks: beyond it no further cluster is begun.
    pub most_bytes: usize,
    /// True if the first cluster is set up regardless of that limit.
    pub is_first: bool,
    /// Output: the bins and counts of the chunk.
    pub chunk: &'a mut Chunk,
}

/// Distance in clusters of the prefetch.
const AHEAD: usize = 3;

/// Largest number of tiles that a vector of tiny faces is binned to as a whole; beyond, it is
/// binned face by face.
const MOST_TILES: usize = 4;

/// Number of fields that the vector stage passes to the scalar stage, a row of lanes each.
const FIELDS: usize = 16;

impl Kernel for SetupKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let mut lanes = [[0i32; 16]; FIELDS];
        let mut faces = [[0; 8]; 16];
        let view = self.view;
        let (zero, none) = (s.splat(0.0), s.splat_i(0));
        // Covered pixels of tiny faces, lane by lane.
        let mut pixels_in = none;
        let mut done = self.faces;
        for start in (0..self.faces).step_by(S::LANES) {
            if start.is_multiple_of(CLUSTER_FACES)
                && self.chunk.bytes.get() > self.most_bytes
                && !(start == 0 && self.is_first)
            {
                done = start;
                break;
            }
            let count = (self.faces - start).min(S::LANES);
            let visibility =
                self.visibilities.get(start / CLUSTER_FACES).copied().unwrap_or(Visibility::OPEN);
            if visibility != Visibility::OPEN {
                let (stats, count) = (&mut self.chunk.stats, count as u64);
                stats.faces += count;
                match visibility {
                    Visibility::CULLED => stats.faces_culled += count,
                    _ => stats.faces_outside += count,
                }
                continue;
            }
            self.ask_ahead(start);
            let live = s.mask(u32::MAX >> (32 - count));
            let all = s.mask(u32::MAX);
            let c0 = s.load_i(&self.corners[0][start..start + S::LANES]);
            let c1 = s.load_i(&self.corners[1][start..start + S::LANES]);
            let c2 = s.load_i(&self.corners[2][start..start + S::LANES]);
            let r0 = s.gather4(all, self.screen_vertices, c0);
            let r1 = s.gather4(all, self.screen_vertices, c1);
            let r2 = s.gather4(all, self.screen_vertices, c2);
            // A screen vertex without 1/w can only be placed by the plain path.
            let (odd0, odd1, odd2) = (r0[3].bits().eq(none), r1[3].bits().eq(none), r2[3].bits().eq(none));
            let is_odd = live & (odd0 | odd1 | odd2);
            let fits = live & !is_odd;
            let (min_fx, max_fx) = bounds3::<S>(r0[0].bits(), r1[0].bits(), r2[0].bits());
            let (min_fy, max_fy) = bounds3::<S>(r0[1].bits(), r1[1].bits(), r2[1].bits());
            // More than a pixel beyond a side of the clip rectangle, before near or beyond far:
            // counted as the plain path does.
            let (z0, z1, z2) = (r0[2], r1[2], r2[2]);
            let (z_min, z_max) = (z0.min(z1).min(z2), z0.max(z1).max(z2));
            let is_beyond = s.splat_i((view.x0 - 1) << 16).gt(max_fx)
                | min_fx.gt(s.splat_i((view.x1 + 1) << 16))
                | s.splat_i((view.y0 - 1) << 16).gt(max_fy)
                | min_fy.gt(s.splat_i((view.y1 + 1) << 16));
            // In f32 these depths do not tell the side of the far plane.
            let is_at_far = fits & s.splat(1.0).le(z_max) & z_min.le(s.splat(1.0 + 4.0 * f32::EPSILON));
            let outside = fits & !is_at_far & (is_beyond | z_max.lt(zero) | s.splat(1.0).lt(z_min));
            let ((x0, y0), (x1, y1), (x2, y2)) = (snapped(s, r0), snapped(s, r1), snapped(s, r2));
            let (min_x, max_x) = bounds3::<S>(x0, x1, x2);
            let (min_y, max_y) = bounds3::<S>(y0, y1, y2);
            // The sign of the area is exact in i32 for boxes of SMALL_SIDE; larger faces go to the
            // plain set-up.
            let side = s.splat_i((SMALL_SIDE + 1) * 256);
            let is_small = side.gt(max_x - min_x) & side.gt(max_y - min_y);
            let (ux, uy, vx, vy) = (x1 - x0, y1 - y0, x2 - x0, y2 - y0);
            let area = ux * vy - vx * uy;
            let is_clockwise = area.gt(none);
            let is_counter = none.gt(area);
            let kept = match self.winding {
                Winding::CounterClockwise => is_counter,
                Winding::Clockwise => is_clockwise,
                Winding::Both => is_counter | is_clockwise,
            };
            let inside = fits & !outside;
            let sized = inside & is_small & !is_at_far;
            let large = inside & (!is_small | is_at_far);
            let seen = sized & kept;
            let stats = &mut self.chunk.stats;
            let (n_outside, n_seen) = (count_of::<S>(outside), count_of::<S>(seen));
            let n_empty = count_of::<S>(sized & !(is_counter | is_clockwise));
            stats.faces_outside += n_outside;
            stats.faces_drawn += n_seen;
            stats.faces_empty += n_empty;
            stats.faces_culled += count_of::<S>(sized) - n_seen - n_empty;
            stats.faces += count_of::<S>(outside | sized);
            // Behind the eye with all corners, or beyond one plane: the outcode is in place of the
            // position.
            let flags = r0[0].bits() & r1[0].bits() & r2[0].bits();
            let is_all_odd = odd0 & odd1 & odd2;
            let gone = is_odd & is_all_odd & !(flags & s.splat_i(Outcode::OUTSIDE)).eq(none);
            let n_gone = count_of::<S>(gone);
            stats.faces += n_gone;
            stats.faces_outside += n_gone;
            let by_plain = large | (is_odd & !gone);
            // Centres lie at 128 mod 256: the first at or after the low side, the last at or before
            // the high one.
            let left = (min_x + s.splat_i(127)).sar::<8>().max(s.splat_i(view.x0));
            let top = (min_y + s.splat_i(127)).sar::<8>().max(s.splat_i(view.y0));
            let right = (max_x + s.splat_i(128)).sar::<8>().min(s.splat_i(view.x1));
            let bottom = (max_y + s.splat_i(128)).sar::<8>().min(s.splat_i(view.y1));
            let (columns, rows) = (right - left, bottom - top);
            let mut work = seen & columns.gt(none) & rows.gt(none);
            if !(work | by_plain).any() {
                continue;
            }
            // Edge k runs from corner k+1 to k+2; signs are flipped so that the inside is >= 0.
            let px = left.shl::<8>() + s.splat_i(128);
            let py = top.shl::<8>() + s.splat_i(128);
            let (e0, sx0, sy0) = edge(s, is_counter, (x1, y1), (x2, y2), (px, py));
            let (e1, sx1, sy1) = edge(s, is_counter, (x2, y2), (x0, y0), (px, py));
            let (e2, sx2, sy2) = edge(s, is_counter, (x0, y0), (x1, y1), (px, py));
            let tiny_side = s.splat_i(TINY_SIDE + 1);
            let is_tiny = work & tiny_side.gt(columns) & tiny_side.gt(rows);
            let (low, high) =
                coverage(s, is_tiny, (columns, rows), [e0, e1, e2], [sx0, sx1, sx2], [sy0, sy1, sy2]);
            // A tiny face that covers no centre is done.
            work = work & !(is_tiny & (low | high).eq(none));
            if !(work | by_plain).any() {
                continue;
            }
            // Depth plane of the unsnapped face, from its corners in canonical order, so that faces
            // with equal corners in any order get equal planes.
            let [a, b, c] = sort_corners(s, [corner::<S>(r0), corner::<S>(r1), corner::<S>(r2)]);
            let (bx, by, cx, cy) =
                (pixels(s, a[0], b[0]), pixels(s, a[1], b[1]), pixels(s, a[0], c[0]), pixels(s, a[1], c[1]));
            let (za, zb, zc) = (a[2].as_f32(), b[2].as_f32(), c[2].as_f32());
            let (bz, cz) = (zb - za, zc - za);
            let det = bx * cy - cx * by;
            let (zx, zy) = ((bz * cy - cz * by) / det, (cz * bx - bz * cx) / det);
            let half_unit = s.splat(0.5 / 65536.0);
            let from_a =
                (pixels(s, a[0], px.shl::<8>()) - half_unit, pixels(s, a[1], py.shl::<8>()) - half_unit);
            let z = za + (zx * from_a.0 + zy * from_a.1);
            // f32 is enough where the roundings of the slope, times the box, stay below 6e-8.
            let reach2 =
                (bx * bx + by * by).max(cx * cx + cy * cy).max((cx - bx) * (cx - bx) + (cy - by) * (cy - by));
            let rise = bz.abs().max(cz.abs()).max((cz - bz).abs());
            let is_gentle = reach2.le(det.abs() * s.splat(SLENDEREST))
                & reach2.le(det * det * s.splat(1.0 / (THINNEST * THINNEST)))
                & (rise * reach2).le(det.abs() * s.splat(STEEPEST))
                & zero.lt(det.abs())
                & (zx.abs() + zy.abs()).le(s.splat(STEEPEST_SLOPE));
            let is_between = zero.le(z_min) & z_max.lt(s.splat(1.0));
            let by_plain = by_plain | (work & !(is_gentle & is_between));
            let tiny = work & is_tiny & !by_plain;
            let others = (work & !is_tiny) | by_plain;
            pixels_in = pixels_in + ones(s, s.select_i(tiny, low, none));
            let high_words = tiny & !high.eq(none);
            if high_words.any() {
                pixels_in = pixels_in + ones(s, s.select_i(high_words, high, none));
            }
            let words = [
                low,
                high,
                s.iota() + s.splat_i((self.first_face as usize + start) as i32),
                left | top.shl::<16>(),
                z.bits(),
                zx.bits(),
                zy.bits(),
                columns | rows.shl::<8>(),
            ];
            if !others.any() {
                // Most often all lie in one tile, or in two: those get the whole vector.
                let (least, most) = (s.splat_i(i32::MAX), s.splat_i(0));
                let bounds = [
                    s.select_i(tiny, left, least).reduce_min(),
                    s.select_i(tiny, top, least).reduce_min(),
                    s.select_i(tiny, right, most).reduce_max(),
                    s.select_i(tiny, bottom, most).reduce_max(),
                ];
                let tiles = self.grid.tiles_of(bounds);
                let [first_column, first_row, last_column, last_row] = tiles;
                let reach = bounds.map(|bound| bound as i16);
                let few_tiles = (last_column - first_column + 1) * (last_row - first_row + 1) <= MOST_TILES;
                if few_tiles && !(tiny & !fragments::has_few(s, (low, high))).any() {
                    let (vectors, count) = fragments::of(s, tiny, words[2], low, words[3], [z, zx, zy]);
                    bin_fragments(s, self.chunk, &self.grid, &vectors[..count], tiles, reach);
                    continue;
                }
                if (first_column == last_column) & (first_row == last_row) {
                    self.chunk.add_vector(
                        s,
                        tiny,
                        words,
                        first_row * self.grid.columns + first_column,
                        reach,
                    );
                    continue;
                }
                if !few_tiles {
                    let count = s.compress8(tiny, words, &mut faces);
                    for face in &faces[..count] {
                        self.chunk.add_tiny(face, &self.grid);
                    }
                    continue;
                }
                for row in first_row..=last_row {
                    let y0 = self.grid.y0 + row as i32 * Grid::TILE_ROWS;
                    let in_row = tiny & bottom.gt(s.splat_i(y0)) & s.splat_i(y0 + Grid::TILE_ROWS).gt(top);
                    for column in first_column..=last_column {
                        let columns = self.grid.pixels_of(column);
                        let inside =
                            in_row & right.gt(s.splat_i(columns.start)) & s.splat_i(columns.end).gt(left);
                        if inside.any() {
                            self.chunk.add_vector(s, inside, words, row * self.grid.columns + column, reach);
                        }
                    }
                }
                continue;
            }
            s.compress8(tiny, words, &mut faces);
            let fields = [
                e0,
                e1,
                e2,
                sx0,
                sx1,
                sx2,
                sy0,
                sy1,
                sy2,
                z.bits(),
                zx.bits(),
                zy.bits(),
                left,
                top,
                right,
                bottom,
            ];
            let mut field = 0;
            while field < FIELDS {
                s.store_i(fields[field], &mut lanes[field]);
                field += 1;
            }
            let (work_bits, tiny_bits, plain_bits) = (work.bits(), tiny.bits(), by_plain.bits());
            let mut left_over = work_bits | plain_bits;
            let mut next_tiny = 0;
            while left_over != 0 {
                let lane = left_over.trailing_zeros() as usize & 15;
                left_over &= left_over - 1;
                let face = self.first_face + (start + lane) as u32;
                if plain_bits >> lane & 1 != 0 {
                    let mut own = DrawStats::default();
                    let exact_face = (self.plain)(face, &mut own);
                    if let Some(exact_face) = exact_face.filter(|w| !w.bounds.is_empty()) {
                        self.chunk.add_exact(exact_face, &self.grid);
                    }
                    // The vectors' decisions are counted already.
                    if work_bits >> lane & 1 == 0 {
                        self.chunk.stats += own;
                    }
                } else if tiny_bits >> lane & 1 != 0 {
                    self.chunk.add_tiny(&faces[next_tiny & 15], &self.grid);
                    next_tiny += 1;
                } else {
                    self.chunk.add_small(&small_of(&lanes, lane, face), &self.grid);
                }
            }
        }
        self.chunk.done = done;
        s.store_i(pixels_in, &mut lanes[0]);
        for count in &lanes[0][..S::LANES] {
            self.chunk.stats.pixels_tested += *count as u64;
        }
    }
}

impl SetupKernel<'_> {
    /// Prefetches the indices of an open cluster ahead.
    #[inline(always)]
    fn ask_ahead(&self, start: usize) {
        let at = start / CLUSTER_FACES + AHEAD;
        if !start.is_multiple_of(CLUSTER_FACES) || self.visibilities.get(at) != Some(&Visibility::OPEN) {
            return;
        }
        for list in self.corners {
            prefetch::for_read(list, at * CLUSTER_FACES);
        }
    }
}

// Helpers are functions marked for inlining, not closures: a closure would be compiled without the
// level's instructions.

/// Gathers the fields of a lane into a small face.
#[inline(always)]
fn small_of(lanes: &[[i32; 16]; FIELDS], lane: usize, face: u32) -> Small {
    Small {
        face,
        bounds: [
            lanes[12][lane] as i16,
            lanes[13][lane] as i16,
            lanes[14][lane] as i16,
            lanes[15][lane] as i16,
        ],
        edges: [lanes[0][lane], lanes[1][lane], lanes[2][lane]],
        steps_x: [lanes[3][lane], lanes[4][lane], lanes[5][lane]],
        steps_y: [lanes[6][lane], lanes[7][lane], lanes[8][lane]],
        depth: [real(lanes[9][lane]), real(lanes[10][lane]), real(lanes[11][lane])],
    }
}

#[inline(always)]
fn real(bits: i32) -> f32 {
    f32::from_bits(bits as u32)
}

#[inline(always)]
fn count_of<S: Simd>(mask: S::M) -> u64 {
    mask.bits().count_ones() as u64
}

//! Exact faces: set up in f64 by the plain path, where screen vertices or f32 are insufficient
//! (behind the eye, huge, steep).
//!
//! Coverage is by exact spans; depth and barycentrics are linear functions of the pixel, in f64.
//! Along a row both are evaluated in f64 at the first column of each run of 16 columns and in f32
//! from there, so the values do not depend on the vector width.

use super::bins::Grid;
use super::raster::{Tile, write};
use crate::math::coverage::{Filling, PixelRect, SnappedTriangle};
use crate::pipeline::plane_equation::PlaneEquation;
use crate::simd::{F32, I32, Mask, Simd};

/// Columns that share a base value in f64.
const RUN: i32 = 16;

/// Depth slope per column above which depth is evaluated in f64 at every pixel.
const STEEP: f64 = 1.0 / 64.0;

/// Distance from 0 and from 1 within which rounding may put a depth in f32 on the wrong side.
const DEPTH_ROUNDING: f32 = 1e-6;

/// Face set up by the plain path.
#[derive(Clone, Debug)]
pub struct ExactFace {
    /// Index of the triangle in the mesh.
    pub face: u32,
    /// Columns and rows that may hold covered pixels, half-open, inside the clip rectangle.
    pub bounds: PixelRect,
    /// Covered area: the face, or the remains of a clipped one.
    pub outlines: [Option<SnappedTriangle>; 2],
    /// Plane equations of depth and barycentrics over the screen.
    pub plane: PlaneEquation,
    /// True if 0 <= z < 1 at every corner.
    pub is_between: bool,
    /// Nearest and farthest z of the corners; unbounded if the face is clipped. Depth is clamped to
    /// it, also at pixel centres outside the face.
    pub z_range: [f32; 2],
    /// These ranges in f64, of z and of 1 - z.
    pub exact_ranges: [[f64; 2]; 2],
    /// True if some corner has w <= 0: barycentrics may then be negative.
    pub is_cut: bool,
    /// Factors from barycentrics to weights on the screen: each corner's w, or 1 where attributes
    /// are linear on the screen.
    pub corner_w: [f32; 3],
    /// True if the barycentrics' slopes are small enough for f32 along a run of columns.
    pub is_gentle: bool,
    /// True if their slopes are so small that f32 has all the digits that bytes need.
    pub is_smooth: bool,
    /// True if the face is back-facing.
    pub is_back: bool,
    /// True if the face's normals are flipped.
    pub is_normal_flipped: bool,
}

/// Row and columns of a span.
pub(super) type Span = (i32, std::ops::Range<i32>);

/// Number of spans listed before they are drawn: a closure would be compiled without the level's
/// instructions.
pub(super) const SPANS: usize = Grid::TILE_ROWS as usize;

/// Draws a face in a tile; returns the fragments tested and passed.
#[inline(always)]
pub fn draw<S: Simd>(s: S, exact_face: &ExactFace, tile: &mut Tile<'_>) -> (u64, u64) {
    let (mut tested, mut passed) = (0, 0);
    let mut spans: [Span; SPANS] = [const { (0, 0..0) }; SPANS];
    let b = exact_face.bounds;
    let clip = PixelRect {
        x0: b.x0.max(tile.x0),
        y0: b.y0.max(tile.y0),
        x1: b.x1.min(tile.x1),
        y1: b.y1.min(tile.y1),
    };
    for outline in exact_face.outlines.iter().flatten() {
        let count = spans_of(outline, clip, &mut spans);
        for (y, span) in &spans[..count] {
            tested += span.len() as u64;
            passed += row(s, exact_face, *y, span.clone(), tile);
        }
    }
    (tested, passed)
}

/// Largest number of faces that are drawn together over a whole tile.
pub const MOST_STACKED: usize = 24;

/// Returns how much of the tile the face covers, as far as [`stack`] can draw it: `All` requires
/// depths between near and far, too, and a slope that is small enough for f32.
#[inline(always)]
pub fn filling(exact_face: &ExactFace, tile: &Tile<'_>) -> Filling {
    match tile_filling(exact_face, tile) {
        Filling::All if tile.depth.is_empty() || exact_face.plane.z[1].abs() > STEEP => Filling::Part,
        filling => filling,
    }
}

/// Returns how much of the tile the face covers: `All` requires depths between near and far, and
/// whole vectors.
#[inline(always)]
pub(super) fn tile_filling(exact_face: &ExactFace, tile: &Tile<'_>) -> Filling {
    let [Some(outline), None] = &exact_face.outlines else { return Filling::Part };
    let b = exact_face.bounds;
    let clip = PixelRect { x0: tile.x0, y0: tile.y0, x1: tile.x1, y1: tile.y1 };
    let holds = b.x0 <= clip.x0 && b.x1 >= clip.x1 && b.y0 <= clip.y0 && b.y1 >= clip.y1;
    let is_even = (clip.x0 | clip.x1) & (RUN - 1) == 0;
    match outline.filling(clip) {
        Filling::All if !(holds && is_even && exact_face.is_between) => Filling::Part,
        filling => filling,
    }
}

/// Draws faces that fill the tile, in order, and returns how many fragments passed. A pixel's depth
/// and face stay in registers until all faces are tested.
#[inline(always)]
pub fn stack<S: Simd>(s: S, faces: &[&ExactFace], tile: &mut Tile<'_>) -> u64 {
    let count = faces.len().min(MOST_STACKED);
    let faces = &faces[..count];
    let (x0, width) = (tile.x0, (tile.x1 - tile.x0) as usize);
    let mut ids = [0; MOST_STACKED];
    // Bounds as `depths` and its callers apply them; + 0.0 makes a zero positive, as its bits have
    // to be.
    let (mut low, mut high, mut slope) = ([0f32; MOST_STACKED], [0f32; MOST_STACKED], [0f32; MOST_STACKED]);
    let mut is_level = true;
    for (i, face) in faces.iter().enumerate() {
        ids[i] = face.face as i32 | super::resolve::EXACT_FACE_BIT;
        low[i] = face.z_range[0].max(0.0) + 0.0;
        high[i] = face.z_range[1].max(0.0) + 0.0;
        slope[i] = face.plane.z[1] as f32;
        is_level &= face.plane.z[1] == 0.0;
    }
    let mut passed = 0;
    for y in tile.y0..tile.y1 {
        let (at, depth_at) = (tile.id_at(x0, y), tile.depth_at(x0, y));
        let row_ids = &mut tile.ids[at..at + width];
        let row_depth = &mut tile.depth[depth_at..depth_at + width];
        let mut base = [0f32; MOST_STACKED];
        let mut level = [0i32; MOST_STACKED];
        if is_level {
            for (i, face) in faces.iter().enumerate() {
                let z = face.plane.z_at(x0, y) as f32;
                level[i] = clamp(z, low[i], high[i]).to_bits() as i32;
            }
        }
        let mut column = 0;
        while column < width {
            let old = &mut row_depth[column..column + S::LANES];
            let own = &mut row_ids[column..column + S::LANES];
            let (mut z, mut id) = (s.load_i(old), s.load_i(own));
            if is_level {
                let mut i = 0;
                while i < count {
                    let new = s.splat_i(level[i]);
                    let passes = z.gt(new);
                    (z, id) = (z.min(new), s.select_i(passes, s.splat_i(ids[i]), id));
                    passed += passes.bits().count_ones() as u64;
                    i += 1;
                }
            } else {
                let in_run = column as i32 & (RUN - 1);
                if in_run == 0 {
                    for (i, face) in faces.iter().enumerate() {
                        base[i] = face.plane.z_at(x0 + column as i32, y) as f32;
                    }
                }
                let along = (s.iota() + s.splat_i(in_run)).to_f32();
                let mut i = 0;
                while i < count {
                    let new = s.splat(base[i]) + s.splat(slope[i]) * along;
                    let new = new.max(s.splat(low[i])).min(s.splat(high[i])).bits();
                    let passes = z.gt(new);
                    (z, id) = (z.min(new), s.select_i(passes, s.splat_i(ids[i]), id));
                    passed += passes.bits().count_ones() as u64;
                    i += 1;
                }
            }
            s.store_i(z, old);
            s.store_i(id, own);
            column += S::LANES;
        }
    }
    passed
}

/// Clamps like the vectors' `max` and `min`.
#[inline(always)]
fn clamp(z: f32, low: f32, high: f32) -> f32 {
    let z = if z > low { z } else { low };
    if z < high { z } else { high }
}

/// Lists the spans of an outline within `clip`; returns their number.
pub(super) fn spans_of(outline: &SnappedTriangle, clip: PixelRect, spans: &mut [Span; SPANS]) -> usize {
    let mut count = 0;
    match outline.filling(clip) {
        Filling::None => {}
        Filling::All => {
            while (count as i32) < clip.y1 - clip.y0 {
                spans[count] = (clip.y0 + count as i32, clip.x0..clip.x1);
                count += 1;
            }
        }
        Filling::Part => outline.for_each_span(clip, |y, span| {
            spans[count] = (y, span);
            count += 1;
        }),
    }
    count
}

/// Draws one span in vectors aligned to their width, the first and the last in part. Returns the
/// fragments passed.
#[inline(always)]
fn row<S: Simd>(
    s: S,
    exact_face: &ExactFace,
    y: i32,
    span: std::ops::Range<i32>,
    tile: &mut Tile<'_>,
) -> u64 {
    let lanes = S::LANES as i32;
    // The last vector of a row that is no multiple of its width starts further left.
    let last_whole = tile.x1 & !(lanes - 1);
    let mut passed = 0;
    let mut x = span.start;
    while x < span.end {
        let start = x & !(lanes - 1);
        let is_whole = start == x && exact_face.is_between;
        let until = span.end.min(last_whole) & !(lanes - 1);
        if is_whole && until > start {
            passed += full_run(s, exact_face, (start, y), (until - start) as usize, tile);
            x = until;
            continue;
        }
        let start = start.min(tile.x1 - lanes);
        let z = depths(s, exact_face, start, y);
        let (from, to) = (x - start, (span.end - start).min(lanes));
        let mut inside = s.mask((u32::MAX << from) & (((1u64 << to) - 1) as u32));
        if !exact_face.is_between {
            inside = inside & between_near_and_far(s, exact_face, z, start, y);
        }
        let z = z.max(s.splat(0.0)).bits();
        let id = s.splat_i(exact_face.face as i32 | super::resolve::EXACT_FACE_BIT);
        passed += write(s, tile, (start, y), inside, z, id);
        x = start + lanes;
    }
    passed
}

/// Returns where LANES pixels from (x, y) on, of depths `z`, lie between near (included) and far
/// (excluded): as f64 says wherever f32 may be wrong.
#[inline(always)]
pub(super) fn between_near_and_far<S: Simd>(s: S, exact_face: &ExactFace, z: S::F, x: i32, y: i32) -> S::M {
    let (zero, one) = (s.splat(0.0), s.splat(1.0));
    let inside = zero.le(z) & z.lt(one);
    let near_either = z.abs().lt(s.splat(DEPTH_ROUNDING)) | (z - one).abs().lt(s.splat(DEPTH_ROUNDING));
    let mut left = near_either.bits();
    if left == 0 {
        return inside;
    }
    let mut bits = inside.bits();
    while left != 0 {
        let lane = left.trailing_zeros();
        left &= left - 1;
        let is_inside =
            exact_face.plane.is_between_near_and_far(exact_face.exact_ranges[0], x + lane as i32, y);
        bits = (bits & !(1 << lane)) | (u32::from(is_inside) << lane);
    }
    s.mask(bits)
}

/// Draws `count` columns from (x, y) on, all covered, in whole vectors. Returns the fragments
/// passed.
#[inline(always)]
fn full_run<S: Simd>(
    s: S,
    exact_face: &ExactFace,
    (x, y): (i32, i32),
    count: usize,
    tile: &mut Tile<'_>,
) -> u64 {
    let id = s.splat_i(exact_face.face as i32 | super::resolve::EXACT_FACE_BIT);
    let (at, depth_at) = (tile.id_at(x, y), tile.depth_at(x, y));
    let ids = &mut tile.ids[at..at + count];
    let mut passed = 0;
    if tile.depth.is_empty() {
        for ids in ids.chunks_exact_mut(S::LANES) {
            s.store_i(id, ids);
        }
        return count as u64;
    }
    let depth = &mut tile.depth[depth_at..depth_at + count];
    let is_level = exact_face.plane.z[1] == 0.0;
    let constant = depths(s, exact_face, x, y).max(s.splat(0.0)).bits();
    let mut column = x;
    for (depth, ids) in depth.chunks_exact_mut(S::LANES).zip(ids.chunks_exact_mut(S::LANES)) {
        let z = match is_level {
            true => constant,
            false => depths(s, exact_face, column, y).max(s.splat(0.0)).bits(),
        };
        let old = s.load_i(depth);
        let passes = old.gt(z);
        s.store_i(s.select_i(passes, z, old), depth);
        s.store_i(s.select_i(passes, id, s.load_i(ids)), ids);
        passed += passes.bits().count_ones() as u64;
        column += S::LANES as i32;
    }
    passed
}

/// Returns the depths at LANES pixels from (x, y) on, with values that depend neither on the vector
/// width nor on its alignment.
#[inline(always)]
pub(super) fn depths<S: Simd>(s: S, exact_face: &ExactFace, x: i32, y: i32) -> S::F {
    let zx = exact_face.plane.z[1];
    let (low, high) = (s.splat(exact_face.z_range[0]), s.splat(exact_face.z_range[1]));
    if zx.abs() <= STEEP && x & (S::LANES as i32 - 1) == 0 {
        let base = x & !(RUN - 1);
        let along = (s.iota() + s.splat_i(x - base)).to_f32();
        let z = s.splat(exact_face.plane.z_at(base, y) as f32) + s.splat(zx as f32) * along;
        return z.max(low).min(high);
    }
    let mut lanes = [0f32; 16];
    for (i, d) in lanes[..S::LANES].iter_mut().enumerate() {
        let column = x + i as i32;
        *d = match zx.abs() <= STEEP {
            true => {
                let base = column & !(RUN - 1);
                exact_face.plane.z_at(base, y) as f32 + zx as f32 * (column - base) as f32
            }
            false => exact_face.plane.z_at(column, y) as f32,
        };
    }
    s.load(&lanes[..S::LANES]).max(low).min(high)
}

/// Returns the barycentrics b of an exact face at LANES pixels from (x, y) on: b / sum(b) are the
/// corners' weights, 1 / sum(b) is w.
#[inline(always)]
pub fn weights<S: Simd>(s: S, exact_face: &ExactFace, x: i32, y: i32) -> [S::F; 3] {
    if exact_face.is_gentle && x & (S::LANES as i32 - 1) == 0 {
        let base = x & !(RUN - 1);
        let along = (s.iota() + s.splat_i(x - base)).to_f32();
        let barycentrics = &exact_face.plane.barycentrics;
        let (g0, g1, g2) = (barycentrics[0][1] as f32, barycentrics[1][1] as f32, barycentrics[2][1] as f32);
        return [
            s.splat(exact_face.plane.barycentric_at(0, base, y) as f32) + s.splat(g0) * along,
            s.splat(exact_face.plane.barycentric_at(1, base, y) as f32) + s.splat(g1) * along,
            s.splat(exact_face.plane.barycentric_at(2, base, y) as f32) + s.splat(g2) * along,
        ];
    }
    let mut out = [s.splat(0.0); 3];
    let mut lanes = [0f32; 16];
    for (k, b) in out.iter_mut().enumerate() {
        let gradient = exact_face.plane.barycentrics[k][1] as f32;
        for (i, lane) in lanes[..S::LANES].iter_mut().enumerate() {
            let column = x + i as i32;
            let base = column & !(RUN - 1);
            *lane = match exact_face.is_gentle {
                true => {
                    exact_face.plane.barycentric_at(k, base, y) as f32 + gradient * (column - base) as f32
                }
                false => exact_face.plane.barycentric_at(k, column, y) as f32,
            };
        }
        *b = s.load(&lanes[..S::LANES]);
    }
    out
}

/// Returns the corners' weights at LANES pixels from (x, y) on, computed in f64, and the lanes
/// beside the face, which the plain path must compute.
#[inline(always)]
pub(super) fn exact_barycentrics<S: Simd>(s: S, exact_face: &ExactFace, x: i32, y: i32) -> ([S::F; 3], S::M) {
    let mut b = [[0.0f64; 16]; 3];
    for (k, lanes) in b.iter_mut().enumerate() {
        for (i, lane) in lanes[..S::LANES].iter_mut().enumerate() {
            *lane = exact_face.plane.barycentric_at(k, x + i as i32, y);
        }
    }
    let mut out = [[0f32; 16]; 3];
    let mut inside = 0u32;
    for i in 0..S::LANES {
        let sum = b[0][i] + b[1][i] + b[2][i];
        let is_inside = b[0][i] >= 0.0 && b[1][i] >= 0.0 && b[2][i] >= 0.0 && sum > 0.0;
        inside |= (is_inside as u32) << i;
        for k in 0..3 {
            out[k][i] = (b[k][i] / sum) as f32;
        }
    }
    (out.map(|lanes| s.load(&lanes[..S::LANES])), !s.mask(inside))
}

/// Clamps barycentrics as the plain path does, where a centre lies beside the face: the weights on
/// the screen to 0..1, rescaled to a sum of 1. Inside the face they are unchanged.
#[inline(always)]
pub fn clamped<S: Simd>(s: S, exact_face: &ExactFace, b: [S::F; 3]) -> [S::F; 3] {
    let (zero, one) = (s.splat(0.0), s.splat(1.0));
    let is_beside = b[0].lt(zero) | b[1].lt(zero) | b[2].lt(zero);
    if !is_beside.any() {
        return b;
    }
    let w =
        [s.splat(exact_face.corner_w[0]), s.splat(exact_face.corner_w[1]), s.splat(exact_face.corner_w[2])];
    let share = [
        (b[0] * w[0]).max(zero).min(one),
        (b[1] * w[1]).max(zero).min(one),
        (b[2] * w[2]).max(zero).min(one),
    ];
    let sum = (share[0] + share[1]) + share[2];
    [
        s.select(is_beside, share[0] / (sum * w[0]), b[0]),
        s.select(is_beside, share[1] / (sum * w[1]), b[1]),
        s.select(is_beside, share[2] / (sum * w[2]), b[2]),
    ]
}

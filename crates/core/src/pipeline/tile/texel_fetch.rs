//! Texel fetches from a texture's levels, a vector of pixels at a time: addresses and
//! interpolation.
//!
//! Coordinates are without whole repeats, in 0..=1 where they repeat. NaN coordinates have no
//! address: callers leave such lanes out of fetches in fixed point, the other fetches return any
//! texel.

use super::lighting::{V3, scale};
use crate::scene::{FIXED_LEVELS, FixedLevels, LevelTexels, Sampling, Texture, Wrap};
use crate::simd::{F32, I32, Mask, Simd, prefetch};

/// Mip levels in fixed point, tabulated once for each draw because every vector uses them. Entry n
/// of a table is that of level n, from 1 on.
#[derive(Clone, Copy, Debug)]
pub struct FixedPointMips<'a> {
    texels: &'a [[u16; 4]],
    /// Number of such levels, from level 1 on.
    pub count: u32,
    widths: [i32; 8],
    heights: [i32; 8],
    /// Index of each level's lowest row: rows are stored from the top.
    lowest_rows: [i32; 8],
}

/// Every such level has an entry in the tables.
const _: () = assert!(FIXED_LEVELS < 8);

impl<'a> FixedPointMips<'a> {
    /// Tabulates the levels of a texture.
    pub fn new(levels: FixedLevels<'a>) -> Self {
        let FixedLevels { texels, levels, count } = levels;
        let (mut widths, mut heights, mut lowest_rows) = ([1; 8], [1; 8], [0; 8]);
        for (i, (w, h, start)) in levels.into_iter().enumerate() {
            (widths[i + 1], heights[i + 1]) = (w as i32, h as i32);
            lowest_rows[i + 1] = start as i32 + (h as i32 - 1) * (w as i32 + 1);
        }
        Self { texels, count, widths, heights, lowest_rows }
    }

    /// Returns the 2x2 texels around coordinates without whole repeats, each lane's in its own
    /// level. Lanes whose level is not in fixed point have meaningless addresses.
    #[inline(always)]
    pub fn quad<S: Simd>(&self, s: S, sampling: Sampling, at: [S::F; 2], number: S::I) -> TexelQuad<S> {
        let (w, h) = (s.lookup(&self.widths, number), s.lookup(&self.heights, number));
        let near = neighbours(s, sampling, at, (w, h));
        // Each row repeats its first texel at its end.
        let stride = w + s.splat_i(1);
        let base = s.lookup(&self.lowest_rows, number) + near.i[0];
        TexelQuad { at: [base - near.j[0] * stride, base - near.j[1] * stride], part: near.part }
    }

    /// Interpolates four texels, in units of 1/256 of 0..255.
    #[inline(always)]
    pub fn bilinear<S: Simd>(&self, s: S, mask: S::M, quad: &TexelQuad<S>) -> V3<S> {
        let a = fixed_pair(s, mask, self.texels, quad.at[0]);
        let b = fixed_pair(s, mask, self.texels, quad.at[1]);
        blend::<S>(a, b, quad.part)
    }

    /// Prefetches the texels of both rows.
    #[inline(always)]
    pub fn ask_for<S: Simd>(&self, s: S, quad: &TexelQuad<S>) {
        let mut row = 0;
        while row < 2 {
            let mut places = [0; 16];
            s.store_i(quad.at[row], &mut places[..S::LANES]);
            let mut lane = 0;
            while lane < S::LANES {
                prefetch::for_read(self.texels, places[lane] as u32 as usize);
                lane += 1;
            }
            row += 1;
        }
    }
}

/// Four texels of a level in fixed point: the addresses of each row's pair, and the interpolation
/// weights.
#[derive(Clone, Copy)]
pub struct TexelQuad<S: Simd> {
    at: [S::I; 2],
    part: [S::F; 2],
}

impl<S: Simd> TexelQuad<S> {
    /// Returns a quad without meaningful addresses.
    #[inline(always)]
    pub fn none(s: S) -> Self {
        Self { at: [s.splat_i(0); 2], part: [s.splat(0.0); 2] }
    }
}

/// Texels around a point of a level, and the weights of the second texel on each axis.
struct Neighbours<S: Simd> {
    i: [S::I; 2],
    j: [S::I; 2],
    part: [S::F; 2],
}

/// Returns the texels around coordinates in a level of this width and height.
#[inline(always)]
fn neighbours<S: Simd>(s: S, sampling: Sampling, [u, v]: [S::F; 2], (w, h): (S::I, S::I)) -> Neighbours<S> {
    let (i, across) = around(s, u, sampling.wrap_s, w);
    let (j, up) = around(s, v, sampling.wrap_t, h);
    Neighbours { i, j, part: [across, up] }
}

/// Returns the two texels around a coordinate without whole repeats, on an axis of `size` texels,
/// and the weight of the second. Beyond a clamped edge that weight is 0, as if the second were the
/// first again.
#[inline(always)]
fn around<S: Simd>(s: S, coordinate: S::F, wrap: Wrap, size: S::I) -> ([S::I; 2], S::F) {
    let (none, one) = (s.splat_i(0), s.splat_i(1));
    let width = size.to_f32();
    let texels = coordinate * width - s.splat(0.5);
    match wrap {
        Wrap::Repeat => {
            let floor = texels.floor();
            // From -1 to size - 1: only the first texel can lie before the texture, only the second
            // behind it.
            let first = floor.to_i32();
            let second = first + one;
            let around =
                [s.select_i(none.gt(first), first + size, first), s.select_i(second.eq(size), none, second)];
            (around, texels - floor)
        }
        Wrap::Clamp => {
            let texels = texels.max(s.splat(0.0)).min(width - s.splat(1.0));
            let floor = texels.floor();
            let first = floor.to_i32();
            ([first, (first + one).min(size - one)], texels - floor)
        }
    }
}

/// Interpolates two texels of each of two rows by the weights `part`.
#[inline(always)]
fn blend<S: Simd>(a: [V3<S>; 2], b: [V3<S>; 2], part: [S::F; 2]) -> V3<S> {
    let (a, b) = (between::<S>(a[0], a[1], part[0]), between::<S>(b[0], b[1], part[0]));
    between::<S>(a, b, part[1])
}

/// Returns the texel in which coordinates without whole repeats lie, in 0..255.
#[inline(always)]
pub fn nearest<S: Simd>(s: S, mask: S::M, texture: &Texture, sampling: Sampling, [u, v]: [S::F; 2]) -> V3<S> {
    let (w, h) = (s.splat_i(texture.width() as i32), s.splat_i(texture.height() as i32));
    let i = in_texels(s, u, sampling.wrap_s, w).floor().to_i32();
    let j = in_texels(s, v, sampling.wrap_t, h).floor().to_i32();
    let (i, j) = (wrapped(s, i, sampling.wrap_s, w), wrapped(s, j, sampling.wrap_t, h));
    // Rows are stored from the top.
    let at = (h - s.splat_i(1) - j) * w + i;
    channels(s, s.gather_bytes(mask, texture.bytes(), at))
}

#[inline(always)]
fn in_texels<S: Simd>(s: S, coordinate: S::F, wrap: Wrap, size: S::I) -> S::F {
    let size = size.to_f32();
    let texels = coordinate * size;
    match wrap {
        Wrap::Repeat => texels,
        Wrap::Clamp => texels.max(s.splat(-1.0)).min(size + s.splat(1.0)),
    }
}

/// Returns an index that is at most one size beyond the texture, wrapped or clamped into it.
#[inline(always)]
fn wrapped<S: Simd>(s: S, texel: S::I, wrap: Wrap, size: S::I) -> S::I {
    let none = s.splat_i(0);
    let highest = size - s.splat_i(1);
    let texel = match wrap {
        Wrap::Repeat => {
            let texel = s.select_i(none.gt(texel), texel + size, texel);
            s.select_i(texel.gt(highest), texel - size, texel)
        }
        Wrap::Clamp => texel,
    };
    // Lanes that are not used must stay in bounds, too.
    texel.max(none).min(highest)
}

/// Interpolates four texels, in one level for all lanes, in 0..255.
#[inline(always)]
pub fn bilinear<S: Simd>(
    s: S,
    mask: S::M,
    texture: &Texture,
    sampling: Sampling,
    at: [S::F; 2],
    level: u32,
) -> V3<S> {
    let (w, h) = texture.level_size(level);
    let near = neighbours(s, sampling, at, (s.splat_i(w as i32), s.splat_i(h as i32)));
    let (a, unit) = pair(s, mask, texture, level, near.i, near.j[0]);
    let (b, _) = pair(s, mask, texture, level, near.i, near.j[1]);
    scale::<S>(blend::<S>(a, b, near.part), s.splat(unit))
}

/// Returns texels i0 and i1 of row j (counted from below), and the unit of their channels.
#[inline(always)]
fn pair<S: Simd>(
    s: S,
    mask: S::M,
    texture: &Texture,
    level: u32,
    [i0, i1]: [S::I; 2],
    j: S::I,
) -> ([V3<S>; 2], f32) {
    let (w, h) = texture.level_size(level);
    // Rows are stored from the top.
    let row = s.splat_i(h as i32 - 1) - j;
    match texture.level_texels(level) {
        LevelTexels::Fixed(texels) => {
            let at = inside(s, row * s.splat_i(w as i32 + 1) + i0, texels.len() - 1);
            (fixed_pair(s, mask, texels, at), 1.0 / 256.0)
        }
        LevelTexels::Bytes(bytes) if !(mask & !i1.eq(i0 + s.splat_i(1))).any() && w > 1 => {
            let at = inside(s, row * s.splat_i(w as i32) + i0, bytes.len() / 4 - 1);
            let [left, right] = s.gather_byte_pairs(mask, bytes, at);
            ([channels(s, left), channels(s, right)], 1.0)
        }
        LevelTexels::Bytes(bytes) => {
            let (at, count) = (row * s.splat_i(w as i32), bytes.len() / 4);
            let left = s.gather_bytes(mask, bytes, inside(s, at + i0, count));
            let right = s.gather_bytes(mask, bytes, inside(s, at + i1, count));
            ([channels(s, left), channels(s, right)], 1.0)
        }
        LevelTexels::Float(texels) => {
            let (at, count) = (row * s.splat_i(w as i32), texels.len());
            let [r0, g0, b0, _] = s.gather4(mask, texels, inside(s, at + i0, count));
            let [r1, g1, b1, _] = s.gather4(mask, texels, inside(s, at + i1, count));
            ([[r0, g0, b0], [r1, g1, b1]], 1.0)
        }
    }
}

/// Returns a texel in fixed point and the next one; after the last of a row its first again.
#[inline(always)]
fn fixed_pair<S: Simd>(s: S, mask: S::M, texels: &[[u16; 4]], at: S::I) -> [V3<S>; 2] {
    let [rg0, ba0, rg1, ba1] = s.gather_pairs(mask, texels, at);
    let low = s.splat_i(0xffff);
    [
        [(rg0 & low).to_f32(), rg0.shr::<16>().to_f32(), (ba0 & low).to_f32()],
        [(rg1 & low).to_f32(), rg1.shr::<16>().to_f32(), (ba1 & low).to_f32()],
    ]
}

/// Clamps an index to `count` elements: NaN coordinates get any element.
#[inline(always)]
fn inside<S: Simd>(s: S, at: S::I, count: usize) -> S::I {
    at.max(s.splat_i(0)).min(s.splat_i((count - 1) as i32))
}

/// Unpacks R, G, B of packed bytes.
#[inline(always)]
fn channels<S: Simd>(s: S, rgba: S::I) -> V3<S> {
    let low = s.splat_i(255);
    [(rgba & low).to_f32(), (rgba.shr::<8>() & low).to_f32(), (rgba.shr::<16>() & low).to_f32()]
}

/// Interpolates linearly from a to b.
#[inline(always)]
pub fn between<S: Simd>(a: V3<S>, b: V3<S>, t: S::F) -> V3<S> {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}

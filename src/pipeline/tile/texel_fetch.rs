//! Texels of a texture's levels, a vector of pixels at a time: where they are, and what lies between them.
//!
//! Coordinates come without whole turns, in 0..=1 where they repeat. One that is no number has no place: whoever asks for
//! places in fixed point leaves such lanes out, the other ways give any texel.

use super::lighting::{V3, scale};
use crate::scene::{FIXED_LEVELS, FixedLevels, LevelTexels, Sampling, Texture, Wrap};
use crate::simd::{F32, I32, Mask, Simd, prefetch};

/// Levels in fixed point, found once a draw because every vector asks for them. Entry n of a table is level n's, from 1
/// on.
#[derive(Clone, Copy, Debug)]
pub struct FixedPointMips<'a> {
    texels: &'a [[u16; 4]],
    /// They are levels 1 to so many.
    pub count: u32,
    widths: [i32; 8],
    heights: [i32; 8],
    /// Where the lowest row begins: rows are stored from the top.
    lowest_rows: [i32; 8],
}

/// Every such level has its entry.
const _: () = assert!(FIXED_LEVELS < 8);

impl<'a> FixedPointMips<'a> {
    /// Of a texture.
    pub fn new(levels: FixedLevels<'a>) -> Self {
        let FixedLevels { texels, levels, count } = levels;
        let (mut widths, mut heights, mut lowest_rows) = ([1; 8], [1; 8], [0; 8]);
        for (i, (w, h, start)) in levels.into_iter().enumerate() {
            (widths[i + 1], heights[i + 1]) = (w as i32, h as i32);
            lowest_rows[i + 1] = start as i32 + (h as i32 - 1) * (w as i32 + 1);
        }
        Self { texels, count, widths, heights, lowest_rows }
    }

    /// The square around coordinates without whole turns, each lane's in its own level. Where that is not one in fixed point
    /// the places mean nothing.
    #[inline(always)]
    pub fn quad<S: Simd>(&self, s: S, sampling: Sampling, at: [S::F; 2], number: S::I) -> TexelQuad<S> {
        let (w, h) = (s.lookup(&self.widths, number), s.lookup(&self.heights, number));
        let near = neighbours(s, sampling, at, (w, h));
        // Each row has its first texel once more at its end.
        let stride = w + s.splat_i(1);
        let base = s.lookup(&self.lowest_rows, number) + near.i[0];
        TexelQuad { at: [base - near.j[0] * stride, base - near.j[1] * stride], part: near.part }
    }

    /// In 1/256 of 0..255.
    #[inline(always)]
    pub fn bilinear<S: Simd>(&self, s: S, mask: S::M, quad: &TexelQuad<S>) -> V3<S> {
        let a = fixed_pair(s, mask, self.texels, quad.at[0]);
        let b = fixed_pair(s, mask, self.texels, quad.at[1]);
        blend::<S>(a, b, quad.part)
    }

    /// Says that both rows' texels will be read soon.
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

/// Four texels of a level in fixed point: where the two of each row begin, and how far on the way between them.
#[derive(Clone, Copy)]
pub struct TexelQuad<S: Simd> {
    at: [S::I; 2],
    part: [S::F; 2],
}

impl<S: Simd> TexelQuad<S> {
    /// Nowhere.
    #[inline(always)]
    pub fn none(s: S) -> Self {
        Self { at: [s.splat_i(0); 2], part: [s.splat(0.0); 2] }
    }
}

/// The texels around a point of a level, and how far it lies on the way from the first to the second of each axis.
struct Neighbours<S: Simd> {
    i: [S::I; 2],
    j: [S::I; 2],
    part: [S::F; 2],
}

/// Of a level of this width and height.
#[inline(always)]
fn neighbours<S: Simd>(s: S, sampling: Sampling, [u, v]: [S::F; 2], (w, h): (S::I, S::I)) -> Neighbours<S> {
    let (i, across) = around(s, u, sampling.wrap_s, w);
    let (j, up) = around(s, v, sampling.wrap_t, h);
    Neighbours { i, j, part: [across, up] }
}

/// The two texels around a coordinate without whole turns, along an axis of so many. Beyond an edge that is clamped the way
/// to the second is 0, as if it were the first once more.
#[inline(always)]
fn around<S: Simd>(s: S, coordinate: S::F, wrap: Wrap, size: S::I) -> ([S::I; 2], S::F) {
    let (none, one) = (s.splat_i(0), s.splat_i(1));
    let width = size.to_f32();
    let texels = coordinate * width - s.splat(0.5);
    match wrap {
        Wrap::Repeat => {
            let floor = texels.floor();
            // From -1 to size - 1: only the first one can lie before the texture, only the second one behind it.
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

/// Two texels of the one row and two of the other, as far as `part` says on the way between them.
#[inline(always)]
fn blend<S: Simd>(a: [V3<S>; 2], b: [V3<S>; 2], part: [S::F; 2]) -> V3<S> {
    let (a, b) = (between::<S>(a[0], a[1], part[0]), between::<S>(b[0], b[1], part[0]));
    between::<S>(a, b, part[1])
}

/// The texel that coordinates without whole turns lie in, in 0..255.
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

/// A texel's number that is at most one size beyond the texture.
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
    // Whatever a lane that nobody looks at holds, it stays inside.
    texel.max(none).min(highest)
}

/// Between four texels, all lanes' in the same level, in 0..255.
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

/// Texels i0 and i1 of row j (counted from below), and what they are counted in.
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

/// A texel in fixed point and the one behind it: behind the last of a row its first again.
#[inline(always)]
fn fixed_pair<S: Simd>(s: S, mask: S::M, texels: &[[u16; 4]], at: S::I) -> [V3<S>; 2] {
    let [rg0, ba0, rg1, ba1] = s.gather_pairs(mask, texels, at);
    let low = s.splat_i(0xffff);
    [
        [(rg0 & low).to_f32(), rg0.shr::<16>().to_f32(), (ba0 & low).to_f32()],
        [(rg1 & low).to_f32(), rg1.shr::<16>().to_f32(), (ba1 & low).to_f32()],
    ]
}

/// A place among so many: where coordinates are no numbers, any.
#[inline(always)]
fn inside<S: Simd>(s: S, at: S::I, count: usize) -> S::I {
    at.max(s.splat_i(0)).min(s.splat_i((count - 1) as i32))
}

/// R, G, B of packed bytes.
#[inline(always)]
fn channels<S: Simd>(s: S, rgba: S::I) -> V3<S> {
    let low = s.splat_i(255);
    [(rgba & low).to_f32(), (rgba.shr::<8>() & low).to_f32(), (rgba.shr::<16>() & low).to_f32()]
}

/// So far on the way from the one to the other.
#[inline(always)]
pub fn between<S: Simd>(a: V3<S>, b: V3<S>, t: S::F) -> V3<S> {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}

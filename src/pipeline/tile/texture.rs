//! Textures, a vector of pixels at a time: the twin of `pipeline::sample`, in f32.
//!
//! Coordinates come as a corner's, in two parts, and the way from it: whole turns are dropped before the digits are.

use super::light::{V3, log2, splat3};
use crate::scene::{Filter, FixedLevels, LevelTexels, Sampling, Texture, Wrap};
use crate::simd::{F32, I32, Mask, Simd};

/// Within this of a level's edge `mipmap` asks the plain path: the level is found to about 1e-4.
const LEVEL_EDGE: f32 = 1e-3;

/// A texture and its rules.
#[derive(Clone, Copy, Debug)]
pub struct TextureShade<'a> {
    /// The texture, without transparent texels.
    pub texture: &'a Texture,
    /// The rules.
    pub sampling: Sampling,
}

impl TextureShade<'_> {
    /// Whether the filter looks at levels.
    #[inline(always)]
    pub fn needs_level(&self) -> bool {
        matches!(self.sampling.filter, Filter::Mipmap | Filter::Trilinear)
    }
}

/// How far u, v move to the pixel on the right and to the one below.
pub struct Footprint<S: Simd> {
    /// To (x + 1, y).
    pub right: [S::F; 2],
    /// To (x, y + 1).
    pub below: [S::F; 2],
    /// Where one of them lies beyond the horizon.
    pub is_horizon: S::M,
}

/// R, G, B in 0..1 at `origin` (u, v, and what f32 lost of them) + `away`, and where f32 lacks the digits.
#[inline(always)]
pub fn sample<S: Simd>(
    s: S,
    mask: S::M,
    shade: &TextureShade<'_>,
    origin: [[S::F; 2]; 2],
    away: [S::F; 2],
    footprint: Option<Footprint<S>>,
) -> (V3<S>, S::M) {
    let (texture, sampling) = (shade.texture, shade.sampling);
    let u = turns(s, origin[0][0], origin[1][0], away[0], sampling.wrap_s);
    let v = turns(s, origin[0][1], origin[1][1], away[1], sampling.wrap_t);
    let mut delicate = s.mask(0);
    let last = texture.level_count() - 1;
    let scale = s.splat(1.0 / 255.0);
    let texel = match (sampling.filter, footprint) {
        (Filter::Nearest, _) => {
            let (w, h) = (s.splat_i(texture.width() as i32), s.splat_i(texture.height() as i32));
            let i = wrapped(s, in_texels(s, u, sampling.wrap_s, w).floor().to_i32(), sampling.wrap_s, w);
            let j = wrapped(s, in_texels(s, v, sampling.wrap_t, h).floor().to_i32(), sampling.wrap_t, h);
            // Rows are stored from the top.
            let at = (h - s.splat_i(1) - j) * w + i;
            channels(s, s.gather_bytes(mask, texture.bytes(), at))
        }
        (Filter::Mipmap | Filter::Trilinear, Some(footprint)) => {
            let (w, h) = (s.splat(texture.width() as f32), s.splat(texture.height() as f32));
            let longer = length2::<S>(footprint.right, w, h).max(length2::<S>(footprint.below, w, h));
            let d = s.splat(0.5) * log2(s, longer);
            let d = s.select(footprint.is_horizon, s.splat(100.0), d);
            let top = s.splat(last as f32);
            if sampling.filter == Filter::Mipmap {
                let at = d + s.splat(0.5);
                let part = at - at.floor();
                let is_edge = part.lt(s.splat(LEVEL_EDGE)) | s.splat(1.0 - LEVEL_EDGE).lt(part);
                delicate = mask & is_edge & s.splat(0.5).lt(at);
                let level = at.floor().max(s.splat(0.0)).min(top);
                levels(s, mask, shade, u, v, level, None, last)
            } else {
                let d = d.max(s.splat(0.0)).min(top);
                let near = d.floor();
                levels(s, mask, shade, u, v, near, Some(d - near), last)
            }
        }
        _ => bilinear(s, mask, shade, u, v, 0),
    };
    ([texel[0] * scale, texel[1] * scale, texel[2] * scale], delicate)
}

/// Bilinear in each lane's own level, and with `part` on the way to the next.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a kernel's registers")]
fn levels<S: Simd>(
    s: S,
    mask: S::M,
    shade: &TextureShade<'_>,
    u: S::F,
    v: S::F,
    level: S::F,
    part: Option<S::F>,
    last: u32,
) -> V3<S> {
    let mut out = splat3(s, [0.0; 3]);
    let fixed = shade.texture.fixed_levels();
    // Those that have both of their levels in fixed point, all at once.
    let highest = fixed.count.min(last) as f32 - if part.is_some() && fixed.count < last { 1.0 } else { 0.0 };
    let is_fixed = mask & s.splat(1.0).le(level) & level.le(s.splat(highest));
    if is_fixed.any() {
        let number = s.select(is_fixed, level, s.splat(1.0)).to_i32();
        let mut texel = fixed_bilinear(s, is_fixed, shade, &fixed, u, v, number);
        if let Some(part) = part {
            // The last level is its own next one.
            let number = (number + s.splat_i(1)).min(s.splat_i(last as i32));
            let next = fixed_bilinear(s, is_fixed, shade, &fixed, u, v, number);
            texel = between::<S>(texel, next, part);
        }
        out = texel;
    }
    let mut numbers = [0f32; 16];
    s.store(level, &mut numbers[..S::LANES]);
    let mut left = mask & !is_fixed;
    while left.any() {
        let first = numbers[left.bits().trailing_zeros() as usize];
        let number = s.splat(first);
        let same = left & level.le(number) & number.le(level);
        left = left & !same;
        let own = (first as u32).min(last);
        let mut texel = bilinear(s, same, shade, u, v, own);
        if let (Some(part), true) = (part, own < last) {
            texel = between::<S>(texel, bilinear(s, same, shade, u, v, own + 1), part);
        }
        for c in 0..3 {
            out[c] = s.select(same, texel[c], out[c]);
        }
        if first.is_nan() {
            break;
        }
    }
    out
}

/// Bilinear in levels 1.. that are held in fixed point, each lane in its own.
#[inline(always)]
fn fixed_bilinear<S: Simd>(
    s: S,
    mask: S::M,
    shade: &TextureShade<'_>,
    fixed: &FixedLevels<'_>,
    u: S::F,
    v: S::F,
    number: S::I,
) -> V3<S> {
    let [(w, h, start), others @ ..] = fixed.levels;
    let (mut w, mut h) = (s.splat_i(w as i32), s.splat_i(h as i32));
    let mut start = s.splat_i(start as i32);
    let mut i = 0;
    while i < others.len() {
        let own = number.eq(s.splat_i(i as i32 + 2));
        w = s.select_i(own, s.splat_i(others[i].0 as i32), w);
        h = s.select_i(own, s.splat_i(others[i].1 as i32), h);
        start = s.select_i(own, s.splat_i(others[i].2 as i32), start);
        i += 1;
    }
    let near = neighbours(s, shade.sampling, u, v, (w, h));
    let (one, highest) = (s.splat_i(1), h - s.splat_i(1));
    // Rows are stored from the top.
    let stride = w + one;
    let [a, b] = [
        fixed_pair(s, mask, fixed.texels, start + (highest - near.j[0]) * stride + near.i[0]),
        fixed_pair(s, mask, fixed.texels, start + (highest - near.j[1]) * stride + near.i[0]),
    ];
    near.blend(s, a, b, 1.0 / 256.0)
}

/// The texels around a point of a level, and how far it lies on the way from the first to the second of each axis.
struct Neighbours<S: Simd> {
    i: [S::I; 2],
    j: [S::I; 2],
    part: [S::F; 2],
}

/// Of a level of this width and height.
#[inline(always)]
fn neighbours<S: Simd>(s: S, sampling: Sampling, u: S::F, v: S::F, (w, h): (S::I, S::I)) -> Neighbours<S> {
    let x = in_texels(s, u, sampling.wrap_s, w) - s.splat(0.5);
    let y = in_texels(s, v, sampling.wrap_t, h) - s.splat(0.5);
    let (i, j) = (x.floor(), y.floor());
    let (fx, fy) = (x - i, y - j);
    let (i, j) = (i.to_i32(), j.to_i32());
    let one = s.splat_i(1);
    let (i0, i1) = (wrapped(s, i, sampling.wrap_s, w), wrapped(s, i + one, sampling.wrap_s, w));
    let (j0, j1) = (wrapped(s, j, sampling.wrap_t, h), wrapped(s, j + one, sampling.wrap_t, h));
    // Where there is no second column the first one counts twice.
    let fx = s.select(i0.eq(i1), s.splat(0.0), fx);
    Neighbours { i: [i0, i1], j: [j0, j1], part: [fx, fy] }
}

impl<S: Simd> Neighbours<S> {
    /// Two texels of the one row and two of the other, in `unit`: a power of two, so that nothing is rounded by it.
    #[inline(always)]
    fn blend(&self, s: S, a: [V3<S>; 2], b: [V3<S>; 2], unit: f32) -> V3<S> {
        let (a, b) = (between::<S>(a[0], a[1], self.part[0]), between::<S>(b[0], b[1], self.part[0]));
        let texel = between::<S>(a, b, self.part[1]);
        let unit = s.splat(unit);
        [texel[0] * unit, texel[1] * unit, texel[2] * unit]
    }
}

/// A coordinate without its whole turns, or as it is where it is clamped.
#[inline(always)]
fn turns<S: Simd>(_: S, origin: S::F, rest: S::F, away: S::F, wrap: Wrap) -> S::F {
    match wrap {
        Wrap::Repeat => {
            let f = (origin - origin.floor()) + (rest + away);
            f - f.floor()
        }
        Wrap::Clamp => origin + (rest + away),
    }
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

#[inline(always)]
fn bilinear<S: Simd>(s: S, mask: S::M, shade: &TextureShade<'_>, u: S::F, v: S::F, level: u32) -> V3<S> {
    let texture = shade.texture;
    let (w, h) = texture.level_size(level);
    let near = neighbours(s, shade.sampling, u, v, (s.splat_i(w as i32), s.splat_i(h as i32)));
    let (a, unit) = pair(s, mask, texture, level, near.i, near.j[0]);
    let (b, _) = pair(s, mask, texture, level, near.i, near.j[1]);
    near.blend(s, a, b, unit)
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
            (fixed_pair(s, mask, texels, row * s.splat_i(w as i32 + 1) + i0), 1.0 / 256.0)
        }
        LevelTexels::Bytes(bytes) if !(mask & !i1.eq(i0 + s.splat_i(1))).any() && w > 1 => {
            let [left, right] = s.gather_byte_pairs(mask, bytes, row * s.splat_i(w as i32) + i0);
            ([channels(s, left), channels(s, right)], 1.0)
        }
        LevelTexels::Bytes(bytes) => {
            let at = row * s.splat_i(w as i32);
            let (left, right) = (s.gather_bytes(mask, bytes, at + i0), s.gather_bytes(mask, bytes, at + i1));
            ([channels(s, left), channels(s, right)], 1.0)
        }
        LevelTexels::Float(texels) => {
            let at = row * s.splat_i(w as i32);
            let [r0, g0, b0, _] = s.gather4(mask, texels, at + i0);
            let [r1, g1, b1, _] = s.gather4(mask, texels, at + i1);
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

/// R, G, B of packed bytes.
#[inline(always)]
fn channels<S: Simd>(s: S, rgba: S::I) -> V3<S> {
    let low = s.splat_i(255);
    [(rgba & low).to_f32(), (rgba.shr::<8>() & low).to_f32(), (rgba.shr::<16>() & low).to_f32()]
}

#[inline(always)]
fn between<S: Simd>(a: V3<S>, b: V3<S>, t: S::F) -> V3<S> {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}

#[inline(always)]
fn length2<S: Simd>(step: [S::F; 2], w: S::F, h: S::F) -> S::F {
    let (x, y) = (step[0] * w, step[1] * h);
    x * x + y * y
}

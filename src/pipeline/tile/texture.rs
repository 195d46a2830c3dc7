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
    /// The texture's levels in fixed point.
    fixed: Fixed<'a>,
}

/// Levels in fixed point, found once a draw because every vector asks for them. Entry n of a table is level n's.
#[derive(Clone, Copy, Debug)]
struct Fixed<'a> {
    texels: &'a [[u16; 4]],
    /// They are levels 1 to so many.
    count: u32,
    widths: [i32; 8],
    heights: [i32; 8],
    /// Where the lowest row begins: rows are stored from the top.
    lowest_rows: [i32; 8],
}

impl<'a> Fixed<'a> {
    fn new(levels: FixedLevels<'a>) -> Self {
        let FixedLevels { texels, levels, count } = levels;
        let (mut widths, mut heights, mut lowest_rows) = ([1; 8], [1; 8], [0; 8]);
        for (i, (w, h, start)) in levels.into_iter().enumerate() {
            (widths[i + 1], heights[i + 1]) = (w as i32, h as i32);
            lowest_rows[i + 1] = start as i32 + (h as i32 - 1) * (w as i32 + 1);
        }
        Self { texels, count, widths, heights, lowest_rows }
    }
}

impl<'a> TextureShade<'a> {
    /// Of this texture by these rules.
    pub fn new(texture: &'a Texture, sampling: Sampling) -> Self {
        Self { texture, sampling, fixed: Fixed::new(texture.fixed_levels()) }
    }

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
    let fixed = &shade.fixed;
    // Those that have both of their levels in fixed point, all at once.
    let highest = fixed.count.min(last) as f32 - if part.is_some() && fixed.count < last { 1.0 } else { 0.0 };
    let is_fixed = mask & s.splat(1.0).le(level) & level.le(s.splat(highest));
    if is_fixed.any() {
        let number = s.select(is_fixed, level, s.splat(1.0)).to_i32();
        let mut texel = fixed_bilinear(s, is_fixed, shade, u, v, number);
        if let Some(part) = part {
            // The last level is its own next one.
            let number = (number + s.splat_i(1)).min(s.splat_i(last as i32));
            let next = fixed_bilinear(s, is_fixed, shade, u, v, number);
            texel = between::<S>(texel, next, part);
        }
        // A power of two, so that nothing is rounded by it.
        let unit = s.splat(1.0 / 256.0);
        out = [texel[0] * unit, texel[1] * unit, texel[2] * unit];
    }
    let mut left = mask & !is_fixed;
    if !left.any() {
        return out;
    }
    let mut numbers = [0f32; 16];
    s.store(level, &mut numbers[..S::LANES]);
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
    u: S::F,
    v: S::F,
    number: S::I,
) -> V3<S> {
    let fixed = &shade.fixed;
    let (w, h) = (s.lookup(&fixed.widths, number), s.lookup(&fixed.heights, number));
    let near = neighbours(s, shade.sampling, u, v, (w, h));
    // Each row has its first texel once more at its end.
    let stride = w + s.splat_i(1);
    let base = s.lookup(&fixed.lowest_rows, number) + near.i[0];
    let [a, b] = [
        fixed_pair(s, mask, fixed.texels, base - near.j[0] * stride),
        fixed_pair(s, mask, fixed.texels, base - near.j[1] * stride),
    ];
    near.blend(s, a, b)
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
            let whole = texels.floor();
            // From -1 to size - 1: only the first one can lie before the texture, only the second one behind it.
            let first = whole.to_i32();
            let second = first + one;
            let around = [
                s.select_i(none.gt(first), first + size, first),
                s.select_i(second.eq(size), none, second),
            ];
            (around, texels - whole)
        }
        Wrap::Clamp => {
            let texels = texels.max(s.splat(0.0)).min(width - s.splat(1.0));
            let whole = texels.floor();
            let first = whole.to_i32();
            ([first, (first + one).min(size - one)], texels - whole)
        }
    }
}

impl<S: Simd> Neighbours<S> {
    /// Two texels of the one row and two of the other.
    #[inline(always)]
    fn blend(&self, _: S, a: [V3<S>; 2], b: [V3<S>; 2]) -> V3<S> {
        let (a, b) = (between::<S>(a[0], a[1], self.part[0]), between::<S>(b[0], b[1], self.part[0]));
        between::<S>(a, b, self.part[1])
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
    let (texel, unit) = (near.blend(s, a, b), s.splat(unit));
    [texel[0] * unit, texel[1] * unit, texel[2] * unit]
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
    let [rg0, ba0, rg1, ba1] = s.gather_pairs(mask, texels, inside(s, at, texels.len() - 1));
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

#[inline(always)]
fn between<S: Simd>(a: V3<S>, b: V3<S>, t: S::F) -> V3<S> {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}

#[inline(always)]
fn length2<S: Simd>(step: [S::F; 2], w: S::F, h: S::F) -> S::F {
    let (x, y) = (step[0] * w, step[1] * h);
    x * x + y * y
}

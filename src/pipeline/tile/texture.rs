//! Textures, a vector of pixels at a time: the twin of `pipeline::sample`, in f32.
//!
//! Coordinates come as a corner's, in two parts, and the way from it: whole turns are dropped before the digits are.

use super::light::{V3, log2, splat3};
use crate::scene::{FIXED_LEVELS, Filter, FixedLevels, LevelTexels, Sampling, Texture, Wrap};
use crate::simd::{F32, I32, Mask, Simd, prefetch};

/// Within this of a level's edge `mipmap` asks the plain path: the level is found to about 1e-4.
const LEVEL_EDGE: f32 = 1e-3;

/// The square of a footprint that reaches the horizon: larger than every texture's.
const HORIZON: f32 = (1u128 << 126) as f32;

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

/// Levels in fixed point, found once a draw because every vector asks for them. Entry n of a table is level n's, from 1
/// on.
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

/// Every such level has its entry.
const _: () = assert!(FIXED_LEVELS < 8);

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

/// Where pixels look into a texture.
#[derive(Clone, Copy)]
pub struct Spot<S: Simd> {
    /// The coordinates, without whole turns.
    u: S::F,
    v: S::F,
    /// The square of the longer way to a neighbour's spot, in texels, where the filter looks at levels.
    footprint: S::F,
}

/// What pixels will read of the levels of a texture: found before anything is read, so that the reads of several vectors are
/// under way together.
#[derive(Clone, Copy)]
pub struct Aim<S: Simd> {
    /// Where the filter looks at levels; else this and what follows means nothing.
    level: S::F,
    /// How far on the way to the next level.
    part: S::F,
    /// Those that have all they read in fixed point, and what that is: of their level and of the next.
    is_fixed: S::M,
    squares: [Square<S>; 2],
    /// Too near to a level's edge for f32.
    delicate: S::M,
}

/// Four texels of a level in fixed point: where the two of each row begin, and how far on the way between them.
#[derive(Clone, Copy)]
struct Square<S: Simd> {
    at: [S::I; 2],
    part: [S::F; 2],
}

impl<S: Simd> Square<S> {
    /// Says that both rows' texels will be read soon.
    #[inline(always)]
    fn ask_for(&self, s: S, texels: &[[u16; 4]]) {
        let mut row = 0;
        while row < 2 {
            let mut places = [0; 16];
            s.store_i(self.at[row], &mut places[..S::LANES]);
            let mut lane = 0;
            while lane < S::LANES {
                prefetch::for_read(texels, places[lane] as u32 as usize);
                lane += 1;
            }
            row += 1;
        }
    }
}

impl<S: Simd> Spot<S> {
    /// The first texel.
    #[inline(always)]
    pub fn origin(s: S) -> Self {
        let zero = s.splat(0.0);
        Self { u: zero, v: zero, footprint: zero }
    }
}

impl<S: Simd> Aim<S> {
    /// At nothing.
    #[inline(always)]
    pub fn none(s: S) -> Self {
        let (zero, at) = (s.splat(0.0), s.splat_i(0));
        let squares = [Square { at: [at; 2], part: [zero; 2] }; 2];
        Self { level: zero, part: zero, is_fixed: s.mask(0), squares, delicate: s.mask(0) }
    }

    /// Where f32 lacks the digits.
    #[inline(always)]
    pub fn delicate(&self) -> S::M {
        self.delicate
    }
}

impl TextureShade<'_> {
    /// The spot at `origin` (u, v, and what f32 lost of them) + `away`.
    #[inline(always)]
    pub fn spot<S: Simd>(
        &self,
        s: S,
        origin: [[S::F; 2]; 2],
        away: [S::F; 2],
        footprint: Option<Footprint<S>>,
    ) -> Spot<S> {
        let (texture, sampling) = (self.texture, self.sampling);
        let u = turns(s, origin[0][0], origin[1][0], away[0], sampling.wrap_s);
        let v = turns(s, origin[0][1], origin[1][1], away[1], sampling.wrap_t);
        let footprint = match footprint {
            None => s.splat(0.0),
            Some(footprint) => {
                let (w, h) = (s.splat(texture.width() as f32), s.splat(texture.height() as f32));
                let longer = length2::<S>(footprint.right, w, h).max(length2::<S>(footprint.below, w, h));
                s.select(footprint.is_horizon, s.splat(HORIZON), longer)
            }
        };
        Spot { u, v, footprint }
    }

    /// What will be read there; nothing is read of the texels yet, but those of the nearer level are asked for.
    #[inline(always)]
    pub fn aim<S: Simd>(&self, s: S, mask: S::M, spot: &Spot<S>) -> Aim<S> {
        if !self.needs_level() {
            return Aim::none(s);
        }
        let last = self.texture.level_count() - 1;
        let (zero, top) = (s.splat(0.0), s.splat(last as f32));
        let d = s.splat(0.5) * log2(s, spot.footprint);
        let is_trilinear = self.sampling.filter == Filter::Trilinear;
        let (level, part, delicate) = if is_trilinear {
            let d = d.max(zero).min(top);
            let level = d.floor();
            (level, d - level, s.mask(0))
        } else {
            let at = d + s.splat(0.5);
            let part = at - at.floor();
            let is_edge = part.lt(s.splat(LEVEL_EDGE)) | s.splat(1.0 - LEVEL_EDGE).lt(part);
            (at.floor().max(zero).min(top), zero, mask & is_edge & s.splat(0.5).lt(at))
        };
        // Those that have both of their levels in fixed point, all at once; what is no number has no place there.
        let fixed = &self.fixed;
        let highest =
            fixed.count.min(last) as f32 - if is_trilinear && fixed.count < last { 1.0 } else { 0.0 };
        let sum = spot.u + spot.v;
        let is_fixed = mask & sum.le(sum) & s.splat(1.0).le(level) & level.le(s.splat(highest));
        if !is_fixed.any() {
            return Aim { level, part, is_fixed, delicate, ..Aim::none(s) };
        }
        let number = level.to_i32();
        let near = self.square(s, spot, number);
        near.ask_for(s, fixed.texels);
        // The last level is its own next one.
        let far = match is_trilinear {
            true => self.square(s, spot, (number + s.splat_i(1)).min(s.splat_i(last as i32))),
            false => near,
        };
        Aim { level, part, is_fixed, squares: [near, far], delicate }
    }

    /// R, G, B in 0..1.
    #[inline(always)]
    pub fn texel<S: Simd>(&self, s: S, mask: S::M, spot: &Spot<S>, aim: &Aim<S>) -> V3<S> {
        let (texture, sampling) = (self.texture, self.sampling);
        let texel = match sampling.filter {
            Filter::Nearest => {
                let (w, h) = (s.splat_i(texture.width() as i32), s.splat_i(texture.height() as i32));
                let i = in_texels(s, spot.u, sampling.wrap_s, w).floor().to_i32();
                let j = in_texels(s, spot.v, sampling.wrap_t, h).floor().to_i32();
                let (i, j) = (wrapped(s, i, sampling.wrap_s, w), wrapped(s, j, sampling.wrap_t, h));
                // Rows are stored from the top.
                let at = (h - s.splat_i(1) - j) * w + i;
                channels(s, s.gather_bytes(mask, texture.bytes(), at))
            }
            Filter::Bilinear => bilinear(s, mask, self, spot, 0),
            Filter::Mipmap | Filter::Trilinear => self.levels(s, mask, spot, aim),
        };
        let scale = s.splat(1.0 / 255.0);
        [texel[0] * scale, texel[1] * scale, texel[2] * scale]
    }

    /// Bilinear in each lane's own level, and on the way to the next.
    #[inline(always)]
    fn levels<S: Simd>(&self, s: S, mask: S::M, spot: &Spot<S>, aim: &Aim<S>) -> V3<S> {
        let is_trilinear = self.sampling.filter == Filter::Trilinear;
        let mut out = splat3(s, [0.0; 3]);
        if aim.is_fixed.any() {
            let mut texel = self.fixed_bilinear(s, aim.is_fixed, &aim.squares[0]);
            if is_trilinear {
                let next = self.fixed_bilinear(s, aim.is_fixed, &aim.squares[1]);
                texel = between::<S>(texel, next, aim.part);
            }
            // A power of two, so that nothing is rounded by it.
            let unit = s.splat(1.0 / 256.0);
            out = [texel[0] * unit, texel[1] * unit, texel[2] * unit];
        }
        let mut left = mask & !aim.is_fixed;
        if !left.any() {
            return out;
        }
        let last = self.texture.level_count() - 1;
        let mut numbers = [0f32; 16];
        s.store(aim.level, &mut numbers[..S::LANES]);
        while left.any() {
            let first = numbers[left.bits().trailing_zeros() as usize];
            let number = s.splat(first);
            let same = left & aim.level.le(number) & number.le(aim.level);
            left = left & !same;
            let own = (first as u32).min(last);
            let mut texel = bilinear(s, same, self, spot, own);
            if is_trilinear && own < last {
                texel = between::<S>(texel, bilinear(s, same, self, spot, own + 1), aim.part);
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

    /// The square around a spot, each lane's in its own level. Where that is not one in fixed point the places mean nothing.
    #[inline(always)]
    fn square<S: Simd>(&self, s: S, spot: &Spot<S>, number: S::I) -> Square<S> {
        let fixed = &self.fixed;
        let (w, h) = (s.lookup(&fixed.widths, number), s.lookup(&fixed.heights, number));
        let near = neighbours(s, self.sampling, spot, (w, h));
        // Each row has its first texel once more at its end.
        let stride = w + s.splat_i(1);
        let base = s.lookup(&fixed.lowest_rows, number) + near.i[0];
        Square { at: [base - near.j[0] * stride, base - near.j[1] * stride], part: near.part }
    }

    /// In 1/256 of 0..255.
    #[inline(always)]
    fn fixed_bilinear<S: Simd>(&self, s: S, mask: S::M, square: &Square<S>) -> V3<S> {
        let a = fixed_pair(s, mask, self.fixed.texels, square.at[0]);
        let b = fixed_pair(s, mask, self.fixed.texels, square.at[1]);
        blend::<S>(a, b, square.part)
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
fn neighbours<S: Simd>(s: S, sampling: Sampling, spot: &Spot<S>, (w, h): (S::I, S::I)) -> Neighbours<S> {
    let (i, across) = around(s, spot.u, sampling.wrap_s, w);
    let (j, up) = around(s, spot.v, sampling.wrap_t, h);
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
            let around =
                [s.select_i(none.gt(first), first + size, first), s.select_i(second.eq(size), none, second)];
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

/// Two texels of the one row and two of the other, as far as `part` says on the way between them.
#[inline(always)]
fn blend<S: Simd>(a: [V3<S>; 2], b: [V3<S>; 2], part: [S::F; 2]) -> V3<S> {
    let (a, b) = (between::<S>(a[0], a[1], part[0]), between::<S>(b[0], b[1], part[0]));
    between::<S>(a, b, part[1])
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
fn bilinear<S: Simd>(s: S, mask: S::M, shade: &TextureShade<'_>, spot: &Spot<S>, level: u32) -> V3<S> {
    let texture = shade.texture;
    let (w, h) = texture.level_size(level);
    let near = neighbours(s, shade.sampling, spot, (s.splat_i(w as i32), s.splat_i(h as i32)));
    let (a, unit) = pair(s, mask, texture, level, near.i, near.j[0]);
    let (b, _) = pair(s, mask, texture, level, near.i, near.j[1]);
    let (texel, unit) = (blend::<S>(a, b, near.part), s.splat(unit));
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

#[inline(always)]
fn between<S: Simd>(a: V3<S>, b: V3<S>, t: S::F) -> V3<S> {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}

#[inline(always)]
fn length2<S: Simd>(step: [S::F; 2], w: S::F, h: S::F) -> S::F {
    let (x, y) = (step[0] * w, step[1] * h);
    x * x + y * y
}

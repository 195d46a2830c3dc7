//! Textures: RGBA pictures with their mip chain.

use super::modes::{Sampling, Wrap};
use crate::error::Code;
use std::fmt;

/// Largest width or height of a texture, in texels.
pub const MAX_TEXTURE_SIDE: u32 = 16_384;

/// Error of creating a texture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TextureError {
    /// A side is not in 1..=[`MAX_TEXTURE_SIDE`] texels.
    BadSize {
        /// Width in texels.
        width: u32,
        /// Height in texels.
        height: u32,
    },
    /// The number of bytes is not width * height * 4.
    BadLength {
        /// Width in texels.
        width: u32,
        /// Height in texels.
        height: u32,
        /// Expected bytes, width * height * 4.
        expected: u64,
        /// Bytes given.
        found: u64,
    },
}

impl fmt::Display for TextureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TextureError::BadSize { width, height } => {
                write!(f, "a texture has 1 to {MAX_TEXTURE_SIDE} texels a side, not {width}x{height}")
            }
            TextureError::BadLength { width, height, expected, found } => {
                write!(f, "a {width}x{height} texture has {expected} bytes, not {found}")
            }
        }
    }
}

impl std::error::Error for TextureError {}

impl TextureError {
    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            TextureError::BadSize { .. } => Code::TooBig,
            TextureError::BadLength { .. } => Code::Format,
        }
    }
}

/// Texture: RGBA bytes, row 0 at the top of the picture (v = 1), with its mip levels and whether
/// any texel is transparent.
///
/// Level 0 is the bytes themselves. Further levels (2x2 box filter, sizes halved rounding down, the
/// last odd row and column dropped) are computed when the texture is created: levels 1 to 4 in
/// fixed point, which is exact, the others as f32.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    bytes: Vec<u8>,
    /// Levels from 1 on.
    levels: Vec<MipLevel>,
    /// Texels of the fixed-point levels, one level after the other, in 1/256 of 0..255. Each row
    /// repeats its first texel at its end.
    fixed: Vec<[u16; 4]>,
    has_alpha: bool,
    /// Set if the edge texels are extended whatever the draw asks for.
    is_clamped: bool,
}

/// Mip level made by averaging.
#[derive(Clone, Debug, PartialEq)]
struct MipLevel {
    width: u32,
    height: u32,
    texels: Texels,
}

#[derive(Clone, Debug, PartialEq)]
enum Texels {
    /// Start of the level's texels among the fixed-point ones.
    Fixed(usize),
    /// Texels in 0..255.
    Float(Vec<[f32; 4]>),
}

/// Fixed-point mip levels of a texture: levels 1 to at most 4.
#[derive(Clone, Copy, Debug)]
pub struct FixedLevels<'a> {
    /// RGBA texels, one level after the other, laid out as in [`LevelTexels::Fixed`].
    pub texels: &'a [[u16; 4]],
    /// Width, height and start in `texels` of each level.
    pub levels: [(u32, u32, usize); FIXED_LEVELS as usize],
    /// Number of levels.
    pub count: u32,
}

/// RGBA texels of a level, row 0 at the top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelTexels<'a> {
    /// Level 0: four bytes per texel.
    Bytes(&'a [u8]),
    /// In 1/256 of 0..255. Each row repeats its first texel at its end, so it has width + 1 of
    /// them.
    Fixed(&'a [[u16; 4]]),
    /// In 0..255.
    Float(&'a [[f32; 4]]),
}

/// Number of levels whose averages of bytes are exact in 1/256: each level adds two binary places.
pub(crate) const FIXED_LEVELS: u32 = 4;

impl Texture {
    /// Creates a texture from RGBA bytes, row 0 at the top, and computes its mip levels.
    ///
    /// # Errors
    /// If a side is out of range, or `bytes` is not width * height * 4 long.
    pub fn new(width: u32, height: u32, bytes: Vec<u8>) -> Result<Self, TextureError> {
        let side = 1..=MAX_TEXTURE_SIDE;
        if !side.contains(&width) || !side.contains(&height) {
            return Err(TextureError::BadSize { width, height });
        }
        let expected = width as u64 * height as u64 * 4;
        if bytes.len() as u64 != expected {
            return Err(TextureError::BadLength { width, height, expected, found: bytes.len() as u64 });
        }
        let has_alpha = bytes.as_chunks::<4>().0.iter().any(|t| t[3] != 255);
        let (levels, fixed, is_clamped) = (Vec::new(), Vec::new(), false);
        let mut texture = Texture { width, height, bytes, levels, fixed, has_alpha, is_clamped };
        texture.fixed.reserve_exact(level_bytes(width, height)[0] as usize / 8);
        while let Some((level, mut fixed)) = texture.next_level() {
            texture.levels.push(level);
            texture.fixed.append(&mut fixed);
        }
        Ok(texture)
    }

    /// Returns the texture with its edge texels extended in both directions, whatever sampling a
    /// draw asks for.
    pub fn clamped(self) -> Self {
        Texture { is_clamped: true, ..self }
    }

    /// Returns the sampling of this texture in a draw that asks for `asked`.
    pub fn sampling(&self, asked: Sampling) -> Sampling {
        match self.is_clamped {
            true => Sampling { wrap_s: Wrap::Clamp, wrap_t: Wrap::Clamp, ..asked },
            false => asked,
        }
    }

    /// Returns the level below the last one and its fixed-point texels, or `None` if the last one
    /// is 1x1.
    fn next_level(&self) -> Option<(MipLevel, Vec<[u16; 4]>)> {
        let last = self.level_count() - 1;
        let (w, h) = self.level_size(last);
        if (w, h) == (1, 1) {
            return None;
        }
        let (width, height) = ((w / 2).max(1), (h / 2).max(1));
        let texel = |x: u32, y: u32| -> [f32; 4] {
            // A side of 1 has no second texel: its only one counts twice.
            let (x1, y1) = ((2 * x + 1).min(w - 1), (2 * y + 1).min(h - 1));
            let t = [(2 * x, 2 * y), (x1, 2 * y), (2 * x, y1), (x1, y1)].map(|(x, y)| self.texel(last, x, y));
            std::array::from_fn(|c| (t[0][c] + t[1][c] + t[2][c] + t[3][c]) * 0.25)
        };
        let mut fixed = Vec::new();
        let texels = if last < FIXED_LEVELS {
            fixed.reserve_exact((width as usize + 1) * height as usize);
            let row = |y: u32| (0..=width).map(move |x| texel(x % width, y).map(|c| (c * 256.0) as u16));
            fixed.extend((0..height).flat_map(row));
            Texels::Fixed(self.fixed.len())
        } else {
            let mut texels = Vec::with_capacity(width as usize * height as usize);
            (0..height).for_each(|y| texels.extend((0..width).map(|x| texel(x, y))));
            Texels::Float(texels)
        };
        Some((MipLevel { width, height, texels }, fixed))
    }

    /// Returns the width of level 0 in texels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height of level 0 in texels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the RGBA bytes of level 0, row 0 at the top.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns whether any texel's alpha is below 255.
    pub fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// Returns the number of levels, level 0 included.
    pub fn level_count(&self) -> u32 {
        self.levels.len() as u32 + 1
    }

    /// Returns the width and height of a level; levels beyond the last have the last one's size.
    pub fn level_size(&self, level: u32) -> (u32, u32) {
        match level.checked_sub(1).map(|i| &self.levels[(i as usize).min(self.levels.len() - 1)]) {
            Some(level) => (level.width, level.height),
            None => (self.width, self.height),
        }
    }

    /// Returns the RGBA of one texel in 0..255, counted from the top left.
    ///
    /// # Panics
    /// If there is no such level or texel.
    #[inline]
    pub fn texel(&self, level: u32, x: u32, y: u32) -> [f32; 4] {
        let (w, _) = self.level_size(level);
        let at = w as usize * y as usize + x as usize;
        match self.level_texels(level) {
            LevelTexels::Bytes(bytes) => std::array::from_fn(|c| bytes[at * 4 + c] as f32),
            LevelTexels::Fixed(texels) => texels[at + y as usize].map(|c| c as f32 / 256.0),
            LevelTexels::Float(texels) => texels[at],
        }
    }

    /// Returns the texels of a level.
    ///
    /// # Panics
    /// If there is no such level.
    #[inline]
    pub fn level_texels(&self, level: u32) -> LevelTexels<'_> {
        let Some(level) = level.checked_sub(1).map(|i| &self.levels[i as usize]) else {
            return LevelTexels::Bytes(&self.bytes);
        };
        match &level.texels {
            Texels::Fixed(at) => {
                LevelTexels::Fixed(&self.fixed[*at..][..(level.width as usize + 1) * level.height as usize])
            }
            Texels::Float(texels) => LevelTexels::Float(texels),
        }
    }

    /// Returns the fixed-point levels.
    pub fn fixed_levels(&self) -> FixedLevels<'_> {
        let mut found =
            FixedLevels { texels: &self.fixed, levels: [(1, 1, 0); FIXED_LEVELS as usize], count: 0 };
        for (place, level) in found.levels.iter_mut().zip(&self.levels) {
            if let Texels::Fixed(at) = level.texels {
                *place = (level.width, level.height, at);
                found.count += 1;
            }
        }
        found
    }

    /// Returns the bytes of all levels of a texture of this size, and the additional bytes while it
    /// is created: level 1, before it is appended to the others.
    pub fn bytes_for(width: u32, height: u32) -> (u64, u64) {
        let [fixed, float] = level_bytes(width, height);
        let first = (u64::from(width / 2).max(1) + 1) * u64::from(height / 2).max(1) * 8;
        (u64::from(width) * u64::from(height) * 4 + fixed + float, first)
    }

    /// Returns the bytes of all levels.
    pub fn size_bytes(&self) -> usize {
        let size = |level: &MipLevel| match &level.texels {
            Texels::Fixed(_) => 0,
            Texels::Float(texels) => texels.len() * 16,
        };
        self.bytes.len() + self.fixed.len() * 8 + self.levels.iter().map(size).sum::<usize>()
    }
}

/// Returns the bytes of the levels below level 0: those in fixed point, and those in f32.
fn level_bytes(width: u32, height: u32) -> [u64; 2] {
    let (mut w, mut h, mut bytes) = (u64::from(width), u64::from(height), [0; 2]);
    for level in 1.. {
        if (w, h) == (1, 1) {
            break;
        }
        (w, h) = ((w / 2).max(1), (h / 2).max(1));
        match level <= FIXED_LEVELS {
            true => bytes[0] += (w + 1) * h * 8,
            false => bytes[1] += w * h * 16,
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_sizes_halve_rounding_down_and_drop_the_last() {
        let bytes: Vec<u8> = (0..5 * 3).flat_map(|i| [i as u8 * 10, 0, 0, 255]).collect();
        let t = Texture::new(5, 3, bytes).unwrap();
        assert_eq!((t.level_size(1), t.level_size(2), t.level_count()), ((2, 1), (1, 1), 3));
        assert_eq!(t.texel(1, 0, 0)[0], (0.0 + 10.0 + 50.0 + 60.0) / 4.0);
        assert_eq!(t.texel(2, 0, 0)[0], (t.texel(1, 0, 0)[0] + t.texel(1, 1, 0)[0]) / 2.0);
        assert!(!t.has_alpha());
        assert!(Texture::new(0, 1, vec![]).is_err());
        assert!(Texture::new(1, 1, vec![0; 3]).is_err());
    }

    #[test]
    fn every_level_is_the_mean_of_the_one_above_to_the_last_bit() {
        let bytes: Vec<u8> =
            (0..200u32 * 150 * 4).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let t = Texture::new(200, 150, bytes).unwrap();
        assert_eq!(t.level_count(), 8);
        for level in 1..t.level_count() {
            let ((w, h), (above, _)) = (t.level_size(level), t.level_size(level - 1));
            for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
                let right = (2 * x + 1).min(above - 1);
                let four = [(2 * x, 2 * y), (right, 2 * y), (2 * x, 2 * y + 1), (right, 2 * y + 1)];
                for c in 0..4 {
                    let sum: f64 = four.iter().map(|&(x, y)| f64::from(t.texel(level - 1, x, y)[c])).sum();
                    assert_eq!(f64::from(t.texel(level, x, y)[c]), sum / 4.0, "level {level}, ({x}, {y})");
                }
            }
            if let LevelTexels::Fixed(texels) = t.level_texels(level) {
                let row = w as usize + 1;
                assert_eq!(texels.len(), row * h as usize);
                texels.chunks(row).for_each(|row| assert_eq!(row[0], row[w as usize]));
            }
        }
    }

    #[test]
    fn the_bytes_of_a_size_are_those_of_its_texture() {
        for (width, height) in [(1, 1), (2, 1), (5, 3), (64, 64), (200, 150), (1, 300), (1024, 7)] {
            let texture = Texture::new(width, height, vec![9; (width * height * 4) as usize]).unwrap();
            assert_eq!(Texture::bytes_for(width, height).0, texture.size_bytes() as u64, "{width}x{height}");
        }
    }
}

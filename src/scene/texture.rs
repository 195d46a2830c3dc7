//! Textures: RGBA pictures with their mip chain.

use crate::error::Code;

/// The largest width or height of a texture, in texels.
pub const MAX_TEXTURE_SIDE: u32 = 16_384;

/// Why a texture cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextureError {
    /// A texture has 1 to [`MAX_TEXTURE_SIDE`] texels a side.
    #[error("a texture has 1 to {MAX_TEXTURE_SIDE} texels a side, not {width}x{height}")]
    BadSize {
        /// Texels across.
        width: u32,
        /// Texels down.
        height: u32,
    },
    /// The bytes are not width * height * 4.
    #[error("a {width}x{height} texture has {expected} bytes, not {found}")]
    BadLength {
        /// Texels across.
        width: u32,
        /// Texels down.
        height: u32,
        /// width * height * 4.
        expected: u64,
        /// Bytes given.
        found: u64,
    },
}

impl TextureError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            TextureError::BadSize { .. } => Code::TooBig,
            TextureError::BadLength { .. } => Code::Format,
        }
    }
}

/// A texture: RGBA bytes, row 0 at the top of the picture (v = 1), and whether any texel lets light through.
///
/// Level 0 is the bytes themselves; further levels (2x2 box, halved rounding down, the last odd row and column dropped,
/// held as f32 in 0..255) are made when the texture is.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    bytes: Vec<u8>,
    /// Levels 1.., each width, height and RGBA texels in 0..255, unrounded.
    levels: Vec<(u32, u32, Vec<[f32; 4]>)>,
    has_alpha: bool,
}

impl Texture {
    /// A texture from RGBA bytes, row 0 at the top.
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
        let mut texture = Texture { width, height, bytes, levels: Vec::new(), has_alpha };
        while let Some(level) = texture.next_level() {
            texture.levels.push(level);
        }
        Ok(texture)
    }

    /// The level below the last one, or `None` when that is 1x1.
    fn next_level(&self) -> Option<(u32, u32, Vec<[f32; 4]>)> {
        let last = self.level_count() - 1;
        let (w, h) = self.level_size(last);
        if (w, h) == (1, 1) {
            return None;
        }
        let (nw, nh) = ((w / 2).max(1), (h / 2).max(1));
        let mut texels = Vec::with_capacity(nw as usize * nh as usize);
        for y in 0..nh {
            for x in 0..nw {
                // A side of 1 has no second texel: the one there is counts twice.
                let (x1, y1) = ((2 * x + 1).min(w - 1), (2 * y + 1).min(h - 1));
                let t =
                    [(2 * x, 2 * y), (x1, 2 * y), (2 * x, y1), (x1, y1)].map(|(x, y)| self.texel(last, x, y));
                texels.push(std::array::from_fn(|c| (t[0][c] + t[1][c] + t[2][c] + t[3][c]) * 0.25));
            }
        }
        Some((nw, nh, texels))
    }

    /// Width of level 0 in texels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height of level 0 in texels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Level 0's RGBA bytes, row 0 at the top.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Whether any texel's alpha is below 255.
    pub fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// How many levels there are, level 0 included.
    pub fn level_count(&self) -> u32 {
        self.levels.len() as u32 + 1
    }

    /// Width and height of a level; levels beyond the last have the last one's size.
    pub fn level_size(&self, level: u32) -> (u32, u32) {
        match level.checked_sub(1).map(|i| &self.levels[(i as usize).min(self.levels.len() - 1)]) {
            Some(&(w, h, _)) => (w, h),
            None => (self.width, self.height),
        }
    }

    /// The RGBA of one texel in 0..255, counted from the top left. `level`, `x` and `y` must exist.
    ///
    /// # Panics
    /// When they do not.
    #[inline]
    pub fn texel(&self, level: u32, x: u32, y: u32) -> [f32; 4] {
        match level {
            0 => {
                let at = (self.width as usize * y as usize + x as usize) * 4;
                std::array::from_fn(|c| self.bytes[at + c] as f32)
            }
            _ => {
                let (w, _, texels) = &self.levels[level as usize - 1];
                texels[*w as usize * y as usize + x as usize]
            }
        }
    }

    /// The RGBA texels of a level in 0..255, row 0 at the top; `None` for level 0, whose texels are the bytes.
    ///
    /// # Panics
    /// When there is no such level.
    pub fn level_texels(&self, level: u32) -> Option<&[[f32; 4]]> {
        Some(&self.levels[level.checked_sub(1)? as usize].2)
    }

    /// Bytes that all levels take.
    pub fn size_bytes(&self) -> usize {
        self.bytes.len() + self.levels.iter().map(|l| l.2.len() * 16).sum::<usize>()
    }
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
}

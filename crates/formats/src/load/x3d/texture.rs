//! Textures of ImageTexture and PixelTexture nodes.

use super::build::Opener;
use super::external_refs::READ_FROM;
use super::url;
use crate::load::side_files;
use crate::load::texture::decode_within;
use crate::load::{LoadErrorKind, LoadMemory};
use fbptr_core::error::Code;
use fbptr_core::scene::{MAX_TEXTURE_SIDE, Texture};
use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

/// Reason why a texture could not be made.
#[derive(Debug)]
pub(super) enum PictureError {
    /// No URL gives a usable picture; the reason for each. The shape is drawn without it.
    Unusable(String),
    /// The numbers of a PixelTexture are invalid; a description of valid ones.
    Pixels(String),
    /// There is no memory for it, or the load was cancelled: reading ends.
    OverMemory(LoadErrorKind),
}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PictureError::Unusable(reason) | PictureError::Pixels(reason) => f.write_str(reason),
            PictureError::OverMemory(kind) => write!(f, "{kind}"),
        }
    }
}

impl std::error::Error for PictureError {}

/// Pictures already read, by path or data URI.
#[derive(Default)]
pub(super) struct Pictures(HashMap<String, Arc<Texture>>);

impl Pictures {
    /// Returns the picture of the first URL that gives one; `note` gets what was done to find it.
    pub(super) fn load(
        &mut self,
        urls: &[String],
        folder: &str,
        note: &mut Option<String>,
        opener: &mut Opener,
        memory: &mut LoadMemory,
    ) -> Result<Arc<Texture>, PictureError> {
        let mut reasons = Vec::new();
        for name in urls {
            let shown: String = name.chars().take(40).collect();
            // A data URI is its own key.
            if let Some(texture) = self.0.get(name).filter(|_| url::is_data(name)) {
                return Ok(Arc::clone(texture));
            }
            // The URL's key for later use, and its bytes unless the picture is in the cache.
            let found = match url::data(name) {
                Some(Err(reason)) => {
                    reasons.push(format!("{shown:?}: {reason}"));
                    continue;
                }
                Some(Ok(bytes)) => Some((name.clone(), Some(bytes))),
                None => url::local_paths(folder, name).into_iter().chain(elsewhere(folder, name)).find_map(
                    |path| match self.0.contains_key(&path) {
                        true => Some((path, None)),
                        false => opener(&path).map(|bytes| (path, Some(bytes))),
                    },
                ),
            };
            let Some((key, bytes)) = found else {
                reasons.push(match url::is_outside(folder, name) {
                    true => format!("{shown:?} lies outside of {READ_FROM}"),
                    false => format!("{shown:?} cannot be found in the scene's folder"),
                });
                continue;
            };
            *note =
                elsewhere(folder, name).any(|path| path == key).then(|| side_files::elsewhere(name, &key));
            if let Some(texture) = self.0.get(&key) {
                return Ok(Arc::clone(texture));
            }
            match decode_within(&bytes.unwrap_or_default(), &key, memory) {
                Ok(texture) => {
                    let texture = Arc::new(texture);
                    self.0.insert(key, Arc::clone(&texture));
                    return Ok(texture);
                }
                Err(error) if error.code() == Code::Quota => {
                    return Err(PictureError::OverMemory(error.kind));
                }
                Err(error) => reasons.push(format!("{shown:?}: {}", error.kind)),
            }
        }
        Err(PictureError::Unusable(reasons.join("; ")))
    }
}

/// Returns the names that a path of another machine may have here.
pub(super) fn elsewhere(folder: &str, name: &str) -> impl Iterator<Item = String> {
    url::ends_of_absolute(name).into_iter().map(move |end| format!("{folder}{end}"))
}

/// Returns the texture of a PixelTexture's image: width, height, components, then one number per
/// pixel, from the lower left, row by row upwards. `None` for an image without pixels; an error
/// describes valid numbers.
///
/// Components: 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA, the first in the highest byte.
pub(super) fn pixels(image: &[i64], memory: &mut LoadMemory) -> Result<Option<Arc<Texture>>, PictureError> {
    let Some((width, height)) = size_of_image(image).map_err(PictureError::Pixels)? else { return Ok(None) };
    let (texture, beside) = Texture::bytes_for(width, height);
    memory.reserve_result(texture).map_err(PictureError::OverMemory)?;
    let _work = memory.work(beside).map_err(PictureError::OverMemory)?;
    let texture = Texture::new(width, height, rgba(image, width));
    texture.map(|t| Some(Arc::new(t))).map_err(|e| PictureError::Pixels(e.to_string()))
}

/// Returns width and height of a PixelTexture's image; `None` if it has no pixels.
fn size_of_image(image: &[i64]) -> Result<Option<(u32, u32)>, String> {
    let &[width, height, components, ref pixels @ ..] = image else {
        return Err("width, height and components first".into());
    };
    if width == 0 || height == 0 {
        return Ok(None);
    }
    if !(1..=4).contains(&components) {
        return Err(format!("1 to 4 components, not {components}"));
    }
    let count = width.saturating_mul(height);
    if pixels.len() as i64 != count {
        return Err(format!("{width} x {height} = {count} pixels, not {}", pixels.len()));
    }
    let side = 1..=i64::from(MAX_TEXTURE_SIDE);
    if !side.contains(&width) || !side.contains(&height) {
        return Err(format!("1 to {MAX_TEXTURE_SIDE} pixels a side, not {width} x {height}"));
    }
    Ok(Some((width as u32, height as u32)))
}

/// Returns the RGBA bytes of a valid image, row 0 at the top.
fn rgba(image: &[i64], width: u32) -> Vec<u8> {
    let (components, pixels) = (image[2], &image[3..]);
    let mut bytes = Vec::with_capacity(pixels.len() * 4);
    for row in pixels.chunks_exact(width as usize).rev() {
        for &pixel in row {
            let byte = |i: i64| (pixel >> (8 * i)) as u8;
            bytes.extend(match components {
                1 => [byte(0), byte(0), byte(0), 255],
                2 => [byte(1), byte(1), byte(1), byte(0)],
                3 => [byte(2), byte(1), byte(0), 255],
                _ => [byte(3), byte(2), byte(1), byte(0)],
            });
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(image: &[i64]) -> Result<Option<Arc<Texture>>, PictureError> {
        super::pixels(image, &mut LoadMemory::unlimited())
    }

    #[test]
    fn pixels_run_from_the_lower_left_and_components_from_the_high_byte() {
        let texture = pixels(&[2, 2, 1, 0, 0x7f, 0xff, 0x40]).unwrap().unwrap();
        assert_eq!(texture.bytes().iter().step_by(4).copied().collect::<Vec<_>>(), [0xff, 0x40, 0, 0x7f]);
        let one = |components, pixel| pixels(&[1, 1, components, pixel]).unwrap().unwrap().bytes().to_vec();
        assert_eq!(one(2, 0x7f80), [0x7f, 0x7f, 0x7f, 0x80]);
        assert_eq!(one(3, 0x010203), [1, 2, 3, 255]);
        assert_eq!(one(4, 0x01020304), [1, 2, 3, 4]);
        assert!(pixels(&[0, 0, 0]).unwrap().is_none());
        for wrong in
            [&[2_i64][..], &[1, 1, 5, 0], &[2, 2, 1, 0, 0, 0], &[1, 1, 1, 0, 0], &[1 << 31, 1 << 31, 1]]
        {
            assert!(pixels(wrong).is_err(), "{wrong:?}");
        }
    }
}

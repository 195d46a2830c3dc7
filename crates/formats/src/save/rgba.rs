//! Decoded pictures as raw RGBA bytes.
//!
//! In: a picture of the crate `image`, in the pixel format of its file. Out: R,G,B,A bytes, row 0
//! at the top: grey becomes three equal channels, pictures without alpha are opaque, 16 bits are
//! rounded to the nearest of 8. `image` converts to the same bytes, and the tests compare with it;
//! here the loops are compiled at the level of this crate, `image` without optimization
//! (`Cargo.toml`). Goldens and the loader of textures share this, and `load` may use `save`.

use image::DynamicImage;

/// Returns the pixels of `picture`.
pub(crate) fn rgba8(picture: DynamicImage) -> Vec<u8> {
    match picture {
        DynamicImage::ImageRgba8(p) => p.into_raw(),
        DynamicImage::ImageLuma8(p) => pixels(&p, |[y]: [u8; 1]| [y, y, y, 255]),
        DynamicImage::ImageLumaA8(p) => pixels(&p, |[y, a]| [y, y, y, a]),
        DynamicImage::ImageRgb8(p) => pixels(&p, |[r, g, b]| [r, g, b, 255]),
        DynamicImage::ImageLuma16(p) => pixels(&p, |[y]: [u16; 1]| {
            let y = rounded(y);
            [y, y, y, 255]
        }),
        DynamicImage::ImageLumaA16(p) => pixels(&p, |[y, a]: [u16; 2]| {
            let y = rounded(y);
            [y, y, y, rounded(a)]
        }),
        DynamicImage::ImageRgb16(p) => pixels(&p, |[r, g, b]| [rounded(r), rounded(g), rounded(b), 255]),
        DynamicImage::ImageRgba16(p) => pixels(&p, |rgba: [u16; 4]| rgba.map(rounded)),
        // Formats in f32, which no decoder that is built gives, and whatever the crate adds.
        other => other.into_rgba8().into_raw(),
    }
}

/// Converts pixels of N channels one by one; `samples` holds whole pixels.
fn pixels<T: Copy, const N: usize>(samples: &[T], convert: impl Fn([T; N]) -> [u8; 4]) -> Vec<u8> {
    let mut out = vec![0; samples.len() / N * 4];
    for (to, from) in out.as_chunks_mut::<4>().0.iter_mut().zip(samples.as_chunks::<N>().0) {
        *to = convert(*from);
    }
    out
}

/// Returns v / 257, rounded to the nearest integer.
fn rounded(v: u16) -> u8 {
    ((u32::from(v) + 128) / 257) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::ImageBuffer;

    /// Returns 7x5 pixels of N channels, and for 16 bits values around rounding borders.
    fn samples<T, const N: usize>(value: impl Fn(u32) -> T) -> Vec<T> {
        (0..7 * 5 * N as u32).map(value).collect()
    }

    #[test]
    fn every_format_gives_the_bytes_that_image_converts_to() {
        let bytes = |k: u32| (k * 37 % 256) as u8;
        let words = |k: u32| (k / 3 * 257 + 127 + k % 3) as u16;
        let picture = |kind: usize| match kind {
            0 => DynamicImage::ImageLuma8(ImageBuffer::from_raw(7, 5, samples::<_, 1>(bytes)).unwrap()),
            1 => DynamicImage::ImageLumaA8(ImageBuffer::from_raw(7, 5, samples::<_, 2>(bytes)).unwrap()),
            2 => DynamicImage::ImageRgb8(ImageBuffer::from_raw(7, 5, samples::<_, 3>(bytes)).unwrap()),
            3 => DynamicImage::ImageRgba8(ImageBuffer::from_raw(7, 5, samples::<_, 4>(bytes)).unwrap()),
            4 => DynamicImage::ImageLuma16(ImageBuffer::from_raw(7, 5, samples::<_, 1>(words)).unwrap()),
            5 => DynamicImage::ImageLumaA16(ImageBuffer::from_raw(7, 5, samples::<_, 2>(words)).unwrap()),
            6 => DynamicImage::ImageRgb16(ImageBuffer::from_raw(7, 5, samples::<_, 3>(words)).unwrap()),
            7 => DynamicImage::ImageRgba16(ImageBuffer::from_raw(7, 5, samples::<_, 4>(words)).unwrap()),
            _ => DynamicImage::ImageRgb32F(
                ImageBuffer::from_raw(7, 5, samples::<_, 3>(|k| k as f32 / 105.0)).unwrap(),
            ),
        };
        for kind in 0..9 {
            assert_eq!(rgba8(picture(kind)), picture(kind).into_rgba8().into_raw(), "{kind}");
        }
    }

    #[test]
    fn sixteen_bits_are_rounded_to_the_nearest_byte() {
        for v in 0..=u16::MAX {
            assert_eq!(f64::from(rounded(v)), (f64::from(v) / 257.0).round(), "{v}");
        }
    }
}

//! Compositing: the formulas by which a colour and the pixel under it become the pixel's bytes.
//!
//! There are two, and they differ on purpose:
//! - [`over`] takes bytes, as the 2-D commands have them, and composes alpha too: the frame keeps its
//!   own transparency. It is exact in integers: the quotient by 255, rounded to nearest.
//! - [`blend`] takes real colours and opacities, the results of lighting and textures: rounded to
//!   bytes first, each layer would lose up to half a step twice. A picture of a scene has no holes,
//!   so alpha becomes 255.
//!
//! For colours and opacities that are bytes both give the same red, green and blue (a test below
//! says so): the quotient has an odd denominator, so f64 meets no tie. The twins in vectors, `Paint`
//! of `draw2d` and the blended faces of the tile renderer, give the bytes of these two.

use super::Rgba;
use glam::DVec3;

/// Composites `source` over `dest`: each channel is (s a + d (255 - a) + 127) / 255 in integers,
/// with s = 255 for alpha itself.
///
/// An opaque source gives itself; a source of alpha 0 gives `dest`.
#[inline]
pub fn over(source: Rgba, dest: Rgba) -> Rgba {
    let a = u16::from(source[3]);
    let mix = |s: u8, d: u8| ((u16::from(s) * a + u16::from(d) * (255 - a) + 127) / 255) as u8;
    [mix(source[0], dest[0]), mix(source[1], dest[1]), mix(source[2], dest[2]), mix(255, dest[3])]
}

/// Blends a colour onto a pixel: new = old * t + rgb * (1 - t) on the bytes in memory, t = 1 -
/// opacity.
pub(crate) fn blend(pixel: &mut [u8], rgb: DVec3, opacity: f64) {
    let opacity = opacity.clamp(0.0, 1.0);
    let t = 1.0 - opacity;
    for (byte, c) in pixel.iter_mut().zip(rgb.to_array()) {
        *byte = to_byte(*byte as f64 / 255.0 * t + c * opacity);
    }
    pixel[3] = 255;
}

/// Returns the bytes of an opaque colour.
pub(crate) fn opaque(rgb: DVec3) -> Rgba {
    [to_byte(rgb.x), to_byte(rgb.y), to_byte(rgb.z), 255]
}

/// Converts a colour component to a byte: floor(255 clamp(c, 0, 1) + 0.5); NaN gives 0.
#[inline]
fn to_byte(c: f64) -> u8 {
    // The cast converts NaN to 0.
    (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_round_half_up_and_never_see_nan() {
        assert_eq!([0.0, 0.4, 0.6, 1.0, 7.0, -1.0, f64::NAN].map(to_byte), [0, 102, 153, 255, 255, 0, 0]);
        let mut pixel = [0, 0, 255, 9];
        blend(&mut pixel, DVec3::Y, 0.6);
        assert_eq!(pixel, [0, 153, 102, 255]);
    }

    #[test]
    fn both_formulas_agree_on_bytes_but_for_alpha() {
        for (s, a) in (0..=255u8).flat_map(|s| (0..=255u8).map(move |a| (s, a))) {
            let dest = [0, s.wrapping_mul(7), a.wrapping_add(s), 0];
            let mut blended = dest;
            blend(&mut blended, DVec3::splat(f64::from(s) / 255.0), f64::from(a) / 255.0);
            let composed = over([s, s, s, a], dest);
            assert_eq!(blended[..3], composed[..3], "{s} {a} over {dest:?}");
            assert_eq!([blended[3], composed[3]], [255, a]);
        }
    }
}

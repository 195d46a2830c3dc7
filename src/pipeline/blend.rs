//! Bytes of a pixel: conversion of a colour, and alpha blending with the colour in memory.

use crate::memory::Rgba;
use glam::DVec3;

/// Converts a colour component to a byte: floor(255 clamp(c, 0, 1) + 0.5); NaN gives 0.
#[inline]
pub(crate) fn to_byte(c: f64) -> u8 {
    // The cast converts NaN to 0.
    (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Returns the bytes of an opaque colour.
pub(crate) fn opaque(rgb: DVec3) -> Rgba {
    [to_byte(rgb.x), to_byte(rgb.y), to_byte(rgb.z), 255]
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
}

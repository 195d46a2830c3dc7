//! Recolouring a picture of the eye: outlines, the facets' own colours, light alone, facet numbers.

use crate::viewer::keys::Look;
use fbptr_core::eye::{EyePicture, EyeScene, MISS};

/// Fractional part of the golden ratio; its multiples spread hues evenly.
const GOLDEN: f64 = 0.618_033_988_75;

/// Returns the picture in the colours of a shading style.
pub(super) fn in_false_color(picture: &EyePicture, scene: &EyeScene, look: Look) -> EyePicture {
    let mut out = picture.clone();
    let width = picture.pixels[0] as usize;
    for (i, color) in out.color.iter_mut().enumerate() {
        let facet = picture.facet[i];
        *color = match look {
            Look::AsGiven | Look::Phong => continue,
            Look::Wire => {
                let differs = |j: usize| picture.facet.get(j).is_some_and(|&f| f != facet);
                let is_edge = (!(i + 1).is_multiple_of(width) && differs(i + 1))
                    || (picture.pixels.len() > 1 && differs(i + width));
                [if is_edge { 255.0 } else { 0.0 }; 3]
            }
            _ if facet == MISS => continue,
            Look::Flat => scene.facets[facet as usize].color,
            Look::Gouraud => {
                // The light is the factor by which the facet's own colour was multiplied.
                let (base, seen) = (scene.facets[facet as usize].color, picture.color[i]);
                let channel = (0..3).max_by(|&a, &b| base[a].total_cmp(&base[b])).unwrap_or(0);
                let light = if base[channel] > 0.0 { seen[channel] / base[channel] } else { 0.0 };
                [255.0 * light.min(1.0); 3]
            }
            Look::Textured => false_color(facet),
        };
    }
    out
}

/// Returns a bright colour for a number, far from those of adjacent numbers.
fn false_color(number: i32) -> [f64; 3] {
    let hue = (f64::from(number) * GOLDEN).fract() * 6.0;
    let wave = |shift: f64| {
        let x = ((hue + shift) % 6.0 - 3.0).abs() - 1.0;
        60.0 + 195.0 * x.clamp(0.0, 1.0)
    };
    [wave(0.0), wave(4.0), wave(2.0)]
}

//! Stages 6, 7 and 10: a face to pixels - coverage, depth, and the bytes.
//!
//! Each covered pixel is decided for itself, at its centre, in f64: no value is carried from pixel to pixel.

use super::assemble::Face;
use super::call::{DrawStats, Target};
use super::light::Lighting;
use super::plane::{FacePlane, Weights};
use super::sample::Footprint;
use super::shade::{FaceShade, uv_from_first};
use super::viewport::Screen;
use crate::memory::{DepthMemory, IdMemory, Rgba};
use crate::scene::Interpolation;
use glam::{DVec2, DVec3};

/// A byte of a colour: floor(255 clamp(c, 0, 1) + 0.5); NaN is 0.
#[inline]
pub(crate) fn to_byte(c: f64) -> u8 {
    // The cast takes NaN to 0.
    (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// What a draw does with a pixel that passed, in every mode the same for all of its faces.
pub(crate) struct Raster<'r, 't> {
    pub target: &'r mut Target<'t>,
    pub screen: &'r Screen,
    pub lighting: &'r Lighting,
    pub interp: Interpolation,
    /// Whether w differs from 1 anywhere.
    pub divide: bool,
    /// Whether depth is tested and written.
    pub depth: bool,
    pub name: u32,
}

/// Which memories a pixel writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Writes {
    /// Colour, and depth where it is kept (transparent faces don't write it).
    Color,
    /// Depth alone: what hides the lines of a wireframe.
    DepthOnly,
}

impl Raster<'_, '_> {
    /// Draws one face; `triangle` is its number for the id memory.
    pub fn face(
        &mut self,
        face: &Face,
        shade: &FaceShade,
        triangle: u32,
        writes: Writes,
        stats: &mut DrawStats,
    ) {
        let solid = shade.solid();
        let (plane, screen, lighting) = (&face.plane, self.screen, self.lighting);
        let width = self.target.memory.width() as usize;
        let mut depth = self.target.depth.as_mut().filter(|_| self.depth);
        let size = (self.target.memory.width(), self.target.memory.height());
        let ids = self.target.ids.as_deref_mut();
        let mut ids = ids.filter(|i| depth.is_some() && (i.width(), i.height()) == size);
        let memory = &mut *self.target.memory;
        let (interp, divide) = (self.interp, self.divide);
        let shares_of = |weights: &Weights| plane.shares(weights, interp, divide);
        for outline in face.outlines.iter().flatten() {
            outline.for_each_span(screen.clip, |y, xs| {
                let mut row_is_written = false;
                for x in xs {
                    let ndc = screen.ndc_of_pixel(x, y);
                    // 7: depth
                    stats.pixels_tested += 1;
                    let Some(weights) = plane.clamped(plane.weights_at(ndc)) else { continue };
                    let (mut z, complement) = plane.depth(&weights);
                    if face.wholly_between_near_and_far {
                        z = z.max(0.0);
                    } else if !(0.0..1.0).contains(&z) {
                        continue;
                    }
                    let index = width * y as usize + x as usize;
                    let mut passed = None;
                    if let Some(depth) = &mut depth {
                        let word = depth.format().encode(z, complement.max(0.0));
                        if word >= depth.word(index) {
                            continue;
                        }
                        passed = Some(word);
                    }
                    let store_depth =
                        |depth: &mut Option<&mut DepthMemory>, ids: &mut Option<&mut IdMemory>| {
                            if let (Some(depth), Some(word)) = (depth, passed) {
                                depth.set_word(index, word);
                                if let Some(ids) = ids {
                                    ids.set(index, self.name, triangle);
                                }
                            }
                        };
                    if writes == Writes::DepthOnly {
                        store_depth(&mut depth, &mut ids);
                        continue;
                    }
                    // 8 and 9: attributes and colour
                    let (rgb, opacity) = match solid {
                        Some(solid) => solid,
                        None => {
                            let Some(s) = shares_of(&weights) else { continue };
                            let footprint = |uv: &[DVec2; 3]| footprint(plane, screen, shares_of, [x, y], uv);
                            shade.at(s, footprint, lighting, stats)
                        }
                    };
                    // 10: the bytes
                    let pixel = &mut memory.bytes_mut()[index * 4..index * 4 + 4];
                    if shade.is_transparent {
                        blend(pixel, rgb, opacity);
                    } else {
                        store_depth(&mut depth, &mut ids);
                        pixel.copy_from_slice(&opaque(rgb));
                    }
                    stats.pixels_written += 1;
                    row_is_written = true;
                }
                if row_is_written {
                    memory.mark_row(y as u32);
                }
            });
        }
    }
}

/// How far the texture runs from the pixel to its neighbours on the right and below, on the face's plane.
pub(crate) fn footprint(
    plane: &FacePlane,
    screen: &Screen,
    shares_of: impl Fn(&Weights) -> Option<[f64; 3]>,
    [x, y]: [i32; 2],
    uv: &[DVec2; 3],
) -> Footprint {
    let at = |x: i32, y: i32| {
        let ndc = screen.ndc_of_pixel(x, y);
        shares_of(&plane.weights_at(ndc)).map(|s| uv_from_first(uv, s))
    };
    match (at(x, y), at(x + 1, y), at(x, y + 1)) {
        (Some(here), Some(right), Some(below)) => Footprint::Steps(right - here, below - here),
        _ => Footprint::Horizon,
    }
}

/// The bytes of an opaque colour.
pub(crate) fn opaque(rgb: DVec3) -> Rgba {
    [to_byte(rgb.x), to_byte(rgb.y), to_byte(rgb.z), 255]
}

/// new = old * t + rgb * (1 - t) on the bytes in memory, t = 1 - opacity.
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

//! Stages 6, 7 and 10: coverage, depth test and pixel writes of a face.
//!
//! Each covered pixel is evaluated independently at its centre, in f64: no value is carried from
//! pixel to pixel.

use super::assemble::Face;
use super::draw_call::{DrawStats, Target};
use super::light::Lighting;
use super::plane_equation::{FacePlane, Weights};
use super::sampler::Footprint;
use super::shade::{FaceShade, ShadingFrequency, uv_from_first};
use super::tile::{BlendedFace, BlendedFaceKernel, ClipRect, DepthEncoder};
use super::viewport::ViewportTransform;
use crate::math::coverage::PixelRect;
use crate::memory::{DepthFormat, DepthWords, PickBuffer, Rgba};
use crate::scene::{Filling, Interpolation};
use crate::simd::Level;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// Converts a colour component to a byte: floor(255 clamp(c, 0, 1) + 0.5); NaN gives 0.
#[inline]
pub(crate) fn to_byte(c: f64) -> u8 {
    // The cast converts NaN to 0.
    (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Some rows of a render target, and the clip rectangle of the draw.
pub(crate) struct TargetRows<'t> {
    /// Pixels per row.
    width: usize,
    /// Clip rectangle in pixels of the frame; it lies within these rows.
    clip: PixelRect,
    /// Index of the first row.
    y0: u32,
    /// Colour bytes of these rows, four per pixel.
    bytes: &'t mut [u8],
    /// Depth words of these rows; `None` if depth is not used.
    depth: Option<(DepthFormat, DepthWords<'t>)>,
    /// Pick-buffer ids of these rows.
    ids: Option<&'t mut [[u32; 2]]>,
    /// Range of rows that were written.
    pub written: Range<u32>,
}

impl<'t> TargetRows<'t> {
    /// Returns all rows of the frame. With `depth`, depth is tested and written, and so are ids if
    /// the target has a pick buffer.
    pub fn new(target: &'t mut Target, clip: PixelRect, depth: bool) -> Self {
        let size = (target.memory.width(), target.memory.height());
        let depth = target.depth.as_mut().filter(|_| depth).map(|d| (d.format(), d.words_mut()));
        let ids = target.ids.as_deref_mut();
        let ids = ids.filter(|i| depth.is_some() && (i.width(), i.height()) == size).map(PickBuffer::ids_mut);
        let bytes = target.memory.bytes_mut();
        TargetRows { width: size.0 as usize, clip, y0: 0, bytes, depth, ids, written: 0..0 }
    }

    /// Returns the rows inside the clip rectangle.
    pub fn rows(&self) -> Range<i32> {
        self.clip.y0..self.clip.y1
    }

    /// Splits into the rows above `row` of the frame, and those from it on.
    pub fn split(self, row: u32) -> (Self, Self) {
        let (width, y0) = (self.width, self.y0);
        let end = y0 + (self.bytes.len() / (width * 4)) as u32;
        let row = row.clamp(y0, end);
        let pixels = (row - y0) as usize * width;
        let (bytes, bytes_below) = self.bytes.split_at_mut(pixels * 4);
        let (depth, depth_below) = match self.depth {
            None => (None, None),
            Some((format, words)) => {
                let (a, b) = words.split_at(pixels);
                (Some((format, a)), Some((format, b)))
            }
        };
        let (ids, ids_below) = self.ids.map(|ids| ids.split_at_mut(pixels)).unzip();
        let at = row as i32;
        let above = PixelRect { y1: self.clip.y1.min(at), ..self.clip };
        let below = PixelRect { y0: self.clip.y0.max(at), ..self.clip };
        (
            TargetRows { width, clip: above, y0, bytes, depth, ids, written: 0..0 },
            TargetRows {
                width,
                clip: below,
                y0: row,
                bytes: bytes_below,
                depth: depth_below,
                ids: ids_below,
                written: 0..0,
            },
        )
    }

    /// Stores a depth word, and the id if ids are kept. No effect without depth.
    #[inline]
    fn store_depth(&mut self, index: usize, word: Option<u32>, id: [u32; 2]) {
        if let (Some((_, words)), Some(word)) = (&mut self.depth, word) {
            words.set_word(index, word);
            if let Some(ids) = &mut self.ids {
                ids[index] = id;
            }
        }
    }

    fn mark_row(&mut self, y: u32) {
        let w = &mut self.written;
        *w = if w.start >= w.end { y..y + 1 } else { w.start.min(y)..w.end.max(y + 1) };
    }
}

/// Rasterizer state that all faces of a draw share.
pub(crate) struct Raster<'r, 't> {
    pub target_rows: &'r mut TargetRows<'t>,
    /// NDC to pixels.
    pub screen: &'r ViewportTransform,
    pub lighting: &'r Lighting,
    /// Interpolation of attributes.
    pub interp: Interpolation,
    /// True unless w is 1 everywhere.
    pub divide: bool,
    /// First word of the pick-buffer ids; the second is the triangle.
    pub name: u32,
}

/// Buffers that a pixel writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WriteMask {
    /// Colour, and depth if the draw has it (transparent faces do not write it).
    Color,
    /// Depth only: the hidden-line removal of a wireframe.
    DepthOnly,
}

impl Face {
    /// Returns the colour and opacity of the face at the centre of a pixel; `None` where its plane
    /// has no point in front of the eye.
    pub fn pixel(
        &self,
        shade: &FaceShade,
        [x, y]: [i32; 2],
        screen: &ViewportTransform,
        lighting: &Lighting,
        (interp, divide): (Interpolation, bool),
        stats: &mut DrawStats,
    ) -> Option<(DVec3, f64)> {
        if let Some(solid) = shade.solid() {
            return Some(solid);
        }
        let weights = self.plane.clamped(self.plane.weights_at(screen.ndc_of_pixel(x, y)))?;
        self.color_at(&weights, shade, [x, y], screen, lighting, (interp, divide), stats)
    }

    /// Stages 8 and 9: returns the interpolated colour at these weights.
    #[inline]
    #[expect(clippy::too_many_arguments, reason = "a pixel's whole surroundings")]
    fn color_at(
        &self,
        weights: &Weights,
        shade: &FaceShade,
        [x, y]: [i32; 2],
        screen: &ViewportTransform,
        lighting: &Lighting,
        (interp, divide): (Interpolation, bool),
        stats: &mut DrawStats,
    ) -> Option<(DVec3, f64)> {
        let plane = &self.plane;
        let shares_of = |weights: &Weights| plane.barycentrics(weights, interp, divide);
        let barycentrics = shares_of(weights)?;
        let footprint = |uv: &[DVec2; 3]| footprint(plane, screen, shares_of, [x, y], uv);
        Some(shade.at(barycentrics, footprint, lighting, stats))
    }
}

impl Raster<'_, '_> {
    /// Draws one face; `triangle` is its index for the pick buffer.
    pub fn face(
        &mut self,
        face: &Face,
        shade: &FaceShade,
        triangle: u32,
        writes: WriteMask,
        stats: &mut DrawStats,
    ) {
        let solid = shade.solid();
        let (plane, screen, lighting) = (&face.plane, self.screen, self.lighting);
        let (interp, divide, name) = (self.interp, self.divide, self.name);
        let target_rows = &mut *self.target_rows;
        let (width, first_row) = (target_rows.width, target_rows.y0 as i32);
        let crossing = face.crossing(screen);
        for outline in face.outlines.iter().flatten() {
            outline.for_each_span(target_rows.clip, |y, xs| {
                let mut row_is_written = false;
                for x in xs {
                    let ndc = screen.ndc_of_pixel(x, y);
                    // Stage 7: depth
                    stats.pixels_tested += 1;
                    let Some(weights) = plane.clamped(plane.weights_at(ndc)) else { continue };
                    if crossing.is_some_and(|plane| !plane.is_between_near_and_far(face.z_range, x, y)) {
                        continue;
                    }
                    let (z, complement) = plane.depth(&weights);
                    let index = width * (y - first_row) as usize + x as usize;
                    let mut passed = None;
                    if let Some((format, words)) = &target_rows.depth {
                        let word = format.encode(z.clamp(0.0, 1.0), complement.clamp(0.0, 1.0));
                        if word >= words.word(index) {
                            continue;
                        }
                        passed = Some(word);
                    }
                    if writes == WriteMask::DepthOnly {
                        target_rows.store_depth(index, passed, [name, triangle]);
                        continue;
                    }
                    // Stages 8 and 9: attributes and colour
                    let (rgb, opacity) = match (shade.fill.at(x, y), solid) {
                        (Filling::Nothing, _) => continue,
                        (Filling::Hatch(color), _) => (color, 1.0),
                        (Filling::Face, Some(solid)) => solid,
                        (Filling::Face, None) => {
                            let at = [x, y];
                            match face.color_at(
                                &weights,
                                shade,
                                at,
                                screen,
                                lighting,
                                (interp, divide),
                                stats,
                            ) {
                                Some(color) => color,
                                None => continue,
                            }
                        }
                    };
                    // Stage 10: the bytes
                    if !shade.is_transparent {
                        target_rows.store_depth(index, passed, [name, triangle]);
                    }
                    let pixel = &mut target_rows.bytes[index * 4..index * 4 + 4];
                    if shade.is_transparent {
                        blend(pixel, rgb, opacity);
                    } else {
                        pixel.copy_from_slice(&opaque(rgb));
                    }
                    stats.pixels_written += 1;
                    row_is_written = true;
                }
                if row_is_written {
                    target_rows.mark_row(y as u32);
                }
            });
        }
    }
}

impl Raster<'_, '_> {
    /// Draws one face by the vector kernels, with the same bytes as [`Raster::face`].
    pub fn blended_face(
        &mut self,
        level: Level,
        blended_face: &BlendedFace,
        (face, shade): (&Face, &FaceShade),
        triangle: u32,
        stats: &mut DrawStats,
    ) {
        let (screen, lighting, rules) = (self.screen, self.lighting, (self.interp, self.divide));
        let exact = |x: i32, y: i32, pixel: &mut [u8]| {
            let own = &mut DrawStats::default();
            match face.pixel(shade, [x, y], screen, lighting, rules, own) {
                Some((rgb, opacity)) if shade.is_transparent => blend(pixel, rgb, opacity),
                Some((rgb, _)) => pixel.copy_from_slice(&opaque(rgb)),
                None => {}
            }
        };
        let target_rows = &mut *self.target_rows;
        let encoder = target_rows.depth.as_ref().and_then(|(format, _)| DepthEncoder::of(*format));
        let (depth, narrow): (&mut [i32], &mut [u16]) = match &mut target_rows.depth {
            Some((_, DepthWords::Wide(words))) => (words, &mut []),
            Some((_, DepthWords::Narrow(words))) => (&mut [], words),
            None => (&mut [], &mut []),
        };
        let has_depth = !(depth.is_empty() && narrow.is_empty());
        let pick: &mut [[u32; 2]] = match &mut target_rows.ids {
            Some(ids) if !shade.is_transparent && has_depth => ids,
            _ => &mut [],
        };
        let clip = target_rows.clip;
        let own = level.dispatch(BlendedFaceKernel {
            blended_face,
            view: ClipRect { x0: clip.x0, y0: clip.y0, x1: clip.x1, y1: clip.y1 },
            y0: target_rows.y0 as i32,
            width: target_rows.width,
            bytes: target_rows.bytes,
            depth,
            narrow,
            encoder,
            pick,
            id: [self.name, triangle],
            exact: &exact,
        });
        stats.pixels_tested += own.tested;
        stats.pixels_written += own.written;
        if matches!(shade.light, ShadingFrequency::Pixels { .. }) {
            stats.pixels_lit += own.written;
        }
        if own.rows.0 < own.rows.1 {
            target_rows.mark_row(own.rows.0 as u32);
            target_rows.mark_row(own.rows.1 as u32 - 1);
        }
    }
}

/// Returns the steps of u, v from a pixel to its neighbours on the right and below, on the face's
/// plane.
pub(crate) fn footprint(
    plane: &FacePlane,
    screen: &ViewportTransform,
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

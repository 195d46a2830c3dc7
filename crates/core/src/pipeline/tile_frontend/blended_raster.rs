//! Rasterizes a blended face by the vector kernels, in rows of a render target.

use crate::memory::{DepthWords, blend, opaque};
use crate::pipeline::assemble::Face;
use crate::pipeline::draw_call::DrawStats;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::shade::{FaceShade, ShadingFrequency};
use crate::pipeline::target_rows::TargetRows;
use crate::pipeline::tile::{BlendedFace, BlendedFaceKernel, DepthEncoder};
use crate::simd::Level;

/// A face as the vector kernels draw it, and as the reference does single pixels of it.
pub(crate) struct BlendedRaster<'r> {
    /// The face's draw.
    pub prepared: &'r PreparedDraw<'r>,
    /// Index of the triangle, for the pick buffer.
    pub triangle: u32,
    /// The face for the vector kernels.
    pub blended_face: &'r BlendedFace<'r>,
    /// The assembled face.
    pub face: &'r Face,
    /// Inputs of its pixels' colours.
    pub shade: &'r FaceShade<'r>,
}

impl BlendedRaster<'_> {
    /// Draws the face with the bytes of the reference.
    pub fn draw(&self, level: Level, target_rows: &mut TargetRows) -> DrawStats {
        let BlendedRaster { prepared, triangle, blended_face, face, shade } = *self;
        let rules = prepared.pixel_rules();
        let exact = |x: i32, y: i32, pixel: &mut [u8]| {
            let own = &mut DrawStats::default();
            match face.pixel(shade, [x, y], &rules, own) {
                Some((rgb, opacity)) if shade.is_transparent => blend(pixel, rgb, opacity),
                Some((rgb, _)) => pixel.copy_from_slice(&opaque(rgb)),
                None => {}
            }
        };
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
        let own = level.dispatch(BlendedFaceKernel {
            blended_face,
            view: target_rows.clip,
            y0: target_rows.y0 as i32,
            width: target_rows.width,
            bytes: target_rows.bytes,
            depth,
            narrow,
            encoder,
            pick,
            id: [prepared.call.name, triangle],
            exact: &exact,
        });
        if own.rows.0 < own.rows.1 {
            target_rows.mark_row(own.rows.0 as u32);
            target_rows.mark_row(own.rows.1 as u32 - 1);
        }
        let is_lit = matches!(shade.light, ShadingFrequency::Pixels { .. });
        DrawStats {
            pixels_tested: own.tested,
            pixels_written: own.written,
            pixels_lit: if is_lit { own.written } else { 0 },
            ..DrawStats::default()
        }
    }
}

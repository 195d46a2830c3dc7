//! Stages 6, 7 and 10: coverage, depth test and pixel writes of a face.
//!
//! Each covered pixel is evaluated independently at its centre, in f64: no value is carried from
//! pixel to pixel.

use crate::memory::{blend, opaque};
use crate::pipeline::assemble::Face;
use crate::pipeline::draw_call::DrawStats;
use crate::pipeline::pixel::PixelRules;
use crate::pipeline::shade::FaceShade;
use crate::pipeline::target_rows::TargetRows;
use crate::scene::Filling;

/// Rasterizer state that all faces of a draw share.
pub(crate) struct Raster<'r, 't> {
    pub target_rows: &'r mut TargetRows<'t>,
    pub rules: PixelRules<'r>,
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
        let (rules, name) = (self.rules, self.name);
        let screen = rules.screen;
        let target_rows = &mut *self.target_rows;
        let (width, first_row) = (target_rows.width, target_rows.y0 as i32);
        let crossing = face.crossing(screen);
        for outline in face.outlines.iter().flatten() {
            outline.for_each_span(target_rows.clip, |y, xs| {
                let mut row_is_written = false;
                target_rows.open(y, xs.clone());
                for x in xs {
                    // Stage 7: depth
                    stats.pixels_tested += 1;
                    let Some((weights, z, complement)) = face.point_at([x, y], screen, crossing.as_ref())
                    else {
                        continue;
                    };
                    let index = width * (y - first_row) as usize + x as usize;
                    let mut passed = None;
                    if let Some((format, words)) = &target_rows.depth {
                        let word = format.encode(z, complement);
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
                            match face.color_at(&weights, shade, [x, y], &rules, stats) {
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

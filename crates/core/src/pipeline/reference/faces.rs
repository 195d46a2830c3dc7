//! Stages 4 to 10 for one triangle of a prepared draw.

use super::rasterize::{Raster, WriteMask};
use crate::math::coverage::PixelRect;
use crate::pipeline::assemble::Face;
use crate::pipeline::draw_call::{DrawStats, Target};
use crate::pipeline::light::LitColor;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::shade::{FaceShade, ShadingFrequency};
use crate::pipeline::target_rows::TargetRows;
use crate::scene::FillStyle;
use glam::DVec3;

impl PreparedDraw<'_> {
    /// Runs stages 4 to 10 for one triangle.
    pub fn draw_face(&self, triangle: u32, target: &mut Target, stats: &mut DrawStats) {
        let Some(face) = self.assemble(triangle, stats) else { return };
        let shade = self.shade(triangle, face.side, stats);
        self.cover(&face, &shade, triangle, WriteMask::Color, target, stats);
    }

    /// Runs stages 6, 7 and 10 for one triangle, writing depth only.
    pub fn draw_depth(&self, triangle: u32, target: &mut Target, stats: &mut DrawStats) {
        let Some(face) = self.assemble(triangle, stats) else { return };
        let shade = FaceShade {
            light: ShadingFrequency::Constant(LitColor {
                diffuse_ambient: DVec3::ZERO,
                specular_emissive: DVec3::ZERO,
            }),
            colors: None,
            texture: None,
            stages: None,
            maps: None,
            fill: FillStyle::default(),
            positions: [DVec3::ZERO; 3],
            opacity: 1.0,
            fog: None,
            is_transparent: false,
        };
        self.cover(&face, &shade, triangle, WriteMask::DepthOnly, target, stats);
    }

    /// Rasterizes an assembled face and marks the rows written. A draw that is preempted stops between
    /// bands of rows of a large face.
    fn cover(
        &self,
        face: &Face,
        shade: &FaceShade,
        triangle: u32,
        writes: WriteMask,
        target: &mut Target,
        stats: &mut DrawStats,
    ) {
        let PixelRect { x0, y0, x1, y1 } = self.bounds_of(triangle);
        let rows = self.preemption.rows_at_once(x1 - x0, y1 - y0);
        for top in (y0..y1).step_by(rows as usize) {
            if self.cancel.is_cancelled() {
                return;
            }
            let mut target_rows = self.target_rows(target);
            (target_rows.clip.y0, target_rows.clip.y1) = (top, y1.min(top + rows));
            self.raster(&mut target_rows).face(face, shade, triangle, writes, stats);
            let written = target_rows.written;
            target.memory.mark_rows(written);
            self.preemption.point(target);
        }
    }

    /// Returns the rasterizer of this draw's faces.
    pub fn raster<'r, 't>(&'r self, target_rows: &'r mut TargetRows<'t>) -> Raster<'r, 't> {
        Raster { target_rows, rules: self.pixel_rules(), name: self.call.name }
    }
}

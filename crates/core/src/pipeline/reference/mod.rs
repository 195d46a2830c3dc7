//! The reference: the pipeline's stages one after the other, face by face and pixel by pixel, in
//! f64.
//!
//! In: a [`DrawCall`] or a prepared draw. Out: its picture, which every other path is compared with.
//! It runs on the calling thread and imports nothing of the tile renderer.

mod faces;
mod line_clip;
mod lines;
mod rasterize;

pub(crate) use lines::wire_bytes;
pub(crate) use rasterize::WriteMask;

use super::depth_sort::FaceOrder;
use super::draw_call::{DrawCall, DrawStats, PipelineError, Target};
use super::plan::Part;
use super::prepared_draw::PreparedDraw;
use crate::scene::ShadeMode;

/// Draws one mesh, opaque and transparent faces alike, in file order or sorted by depth under the
/// painter's algorithm.
///
/// # Errors
/// When the camera makes no picture, when the model matrix is not affine or not finite, or when the
/// mesh has an index outside its own arrays. The target is then untouched.
pub fn draw(target: &mut Target, call: &DrawCall) -> Result<DrawStats, PipelineError> {
    let mut stats = DrawStats::default();
    // 1 plan, 2 transform vertices, 3 normals
    let prepared = PreparedDraw::new(call, target, &mut stats)?;
    prepared.open_buffers(target);
    if call.shade == ShadeMode::Wire {
        prepared.draw_wire(target, &mut stats);
    } else {
        let mut order = FaceOrder::default();
        let all = std::slice::from_ref(&prepared);
        order.collect_faces(all, |_, _| true);
        if prepared.parts.uses(Part::SortFaces) {
            order.sort(all, prepared.cancel);
        }
        for &(_, triangle) in order.list() {
            // 4 cull, 5 cut at the eye, 6 coverage, 7 depth, 8 attributes, 9 shade, 10 blend and
            // write
            prepared.draw_face(triangle, target, &mut stats);
        }
    }
    // 11 lines and points of the mesh
    prepared.draw_lines(target, &mut stats);
    prepared.draw_points(target, &mut stats);
    Ok(stats)
}

//! The 3-D pipeline: object space to bytes in numbered stages, in f64 - the plain path that is the project's exact answer.
//!
//! In: a [`DrawCall`] (a mesh and every state that its picture depends on) or a whole [`Scene`](crate::scene::Scene).
//! Out: bytes in video memory, depths in depth memory, [`DrawStats`]. No thread, no I/O; nothing here uses FMA or the
//! system's libm, so the same call gives the same bytes on every machine.
//!
//! Spaces, in order: object -> (model) world -> view, looking along -z -> clip, -w<=x<=w, -w<=y<=w, 0<=z<=w -> NDC ->
//! screen, pixels, y down, centres at .5. Column vectors.
//!
//! What is exact: coverage, in whole numbers on vertices snapped to 1/256 pixel. What is worked in f64 at each pixel's
//! centre on the face's own unsnapped plane, relative to a vertex: depth, and everything that runs across a face. One would
//! know an error by comparing with `truth`, which works the same formulas with 32 digits and another method each.
//!
//! Source: notes 000 (stages, clipping, Phong), 001 (matrices), 003 (interpolation, mip-maps, depth, transparency), 004
//! (projections).

mod assemble;
mod backdrop;
mod clip;
mod depth_sort;
mod draw_call;
mod geometry_cache;
mod light;
mod lines;
mod normals;
mod ordered;
mod plan;
mod plane_equation;
mod planner;
mod prepared_draw;
pub mod quality;
mod rasterize;
mod renderer;
mod sampler;
mod scene;
mod shade;
pub mod tile;
mod tile_frontend;
pub mod trace;
mod vertex;
mod viewport;
mod working;

pub use clip::{ClipVertex, ClippedLine, clip_line, clip_polygon};
pub use draw_call::{CoarseDepth, DepthUse, DrawCall, DrawStats, PipelineError, SceneOptions, Target};
pub(crate) use normals::polygon_normal;
pub use plan::{Part, Plan, PlanItem, Title};
pub use renderer::{RenderOptions, RenderPath, Renderer};
pub use scene::{draw_scene, plan_scene};

use crate::scene::ShadeMode;
use prepared_draw::{Layer, PreparedDraw};

/// Draws one mesh at once, its faces in file order (or sorted by the painter), transparent ones among the others.
///
/// # Errors
/// When the camera makes no picture, the model matrix is not affine or not finite, or the mesh points outside its own
/// arrays; the memories are then untouched.
pub fn draw(target: &mut Target, call: &DrawCall) -> Result<DrawStats, PipelineError> {
    let mut stats = DrawStats::default();
    // 1 plan, 2 transform vertices, 3 normals
    let prepared = PreparedDraw::new(call, target, &mut stats)?;
    prepared.open_buffers(target);
    if call.shade == ShadeMode::Wire {
        prepared.draw_wire(target, &mut stats);
    } else {
        for triangle in prepared.face_order() {
            // 4 cull, 5 cut at the eye, 6 coverage, 7 depth, 8 attributes, 9 shade, 10 blend and write
            prepared.draw_face(triangle, Layer::All, target, &mut stats);
        }
    }
    // 11 lines and points of the mesh
    prepared.draw_lines(target, &mut stats);
    prepared.draw_points(target, &mut stats);
    Ok(stats)
}

/// A file of worked numbers, as the tests keep it.
#[cfg(test)]
fn golden(name: &str) -> serde_json::Value {
    let path = format!("{}/tests/data/golden/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"))
}

#[cfg(test)]
mod tests;

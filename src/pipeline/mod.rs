//! The 3-D pipeline: numbered stages from object space to bytes, in f64. This plain path is the
//! project's exact answer.
//!
//! In: a [`DrawCall`] (a mesh and every state that its picture depends on) or a
//! [`Scene`](crate::scene::Scene). Out: bytes in video memory, depths in depth memory,
//! [`DrawStats`]. It starts no thread and does no I/O. It uses neither FMA nor the system's libm,
//! so equal calls give equal bytes on every machine.
//!
//! Spaces, in order: object -> (model) world -> view, looking along -z -> clip, -w<=x<=w, -w<=y<=w,
//! 0<=z<=w -> NDC -> screen, in pixels, y down, pixel centres at .5. Vectors are columns.
//!
//! Coverage is exact: it is computed in integers on vertices snapped to 1/256 pixel. Depth and
//! interpolated attributes are computed in f64 at each pixel's centre, on the face's unsnapped
//! plane, relative to a vertex. Tests compare with `truth`, which evaluates the same formulas with
//! 32 digits and by different methods.
//!
//! Source: notes 000 (stages, clipping, Phong), 001 (matrices), 003 (interpolation, mip-maps,
//! depth, transparency), 004 (projections).

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
        for triangle in prepared.face_order() {
            // 4 cull, 5 cut at the eye, 6 coverage, 7 depth, 8 attributes, 9 shade, 10 blend and
            // write
            prepared.draw_face(triangle, Layer::All, target, &mut stats);
        }
    }
    // 11 lines and points of the mesh
    prepared.draw_lines(target, &mut stats);
    prepared.draw_points(target, &mut stats);
    Ok(stats)
}

/// Reads a JSON file of reference values from `tests/data/golden`.
#[cfg(test)]
fn golden(name: &str) -> serde_json::Value {
    let path = format!("{}/tests/data/golden/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"))
}

#[cfg(test)]
mod tests;

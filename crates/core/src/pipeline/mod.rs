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
mod empty_draw;
mod far_face;
mod geometry_cache;
mod indexed_mesh;
mod light;
mod materials;
mod mesh_extent;
mod ndc_box;
mod normals;
mod occlusion_history;
mod ordered;
mod path_plan;
mod pixel;
mod plan;
mod plane_equation;
mod planner;
mod preemption;
mod prepared_draw;
#[doc(hidden)]
pub mod quality;
mod reference;
mod renderer;
mod sampler;
mod scene;
mod scene_plan;
mod shade;
mod shading_space;
mod surface_maps;
mod target_rows;
mod tile;
mod tile_frontend;
pub mod trace;
mod vertex;
mod viewport;
mod wide_vertex;
mod working;
mod worst_case;

pub use clip::{ClipVertex, ClippedLine, clip_line, clip_polygon};
pub use draw_call::{
    CoarseDepth, DepthUse, DrawCall, DrawStats, PathCounts, PipelineError, RenderPath, SceneOptions, Target,
};
#[doc(hidden)]
pub use empty_draw::reflects_light;
pub use empty_draw::{EmptyDraw, is_dark};
#[doc(hidden)]
pub use mesh_extent::CoverageBound;
#[doc(hidden)]
pub use ndc_box::{ClipTransform, NdcBox};
#[doc(hidden)]
pub use normals::polygon_normal;
pub use plan::{Part, Plan, PlanItem, Title};
pub use preemption::{Preemption, TargetOwner};
pub use reference::draw;
pub use renderer::{RenderOptions, Renderer, draw_scene};
pub use scene_plan::plan_scene;

/// Reads a JSON file of reference values from `tests/data/golden`.
#[cfg(test)]
fn golden(name: &str) -> serde_json::Value {
    let path = format!("{}/../../tests/data/golden/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"))
}

#[cfg(test)]
mod tests;

//! Stage 1, second half: decides by which path a draw's faces are drawn.
//!
//! In: a prepared draw with the parts of its stages, its target, and the backend. Out: the same with
//! the tile renderer and the faces drawn in order, or the reasons why they are left out. Nothing
//! after it decides: whoever draws follows the parts, and a printed plan has the same.
//!
//! Verified by tests/drawing/plan_paths.rs, which compares plans with counts of what drew.

use super::draw_call::{Backend, CoarseDepth, DrawCall, RenderPath, Target};
use super::geometry_cache::GeometryInfo;
use super::occlusion_history::FEW_FACES;
use super::ordered::face_list_bytes;
use super::plan::{Part, Parts, Plan, PlanRecord};
use super::planner::plan_draw;
use super::prepared_draw::{PreparedDraw, RecycledLists};
use super::scene::NOTHING_HIDDEN;
use super::tile::LIST_BYTES;
use super::tile_frontend::estimated_bytes;
use super::worst_case::{ListLimits, at_worst};
use crate::cancel::CancelToken;
use crate::memory::DepthFormat;
use std::sync::Arc;

/// Reason printed when the caller asks for the reference.
const ON_REQUEST: &str = "the plain path, on request";

impl Plan {
    /// Creates the plan of one DRAW into `target`.
    ///
    /// The cost is linear in the mesh's polygons and corners; vertices are not transformed.
    pub fn of_draw(call: &DrawCall, target: &Target) -> Plan {
        let limits = ListLimits { threads: 1, list_bytes: LIST_BYTES as u64 };
        plan_draw_for(call, target, Backend::default(), limits, None)
    }
}

/// Returns the plan of one draw by a backend, with its working memory.
pub(crate) fn plan_draw_for(
    call: &DrawCall,
    target: &Target,
    backend: Backend,
    limits: ListLimits,
    cached: Option<Arc<GeometryInfo>>,
) -> Plan {
    let mut plan = plan_call(call, target, backend, true, cached);
    let working = at_worst(call, target, Parts::from(&plan), None, limits);
    plan.set_working_bytes(working.sum());
    plan
}

/// Returns the plan of one draw, even if it would be refused, without its working memory. `cached`
/// are the facts about its geometry that a renderer has.
pub(crate) fn plan_call(
    call: &DrawCall,
    target: &Target,
    backend: Backend,
    keeps_depth: bool,
    cached: Option<Arc<GeometryInfo>>,
) -> Plan {
    let new = || Arc::new(GeometryInfo::of(call.geometry, CancelToken::default()));
    let geometry_info = cached.unwrap_or_else(new);
    let camera = PreparedDraw::camera_of(call).unwrap_or_default();
    let prepared = PreparedDraw::of(call, camera, target, geometry_info, RecycledLists::default());
    let mut plan: Plan = plan_draw(call, target, &prepared.lighting, &prepared.geometry_info);
    record_path(&prepared, &mut plan, target, backend, keeps_depth);
    if plan.uses(Part::TileRenderer) {
        plan.set_bytes(Part::TransformVertices, 0);
        plan.set_bytes(Part::TileRenderer, estimated_bytes(call, target, Parts::from(&plan)));
    }
    plan
}

/// Adds the path of the draw's faces to its parts; without `keeps_depth`, leaves depth out.
pub(crate) fn add_path(prepared: &mut PreparedDraw, target: &Target, backend: Backend, keeps_depth: bool) {
    let mut parts = prepared.parts;
    record_path(prepared, &mut parts, target, backend, keeps_depth);
    prepared.parts = parts;
}

/// Decides the path of a draw's faces, and records it in `plan`, which has the parts of `prepared`.
fn record_path(
    prepared: &PreparedDraw,
    plan: &mut impl PlanRecord,
    target: &Target,
    backend: Backend,
    keeps_depth: bool,
) {
    let mesh = &prepared.call.geometry.mesh;
    let faces = mesh.triangles.len() as u64;
    if faces == 0 && mesh.lines.is_empty() && mesh.points.is_empty() {
        return;
    }
    if !keeps_depth {
        plan.leave_out(Part::DepthMemory, NOTHING_HIDDEN);
        plan.leave_out(Part::PickBuffer, NOTHING_HIDDEN);
    }
    let is_plain = backend.path == RenderPath::Plain;
    let no_tiles = if is_plain { Some(ON_REQUEST) } else { prepared.unsupported_reason(target) };
    let Some(no_tiles) = no_tiles else {
        let has_depth = keeps_depth && prepared.parts.uses(Part::DepthMemory);
        return record_tiles(prepared, plan, has_depth.then_some(target.depth_format), backend.coarse);
    };
    let no_vectors = if is_plain { Some(ON_REQUEST) } else { prepared.blended_unsupported_reason(target) };
    plan.leave_out(Part::TileRenderer, no_tiles);
    plan.leave_out(Part::CoarseDepth, "the tile renderer tests no depth");
    match no_vectors {
        None => {
            let bytes = face_list_bytes(faces);
            plan.add(Part::FacesInOrder, "one after the other, in vectors", faces, bytes);
        }
        Some(why) => plan.leave_out(Part::FacesInOrder, why),
    }
}

/// Records that the tile renderer draws the faces; `depth` is the format of the depth that it tests.
fn record_tiles(
    prepared: &PreparedDraw,
    plan: &mut impl PlanRecord,
    depth: Option<DepthFormat>,
    coarse: CoarseDepth,
) {
    let occlusion = prepared.geometry_info.occlusion.get();
    let faces = prepared.call.geometry.mesh.triangles.len() as u64;
    let reason = "opaque faces: first what is seen, then its colour, in vectors";
    plan.add(Part::TileRenderer, reason, faces, 0);
    plan.leave_out(Part::FacesInOrder, "the tile renderer draws them");
    let Some(format) = depth else {
        return plan.leave_out(Part::CoarseDepth, "the tile renderer tests no depth");
    };
    match (coarse, format) {
        (CoarseDepth::Off, _) => plan.leave_out(Part::CoarseDepth, "off, on request"),
        (_, DepthFormat::U16 | DepthFormat::U24 | DepthFormat::U32 | DepthFormat::Reversed) => {
            plan.leave_out(Part::CoarseDepth, "only f32 depths have it");
        }
        (CoarseDepth::On, DepthFormat::F32) => {
            plan.add(Part::CoarseDepth, "on request: by cells of 16x8 pixels", faces, 0);
        }
        (CoarseDepth::Auto, DepthFormat::F32) if faces <= FEW_FACES => {
            plan.leave_out(Part::CoarseDepth, "the mesh has few faces");
        }
        (CoarseDepth::Auto, DepthFormat::F32) => match occlusion.pays() {
            true => plan.add(Part::CoarseDepth, occlusion.reason(), faces, 0),
            false => plan.leave_out(Part::CoarseDepth, occlusion.reason()),
        },
    }
}

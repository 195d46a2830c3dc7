//! Stage 1, second half: decides by which path a draw's faces are drawn, and adds it to the plan.
//!
//! In: a draw call, its target, and the plan of its stages. Out: the plan with the tile renderer and
//! the faces drawn in order, or the reasons why they are left out, and its working memory.

use super::draw_call::{DrawCall, Target};
use super::geometry_cache::GeometryInfo;
use super::light::ViewerPosition;
use super::ordered::face_list_bytes;
use super::plan::{Part, Plan};
use super::planner::plan_draw;
use super::tile::LIST_BYTES;
use super::tile_frontend::{blended_unsupported_reason, estimated_bytes, unsupported_reason};
use super::worst_case::{ListLimits, at_worst};
use crate::cancel::CancelToken;
use glam::DVec3;

impl Plan {
    /// Creates the plan of one DRAW into `target`.
    ///
    /// The cost is linear in the mesh's polygons and corners; vertices are not transformed.
    pub fn of_draw(call: &DrawCall, target: &Target) -> Plan {
        let lighting = call.lighting(ViewerPosition::Axis(DVec3::Z));
        let mut plan =
            plan_draw(call, target, &lighting, &GeometryInfo::of(call.geometry, CancelToken::default()));
        add_path(&mut plan, call, target);
        let bound = ListLimits { threads: 1, list_bytes: LIST_BYTES as u64 };
        let working = at_worst(call, target, &plan, None, bound);
        plan.set_working_bytes(working.sum());
        plan
    }
}

/// Adds the path of the draw's faces to the plan of its stages.
pub(crate) fn add_path(plan: &mut Plan, call: &DrawCall, target: &Target) {
    let mesh = &call.geometry.mesh;
    let faces = mesh.triangles.len() as u64;
    if faces == 0 && mesh.lines.is_empty() && mesh.points.is_empty() {
        return;
    }
    match unsupported_reason(call, target, plan) {
        None => {
            let bytes = estimated_bytes(call, target, plan);
            plan.set_bytes(Part::TransformVertices, 0);
            plan.add(
                Part::TileRenderer,
                "opaque faces: first what is seen, then its colour, in vectors",
                faces,
                bytes,
            );
        }
        Some(why) => plan.leave_out(Part::TileRenderer, why),
    }
    match plan.uses(Part::TileRenderer) && plan.uses(Part::DepthMemory) {
        true => plan.leave_out(Part::CoarseDepth, "nobody asks for it"),
        false => plan.leave_out(Part::CoarseDepth, "the tile renderer tests no depth"),
    }
    match blended_unsupported_reason(call, target) {
        _ if plan.uses(Part::TileRenderer) => {
            plan.leave_out(Part::FacesInOrder, "the tile renderer draws them");
        }
        None => {
            let bytes = face_list_bytes(faces);
            plan.add(Part::FacesInOrder, "one after the other, in vectors", faces, bytes);
        }
        Some(why) => plan.leave_out(Part::FacesInOrder, why),
    }
}

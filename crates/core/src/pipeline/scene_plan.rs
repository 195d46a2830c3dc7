//! The plan of a scene, and its worst-case working memory.

use super::draw_call::{Backend, DepthUse, DrawCall, SceneOptions, Target};
use super::geometry_cache::GeometryInfo;
use super::light::PreparedLight;
use super::ordered::face_list_bytes;
use super::path_plan::plan_call;
use super::plan::{Part, Parts, Plan, Title};
use super::planner::SORTED_BY_PAINTER;
use super::prepared_draw::{PreparedDraw, RecycledLists};
use super::scene::{calls_of, leaves_depth_out};
use super::tile::{HIERARCHICAL_Z_BYTES, LIST_BYTES};
use super::tile_frontend::{DrawBatch, binding_bytes};
use super::vertex::Vertex;
use super::working::{SORT_KEY_BYTES, Working, WorkingBytes};
use super::worst_case::{ListLimits, SMALL_FACES, at_worst, ordered, small_at_worst};
use crate::scene::{HiddenSurface, Scene, TransparencyOrder};
use std::sync::Arc;

/// Returns the plan of a scene: the parts that any of its objects needs, and shared memory once.
///
/// Also works for scenes whose camera or meshes [`super::draw_scene`] refuses.
pub fn plan_scene(target: &Target, scene: &Scene, options: &SceneOptions) -> Plan {
    plan_scene_for(target, scene, options, Backend::default(), 1, &|_| None)
}

/// Returns the plan of a scene for a renderer with `threads` threads. `cached` returns
/// the facts about a draw's geometry that the renderer has.
pub(crate) fn plan_scene_for(
    target: &Target,
    scene: &Scene,
    options: &SceneOptions,
    backend: Backend,
    threads: u64,
    cached: &dyn Fn(&DrawCall) -> Option<Arc<GeometryInfo>>,
) -> Plan {
    let calls = calls_of(scene, options);
    let (width, height) = (target.memory.width(), target.memory.height());
    let title = Title::Scene { objects: calls.len() };
    let mut plan = Plan::of_frame(title, width, height, "nothing is drawn in 3-D");
    let first = calls.first().and_then(cached);
    let keeps_depth = !leaves_depth_out(&calls, first.as_deref(), options);
    let plan_of = |call| plan_call(call, target, backend, keeps_depth, cached(call));
    let plans: Vec<Plan> = calls.iter().map(plan_of).collect();
    plans.iter().for_each(|own| plan.merge(own));
    if plan.uses(Part::CoarseDepth) {
        plan.set_bytes(Part::CoarseDepth, threads * HIERARCHICAL_Z_BYTES);
    }
    if options.depth_use == DepthUse::SceneOnly && plan.uses(Part::DepthMemory) {
        plan.explain(Part::DepthMemory, "HIDE zbuffer; faces may hide each other");
    }
    // All objects' faces share one list.
    plan.set_bytes(Part::FacesInOrder, face_list_bytes(plan.item(Part::FacesInOrder).count));
    let each: Vec<(DrawCall, Parts)> = calls.into_iter().zip(plans.iter().map(Parts::from)).collect();
    let worst = scene_at_worst(&each, target, threads, options, object_bytes(scene));
    plan.set_working_bytes(worst.sum());
    if options.hide == HiddenSurface::Painter && plan.uses(Part::SortFaces) {
        plan.explain(Part::SortFaces, SORTED_BY_PAINTER);
    } else if options.transparency == TransparencyOrder::Sorted && plan.uses(Part::ReadBack) {
        let (count, _) = (plan.item(Part::ReadBack).count, ());
        plan.add(Part::SortFaces, "transparent faces far to near, on request", count, count * SORT_KEY_BYTES);
    }
    plan
}

/// Returns the bytes that a scene's objects take while they are drawn, lights included.
pub(crate) fn object_bytes(scene: &Scene) -> u64 {
    let each = size_of::<DrawCall>()
        + size_of::<PreparedDraw>()
        + size_of::<Arc<GeometryInfo>>()
        + size_of::<RecycledLists>();
    let lights = scene.lights.len() * size_of::<PreparedLight>();
    // A list's capacity can be twice its length.
    2 * scene.objects.len() as u64 * (each + lights) as u64
}

/// Returns the memory for faces drawn in submission order: vertices of all their objects at once,
/// and one face list.
pub(crate) fn in_order<'a>(
    all: impl Iterator<Item = (&'a DrawCall<'a>, Parts)>,
    options: &SceneOptions,
    object_bytes: u64,
) -> WorkingBytes {
    let mut bytes = WorkingBytes::default();
    let is_painted = options.hide == HiddenSurface::Painter;
    let (mut faces, mut vertices) = (0, 0);
    for (call, parts) in all.filter(|(_, parts)| is_painted || parts.uses(Part::ReadBack)) {
        let mesh = &call.geometry.mesh;
        faces += mesh.triangles.len() as u64;
        vertices += if parts.uses(Part::TransformVertices) { mesh.positions.len() as u64 } else { 0 };
    }
    ordered(&mut bytes, faces, is_painted || options.transparency == TransparencyOrder::Sorted);
    bytes[Working::Vertices] = vertices * size_of::<Vertex>() as u64;
    bytes[Working::Objects] = object_bytes;
    bytes
}

/// Returns the worst-case memory of a scene with `threads` threads: the maximum of each part over
/// all objects.
fn scene_at_worst(
    each: &[(DrawCall, Parts)],
    target: &Target,
    threads: u64,
    options: &SceneOptions,
    object_bytes: u64,
) -> WorkingBytes {
    let bound = ListLimits { threads, list_bytes: LIST_BYTES as u64 };
    let mut worst = in_order(each.iter().map(|(call, parts)| (call, *parts)), options, object_bytes);
    let is_small = |parts: Parts, call: &DrawCall| {
        parts.uses(Part::TileRenderer) && call.geometry.mesh.triangles.len() <= SMALL_FACES
    };
    let small = || each.iter().filter(|(call, parts)| is_small(*parts, call)).map(|(c, _)| binding_bytes(c));
    each.iter().for_each(|(call, parts)| worst.cover(&at_worst(call, target, *parts, None, bound)));
    if let Some(surfaces) = small().max() {
        worst.cover(&small_at_worst(surfaces, target, bound));
    }
    if threads > 1 && small().nth(1).is_some() {
        worst[Working::DrawBatch] = DrawBatch::worst_bytes(small(), threads, target);
    }
    worst
}

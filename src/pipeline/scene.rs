//! Drawing a scene: background, opaque faces, lines and points, then transparent faces.

use super::backdrop::{paint, paint_sky};
use super::depth_sort::{FaceOrder, SORT_KEY_BYTES, recycle};
use super::draw_call::{DepthUse, DrawCall, DrawStats, PipelineError, SceneOptions, Target};
use super::geometry_cache::GeometryInfo;
use super::light::PreparedLight;
use super::ordered::face_list_bytes;
use super::plan::{Part, Plan, Title};
use super::planner::{SORTED_BY_PAINTER, nothing_can_hide};
use super::prepared_draw::{Layer, PreparedDraw, RecycledLists};
use super::tile::LIST_BYTES;
use super::tile_frontend::{DrawBatch, binding_bytes};
use super::vertex::Vertex;
use super::working::{SMALL_FACES, Working, WorkingBytes, at_worst, ordered, small_at_worst};
use crate::cancel::CancelToken;
use crate::executor::Executor;
use crate::scene::{HiddenSurface, Scene, ShadeMode, TransparencyOrder};
use rayon::prelude::*;
use std::fmt;
use std::sync::Arc;

/// Draws a scene: its background over the viewport, the opaque faces, lines and points, then the
/// transparent faces in file order or from far to near.
///
/// # Errors
/// As [`super::draw`]; every object is checked before anything is written, so the target is then
/// untouched.
pub fn draw_scene(
    target: &mut Target,
    scene: &Scene,
    options: &SceneOptions,
) -> Result<DrawStats, PipelineError> {
    draw_scene_with(&mut PlainBackend::default(), target, scene, options)
}

/// Empty lists that one scene leaves to the next for reuse.
#[derive(Default)]
pub(crate) struct SceneLists {
    calls: Vec<DrawCall<'static>>,
    prepared: Vec<PreparedDraw<'static>>,
    geometry_infos: Vec<Arc<GeometryInfo>>,
    /// Per object, its lights and its vertices.
    recycled: Vec<RecycledLists>,
    order: FaceOrder,
}

impl fmt::Debug for SceneLists {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SceneLists of {} bytes", self.size_bytes())
    }
}

impl SceneLists {
    /// Returns the bytes that the lists take.
    pub fn size_bytes(&self) -> usize {
        self.calls.capacity() * size_of::<DrawCall>()
            + self.prepared.capacity() * size_of::<PreparedDraw>()
            + self.geometry_infos.capacity() * size_of::<Arc<GeometryInfo>>()
            + self.recycled.capacity() * size_of::<RecycledLists>()
            + self.recycled.iter().map(RecycledLists::size_bytes).sum::<usize>()
            + self.order.size_bytes()
    }
}

/// The operations of [`draw_scene_with`] that the plain path and the renderer implement
/// differently.
pub(crate) trait SceneBackend {
    /// Returns the executor that runs the work.
    fn executor(&self) -> &Executor;

    /// Returns the lists that the last scene left.
    fn lists(&mut self) -> &mut SceneLists;

    /// Reserves `bytes` for a scene's objects.
    ///
    /// # Errors
    /// When they do not fit the budget.
    fn reserve_objects(&mut self, _bytes: u64) -> Result<(), PipelineError> {
        Ok(())
    }

    /// Reserves the memory for drawing these objects; `face_list` is that of the faces drawn in
    /// submission order.
    ///
    /// # Errors
    /// When it does not fit the budget.
    fn reserve_scene(
        &mut self,
        _all: &[PreparedDraw],
        (_target, _listed): (&Target, &WorkingBytes),
    ) -> Result<(), PipelineError> {
        Ok(())
    }

    /// Returns the cached facts about a draw's geometry.
    fn geometry_info(&mut self, call: &DrawCall) -> Arc<GeometryInfo>;

    /// Draws the faces of one object that belong to a layer, in order; a wireframe completely.
    fn faces(
        &mut self,
        prepared: &mut PreparedDraw,
        layer: Layer,
        target: &mut Target,
        stats: &mut DrawStats,
    );

    /// Draws the opaque faces of the first objects of `all` as one batch, where that pays, and
    /// returns their number. Batched objects have nothing else to draw.
    fn draw_batch(&mut self, all: &[PreparedDraw], target: &mut Target, stats: &mut DrawStats) -> usize;

    /// Draws faces of several objects in the list's order; an entry is (object index, triangle
    /// index).
    fn draw_in_order(
        &mut self,
        all: &[PreparedDraw],
        list: &[(usize, u32)],
        target: &mut Target,
        stats: &mut DrawStats,
    );
}

/// The plain path as a backend.
#[derive(Default)]
struct PlainBackend {
    executor: Executor,
    lists: SceneLists,
}

impl SceneBackend for PlainBackend {
    fn executor(&self) -> &Executor {
        &self.executor
    }

    fn lists(&mut self) -> &mut SceneLists {
        &mut self.lists
    }

    fn geometry_info(&mut self, call: &DrawCall) -> Arc<GeometryInfo> {
        Arc::new(GeometryInfo::of(call.geometry, CancelToken::default()))
    }

    fn faces(
        &mut self,
        prepared: &mut PreparedDraw,
        layer: Layer,
        target: &mut Target,
        stats: &mut DrawStats,
    ) {
        prepared.transform_all();
        if prepared.call.shade == ShadeMode::Wire {
            prepared.draw_wire(target, stats);
            return;
        }
        for triangle in prepared.face_order() {
            prepared.draw_face(triangle, layer, target, stats);
        }
    }

    fn draw_batch(&mut self, _: &[PreparedDraw], _: &mut Target, _: &mut DrawStats) -> usize {
        0
    }

    fn draw_in_order(
        &mut self,
        all: &[PreparedDraw],
        list: &[(usize, u32)],
        target: &mut Target,
        stats: &mut DrawStats,
    ) {
        list.iter().for_each(|&(o, t)| all[o].draw_any_face(t, target, stats));
    }
}

/// Draws a scene by a backend; see [`draw_scene`].
pub(crate) fn draw_scene_with(
    backend: &mut impl SceneBackend,
    target: &mut Target,
    scene: &Scene,
    options: &SceneOptions,
) -> Result<DrawStats, PipelineError> {
    let cancel = backend.executor().cancel().clone();
    let SceneLists { calls, prepared: mut all, mut geometry_infos, mut recycled, mut order } =
        std::mem::take(backend.lists());
    let mut calls: Vec<DrawCall> = calls;
    let object_bytes = object_bytes(scene);
    backend.reserve_objects(object_bytes)?;
    calls.extend(each_call(scene, options));
    let mut stats = DrawStats::default();
    let keeps_depth = !leaves_depth_out(&calls, options);
    // Stages 1 to 3 for every object: faces may be sorted across objects, and transparent faces
    // need a second pass.
    all.reserve(calls.len());
    recycled.resize_with(calls.len(), RecycledLists::default);
    let mut camera = None;
    for call in &calls {
        let geometry_info = backend.geometry_info(call);
        // All objects have the scene's camera.
        camera = Some(PreparedDraw::check(call, &geometry_info, camera)?);
        geometry_infos.push(geometry_info);
    }
    if let Some(camera) = camera {
        let target = &*target;
        let make = |((call, geometry_info), recycled): ((_, _), &mut RecycledLists)| {
            let mut prepared =
                PreparedDraw::of(call, camera, target, geometry_info, std::mem::take(recycled));
            prepared.cancel = &cancel;
            if !keeps_depth {
                prepared.plan.leave_out(Part::DepthMemory, NOTHING_HIDDEN);
                prepared.plan.leave_out(Part::PickBuffer, NOTHING_HIDDEN);
            }
            prepared
        };
        match backend.executor().pool() {
            Some(pool) if calls.len() >= MANY_OBJECTS => pool.install(|| {
                let each = calls.par_iter().zip(geometry_infos.par_drain(..)).zip(&mut recycled);
                each.with_min_len(MANY_OBJECTS / 2).map(make).collect_into_vec(&mut all);
            }),
            _ => all.extend(calls.iter().zip(geometry_infos.drain(..)).zip(&mut recycled).map(make)),
        }
    }
    let face_list = in_order(all.iter().map(|p| (p.call, &p.plan)), options, object_bytes);
    backend.reserve_scene(&all, (target, &face_list))?;
    stats.vertices += all.iter().map(PreparedDraw::vertices_in).sum::<u64>();
    match (&scene.sky, scene.background.color) {
        (Some(sky), _) => {
            let camera = scene.camera.unwrap_or(options.camera);
            paint_sky(target, options.viewport, &camera, sky, backend.executor());
        }
        (None, Some(color)) => paint(target, options.viewport, color),
        (None, None) => {}
    }
    for prepared in &all {
        prepared.open_buffers(target);
    }
    if options.hide == HiddenSurface::Painter {
        all.iter_mut().for_each(PreparedDraw::transform_all);
        order.collect_faces(&all, |p, t| !p.is_transparent(t));
        order.sort(&all, &cancel);
        backend.draw_in_order(&all, order.list(), target, &mut stats);
    }
    let mut at = 0;
    while at < all.len() && !cancel.is_cancelled() {
        let draw_batch = match options.hide {
            HiddenSurface::Painter => 0,
            _ => backend.draw_batch(&all[at..], target, &mut stats),
        };
        at += draw_batch;
        let Some(prepared) = all.get_mut(at).filter(|_| draw_batch == 0) else { continue };
        at += 1;
        if prepared.call.shade == ShadeMode::Wire || options.hide != HiddenSurface::Painter {
            backend.faces(prepared, Layer::Opaque, target, &mut stats);
        }
        prepared.draw_lines(target, &mut stats);
        prepared.draw_points(target, &mut stats);
    }
    for prepared in all.iter_mut().filter(|p| p.plan.uses(Part::ReadBack)) {
        prepared.transform_all();
    }
    order.collect_faces(&all, |p, t| p.is_transparent(t));
    if options.transparency == TransparencyOrder::Sorted {
        order.sort(&all, &cancel);
    }
    if !order.list().is_empty() {
        backend.draw_in_order(&all, order.list(), target, &mut stats);
    }
    for (prepared, recycled) in all.drain(..).zip(&mut recycled) {
        *recycled = prepared.into_recycled();
    }
    calls = {
        let prepared = recycle(all);
        calls.clear();
        *backend.lists() = SceneLists { calls: Vec::new(), prepared, geometry_infos, recycled, order };
        calls
    };
    backend.lists().calls = recycle(calls);
    Ok(stats)
}

/// Returns the bytes that a scene's objects take while they are drawn, lights included.
fn object_bytes(scene: &Scene) -> u64 {
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
fn in_order<'a>(
    all: impl Iterator<Item = (&'a DrawCall<'a>, &'a Plan)>,
    options: &SceneOptions,
    object_bytes: u64,
) -> WorkingBytes {
    let mut bytes = WorkingBytes::default();
    let is_painted = options.hide == HiddenSurface::Painter;
    let (mut faces, mut vertices) = (0, 0);
    for (call, plan) in all.filter(|(_, plan)| is_painted || plan.uses(Part::ReadBack)) {
        let mesh = &call.geometry.mesh;
        faces += mesh.triangles.len() as u64;
        vertices += if plan.uses(Part::TransformVertices) { mesh.positions.len() as u64 } else { 0 };
    }
    ordered(&mut bytes, faces, is_painted || options.transparency == TransparencyOrder::Sorted);
    bytes[Working::Vertices] = vertices * size_of::<Vertex>() as u64;
    bytes[Working::Objects] = object_bytes;
    bytes
}

/// Returns the worst-case memory of a scene with `threads` threads: the maximum of each part over
/// all objects.
fn scene_at_worst(
    each: &[(DrawCall, Plan)],
    (target, threads): (&Target, u64),
    options: &SceneOptions,
    object_bytes: u64,
) -> WorkingBytes {
    let bound = (threads, LIST_BYTES as u64);
    let mut worst = in_order(each.iter().map(|(call, plan)| (call, plan)), options, object_bytes);
    let is_small = |plan: &Plan, call: &DrawCall| {
        plan.uses(Part::TileRenderer) && call.geometry.mesh.triangles.len() <= SMALL_FACES
    };
    let small = || each.iter().filter(|(call, plan)| is_small(plan, call)).map(|(c, _)| binding_bytes(c));
    each.iter().for_each(|(call, plan)| worst.cover(&at_worst(call, target, plan, None, bound)));
    if let Some(surfaces) = small().max() {
        worst.cover(&small_at_worst(surfaces, target, bound));
    }
    if threads > 1 && small().nth(1).is_some() {
        worst[Working::DrawBatch] = DrawBatch::worst_bytes(small(), threads, target);
    }
    worst
}

/// Minimum number of objects that are prepared on the pool.
const MANY_OBJECTS: usize = 128;

const NOTHING_HIDDEN: &str = "the scene is known whole, and nothing in it can be hidden";

/// Returns the plan of a scene: the parts that any of its objects needs, and shared memory once.
///
/// Also works for scenes whose camera or meshes [`draw_scene`] refuses.
pub fn plan_scene(target: &Target, scene: &Scene, options: &SceneOptions) -> Plan {
    plan_scene_for(target, scene, options, 1)
}

/// Returns the plan of a scene for a renderer with `threads` threads.
pub(super) fn plan_scene_for(target: &Target, scene: &Scene, options: &SceneOptions, threads: u64) -> Plan {
    let calls = calls_of(scene, options);
    let (width, height) = (target.memory.width(), target.memory.height());
    let title = Title::Scene { objects: calls.len() };
    let mut plan = Plan::of_frame(title, width, height, "nothing is drawn in 3-D");
    let plans: Vec<Plan> = calls.iter().map(|call| Plan::of_draw(call, target)).collect();
    plans.iter().for_each(|own| plan.merge(own));
    if leaves_depth_out(&calls, options) {
        plan.leave_out(Part::DepthMemory, NOTHING_HIDDEN);
        plan.leave_out(Part::PickBuffer, NOTHING_HIDDEN);
    } else if options.depth_use == DepthUse::SceneOnly && plan.uses(Part::DepthMemory) {
        plan.explain(Part::DepthMemory, "HIDE zbuffer; faces may hide each other");
    }
    // All objects' faces share one list.
    plan.set_bytes(Part::FacesInOrder, face_list_bytes(plan.item(Part::FacesInOrder).count));
    let each: Vec<(DrawCall, Plan)> = calls.into_iter().zip(plans).collect();
    let worst = scene_at_worst(&each, (target, threads), options, object_bytes(scene));
    plan.set_working_bytes(worst.sum());
    if options.hide == HiddenSurface::Painter && plan.uses(Part::SortFaces) {
        plan.explain(Part::SortFaces, SORTED_BY_PAINTER);
    } else if options.transparency == TransparencyOrder::Sorted && plan.uses(Part::ReadBack) {
        let (count, _) = (plan.item(Part::ReadBack).count, ());
        plan.add(Part::SortFaces, "transparent faces far to near, on request", count, count * SORT_KEY_BYTES);
    }
    plan
}

/// Returns the draw calls of a scene, one per object.
pub(super) fn calls_of<'a>(scene: &'a Scene, options: &SceneOptions) -> Vec<DrawCall<'a>> {
    each_call(scene, options).collect()
}

/// Iterates over the draw calls of a scene, one per object, with consecutive pick-buffer values.
fn each_call<'a>(scene: &'a Scene, options: &SceneOptions) -> impl Iterator<Item = DrawCall<'a>> {
    let call = move |(index, object)| DrawCall {
        name: options.first_name.wrapping_add(index as u32),
        ..DrawCall::of_object(object, scene, options)
    };
    scene.objects.iter().enumerate().map(call)
}

/// Returns whether depth is unnecessary: a single object that cannot hide itself, and no later use
/// of depth.
fn leaves_depth_out(calls: &[DrawCall], options: &SceneOptions) -> bool {
    let one = match calls {
        [one] => one,
        _ => return false,
    };
    options.depth_use == DepthUse::SceneOnly
        && options.hide == HiddenSurface::ZBuffer
        && nothing_can_hide(one)
}

/// Returns the faces of all objects in the order in which [`draw_scene`] draws them.
pub(super) fn drawing_order(all: &[PreparedDraw], options: &SceneOptions) -> Vec<(usize, u32)> {
    let mut order = FaceOrder::default();
    let mut face_list = |is_through: bool, is_sorted: bool| {
        order.collect_faces(all, |p, t| p.is_transparent(t) == is_through);
        if is_sorted {
            order.sort(all, &CancelToken::default());
        }
        order.list().to_vec()
    };
    let mut list = face_list(false, options.hide == HiddenSurface::Painter);
    list.extend(face_list(true, options.transparency == TransparencyOrder::Sorted));
    list
}

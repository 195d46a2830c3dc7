//! The renderer that programs use: draws each mesh by the fastest path that serves it.
//!
//! In: draw calls and scenes. Out: their picture, by the backend that [`RenderPath`] names; that of
//! the tile renderer is within its limits of the reference's. The renderer keeps working memory and
//! facts about shared geometries, including their indexed meshes, from draw to draw. It starts no
//! thread; a pool is passed to it. The bytes do not depend on the pool or the SIMD level.

mod cache;
mod draw_all;
mod draw_scene;
mod workspace;

use super::draw_call::{
    Backend, CoarseDepth, DrawCall, DrawStats, PathCounts, PipelineError, RenderPath, SceneOptions, Target,
};
use super::geometry_cache::GeometryInfo;
use super::mesh_extent::{CoverageBound, MeshExtent};
use super::ndc_box::ClipTransform;
use super::ordered::draw_in_order;
use super::path_plan::{add_path, plan_draw_for};
use super::plan::{Part, Plan};
use super::preemption::Preemption;
use super::prepared_draw::{Layer, PreparedDraw};
use super::scene_plan::plan_scene_for;
use super::tile::{LIST_BYTES, list_bound};
use super::tile_frontend::{DrawBatch, DrawContext, binding_bytes};
use super::working::{Working, WorkingBytes, WorkingMemory};
use super::worst_case::{ListLimits, SMALL_FACES, at_worst, small_at_worst};
use crate::cancel::CancelToken;
use crate::executor::{Executor, PieceObserver, ThreadPool};
use crate::memory::{MemoryBudget, OverBudget, Rgba, VideoMemory};
use crate::scene::{Geometry, Scene, ShadeMode};
use crate::simd::{Level, fill_pixels};
use cache::Cache;
use std::sync::Arc;
use workspace::Workspace;

/// Settings of a [`Renderer`].
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    /// Thread pool that shares the work; `None` for the calling thread alone.
    pub pool: Option<Arc<ThreadPool>>,
    /// SIMD level of the kernels; `None` for the best that this CPU has.
    pub simd: Option<Level>,
    /// The code path that draws.
    pub path: RenderPath,
    /// Hierarchical culling of hidden faces, tile by tile.
    pub coarse: CoarseDepth,
    /// Token that ends a draw early. Pixels drawn so far stay; the returned statistics are
    /// meaningless.
    pub cancel: CancelToken,
    /// Handle by which draws are preempted.
    pub preemption: Preemption,
    /// Observer of the pieces of work that threads share.
    pub observer: Option<Arc<dyn PieceObserver>>,
}

impl RenderOptions {
    fn executor(&self) -> Executor {
        Executor::new(self.pool.clone(), self.cancel.clone()).observed(self.observer.clone())
    }
}

/// Draws meshes and scenes, and keeps working memory and geometry facts between draws.
#[derive(Debug, Default)]
pub struct Renderer {
    options: RenderOptions,
    executor: Executor,
    /// Buffers that one draw leaves to the next.
    workspace: Workspace,
    cache: Cache,
    /// Budget reservation for the workspace.
    working: WorkingMemory,
    /// Bytes of the tiles' face lists at which a draw is split into pieces.
    bound: ListBound,
}

/// Bytes of the tiles' face lists at which a draw is split into pieces.
#[derive(Clone, Copy, Debug)]
struct ListBound(u64);

impl Default for ListBound {
    fn default() -> Self {
        ListBound(LIST_BYTES as u64)
    }
}

/// Pixels per thread below which a clear does not use the pool, because waking another thread costs
/// more: about 20 microseconds of work.
const LARGE_SHARE: usize = 1 << 19;

impl Renderer {
    /// Creates a renderer with empty caches.
    pub fn new(options: RenderOptions) -> Self {
        let executor = options.executor();
        Renderer { options, executor, ..Renderer::default() }
    }

    /// Sets the token that ends draws early. Once `cancel` is cancelled, the current draw and every
    /// later one end early, until another token is set. If the previous token was cancelled, all
    /// cached state is dropped, because a cancelled draw may have left it incomplete.
    pub fn set_cancel(&mut self, cancel: CancelToken) {
        let options = RenderOptions { cancel, ..self.options.clone() };
        if self.options.cancel.is_cancelled() {
            let budget = self.working.budget().clone();
            *self = Renderer::default();
            self.set_budget(&budget);
        }
        self.executor = options.executor();
        self.options = options;
    }

    /// Sets the handle by which later draws are preempted.
    pub fn set_preemption(&mut self, preemption: Preemption) {
        self.options.preemption = preemption;
    }

    /// Returns the renderer's settings.
    pub fn options(&self) -> &RenderOptions {
        &self.options
    }

    /// Drops all cached state and reserves working memory from `budget` from then on. A draw that
    /// does not fit is drawn in pieces, or refused.
    pub fn set_budget(&mut self, budget: &MemoryBudget) {
        self.release();
        self.cache = Cache::default();
        self.working = WorkingMemory::of(budget);
    }

    /// Returns the bytes reserved for working memory.
    pub fn reserved_bytes(&self) -> u64 {
        self.working.bytes()
    }

    /// Frees working memory, and the cached facts of geometries that have been dropped. Facts about
    /// geometries that still exist are kept.
    pub fn release(&mut self) {
        self.workspace = Workspace::default();
        self.cache.forget_dropped();
        self.working.clear();
        self.bound = ListBound::default();
    }

    /// Returns the number of threads that draw.
    fn threads(&self) -> u64 {
        self.options.pool.as_ref().map_or(1, |p| p.current_num_threads()) as u64
    }

    /// Returns whether small draws are put together: for threads to share them, or for an observer,
    /// which is told of the pieces that threads would have.
    fn shares_small_draws(&self) -> bool {
        self.threads() > 1 || self.options.observer.is_some()
    }

    /// Computes the facts that a draw needs of its geometry, within the budget.
    fn prepare_geometry(&mut self, prepared: &PreparedDraw) -> Result<(), OverBudget> {
        let mesh = &prepared.call.geometry.mesh;
        let needs = prepared.needs();
        match prepared.geometry_info.prepare(mesh, needs, self.working.budget()) {
            Ok(()) => Ok(()),
            Err(_) => {
                self.release();
                prepared.geometry_info.prepare(mesh, needs, self.working.budget())
            }
        }
    }

    /// Returns the limits of the tiles' lists.
    fn list_limits(&self) -> ListLimits {
        ListLimits { threads: self.threads(), list_bytes: self.bound.0 }
    }

    /// Returns the worst-case working memory of a draw.
    fn at_worst(&self, prepared: &PreparedDraw, target: &Target) -> WorkingBytes {
        let bound = self.list_limits();
        at_worst(prepared.call, target, prepared.parts, prepared.geometry_info.vertex_count(), bound)
    }

    /// Reserves the bytes that `worst` returns for the current bound of the tiles' lists. If they
    /// do not fit, frees what other draws left; if they still do not fit, lowers the bound to what
    /// is free.
    fn reserve(
        &mut self,
        target: &Target,
        worst: impl Fn(&Renderer) -> WorkingBytes,
    ) -> Result<(), OverBudget> {
        let mut required = worst(self);
        if self.working.reserve(&required).is_err() {
            self.release();
            required = worst(self);
            if let Err(e) = self.working.reserve(&required) {
                let others = required.sum() - required[Working::Lists];
                let free = self.working.budget().available();
                let size = (target.memory.width() as usize, target.memory.height() as usize);
                // A quarter stays free for decoding and replies where possible; otherwise the lists
                // take everything.
                let bound = |part: u64| list_bound(part.checked_sub(others)?, self.threads(), size);
                let bound = bound(free / 4 * 3).or_else(|| bound(free));
                self.bound = ListBound(bound.filter(|_| required[Working::Lists] > 0).ok_or(e)?);
                self.working.reserve(&worst(self))?;
            }
        }
        self.workspace.draw_batch.bound_lists(self.bound.0 as usize);
        Ok(())
    }

    /// Returns to the budget what was reserved for the worst case and is not in use.
    fn shrink_reservation(&mut self) {
        if self.working.is_large() {
            let batch = &self.workspace.draw_batch;
            self.working.shrink_reservation(batch.list_bytes(), batch.held_bytes());
        }
    }

    /// Returns the SIMD level of the kernels.
    pub fn level(&self) -> Level {
        self.options.simd.unwrap_or_else(Level::best).min(Level::best())
    }

    /// Returns the bytes kept from draw to draw: working memory and cached geometry facts.
    pub fn size_bytes(&self) -> usize {
        self.workspace.size_bytes() + self.cache.size_bytes()
    }

    /// Fills the frame with `color`, on all threads if the frame is large enough.
    pub fn clear(&self, memory: &mut VideoMemory, color: Rgba) {
        let pixels = memory.bytes_mut().as_chunks_mut::<4>().0;
        if self.executor.pool().is_none() || pixels.len() < 2 * LARGE_SHARE {
            return memory.clear(color);
        }
        self.executor.chunks(pixels, LARGE_SHARE, |_, run| fill_pixels(run, color));
        memory.mark_rows(0..memory.height());
    }

    /// Returns the backend that plans are made for.
    fn backend(&self) -> Backend {
        Backend { path: self.options.path, coarse: self.options.coarse }
    }

    /// Returns the plan of [`super::plan_scene`] as this renderer draws: by its backend, with its
    /// threads.
    pub fn plan_scene(&self, target: &Target, scene: &Scene, options: &SceneOptions) -> Plan {
        plan_scene_for(target, scene, options, self.backend(), self.threads(), &|call| self.cached_info(call))
    }

    /// Returns the plan of one draw, as this renderer draws it.
    pub fn plan_draw(&self, target: &Target, call: &DrawCall) -> Plan {
        plan_draw_for(call, target, self.backend(), self.list_limits(), self.cached_info(call))
    }

    /// Returns the cached facts about a draw's geometry, if there are any.
    fn cached_info(&self, call: &DrawCall) -> Option<Arc<GeometryInfo>> {
        shared(call).and_then(|geometry| self.cache.get(geometry))
    }

    /// Returns the faces that each path has drawn since the working memory was last freed.
    pub fn path_counts(&self) -> PathCounts {
        let [vectors, reference] = self.workspace.face_list.faces_drawn();
        PathCounts { tiles: self.workspace.draw_batch.faces_drawn(), vectors, reference }
    }

    /// Draws one mesh: faces in file order, or sorted under HIDE painter; then its lines and points.
    ///
    /// # Errors
    /// As [`super::draw`], and when the working memory does not fit the budget.
    pub fn draw(&mut self, target: &mut Target, call: &DrawCall) -> Result<DrawStats, PipelineError> {
        let mut stats = DrawStats::default();
        let (cancel, preemption) = (self.options.cancel.clone(), self.options.preemption.clone());
        let items = call.geometry.mesh.corners.len();
        let geometry_info = preemption.without(target, items, || self.geometry_info(call));
        let recycled = std::mem::take(&mut self.workspace.recycled);
        let mut prepared = PreparedDraw::with(call, target, geometry_info, recycled, &mut stats)?;
        (prepared.cancel, prepared.preemption) = (&cancel, &preemption);
        add_path(&mut prepared, target, self.backend(), true);
        preemption.without(target, items, || self.prepare_geometry(&prepared))?;
        self.reserve(target, |own| own.at_worst(&prepared, target))?;
        prepared.open_buffers(target);
        let own = std::slice::from_mut(&mut prepared);
        self.draw_faces(own, Layer::All, target, &mut |_, faces| stats += faces);
        prepared.draw_lines(target, &mut stats);
        prepared.draw_points(target, &mut stats);
        self.workspace.recycled = prepared.take_recycled();
        self.shrink_reservation();
        Ok(stats)
    }

    /// Returns upper bounds of the pixels that a draw covers, if the tile renderer draws all of it in
    /// one piece, and all that it needs of the mesh has been computed by draws before.
    #[doc(hidden)]
    pub fn coverage_by_tiles(&mut self, target: &Target, call: &DrawCall) -> Option<CoverageBound> {
        let info = self.cached_info(call).filter(|info| info.checked.is_ok())?;
        let (bounds, mesh) = (info.bounds?, &call.geometry.mesh);
        if self.bound.0 < ListBound::default().0 || !mesh.lines.is_empty() || !mesh.points.is_empty() {
            return None;
        }
        let camera = PreparedDraw::camera_of(call).ok()?;
        let recycled = std::mem::take(&mut self.workspace.recycled);
        let mut prepared = PreparedDraw::of(call, camera, target, Arc::clone(&info), recycled);
        add_path(&mut prepared, target, self.backend(), true);
        let is_ready = prepared.parts.uses(Part::TileRenderer) && info.has(prepared.needs());
        self.workspace.recycled = prepared.take_recycled();
        if !is_ready {
            return None;
        }
        let extent = info.extent.get_or_init(|| MeshExtent::of(mesh, bounds));
        let view = [call.viewport.width, call.viewport.height].map(f64::from);
        extent.coverage(&ClipTransform::of(&camera).after(&call.model), view)
    }

    /// Returns the cached facts about a draw's geometry.
    fn geometry_info(&mut self, call: &DrawCall) -> Arc<GeometryInfo> {
        match shared(call) {
            Some(shared) => self.cache.geometry_info(shared, &self.options.cancel),
            None => Arc::new(GeometryInfo::of(call.geometry, CancelToken::default())),
        }
    }

    /// Reserves `bytes` for a scene's objects.
    fn reserve_objects(&mut self, bytes: u64) -> Result<(), PipelineError> {
        let mut required = WorkingBytes::default();
        required[Working::Objects] = bytes;
        if self.working.reserve(&required).is_err() {
            self.release();
            self.working.reserve(&required)?;
        }
        Ok(())
    }

    /// Computes the facts that draws need of their geometries.
    ///
    /// # Errors
    /// When they do not fit the budget.
    fn prepare_geometries(&mut self, all: &[PreparedDraw]) -> Result<(), OverBudget> {
        all.iter().try_for_each(|prepared| self.prepare_geometry(prepared))
    }

    /// Reserves the memory for drawing these objects; `face_list` is that of the faces drawn in
    /// submission order.
    fn reserve_scene(
        &mut self,
        all: &[PreparedDraw],
        target: &Target,
        face_list: &WorkingBytes,
    ) -> Result<(), PipelineError> {
        self.reserve(target, |own| {
            let mut worst = *face_list;
            let is_large = |p: &&PreparedDraw| !is_small(p);
            all.iter().filter(is_large).for_each(|p| worst.cover(&own.at_worst(p, target)));
            // Small objects share one bound, the most that any of them can need.
            let small = all.iter().filter(|p| is_small(p)).map(|p| binding_bytes(p.call)).max();
            if let Some(surfaces) = small {
                worst.cover(&small_at_worst(surfaces, target, own.list_limits()));
            }
            worst
        })?;
        Ok(())
    }

    /// Draws faces of the first objects of `all`, as their plans say, and returns the number of these
    /// objects: several that the tile renderer draws together, which have no lines and points, or
    /// one; its faces of a layer in order, or a wireframe completely. `each` is given the counts of
    /// each.
    fn draw_faces(
        &mut self,
        all: &mut [PreparedDraw],
        layer: Layer,
        target: &mut Target,
        each: &mut dyn FnMut(usize, DrawStats),
    ) -> usize {
        if all[0].parts.uses(Part::TileRenderer) {
            let count = self.batch_size(all, target);
            let context = DrawContext { level: self.level(), executor: &self.executor };
            let batch = &mut self.workspace.draw_batch;
            let each = &mut |i: usize, stats| {
                note_occlusion(&all[i], &stats);
                each(i, stats);
            };
            return match batch.draw(context, &all[..count], target, each) {
                0 => batch.draw(context, &all[..1], target, each),
                drawn => drawn,
            };
        }
        let (prepared, mut stats) = (&mut all[0], DrawStats::default());
        let (preemption, items) = (prepared.preemption, prepared.items());
        preemption.without(target, items, || prepared.transform_all());
        if prepared.call.shade == ShadeMode::Wire {
            prepared.draw_wire(target, &mut stats);
            each(0, stats);
            return 1;
        }
        let all = std::slice::from_ref(&*prepared);
        let mut order = std::mem::take(&mut self.workspace.order);
        preemption.without(target, items, || {
            order.collect_faces(all, |p, t| p.is_in(t, layer));
            if prepared.parts.uses(Part::SortFaces) {
                order.sort(all, self.executor.cancel());
            }
        });
        self.draw_in_order(all, order.list(), target, &mut stats);
        self.workspace.order = order;
        each(0, stats);
        1
    }

    /// Returns how many of the first objects of `all` the tile renderer draws together: more than
    /// one if they are shared, and there is memory.
    fn batch_size(&mut self, all: &[PreparedDraw], target: &Target) -> usize {
        if all.len() < 2 || !self.shares_small_draws() {
            return 1;
        }
        let count = self.workspace.draw_batch.count(all, target);
        let mut required = WorkingBytes::default();
        let surfaces = all[..count].iter().map(|p| binding_bytes(p.call));
        required[Working::DrawBatch] = DrawBatch::worst_bytes(surfaces, self.threads(), target);
        if count > 1 && self.working.reserve(&required).is_ok() { count } else { 1 }
    }

    /// Draws faces of several objects in the list's order; an entry is (object index, triangle
    /// index).
    fn draw_in_order(
        &mut self,
        all: &[PreparedDraw],
        list: &[(usize, u32)],
        target: &mut Target,
        stats: &mut DrawStats,
    ) {
        let context = DrawContext { level: self.level(), executor: &self.executor };
        draw_in_order(context, &mut self.workspace.face_list, all, list, target, stats);
    }
}

/// Draws a scene by the reference; see [`Renderer::draw_scene`].
///
/// # Errors
/// As [`Renderer::draw_scene`].
pub fn draw_scene(
    target: &mut Target,
    scene: &Scene,
    options: &SceneOptions,
) -> Result<DrawStats, PipelineError> {
    let reference = RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() };
    Renderer::new(reference).draw_scene(target, scene, options)
}

/// Returns a draw's geometry if it is shared.
fn shared<'a>(call: &DrawCall<'a>) -> Option<&'a Arc<Geometry>> {
    call.shared.filter(|shared| std::ptr::eq(Arc::as_ptr(shared), call.geometry))
}

/// Notes how much of a mesh was hidden, unless the draw was cancelled.
fn note_occlusion(prepared: &PreparedDraw, stats: &DrawStats) {
    if prepared.parts.uses(Part::DepthMemory) && !prepared.cancel.is_cancelled() {
        prepared.geometry_info.occlusion.note(stats, prepared.parts.uses(Part::CoarseDepth));
    }
}

/// Returns whether [`small_at_worst`] bounds the draw's working memory.
fn is_small(prepared: &PreparedDraw) -> bool {
    prepared.parts.uses(Part::TileRenderer) && prepared.call.geometry.mesh.triangles.len() <= SMALL_FACES
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::DepthFormat;
    use crate::scene::shapes;

    /// Returns a scene of one large mesh and many small ones, some of them transparent.
    fn crowd() -> Scene {
        use crate::truth::scenes::{lit_triangle, object};
        let mut scene = lit_triangle();
        scene.objects.push(object("knot", shapes::knot(160, 40).expect("a knot")));
        for i in 0..200 {
            let mut one = object("box", shapes::cuboid(glam::DVec3::splat(0.3)).expect("a box"));
            one.model =
                glam::DMat4::from_translation(glam::DVec3::new(f64::from(i % 20) / 5.0 - 2.0, 0.0, 0.1));
            one.material.transparency = if i % 5 == 0 { 0.5 } else { 0.0 };
            scene.objects.push(one);
        }
        scene
    }

    #[test]
    fn working_memory_is_reserved_in_the_budget_that_was_set_last() {
        use crate::memory::MemoryUse;
        let (scene, options) = (crowd(), SceneOptions::new(320, 240));
        let (first, second) = (MemoryBudget::new(1 << 30), MemoryBudget::new(1 << 30));
        let mut renderer = Renderer::default();
        for budget in [&first, &second] {
            renderer.set_budget(budget);
            assert_eq!((first.used(), renderer.reserved_bytes()), (0, 0));
            let (mut memory, mut depth) = (VideoMemory::new(320, 240).unwrap(), None);
            let depth_format = DepthFormat::F32;
            let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
            renderer.draw_scene(&mut target, &scene, &options).unwrap();
            assert!(renderer.reserved_bytes() > 0);
            assert_eq!(budget.used_for(MemoryUse::Draws), renderer.reserved_bytes());
        }
        // What does not fit is refused.
        let none = MemoryBudget::new(1000);
        renderer.set_budget(&none);
        let (mut memory, mut depth) = (VideoMemory::new(320, 240).unwrap(), None);
        let depth_format = DepthFormat::F32;
        let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
        assert!(renderer.draw_scene(&mut target, &scene, &options).is_err());
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn pairs_of_vectors_draw_the_same_bytes() {
        use crate::simd::{Level, with_pairs};
        if !Level::Avx2.is_available() {
            return;
        }
        for seed in 1..61 {
            let case = crate::truth::scenes::random(seed);
            let (options, depth_format) = (SceneOptions::new(160, 120), case.format);
            let draw = |pairs| {
                let (mut memory, mut depth) = (VideoMemory::new(160, 120).unwrap(), None);
                let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
                let of = RenderOptions { simd: Some(Level::Avx2), ..RenderOptions::default() };
                with_pairs(pairs, || {
                    Renderer::new(of).draw_scene(&mut target, &case.scene, &options).unwrap()
                });
                memory
            };
            let [one, two] = [false, true].map(draw);
            assert!(one.bytes() == two.bytes(), "seed {seed}");
        }
    }

    #[test]
    fn cancelled_draws_end_early_and_leave_nothing_to_later_ones() {
        use crate::scene::HiddenSurface;
        let (scene, pool) = (crowd(), rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap());
        let pool = Arc::new(pool);
        let draw = |renderer: &mut Renderer, options: &SceneOptions, depth_format| {
            let (mut memory, mut depth) = (VideoMemory::new(320, 240).unwrap(), None);
            let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
            renderer.draw_scene(&mut target, &scene, options).unwrap();
            memory
        };
        for (shade, hide, format) in [
            (ShadeMode::Phong, HiddenSurface::ZBuffer, DepthFormat::F32),
            (ShadeMode::Gouraud, HiddenSurface::ZBuffer, DepthFormat::U16),
            (ShadeMode::Flat, HiddenSurface::Painter, DepthFormat::F32),
            (ShadeMode::Wire, HiddenSurface::ZBuffer, DepthFormat::Reversed),
        ] {
            let options = SceneOptions { shade, hide, ..SceneOptions::new(320, 240) };
            for pool in [None, Some(pool.clone())] {
                let of = RenderOptions { pool, ..RenderOptions::default() };
                let want = draw(&mut Renderer::new(of.clone()), &options, format);
                let mut renderer = Renderer::new(of);
                for wait in [0, 20, 100, 400, 1500, 5000] {
                    let cancel = CancelToken::new();
                    renderer.set_cancel(cancel.clone());
                    std::thread::scope(|scope| {
                        scope.spawn(|| {
                            std::thread::sleep(std::time::Duration::from_micros(wait));
                            cancel.cancel();
                        });
                        drop(draw(&mut renderer, &options, format));
                    });
                    let cancelled = draw(&mut renderer, &options, format);
                    assert!(cancelled.bytes() != want.bytes(), "a cancelled renderer draws no more");
                    renderer.set_cancel(CancelToken::default());
                    let got = draw(&mut renderer, &options, format);
                    assert!(got.bytes() == want.bytes(), "{shade:?} {hide:?} after {wait} us");
                }
            }
        }
    }
}

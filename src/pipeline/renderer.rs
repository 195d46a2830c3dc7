//! The renderer that programs use: draws each mesh by the fastest path that serves it.
//!
//! In: the arguments of [`super::draw`] and [`super::draw_scene`]. Out: the same picture within the
//! limits of the plain path, which is the reference. The renderer keeps working memory and facts
//! about shared geometries, including their indexed meshes, from draw to draw. It starts no thread;
//! a pool is passed to it. The bytes do not depend on the pool or the SIMD level.

use super::depth_sort::FaceOrder;
use super::draw_call::{CoarseDepth, DrawCall, DrawStats, PipelineError, SceneOptions, Target};
use super::geometry_cache::{GeometryInfo, Needs};
use super::ordered::{FaceList, draw_in_order};
use super::plan::{Part, Plan};
use super::prepared_draw::{Layer, PreparedDraw, RecycledLists};
use super::scene::{SceneBackend, SceneLists, draw_scene_with, plan_scene_for};
use super::tile::{HIERARCHICAL_Z_BYTES, LIST_BYTES, list_bound};
use super::tile_frontend::{DrawBatch, DrawContext, Workspace, binding_bytes, unsupported_reason};
use super::vertex::Vertex;
use super::working::{SMALL_FACES, Working, WorkingBytes, WorkingMemory, at_worst, ordered, small_at_worst};
use crate::cancel::CancelToken;
use crate::executor::Executor;
use crate::memory::{DepthFormat, MemoryBudget, OverBudget, Rgba, VideoMemory};
use crate::scene::{Geometry, Scene, ShadeMode};
use crate::simd::{Level, fill_pixels};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

/// The code path that draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum RenderPath {
    /// The tile renderer where it supports the draw, otherwise the plain path.
    #[default]
    Fast,
    /// The plain path for every draw: the reference.
    Plain,
}

/// Settings of a [`Renderer`].
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    /// Thread pool that shares the work; `None` for the calling thread alone.
    pub pool: Option<Arc<rayon::ThreadPool>>,
    /// SIMD level of the kernels; `None` for the best that this CPU has.
    pub simd: Option<Level>,
    /// The code path that draws.
    pub path: RenderPath,
    /// Hierarchical culling of hidden faces, tile by tile.
    pub coarse: CoarseDepth,
    /// Token that ends a draw early. Pixels drawn so far stay; the returned statistics are
    /// meaningless.
    pub cancel: CancelToken,
}

/// Draws meshes and scenes, and keeps working memory and geometry facts between draws.
#[derive(Debug, Default)]
pub struct Renderer {
    options: RenderOptions,
    executor: Executor,
    workspace: Workspace,
    cache: Cache,
    /// Lists of the last draw, for reuse.
    recycled: RecycledLists,
    /// Faces of one object that are drawn in submission order.
    order: FaceOrder,
    /// Prepared faces that [`draw_in_order`] works on.
    face_list: FaceList,
    /// Batch of small draws that are rasterized together, for reuse.
    draw_batch: DrawBatch,
    /// Lists of the last scene, for reuse.
    lists: SceneLists,
    /// Budget reservation for all of the above.
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
        let executor = Executor::new(options.pool.clone(), options.cancel.clone());
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
        self.executor = Executor::new(options.pool.clone(), options.cancel.clone());
        self.options = options;
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
        self.recycled = RecycledLists::default();
        self.order = FaceOrder::default();
        self.face_list = FaceList::default();
        self.draw_batch = DrawBatch::default();
        self.lists = SceneLists::default();
        self.cache.forget_dropped();
        self.working.clear();
        self.bound = ListBound::default();
    }

    /// Returns the number of threads that draw.
    fn threads(&self) -> u64 {
        self.options.pool.as_ref().map_or(1, |p| p.current_num_threads()) as u64
    }

    /// Computes the facts that a draw needs of its geometry, within the budget.
    fn prepare_geometry(&mut self, prepared: &PreparedDraw) -> Result<(), OverBudget> {
        let mesh = &prepared.call.geometry.mesh;
        let needs = match self.options.path {
            RenderPath::Fast => prepared.needs(),
            RenderPath::Plain => Needs { prepared: None, faces: false, ..prepared.needs() },
        };
        match prepared.geometry_info.prepare(mesh, needs, self.working.budget()) {
            Ok(()) => Ok(()),
            Err(_) => {
                self.release();
                prepared.geometry_info.prepare(mesh, needs, self.working.budget())
            }
        }
    }

    /// Returns the worst-case working memory of a draw.
    fn at_worst(&self, prepared: &PreparedDraw, target: &Target) -> WorkingBytes {
        let bound = (self.threads(), self.bound.0);
        at_worst(prepared.call, target, &prepared.plan, prepared.geometry_info.vertex_count(), bound)
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
        self.workspace.bound_lists(self.bound.0 as usize);
        Ok(())
    }

    /// Reserves the plain path's memory for a draw that was planned for the tile renderer. Returns
    /// whether it fits.
    fn reserve_plain(&mut self, prepared: &PreparedDraw) -> bool {
        let mesh = &prepared.call.geometry.mesh;
        let mut required = WorkingBytes::default();
        required[Working::Vertices] = mesh.positions.len() as u64 * size_of::<Vertex>() as u64;
        ordered(&mut required, mesh.triangles.len() as u64, false);
        self.working.reserve(&required).is_ok()
    }

    /// Returns to the budget what was reserved for the worst case and is not in use.
    fn shrink_reservation(&mut self) {
        if self.working.is_large() {
            self.working.shrink_reservation(self.workspace.list_bytes(), self.draw_batch.held_bytes());
        }
    }

    /// Returns the SIMD level of the kernels.
    pub fn level(&self) -> Level {
        self.options.simd.unwrap_or_else(Level::best).min(Level::best())
    }

    /// Returns the bytes kept from draw to draw: working memory and cached geometry facts.
    pub fn size_bytes(&self) -> usize {
        self.workspace.size_bytes()
            + self.lists.size_bytes()
            + self.recycled.size_bytes()
            + self.order.size_bytes()
            + self.draw_batch.size_bytes()
            + self.face_list.size_bytes()
            + self.cache.entries.values().map(|e| e.geometry_info.size_bytes()).sum::<usize>()
    }

    /// Fills the frame with `color`, on all threads if the frame is large enough.
    pub fn clear(&self, memory: &mut VideoMemory, color: Rgba) {
        let Some(pool) = self.executor.pool() else { return memory.clear(color) };
        let pixels = memory.bytes_mut().as_chunks_mut::<4>().0;
        let share = pixels.len().div_ceil(pool.current_num_threads());
        if share < LARGE_SHARE {
            return memory.clear(color);
        }
        pool.install(|| pixels.par_chunks_mut(share).for_each(|run| fill_pixels(run, color)));
        memory.mark_rows(0..memory.height());
    }

    /// Returns the plan of [`super::plan_scene`], with this renderer's threads and its hierarchical
    /// culling.
    pub fn plan_scene(&self, target: &Target, scene: &Scene, options: &SceneOptions) -> Plan {
        let mut plan = plan_scene_for(target, scene, options, self.threads());
        if plan.uses(Part::TileRenderer) && plan.uses(Part::DepthMemory) {
            match (self.options.coarse, target.depth_format) {
                (CoarseDepth::Off, _) => {}
                (CoarseDepth::On, DepthFormat::F32) => {
                    let threads = self.options.pool.as_ref().map_or(1, |p| p.current_num_threads()) as u64;
                    let reason = "hidden faces are left out by cells of 16x8 pixels";
                    plan.add(
                        Part::CoarseDepth,
                        reason,
                        plan.item(Part::TileRenderer).count,
                        threads * HIERARCHICAL_Z_BYTES,
                    );
                }
                (CoarseDepth::On, _) => plan.leave_out(Part::CoarseDepth, "only f32 depths have it"),
            }
        }
        plan
    }

    /// Draws one mesh, like [`super::draw`].
    ///
    /// # Errors
    /// As [`super::draw`], and when the working memory does not fit the budget.
    pub fn draw(&mut self, target: &mut Target, call: &DrawCall) -> Result<DrawStats, PipelineError> {
        let mut stats = DrawStats::default();
        let cancel = self.options.cancel.clone();
        let mut prepared = PreparedDraw::with(
            call,
            target,
            self.geometry_info(call),
            std::mem::take(&mut self.recycled),
            &mut stats,
        )?;
        prepared.cancel = &cancel;
        self.prepare_geometry(&prepared)?;
        self.reserve(target, |own| own.at_worst(&prepared, target))?;
        prepared.open_buffers(target);
        self.faces(&mut prepared, Layer::All, target, &mut stats);
        prepared.draw_lines(target, &mut stats);
        prepared.draw_points(target, &mut stats);
        self.recycled = prepared.into_recycled();
        self.shrink_reservation();
        Ok(stats)
    }

    /// Draws a scene, like [`super::draw_scene`].
    ///
    /// # Errors
    /// As [`super::draw_scene`], and when the working memory does not fit the budget.
    pub fn draw_scene(
        &mut self,
        target: &mut Target,
        scene: &Scene,
        options: &SceneOptions,
    ) -> Result<DrawStats, PipelineError> {
        let stats = draw_scene_with(self, target, scene, options)?;
        self.shrink_reservation();
        Ok(stats)
    }
}

impl SceneBackend for Renderer {
    fn executor(&self) -> &Executor {
        &self.executor
    }

    fn geometry_info(&mut self, call: &DrawCall) -> Arc<GeometryInfo> {
        match call.shared.filter(|shared| std::ptr::eq(Arc::as_ptr(shared), call.geometry)) {
            Some(shared) => self.cache.geometry_info(shared, &self.options.cancel),
            None => Arc::new(GeometryInfo::of(call.geometry, CancelToken::default())),
        }
    }

    fn lists(&mut self) -> &mut SceneLists {
        &mut self.lists
    }

    fn reserve_objects(&mut self, bytes: u64) -> Result<(), PipelineError> {
        let mut required = WorkingBytes::default();
        required[Working::Objects] = bytes;
        if self.working.reserve(&required).is_err() {
            self.release();
            self.working.reserve(&required)?;
        }
        Ok(())
    }

    fn reserve_scene(
        &mut self,
        all: &[PreparedDraw],
        (target, face_list): (&Target, &WorkingBytes),
    ) -> Result<(), PipelineError> {
        for prepared in all {
            self.prepare_geometry(prepared)?;
        }
        self.reserve(target, |own| {
            let mut worst = *face_list;
            let is_large = |p: &&PreparedDraw| !is_small(p);
            all.iter().filter(is_large).for_each(|p| worst.cover(&own.at_worst(p, target)));
            // Small objects share one bound, the most that any of them can need.
            let small = all.iter().filter(|p| is_small(p)).map(|p| binding_bytes(p.call)).max();
            if let Some(surfaces) = small {
                worst.cover(&small_at_worst(surfaces, target, (own.threads(), own.bound.0)));
            }
            worst
        })?;
        Ok(())
    }

    fn faces(
        &mut self,
        prepared: &mut PreparedDraw,
        layer: Layer,
        target: &mut Target,
        stats: &mut DrawStats,
    ) {
        let is_fast = self.options.path == RenderPath::Fast
            && layer != Layer::Transparent
            && unsupported_reason(prepared.call, target, &prepared.plan).is_none();
        if is_fast {
            let coarse = self.options.coarse;
            let context = DrawContext {
                level: self.level(),
                executor: &self.executor,
                coarse,
                workspace: &mut self.workspace,
            };
            if prepared.draw_fast(context, target, stats) {
                return;
            }
        }
        if prepared.plan.uses(Part::TileRenderer) && !self.reserve_plain(prepared) {
            // The plan did not foresee this path, and its lists do not fit: draw face by face
            // without them.
            (0..prepared.call.geometry.mesh.triangles.len() as u32)
                .for_each(|t| prepared.draw_face(t, layer, target, stats));
            return;
        }
        prepared.transform_all();
        if prepared.call.shade == ShadeMode::Wire {
            prepared.draw_wire(target, stats);
        } else {
            let all = std::slice::from_ref(&*prepared);
            let mut order = std::mem::take(&mut self.order);
            order.collect_faces(all, |p, t| p.is_in(t, layer));
            if prepared.plan.uses(Part::SortFaces) {
                order.sort(all, self.executor.cancel());
            }
            self.draw_in_order(all, order.list(), target, stats);
            self.order = order;
        }
    }

    fn draw_batch(&mut self, all: &[PreparedDraw], target: &mut Target, stats: &mut DrawStats) -> usize {
        if self.options.path == RenderPath::Plain || self.threads() < 2 {
            return 0;
        }
        let count = self.draw_batch.count(all, target);
        let mut required = WorkingBytes::default();
        required[Working::DrawBatch] = {
            let surfaces = all[..count].iter().map(|p| binding_bytes(p.call));
            DrawBatch::worst_bytes(surfaces, self.threads(), target)
        };
        // If the batch does not fit, each object is drawn by itself.
        if count == 0 || self.working.reserve(&required).is_err() {
            return 0;
        }
        self.draw_batch.draw(
            (self.level(), &self.executor, self.options.coarse),
            &all[..count],
            target,
            stats,
        )
    }

    fn draw_in_order(
        &mut self,
        all: &[PreparedDraw],
        list: &[(usize, u32)],
        target: &mut Target,
        stats: &mut DrawStats,
    ) {
        let level = (self.options.path == RenderPath::Fast).then(|| self.level());
        draw_in_order((&self.executor, level), &mut self.face_list, all, list, target, stats);
    }
}

/// Returns whether [`small_at_worst`] bounds the draw's working memory.
fn is_small(prepared: &PreparedDraw) -> bool {
    prepared.plan.uses(Part::TileRenderer) && prepared.call.geometry.mesh.triangles.len() <= SMALL_FACES
}

/// Maximum number of geometries in the cache.
const MOST_ENTRIES: usize = 1 << 15;

/// Maximum bytes of cached geometry facts, apart from those in use.
const MOST_BYTES: usize = 1 << 30;

/// Cached facts about shared geometries, by address.
#[derive(Debug, Default)]
struct Cache {
    entries: HashMap<usize, Entry>,
    /// Number of look-ups so far.
    clock: u64,
}

/// Cached facts about one geometry.
#[derive(Debug)]
struct Entry {
    /// Keeps the address from being reused for another geometry, but not the geometry alive.
    /// Changing a geometry in place while this exists either moves it to a new address
    /// (`Arc::make_mut`) or fails (`Arc::get_mut`).
    geometry: Weak<Geometry>,
    geometry_info: Arc<GeometryInfo>,
    /// Value of the cache's clock at the last look-up.
    last_used: u64,
}

impl Cache {
    /// Returns the facts about a shared geometry, and caches them.
    fn geometry_info(&mut self, shared: &Arc<Geometry>, cancel: &CancelToken) -> Arc<GeometryInfo> {
        self.clock += 1;
        let address = Arc::as_ptr(shared).addr();
        if let Some(entry) = self.entries.get_mut(&address) {
            entry.last_used = self.clock;
            return Arc::clone(&entry.geometry_info);
        }
        self.forget();
        let geometry_info = Arc::new(GeometryInfo::of(shared, cancel.clone()));
        let geometry = Arc::downgrade(shared);
        self.entries.insert(
            address,
            Entry { geometry, geometry_info: Arc::clone(&geometry_info), last_used: self.clock },
        );
        geometry_info
    }

    /// Drops the entries of geometries that no longer exist.
    fn forget_dropped(&mut self) {
        self.entries.retain(|_, e| e.geometry.strong_count() > 0);
    }

    /// Drops the entries of geometries that no longer exist and, if that is not enough, the older
    /// half of the rest.
    fn forget(&mut self) {
        // Scans all entries only when their number has doubled or is at its limit.
        if self.entries.len().is_power_of_two() || self.entries.len() >= MOST_ENTRIES {
            self.forget_dropped();
            let bytes: usize = self.entries.values().map(|e| e.geometry_info.size_bytes()).sum();
            if self.entries.len() >= MOST_ENTRIES || bytes > MOST_BYTES {
                let mut times: Vec<u64> = self.entries.values().map(|e| e.last_used).collect();
                times.sort_unstable();
                let middle = times[times.len() / 2];
                self.entries.retain(|_, e| e.last_used > middle);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;

    #[test]
    fn a_geometry_is_known_by_its_address_as_long_as_that_is_its_own() {
        let mut cache = Cache::default();
        let geometry = |n| Arc::new(Geometry { mesh: shapes::knot(n, 4).expect("a knot"), textures: vec![] });
        let mut first = geometry(5);
        let never = &CancelToken::default();
        let geometry_info = cache.geometry_info(&first, never);
        assert!(Arc::ptr_eq(&geometry_info, &cache.geometry_info(&first, never)));
        // Changing it in place moves it, because the cache holds a weak reference.
        Arc::make_mut(&mut first).mesh.positions[0].x = 9.0;
        assert!(!Arc::ptr_eq(&geometry_info, &cache.geometry_info(&first, never)));
        drop(first);
        for n in 6..40 {
            let other = geometry(n);
            let geometry_info = cache.geometry_info(&other, never);
            assert_eq!(geometry_info.prepared(&other.mesh, false).triangle_count, n as usize * 8);
        }
        assert!(cache.entries.len() < 20, "{} of dropped geometries are left", cache.entries.len());
    }

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

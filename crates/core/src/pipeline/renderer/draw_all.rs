//! Drawing several draw calls at once: the same as one after another.
//!
//! In: draw calls in order, which may differ in every state. Out: their picture, and the counts or
//! the error of each. A small draw has too little work for two threads; several of them that follow
//! each other are prepared over the threads and rasterized in one batch, as the objects of a scene
//! are.

use super::Renderer;
use super::draw_scene::{MANY_OBJECTS, ObjectDraws};
use super::workspace::SceneLists;
use crate::executor::prelude::*;
use crate::pipeline::depth_sort::recycle;
use crate::pipeline::draw_call::{DrawCall, DrawStats, PipelineError, Target};
use crate::pipeline::geometry_cache::GeometryInfo;
use crate::pipeline::light::PreparedLight;
use crate::pipeline::plan::Part;
use crate::pipeline::prepared_draw::{Layer, PreparedDraw, RecycledLists, check};
use crate::pipeline::vertex::Vertex;
use crate::pipeline::working::{Working, WorkingBytes};
use crate::pipeline::worst_case::SMALL_FACES;
use crate::scene::CameraMatrices;
use std::sync::Arc;

/// Maximum number of draw calls that are prepared together.
const MOST_CALLS: usize = 256;

impl Renderer {
    /// Draws several calls as [`Renderer::draw`] does one after another: the same bytes, and the
    /// result of each. On two threads or more, small draws that follow each other share them.
    pub fn draw_all(
        &mut self,
        target: &mut Target,
        calls: &[DrawCall],
    ) -> Vec<Result<DrawStats, PipelineError>> {
        let is_small = |call: &&DrawCall| call.geometry.mesh.triangles.len() <= SMALL_FACES;
        let mut results = Vec::with_capacity(calls.len());
        while results.len() < calls.len() {
            let (done, rest) = (results.len(), &calls[results.len()..]);
            let run = rest.iter().take(MOST_CALLS).take_while(is_small).count();
            if self.shares_small_draws() && run > 1 {
                let counts = self.draw_together(target, &rest[..run]);
                results.extend(counts.into_iter().map(Ok));
            }
            if results.len() == done {
                results.push(self.draw(target, &rest[0]));
            }
        }
        results
    }

    /// Draws the first of these calls together and returns the counts of each: all of them, or those
    /// before the first that is refused or does not fit the budget.
    fn draw_together(&mut self, target: &mut Target, calls: &[DrawCall]) -> Vec<DrawStats> {
        let (cancel, preemption) = (self.options.cancel.clone(), self.options.preemption.clone());
        let SceneLists { calls: no_calls, prepared: all, mut geometry_infos, mut recycled, order } =
            std::mem::take(&mut self.workspace.scene);
        let mut all: Vec<PreparedDraw> = all;
        let mut required = draw_bytes(calls);
        let cameras = match self.reserve_objects(required[Working::Objects]) {
            Ok(()) => self.check_all(calls, &mut geometry_infos),
            Err(_) => Vec::new(),
        };
        let calls = &calls[..cameras.len()];
        recycled.resize_with(calls.len(), RecycledLists::default);
        let (shared, cancel, preemption) = (&*target, &cancel, &preemption);
        let backend = self.backend();
        let prepare = |((call, camera), (info, recycled)): ((_, &CameraMatrices), (_, &mut _))| {
            let (camera, target, keeps_depth) = (*camera, shared, true);
            let draws = ObjectDraws { camera, target, backend, keeps_depth, cancel, preemption };
            draws.prepare(call, info, recycled)
        };
        match self.executor.pool() {
            Some(pool) if calls.len() >= MANY_OBJECTS => self.executor.region(|| {
                pool.install(|| {
                    let lists = geometry_infos.par_drain(..).zip(&mut recycled[..]);
                    let each = calls.par_iter().zip(cameras.par_iter()).zip(lists);
                    let prepare = |inputs| self.executor.whole_piece(|| prepare(inputs));
                    all.par_extend(each.with_min_len(MANY_OBJECTS / 2).map(prepare));
                });
            }),
            _ => {
                let lists = geometry_infos.drain(..).zip(&mut recycled[..]);
                all.extend(calls.iter().zip(&cameras).zip(lists).map(prepare));
            }
        }
        let ready = all.iter().take_while(|prepared| self.prepare_geometry(prepared).is_ok()).count();
        all.truncate(ready);
        // Draws by the plain path keep their vertices to the end.
        let in_order = all.iter().filter(|prepared| !prepared.parts.uses(Part::TileRenderer));
        required[Working::Vertices] =
            in_order.map(PreparedDraw::vertices_in).sum::<u64>() * size_of::<Vertex>() as u64;
        if self.reserve_scene(&all, target, &required).is_err() {
            all.clear();
        }
        let counts = self.draw_prepared(target, &mut all);
        for (prepared, recycled) in all.iter_mut().zip(&mut recycled) {
            *recycled = prepared.take_recycled();
        }
        let prepared = recycle(all);
        self.workspace.scene = SceneLists { calls: no_calls, prepared, geometry_infos, recycled, order };
        self.shrink_reservation();
        counts
    }

    /// Checks draw calls up to the first that is refused, and collects the facts about their
    /// geometries. Returns the camera of each.
    fn check_all(
        &mut self,
        calls: &[DrawCall],
        geometry_infos: &mut Vec<Arc<GeometryInfo>>,
    ) -> Vec<CameraMatrices> {
        let mut cameras = Vec::with_capacity(calls.len());
        for (i, call) in calls.iter().enumerate() {
            let info = self.geometry_info(call);
            // Most calls have the camera of the one before.
            let same =
                |earlier: &DrawCall| (earlier.camera, earlier.viewport) == (call.camera, call.viewport);
            let previous =
                i.checked_sub(1).filter(|&before| same(&calls[before])).map(|before| cameras[before]);
            if check(call, &info).is_err() {
                break;
            }
            let Some(camera) = previous.or_else(|| PreparedDraw::camera_of(call).ok()) else { break };
            cameras.push(camera);
            geometry_infos.push(info);
        }
        cameras
    }

    /// Draws prepared draws in their order, and returns the counts of each.
    fn draw_prepared(&mut self, target: &mut Target, all: &mut [PreparedDraw]) -> Vec<DrawStats> {
        let before = |p: &PreparedDraw| DrawStats { vertices: p.vertices_in(), ..DrawStats::default() };
        let mut counts: Vec<DrawStats> = all.iter().map(before).collect();
        all.iter().for_each(|prepared| prepared.open_buffers(target));
        let mut at = 0;
        while at < all.len() {
            let own = &mut counts[at..];
            let drawn = self.draw_faces(&mut all[at..], Layer::All, target, &mut |i, faces| own[i] += faces);
            for (prepared, stats) in all[at..at + drawn].iter().zip(own) {
                prepared.draw_lines(target, stats);
                prepared.draw_points(target, stats);
            }
            at += drawn;
        }
        counts
    }
}

/// Returns the bytes of draws while they are prepared together.
fn draw_bytes(calls: &[DrawCall]) -> WorkingBytes {
    let each = size_of::<PreparedDraw>()
        + size_of::<CameraMatrices>()
        + size_of::<Arc<GeometryInfo>>()
        + size_of::<RecycledLists>()
        + size_of::<DrawStats>();
    let bytes = |call: &DrawCall| each + call.lights.len() * size_of::<PreparedLight>();
    let mut required = WorkingBytes::default();
    // A list's capacity can be twice its length.
    required[Working::Objects] = 2 * calls.iter().map(bytes).sum::<usize>() as u64;
    required
}

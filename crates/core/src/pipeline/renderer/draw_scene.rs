//! Drawing a scene: background, opaque faces, lines and points, then transparent faces.

use super::Renderer;
use super::workspace::SceneLists;
use crate::cancel::CancelToken;
use crate::executor::prelude::*;
use crate::pipeline::backdrop::{paint, paint_sky};
use crate::pipeline::depth_sort::{FaceOrder, recycle};
use crate::pipeline::draw_call::{Backend, DrawCall, DrawStats, PipelineError, SceneOptions, Target};
use crate::pipeline::geometry_cache::GeometryInfo;
use crate::pipeline::path_plan::add_path;
use crate::pipeline::plan::Part;
use crate::pipeline::preemption::Preemption;
use crate::pipeline::prepared_draw::{Layer, PreparedDraw, RecycledLists, check};
use crate::pipeline::scene::{each_call, leaves_depth_out};
use crate::pipeline::scene_plan::{in_order, object_bytes};
use crate::scene::{CameraMatrices, HiddenSurface, Scene, ShadeMode, TransparencyOrder};
use std::sync::Arc;

/// Number of objects that are prepared between two preemption points.
const OBJECTS_AT_ONCE: usize = 4096;

/// Minimum number of objects that are prepared on the pool.
pub(super) const MANY_OBJECTS: usize = 128;

impl Renderer {
    /// Draws a scene: its background over the viewport, the opaque faces, lines and points, then
    /// the transparent faces in file order or from far to near.
    ///
    /// # Errors
    /// As [`Renderer::draw`]; every object is checked before anything is written, so the target is
    /// then untouched.
    pub fn draw_scene(
        &mut self,
        target: &mut Target,
        scene: &Scene,
        options: &SceneOptions,
    ) -> Result<DrawStats, PipelineError> {
        let (cancel, preemption) = (self.executor.cancel().clone(), self.options.preemption.clone());
        let SceneLists { calls, prepared: mut all, mut geometry_infos, mut recycled, mut order } =
            std::mem::take(&mut self.workspace.scene);
        let mut calls: Vec<DrawCall> = calls;
        let object_bytes = object_bytes(scene);
        self.reserve_objects(object_bytes)?;
        calls.extend(each_call(scene, options));
        // Stages 1 to 3 for every object: faces may be sorted across objects, and transparent faces
        // need a second pass.
        all.reserve(calls.len());
        recycled.resize_with(calls.len(), RecycledLists::default);
        // Facts about a small geometry take as long as some corners do.
        let items: usize = calls.iter().map(|call| 16 + call.geometry.mesh.corners.len()).sum();
        let check = || self.check_calls(&calls, &mut geometry_infos);
        if let Some(camera) = preemption.without(target, items, check)? {
            let first = geometry_infos.first().map(Arc::as_ref);
            let keeps_depth = !leaves_depth_out(&calls, first, options);
            for (calls, recycled) in calls.chunks(OBJECTS_AT_ONCE).zip(recycled.chunks_mut(OBJECTS_AT_ONCE)) {
                preemption.point(target);
                let (cancel, preemption) = (&cancel, &preemption);
                let draws =
                    ObjectDraws { camera, target, backend: self.backend(), keeps_depth, cancel, preemption };
                self.prepare_objects(&draws, calls, &mut geometry_infos, recycled, &mut all);
            }
        }
        let face_list = in_order(all.iter().map(|p| (p.call, p.parts)), options, object_bytes);
        preemption.without(target, items, || self.prepare_geometries(&all))?;
        self.reserve_scene(&all, target, &face_list)?;
        let mut stats = DrawStats::default();
        stats.vertices += all.iter().map(PreparedDraw::vertices_in).sum::<u64>();
        self.paint_background(target, scene, options);
        for prepared in &all {
            prepared.open_buffers(target);
        }
        self.draw_opaque(&mut all, &mut order, target, options.hide, &mut stats);
        self.draw_transparent(&mut all, &mut order, target, options.transparency, &mut stats);
        for (prepared, recycled) in all.iter_mut().zip(&mut recycled) {
            *recycled = prepared.take_recycled();
        }
        let prepared = recycle(all);
        calls.clear();
        self.workspace.scene =
            SceneLists { calls: recycle(calls), prepared, geometry_infos, recycled, order };
        self.shrink_reservation();
        Ok(stats)
    }

    /// Checks the objects' draw calls, and collects the facts about their geometries. Returns the
    /// camera, which all objects share; `None` without objects.
    fn check_calls(
        &mut self,
        calls: &[DrawCall],
        geometry_infos: &mut Vec<Arc<GeometryInfo>>,
    ) -> Result<Option<CameraMatrices>, PipelineError> {
        let mut camera = None;
        for call in calls {
            let geometry_info = self.geometry_info(call);
            check(call, &geometry_info)?;
            if camera.is_none() {
                camera = Some(PreparedDraw::camera_of(call)?);
            }
            geometry_infos.push(geometry_info);
        }
        Ok(camera)
    }

    /// Prepares the objects' draws, on the pool if they are many.
    fn prepare_objects<'c>(
        &self,
        draws: &ObjectDraws<'_, 'c>,
        calls: &'c [DrawCall<'c>],
        geometry_infos: &mut Vec<Arc<GeometryInfo>>,
        recycled: &mut [RecycledLists],
        all: &mut Vec<PreparedDraw<'c>>,
    ) {
        match self.executor.pool() {
            Some(pool) if calls.len() >= MANY_OBJECTS => pool.install(|| {
                let infos = geometry_infos.par_drain(..calls.len());
                let each = calls.par_iter().zip(infos).zip(recycled).with_min_len(MANY_OBJECTS / 2);
                all.par_extend(each.map(|((call, info), recycled)| draws.prepare(call, info, recycled)));
            }),
            _ => {
                let each = calls.iter().zip(geometry_infos.drain(..calls.len())).zip(recycled);
                all.extend(each.map(|((call, info), recycled)| draws.prepare(call, info, recycled)));
            }
        }
    }

    /// Paints the scene's sky or background colour over the viewport.
    fn paint_background(&self, target: &mut Target, scene: &Scene, options: &SceneOptions) {
        match (&scene.sky, scene.background.color) {
            (Some(sky), _) => {
                let camera = scene.camera.unwrap_or(options.camera);
                paint_sky(target, options.viewport, &camera, sky, &self.executor, &self.options.preemption);
            }
            (None, Some(color)) => paint(target, options.viewport, color),
            (None, None) => {}
        }
    }

    /// Draws the opaque faces, and each object's lines and points.
    fn draw_opaque(
        &mut self,
        all: &mut [PreparedDraw],
        order: &mut FaceOrder,
        target: &mut Target,
        hide: HiddenSurface,
        stats: &mut DrawStats,
    ) {
        let is_painted = hide == HiddenSurface::Painter;
        let preemption = self.options.preemption.clone();
        if is_painted {
            preemption.without(target, items_of(all), || {
                all.iter_mut().for_each(PreparedDraw::transform_all);
                order.collect_faces(all, |p, t| !p.is_transparent(t));
                order.sort(all, self.executor.cancel());
            });
            self.draw_in_order(all, order.list(), target, stats);
        }
        let mut at = 0;
        while at < all.len() && !self.executor.is_cancelled() {
            preemption.point(target);
            let end = match is_painted && all[at].call.shade != ShadeMode::Wire {
                true => at + 1,
                false => {
                    at + self.draw_faces(&mut all[at..], Layer::Opaque, target, &mut |_, own| *stats += own)
                }
            };
            for prepared in &all[at..end] {
                prepared.draw_lines(target, stats);
                prepared.draw_points(target, stats);
            }
            at = end;
        }
    }

    /// Draws the transparent faces of all objects.
    fn draw_transparent(
        &mut self,
        all: &mut [PreparedDraw],
        order: &mut FaceOrder,
        target: &mut Target,
        transparency: TransparencyOrder,
        stats: &mut DrawStats,
    ) {
        if !all.iter().any(|p| p.parts.uses(Part::ReadBack)) {
            return;
        }
        self.options.preemption.without(target, items_of(all), || {
            for prepared in all.iter_mut().filter(|p| p.parts.uses(Part::ReadBack)) {
                prepared.transform_all();
            }
            order.collect_faces(all, |p, t| p.is_transparent(t));
            if transparency == TransparencyOrder::Sorted {
                order.sort(all, self.executor.cancel());
            }
        });
        if !order.list().is_empty() {
            self.draw_in_order(all, order.list(), target, stats);
        }
    }
}

/// Returns the number of items on which the time of a scene's stages depends.
fn items_of(all: &[PreparedDraw]) -> usize {
    all.iter().map(PreparedDraw::items).sum()
}

/// State that the draws of a scene's objects share.
pub(super) struct ObjectDraws<'t, 'c> {
    pub camera: CameraMatrices,
    pub target: &'t Target<'t>,
    pub backend: Backend,
    /// True unless the scene needs no depth.
    pub keeps_depth: bool,
    /// Token that cancels the draws.
    pub cancel: &'c CancelToken,
    /// Handle by which they are preempted.
    pub preemption: &'c Preemption,
}

impl<'c> ObjectDraws<'_, 'c> {
    /// Prepares the draw of one object, and plans its path.
    pub fn prepare(
        &self,
        call: &'c DrawCall<'c>,
        geometry_info: Arc<GeometryInfo>,
        recycled: &mut RecycledLists,
    ) -> PreparedDraw<'c> {
        let mut prepared =
            PreparedDraw::of(call, self.camera, self.target, geometry_info, std::mem::take(recycled));
        (prepared.cancel, prepared.preemption) = (self.cancel, self.preemption);
        add_path(&mut prepared, self.target, self.backend, self.keeps_depth);
        prepared
    }
}

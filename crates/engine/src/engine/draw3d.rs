//! The 3-D commands: camera, model matrix, lights, drawing, and queries about drawn pixels.
//!
//! In: a session's 3-D state and the resources that it names. Out: pixels, depths and object
//! numbers in the engine's buffers; counters; replies of DEPTHAT and PICK.

use super::drawing::{Drawing, MeshDraw, SceneDraw};
use super::empty_draw;
use super::scene_request::SceneRequest;
use super::{Effect, Engine, Job, JobResult, Progress, Rendering, default_view};
use crate::Session;
use crate::clock::Instant;
use crate::resources::ResourceKind;
use crate::session::DefaultView;
use fbptr_command::{Command, LightCommand, Rect};
use fbptr_core::error::{Code, Fault};
use fbptr_core::math::matrix;
use fbptr_core::memory::{MemoryUse, Reservation};
use fbptr_core::pipeline::{DrawStats, EmptyDraw, PipelineError, SceneOptions, is_dark};
use fbptr_core::scene::{
    Camera, Geometry, Light, LightKind, LookAt, Projection, Sampling, Scene, TextureUse, TransparencyOrder,
    Viewport, ViewportRule,
};
use glam::{DMat4, DVec3};
use std::sync::Arc;

/// Size of a scene's objects and moving meshes, in bytes, from which it is built by a job.
const LARGE_SCENE_BYTES: u64 = 1 << 19;

impl Engine {
    pub(super) fn look_at(
        &self,
        s: &mut Session,
        eye: DVec3,
        reference: DVec3,
        up: DVec3,
    ) -> Result<(), Fault> {
        self.set_camera(s, Camera { look_at: LookAt { eye, reference, up }, ..s.camera })
    }

    #[expect(clippy::boxed_local, reason = "the command holds it in a box, for its size")]
    pub(super) fn set_projection(&self, s: &mut Session, projection: Box<Projection>) -> Result<(), Fault> {
        self.set_camera(s, Camera { projection: *projection, ..s.camera })
    }

    /// Sets the camera. One without an image is refused here, where its author sees the error, not
    /// at a later DRAW.
    fn set_camera(&self, s: &mut Session, camera: Camera) -> Result<(), Fault> {
        camera.matrices(1.0)?;
        s.camera = camera;
        s.has_own_camera = true;
        s.default_view = DefaultView::Own;
        Ok(())
    }

    pub(super) fn set_viewport(&self, s: &mut Session, rect: Rect, rule: ViewportRule) -> Result<(), Fault> {
        let side = |n: i32| {
            u32::try_from(n)
                .map_err(|_| Fault::new(Code::Range, "a viewport's sides are 0 or more").got(n.to_string()))
        };
        let (width, height) = (side(rect.w)?, side(rect.h)?);
        s.viewport = Some(Viewport { x: rect.x, y: rect.y, width, height, rule });
        Ok(())
    }

    pub(super) fn push_matrix(&mut self, s: &mut Session) -> Result<(), Fault> {
        if !s.has_stack_room(&self.quotas.limits) {
            let message = format!("the matrix stack holds at most {}", self.quotas.limits.matrix_stack);
            return Err(Fault::new(Code::Quota, message));
        }
        if s.stack.len() == s.stack.capacity() {
            // The list's capacity doubles when it grows.
            let bytes = 2 * (s.stack.len().max(4) * size_of::<DMat4>()) as u64;
            let held = s.held.get_or_insert_with(|| self.quotas.budget.empty(MemoryUse::Resources));
            held.try_cover(bytes)?;
        }
        s.stack.push(s.model);
        Ok(())
    }

    pub(super) fn pop_matrix(&self, s: &mut Session) -> Result<(), Fault> {
        s.model = s.stack.pop().ok_or_else(|| Fault::new(Code::Range, "the matrix stack is empty"))?;
        Ok(())
    }

    #[expect(clippy::boxed_local, reason = "the command holds it in a box, for its size")]
    pub(super) fn set_light(
        &mut self,
        s: &mut Session,
        index: i32,
        command: Box<LightCommand>,
    ) -> Result<(), Fault> {
        let index =
            usize::try_from(index).ok().filter(|&i| i < self.quotas.limits.lights).ok_or_else(|| {
                let message = format!("a light's index is from 0 to {}", self.quotas.limits.lights - 1);
                Fault::new(Code::Range, message).got(index.to_string())
            })?;
        let light = |kind, color| Some(Light { kind, color, ambient: DVec3::ZERO, clamp_attenuation: false });
        let directed = |direction: DVec3| {
            matrix::unit(direction).ok_or_else(|| Fault::new(Code::Range, "a light's direction is not 0 0 0"))
        };
        let light = match *command {
            LightCommand::Off => None,
            LightCommand::Point { position, color, attenuation } => {
                light(LightKind::Point { position, attenuation, radius: f64::INFINITY }, color)
            }
            LightCommand::Dir { direction, color } => {
                directed(direction)?;
                light(LightKind::Directional { direction }, color)
            }
            LightCommand::Spot { position, direction, angle_rad, exponent, color, attenuation } => {
                directed(direction)?;
                light(LightKind::Spot { position, direction, angle_rad, exponent, attenuation }, color)
            }
        };
        s.set_light(index, light);
        Ok(())
    }

    pub(super) fn use_texture(
        &mut self,
        s: &mut Session,
        name: Option<String>,
        sampling: Sampling,
    ) -> Result<(), Fault> {
        if let Some(name) = &name {
            self.texture(s, name)?;
        }
        s.texture = name.map(|name| (name, sampling));
        Ok(())
    }

    /// Runs `DRAW`, under `QUALITY max-error` with the settings chosen for it.
    pub(super) fn draw(&mut self, s: &mut Session, name: String) -> Result<Progress, Fault> {
        self.draw_framed(s, name, None)
    }

    /// Draws a mesh, with the camera of the default view that a job has found for it if that takes
    /// long.
    fn draw_framed(
        &mut self,
        s: &mut Session,
        name: String,
        found: Option<(Arc<Geometry>, Option<Camera>)>,
    ) -> Result<Progress, Fault> {
        let mut geometry = self.mesh(s, &name)?;
        // Under a shared name there may be another mesh by now.
        let found = found.filter(|(of, _)| Arc::ptr_eq(of, &geometry)).map(|(_, camera)| camera);
        if self.may_suspend && found.is_none() && default_view::takes_long(s, &geometry.mesh) {
            self.queues_draw = false;
            return Ok(Progress::Job(frame_job(name, geometry)));
        }
        let due = self.due_levels(s, [&geometry].into_iter());
        if !due.is_empty() {
            self.queues_draw = false;
            let command = Command::Draw { name: name.clone() };
            let rest = move |engine: &mut Engine, s: &mut Session| {
                engine.draw_framed(s, name, found.map(|camera| (geometry, camera)))
            };
            return Ok(Progress::Job(self.levels_job(due, command, rest)));
        }
        let has_textures = self.rendering.view_overrides.textures == TextureUse::AsGiven;
        if !has_textures && geometry.textures.iter().any(Option::is_some) {
            geometry = Arc::new(geometry.without_textures());
        }
        let (texture, sampling) = match s.texture.as_ref().filter(|_| has_textures) {
            None => (None, Sampling::default()),
            Some((name, sampling)) => (Some(self.texture(s, name)?), *sampling),
        };
        let viewport = s.viewport_on(self.framebuffer.width(), self.framebuffer.height());
        if viewport.width == 0 || viewport.height == 0 {
            empty_draw::note(s, Some(EmptyDraw::NoViewport));
            return Ok(Progress::Done(Effect::Done));
        }
        let aspect = f64::from(viewport.width) / f64::from(viewport.height);
        let (camera, lights, ambient) = match default_view::of(s, &geometry.mesh, found) {
            Some((camera, light, ambient)) => (camera, vec![light], ambient),
            None => (s.camera, s.lights.iter().flatten().copied().collect(), s.ambient),
        };
        let mut draw = MeshDraw {
            id: self.framebuffer.id_of(&name),
            name,
            geometry,
            texture,
            sampling,
            lights,
            ambient,
            material: s.material.clone(),
            model: s.model,
            camera: self.rendering.view_overrides.navigator.apply(&camera, None, aspect),
            viewport,
            shade: self.rendering.view_overrides.shade.unwrap_or(s.shade),
            cull: self.rendering.view_overrides.cull.unwrap_or(s.cull),
            hide: self.rendering.view_overrides.hide.unwrap_or(s.hide),
            interp: s.interp,
            light_error: None,
            is_dark: false,
            ndc_box: None,
            asked: (s.shade, s.hide),
        };
        draw.is_dark = is_dark(&draw.call());
        self.cheapen_draw(s, &mut draw);
        self.run_drawing(s, Drawing::Mesh(Box::new(draw)))
    }

    /// Runs `DRAWSCENE`, under `QUALITY max-error` with the settings chosen for it.
    pub(super) fn draw_scene(&mut self, s: &mut Session, time: f64, sorted: bool) -> Result<Progress, Fault> {
        self.draw_made_scene(s, time, sorted, None)
    }

    /// Draws the scene, which a job has built if that takes long.
    fn draw_made_scene(
        &mut self,
        s: &mut Session,
        time: f64,
        sorted: bool,
        made: Option<Box<Scene>>,
    ) -> Result<Progress, Fault> {
        let document = self.scene(s)?;
        let (width, height) = (self.framebuffer.width(), self.framebuffer.height());
        let viewport = s.viewport_on(width, height);
        if viewport.width == 0 || viewport.height == 0 {
            empty_draw::note(s, Some(EmptyDraw::NoViewport));
            return Ok(Progress::Done(Effect::Done));
        }
        let bytes = document.scene_bytes();
        let held = self.with_room(|engine| engine.quotas.budget.try_reserve(MemoryUse::Draws, bytes))?;
        let mut scene = match made {
            Some(scene) => *scene,
            None => {
                let request = SceneRequest::of(s, document, time, viewport, self.rendering.view_overrides);
                if self.may_suspend && bytes > LARGE_SCENE_BYTES {
                    return Ok(Progress::Job(scene_job(request, time, sorted, held)));
                }
                request.build()
            }
        };
        let due = self.due_levels(s, scene.objects.iter().map(|object| &object.geometry));
        if !due.is_empty() {
            self.queues_draw = false;
            let rest = move |engine: &mut Engine, s: &mut Session| {
                // Reserved anew by the command.
                drop(held);
                engine.draw_made_scene(s, time, sorted, Some(Box::new(scene)))
            };
            return Ok(Progress::Job(self.levels_job(due, Command::DrawScene { time, sorted }, rest)));
        }
        let mut options = SceneOptions {
            viewport,
            camera: s.camera,
            shade: s.shade,
            hide: self.rendering.view_overrides.hide.unwrap_or(s.hide),
            interp: s.interp,
            transparency: if sorted { TransparencyOrder::Sorted } else { TransparencyOrder::FileOrder },
            first_name: self.framebuffer.ids_of(&scene),
            ..SceneOptions::new(width, height)
        };
        self.cheapen_scene(s, &mut scene, &mut options);
        self.run_drawing(s, Drawing::Scene(Box::new(SceneDraw { scene, options, time, sorted, _held: held })))
    }

    /// Runs a draw, or leaves it to the stream if that lets it wait for others.
    fn run_drawing(&mut self, s: &mut Session, drawing: Drawing) -> Result<Progress, Fault> {
        self.reserve_target(s, drawing.hide())?;
        if std::mem::take(&mut self.queues_draw) {
            return Ok(Progress::Queued(drawing));
        }
        self.draw_now(s, drawing)
    }

    /// Runs a draw whose target is reserved, or hands it to the drawing thread if it may take long.
    pub(super) fn draw_now(&mut self, s: &mut Session, drawing: Drawing) -> Result<Progress, Fault> {
        self.explain_drawing(s, &drawing);
        let frame = self.framebuffer.area();
        let is_timed = self.may_suspend && drawing.is_long(frame);
        let Rendering { draw_times, renderer, .. } = &mut self.rendering;
        let drawing = match is_timed && !draw_times.is_short(&drawing, &self.framebuffer.target(), renderer) {
            true => match self.begin_draw_in_pieces(drawing) {
                Ok(pieces) => return Ok(Progress::Pieces(Box::new(pieces))),
                Err(drawing) => drawing,
            },
            false => drawing,
        };
        let begun = is_timed.then(Instant::now);
        let result = drawing.run(&mut self.rendering.renderer, &mut self.framebuffer.target());
        if let (Some(begun), Ok(_)) = (begun, &result) {
            self.rendering.draw_times.note(&drawing, Instant::now().duration_since(begun));
        }
        self.framebuffer.count_target();
        if result.is_ok() {
            self.check_abandoned(drawing.verb())?;
        }
        self.end_drawing(s, &drawing, result)?;
        self.log_draw(s, drawing);
        Ok(Progress::Done(Effect::Done))
    }

    /// Completes a draw: counts what it drew, and explains it if it shows nothing.
    pub(super) fn end_drawing(
        &mut self,
        s: &mut Session,
        drawing: &Drawing,
        result: Result<DrawStats, PipelineError>,
    ) -> Result<(), Fault> {
        self.framebuffer.count_target();
        let stats = result?;
        self.follow_drawing(drawing);
        self.note_drawn(s, drawing, &stats);
        Ok(())
    }

    /// Counts what a draw has drawn, and explains it if it shows nothing.
    pub(super) fn note_drawn(&mut self, s: &mut Session, drawing: &Drawing, stats: &DrawStats) {
        let memory = &self.framebuffer.memory;
        let (empty, (shade, hide)) = match drawing {
            Drawing::Mesh(draw) => {
                (EmptyDraw::of_call(stats, &draw.call(), memory, draw.is_dark), draw.asked)
            }
            Drawing::Scene(draw) => {
                (EmptyDraw::of_scene(stats, &draw.scene, &draw.options, memory), (s.shade, s.hide))
            }
        };
        empty_draw::note(s, empty);
        s.stats.pixels += stats.pixels_written;
        // Replies are the same for every vector level.
        let tested = match stats.coarse_draws {
            0 => stats.pixels_tested.to_string(),
            _ => "-".to_owned(),
        };
        self.rendering.plan = format!(
            "shade:{},hide:{},depth:{},faces:{},drawn:{},tested:{},lit:{}",
            shade.as_str(),
            hide.as_str(),
            self.framebuffer.depth.as_ref().map_or("none", |d| d.format().as_str()),
            stats.faces,
            stats.faces_drawn,
            tested,
            stats.pixels_lit + stats.vertices_lit,
        );
    }
}

/// Creates the job that finds the camera of the default view for a `DRAW`.
fn frame_job(name: String, geometry: Arc<Geometry>) -> Job {
    Job::new(false, move |_| {
        let camera = default_view::frame(&geometry.mesh);
        let command = Command::Draw { name: name.clone() };
        let draw = move |engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>| {
            engine.draw_framed(s, name, Some((geometry, camera)))
        };
        JobResult::new(command, Ok(draw))
    })
}

/// Creates the job that builds the scene of a `DRAWSCENE`. `held` is the reservation for its
/// objects.
fn scene_job(request: SceneRequest, time: f64, sorted: bool, held: Reservation) -> Job {
    Job::new(false, move |_| {
        let scene = Box::new(request.build());
        let draw = move |engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>| {
            // Reserved anew by the command.
            drop(held);
            engine.draw_made_scene(s, time, sorted, Some(scene))
        };
        JobResult::new(Command::DrawScene { time, sorted }, Ok(draw))
    })
}

/// Creates the fault for a name without a resource.
pub(super) fn missing(kind: ResourceKind, name: &str) -> Fault {
    Fault::new(Code::NoEnt, format!("no {} has this name", kind.as_str())).got(name)
}

//! The 3-D commands: camera, model matrix, lights, drawing, and queries about drawn pixels.
//!
//! In: a session's 3-D state and the resources that it names. Out: pixels, depths and object
//! numbers in the engine's buffers; counters; replies of DEPTHAT and PICK.

use super::drawing::{Drawing, MeshDraw, SceneDraw};
use super::empty_draw::{self, EmptyDraw};
use super::quality::{Found, QualityRequest};
use super::scene_request::{MadeScene, SceneRequest};
use super::{Effect, Engine, IdNames, Job, JobResult, Progress};
use crate::command::{Command, LightCommand, Quality, Rect, Shears};
use crate::error::{Code, Fault};
use crate::math::matrix;
use crate::memory::{DepthFormat, MemoryUse, PickBuffer, Reservation};
use crate::pipeline::quality::BudgetKind;
use crate::pipeline::{DrawStats, PipelineError, Renderer, SceneOptions, Target};
use crate::scene::{
    Camera, CameraError, HiddenSurface, Light, LightKind, LookAt, Object, Projection, QualityUse, Sampling,
    Scene, TextureUse, TransparencyOrder, Viewport, ViewportRule,
};
use crate::server::Session;
use crate::server::resources::ResourceKind;
use glam::{DMat4, DVec3, DVec4};
use std::sync::Arc;

/// Memory of a name in the tables of object names, in bytes without its letters.
const NAME_BYTES: u64 = 96;

/// Memory of a pixel in the pick buffer, in bytes.
const ID_BYTES: u64 = 8;

/// Size of a scene's objects and moving meshes, in bytes, from which it is built by a job.
const LARGE_SCENE_BYTES: u64 = 1 << 19;

/// Number of names at which those that no pixel refers to are removed.
const MAX_ID_NAMES: usize = 1 << 16;

impl From<CameraError> for Fault {
    fn from(e: CameraError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

impl From<PipelineError> for Fault {
    fn from(e: PipelineError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

impl Engine {
    pub(super) fn look_at(&self, s: &mut Session, look_at: LookAt) -> Result<(), Fault> {
        self.set_camera(s, Camera { look_at, ..s.camera })
    }

    pub(super) fn set_projection(&self, s: &mut Session, projection: Projection) -> Result<(), Fault> {
        self.set_camera(s, Camera { projection, ..s.camera })
    }

    /// Sets the camera. One without an image is refused here, where its author sees the error, not
    /// at a later DRAW.
    fn set_camera(&self, s: &mut Session, camera: Camera) -> Result<(), Fault> {
        camera.matrices(1.0)?;
        s.camera = camera;
        s.has_own_camera = true;
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
        if !s.has_stack_room(&self.limits) {
            let message = format!("the matrix stack holds at most {}", self.limits.matrix_stack);
            return Err(Fault::new(Code::Quota, message));
        }
        if s.stack.len() == s.stack.capacity() {
            // The list's capacity doubles when it grows.
            let bytes = 2 * (s.stack.len().max(4) * size_of::<DMat4>()) as u64;
            let held = s.held.get_or_insert_with(|| self.budget.empty(MemoryUse::Resources));
            held.try_cover(bytes)?;
        }
        s.stack.push(s.model);
        Ok(())
    }

    pub(super) fn pop_matrix(&self, s: &mut Session) -> Result<(), Fault> {
        s.model = s.stack.pop().ok_or_else(|| Fault::new(Code::Range, "the matrix stack is empty"))?;
        Ok(())
    }

    pub(super) fn rotate_model(&self, s: &mut Session, axis: DVec3, angle_rad: f64) -> Result<(), Fault> {
        let by = matrix::rotate(axis, angle_rad)
            .ok_or_else(|| Fault::new(Code::Range, "a rotation's axis has a direction, 0 0 0 has none"))?;
        self.multiply_model(s, by)
    }

    pub(super) fn shear_model(&self, s: &mut Session, by: &Shears) -> Result<(), Fault> {
        self.multiply_model(s, matrix::shear(by[0], by[1], by[2], by[3], by[4], by[5]))
    }

    /// Multiplies the model matrix by one whose last row is checked.
    pub(super) fn multiply_affine(&self, s: &mut Session, by: &DMat4) -> Result<(), Fault> {
        let row = by.row(3);
        if row != DVec4::W {
            let found = format!("{} {} {} {}", row.x, row.y, row.z, row.w);
            return Err(Fault::new(Code::Range, "a model matrix's last row is 0 0 0 1").got(found));
        }
        self.multiply_model(s, *by)
    }

    pub(super) fn multiply_model(&self, s: &mut Session, by: DMat4) -> Result<(), Fault> {
        let product = s.model * by;
        if !product.is_finite() {
            return Err(Fault::new(Code::Range, "the model matrix would hold a number that is not finite"));
        }
        s.model = product;
        Ok(())
    }

    pub(super) fn set_light(
        &mut self,
        s: &mut Session,
        index: i32,
        command: LightCommand,
    ) -> Result<(), Fault> {
        let index = usize::try_from(index).ok().filter(|&i| i < self.limits.lights).ok_or_else(|| {
            let message = format!("a light's index is from 0 to {}", self.limits.lights - 1);
            Fault::new(Code::Range, message).got(index.to_string())
        })?;
        let light = |kind, color| Some(Light { kind, color, ambient: DVec3::ZERO, clamp_attenuation: false });
        let directed = |direction: DVec3| {
            matrix::unit(direction).ok_or_else(|| Fault::new(Code::Range, "a light's direction is not 0 0 0"))
        };
        let light = match command {
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

    /// Sets the format of the depth buffer, which all connections share. A change discards its
    /// contents.
    pub(super) fn set_depth_format(&mut self, format: DepthFormat) {
        if format != self.depth_format {
            self.depth_format = format;
            self.depth = None;
            self.held.depth.shrink_to(0);
        }
    }

    /// Runs `DRAW`. Under `QUALITY max-error` it uses the settings that a search has found, or
    /// returns the job that searches them.
    pub(super) fn draw(
        &mut self,
        s: &mut Session,
        name: String,
        found: Option<Found>,
    ) -> Result<Progress, Fault> {
        let searched = found.map(|found| self.note_found(found));
        let mut geometry = self.mesh(s, &name)?;
        let has_textures = self.view_overrides.textures == TextureUse::AsGiven;
        if !has_textures && geometry.textures.iter().any(Option::is_some) {
            geometry = match searched {
                // The searched copy is drawn: the cache identifies geometries by address and would
                // not match a second copy.
                Some(request) => request.geometry(),
                None => Arc::new(geometry.without_textures()),
            };
        }
        let (texture, sampling) = match s.texture.as_ref().filter(|_| has_textures) {
            None => (None, Sampling::default()),
            Some((name, sampling)) => (Some(self.texture(s, name)?), *sampling),
        };
        let viewport = s.viewport_on(self.memory.width(), self.memory.height());
        if viewport.width == 0 || viewport.height == 0 {
            empty_draw::note(s, Some(EmptyDraw::NoViewport));
            return Ok(Progress::Done(Effect::Done));
        }
        let aspect = f64::from(viewport.width) / f64::from(viewport.height);
        let mut draw = MeshDraw {
            id: self.id_of(&name),
            name,
            geometry,
            texture,
            sampling,
            lights: s.lights.iter().flatten().copied().collect(),
            ambient: s.ambient,
            material: s.material.clone(),
            model: s.model,
            camera: self.view_overrides.navigator.apply(&s.camera, None, aspect),
            viewport,
            shade: self.view_overrides.shade.unwrap_or(s.shade),
            cull: self.view_overrides.cull.unwrap_or(s.cull),
            hide: self.view_overrides.hide.unwrap_or(s.hide),
            interp: s.interp,
            is_dark: false,
        };
        draw.is_dark = empty_draw::is_dark(&draw.call());
        if let (Quality::MaxError(max_error), QualityUse::AsGiven) = (s.quality, self.view_overrides.quality)
        {
            let call = draw.call();
            let mut request =
                QualityRequest::of_draw(self, &call, &draw.geometry, draw.texture.as_ref(), max_error);
            let Some(choice) = self.cached_choice(&request) else {
                let (command, name) = (Command::Draw { name: draw.name.clone() }, draw.name);
                return self.search_job(command, request, move |e, s, found| e.draw(s, name, Some(found)));
            };
            request.apply(&choice);
            let cheaper = request.cheaper_draw(&call);
            draw.lights = cheaper.lights;
            (draw.shade, draw.sampling, draw.interp) = (cheaper.shade, cheaper.sampling, cheaper.interp);
        }
        self.run_drawing(s, Drawing::Mesh(Box::new(draw)))
    }

    /// Runs `DRAWSCENE`, with the search of [`Engine::draw`]. The searched scene itself is drawn:
    /// the moving parts of a scene are created anew for each time, so the cache would not match a
    /// second copy.
    pub(super) fn draw_scene(
        &mut self,
        s: &mut Session,
        time: f64,
        sorted: bool,
        made: Option<MadeScene>,
    ) -> Result<Progress, Fault> {
        let document = self.scene(s)?;
        let (width, height) = (self.memory.width(), self.memory.height());
        let viewport = s.viewport_on(width, height);
        if viewport.width == 0 || viewport.height == 0 {
            empty_draw::note(s, Some(EmptyDraw::NoViewport));
            return Ok(Progress::Done(Effect::Done));
        }
        let bytes = document.scene_bytes();
        let held = self.with_room(|engine| engine.budget.try_reserve(MemoryUse::Draws, bytes))?;
        let mut scene = match made {
            Some(MadeScene::Searched(found)) => self.note_found(*found).scene,
            Some(MadeScene::Built(scene)) => *scene,
            None => {
                let request = SceneRequest::of(s, document, time, viewport, self.view_overrides);
                if self.may_suspend && bytes > LARGE_SCENE_BYTES {
                    return Ok(Progress::Job(scene_job(request, time, sorted, held)));
                }
                request.build()
            }
        };
        let mut options = SceneOptions {
            viewport,
            camera: s.camera,
            shade: s.shade,
            hide: self.view_overrides.hide.unwrap_or(s.hide),
            interp: s.interp,
            transparency: if sorted { TransparencyOrder::Sorted } else { TransparencyOrder::FileOrder },
            first_name: self.ids_of(&scene),
            ..SceneOptions::new(width, height)
        };
        if let (Quality::MaxError(max_error), QualityUse::AsGiven) = (s.quality, self.view_overrides.quality)
        {
            let mut request = QualityRequest::of_scene(self, scene, options, BudgetKind::Scene, max_error);
            let Some(choice) = self.cached_choice(&request) else {
                let command = Command::DrawScene { time, sorted };
                let then = move |e: &mut Engine, s: &mut Session, found| {
                    e.draw_scene(s, time, sorted, Some(MadeScene::Searched(Box::new(found))))
                };
                return self.search_job(command, request, then);
            };
            request.apply(&choice);
            (scene, options) = (request.scene, request.options);
        }
        self.run_drawing(s, Drawing::Scene(Box::new(SceneDraw { scene, options, time, sorted, _held: held })))
    }

    /// Runs a draw, or hands it to the drawing thread if it may take long.
    fn run_drawing(&mut self, s: &mut Session, drawing: Drawing) -> Result<Progress, Fault> {
        self.reserve_target(drawing.hide())?;
        let frame = u64::from(self.memory.width()) * u64::from(self.memory.height());
        let drawing = match self.may_suspend && drawing.is_long(frame) {
            true => match self.begin_draw_in_pieces(drawing) {
                Ok(pieces) => return Ok(Progress::Pieces(Box::new(pieces))),
                Err(drawing) => drawing,
            },
            false => drawing,
        };
        let (renderer, mut target) = self.target();
        let result = drawing.run(renderer, &mut target);
        self.count_target();
        if result.is_ok() {
            self.check_abandoned(drawing.verb())?;
        }
        self.end_drawing(s, &drawing, result)?;
        Ok(Progress::Done(Effect::Done))
    }

    /// Completes a draw: counts what it drew, and explains it if it shows nothing.
    pub(super) fn end_drawing(
        &mut self,
        s: &mut Session,
        drawing: &Drawing,
        result: Result<DrawStats, PipelineError>,
    ) -> Result<(), Fault> {
        self.count_target();
        let stats = result?;
        let empty = match drawing {
            Drawing::Mesh(draw) => {
                self.follow_draw(&draw.call(), &draw.name);
                self.empty_call(&stats, &draw.call(), draw.is_dark)
            }
            Drawing::Scene(draw) => {
                self.follow_scene(&draw.scene, &draw.options);
                self.empty_scene(&stats, &draw.scene, &draw.options)
            }
        };
        self.note_draw(s, &stats);
        empty_draw::note(s, empty);
        Ok(())
    }

    /// Returns the number of the scene's first object in the pick buffer; those of the others
    /// follow it.
    fn ids_of(&mut self, scene: &Scene) -> u32 {
        if self.id_names.names.len() + scene.objects.len() > MAX_ID_NAMES {
            self.forget_unused_ids();
        }
        let names = &mut self.id_names.names;
        let start = self.id_names.last_scene as usize;
        let is_same = |(name, object): (&Arc<str>, &Object)| **name == *object.name;
        let is_there = names.len() >= start + scene.objects.len()
            && names[start..].iter().zip(&scene.objects).all(is_same);
        if !is_there {
            self.id_names.last_scene = names.len() as u32;
            names.extend(scene.objects.iter().map(|o| Arc::from(o.name.as_str())));
            let bytes: u64 = scene.objects.iter().map(|o| o.name.len() as u64 + NAME_BYTES).sum();
            self.id_names.bytes += bytes;
            self.held.names.set(self.id_names.bytes);
        }
        self.id_names.last_scene
    }

    /// Reserves memory for the depth and pick buffers that a draw will allocate.
    pub(super) fn reserve_target(&mut self, hide: HiddenSurface) -> Result<(), Fault> {
        let (width, height) = (u64::from(self.memory.width()), u64::from(self.memory.height()));
        if self.ids.is_none() {
            self.with_room(|engine| engine.held.ids.try_cover(width * height * ID_BYTES))?;
        }
        if self.depth.is_none() && hide == HiddenSurface::ZBuffer {
            // Each row has one word of cells whose clear is pending.
            let bytes = width * height * self.depth_format.bytes_per_pixel() as u64 + height * 16;
            self.with_room(|engine| engine.held.depth.try_cover(bytes))?;
        }
        Ok(())
    }

    /// Sets the reservations to the sizes of the depth and pick buffers.
    pub(super) fn count_target(&mut self) {
        self.held.depth.set(self.depth.as_ref().map_or(0, |d| d.size_bytes() as u64));
        self.held.ids.set(self.ids.as_ref().map_or(0, |i| i.size_bytes() as u64));
    }

    /// Returns the renderer and its target. The pick buffer is written from the first draw on,
    /// since a PICK may follow.
    pub(super) fn target(&mut self) -> (&mut Renderer, Target<'_>) {
        let (width, height) = (self.memory.width(), self.memory.height());
        let target = Target {
            memory: &mut self.memory,
            depth: &mut self.depth,
            depth_format: self.depth_format,
            ids: Some(self.ids.get_or_insert_with(|| PickBuffer::new(width, height))),
        };
        (&mut self.renderer, target)
    }

    fn note_draw(&mut self, s: &mut Session, stats: &DrawStats) {
        s.stats.pixels += stats.pixels_written;
        self.plan = format!(
            "shade:{},hide:{},depth:{},faces:{},drawn:{},tested:{},lit:{}",
            s.shade.as_str(),
            s.hide.as_str(),
            self.depth.as_ref().map_or("none", |d| d.format().as_str()),
            stats.faces,
            stats.faces_drawn,
            stats.pixels_tested,
            stats.pixels_lit + stats.vertices_lit,
        );
    }

    pub(super) fn depth_at(&self, x: i32, y: i32, out: &mut Vec<u8>) -> Result<(), Fault> {
        self.memory.get_pixel(x, y)?;
        let z = self.depth.as_ref().and_then(|d| d.z(x, y)).unwrap_or(1.0);
        out.extend_from_slice(format!("DEPTHAT {x} {y} {}\n", nine_digits(z)).as_bytes());
        Ok(())
    }

    pub(super) fn pick(&self, x: i32, y: i32, out: &mut Vec<u8>) -> Result<(), Fault> {
        self.memory.get_pixel(x, y)?;
        let hit = self.ids.as_ref().and_then(|ids| ids.get(x, y));
        let line = match hit.and_then(|(number, t)| Some((self.id_names.names.get(number as usize)?, t))) {
            Some((name, triangle)) => format!("PICK {x} {y} {name} {triangle}\n"),
            None => format!("PICK {x} {y} none -1\n"),
        };
        out.extend_from_slice(line.as_bytes());
        Ok(())
    }

    /// Returns the number of `name` in the pick buffer.
    pub(super) fn id_of(&mut self, name: &str) -> u32 {
        if !self.id_names.numbers.contains_key(name) {
            let is_full = self.budget.available() < name.len() as u64 + NAME_BYTES;
            if is_full || self.id_names.names.len() >= MAX_ID_NAMES {
                self.forget_unused_ids();
            }
        }
        let number = self.id_names.number(name);
        self.held.names.set(self.id_names.bytes);
        number
    }

    /// Removes the names that no pixel refers to, and numbers the others anew.
    fn forget_unused_ids(&mut self) {
        let Some(ids) = &mut self.ids else { return self.id_names.clear() };
        let old = std::mem::take(&mut self.id_names);
        let (width, height) = (ids.width() as usize, ids.height() as usize);
        for index in 0..width * height {
            if let Some((number, triangle)) = ids.get((index % width) as i32, (index / width) as i32) {
                let name = &old.names[number as usize];
                ids.set(index, self.id_names.number(name), triangle);
            }
        }
    }
}

impl IdNames {
    /// Returns the number of a name; adds the name if it is new.
    fn number(&mut self, name: &str) -> u32 {
        if let Some(&number) = self.numbers.get(name) {
            return number;
        }
        let (name, number): (Arc<str>, _) = (name.into(), self.names.len() as u32);
        self.bytes += name.len() as u64 + NAME_BYTES;
        self.names.push(name.clone());
        self.numbers.insert(name, number);
        number
    }

    /// Removes all names.
    pub(super) fn clear(&mut self) {
        *self = IdNames::default();
    }
}

/// Creates the job that builds the scene of a `DRAWSCENE`. `held` is the reservation for its
/// objects.
fn scene_job(request: SceneRequest, time: f64, sorted: bool, held: Reservation) -> Job {
    Job::new(false, move |_| {
        let scene = Box::new(request.build());
        let draw = move |engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>| {
            // Reserved anew by the command.
            drop(held);
            engine.draw_scene(s, time, sorted, Some(MadeScene::Built(scene)))
        };
        JobResult::new(Command::DrawScene { time, sorted }, Ok(draw))
    })
}

/// Creates the fault for a name without a resource.
pub(super) fn missing(kind: ResourceKind, name: &str) -> Fault {
    Fault::new(Code::NoEnt, format!("there is no {} of this name", kind.as_str())).got(name)
}

/// Formats a number from 0 to 1 with nine significant digits, without an exponent.
fn nine_digits(z: f64) -> String {
    // The exponent form rounds first: 0.99999999996 becomes 1.00000000.
    let rounded = format!("{z:.8e}");
    let exponent: i32 = rounded.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0);
    let decimals = if z == 0.0 { 8 } else { (8 - exponent).max(0) as usize };
    format!("{z:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_have_nine_significant_digits() {
        for (z, text) in [
            (0.0, "0.00000000"),
            (1.0, "1.00000000"),
            (0.998_001_998_001_998, "0.998001998"),
            (0.099_999_999_99, "0.100000000"),
            (0.999_999_999_96, "1.00000000"),
            (1.234_567_891e-5, "0.0000123456789"),
        ] {
            assert_eq!(nine_digits(z), text);
        }
    }
}

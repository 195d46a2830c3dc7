//! The commands that create, load and free named resources.
//!
//! In: payloads and file names. Out: jobs that decode them, and resources under their names.

use super::draw3d::missing;
use super::empty_draw;
use super::files::FileReader;
use super::job::{Job, JobResult};
use super::{Effect, Engine, Progress, Resources};
use crate::resources::{Eye, Resource, ResourceKind, ResourceTable};
use crate::session::DefaultView;
use crate::{Limits, Session};
use fbptr_command::{Command, FileKind, MeshSource, Rect};
use fbptr_core::cancel::CancelToken;
use fbptr_core::error::{Code, Fault};
use fbptr_core::eye::{self, EyeScene, Rotation};
use fbptr_core::memory::{MemoryUse, Reservation};
use fbptr_core::pipeline::EmptyDraw;
use fbptr_core::scene::{Geometry, Mesh, Scene, Texture, Viewport, ViewportRule, shapes};
use fbptr_formats::load::x3d::X3dDocument;
use fbptr_formats::load::{self, FilePosition, LoadError, LoadMemory, LoadWarning, MeshFormat, Smoothing};
use std::ops::Range;
use std::sync::Arc;

impl Resources {
    /// Returns the table of a name: the shared one, or the connection's own.
    fn table<'a>(&'a self, s: &'a Session, name: &str) -> &'a ResourceTable {
        if ResourceTable::is_shared(name) { &self.shared } else { &s.names }
    }

    fn table_mut<'a>(&'a mut self, s: &'a mut Session, name: &str) -> &'a mut ResourceTable {
        if ResourceTable::is_shared(name) { &mut self.shared } else { &mut s.names }
    }
}

impl Engine {
    /// Returns the resource of a name: the connection's own, or a shared one if the name begins
    /// with `@`.
    fn resource(&self, s: &Session, kind: ResourceKind, name: &str) -> Option<Resource> {
        self.resources.table(s, name).get(kind, name).cloned()
    }

    pub(super) fn mesh(&self, s: &Session, name: &str) -> Result<Arc<Geometry>, Fault> {
        match self.resource(s, ResourceKind::Mesh, name) {
            Some(Resource::Mesh(geometry)) => Ok(geometry),
            _ => Err(missing(ResourceKind::Mesh, name)),
        }
    }

    pub(super) fn texture(&self, s: &Session, name: &str) -> Result<Arc<Texture>, Fault> {
        match self.resource(s, ResourceKind::Texture, name) {
            Some(Resource::Texture(texture)) => Ok(texture),
            _ => Err(missing(ResourceKind::Texture, name)),
        }
    }

    fn store(
        &mut self,
        s: &mut Session,
        name: &str,
        resource: Resource,
        held: Reservation,
    ) -> Result<(), Fault> {
        let limits = self.limits_for(s, name);
        self.resources.table_mut(s, name).insert(name, resource, held, &limits)
    }

    /// Returns the limits of the table that `name` belongs to: what a connection's canvases take is
    /// not left for its names.
    fn limits_for(&self, s: &Session, name: &str) -> Limits {
        let limits = self.quotas.limits;
        let canvases = if ResourceTable::is_shared(name) { 0 } else { s.surfaces.bytes() };
        Limits { resource_bytes: limits.resource_bytes.saturating_sub(canvases), ..limits }
    }

    /// Reserves the memory of a job that makes a resource called `name` from `input` bytes: these
    /// bytes, within the budget, and a result within the quota. A payload that came in pieces is
    /// already reserved.
    pub(super) fn job_memory(
        &mut self,
        s: &mut Session,
        kind: ResourceKind,
        name: &str,
        input: usize,
    ) -> Result<JobMemory, Fault> {
        if self.quotas.budget.is_tight() {
            self.free_caches();
        }
        let room = self.resources.table(s, name).room(kind, name, &self.limits_for(s, name));
        let result = LoadMemory::new(&self.quotas.budget, room);
        let taken_over = s.payload_held.take();
        let mut held = taken_over.unwrap_or_else(|| self.quotas.budget.empty(MemoryUse::Payloads));
        held.try_cover(input as u64)?;
        Ok(JobMemory { result, _input: held })
    }

    /// Runs `MESH`: a job creates the mesh.
    pub(super) fn mesh_job(
        &mut self,
        s: &mut Session,
        name: String,
        source: Box<MeshSource>,
    ) -> Result<Progress, Fault> {
        let input = if let MeshSource::Obj(bytes) = &*source { bytes.len() } else { 0 };
        let memory = self.job_memory(s, ResourceKind::Mesh, &name, input)?;
        let mut files = None;
        let is_small = match &*source {
            MeshSource::Obj(bytes) => {
                let reader = files.insert(self.file_reader(s));
                bytes.len() <= SMALL_TEXT_BYTES && !reader.may_wait()
            }
            MeshSource::Teapot(level) => *level <= SMALL_TEAPOT,
            MeshSource::Knot(nu, nv) => u64::from(*nu) * u64::from(*nv) <= SMALL_KNOT_FACES,
            _ => true,
        };
        Ok(Progress::Job(Job::new(is_small, move |cancel| {
            let memory = memory.until(cancel);
            let made = match (&*source, &mut files) {
                (MeshSource::Obj(bytes), Some(files)) => {
                    Made::mesh_of_file(MeshFormat::Obj, bytes, &name, "", files, memory)
                }
                (shape, _) => Made::mesh_of_shape(shape, &name, memory),
            };
            let command = Command::Mesh { name: name.clone(), source };
            JobResult::new(command, made.map(|m| m.named(name))).with_files(files)
        })))
    }

    /// Runs `TEX`: a job decodes the picture.
    pub(super) fn texture_job(
        &mut self,
        s: &mut Session,
        name: String,
        file: Vec<u8>,
    ) -> Result<Progress, Fault> {
        let memory = self.job_memory(s, ResourceKind::Texture, &name, file.len())?;
        Ok(Progress::Job(Job::new(file.len() <= SMALL_PICTURE_BYTES, move |cancel| {
            let memory = memory.until(cancel);
            let made = Made::texture(&file, &name, memory);
            JobResult::new(Command::Texture { name: name.clone(), file }, made.map(|m| m.named(name)))
        })))
    }

    /// Runs `SCENE`: a job parses the file, and the files that it refers to.
    pub(super) fn scene_job(&mut self, s: &mut Session, x3d: Vec<u8>) -> Result<Progress, Fault> {
        let memory = self.job_memory(s, ResourceKind::Scene, SCENE_NAME, x3d.len())?;
        let mut files = self.file_reader(s);
        let is_small = x3d.len() <= SMALL_SCENE_BYTES && !files.may_wait();
        Ok(Progress::Job(Job::new(is_small, move |cancel| {
            let memory = memory.until(cancel);
            let made = NewScene::parse(&x3d, "SCENE", "", &mut files, memory);
            JobResult::new(Command::Scene { x3d }, made.map(NewScene::begin)).with_files(Some(files))
        })))
    }

    /// Runs `EYE`: a job parses the scene; its picture is rendered when it is first drawn.
    pub(super) fn eye_job(
        &mut self,
        s: &mut Session,
        name: String,
        json: Vec<u8>,
    ) -> Result<Progress, Fault> {
        let most = self.quotas.limits.resource_bytes;
        let memory = self.job_memory(s, ResourceKind::Eye, &name, json.len())?;
        let turns = self.rendering.eye_turns.clone();
        Ok(Progress::Job(Job::new(json.len() <= SMALL_TEXT_BYTES, move |cancel| {
            let memory = memory.until(cancel);
            let made = Made::eye(&json, &turns, &name, most, memory);
            JobResult::new(Command::Eye { name: name.clone(), json }, made.map(|m| m.named(name)))
        })))
    }

    /// Runs `LOAD`: a job reads the file and decodes it.
    pub(super) fn load_job(
        &mut self,
        s: &mut Session,
        kind: FileKind,
        name: String,
        path: String,
    ) -> Result<Progress, Fault> {
        let mut files = self.file_reader(s);
        files.check_source(&path)?;
        let (made_kind, named) = match kind {
            FileKind::Mesh => (ResourceKind::Mesh, &*name),
            FileKind::Texture => (ResourceKind::Texture, &*name),
            FileKind::Scene => (ResourceKind::Scene, SCENE_NAME),
        };
        // The file's bytes are reserved when they are read.
        let memory = self.job_memory(s, made_kind, named, 0)?;
        Ok(Progress::Job(Job::new(false, move |cancel| {
            let memory = memory.until(cancel);
            let bytes = match files.read(&path) {
                Ok(bytes) => bytes,
                Err(fault) => return JobResult::refused(fault),
            };
            let beside = path.rsplit_once('/').map_or("", |(folder, _)| folder);
            let command = Command::Load { kind, name: name.clone(), path: path.clone() };
            let result = match kind {
                FileKind::Mesh => {
                    let format = MeshFormat::of(&bytes);
                    let made = Made::mesh_of_file(format, &bytes, &path, beside, &mut files, memory);
                    JobResult::new(command, made.map(|m| m.named(name)))
                }
                FileKind::Texture => {
                    JobResult::new(command, Made::texture(&bytes, &path, memory).map(|m| m.named(name)))
                }
                FileKind::Scene => {
                    let made = NewScene::parse(&bytes, &path, beside, &mut files, memory);
                    JobResult::new(command, made.map(NewScene::begin))
                }
            };
            result.with_files(Some(files))
        })))
    }

    /// Makes a parsed scene the connection's scene; its camera and lights replace those of the
    /// session.
    fn begin_scene(&mut self, s: &mut Session, new: NewScene) -> Result<(), Fault> {
        self.note_warnings(s, new.document.warnings());
        self.note_warnings(s, &new.other_cases);
        let resource = Resource::Scene(Arc::new(new.document), new.size);
        let limits = self.limits_for(s, SCENE_NAME);
        s.names.insert(SCENE_NAME, resource, new.memory.result.into_kept(), &limits)?;
        s.camera = new.at_start.camera.unwrap_or_default();
        s.ambient = new.at_start.ambient;
        s.lights = new.at_start.lights.into_iter().map(Some).collect();
        s.own_lights.clear();
        s.default_view = DefaultView::Own;
        s.has_own_camera = false;
        Ok(())
    }

    pub(super) fn scene(&self, s: &Session) -> Result<Arc<X3dDocument>, Fault> {
        match s.names.get(ResourceKind::Scene, SCENE_NAME) {
            Some(Resource::Scene(document, _)) => Ok(document.clone()),
            _ => Err(Fault::new(Code::NoEnt, "there is no scene: SCENE or LOAD SCENE makes one")),
        }
    }

    /// Keeps a file's warnings for the connection's owner.
    fn note_warnings(&self, s: &mut Session, warnings: &[LoadWarning]) {
        let room = MAX_WARNINGS.saturating_sub(s.warnings.len());
        s.warnings.extend(warnings.iter().take(room).map(ToString::to_string));
    }

    /// Runs `DRAWEYE`: a job renders the picture when it is first needed.
    pub(super) fn draw_eye(&mut self, s: &mut Session, name: String, rect: Rect) -> Result<Progress, Fault> {
        let Some(Resource::Eye(eye)) = self.resource(s, ResourceKind::Eye, &name) else {
            return Err(missing(ResourceKind::Eye, &name));
        };
        if eye.has_picture() {
            if self.may_suspend && self.framebuffer.visible(rect) > LARGE_EYE_PIXELS {
                return Ok(Progress::Pieces(Box::new(self.begin_eye_in_pieces(name, rect))));
            }
            self.put_eye_rows(&eye, rect, 0..self.framebuffer.height());
            self.note_eye(s, rect);
            return Ok(Progress::Done(Effect::Done));
        }
        // Its pixels twice: while they are rendered, and in the resource, which counts them itself.
        let held = self
            .quotas
            .budget
            .try_reserve(MemoryUse::Draws, eye.working_bytes() + eye.size_bytes() as u64)?;
        Ok(Progress::Job(Job::new(eye.working_bytes() <= SMALL_EYE_BYTES, move |_| {
            eye.picture();
            drop(held);
            let command = Command::DrawEye { name: name.clone(), rect };
            // The name may stand for another scene when the job is done.
            JobResult::new(
                command,
                Ok(move |engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>| {
                    engine.draw_eye(s, name, rect)
                }),
            )
        })))
    }

    /// Draws the rows of an eye's picture that lie in `band`.
    pub(super) fn put_eye_band(
        &mut self,
        s: &Session,
        name: &str,
        rect: Rect,
        band: Range<u32>,
    ) -> Result<(), Fault> {
        match self.resource(s, ResourceKind::Eye, name) {
            Some(Resource::Eye(eye)) => self.put_eye_rows(&eye, rect, band),
            _ => return Err(missing(ResourceKind::Eye, name)),
        }
        Ok(())
    }

    fn put_eye_rows(&mut self, eye: &Eye, rect: Rect, band: Range<u32>) {
        let ([columns, rows], pixels) = eye.picture();
        let width = i64::from(self.framebuffer.width());
        let [columns_drawn, rows_drawn] = self.framebuffer.memory.clip();
        let (x, y, w, h) = (i64::from(rect.x), i64::from(rect.y), i64::from(rect.w), i64::from(rect.h));
        let top = i64::from(band.start.max(rows_drawn.start));
        let bottom = i64::from(band.end.min(rows_drawn.end)).max(top);
        let ys = y.clamp(top, bottom)..(y + h).clamp(top, bottom);
        let [left, right] = [columns_drawn.start, columns_drawn.end].map(i64::from);
        let xs = x.clamp(left, right)..(x + w).clamp(left, right);
        let frame = self.framebuffer.memory.bytes_mut().as_chunks_mut::<4>().0;
        for j in ys.clone() {
            // The source pixel that contains the centre of this pixel.
            let row = ((2 * (j - y) + 1) * rows as i64 / (2 * h)) as usize * columns;
            for i in xs.clone() {
                let column = ((2 * (i - x) + 1) * columns as i64 / (2 * w)) as usize;
                frame[(width * j + i) as usize] = pixels[row + column];
            }
        }
        if !xs.is_empty() && !ys.is_empty() {
            self.framebuffer.memory.mark_rows(ys.start as u32..ys.end as u32);
        }
    }

    /// Counts the pixels of `DRAWEYE`.
    pub(super) fn note_eye(&mut self, s: &mut Session, rect: Rect) {
        let Rect { x, y, w, h } = rect;
        let [width, height] = [w, h].map(|side| side.max(0) as u32);
        let area = Viewport { x, y, width, height, rule: ViewportRule::default() };
        match self.framebuffer.visible(rect) {
            0 => empty_draw::note(s, EmptyDraw::of_area(area, &self.framebuffer.memory)),
            pixels => s.stats.pixels += pixels,
        }
    }

    pub(super) fn free(&mut self, s: &mut Session, name: String) -> Result<(), Fault> {
        let is_canvas = s.surfaces.free(&name);
        if !self.resources.table_mut(s, &name).free(&name) && !is_canvas {
            return Err(Fault::new(Code::NoEnt, "nothing has this name").got(name));
        }
        if s.texture.as_ref().is_some_and(|(bound, _)| *bound == name) {
            s.texture = None;
        }
        Ok(())
    }
}

/// Wraps a mesh without textures.
fn plain(mesh: Mesh) -> Arc<Geometry> {
    Arc::new(Geometry { mesh, textures: Vec::new() })
}

/// Name of a connection's scene, which no command can contain.
const SCENE_NAME: &str = "";

/// Warnings that are kept until they are reported, at most.
const MAX_WARNINGS: usize = 100;

/// Largest payload in bytes that is decoded at once, without a worker thread.
const SMALL_TEXT_BYTES: usize = 8 << 10;
/// [`SMALL_TEXT_BYTES`] for scenes, in which a few words can create large shapes.
const SMALL_SCENE_BYTES: usize = 1 << 10;
/// [`SMALL_TEXT_BYTES`] for pictures, which decode to at most about a thousand times their size.
pub(super) const SMALL_PICTURE_BYTES: usize = 1 << 10;
/// Largest shapes, in steps and faces, that are created at once, without a worker thread.
const SMALL_TEAPOT: u32 = 10;
const SMALL_KNOT_FACES: u64 = 1 << 11;
/// Most working memory, in bytes, of a picture of the eye that is rendered at once.
const SMALL_EYE_BYTES: u64 = 8 << 10;
/// Most pixels of a picture of the eye that are drawn at once: some milliseconds.
const LARGE_EYE_PIXELS: u64 = 1 << 18;

/// Memory that a job has reserved.
#[derive(Debug)]
pub(super) struct JobMemory {
    /// For its working memory and its result.
    pub result: LoadMemory,
    /// For its input.
    _input: Reservation,
}

impl JobMemory {
    /// Returns this memory with `cancel` as the token that ends the job.
    pub fn until(self, cancel: &CancelToken) -> Self {
        JobMemory { result: self.result.until(cancel.clone()), ..self }
    }
}

/// A resource that a job has created; the render thread stores it under its name.
struct Made {
    resource: Resource,
    warnings: Vec<LoadWarning>,
    memory: JobMemory,
}

/// Working memory, in bytes, of a shape with a fixed number of faces.
const FIXED_SHAPE_BYTES: u64 = 1 << 20;

/// Returns the working memory, in bytes, for creating a shape.
fn shape_bytes(source: &MeshSource) -> u64 {
    match *source {
        MeshSource::Teapot(level) => shapes::teapot_bytes(level),
        MeshSource::Knot(nu, nv) => shapes::knot_bytes(nu, nv),
        _ => FIXED_SHAPE_BYTES,
    }
}

impl Made {
    fn mesh_of_shape(source: &MeshSource, name: &str, mut memory: JobMemory) -> Result<Self, Fault> {
        let refused = |kind| Fault::from(LoadError::new(FilePosition::file(name), kind));
        let work = memory.result.work(shape_bytes(source)).map_err(refused)?;
        let mut mesh = match *source {
            MeshSource::Obj(_) => Mesh::default(),
            MeshSource::Box(size) => shapes::cuboid(size)?,
            MeshSource::Sphere(radius) => shapes::sphere(radius)?,
            MeshSource::Cone(radius, height) => shapes::cone(radius, height)?,
            MeshSource::Cylinder(radius, height) => shapes::cylinder(radius, height)?,
            MeshSource::Teapot(level) => shapes::teapot(level)?,
            MeshSource::Knot(nu, nv) => shapes::knot(nu, nv)?,
        };
        mesh.shrink_to_fit();
        // From here on the reservation is the mesh's own size.
        drop(work);
        memory.result.reserve_result(mesh.size_bytes() as u64).map_err(refused)?;
        Ok(Made { resource: Resource::Mesh(plain(mesh)), warnings: Vec::new(), memory })
    }

    fn mesh_of_file(
        format: MeshFormat,
        bytes: &[u8],
        file: &str,
        beside: &str,
        files: &mut FileReader,
        mut memory: JobMemory,
    ) -> Result<Self, Fault> {
        let side_files = &mut |name: &str| files.read_beside(beside, name);
        let smoothing = Smoothing::default();
        let mut loaded = format.parse(bytes, side_files, file, &mut memory.result, smoothing)?;
        loaded.warnings.extend(files.take_warnings());
        let resource = Resource::Mesh(Arc::new(loaded.geometry));
        Ok(Made { resource, warnings: loaded.warnings, memory })
    }

    fn texture(bytes: &[u8], file: &str, mut memory: JobMemory) -> Result<Self, Fault> {
        let texture = load::texture::decode_within(bytes, file, &mut memory.result)?;
        Ok(Made { resource: Resource::Texture(Arc::new(texture)), warnings: Vec::new(), memory })
    }

    fn eye(
        json: &[u8],
        turns: &[Rotation],
        name: &str,
        most: u64,
        mut memory: JobMemory,
    ) -> Result<Self, Fault> {
        let refused = |kind| Fault::from(LoadError::new(FilePosition::file(name), kind));
        let work = memory.result.work(eye::json_bytes(json)).map_err(refused)?;
        let scene = EyeScene::from_json(json)?;
        let eye = Eye::new(if turns.is_empty() { scene } else { scene.turned(turns)? });
        drop(work);
        let working = eye.working_bytes();
        if working > most {
            let message =
                format!("a picture of the eye may take {most} bytes to make, and this one takes {working}");
            return Err(Fault::new(Code::TooBig, message).got(name));
        }
        memory.result.reserve_result(eye.size_bytes() as u64).map_err(refused)?;
        Ok(Made { resource: Resource::Eye(Arc::new(eye)), warnings: Vec::new(), memory })
    }

    /// Returns the job's effect: stores the resource as `name`.
    fn named(
        self,
        name: String,
    ) -> impl FnOnce(&mut Engine, &mut Session, &mut Vec<u8>) -> Result<Progress, Fault> + Send + 'static
    {
        move |engine, s, _| {
            engine.note_warnings(s, &self.warnings);
            engine.store(s, &name, self.resource, self.memory.result.into_kept())?;
            Ok(Progress::Done(Effect::Done))
        }
    }
}

/// A scene that a job has parsed.
struct NewScene {
    document: X3dDocument,
    at_start: Scene,
    /// Warnings about names in another case of letters.
    other_cases: Vec<LoadWarning>,
    /// Its size in bytes.
    size: u64,
    memory: JobMemory,
    /// The memory reserved for its objects.
    _at_start: Reservation,
}

impl NewScene {
    fn parse(
        x3d: &[u8],
        file: &str,
        beside: &str,
        files: &mut FileReader,
        mut memory: JobMemory,
    ) -> Result<Self, Fault> {
        let opener = &mut |name: &str| files.read_beside(beside, name);
        let document = load::x3d::parse_within(x3d, file, opener, &mut memory.result)?;
        let given_up = |kind| Fault::from(LoadError::new(FilePosition::file(file), kind));
        memory.result.check_cancelled().map_err(given_up)?;
        let held = memory.result.budget().try_reserve(MemoryUse::Draws, document.scene_bytes())?;
        let at_start = document.at(0.0);
        let size = memory.result.kept_bytes();
        let other_cases = files.take_warnings();
        Ok(NewScene { document, at_start, other_cases, size, memory, _at_start: held })
    }

    /// Returns the job's effect: makes it the connection's scene.
    fn begin(
        self,
    ) -> impl FnOnce(&mut Engine, &mut Session, &mut Vec<u8>) -> Result<Progress, Fault> + Send + 'static
    {
        move |engine, s, _| engine.begin_scene(s, self).map(|()| Progress::Done(Effect::Done))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Audience;

    #[test]
    fn a_file_is_not_read_to_its_end_when_its_command_was_given_up() {
        let mut engine = Engine::new(8, 6).unwrap();
        let mut s = Session::new(1, Audience::Connection);
        let scene = b"<X3D><Scene><Shape><Box/></Shape></Scene></X3D>".to_vec();
        let texture = b"P6 1 1 255\n\x01\x02\x03".to_vec();
        for is_cancelled in [true, false] {
            let token = CancelToken::new();
            if is_cancelled {
                token.cancel();
            }
            let jobs = [
                engine.scene_job(&mut s, scene.clone()).unwrap(),
                engine.texture_job(&mut s, "t".into(), texture.clone()).unwrap(),
                engine.mesh_job(&mut s, "m".into(), Box::new(MeshSource::Obj(b"v 0 0 0".into()))).unwrap(),
            ];
            for progress in jobs {
                let Progress::Job(job) = progress else { panic!("{progress:?}") };
                let code = job.run(&token).made.err().map(|fault| fault.code);
                assert_eq!(code, is_cancelled.then_some(Code::Quota), "cancelled: {is_cancelled}");
            }
        }
        assert_eq!(engine.memory_budget().used_for(MemoryUse::Decoders), 0, "all is given back");
    }
}

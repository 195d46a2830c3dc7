//! The verbs that make, load and free named resources.

use super::files::FileReader;
use super::space::missing;
use super::{Effect, Engine, Progress};
use crate::command::{Command, FileKind, MeshSource, Rect};
use crate::error::{Code, Fault};
use crate::eye::{EyeError, EyeScene};
use crate::load::x3d::X3dDocument;
use crate::load::{self, LoadError, LoadWarning};
use crate::scene::{Geometry, Mesh, Scene, Texture, shapes};
use crate::server::Session;
use crate::server::jobs::{Job, JobResult};
use crate::server::names::{Eye, Kind, Names, Resource};
use std::sync::Arc;

impl From<shapes::ShapeError> for Fault {
    fn from(e: shapes::ShapeError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

impl From<LoadError> for Fault {
    fn from(e: LoadError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

impl From<EyeError> for Fault {
    fn from(e: EyeError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

impl Engine {
    /// What a name stands for: the connection's own, or everybody's where it begins with `@`.
    fn resource(&self, s: &Session, kind: Kind, name: &str) -> Option<Resource> {
        let names = if Names::is_shared(name) { &self.shared } else { &s.names };
        names.get(kind, name).cloned()
    }

    pub(super) fn mesh(&self, s: &Session, name: &str) -> Result<Arc<Geometry>, Fault> {
        match self.resource(s, Kind::Mesh, name) {
            Some(Resource::Mesh(geometry)) => Ok(geometry),
            _ => Err(missing(Kind::Mesh, name)),
        }
    }

    pub(super) fn texture(&self, s: &Session, name: &str) -> Result<Arc<Texture>, Fault> {
        match self.resource(s, Kind::Texture, name) {
            Some(Resource::Texture(texture)) => Ok(texture),
            _ => Err(missing(Kind::Texture, name)),
        }
    }

    fn keep(&mut self, s: &mut Session, name: &str, resource: Resource) -> Result<(), Fault> {
        let names = if Names::is_shared(name) { &mut self.shared } else { &mut s.names };
        names.insert(name, resource, &self.limits)
    }

    /// `MESH`: the mesh is made by a job.
    pub(super) fn mesh_job(&mut self, s: &mut Session, name: String, source: Box<MeshSource>) -> Progress {
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
        Progress::Job(Job::new(is_small, move |_| {
            let made = match (&*source, &mut files) {
                (MeshSource::Obj(bytes), Some(files)) => Made::mesh_of_obj(bytes, &name, "", files),
                (shape, _) => Made::mesh_of_shape(shape),
            };
            let command = Command::Mesh { name: name.clone(), source };
            JobResult::new(command, made.map(|m| m.named(name))).with_files(files)
        }))
    }

    /// `TEX`: the picture is decoded by a job.
    pub(super) fn texture_job(&self, name: String, file: Vec<u8>) -> Progress {
        Progress::Job(Job::new(file.len() <= SMALL_PICTURE_BYTES, move |_| {
            let made = Made::texture(&file, &name);
            JobResult::new(Command::Texture { name: name.clone(), file }, made.map(|m| m.named(name)))
        }))
    }

    /// `SCENE`: the file, and what it refers to, is parsed by a job.
    pub(super) fn scene_job(&mut self, s: &mut Session, x3d: Vec<u8>) -> Progress {
        let mut files = self.file_reader(s);
        let is_small = x3d.len() <= SMALL_SCENE_BYTES && !files.may_wait();
        Progress::Job(Job::new(is_small, move |_| {
            let made = NewScene::parse(&x3d, "SCENE", "", &mut files);
            JobResult::new(Command::Scene { x3d }, made.map(NewScene::begin)).with_files(Some(files))
        }))
    }

    /// `EYE`: the scene is parsed by a job; its picture is made when it is first asked for.
    pub(super) fn eye_job(&self, name: String, json: Vec<u8>) -> Progress {
        let most = self.limits.resource_bytes;
        Progress::Job(Job::new(json.len() <= SMALL_TEXT_BYTES, move |_| {
            let made = Made::eye(&json, &name, most);
            JobResult::new(Command::Eye { name: name.clone(), json }, made.map(|m| m.named(name)))
        }))
    }

    /// `LOAD`: the file is read and made into what it holds by a job.
    pub(super) fn load_job(
        &mut self,
        s: &mut Session,
        kind: FileKind,
        name: String,
        path: String,
    ) -> Result<Progress, Fault> {
        let mut files = self.file_reader(s);
        files.check_source(&path)?;
        Ok(Progress::Job(Job::new(false, move |_| {
            let bytes = match files.read(&path) {
                Ok(bytes) => bytes,
                Err(fault) => return JobResult::refused(fault),
            };
            let beside = path.rsplit_once('/').map_or("", |(folder, _)| folder);
            let command = Command::Load { kind, name: name.clone(), path: path.clone() };
            let result = match kind {
                FileKind::Mesh => {
                    let made = Made::mesh_of_obj(&bytes, &path, beside, &mut files);
                    JobResult::new(command, made.map(|m| m.named(name)))
                }
                FileKind::Texture => {
                    JobResult::new(command, Made::texture(&bytes, &path).map(|m| m.named(name)))
                }
                FileKind::Scene => {
                    let made = NewScene::parse(&bytes, &path, beside, &mut files);
                    JobResult::new(command, made.map(NewScene::begin))
                }
            };
            result.with_files(Some(files))
        })))
    }

    /// A scene takes the place of camera, lights and objects.
    fn begin_scene(&mut self, s: &mut Session, new: NewScene) -> Result<(), Fault> {
        self.note_warnings(s, new.document.warnings());
        let resource = Resource::Scene(Arc::new(new.document), new.size);
        s.names.insert(SCENE_NAME, resource, &self.limits)?;
        s.camera = new.at_start.camera.unwrap_or_default();
        s.ambient = new.at_start.ambient;
        s.lights = new.at_start.lights.into_iter().map(Some).collect();
        s.own_lights.clear();
        s.has_own_camera = false;
        Ok(())
    }

    pub(super) fn scene(&self, s: &Session) -> Result<Arc<X3dDocument>, Fault> {
        match s.names.get(Kind::Scene, SCENE_NAME) {
            Some(Resource::Scene(document, _)) => Ok(document.clone()),
            _ => Err(Fault::new(Code::NoEnt, "there is no scene: SCENE or LOAD SCENE makes one")),
        }
    }

    /// Keeps what a file's author should know, for the connection's owner.
    fn note_warnings(&self, s: &mut Session, warnings: &[LoadWarning]) {
        let room = MAX_WARNINGS.saturating_sub(s.warnings.len());
        s.warnings.extend(warnings.iter().take(room).map(ToString::to_string));
    }

    /// `DRAWEYE`: the picture is made by a job when it is first asked for.
    pub(super) fn draw_eye(&mut self, s: &mut Session, name: String, rect: Rect) -> Result<Progress, Fault> {
        let Some(Resource::Eye(eye)) = self.resource(s, Kind::Eye, &name) else {
            return Err(missing(Kind::Eye, &name));
        };
        if eye.has_picture() {
            self.put_eye(s, &eye, rect);
            return Ok(Progress::Done(Effect::Done));
        }
        Ok(Progress::Job(Job::new(eye.working_bytes() <= SMALL_EYE_BYTES, move |_| {
            eye.picture();
            let command = Command::DrawEye { name: name.clone(), rect };
            // The name may stand for another scene by now.
            JobResult::new(
                command,
                Ok(move |engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>| {
                    engine.draw_eye(s, name, rect)
                }),
            )
        })))
    }

    fn put_eye(&mut self, s: &mut Session, eye: &Eye, rect: Rect) {
        let ([columns, rows], pixels) = eye.picture();
        let (width, height) = (i64::from(self.memory.width()), i64::from(self.memory.height()));
        let (x, y, w, h) = (i64::from(rect.x), i64::from(rect.y), i64::from(rect.w), i64::from(rect.h));
        let ys = y.clamp(0, height)..(y + h).clamp(0, height);
        let xs = x.clamp(0, width)..(x + w).clamp(0, width);
        let frame = self.memory.bytes_mut().as_chunks_mut::<4>().0;
        for j in ys.clone() {
            // The source pixel that holds the centre of this one.
            let row = ((2 * (j - y) + 1) * rows as i64 / (2 * h)) as usize * columns;
            for i in xs.clone() {
                let column = ((2 * (i - x) + 1) * columns as i64 / (2 * w)) as usize;
                frame[(width * j + i) as usize] = pixels[row + column];
            }
        }
        if !xs.is_empty() && !ys.is_empty() {
            self.memory.mark_rows(ys.start as u32..ys.end as u32);
            s.stats.pixels += ((xs.end - xs.start) * (ys.end - ys.start)) as u64;
        }
    }

    pub(super) fn free(&mut self, s: &mut Session, name: &str) -> Result<(), Fault> {
        let names = if Names::is_shared(name) { &mut self.shared } else { &mut s.names };
        if !names.free(name) {
            return Err(Fault::new(Code::NoEnt, "nothing has this name").got(name));
        }
        if s.texture.as_ref().is_some_and(|(bound, _)| bound == name) {
            s.texture = None;
        }
        Ok(())
    }
}

/// A mesh without textures of its own.
fn plain(mesh: Mesh) -> Arc<Geometry> {
    Arc::new(Geometry { mesh, textures: Vec::new() })
}

/// The name of a connection's scene, which no stream can say.
const SCENE_NAME: &str = "";

/// Warnings that are kept until somebody hears them.
const MAX_WARNINGS: usize = 100;

/// Payloads of so many bytes at most are made into what they hold within some 100 us.
const SMALL_TEXT_BYTES: usize = 8 << 10;
/// A scene may say much in few words.
const SMALL_SCENE_BYTES: usize = 1 << 10;
/// So may a packed picture: at most about a thousand times its bytes.
const SMALL_PICTURE_BYTES: usize = 1 << 10;
/// Shapes that are made within some 100 us.
const SMALL_TEAPOT: u32 = 10;
const SMALL_KNOT_FACES: u64 = 1 << 11;
/// A picture of the eye that is made within some 100 us takes so many bytes to make.
const SMALL_EYE_BYTES: u64 = 8 << 10;

/// What a job has made, to be given its name on the render thread.
struct Made {
    resource: Resource,
    warnings: Vec<LoadWarning>,
}

impl Made {
    fn mesh_of_shape(source: &MeshSource) -> Result<Self, Fault> {
        let mesh = match *source {
            MeshSource::Obj(_) => Mesh::default(),
            MeshSource::Box(size) => shapes::box_(size)?,
            MeshSource::Sphere(radius) => shapes::sphere(radius)?,
            MeshSource::Cone(radius, height) => shapes::cone(radius, height)?,
            MeshSource::Cylinder(radius, height) => shapes::cylinder(radius, height)?,
            MeshSource::Teapot(level) => shapes::teapot(level)?,
            MeshSource::Knot(nu, nv) => shapes::knot(nu, nv)?,
        };
        Ok(Made { resource: Resource::Mesh(plain(mesh)), warnings: Vec::new() })
    }

    fn mesh_of_obj(bytes: &[u8], file: &str, beside: &str, files: &mut FileReader) -> Result<Self, Fault> {
        let loaded = load::obj::parse(bytes, &mut |name| files.read_beside(beside, name), file)?;
        Ok(Made { resource: Resource::Mesh(Arc::new(loaded.geometry)), warnings: loaded.warnings })
    }

    fn texture(bytes: &[u8], file: &str) -> Result<Self, Fault> {
        let texture = load::texture::decode_file(bytes, file)?;
        Ok(Made { resource: Resource::Texture(Arc::new(texture)), warnings: Vec::new() })
    }

    fn eye(json: &[u8], name: &str, most: u64) -> Result<Self, Fault> {
        let eye = Eye::new(EyeScene::from_json(json)?);
        let working = eye.working_bytes();
        if working > most {
            let message =
                format!("a picture of the eye may take {most} bytes to make, and this one takes {working}");
            return Err(Fault::new(Code::TooBig, message).got(name));
        }
        Ok(Made { resource: Resource::Eye(Arc::new(eye)), warnings: Vec::new() })
    }

    /// The effect: `name` stands for it.
    fn named(
        self,
        name: String,
    ) -> impl FnOnce(&mut Engine, &mut Session, &mut Vec<u8>) -> Result<Progress, Fault> + Send + 'static
    {
        move |engine, s, _| {
            engine.note_warnings(s, &self.warnings);
            engine.keep(s, &name, self.resource)?;
            Ok(Progress::Done(Effect::Done))
        }
    }
}

/// A scene that a job has parsed.
struct NewScene {
    document: X3dDocument,
    at_start: Scene,
    /// Bytes that it takes, about.
    size: u64,
}

impl NewScene {
    fn parse(x3d: &[u8], file: &str, beside: &str, files: &mut FileReader) -> Result<Self, Fault> {
        let document = load::x3d::parse(x3d, file, &mut |name| files.read_beside(beside, name))?;
        let at_start = document.at(0.0);
        let meshes: usize = at_start.objects.iter().map(|o| o.geometry.mesh.size_bytes()).sum();
        let size = x3d.len() as u64 + files.side_bytes() + meshes as u64;
        Ok(NewScene { document, at_start, size })
    }

    /// The effect: it is the connection's scene.
    fn begin(
        self,
    ) -> impl FnOnce(&mut Engine, &mut Session, &mut Vec<u8>) -> Result<Progress, Fault> + Send + 'static
    {
        move |engine, s, _| engine.begin_scene(s, self).map(|()| Progress::Done(Effect::Done))
    }
}

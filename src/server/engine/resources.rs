//! The verbs that make, load and free named resources.

use super::Engine;
use super::space::missing;
use crate::command::{FileKind, MeshSource, Rect};
use crate::error::{Code, Fault};
use crate::eye::{EyeError, EyeScene};
use crate::load::x3d::X3dDocument;
use crate::load::{self, LoadError, LoadWarning};
use crate::scene::{Geometry, Mesh, Texture, shapes};
use crate::server::Session;
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

    pub(super) fn make_mesh(&mut self, s: &mut Session, name: &str, source: MeshSource) -> Result<(), Fault> {
        let mesh = match source {
            MeshSource::Obj(bytes) => {
                let mut files = self.file_reader(s);
                let loaded = load::obj::parse(&bytes, &mut |name| files.read_beside("", name), name)?;
                self.files_read = files.into_read();
                self.note_warnings(s, &loaded.warnings);
                return self.keep(s, name, Resource::Mesh(Arc::new(loaded.geometry)));
            }
            MeshSource::Box(size) => shapes::box_(size)?,
            MeshSource::Sphere(radius) => shapes::sphere(radius)?,
            MeshSource::Cone(radius, height) => shapes::cone(radius, height)?,
            MeshSource::Cylinder(radius, height) => shapes::cylinder(radius, height)?,
            MeshSource::Teapot(level) => shapes::teapot(level)?,
            MeshSource::Knot(nu, nv) => shapes::knot(nu, nv)?,
        };
        self.keep(s, name, Resource::Mesh(plain(mesh)))
    }

    pub(super) fn make_texture(&mut self, s: &mut Session, name: &str, file: &[u8]) -> Result<(), Fault> {
        let texture = load::texture::decode_file(file, name)?;
        self.keep(s, name, Resource::Texture(Arc::new(texture)))
    }

    pub(super) fn make_scene(&mut self, s: &mut Session, x3d: &[u8]) -> Result<(), Fault> {
        let mut files = self.file_reader(s);
        let document = load::x3d::parse(x3d, "SCENE", &mut |name| files.read_beside("", name))?;
        let size = x3d.len() as u64 + files.side_bytes();
        self.files_read = files.into_read();
        self.begin_scene(s, document, size)
    }

    pub(super) fn make_eye(&mut self, s: &mut Session, name: &str, json: &[u8]) -> Result<(), Fault> {
        let scene = EyeScene::from_json(json)?;
        let eye = Eye::new(scene);
        let working = eye.working_bytes();
        if working > self.limits.resource_bytes {
            let message = format!(
                "a picture of the eye may take {} bytes to make, and this one takes {working}",
                self.limits.resource_bytes
            );
            return Err(Fault::new(Code::TooBig, message).got(name));
        }
        self.keep(s, name, Resource::Eye(Arc::new(eye)))
    }

    pub(super) fn load(
        &mut self,
        s: &mut Session,
        kind: FileKind,
        name: &str,
        path: &str,
    ) -> Result<(), Fault> {
        let mut files = self.file_reader(s);
        let bytes = files.read(path)?;
        let beside = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        match kind {
            FileKind::Mesh => {
                let loaded = load::obj::parse(&bytes, &mut |name| files.read_beside(beside, name), path)?;
                self.files_read = files.into_read();
                self.note_warnings(s, &loaded.warnings);
                self.keep(s, name, Resource::Mesh(Arc::new(loaded.geometry)))
            }
            FileKind::Texture => {
                let texture = load::texture::decode_file(&bytes, path)?;
                self.files_read = files.into_read();
                self.keep(s, name, Resource::Texture(Arc::new(texture)))
            }
            FileKind::Scene => {
                let document = load::x3d::parse(&bytes, path, &mut |name| files.read_beside(beside, name))?;
                let size = bytes.len() as u64 + files.side_bytes();
                self.files_read = files.into_read();
                self.begin_scene(s, document, size)
            }
        }
    }

    /// A scene takes the place of camera, lights and objects.
    fn begin_scene(&mut self, s: &mut Session, document: X3dDocument, file_bytes: u64) -> Result<(), Fault> {
        let scene = document.at(0.0);
        let meshes: usize = scene.objects.iter().map(|o| o.geometry.mesh.size_bytes()).sum();
        self.note_warnings(s, document.warnings());
        let size = file_bytes + meshes as u64;
        s.names.insert(SCENE_NAME, Resource::Scene(Arc::new(document), size), &self.limits)?;
        s.camera = scene.camera.unwrap_or_default();
        s.ambient = scene.ambient;
        s.lights = scene.lights.into_iter().map(Some).collect();
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

    pub(super) fn draw_eye(&mut self, s: &mut Session, name: &str, rect: Rect) -> Result<(), Fault> {
        let Some(Resource::Eye(eye)) = self.resource(s, Kind::Eye, name) else {
            return Err(missing(Kind::Eye, name));
        };
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
        Ok(())
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

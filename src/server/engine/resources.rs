//! The verbs that make, load and free named resources.

use super::Engine;
use super::space::missing;
use crate::command::{FileKind, MeshSource, Rect};
use crate::error::{Code, Fault};
use crate::scene::{Geometry, Mesh, Texture, shapes};
use crate::server::Session;
use crate::server::names::{Kind, Names, Resource};
use std::sync::Arc;

impl From<shapes::ShapeError> for Fault {
    fn from(e: shapes::ShapeError) -> Self {
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
            MeshSource::Obj(_bytes) => return Err(Fault::new(Code::Perm, "no OBJ reader")),
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
        not_yet((s, name, file))
    }
    pub(super) fn make_scene(&mut self, s: &mut Session, x3d: &[u8]) -> Result<(), Fault> {
        not_yet((s, x3d))
    }
    pub(super) fn make_eye(&mut self, s: &mut Session, name: &str, json: &[u8]) -> Result<(), Fault> {
        not_yet((s, name, json))
    }
    pub(super) fn load(
        &mut self,
        s: &mut Session,
        kind: FileKind,
        name: &str,
        path: &str,
    ) -> Result<(), Fault> {
        not_yet((s, kind, name, path, self.load_dir.is_some()))
    }
    pub(super) fn draw_scene(&mut self, s: &mut Session, time: f64, sorted: bool) -> Result<(), Fault> {
        not_yet((s, time, sorted))
    }
    pub(super) fn draw_eye(&mut self, s: &mut Session, name: &str, rect: Rect) -> Result<(), Fault> {
        not_yet((s, name, rect))
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

pub(super) fn not_yet<T, R>(_: T) -> Result<R, Fault> {
    Err(Fault::new(Code::Perm, "this verb is not built in yet"))
}

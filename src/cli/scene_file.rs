//! Scene files by name: an X3D document, an OBJ mesh or an N-dimensional scene, read with everything that they refer to.

use super::say;
use crate::eye::EyeScene;
use crate::load::x3d::X3dDocument;
use crate::load::{self, Folder, LoadError};
use crate::scene::{self, Camera, Geometry, Light, LightKind, Material, Object, Scene};
use glam::{DMat4, DVec3};
use std::path::Path;
use std::sync::Arc;

/// A scene file, read.
pub(super) enum SceneFile {
    X3d(Box<X3dDocument>),
    Obj(Arc<Geometry>),
    Eye(Box<EyeScene>),
}

/// Why a scene file is no use.
pub(super) enum SceneError {
    /// There is none, or its name says no format.
    NoFile(String),
    /// It was refused.
    Refused(String),
}

/// The largest scene file that is read.
const MAX_BYTES: u64 = 4 << 30;

/// Reads the scene at `path`; what it refers to is looked for in its folder. Warnings go to stderr.
pub(super) fn read(path: &Path) -> Result<SceneFile, SceneError> {
    let name = path.display().to_string();
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if !["x3d", "obj", "json"].contains(&ending.as_str()) {
        return Err(SceneError::NoFile(format!("{name}: expected a name that ends in .x3d, .obj or .json")));
    }
    let no_file = |e: std::io::Error| SceneError::NoFile(format!("{name}: {e}"));
    let meta = std::fs::metadata(path).map_err(no_file)?;
    if meta.is_dir() {
        return Err(SceneError::NoFile(format!("{name}: is a folder")));
    }
    if meta.len() > MAX_BYTES {
        return Err(SceneError::Refused(format!(
            "{name}: {} bytes are over the limit of {MAX_BYTES}",
            meta.len()
        )));
    }
    let bytes = std::fs::read(path).map_err(no_file)?;
    let folder = path.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
    let folder = folder.and_then(|p| Folder::open(p).ok());
    let mut beside = |name: &str| folder.as_ref()?.read(name, MAX_BYTES).ok();
    let refused = |e: LoadError| SceneError::Refused(e.to_string());
    match ending.as_str() {
        "x3d" => {
            let document = load::x3d::parse(&bytes, &name, &mut beside).map_err(refused)?;
            document.warnings().iter().for_each(|w| say(&w.to_string()));
            Ok(SceneFile::X3d(Box::new(document)))
        }
        "obj" => {
            let loaded = load::obj::parse(&bytes, &mut beside, &name).map_err(refused)?;
            loaded.warnings.iter().for_each(|w| say(&w.to_string()));
            Ok(SceneFile::Obj(Arc::new(loaded.geometry)))
        }
        _ => {
            let scene =
                EyeScene::from_json(&bytes).map_err(|e| SceneError::Refused(format!("{name}: {e}")))?;
            Ok(SceneFile::Eye(Box::new(scene)))
        }
    }
}

/// A mesh as a scene: framed for a picture of this aspect, lit from the viewer's upper left.
pub(super) fn scene_of_mesh(geometry: Arc<Geometry>, name: &str, aspect: f64) -> Scene {
    let camera = geometry
        .mesh
        .bounds()
        .map_or_else(Camera::default, |bounds| scene::frame_mesh(&geometry.mesh, bounds, aspect));
    let (eye, reference) = (camera.look_at.eye, camera.look_at.reference);
    let ahead = (reference - eye).normalize_or(DVec3::NEG_Z);
    let right = ahead.cross(camera.look_at.up).normalize_or(DVec3::X);
    let up = right.cross(ahead);
    let light = Light {
        kind: LightKind::Directional { direction: ahead + right * 0.5 - up * 0.5 },
        color: DVec3::ONE,
        ambient: DVec3::ZERO,
        clamp_attenuation: false,
    };
    let object = Object {
        name: name.to_owned(),
        geometry,
        model: DMat4::IDENTITY,
        material: Material { ka: DVec3::splat(0.8), ..Material::default() },
        back_material: None,
        cull: Default::default(),
        two_sided_lighting: false,
        shade: None,
        texture: None,
        lights: None,
    };
    Scene {
        camera: Some(camera),
        ambient: DVec3::splat(0.15),
        lights: vec![light],
        objects: vec![object],
        ..Scene::default()
    }
}

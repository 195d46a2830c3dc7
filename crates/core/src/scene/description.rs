//! Scene description: everything that a file or a stream draws.

use super::{Camera, Cull, Light, Material, Mesh, Sampling, ShadeMode, Sky, Style, Texture};
use glam::{DMat4, DVec3};
use std::sync::Arc;

/// Mesh placed in the world.
#[derive(Clone, Debug)]
pub struct Object {
    /// Name that PICK replies with.
    pub name: String,
    /// Mesh and textures, shared between objects.
    pub geometry: Arc<Geometry>,
    /// Matrix from object to world space; its last row is 0 0 0 1.
    pub model: DMat4,
    /// Material of polygons without one of their own.
    pub material: Material,
    /// Material of faces seen from behind (X3D's TwoSidedMaterial); `None` uses the front's.
    pub back_material: Option<Material>,
    /// Faces that are culled.
    pub cull: Cull,
    /// True if faces seen from behind turn their normal to the viewer for lighting (X3D
    /// solid='false').
    pub two_sided_lighting: bool,
    /// Shading mode; `None` takes that of the draw.
    pub shade: Option<ShadeMode>,
    /// Texture of polygons without one of their own, with its sampling.
    pub texture: Option<(Arc<Texture>, Sampling)>,
    /// Indices of the scene's lights that reach the object, or `None` for all.
    pub lights: Option<Vec<u32>>,
    /// Largest error, in steps of 1/255, of light that is interpolated over pixels of a large face;
    /// `None` for less than can be seen.
    pub light_error: Option<f64>,
    /// Line and fill patterns, and multitexturing.
    pub style: Style,
}

/// Mesh with the textures that its own materials name.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    /// The mesh.
    pub mesh: Mesh,
    /// Texture of each of the mesh's materials; `None` if it names none or none was found.
    pub textures: Vec<Option<Arc<Texture>>>,
}

impl From<Mesh> for Geometry {
    /// Takes a mesh whose materials have no textures.
    fn from(mesh: Mesh) -> Self {
        Geometry { textures: vec![None; mesh.materials.len()], mesh }
    }
}

impl From<Mesh> for Arc<Geometry> {
    fn from(mesh: Mesh) -> Self {
        Arc::new(mesh.into())
    }
}

/// Background of one colour.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Background {
    /// R, G, B in 0..1, or `None` to keep the pixels of the frame.
    pub color: Option<DVec3>,
}

/// Falloff of the fog factor over the distance d, with the visibility range as `range`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FogKind {
    /// (range - d) / range.
    Linear,
    /// exp(-d / (range - d)).
    Exponential,
}

/// Fog of X3D.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fog {
    /// R, G, B in 0..1.
    pub color: DVec3,
    /// Falloff over distance.
    pub kind: FogKind,
    /// Distance from the eye, in world units, at which only fog is seen; 0 and infinity are no fog.
    pub visibility_range: f64,
}

impl Fog {
    /// Returns whether the fog is seen at any distance.
    pub fn is_seen(&self) -> bool {
        self.visibility_range > 0.0 && self.visibility_range.is_finite()
    }
}

/// Order in which transparent faces are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum TransparencyOrder {
    /// In file order.
    #[default]
    FileOrder,
    /// From far to near, by the depth of their centroids.
    Sorted,
}

/// Scene at one moment: camera, lights, objects.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Camera; `None` if the file gives none, and the caller frames the scene.
    pub camera: Option<Camera>,
    /// Ambient light R, G, B.
    pub ambient: DVec3,
    /// Lights in world space.
    pub lights: Vec<Light>,
    /// Objects in file order.
    pub objects: Vec<Object>,
    /// Background colour.
    pub background: Background,
    /// Background of several colours or with pictures; painted in place of `background`.
    pub sky: Option<Arc<Sky>>,
    /// Fog, if any.
    pub fog: Option<Fog>,
}

//! A whole scene: what a file or a stream says is to be drawn.

use super::{Camera, Cull, Light, Material, Mesh, Sampling, ShadeMode, Sky, Style, Texture};
use glam::{DMat4, DVec3};
use std::sync::Arc;

/// One mesh in the world.
#[derive(Clone, Debug)]
pub struct Object {
    /// The name that PICK answers.
    pub name: String,
    /// What is drawn.
    pub geometry: Arc<Geometry>,
    /// Object to world space; its last row is 0 0 0 1.
    pub model: DMat4,
    /// For polygons without a material of their own.
    pub material: Material,
    /// X3D's TwoSidedMaterial: for faces seen from behind.
    pub back_material: Option<Material>,
    /// Which faces are left out.
    pub cull: Cull,
    /// Whether faces seen from behind turn their normal to the viewer before they are lit (X3D solid='false').
    pub two_sided_lighting: bool,
    /// How it is shaded; `None` takes the draw's own mode.
    pub shade: Option<ShadeMode>,
    /// The texture of polygons without one of their own, with its rules.
    pub texture: Option<(Arc<Texture>, Sampling)>,
    /// Which of the scene's lights reach it: indices, or `None` for all.
    pub lights: Option<Vec<u32>>,
    /// How its lines and faces are drawn beside that.
    pub style: Style,
}

/// A mesh with the textures that its own materials name.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    /// The mesh.
    pub mesh: Mesh,
    /// For each of the mesh's materials, its texture, if it names one that was found.
    pub textures: Vec<Option<Arc<Texture>>>,
}

/// What lies behind everything.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Background {
    /// R, G, B in 0..1, or `None` to leave the memory as it is.
    pub color: Option<DVec3>,
}

/// How fog thickens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FogKind {
    /// (range - d) / range.
    Linear,
    /// exp(-d / (range - d)).
    Exponential,
}

/// X3D's fog.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fog {
    /// Colour, 0..1.
    pub color: DVec3,
    /// How it thickens.
    pub kind: FogKind,
    /// Distance from the eye, in world units, at which nothing else is seen; 0 is no fog.
    pub visibility_range: f64,
}

/// In which order transparent faces are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum TransparencyOrder {
    /// As the file has them.
    #[default]
    FileOrder,
    /// Far to near, by the depth of their centres.
    Sorted,
}

/// A scene at one moment: camera, lights, objects.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The camera; `None` where the file gives none (the caller frames the scene).
    pub camera: Option<Camera>,
    /// Ambient light, R, G, B.
    pub ambient: DVec3,
    /// The lights, world space.
    pub lights: Vec<Light>,
    /// The objects, in file order.
    pub objects: Vec<Object>,
    /// What lies behind.
    pub background: Background,
    /// What lies behind where it is more than one colour; it is painted in place of `background`.
    pub sky: Option<Arc<Sky>>,
    /// Fog, if any.
    pub fog: Option<Fog>,
}

//! Scenes as plain data: meshes, materials, lights, cameras, textures, and the scene that holds
//! them.
//!
//! In: the values of files and commands. Out: the pipeline's input. No I/O and no drawing.
//!
//! World space is right-handed; the camera looks along its own -z; counter-clockwise faces are
//! front; angles are radians; all numbers are f64.

mod auto_framing;
mod camera;
mod description;
mod light;
mod maps;
mod material;
mod matrices;
mod max_error;
mod mesh;
mod modes;
mod navigate;
pub mod shapes;
mod sky;
mod stages;
mod style;
mod texture;
mod view_overrides;

pub(crate) use auto_framing::box_corners;
pub use auto_framing::{FRAME_FOV_RAD, FRAME_MARGIN, frame, frame_along, frame_mesh};
pub use camera::{
    Camera, CameraError, CameraMatrices, FARTHEST_EYE, LookAt, ObliqueKind, Projection, Viewport,
    ViewportRule,
};
pub use description::{Background, Fog, FogKind, Geometry, Object, Scene, TransparencyOrder};
pub use light::{Attenuation, Light, LightKind};
pub use maps::{NormalMap, OcclusionMap, SurfaceMap, SurfaceMaps, encoded};
pub use material::{LightingModel, Material};
pub use matrices::contain;
pub use max_error::MaxError;
pub use mesh::{Corner, Mesh, NONE, Polygon};
pub use modes::{Cull, Filter, HiddenSurface, Interpolation, Sampling, ShadeMode, Wrap};
pub use navigate::{Navigator, ProjectionChoice};
pub use sky::{Band, Sky, SkyPictures};
pub use stages::{MAX_STAGES, StageFunction, StageMode, StageSource, TextureStage, TextureStages};
pub use style::{FillStyle, Filling, Hatch, LineKind, LineStyle, MAX_POINT_SIZE, PointShape, Style};
pub(crate) use texture::FIXED_LEVELS;
pub use texture::{FixedLevels, LevelTexels, MAX_TEXTURE_SIDE, Texture, TextureError};
pub use view_overrides::{QualityUse, TextureUse, ViewOverrides, viewers_light};

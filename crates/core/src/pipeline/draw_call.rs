//! Inputs and outputs of a draw: target, draw call, scene options, statistics, errors.

use crate::error::{Code, Fault};
use crate::memory::{DepthFormat, DepthMemory, OverBudget, PickBuffer, VideoMemory};
use crate::scene::{
    Camera, CameraError, Cull, FillStyle, Fog, Geometry, HiddenSurface, Interpolation, Light, LineStyle,
    Material, Object, PointShape, Sampling, Scene, ShadeMode, SurfaceMaps, Texture, TextureStages,
    TransparencyOrder, Viewport,
};
use glam::{DMat4, DVec3};
use std::error::Error;
use std::fmt;
use std::sync::Arc;

/// The memories that a draw writes to.
#[derive(Debug)]
pub struct Target<'a> {
    /// Video memory: the frame.
    pub memory: &'a mut VideoMemory,
    /// Depth memory; created by the first draw that needs it, and again if its size or format
    /// differs.
    pub depth: &'a mut Option<DepthMemory>,
    /// Format of depth memory when it is created.
    pub depth_format: DepthFormat,
    /// Pick buffer: the face that wrote each pixel's depth; as large as the frame. `None` if PICK
    /// is not used.
    pub ids: Option<&'a mut PickBuffer>,
}

/// One DRAW: a mesh and every state that its picture depends on. Colours may exceed 1; positions
/// are in world space.
#[derive(Clone, Debug)]
pub struct DrawCall<'a> {
    /// The mesh, and the textures of its own materials.
    pub geometry: &'a Geometry,
    /// `geometry` as an `Arc`, if it is shared: a renderer then caches facts about it from draw
    /// to draw.
    pub shared: Option<&'a Arc<Geometry>>,
    /// Object to world space; the last row is 0 0 0 1.
    pub model: DMat4,
    /// View and projection.
    pub camera: Camera,
    /// Part of the frame that is drawn to; it may extend beyond the frame.
    pub viewport: Viewport,
    /// Ambient light.
    pub ambient: DVec3,
    /// The lights that are on, in order.
    pub lights: &'a [Light],
    /// Indices of the `lights` that reach this mesh; `None` for all.
    pub light_subset: Option<&'a [u32]>,
    /// Material of polygons that have none of their own (`usemtl` takes precedence).
    pub material: &'a Material,
    /// Material of faces seen from behind, in place of every other one (X3D's TwoSidedMaterial).
    pub back_material: Option<&'a Material>,
    /// Texture of polygons whose own material names none.
    pub texture: Option<&'a Texture>,
    /// Wrap and filter modes of every texture in this draw.
    pub sampling: Sampling,
    /// Shading mode.
    pub shade: ShadeMode,
    /// Faces to leave out by the side seen.
    pub cull: Cull,
    /// Hidden-surface method.
    pub hide: HiddenSurface,
    /// Interpolation of attributes across a face: linear on the screen or perspective-correct.
    pub interp: Interpolation,
    /// True if faces seen from behind flip their normal before lighting.
    pub two_sided_lighting: bool,
    /// X3D fog.
    pub fog: Option<Fog>,
    /// Line style.
    pub line: LineStyle,
    /// Side of points in pixels; 0 is 1.
    pub point_size: u32,
    /// Shape of points.
    pub point_shape: PointShape,
    /// Fill style of faces.
    pub fill: FillStyle,
    /// Multitexturing stages, in place of `texture`.
    pub stages: Option<&'a TextureStages>,
    /// Maps of emission, normals and occlusion.
    pub maps: Option<&'a SurfaceMaps>,
    /// Value that the pick buffer stores for this draw.
    pub name: u32,
    /// Largest error, in steps of 1/255, of light that is interpolated over pixels of a large face;
    /// `None` for less than can be seen.
    pub light_error: Option<f64>,
}

impl<'a> DrawCall<'a> {
    /// Creates a draw of `geometry` with the command language's initial state, over a frame of
    /// `width` x `height` pixels.
    pub fn new(geometry: &'a Geometry, material: &'a Material, width: u32, height: u32) -> Self {
        DrawCall {
            geometry,
            shared: None,
            model: DMat4::IDENTITY,
            camera: Camera::default(),
            viewport: Viewport { x: 0, y: 0, width, height, rule: Default::default() },
            ambient: DVec3::ZERO,
            lights: &[],
            light_subset: None,
            material,
            back_material: None,
            texture: None,
            sampling: Sampling::default(),
            shade: ShadeMode::default(),
            cull: Cull::default(),
            hide: HiddenSurface::default(),
            interp: Interpolation::default(),
            two_sided_lighting: false,
            fog: None,
            line: LineStyle::default(),
            point_size: 1,
            point_shape: PointShape::default(),
            fill: FillStyle::default(),
            stages: None,
            maps: None,
            name: 0,
            light_error: None,
        }
    }
}

impl<'a> DrawCall<'a> {
    /// Creates the draw of one object of a scene, with `name` 0.
    pub fn of_object(object: &'a Object, scene: &'a Scene, options: &SceneOptions) -> Self {
        DrawCall {
            geometry: &object.geometry,
            shared: Some(&object.geometry),
            model: object.model,
            camera: scene.camera.unwrap_or(options.camera),
            viewport: options.viewport,
            ambient: scene.ambient,
            lights: &scene.lights,
            light_subset: object.lights.as_deref(),
            material: &object.material,
            back_material: object.back_material.as_ref(),
            texture: object.texture.as_ref().map(|(t, _)| t.as_ref()),
            sampling: object.texture.as_ref().map(|(_, s)| *s).unwrap_or_default(),
            shade: object.shade.unwrap_or(options.shade),
            cull: object.cull,
            hide: options.hide,
            interp: options.interp,
            two_sided_lighting: object.two_sided_lighting,
            fog: scene.fog,
            line: object.style.line,
            point_size: object.style.point_size,
            point_shape: object.style.point_shape,
            fill: object.style.fill,
            stages: object.style.stages.as_deref(),
            maps: object.style.maps.as_deref(),
            name: 0,
            light_error: object.light_error,
        }
    }
}

/// Use of depth after a scene is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum DepthUse {
    /// Later commands may read it (a stream): depth is kept under `zbuffer`.
    #[default]
    Keep,
    /// Only the scene itself: depth is left out where nothing can be hidden.
    SceneOnly,
}

/// Hierarchical culling in the tile renderer: leaves out faces behind everything in their part of a
/// tile. The bytes are the same either way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum CoarseDepth {
    /// As the draws before tell of each mesh: culling if most of it was hidden.
    #[default]
    Auto,
    /// No culling; every face's pixels are depth-tested.
    Off,
    /// Hidden faces are culled first, under f32 depths.
    On,
}

/// The code path that draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum RenderPath {
    /// The tile renderer where it supports the draw, otherwise the plain path.
    #[default]
    Fast,
    /// The plain path for every draw: the reference.
    Plain,
}

/// Settings by which a plan chooses the path of a draw, beside the draw itself.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Backend {
    /// The code path that draws.
    pub path: RenderPath,
    /// Hierarchical culling of hidden faces.
    pub coarse: CoarseDepth,
}

/// Settings for drawing a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneOptions {
    /// Part of the frame that is drawn to.
    pub viewport: Viewport,
    /// Camera of scenes that have none of their own.
    pub camera: Camera,
    /// Shading mode of objects that set none.
    pub shade: ShadeMode,
    /// Hidden-surface method.
    pub hide: HiddenSurface,
    /// Interpolation of attributes across a face.
    pub interp: Interpolation,
    /// Order of transparent faces, which follow the opaque ones.
    pub transparency: TransparencyOrder,
    /// Use of depth after the scene is drawn.
    pub depth_use: DepthUse,
    /// Pick-buffer value of object 0; object i has `first_name + i`.
    pub first_name: u32,
}

impl SceneOptions {
    /// Creates the initial state over a frame of `width` x `height` pixels.
    pub fn new(width: u32, height: u32) -> Self {
        SceneOptions {
            viewport: Viewport { x: 0, y: 0, width, height, rule: Default::default() },
            camera: Camera::default(),
            shade: ShadeMode::default(),
            hide: HiddenSurface::default(),
            interp: Interpolation::default(),
            transparency: TransparencyOrder::default(),
            depth_use: DepthUse::default(),
            first_name: 0,
        }
    }
}

/// Faces that each path was given to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct PathCounts {
    /// Faces of draws by the tile renderer, culled ones included.
    pub tiles: u64,
    /// Faces drawn in order by vector kernels.
    pub vectors: u64,
    /// Faces drawn in order by the reference.
    pub reference: u64,
}

/// Counts of items in and out of each stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct DrawStats {
    /// Vertices transformed.
    pub vertices: u64,
    /// Triangles submitted.
    pub faces: u64,
    /// Triangles without area on the screen, or with a number that is not finite.
    pub faces_empty: u64,
    /// Triangles entirely outside the view.
    pub faces_outside: u64,
    /// Triangles culled by CULL.
    pub faces_culled: u64,
    /// Triangles with some w <= 0, clipped in front of the eye.
    pub faces_cut: u64,
    /// Triangles passed to the rasterizer.
    pub faces_drawn: u64,
    /// Triangles culled by coarse depth, counted once per tile reached; their pixels are not
    /// tested.
    pub faces_hidden: u64,
    /// Draws with coarse depth. If there are any, `faces_hidden` and `pixels_tested` depend on the
    /// vector level; nothing else does.
    pub coarse_draws: u64,
    /// Line segments drawn (wireframe edges, line sets), after clipping.
    pub lines_drawn: u64,
    /// Points drawn.
    pub points_drawn: u64,
    /// Corners lit (Gouraud), or faces (flat).
    pub vertices_lit: u64,
    /// Pixels covered and depth-tested.
    pub pixels_tested: u64,
    /// Pixels lit individually (Phong).
    pub pixels_lit: u64,
    /// Pixels written.
    pub pixels_written: u64,
}

impl std::ops::AddAssign for DrawStats {
    fn add_assign(&mut self, o: Self) {
        self.vertices += o.vertices;
        self.faces += o.faces;
        self.faces_empty += o.faces_empty;
        self.faces_outside += o.faces_outside;
        self.faces_culled += o.faces_culled;
        self.faces_cut += o.faces_cut;
        self.faces_drawn += o.faces_drawn;
        self.faces_hidden += o.faces_hidden;
        self.coarse_draws += o.coarse_draws;
        self.lines_drawn += o.lines_drawn;
        self.points_drawn += o.points_drawn;
        self.vertices_lit += o.vertices_lit;
        self.pixels_tested += o.pixels_tested;
        self.pixels_lit += o.pixels_lit;
        self.pixels_written += o.pixels_written;
    }
}

/// Reason why a draw was refused; the target is then untouched.
#[derive(Clone, Debug, PartialEq)]
pub enum PipelineError {
    /// The camera makes no picture.
    Camera(CameraError),
    /// The model matrix's last row is not 0 0 0 1.
    PerspectiveModel {
        /// The row found.
        row: [f64; 4],
    },
    /// A number is not finite.
    NotFinite {
        /// The field concerned.
        what: &'static str,
    },
    /// The mesh has an index outside its own arrays.
    BadIndex {
        /// The array.
        what: &'static str,
        /// The index.
        index: u64,
        /// The array's length.
        len: u64,
    },
    /// The draw's working memory does not fit the budget, not even in pieces.
    OverBudget(OverBudget),
}

impl fmt::Display for PipelineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PipelineError::Camera(e) => write!(f, "camera: {e}"),
            PipelineError::PerspectiveModel { row: [x, y, z, w] } => {
                write!(f, "the model matrix's last row is 0 0 0 1, not {x} {y} {z} {w}")
            }
            PipelineError::NotFinite { what } => write!(f, "{what} holds a number that is not finite"),
            PipelineError::BadIndex { what, index, len } => {
                write!(f, "mesh {what} {index} is outside its {len} entries")
            }
            PipelineError::OverBudget(e) => write!(f, "{e}"),
        }
    }
}

impl Error for PipelineError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            PipelineError::Camera(e) => Some(e),
            _ => None,
        }
    }
}

impl From<CameraError> for PipelineError {
    fn from(e: CameraError) -> Self {
        PipelineError::Camera(e)
    }
}

impl From<OverBudget> for PipelineError {
    fn from(e: OverBudget) -> Self {
        PipelineError::OverBudget(e)
    }
}

impl PipelineError {
    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            PipelineError::Camera(e) => e.code(),
            PipelineError::OverBudget(e) => e.code(),
            _ => Code::Range,
        }
    }
}

impl From<PipelineError> for Fault {
    fn from(e: PipelineError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

//! What a draw is given, and what it answers.

use crate::error::Code;
use crate::memory::{DepthFormat, DepthMemory, OverBudget, PickBuffer, VideoMemory};
use crate::scene::{
    Camera, CameraError, Cull, FillStyle, Fog, Geometry, HiddenSurface, Interpolation, Light, LineStyle,
    Material, Object, Sampling, Scene, ShadeMode, Texture, TextureStages, TransparencyOrder, Viewport,
};
use glam::{DMat4, DVec3};
use std::sync::Arc;

/// The memories that a draw writes.
#[derive(Debug)]
pub struct Target<'a> {
    /// The frame.
    pub memory: &'a mut VideoMemory,
    /// Its depth: made by the first draw that needs it, and again when its size or format is another one.
    pub depth: &'a mut Option<DepthMemory>,
    /// The format in which depth is made.
    pub depth_format: DepthFormat,
    /// Which face wrote the depth of each pixel, where PICK asks for it; as large as the frame.
    pub ids: Option<&'a mut PickBuffer>,
}

/// One DRAW: a mesh and every state that its picture depends on. Colours may exceed 1; positions are world coordinates.
#[derive(Clone, Debug)]
pub struct DrawCall<'a> {
    /// The mesh, and the textures of its own materials.
    pub geometry: &'a Geometry,
    /// The same geometry as something shared, where it is: a renderer then keeps its prepared form from draw to draw.
    pub shared: Option<&'a Arc<Geometry>>,
    /// Object to world space; its last row is 0 0 0 1.
    pub model: DMat4,
    /// View and projection.
    pub camera: Camera,
    /// Which part of the frame is drawn to; it may leave the frame.
    pub viewport: Viewport,
    /// Ambient light.
    pub ambient: DVec3,
    /// The lights that are on, in order.
    pub lights: &'a [Light],
    /// Which of `lights` reach this mesh, as indices; `None` for all.
    pub light_subset: Option<&'a [u32]>,
    /// For polygons without a material of their own (`usemtl` wins).
    pub material: &'a Material,
    /// For faces seen from behind, in place of every other material (X3D's TwoSidedMaterial).
    pub back_material: Option<&'a Material>,
    /// For polygons whose own material names no texture.
    pub texture: Option<&'a Texture>,
    /// The rules of every texture in this draw.
    pub sampling: Sampling,
    /// How faces get their colours.
    pub shade: ShadeMode,
    /// Which faces are left out.
    pub cull: Cull,
    /// How hidden surfaces are found.
    pub hide: HiddenSurface,
    /// How values run across a face.
    pub interp: Interpolation,
    /// Whether faces seen from behind turn their normal before they are lit.
    pub two_sided_lighting: bool,
    /// X3D's fog.
    pub fog: Option<Fog>,
    /// How lines are drawn.
    pub line: LineStyle,
    /// How faces are filled.
    pub fill: FillStyle,
    /// Several textures in place of one.
    pub stages: Option<&'a TextureStages>,
    /// What the pick buffer keeps for this draw.
    pub name: u32,
}

impl<'a> DrawCall<'a> {
    /// A draw of `geometry` with the command language's start state, over a whole frame of `width` x `height` pixels.
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
            fill: FillStyle::default(),
            stages: None,
            name: 0,
        }
    }
}

impl<'a> DrawCall<'a> {
    /// The draw of one object of a scene, nameless (`name` is 0).
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
            fill: object.style.fill,
            stages: object.style.stages.as_deref(),
            name: 0,
        }
    }
}

/// Whether anybody reads the depth after the scene is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum DepthUse {
    /// A stream: what comes next is not known, so under `zbuffer` depth is kept.
    #[default]
    Keep,
    /// The scene is known whole and nobody asks for depth: it is left out where nothing can be hidden.
    SceneOnly,
}

/// Whether the tile renderer leaves out faces that lie behind everything in their part of a tile; the same bytes either way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum CoarseDepth {
    /// Every face's pixels are tested.
    #[default]
    Off,
    /// Hidden faces are left out first, under f32 depths.
    On,
}

/// How a whole scene is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneOptions {
    /// Which part of the frame is drawn to.
    pub viewport: Viewport,
    /// The camera of scenes that have none of their own.
    pub camera: Camera,
    /// For objects that do not say.
    pub shade: ShadeMode,
    /// How hidden surfaces are found.
    pub hide: HiddenSurface,
    /// How values run across a face.
    pub interp: Interpolation,
    /// In which order transparent faces follow the opaque ones.
    pub transparency: TransparencyOrder,
    /// Whether depth is kept where it is not needed.
    pub depth_use: DepthUse,
    /// The id of object 0; object i has `first_name + i`.
    pub first_name: u32,
}

impl SceneOptions {
    /// The start state over a whole frame of `width` x `height` pixels.
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

/// What went in and out of each stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct DrawStats {
    /// Vertices transformed.
    pub vertices: u64,
    /// Triangles that came in.
    pub faces: u64,
    /// Triangles left out: without area on the screen, or with a number that is not finite.
    pub faces_empty: u64,
    /// Triangles left out as wholly outside the view.
    pub faces_outside: u64,
    /// Triangles left out by CULL.
    pub faces_culled: u64,
    /// Triangles with some w <= 0, cut in front of the eye.
    pub faces_cut: u64,
    /// Triangles handed to the rasteriser.
    pub faces_drawn: u64,
    /// Triangles left out by coarse depth, each once for every tile that it reaches; their pixels are not tested.
    pub faces_hidden: u64,
    /// Line segments drawn (wire edges, line sets), after clipping.
    pub lines_drawn: u64,
    /// Points drawn.
    pub points_drawn: u64,
    /// Corners lit (Gouraud), or faces (flat).
    pub vertices_lit: u64,
    /// Pixels covered, whose depth was found.
    pub pixels_tested: u64,
    /// Pixels lit one by one (Phong).
    pub pixels_lit: u64,
    /// Pixels stored.
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
        self.lines_drawn += o.lines_drawn;
        self.points_drawn += o.points_drawn;
        self.vertices_lit += o.vertices_lit;
        self.pixels_tested += o.pixels_tested;
        self.pixels_lit += o.pixels_lit;
        self.pixels_written += o.pixels_written;
    }
}

/// Why a draw was refused; the memories are then untouched.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PipelineError {
    /// The camera makes no picture.
    #[error("camera: {0}")]
    Camera(#[from] CameraError),
    /// The model matrix's last row is not 0 0 0 1.
    #[error("the model matrix's last row is 0 0 0 1, not {} {} {} {}", .row[0], .row[1], .row[2], .row[3])]
    PerspectiveModel {
        /// The row found.
        row: [f64; 4],
    },
    /// A number is not finite.
    #[error("{what} holds a number that is not finite")]
    NotFinite {
        /// Where it is.
        what: &'static str,
    },
    /// The mesh points outside its own arrays.
    #[error("mesh {what} {index} is outside its {len} entries")]
    BadIndex {
        /// Which array.
        what: &'static str,
        /// The index found.
        index: u64,
        /// How many entries there are.
        len: u64,
    },
    /// The draw's working memory does not fit the budget, not even in pieces.
    #[error(transparent)]
    OverBudget(#[from] OverBudget),
}

impl PipelineError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            PipelineError::Camera(e) => e.code(),
            PipelineError::OverBudget(e) => e.code(),
            _ => Code::Range,
        }
    }
}

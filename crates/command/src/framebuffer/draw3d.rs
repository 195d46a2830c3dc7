//! Meshes and scenes.

use super::Framebuffer;
use fbptr_core::memory::{DepthFormat, MemoryError, PickBuffer};
use fbptr_core::pipeline::{DrawCall, DrawStats, EmptyDraw, PipelineError, SceneOptions, Target, is_dark};
use fbptr_core::scene::{
    Camera, Cull, Geometry, HiddenSurface, Interpolation, Light, Material, Mesh, Sampling, Scene, ShadeMode,
    Texture, frame_mesh, viewers_light,
};
use glam::{DMat4, DVec3};
use std::borrow::Cow;
use std::fmt;
use std::sync::Arc;

/// Settings of [`Framebuffer::draw`]: the states that the command language keeps for each client,
/// with its initial values. There is no light at first: [`Framebuffer::show_whole`] sets one.
#[derive(Clone, Debug)]
pub struct DrawState {
    /// View and projection.
    pub camera: Camera,
    /// Object to world space; the last row is 0 0 0 1.
    pub model: DMat4,
    /// Ambient light.
    pub ambient: DVec3,
    /// Lights in world space.
    pub lights: Vec<Light>,
    /// Material of polygons that have none of their own.
    pub material: Material,
    /// Texture of polygons whose own material names none, with its sampling.
    pub texture: Option<(Arc<Texture>, Sampling)>,
    /// Shading mode.
    pub shade: ShadeMode,
    /// Faces to leave out by the side seen.
    pub cull: Cull,
    /// Hidden-surface method.
    pub hide: HiddenSurface,
    /// Interpolation of attributes across a face.
    pub interp: Interpolation,
    /// Format of depth memory. A change clears it at the next draw.
    pub depth_format: DepthFormat,
    /// Value that the pick buffer stores for the draw.
    pub name: u32,
}

impl Default for DrawState {
    fn default() -> Self {
        DrawState {
            camera: Camera::default(),
            model: DMat4::IDENTITY,
            ambient: DVec3::ZERO,
            lights: Vec::new(),
            material: Material::default(),
            texture: None,
            shade: ShadeMode::default(),
            cull: Cull::default(),
            hide: HiddenSurface::default(),
            interp: Interpolation::default(),
            depth_format: DepthFormat::default(),
            name: 0,
        }
    }
}

/// Result of a draw that was made.
#[derive(Clone, Copy, Debug)]
#[must_use = "it says whether the draw shows anything"]
pub struct DrawReport {
    /// Counts of the draw's stages.
    pub stats: DrawStats,
    /// The reason for which nothing of it can be seen, `None` if something can.
    pub empty: Option<EmptyDraw>,
}

impl DrawReport {
    /// Returns the counts, or the reason for which nothing can be seen as an error.
    ///
    /// # Errors
    /// If nothing of the draw can be seen.
    pub fn visible(self) -> Result<DrawStats, InvisibleDraw> {
        match self.empty {
            None => Ok(self.stats),
            Some(reason) => Err(InvisibleDraw(reason)),
        }
    }
}

/// A draw that shows nothing, as an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InvisibleDraw(pub EmptyDraw);

impl fmt::Display for InvisibleDraw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the draw shows nothing: {}", self.0)
    }
}

impl std::error::Error for InvisibleDraw {}

/// A mesh that [`Framebuffer::draw`] takes: a [`Mesh`] alone, or a [`Geometry`] with the textures
/// of its materials.
///
/// An `Arc<Geometry>` is drawn fastest: facts about it are cached from draw to draw. A [`Mesh`]
/// alone is copied by each draw.
pub trait Drawable {
    /// Returns the mesh with its textures.
    fn geometry(&self) -> Cow<'_, Geometry>;

    /// Returns the shared geometry, if it is one.
    fn shared(&self) -> Option<&Arc<Geometry>> {
        None
    }
}

impl Drawable for Mesh {
    fn geometry(&self) -> Cow<'_, Geometry> {
        Cow::Owned(self.clone().into())
    }
}

impl Drawable for Geometry {
    fn geometry(&self) -> Cow<'_, Geometry> {
        Cow::Borrowed(self)
    }
}

impl Drawable for Arc<Geometry> {
    fn geometry(&self) -> Cow<'_, Geometry> {
        Cow::Borrowed(self)
    }

    fn shared(&self) -> Option<&Arc<Geometry>> {
        Some(self)
    }
}

impl Framebuffer {
    /// Draws a mesh with the settings of [`Framebuffer::state`], as `DRAW` does. The report says
    /// why nothing can be seen of it, if that is so: there is no light at first, a mesh may lie
    /// outside the view, its faces may be turned away. [`DrawReport::visible`] makes that an error.
    ///
    /// ```
    /// let mut fb = fbptr_command::Framebuffer::new(64, 48)?;
    /// let teapot = fbptr_core::scene::shapes::teapot(4)?;
    /// fb.show_whole(&teapot);
    /// fb.draw(&teapot)?.visible()?;
    /// assert!(fb.depth_at(32, 24)? < 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the camera makes no picture, or a number of the settings or the mesh is not finite; the
    /// frame is then unchanged.
    pub fn draw(&mut self, mesh: &impl Drawable) -> Result<DrawReport, PipelineError> {
        let geometry = mesh.geometry();
        let (width, height) = (self.width(), self.height());
        let Framebuffer { memory, depth, ids, renderer, state, .. } = self;
        let call = DrawCall {
            shared: mesh.shared(),
            model: state.model,
            camera: state.camera,
            ambient: state.ambient,
            lights: &state.lights,
            texture: state.texture.as_ref().map(|(texture, _)| texture.as_ref()),
            sampling: state.texture.as_ref().map(|(_, sampling)| *sampling).unwrap_or_default(),
            shade: state.shade,
            cull: state.cull,
            hide: state.hide,
            interp: state.interp,
            name: state.name,
            ..DrawCall::new(&geometry, &state.material, width, height)
        };
        let mut target = Target { memory, depth, depth_format: state.depth_format, ids: ids.as_mut() };
        let stats = renderer.draw(&mut target, &call)?;
        Ok(DrawReport { stats, empty: EmptyDraw::of_call(&stats, &call, target.memory, is_dark(&call)) })
    }

    /// Draws a scene, as `DRAWSCENE` does: its background, its objects, and last the transparent
    /// faces. Camera, shading, hidden surfaces and interpolation are those of
    /// [`Framebuffer::state`] where the scene has none of its own. The report is that of
    /// [`Framebuffer::draw`].
    ///
    /// # Errors
    /// Those of [`Framebuffer::draw`].
    pub fn draw_scene(&mut self, scene: &Scene) -> Result<DrawReport, PipelineError> {
        let DrawState { camera, shade, hide, interp, name, .. } = self.state;
        let size = SceneOptions::new(self.width(), self.height());
        let options = SceneOptions { camera, shade, hide, interp, first_name: name, ..size };
        let Framebuffer { memory, depth, ids, renderer, state, .. } = self;
        let mut target = Target { memory, depth, depth_format: state.depth_format, ids: ids.as_mut() };
        let stats = renderer.draw_scene(&mut target, scene, &options)?;
        Ok(DrawReport { stats, empty: EmptyDraw::of_scene(&stats, scene, &options, target.memory) })
    }

    /// Sets a camera that shows all of a mesh from its front, somewhat from the right and above, a
    /// light from the viewer's upper left, and some ambient light with the material's reflection of
    /// it. A mesh without positions keeps the camera.
    pub fn show_whole(&mut self, mesh: &impl Drawable) {
        let aspect = f64::from(self.width()) / f64::from(self.height());
        let geometry = mesh.geometry();
        if let Some(bounds) = geometry.mesh.bounds() {
            self.state.camera = frame_mesh(&geometry.mesh, bounds, aspect, false);
        }
        self.state.ambient = DVec3::splat(0.15);
        self.state.material.ka = DVec3::splat(0.8);
        self.state.lights = vec![viewers_light(&self.state.camera)];
    }

    /// Returns the depth of a pixel, from 0 (near) to 1 (far, or never drawn), as `DEPTHAT` does.
    ///
    /// # Errors
    /// If the pixel is outside the frame.
    pub fn depth_at(&self, x: i32, y: i32) -> Result<f64, MemoryError> {
        self.memory.get_pixel(x, y)?;
        Ok(self.depth.as_ref().and_then(|depth| depth.z(x, y)).unwrap_or(1.0))
    }

    /// Lets later draws store which face is seen at each pixel, for [`Framebuffer::pick`].
    pub fn enable_picking(&mut self) {
        let (width, height) = (self.width(), self.height());
        self.ids.get_or_insert_with(|| PickBuffer::new(width, height));
    }

    /// Returns the [`DrawState::name`] and the triangle that are seen at a pixel; `None` off the
    /// frame, where nothing was drawn, and before [`Framebuffer::enable_picking`].
    pub fn pick(&self, x: i32, y: i32) -> Option<(u32, u32)> {
        self.ids.as_ref()?.get(x, y)
    }
}

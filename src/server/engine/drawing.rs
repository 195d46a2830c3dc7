//! A 3-D draw with everything that it needs, so that it can run on the render thread or on another
//! one; and an estimate of its time.
//!
//! In: resources, session state and settings, resolved when the command begins. Out: a
//! [`Drawing`], which draws the same whoever runs it, and an upper bound of its time by which long
//! draws are told from short ones. The bound must not miss a draw that takes long: one would know
//! by `benches/waits.py`, where another client then waits.

use crate::command::Command;
use crate::memory::Reservation;
use crate::pipeline::{CoverageBound, DrawCall, DrawStats, PipelineError, Renderer, SceneOptions, Target};
use crate::scene::{
    Camera, Cull, FillStyle, Geometry, HiddenSurface, Interpolation, Light, Material, Sampling, Scene,
    ShadeMode, Texture, Viewport,
};
use glam::{DMat4, DVec3};
use std::fmt;
use std::sync::Arc;

/// A `DRAW` or a `DRAWSCENE`.
pub(in crate::server) enum Drawing {
    Mesh(Box<MeshDraw>),
    Scene(Box<SceneDraw>),
}

/// A `DRAW`: its mesh, and the settings of its session.
pub(in crate::server) struct MeshDraw {
    /// Name of the mesh, and its number in the pick buffer.
    pub name: String,
    pub id: u32,
    pub geometry: Arc<Geometry>,
    pub texture: Option<Arc<Texture>>,
    pub sampling: Sampling,
    pub lights: Vec<Light>,
    pub ambient: DVec3,
    pub material: Material,
    pub model: DMat4,
    pub camera: Camera,
    pub viewport: Viewport,
    pub shade: ShadeMode,
    pub cull: Cull,
    pub hide: HiddenSurface,
    pub interp: Interpolation,
    /// Set if the draw is certainly black, whatever `QUALITY` makes of it.
    pub is_dark: bool,
    /// The session's own modes, which `STATS` names.
    pub asked: (ShadeMode, HiddenSurface),
}

/// A `DRAWSCENE`: its scene at a time.
pub(in crate::server) struct SceneDraw {
    pub scene: Scene,
    pub options: SceneOptions,
    pub time: f64,
    pub sorted: bool,
    /// Reservation for the scene's objects.
    pub _held: Reservation,
}

impl MeshDraw {
    /// Returns the draw call.
    pub fn call(&self) -> DrawCall<'_> {
        DrawCall {
            shared: Some(&self.geometry),
            model: self.model,
            camera: self.camera,
            viewport: self.viewport,
            ambient: self.ambient,
            lights: &self.lights,
            texture: self.texture.as_deref(),
            sampling: self.sampling,
            shade: self.shade,
            cull: self.cull,
            hide: self.hide,
            interp: self.interp,
            name: self.id,
            ..DrawCall::new(&self.geometry, &self.material, self.viewport.width, self.viewport.height)
        }
    }
}

/// Estimated nanoseconds from which a draw does not run on the render thread.
pub(super) const LONG_NS: u64 = 4_000_000;
/// Largest number of faces whose areas are added up; more are taken to fill the viewport.
const FEW_FACES: usize = 512;
/// Estimated nanoseconds of a face, line or point beside its pixels: drawn by tiles, or in order.
const FACE_NS: u64 = 100;
const ORDERED_FACE_NS: u64 = 1000;
/// Estimated nanoseconds of an object of a scene beside its faces.
const OBJECT_NS: u64 = 2000;
/// Estimated nanoseconds of a pixel of a face or a line by vectors, by the plain path, of its light
/// by one lamp, and of a sky.
const PIXEL_NS: u64 = 4;
const PLAIN_PIXEL_NS: u64 = 40;
const LIGHT_NS: u64 = 4;
const SKY_NS: u64 = 30;
/// Estimated nanoseconds of a pixel of a face that is covered, and its depth tested, but not seen.
const RASTER_NS: f64 = 1.0;

impl fmt::Debug for Drawing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.verb())
    }
}

impl Drawing {
    /// Returns the draw call of a `DRAW`.
    pub fn mesh_call(&self) -> Option<DrawCall<'_>> {
        match self {
            Drawing::Mesh(draw) => Some(draw.call()),
            Drawing::Scene(_) => None,
        }
    }

    /// Draws.
    ///
    /// # Errors
    /// As [`Renderer::draw`] and [`Renderer::draw_scene`].
    pub fn run(&self, renderer: &mut Renderer, target: &mut Target) -> Result<DrawStats, PipelineError> {
        match self {
            Drawing::Mesh(draw) => renderer.draw(target, &draw.call()),
            Drawing::Scene(draw) => renderer.draw_scene(target, &draw.scene, &draw.options),
        }
    }

    /// Returns the command.
    pub fn command(&self) -> Command {
        match self {
            Drawing::Mesh(draw) => Command::Draw { name: draw.name.clone() },
            Drawing::Scene(draw) => Command::DrawScene { time: draw.time, sorted: draw.sorted },
        }
    }

    /// Returns the command's verb.
    pub fn verb(&self) -> &'static str {
        match self {
            Drawing::Mesh(_) => "DRAW",
            Drawing::Scene(_) => "DRAWSCENE",
        }
    }

    /// Returns the hidden-surface method.
    pub fn hide(&self) -> HiddenSurface {
        match self {
            Drawing::Mesh(draw) => draw.hide,
            Drawing::Scene(draw) => draw.options.hide,
        }
    }

    /// Returns the sum of a figure over the draw's calls, if each has one, and of the estimated
    /// nanoseconds of what is behind the objects of a scene.
    pub fn sum_of_calls(
        &self,
        frame: u64,
        figure: &mut dyn FnMut(&Arc<Geometry>, &DrawCall) -> Option<u64>,
    ) -> Option<u64> {
        match self {
            Drawing::Mesh(draw) => figure(&draw.geometry, &draw.call()),
            Drawing::Scene(draw) => {
                let SceneDraw { scene, options, .. } = &**draw;
                scene.objects.iter().try_fold(backdrop_ns(scene, frame), |sum, object| {
                    let call = DrawCall::of_object(object, scene, options);
                    Some(figure(&object.geometry, &call)?.saturating_add(sum).saturating_add(OBJECT_NS))
                })
            }
        }
    }

    /// Returns whether the draw may take so long that others should not wait for all of it. `frame`
    /// is the number of pixels of the frame.
    pub fn is_long(&self, frame: u64) -> bool {
        self.estimated_ns(frame) > LONG_NS
    }

    /// Estimates the nanoseconds of the draw on one thread, rather too many than too few; any number
    /// that is long if it is more than that.
    pub fn estimated_ns(&self, frame: u64) -> u64 {
        match self {
            Drawing::Mesh(draw) => draw_ns(&draw.call(), frame),
            Drawing::Scene(draw) => {
                let SceneDraw { scene, options, .. } = &**draw;
                let mut sum = backdrop_ns(scene, frame);
                for object in &scene.objects {
                    if sum > LONG_NS {
                        break;
                    }
                    let call = DrawCall::of_object(object, scene, options);
                    sum = sum.saturating_add(OBJECT_NS + draw_ns(&call, frame));
                }
                sum
            }
        }
    }
}

/// Estimates the nanoseconds of what is behind the objects of a scene.
fn backdrop_ns(scene: &Scene, frame: u64) -> u64 {
    if scene.sky.is_some() { frame * SKY_NS } else { frame / 4 }
}

/// Estimates the nanoseconds of a draw on one thread, rather too many than too few.
fn draw_ns(call: &DrawCall, frame: u64) -> u64 {
    let (items, pixel_ns) = (items_ns(call), pixel_ns(call));
    if items > LONG_NS {
        return items;
    }
    let most = (LONG_NS / pixel_ns).saturating_add(1);
    items + covered_pixels(call, frame, most).saturating_mul(pixel_ns)
}

/// Estimates the nanoseconds of a draw's faces, lines and points beside their pixels.
fn items_ns(call: &DrawCall) -> u64 {
    let mesh = &call.geometry.mesh;
    let is_ordered = call.hide == HiddenSurface::Painter || call.shade == ShadeMode::Wire;
    let face_ns = if is_ordered { ORDERED_FACE_NS } else { FACE_NS };
    let figures = (mesh.lines.len() + mesh.points.len()) as u64 * ORDERED_FACE_NS;
    mesh.triangles.len() as u64 * face_ns + mesh.positions.len() as u64 * FACE_NS + figures
}

/// Estimates the nanoseconds of a pixel of a draw.
fn pixel_ns(call: &DrawCall) -> u64 {
    let lights = if call.shade == ShadeMode::Phong { call.lights.len() as u64 } else { 0 };
    let pixel = if is_plain(call) { PLAIN_PIXEL_NS } else { PIXEL_NS };
    pixel + LIGHT_NS * lights
}

/// Returns whether only the plain path draws a call's faces.
fn is_plain(call: &DrawCall) -> bool {
    call.shade == ShadeMode::Wire || call.stages.is_some() || call.fill != FillStyle::default()
}

/// Returns whether every pixel of a call's faces is shaded once, however many of them cover it:
/// they are opaque and tested by depth.
fn is_shaded_once(call: &DrawCall) -> bool {
    let Geometry { mesh, textures } = call.geometry;
    let mut materials = mesh.materials.iter().chain(call.back_material).chain([call.material]);
    let mut textures = textures.iter().filter_map(|t| t.as_deref()).chain(call.texture);
    call.hide == HiddenSurface::ZBuffer
        && !is_plain(call)
        && mesh.colors.is_empty()
        && materials.all(|m| m.transparency <= 0.0)
        && !textures.any(Texture::has_alpha)
}

/// Estimates the nanoseconds of a draw on one thread, rather too many than too few, wherever its
/// faces lie; `pixels` bounds their pixels by the projection from object space and the viewport.
/// `None` if there is no bound, and for wireframes.
pub(super) fn bound_ns(
    call: &DrawCall,
    frame: u64,
    pixels: impl FnOnce(&DMat4, [f64; 2]) -> Option<CoverageBound>,
) -> Option<u64> {
    if call.shade == ShadeMode::Wire {
        return None;
    }
    let view = [call.viewport.width, call.viewport.height].map(f64::from);
    let camera = call.camera.matrices(view[0].max(1.0) / view[1].max(1.0)).ok()?;
    let CoverageBound { covered, boxed } = pixels(&(camera.projection * camera.view * call.model), view)?;
    let (boxed, faces) = (boxed.min(frame as f64), call.geometry.mesh.triangles.len() as f64);
    // A face covers a centre more than its area at most, in the mean.
    let covered = (covered + faces).min(boxed * faces);
    let shaded = if is_shaded_once(call) { covered.min(boxed) } else { covered };
    let pixels_ns = (covered * RASTER_NS + shaded * pixel_ns(call) as f64) as u64;
    Some(items_ns(call).saturating_add(lit_items_ns(call)).saturating_add(pixels_ns))
}

/// Estimates the nanoseconds of the light of a draw's vertices or faces.
fn lit_items_ns(call: &DrawCall) -> u64 {
    let mesh = &call.geometry.mesh;
    let items = match call.shade {
        ShadeMode::Gouraud => mesh.positions.len().max(mesh.normals.len()),
        ShadeMode::Flat => mesh.polygons.len(),
        ShadeMode::Phong | ShadeMode::Wire => 0,
    };
    (items as u64).saturating_mul(LIGHT_NS * call.lights.len() as u64)
}

/// Returns an upper bound of the pixels that faces and lines cover, each of them counted by itself;
/// any number above `most` if there are more.
fn covered_pixels(call: &DrawCall, frame: u64, most: u64) -> u64 {
    let mesh = &call.geometry.mesh;
    let view = [call.viewport.width, call.viewport.height].map(f64::from);
    let whole = (view[0] * view[1]).min(frame as f64) as u64;
    // A line is as long as the longer side; a wide one covers that times its width.
    let edges = if call.shade == ShadeMode::Wire { 3 * mesh.triangles.len() } else { 0 };
    let width = u64::from(call.line.width.max(1));
    let line = ((view[0].max(view[1]) as u64).min(frame)).saturating_mul(width).min(whole);
    let lines = ((mesh.lines.len() + edges) as u64).saturating_mul(line);
    let faces = mesh.triangles.len();
    let Ok(camera) = call.camera.matrices(view[0].max(1.0) / view[1].max(1.0)) else { return 0 };
    if faces > FEW_FACES {
        return lines.saturating_add(whole.saturating_mul(faces as u64));
    }
    let to_clip = camera.projection * camera.view * call.model;
    let mut sum = lines;
    for triangle in &mesh.triangles {
        sum = sum.saturating_add(face_box(call, triangle, &to_clip, view).min(whole));
        if sum > most {
            break;
        }
    }
    sum
}

/// Returns the pixels of a face's bounding box within a viewport of these sides, rounded up.
fn face_box(call: &DrawCall, triangle: &[u32; 3], to_clip: &DMat4, view: [f64; 2]) -> u64 {
    let mesh = &call.geometry.mesh;
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for corner in triangle {
        let position =
            mesh.corners.get(*corner as usize).and_then(|c| mesh.positions.get(c.position as usize));
        // A mesh with a wrong index is refused later.
        let Some(position) = position else { return 0 };
        let clip = *to_clip * position.extend(1.0);
        if clip.w.is_nan() || clip.w <= 0.0 {
            return u64::MAX;
        }
        let at = [clip.x / clip.w, clip.y / clip.w];
        (low, high) = ([0, 1].map(|i| low[i].min(at[i])), [0, 1].map(|i| high[i].max(at[i])));
    }
    let side = |i: usize| (high[i].min(1.0) - low[i].max(-1.0)).max(0.0) * view[i] / 2.0 + 1.0;
    (side(0) * side(1)) as u64
}

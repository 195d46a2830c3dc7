//! A 3-D draw with everything that it needs, so that it can run on the render thread or on another
//! one; and an estimate of its time.
//!
//! In: resources, session state and settings, resolved when the command begins. Out: a
//! [`Drawing`], which draws the same whoever runs it, and an upper bound of its time by which long
//! draws are told from short ones. The bound must not miss a draw that takes long: one would know
//! by `benches/waits.py`, where another client then waits.

use fbptr_command::Command;
use fbptr_core::memory::Reservation;
use fbptr_core::pipeline::{
    ClipTransform, CoverageBound, DrawCall, DrawStats, NdcBox, PipelineError, Renderer, SceneOptions, Target,
};
use fbptr_core::scene::{
    Camera, Cull, FillStyle, Filter, Geometry, HiddenSurface, Interpolation, Light, Material, Sampling,
    Scene, ShadeMode, Texture, Viewport,
};
use glam::{DMat4, DVec3};
use std::fmt;
use std::sync::Arc;

/// A `DRAW` or a `DRAWSCENE`.
pub(crate) enum Drawing {
    Mesh(Box<MeshDraw>),
    Scene(Box<SceneDraw>),
}

/// A `DRAW`: its mesh, and the settings of its session.
pub(crate) struct MeshDraw {
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
    /// Largest error of interpolated light, in steps of 1/255; `None` for less than can be seen.
    pub light_error: Option<f64>,
    /// Set if the draw is certainly black, whatever `QUALITY` makes of it.
    pub is_dark: bool,
    /// Rectangle around the mesh on the screen, if it was computed.
    pub ndc_box: Option<NdcBox>,
    /// The session's own modes, which `STATS` names.
    pub asked: (ShadeMode, HiddenSurface),
}

/// A `DRAWSCENE`: its scene at a time.
pub(crate) struct SceneDraw {
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
            light_error: self.light_error,
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
/// Estimated nanoseconds of a pixel of a face's perimeter: of the tiles and rows that a long, thin
/// face passes through.
const EDGE_PIXEL_NS: f64 = 5.0;
/// Estimated nanoseconds of a pixel's texture by the tile renderer, with texels far from each other.
const TILE_TEXTURE_NS: u64 = 50;

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
    pub fn sum_of_calls(&self, frame: u64, figure: &mut dyn FnMut(&DrawCall) -> Option<u64>) -> Option<u64> {
        match self {
            Drawing::Mesh(draw) => figure(&draw.call()),
            Drawing::Scene(draw) => {
                let SceneDraw { scene, options, .. } = &**draw;
                scene.objects.iter().try_fold(backdrop_ns(scene, frame), |sum, object| {
                    let call = DrawCall::of_object(object, scene, options);
                    Some(figure(&call)?.saturating_add(sum).saturating_add(OBJECT_NS))
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
            Drawing::Mesh(draw) => draw_ns(&draw.call(), frame, draw.ndc_box),
            Drawing::Scene(draw) => {
                let SceneDraw { scene, options, .. } = &**draw;
                let mut sum = backdrop_ns(scene, frame);
                for object in &scene.objects {
                    if sum > LONG_NS {
                        break;
                    }
                    let call = DrawCall::of_object(object, scene, options);
                    sum = sum.saturating_add(OBJECT_NS + draw_ns(&call, frame, None));
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

/// Estimates the nanoseconds of a draw on one thread, rather too many than too few. `ndc_box` is the
/// rectangle around its mesh on the screen, if it was computed.
fn draw_ns(call: &DrawCall, frame: u64, ndc_box: Option<NdcBox>) -> u64 {
    let (items, pixel_ns) = (items_ns(call), pixel_ns(call) + texture_ns(call));
    if items > LONG_NS {
        return items;
    }
    let most = (LONG_NS / pixel_ns).saturating_add(1);
    items + covered_pixels(call, frame, most, ndc_box).saturating_mul(pixel_ns)
}

/// Estimates the nanoseconds of a draw's faces, lines and points beside their pixels.
pub(super) fn items_ns(call: &DrawCall) -> u64 {
    let mesh = &call.geometry.mesh;
    let is_ordered = call.hide == HiddenSurface::Painter || call.shade == ShadeMode::Wire;
    let face_ns = if is_ordered { ORDERED_FACE_NS } else { FACE_NS };
    let figures = (mesh.lines.len() + mesh.points.len()) as u64 * ORDERED_FACE_NS;
    mesh.triangles.len() as u64 * face_ns + mesh.positions.len() as u64 * FACE_NS + figures
}

/// Estimates the nanoseconds of a pixel of a draw without its texture.
fn pixel_ns(call: &DrawCall) -> u64 {
    let lights = if call.shade == ShadeMode::Phong { call.lights.len() as u64 } else { 0 };
    let pixel = if is_plain(call) { PLAIN_PIXEL_NS } else { PIXEL_NS };
    pixel + LIGHT_NS * lights
}

/// Returns whether a draw may be textured.
fn has_texture(call: &DrawCall) -> bool {
    call.texture.is_some() || call.geometry.textures.iter().any(Option::is_some)
}

/// Estimates the nanoseconds of a pixel's texture by the paths for blended faces, which take the most.
fn texture_ns(call: &DrawCall) -> u64 {
    match call.sampling.filter {
        _ if !has_texture(call) => 0,
        Filter::Nearest => 40,
        Filter::Bilinear => 80,
        Filter::Mipmap => 120,
        Filter::Trilinear => 180,
    }
}

/// Returns whether only the plain path draws a call's faces.
fn is_plain(call: &DrawCall) -> bool {
    call.shade == ShadeMode::Wire
        || call.stages.is_some()
        || call.maps.is_some()
        || call.fill != FillStyle::default()
}

/// Returns an upper bound of the nanoseconds that the tile renderer takes for a draw on one thread.
pub(super) fn bound_ns(call: &DrawCall, frame: u64, coverage: CoverageBound) -> u64 {
    let CoverageBound { covered, perimeter, boxed } = coverage;
    // With a depth test every pixel is shaded once, however many faces cover it.
    let shaded =
        if call.hide == HiddenSurface::ZBuffer { covered.min(boxed).min(frame as f64) } else { covered };
    let texture_ns = if has_texture(call) { TILE_TEXTURE_NS } else { 0 };
    let shading = shaded * (pixel_ns(call) + texture_ns) as f64;
    let pixels = covered * RASTER_NS + perimeter * EDGE_PIXEL_NS + shading;
    items_ns(call).saturating_add(lit_items_ns(call)).saturating_add(pixels as u64)
}

/// Estimates the nanoseconds of the light of a draw's vertices or faces.
fn lit_items_ns(call: &DrawCall) -> u64 {
    let mesh = &call.geometry.mesh;
    let items = match call.shade {
        ShadeMode::Gouraud => mesh.corners.len(),
        ShadeMode::Flat => mesh.triangles.len(),
        ShadeMode::Phong | ShadeMode::Wire => 0,
    };
    (items as u64).saturating_mul(LIGHT_NS * call.lights.len() as u64)
}

/// Returns an upper bound of the pixels that faces and lines cover, each of them counted by itself;
/// any number above `most` if there are more.
fn covered_pixels(call: &DrawCall, frame: u64, most: u64, ndc_box: Option<NdcBox>) -> u64 {
    let mesh = &call.geometry.mesh;
    let view = [call.viewport.width, call.viewport.height].map(f64::from);
    let viewport_area = (view[0] * view[1]).min(frame as f64) as u64;
    // A line is as long as the longer side; a wide one covers that times its width.
    let edges = if call.shade == ShadeMode::Wire { 3 * mesh.triangles.len() } else { 0 };
    let width = u64::from(call.line.width.max(1));
    let line = ((view[0].max(view[1]) as u64).min(frame)).saturating_mul(width).min(viewport_area);
    let lines = ((mesh.lines.len() + edges) as u64).saturating_mul(line);
    let square = u64::from(call.point_shape.largest_side(call.point_size)).pow(2);
    let lines = lines.saturating_add((square - 1).saturating_mul(mesh.points.len() as u64));
    let faces = mesh.triangles.len();
    // Each face covers at most what all of them do, which is little in most draws.
    let within = |boxed: NdcBox| {
        let pixels = (boxed.pixels(view) as u64).min(viewport_area).saturating_mul(faces as u64);
        Some(lines.saturating_add(pixels)).filter(|sum| *sum <= most)
    };
    if let Some(sum) = ndc_box.filter(|_| faces <= FEW_FACES).and_then(within) {
        return sum;
    }
    let Ok(camera) = call.camera.matrices(view[0].max(1.0) / view[1].max(1.0)) else { return 0 };
    if faces > FEW_FACES {
        return lines.saturating_add(viewport_area.saturating_mul(faces as u64));
    }
    let to_clip = ClipTransform::of(&camera).after(&call.model);
    let bounds = if mesh.positions.len() <= 3 * faces { mesh.bounds() } else { None };
    if let Some(sum) = bounds.and_then(|bounds| NdcBox::of(bounds, &to_clip)).and_then(within) {
        return sum;
    }
    let mut sum = lines;
    for triangle in &mesh.triangles {
        sum = sum.saturating_add(face_box(call, triangle, &to_clip, view).min(viewport_area));
        if sum > most {
            break;
        }
    }
    sum
}

/// Returns the pixels of a face's bounding box within a viewport of these sides, rounded up.
fn face_box(call: &DrawCall, triangle: &[u32; 3], to_clip: &ClipTransform, view: [f64; 2]) -> u64 {
    let mesh = &call.geometry.mesh;
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for corner in triangle {
        let position =
            mesh.corners.get(*corner as usize).and_then(|c| mesh.positions.get(c.position as usize));
        // A mesh with a wrong index is refused later.
        let Some(position) = position else { return 0 };
        let Some(clip) = to_clip.project(*position) else { return u64::MAX };
        let at = [clip.x / clip.w, clip.y / clip.w];
        (low, high) = ([0, 1].map(|i| low[i].min(at[i])), [0, 1].map(|i| high[i].max(at[i])));
    }
    let side = |i: usize| (high[i].min(1.0) - low[i].max(-1.0)).max(0.0) * view[i] / 2.0 + 1.0;
    (side(0) * side(1)) as u64
}

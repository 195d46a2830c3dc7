//! Trace of one triangle, and of one pixel of it: every value on the way from object space to
//! bytes.
//!
//! In: a [`DrawCall`] or a [`Scene`], the frame, and the triangle or pixel to follow. Out: a
//! [`Trace`] whose `Display` prints the values stage by stage, so that a student can follow by
//! hand. The values come from the stages of the plain path themselves, and the last line is the
//! bytes that they store. The tests draw the same call and compare with the memory.
//!
//! Source: notes 000 (stages, Phong), 001 (matrices, homogenisation, viewport), 003 (barycentrics,
//! depth, mip level).

mod collect;
mod display;
mod fast;

use super::draw_call::{Backend, DrawCall, DrawStats, PipelineError, SceneOptions, Target};
use super::light::{LightTerm, SurfacePoint};
use super::path_plan::add_path;
use super::prepared_draw::PreparedDraw;
use super::sampler::Footprint;
use super::scene::calls_of;
use crate::math::projection::ViewingTransformation;
use crate::memory::{DepthFormat, FbPtr, MemoryError, Rgba, VideoMemory};
use crate::scene::{CameraMatrices, Material, Scene, ShadeMode};
use collect::{follow, middle_pixel, seen_at};
pub use fast::{FastCorner, FastTrace};
use glam::{DMat4, DVec2, DVec3, DVec4};
use std::error::Error;
use std::fmt;

/// Selects the triangle or pixel to follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Probe {
    /// The triangle with this index, counted from 0 over all objects in file order, at the covered
    /// pixel nearest to its middle.
    Triangle(u64),
    /// The triangle with this index at a pixel (x, y), covered or not.
    TriangleAt(u64, i32, i32),
    /// The triangle that gives pixel (x, y) its colour.
    Pixel(i32, i32),
}

/// Reason why a trace failed.
#[derive(Debug)]
pub enum TraceError {
    /// The scene cannot be drawn.
    Pipeline(PipelineError),
    /// The frame cannot be created.
    Memory(MemoryError),
    /// The triangle index is out of range.
    NoTriangle {
        /// The requested index.
        asked: u64,
        /// Number of triangles.
        count: u64,
    },
    /// No triangle gives this pixel its colour.
    NothingThere {
        /// Column.
        x: i32,
        /// Row.
        y: i32,
    },
}

impl fmt::Display for TraceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TraceError::Pipeline(e) => write!(f, "{e}"),
            TraceError::Memory(e) => write!(f, "{e}"),
            TraceError::NoTriangle { asked, count } => {
                write!(f, "expected a triangle below {count}, found {asked}")
            }
            TraceError::NothingThere { x, y } => write!(f, "no triangle gives pixel ({x}, {y}) its colour"),
        }
    }
}

impl Error for TraceError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            TraceError::Pipeline(e) => e.source(),
            _ => None,
        }
    }
}

impl From<PipelineError> for TraceError {
    fn from(e: PipelineError) -> Self {
        TraceError::Pipeline(e)
    }
}

impl From<MemoryError> for TraceError {
    fn from(e: MemoryError) -> Self {
        TraceError::Memory(e)
    }
}

/// One corner in every space.
#[derive(Clone, Copy, Debug)]
pub struct CornerTrace {
    /// Index of the position in the mesh.
    pub position: u32,
    /// Object space.
    pub object: DVec3,
    /// World space.
    pub world: DVec3,
    /// View space: x right, y up, looking along -z.
    pub view: DVec3,
    /// Clip space: -w<=x<=w, -w<=y<=w, 0<=z<=w.
    pub clip: DVec4,
    /// Normalized device coordinates, x and y in -1..1, z in 0..1; not finite where w <= 0.
    pub ndc: DVec3,
    /// Screen position in pixels, y down, pixel centres at .5.
    pub screen: [f64; 2],
    /// Snapped position in 1/256 pixel, on which coverage is decided; `None` beyond 262,144 pixels
    /// or behind the eye.
    pub snapped: Option<[i64; 2]>,
    /// Unit normal in world space.
    pub normal: DVec3,
    /// Texture coordinates u and v.
    pub texcoord: Option<DVec2>,
}

/// Contributions of the lights at one point: the pixel, the face's middle or a corner, depending on
/// the shading mode.
pub(crate) struct LitAt {
    /// Name of the point in the printed trace.
    pub place: &'static str,
    pub point: SurfacePoint,
    /// V, the unit vector to the viewer.
    pub to_viewer: DVec3,
    /// Terms of each light that reaches the point.
    pub terms: Vec<LightTerm>,
    pub diffuse_ambient: DVec3,
    pub specular_emissive: DVec3,
}

/// Texture sample at the pixel.
pub(crate) struct Texel {
    /// Texture coordinates.
    pub uv: DVec2,
    /// Width and height of level 0 in texels.
    pub size: [u32; 2],
    /// Distance to the pixel on the right and to the one below, and D, the level of detail that
    /// follows, not clamped.
    pub footprint: Footprint,
    pub level: f64,
    /// R, G, B, A in 0..1.
    pub color: [f64; 4],
}

/// One pixel of the triangle.
pub struct PixelTrace {
    /// Column and row.
    pub at: [i32; 2],
    /// The pixel's centre in NDC.
    pub ndc: [f64; 2],
    /// The three edge functions in 1/65536 square pixels, edge i opposite corner i, with the sign
    /// that is positive inside.
    pub edges: Option<[i128; 3]>,
    /// True if the exact fill rule gives the pixel to the triangle.
    pub is_covered: bool,
    /// Barycentrics linear on the screen.
    pub screen_weights: [f64; 3],
    /// Perspective-correct barycentrics.
    pub weights: [f64; 3],
    /// 1/w.
    pub inverse_w: f64,
    /// Depth in 0..1.
    pub z: f64,
    /// Stored depth word.
    pub depth_word: u32,
    /// Format of the depth word.
    pub depth_format: DepthFormat,
    /// Interpolated normal before normalization, if pixels are lit.
    pub normal: Option<DVec3>,
    pub(crate) lit: Vec<LitAt>,
    pub(crate) texel: Option<Texel>,
    /// R, G, B before clamping.
    pub color: DVec3,
    /// Opacity; 1 is opaque.
    pub opacity: f64,
    /// Stored bytes; over black if the face is transparent.
    pub bytes: Rgba,
    /// Address of the pixel; `None` off the frame.
    pub offset: Option<FbPtr>,
}

/// All values of one triangle, and of one pixel of it.
pub struct Trace {
    /// Index and name of the object.
    pub object: (usize, String),
    /// Indices of the triangle and its polygon in the mesh.
    pub triangle: (u32, u32),
    /// Object to world space.
    pub model: DMat4,
    /// World to view to clip space.
    pub camera: CameraMatrices,
    /// The matrices A, B, C, D and P of source 000, if the camera is a viewing transformation.
    pub viewing: Option<ViewingTransformation>,
    /// NDC to pixels: M2.
    pub to_screen: DMat4,
    /// Width and height of the frame in pixels.
    pub frame: [u32; 2],
    /// Shading mode.
    pub shade: ShadeMode,
    /// The three corners.
    pub corners: [CornerTrace; 3],
    /// The triangle clipped by the six planes of the view, as in a textbook; in clip space.
    pub clipped: Vec<DVec4>,
    /// Twice the area in 1/65536 square pixels; positive when clockwise on the screen.
    pub doubled_area: Option<i128>,
    /// Outcome of culling and clipping.
    pub verdict: &'static str,
    /// Unit normal in world space.
    pub face_normal: DVec3,
    /// Material of the visible side.
    pub material: Material,
    /// Ambient light.
    pub ambient: DVec3,
    /// The pixel; `None` if no pixel was selected, or the face is not drawn or has no visible point
    /// there.
    pub pixel: Option<PixelTrace>,
    /// Values of the tile renderer.
    pub fast: Option<FastTrace>,
}

impl Trace {
    /// Returns M1, world to clip space: P D C B A of a viewing transformation, otherwise the product
    /// of projection and view.
    pub fn m1(&self) -> DMat4 {
        self.viewing.map_or_else(|| self.camera.projection * self.camera.view, |t| t.m1())
    }

    /// Returns A, B, C and D of the face's plane in eye space, Ax + By + Cz + D = 0, where the eye is
    /// the origin: it is in front of the face where D is above 0. (A, B, C) is not normalized. `None`
    /// for parallel projections, whose eye is at no point.
    pub fn eye_plane(&self) -> Option<DVec4> {
        let [a, b, c] = [0, 1, 2].map(|i| self.corners[i].view);
        let normal = (b - a).cross(c - a);
        (!self.camera.is_parallel).then(|| normal.extend(-normal.dot(a)))
    }
}

/// Traces one triangle or pixel of a scene, as [`super::draw_scene`] would draw it into a frame of
/// `size`.
///
/// # Errors
/// As [`super::draw_scene`], when the frame cannot be created, and when the probe finds no
/// triangle.
pub fn trace_scene(
    scene: &Scene,
    options: &SceneOptions,
    size: [u32; 2],
    format: DepthFormat,
    probe: Probe,
) -> Result<Trace, TraceError> {
    let calls = calls_of(scene, options);
    let names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    trace_calls(&calls, &names, options, size, format, probe)
}

/// Gives `ask` a function that traces triangles of a scene, by their index as in [`Probe::Triangle`],
/// at pixels (x, y); it returns `None` where the triangle is not drawn or does not cover the pixel.
///
/// # Errors
/// As [`super::draw_scene`], and when the frame cannot be created.
pub fn trace_pixels<R>(
    scene: &Scene,
    options: &SceneOptions,
    size: [u32; 2],
    format: DepthFormat,
    ask: impl FnOnce(&dyn Fn(u64, [i32; 2]) -> Option<PixelTrace>) -> R,
) -> Result<R, TraceError> {
    let calls = calls_of(scene, options);
    let all = prepare(&calls, size, format)?;
    Ok(ask(&|number, at| {
        let (object, triangle) = numbered(&all, number).ok()?;
        let trace = follow(&all[object], (object, String::new()), triangle, Some(at), size, format);
        trace.pixel.filter(|pixel| pixel.is_covered)
    }))
}

/// Traces one triangle or pixel of a single draw into a frame of `size`.
///
/// # Errors
/// As [`super::draw`], when the frame cannot be created, and when the probe finds no triangle.
pub fn trace_draw(
    call: &DrawCall,
    size: [u32; 2],
    format: DepthFormat,
    probe: Probe,
) -> Result<Trace, TraceError> {
    let options =
        SceneOptions { hide: call.hide, interp: call.interp, ..SceneOptions::new(size[0], size[1]) };
    trace_calls(std::slice::from_ref(call), &[], &options, size, format, probe)
}

fn trace_calls(
    calls: &[DrawCall],
    names: &[&str],
    options: &SceneOptions,
    size: [u32; 2],
    format: DepthFormat,
    probe: Probe,
) -> Result<Trace, TraceError> {
    let all = prepare(calls, size, format)?;
    let (object, triangle, at) = match probe {
        Probe::Triangle(n) => {
            let (object, triangle) = numbered(&all, n)?;
            (object, triangle, middle_pixel(&all[object], triangle))
        }
        Probe::TriangleAt(n, x, y) => {
            let (object, triangle) = numbered(&all, n)?;
            (object, triangle, Some([x, y]))
        }
        Probe::Pixel(x, y) => {
            let (object, triangle) =
                seen_at(&all, options, size, format, [x, y]).ok_or(TraceError::NothingThere { x, y })?;
            (object, triangle, Some([x, y]))
        }
    };
    let name = names.get(object).copied().unwrap_or_default();
    let mut trace = follow(&all[object], (object, name.to_owned()), triangle, at, size, format);
    trace.fast = fast::fast(&all[object], triangle, at, size, format);
    Ok(trace)
}

/// Prepares the draws of a frame.
fn prepare<'a>(
    calls: &'a [DrawCall<'a>],
    size: [u32; 2],
    format: DepthFormat,
) -> Result<Vec<PreparedDraw<'a>>, TraceError> {
    // Planning requires a target; nothing is written to it.
    let mut memory = VideoMemory::new(size[0], size[1])?;
    let mut depth = None;
    let target = Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: None };
    let prepared = calls.iter().map(|call| PreparedDraw::new(call, &target, &mut DrawStats::default()));
    let mut all = prepared.collect::<Result<Vec<_>, _>>()?;
    all.iter_mut().for_each(|p| add_path(p, &target, Backend::default(), true));
    Ok(all)
}

/// Returns object and triangle of an index that counts over all objects.
fn numbered(all: &[PreparedDraw], asked: u64) -> Result<(usize, u32), TraceError> {
    let mut left = asked;
    for (object, p) in all.iter().enumerate() {
        let count = p.call.geometry.mesh.triangles.len() as u64;
        if left < count {
            return Ok((object, left as u32));
        }
        left -= count;
    }
    Err(TraceError::NoTriangle { asked, count: asked - left })
}

#[cfg(test)]
mod tests;

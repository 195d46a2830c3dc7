//! The textbook mode: every number that one triangle, and one pixel of it, has on its way from
//! object space to bytes.
//!
//! In: a [`DrawCall`] or a [`Scene`], the frame, and which triangle or pixel is asked for. Out: a
//! [`Trace`] whose `Display` prints the numbers stage by stage, so that a student can follow by
//! hand. They are not computed again for the print: the stages of the plain path are asked, and the
//! last line is the byte that they store. One would know an error by drawing the same call and
//! looking into the memory, as the tests do.
//!
//! Source: notes 000 (stages, Phong), 001 (matrices, homogenisation, viewport), 003 (barycentrics,
//! depth, mip level).

mod collect;
mod display;
mod fast;

use super::draw_call::{DrawCall, DrawStats, PipelineError, SceneOptions, Target};
use super::light::{LightTerm, SurfacePoint};
use super::prepared_draw::PreparedDraw;
use super::scene::calls_of;
use crate::memory::{DepthFormat, FbPtr, MemoryError, Rgba, VideoMemory};
use crate::scene::{CameraMatrices, Material, Scene, ShadeMode};
use collect::{follow, middle_pixel, seen_at};
pub use fast::{FastCorner, FastTrace};
use glam::{DMat4, DVec2, DVec3, DVec4};

/// What is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Probe {
    /// The triangle of this number, counted from 0 over all objects in file order, at the pixel
    /// nearest to its middle.
    Triangle(u64),
    /// The triangle of this number at a pixel (x, y), covered or not.
    TriangleAt(u64, i32, i32),
    /// Whatever gives pixel (x, y) its colour.
    Pixel(i32, i32),
}

/// Why nothing can be followed.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// The scene can't be drawn.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The frame can't be had.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// There is no such triangle.
    #[error("expected a triangle below {count}, found {asked}")]
    NoTriangle {
        /// The triangle asked for.
        asked: u64,
        /// How many there are.
        count: u64,
    },
    /// No triangle gives this pixel its colour.
    #[error("no triangle gives pixel ({x}, {y}) its colour")]
    NothingThere {
        /// Column.
        x: i32,
        /// Row.
        y: i32,
    },
}

/// One corner in every space.
#[derive(Clone, Copy, Debug)]
pub struct CornerTrace {
    /// Which position of the mesh it is.
    pub position: u32,
    /// Object space.
    pub object: DVec3,
    /// World space.
    pub world: DVec3,
    /// View space: x right, y up, looking along -z.
    pub view: DVec3,
    /// Clip space: -w<=x<=w, -w<=y<=w, 0<=z<=w.
    pub clip: DVec4,
    /// Normalised device coordinates, x and y in -1..1, z in 0..1; not finite where w <= 0.
    pub ndc: DVec3,
    /// Pixels, y down, centres at .5.
    pub screen: [f64; 2],
    /// In 1/256 pixel, where coverage is decided; `None` beyond 262,144 pixels or behind the eye.
    pub snapped: Option<[i64; 2]>,
    /// Unit, world space.
    pub normal: DVec3,
    /// u and v.
    pub texcoord: Option<DVec2>,
}

/// What one light adds at the pixel (or the face's middle, or a corner: wherever the shading mode
/// lights).
pub(crate) struct LitAt {
    pub place: &'static str,
    pub point: SurfacePoint,
    pub to_viewer: DVec3,
    pub terms: Vec<LightTerm>,
    pub diffuse_ambient: DVec3,
    pub specular_emissive: DVec3,
}

/// A texture at the pixel.
pub(crate) struct Texel {
    pub uv: DVec2,
    pub size: [u32; 2],
    pub level: f64,
    pub color: [f64; 4],
}

/// One pixel of the triangle.
pub struct PixelTrace {
    /// Column and row.
    pub at: [i32; 2],
    /// The centre in NDC.
    pub ndc: [f64; 2],
    /// The three edge functions in 1/65536 square pixels, edge i opposite corner i, turned so that
    /// inside is positive.
    pub edges: Option<[i128; 3]>,
    /// Whether the exact fill rule gives the pixel to the triangle.
    pub is_covered: bool,
    /// Barycentrics straight on the screen.
    pub screen_weights: [f64; 3],
    /// Perspective-correct ones.
    pub weights: [f64; 3],
    /// 1/w.
    pub inverse_w: f64,
    /// Depth in 0..1.
    pub z: f64,
    /// Its stored word.
    pub depth_word: u32,
    /// The format of the word.
    pub depth_format: DepthFormat,
    /// Interpolated normal before it is made unit, where pixels are lit.
    pub normal: Option<DVec3>,
    pub(crate) lit: Vec<LitAt>,
    pub(crate) texel: Option<Texel>,
    /// R, G, B, before they are clamped.
    pub color: DVec3,
    /// 1 opaque.
    pub opacity: f64,
    /// The bytes, over black where the face lets light through.
    pub bytes: Rgba,
    /// Where they are stored.
    pub offset: Option<FbPtr>,
}

/// Everything about one triangle, and one pixel of it.
pub struct Trace {
    /// The object's name and number.
    pub object: (usize, String),
    /// The triangle in its mesh, and its polygon.
    pub triangle: (u32, u32),
    /// Object to world space.
    pub model: DMat4,
    /// World to view to clip space.
    pub camera: CameraMatrices,
    /// The frame's width and height.
    pub frame: [u32; 2],
    /// How it is coloured.
    pub shade: ShadeMode,
    /// The three corners.
    pub corners: [CornerTrace; 3],
    /// The triangle cut by the six planes of the view, as a textbook cuts it; in clip space.
    pub clipped: Vec<DVec4>,
    /// Twice the area in 1/65536 square pixels; positive when clockwise on the screen.
    pub doubled_area: Option<i128>,
    /// What became of the face.
    pub verdict: &'static str,
    /// Unit, world space.
    pub face_normal: DVec3,
    /// What it is made of.
    pub material: Material,
    /// The ambient light.
    pub ambient: DVec3,
    /// The pixel, where the face has a plane.
    pub pixel: Option<PixelTrace>,
    /// The same as the fast path has it.
    pub fast: Option<FastTrace>,
}

/// Follows one triangle or pixel through a scene, as [`super::draw_scene`] would draw it into a
/// frame of `size`.
///
/// # Errors
/// What `draw_scene` refuses, and a probe that meets nothing.
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

/// Follows one triangle or pixel of a single draw into a frame of `size`.
///
/// # Errors
/// What [`super::draw`] refuses, and a probe that meets nothing.
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
    // The plans look at a target; nothing is written to it.
    let mut memory = VideoMemory::new(size[0], size[1])?;
    let mut depth = None;
    let target = Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: None };
    let prepared = calls.iter().map(|call| PreparedDraw::new(call, &target, &mut DrawStats::default()));
    let all = prepared.collect::<Result<Vec<_>, _>>()?;
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

/// The object and triangle of a number that counts over all objects.
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

//! The textbook mode: every number that one triangle, and one pixel of it, has on its way from object space to bytes.
//!
//! In: a [`DrawCall`] or a [`Scene`], the frame, and which triangle or pixel is asked for. Out: a [`Trace`] whose `Display`
//! prints the numbers stage by stage, so that a student can follow by hand. They are not computed again for the print: the
//! stages of the plain path are asked, and the last line is the byte that they store. One would know an error by drawing the
//! same call and looking into the memory, as the tests do.
//!
//! Source: notes 000 (stages, Phong), 001 (matrices, homogenisation, viewport), 003 (barycentrics, depth, mip level).

mod write;

use super::assemble::{Face, Side};
use super::call::{DrawCall, DrawStats, PipelineError, SceneOptions, Target};
use super::clip::{ClipVertex, clip_polygon};
use super::light::{LightTerm, SurfacePoint};
use super::plane::Weights;
use super::prepare::Prepared;
use super::raster::{footprint, opaque};
use super::sample::sample;
use super::shade::{FaceShade, LightMode, uv_from_first};
use super::whole::{calls_of, drawing_order};
use crate::math::coverage::{PixelRect, SnappedTriangle};
use crate::math::matrix::unit;
use crate::memory::{DepthFormat, DepthMemory, FbPtr, MemoryError, Rgba, VideoMemory};
use crate::scene::{CameraMatrices, Interpolation, Material, Scene, ShadeMode};
use glam::{DMat4, DVec2, DVec3, DVec4};

/// What is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Probe {
    /// The triangle of this number, counted from 0 over all objects in file order, at the pixel nearest to its middle.
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

/// What one light adds at the pixel (or the face's middle, or a corner: wherever the shading mode lights).
pub(crate) struct LitAt {
    pub place: &'static str,
    pub point: SurfacePoint,
    pub to_viewer: DVec3,
    pub terms: Vec<LightTerm>,
    pub base: DVec3,
    pub extra: DVec3,
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
    /// The three edge functions in 1/65536 square pixels, edge i opposite corner i, turned so that inside is positive.
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
}

/// Follows one triangle or pixel through a scene, as [`super::draw_scene`] would draw it into a frame of `size`.
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
    let prepared = calls.iter().map(|call| Prepared::new(call, &target, &mut DrawStats::default()));
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
    Ok(follow(&all[object], (object, name.to_owned()), triangle, at, size, format))
}

/// The object and triangle of a number that counts over all objects.
fn numbered(all: &[Prepared], asked: u64) -> Result<(usize, u32), TraceError> {
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

/// The covered pixel nearest to the middle of what is covered.
fn middle_pixel(p: &Prepared, triangle: u32) -> Option<[i32; 2]> {
    let corners = p.corner_vertices(triangle);
    let face = p.assembler.face(corners, &mut DrawStats::default())?;
    let mut rows: Vec<(i32, std::ops::Range<i32>)> = Vec::new();
    for outline in face.outlines.iter().flatten() {
        outline.for_each_span(p.transform().screen.clip, |y, xs| rows.push((y, xs)));
    }
    let count: i64 = rows.iter().map(|(_, xs)| xs.len() as i64).sum();
    if count == 0 {
        return None;
    }
    let sum_x: i64 =
        rows.iter().map(|(_, xs)| (xs.start as i64 + xs.end as i64 - 1) * xs.len() as i64 / 2).sum();
    let sum_y: i64 = rows.iter().map(|(y, xs)| *y as i64 * xs.len() as i64).sum();
    let (cx, cy) = ((sum_x / count) as i32, (sum_y / count) as i32);
    let nearest = |xs: &std::ops::Range<i32>| cx.clamp(xs.start, xs.end - 1);
    let distance = |&(y, ref xs): &(i32, std::ops::Range<i32>)| {
        let (dx, dy) = (i64::from(nearest(xs) - cx), i64::from(y - cy));
        dx * dx + dy * dy
    };
    rows.iter().min_by_key(|row| distance(row)).map(|(y, xs)| [nearest(xs), *y])
}

/// What gives a pixel its colour: the last face that passes there, in the order of drawing.
fn seen_at(
    all: &[Prepared],
    options: &SceneOptions,
    size: [u32; 2],
    format: DepthFormat,
    at: [i32; 2],
) -> Option<(usize, u32)> {
    let is_on_frame =
        (0..size[0] as i64).contains(&at[0].into()) && (0..size[1] as i64).contains(&at[1].into());
    let mut nearest: Option<u32> = None;
    let mut seen = None;
    for (object, triangle) in drawing_order(all, options) {
        let p = &all[object];
        let Some(face) = p.assemble(triangle, &mut DrawStats::default()) else { continue };
        let Some((_, z, complement)) = point_of(p, &face, at).filter(|_| is_on_frame && covers(p, &face, at))
        else {
            continue;
        };
        let word = format.encode(z, complement.max(0.0));
        if p.plan.uses(super::plan::Part::DepthMemory) {
            let cleared = || DepthMemory::new(1, 1, format).word(0);
            if word >= nearest.unwrap_or_else(cleared) {
                continue;
            }
            if !p.is_transparent(triangle) {
                nearest = Some(word);
            }
        }
        seen = Some((object, triangle));
    }
    seen
}

fn covers(p: &Prepared, face: &Face, [x, y]: [i32; 2]) -> bool {
    let clip = p.transform().screen.clip;
    let is_inside = (clip.x0..clip.x1).contains(&x) && (clip.y0..clip.y1).contains(&y);
    let pixel = PixelRect { x0: x, y0: y, x1: x.saturating_add(1), y1: y.saturating_add(1) };
    let mut is_covered = false;
    for outline in face.outlines.iter().flatten() {
        outline.for_each_span(pixel, |_, _| is_covered = true);
    }
    is_inside && is_covered
}

/// The weights at a pixel with z and 1 - z, or `None` where the face has no point in front of near and before far.
fn point_of(p: &Prepared, face: &Face, [x, y]: [i32; 2]) -> Option<(Weights, f64, f64)> {
    let ndc = p.transform().screen.ndc_of_pixel(x, y);
    let weights = face.plane.clamped(face.plane.weights_at(ndc))?;
    let (z, complement) = face.plane.depth(&weights);
    match face.wholly_between_near_and_far {
        true => Some((weights, z.max(0.0), complement)),
        false => (0.0..1.0).contains(&z).then_some((weights, z, complement)),
    }
}

fn follow(
    p: &Prepared,
    object: (usize, String),
    triangle: u32,
    at: Option<[i32; 2]>,
    size: [u32; 2],
    format: DepthFormat,
) -> Trace {
    let mesh = &p.call.geometry.mesh;
    let camera = p.transform().camera;
    let vertices = p.corner_vertices(triangle);
    let face_normal = p.face_normal(triangle);
    let whole = SnappedTriangle::new(vertices.map(|v| v.screen));
    let is_on_screen = vertices.iter().all(|v| v.screen[0].is_finite() && v.screen[1].is_finite());
    let snapped = is_on_screen.then(|| whole.corners_fixed()).flatten();
    let ids = p.corners(triangle);
    let corner = |i: usize| {
        let object = mesh.positions[ids[i].position as usize];
        let world = p.transform().world(object);
        let v = vertices[i];
        CornerTrace {
            position: ids[i].position,
            object,
            world,
            view: (camera.view * world.extend(1.0)).truncate(),
            clip: v.clip,
            ndc: v.clip.truncate() / v.clip.w,
            screen: v.screen,
            snapped: snapped.map(|s| s[i]),
            normal: p.corner_normal(ids[i], face_normal),
            texcoord: mesh.texcoords.get(ids[i].texcoord as usize).copied(),
        }
    };
    let polygon: Vec<ClipVertex<0>> =
        vertices.iter().map(|v| ClipVertex { pos_clip: v.clip, varyings: [] }).collect();
    let mut stats = DrawStats::default();
    let face = p.assemble(triangle, &mut stats);
    let verdict = match &face {
        _ if stats.faces_outside > 0 => "wholly outside the view: left out",
        _ if stats.faces_culled > 0 => "turned away: left out by CULL",
        None => "no area on the screen, or not finite: left out",
        Some(f) if stats.faces_cut > 0 && f.side == Side::Front => "seen from its front, cut before the eye",
        Some(_) if stats.faces_cut > 0 => "seen from its back, cut before the eye",
        Some(f) if f.side == Side::Front => "seen from its front",
        Some(_) => "seen from its back",
    };
    let side = face.as_ref().map_or(Side::Front, |f| f.side);
    let polygon_number = p.polygon_of(triangle);
    let (material, _) = p.call.material_of(&mesh.polygons[polygon_number], side);
    Trace {
        object,
        triangle: (triangle, polygon_number as u32),
        model: p.call.model,
        camera,
        frame: size,
        shade: p.call.shade,
        corners: [corner(0), corner(1), corner(2)],
        clipped: clip_polygon(&polygon).into_iter().map(|v| v.pos_clip).collect(),
        doubled_area: snapped.map(|s| edge(s[0], s[1], s[2])),
        verdict,
        face_normal,
        material: material.clone(),
        ambient: p.lighting.ambient(),
        pixel: face.zip(at).and_then(|(face, at)| pixel(p, triangle, &face, at, snapped, size, format)),
    }
}

/// (b-a) x (p-a): twice the signed area of a, b, p, in the product of their units.
fn edge(a: [i64; 2], b: [i64; 2], p: [i64; 2]) -> i128 {
    let d = |q: [i64; 2], axis: usize| i128::from(q[axis]) - i128::from(a[axis]);
    d(b, 0) * d(p, 1) - d(b, 1) * d(p, 0)
}

fn pixel(
    p: &Prepared,
    triangle: u32,
    face: &Face,
    at: [i32; 2],
    snapped: Option<[[i64; 2]; 3]>,
    size: [u32; 2],
    format: DepthFormat,
) -> Option<PixelTrace> {
    let screen = &p.transform().screen;
    let (weights, z, complement) = point_of(p, face, at)?;
    let divide = p.plan.uses(super::plan::Part::PerspectiveDivision);
    let shares_of = |w: &Weights| face.plane.shares(w, p.call.interp, divide);
    let shares = shares_of(&weights)?;
    let center = [i64::from(at[0]) * 256 + 128, i64::from(at[1]) * 256 + 128];
    let edges = snapped.map(|s| {
        let turn = edge(s[0], s[1], s[2]).signum();
        [0, 1, 2].map(|i| edge(s[(i + 1) % 3], s[(i + 2) % 3], center) * turn)
    });
    let shade = p.shade(triangle, face.side, &mut DrawStats::default());
    let footprint = |uv: &[DVec2; 3]| footprint(&face.plane, screen, shares_of, at, uv);
    let (color, opacity) =
        shade.solid().unwrap_or_else(|| shade.at(shares, footprint, &p.lighting, &mut DrawStats::default()));
    let mut bytes = opaque(color);
    if shade.is_transparent {
        bytes = [0, 0, 0, 255];
        super::raster::blend(&mut bytes, color, opacity);
    }
    let texel = shade.texture.map(|(texture, sampling, uv)| {
        let here = uv[0] + uv_from_first(&uv, shares);
        let level = footprint(&uv).level(texture.width(), texture.height());
        Texel {
            uv: here,
            size: [texture.width(), texture.height()],
            level,
            color: sample(texture, sampling, here, || level),
        }
    });
    let is_on_frame = (0..size[0] as i32).contains(&at[0]) && (0..size[1] as i32).contains(&at[1]);
    Some(PixelTrace {
        at,
        ndc: screen.ndc_of_pixel(at[0], at[1]),
        edges,
        is_covered: covers(p, face, at),
        screen_weights: face.plane.shares(&weights, Interpolation::Affine, divide).unwrap_or(shares),
        weights: face.plane.shares(&weights, Interpolation::Perspective, divide).unwrap_or(shares),
        inverse_w: weights.values().iter().sum(),
        z,
        depth_word: format.encode(z, complement.max(0.0)),
        depth_format: format,
        normal: match &shade.light {
            LightMode::Pixels { normals, .. } => {
                Some(normals[0] * shares[0] + normals[1] * shares[1] + normals[2] * shares[2])
            }
            _ => None,
        },
        lit: lit_at(p, triangle, &shade, shares),
        texel,
        color,
        opacity,
        bytes,
        offset: is_on_frame.then(|| FbPtr::of_pixel(size[0], at[0] as u32, at[1] as u32)),
    })
}

/// The places at which the shading mode lights, and what it finds there.
fn lit_at(p: &Prepared, triangle: u32, shade: &FaceShade, shares: [f64; 3]) -> Vec<LitAt> {
    let polygon = p.polygon_of(triangle);
    let (mesh, side) = (&p.call.geometry.mesh, p.assembler.side(p.corner_vertices(triangle)));
    let (material, _) = p.call.material_of(&mesh.polygons[polygon], side.unwrap_or(Side::Front));
    let turn = if p.call.two_sided_lighting && side == Some(Side::Back) { -1.0 } else { 1.0 };
    let at = |place: &'static str, point: SurfacePoint| {
        let (to_viewer, terms) = p.lighting.terms(point, material);
        let lit = p.lighting.at(point, material);
        LitAt { place, point, to_viewer, terms, base: lit.base, extra: lit.extra }
    };
    let face_normal = p.face_normal(triangle);
    match &shade.light {
        LightMode::Constant(_)
            if p.call.shade == ShadeMode::Flat && p.lighting.depends_on_point(material) =>
        {
            let point = SurfacePoint { position: p.polygon_center(polygon), normal: face_normal * turn };
            vec![at("the polygon's middle", point)]
        }
        LightMode::Constant(_) => Vec::new(),
        LightMode::Vertices(_) => {
            let corners = p.corners(triangle);
            let point = |i: usize| SurfacePoint {
                position: shade.positions[i],
                normal: p.corner_normal(corners[i], face_normal) * turn,
            };
            vec![at("corner 0", point(0)), at("corner 1", point(1)), at("corner 2", point(2))]
        }
        LightMode::Pixels { normals, face_normal, .. } => {
            let normal = normals[0] * shares[0] + normals[1] * shares[1] + normals[2] * shares[2];
            let normal = Some(normal).filter(|n| n.length_squared() > 1e-24).and_then(unit);
            let position = shade.positions[0]
                + (shade.positions[1] - shade.positions[0]) * shares[1]
                + (shade.positions[2] - shade.positions[0]) * shares[2];
            vec![at("the pixel", SurfacePoint { position, normal: normal.unwrap_or(*face_normal) })]
        }
    }
}

#[cfg(test)]
mod tests;

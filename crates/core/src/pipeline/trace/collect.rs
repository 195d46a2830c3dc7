//! Collection of a trace's values from the stages of the plain path.

use super::{CornerTrace, LitAt, PixelTrace, Texel, Trace};
use crate::math::coverage::{PixelRect, SnappedTriangle};
use crate::math::matrix::unit;
use crate::memory::{DepthFormat, DepthMemory, FbPtr, blend, opaque};
use crate::pipeline::assemble::{Face, Facing};
use crate::pipeline::clip::{ClipVertex, clip_polygon};
use crate::pipeline::draw_call::{DrawStats, SceneOptions};
use crate::pipeline::light::SurfacePoint;
use crate::pipeline::pixel::footprint;
use crate::pipeline::plan::Part;
use crate::pipeline::plane_equation::Weights;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::sampler::sample;
use crate::pipeline::scene::drawing_order;
use crate::pipeline::shade::{FaceShade, ShadingFrequency, uv_from_first};
use crate::scene::{Interpolation, ShadeMode};
use glam::{DMat4, DVec2, DVec3};

/// Returns the covered pixel nearest to the centroid of the covered ones.
pub(super) fn middle_pixel(p: &PreparedDraw, triangle: u32) -> Option<[i32; 2]> {
    let corners = p.corner_vertices(triangle);
    let face = p.assembler.face(corners.each_ref(), &mut DrawStats::default())?;
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

/// Returns the face that gives a pixel its colour: the last one that passes there, in drawing
/// order.
pub(super) fn seen_at(
    all: &[PreparedDraw],
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
        if !(is_on_frame && covers(p, &face, at)) {
            continue;
        }
        let screen = &p.transform().screen;
        let crossing = face.crossing(screen);
        let Some((_, z, complement)) = face.point_at(at, screen, crossing.as_ref()) else { continue };
        let word = format.encode(z, complement);
        if p.parts.uses(Part::DepthMemory) {
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

/// Returns whether the fill rule gives a pixel of the viewport to the face.
fn covers(p: &PreparedDraw, face: &Face, [x, y]: [i32; 2]) -> bool {
    let clip = p.transform().screen.clip;
    let is_inside = (clip.x0..clip.x1).contains(&x) && (clip.y0..clip.y1).contains(&y);
    let pixel = PixelRect { x0: x, y0: y, x1: x.saturating_add(1), y1: y.saturating_add(1) };
    let mut is_covered = false;
    for outline in face.outlines.iter().flatten() {
        outline.for_each_span(pixel, |_, _| is_covered = true);
    }
    is_inside && is_covered
}

/// Returns the matrix from NDC to pixels: pixel = origin + NDC * half extents.
fn to_screen((origin, half): ([f64; 2], [f64; 2])) -> DMat4 {
    let scaled = DMat4::from_scale(DVec3::new(half[0], half[1], 1.0));
    DMat4::from_translation(DVec3::new(origin[0], origin[1], 0.0)) * scaled
}

/// Collects the values of one triangle, and of pixel `at` if given.
pub(super) fn follow(
    p: &PreparedDraw,
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
    let outline = SnappedTriangle::new(vertices.map(|v| v.screen));
    let is_on_screen = vertices.iter().all(|v| v.screen[0].is_finite() && v.screen[1].is_finite());
    let snapped = is_on_screen.then(|| outline.corners_fixed()).flatten();
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
        Some(f) if stats.faces_cut > 0 && f.side == Facing::Front => {
            "seen from its front, cut before the eye"
        }
        Some(_) if stats.faces_cut > 0 => "seen from its back, cut before the eye",
        Some(f) if f.side == Facing::Front => "seen from its front",
        Some(_) => "seen from its back",
    };
    let side = face.as_ref().map_or(Facing::Front, |f| f.side);
    let polygon_number = p.polygon_of(triangle);
    let (material, _) = p.call.material_of(&mesh.polygons[polygon_number], side);
    Trace {
        object,
        triangle: (triangle, polygon_number as u32),
        model: p.call.model,
        camera,
        viewing: p.call.camera.viewing_transformation().ok().flatten(),
        to_screen: to_screen(p.transform().screen.map()),
        frame: size,
        shade: p.call.shade,
        corners: [corner(0), corner(1), corner(2)],
        clipped: clip_polygon(&polygon).into_iter().map(|v| v.pos_clip).collect(),
        doubled_area: snapped.map(|s| edge(s[0], s[1], s[2])),
        verdict,
        face_normal,
        material: material.clone(),
        ambient: p.lighting.ambient(),
        fast: None,
        pixel: face.zip(at).and_then(|(face, at)| pixel(p, triangle, &face, at, snapped, size, format)),
    }
}

/// Returns (b-a) x (p-a): twice the signed area of a, b, p, in the product of their units.
fn edge(a: [i64; 2], b: [i64; 2], p: [i64; 2]) -> i128 {
    let d = |q: [i64; 2], axis: usize| i128::from(q[axis]) - i128::from(a[axis]);
    d(b, 0) * d(p, 1) - d(b, 1) * d(p, 0)
}

/// Collects the values of one pixel; `None` if the face has no visible point there.
fn pixel(
    p: &PreparedDraw,
    triangle: u32,
    face: &Face,
    at: [i32; 2],
    snapped: Option<[[i64; 2]; 3]>,
    size: [u32; 2],
    format: DepthFormat,
) -> Option<PixelTrace> {
    let screen = &p.transform().screen;
    let (weights, z, complement) = face.point_at(at, screen, face.crossing(screen).as_ref())?;
    let divide = p.parts.uses(Part::PerspectiveDivision);
    let shares_of = |w: &Weights| face.plane.barycentrics(w, p.call.interp, divide);
    let barycentrics = shares_of(&weights)?;
    let center = [i64::from(at[0]) * 256 + 128, i64::from(at[1]) * 256 + 128];
    let edges = snapped.map(|s| {
        let turn = edge(s[0], s[1], s[2]).signum();
        [0, 1, 2].map(|i| edge(s[(i + 1) % 3], s[(i + 2) % 3], center) * turn)
    });
    let shade = p.shade(triangle, face.side, &mut DrawStats::default());
    let footprint = |uv: &[DVec2; 3]| footprint(&face.plane, screen, shares_of, at, uv);
    let (color, opacity) = shade
        .solid()
        .unwrap_or_else(|| shade.at(barycentrics, footprint, &p.lighting, &mut DrawStats::default()));
    let mut bytes = opaque(color);
    if shade.is_transparent {
        bytes = [0, 0, 0, 255];
        blend(&mut bytes, color, opacity);
    }
    let texel = shade.texture.map(|(texture, sampling, uv)| {
        let here = uv[0] + uv_from_first(&uv, barycentrics);
        let footprint = footprint(&uv);
        let level = footprint.level(texture.width(), texture.height());
        Texel {
            uv: here,
            footprint,
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
        screen_weights: face
            .plane
            .barycentrics(&weights, Interpolation::Affine, divide)
            .unwrap_or(barycentrics),
        weights: face
            .plane
            .barycentrics(&weights, Interpolation::Perspective, divide)
            .unwrap_or(barycentrics),
        inverse_w: weights.values().iter().sum(),
        z,
        depth_word: format.encode(z, complement),
        depth_format: format,
        normal: match &shade.light {
            ShadingFrequency::Pixels { normals, .. } => Some(
                normals[0] * barycentrics[0] + normals[1] * barycentrics[1] + normals[2] * barycentrics[2],
            ),
            _ => None,
        },
        lit: lit_at(p, triangle, &shade, barycentrics),
        texel,
        color,
        opacity,
        bytes,
        offset: is_on_frame.then(|| FbPtr::of_pixel(size[0], at[0] as u32, at[1] as u32)),
    })
}

/// Returns the lighting at the points that the shading mode lights.
fn lit_at(p: &PreparedDraw, triangle: u32, shade: &FaceShade, barycentrics: [f64; 3]) -> Vec<LitAt> {
    let polygon = p.polygon_of(triangle);
    let (mesh, side) = (&p.call.geometry.mesh, p.assembler.side(p.corner_vertices(triangle).each_ref()));
    let (material, _) = p.call.material_of(&mesh.polygons[polygon], side.unwrap_or(Facing::Front));
    let turn = if p.call.two_sided_lighting && side == Some(Facing::Back) { -1.0 } else { 1.0 };
    let at = |place: &'static str, point: SurfacePoint| {
        let (to_viewer, terms) = p.lighting.terms(point, material);
        let lit = p.lighting.at(point, material);
        LitAt {
            place,
            point,
            to_viewer,
            terms,
            diffuse_ambient: lit.diffuse_ambient,
            specular_emissive: lit.specular_emissive,
        }
    };
    let face_normal = p.face_normal(triangle);
    match &shade.light {
        ShadingFrequency::Constant(_)
            if p.call.shade == ShadeMode::Flat && p.lighting.depends_on_point(material) =>
        {
            let point = SurfacePoint { position: p.polygon_center(polygon), normal: face_normal * turn };
            vec![at("the polygon's middle", point)]
        }
        ShadingFrequency::Constant(_) => Vec::new(),
        ShadingFrequency::Vertices(_) => {
            let corners = p.corners(triangle);
            let point = |i: usize| SurfacePoint {
                position: shade.positions[i],
                normal: p.corner_normal(corners[i], face_normal) * turn,
            };
            vec![at("corner 0", point(0)), at("corner 1", point(1)), at("corner 2", point(2))]
        }
        ShadingFrequency::Pixels { normals, face_normal, .. } => {
            let normal =
                normals[0] * barycentrics[0] + normals[1] * barycentrics[1] + normals[2] * barycentrics[2];
            let normal = Some(normal).filter(|n| n.length_squared() > 1e-24).and_then(unit);
            let position = shade.positions[0]
                + (shade.positions[1] - shade.positions[0]) * barycentrics[1]
                + (shade.positions[2] - shade.positions[0]) * barycentrics[2];
            vec![at("the pixel", SurfacePoint { position, normal: normal.unwrap_or(*face_normal) })]
        }
    }
}

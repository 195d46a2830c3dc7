//! Stage 1: derives the stages that a draw call needs, by whatever path it is drawn.
//!
//! In: a draw call, its target, its lights and cached facts about its mesh. Out: a record of the
//! parts that it needs, without those of its path, which `path_plan` adds. No vertex is transformed
//! and no pixel is read.

use super::draw_call::{DrawCall, Target};
use super::geometry_cache::GeometryInfo;
use super::light::Lighting;
use super::plan::{Part, PlanRecord, Title};
use super::vertex::Vertex;
use super::working::SORT_KEY_BYTES;
use crate::memory::PickBuffer;
use crate::scene::{Cull, HiddenSurface, ShadeMode, Texture};
use glam::DVec3;

/// Reason printed when the painter's algorithm sorts faces.
pub(crate) const SORTED_BY_PAINTER: &str = "HIDE painter draws far to near";

/// Derives the plan of one draw call: the parts of the pipeline that it needs, and why.
pub(crate) fn plan_draw<P: PlanRecord>(
    call: &DrawCall,
    target: &Target,
    lighting: &Lighting,
    geometry_info: &GeometryInfo,
) -> P {
    let mesh = &call.geometry.mesh;
    let (width, height) = (target.memory.width(), target.memory.height());
    let pixels = width as u64 * height as u64;
    let faces = mesh.triangles.len() as u64;
    let wire = call.shade == ShadeMode::Wire;
    let vertices = mesh.positions.len() as u64;
    let is_empty = faces == 0 && mesh.lines.is_empty() && mesh.points.is_empty();
    let title =
        if is_empty { Title::Words("draw of an empty mesh") } else { Title::Draw { faces, vertices } };
    let mut plan = P::of_frame(title, [width, height], "nothing asks for it");
    if is_empty {
        return plan;
    }
    let vertex_bytes = vertices * size_of::<Vertex>() as u64;
    plan.add(Part::TransformVertices, "every position once", vertices, vertex_bytes);
    match call.is_parallel() {
        true => plan.leave_out(Part::PerspectiveDivision, "a parallel projection: w is 1"),
        false => plan.add(Part::PerspectiveDivision, "a perspective projection", vertices, 0),
    }
    match call.hide {
        HiddenSurface::ZBuffer => {
            let bytes = pixels * target.depth_format.bytes_per_pixel() as u64;
            let reason = "HIDE zbuffer; a stream's future is not known, so depth is kept";
            plan.add(Part::DepthMemory, reason, pixels, bytes);
        }
        HiddenSurface::Painter => {
            plan.leave_out(Part::DepthMemory, "HIDE painter neither tests nor writes depth");
            plan.add(Part::SortFaces, SORTED_BY_PAINTER, faces, faces * SORT_KEY_BYTES);
        }
        HiddenSurface::None => plan.leave_out(Part::DepthMemory, "HIDE none neither tests nor writes depth"),
    }
    let fits = |ids: &&&mut PickBuffer| (ids.width(), ids.height()) == (width, height);
    if let Some(ids) = target.ids.as_ref().filter(|_| call.hide == HiddenSurface::ZBuffer).filter(fits) {
        plan.add(Part::PickBuffer, "PICK asks which face is seen", pixels, ids.size_bytes() as u64);
    }
    if !mesh.lines.is_empty() {
        plan.add(Part::Lines, "the mesh has line segments", mesh.lines.len() as u64, 0);
    } else if wire && faces > 0 {
        plan.add(Part::Lines, "SHADE wire draws each polygon edge once", mesh.corners.len() as u64, 0);
    }
    if !mesh.points.is_empty() {
        plan.add(Part::Points, "the mesh has points", mesh.points.len() as u64, 0);
    }
    if faces > 0 {
        plan_faces(call, lighting, geometry_info, &mut plan, faces, wire);
    }
    plan
}

/// Requirements of the polygons: whether any is lit, textured or transparent, and the bytes of all
/// textures in use.
#[derive(Default)]
struct Asks {
    light: bool,
    /// True if some light depends on the place of a point or on the viewer.
    place: bool,
    highlight: bool,
    texture: bool,
    texture_bytes: u64,
    transparent: bool,
}

/// Collects the requirements of all materials in use, on their visible sides.
fn asks_of(call: &DrawCall, lighting: &Lighting, geometry_info: &GeometryInfo) -> Asks {
    let mesh = &call.geometry.mesh;
    let mut asks = Asks::default();
    // Most meshes have few textures; those need no allocation.
    let (mut few, mut count, mut more) = ([std::ptr::null(); 8], 0, Vec::new());
    for p in geometry_info.materials.iter().map(|&p| &mesh.polygons[p as usize]) {
        for &side in call.sides() {
            let (material, texture) = call.material_of(p, side);
            asks.light |= lighting.depends_on_point(material);
            asks.place |= lighting.depends_on_place(material);
            asks.highlight |= lighting.depends_on_point(material) && material.ks != DVec3::ZERO;
            asks.transparent |= DrawCall::is_transparent(material, texture);
            if let Some(t) = texture {
                asks.texture = true;
                let address: *const Texture = t;
                if !few[..count].contains(&address) && !more.contains(&address) {
                    match few.get_mut(count) {
                        Some(place) => (*place, count) = (address, count + 1),
                        None => more.push(address),
                    }
                    asks.texture_bytes += t.size_bytes() as u64;
                }
            }
        }
    }
    if let Some(stages) = call.stages {
        asks.transparent |= stages.may_be_transparent();
        asks.texture |= !stages.stages.is_empty();
        let textures = stages.stages.iter().filter_map(|s| s.texture.as_ref());
        asks.texture_bytes += textures.map(|t| t.size_bytes() as u64).sum::<u64>();
    }
    asks
}

/// Adds the parts that faces need: culling, coverage, lighting, interpolation, textures, fog,
/// blending.
fn plan_faces(
    call: &DrawCall,
    lighting: &Lighting,
    geometry_info: &GeometryInfo,
    plan: &mut impl PlanRecord,
    faces: u64,
    wire: bool,
) {
    plan_coverage(call, plan, faces, wire);
    if wire {
        return;
    }
    let asks = asks_of(call, lighting, geometry_info);
    match asks.light {
        true => plan_lighting(call, lighting, geometry_info, plan, &asks),
        false => leave_lighting_out(lighting, plan),
    }
    if has_colors(call) && call.shade != ShadeMode::Flat {
        plan.add(Part::InterpolateColors, "the mesh has vertex colours", faces, 0);
    }
    if asks.texture {
        plan.add(Part::Textures, "the faces are textured", 1, asks.texture_bytes);
        plan.add(Part::InterpolateTexcoords, "the faces are textured", faces, 0);
        plan.add(Part::SampleTextures, call.sampling.filter.as_str(), faces, 0);
    } else {
        for part in [Part::Textures, Part::InterpolateTexcoords, Part::SampleTextures] {
            plan.leave_out(part, "no texture");
        }
    }
    match call.maps {
        None => plan.leave_out(Part::SurfaceMaps, "no map of emission, normals or occlusion"),
        Some(maps) => {
            let bytes = maps.all().map(|map| map.size_bytes() as u64).sum();
            plan.add(Part::SurfaceMaps, maps.names(), faces, bytes);
            if !asks.texture {
                plan.add(Part::InterpolateTexcoords, "the maps' own", faces, 0);
            }
        }
    }
    match call.fog {
        Some(fog) if fog.is_seen() => {
            plan.add(Part::Fog, "the scene has fog", faces, 0);
            plan.add(Part::InterpolatePositions, "fog needs the distance", faces, 0);
        }
        Some(_) => plan.leave_out(Part::Fog, "a visibility range of 0 or without end is no fog"),
        None => {}
    }
    if asks.transparent || geometry_info.has_clear_colors {
        plan.add(Part::ReadBack, "transparent faces are blended", faces, 0);
    } else {
        plan.leave_out(Part::ReadBack, "every face is opaque");
    }
}

/// Adds culling, clipping and coverage of faces.
fn plan_coverage(call: &DrawCall, plan: &mut impl PlanRecord, faces: u64, wire: bool) {
    match call.cull {
        Cull::None => plan.leave_out(Part::CullFaces, "CULL none"),
        _ => plan.add(Part::CullFaces, "by the sign of the screen area", faces, 0),
    }
    match call.is_parallel() {
        true => plan.leave_out(Part::CutFaces, "a parallel projection has no eye plane"),
        false => plan.add(Part::CutFaces, "only faces with some w <= 0", faces, 0),
    }
    if wire && call.hide != HiddenSurface::ZBuffer {
        plan.leave_out(Part::Coverage, "SHADE wire without depth: lines alone");
    } else {
        let reason = if wire { "depth that hides lines" } else { "every face that is seen" };
        plan.add(Part::Coverage, reason, faces, 0);
    }
}

/// Adds normals, lighting and what is interpolated for it.
fn plan_lighting(
    call: &DrawCall,
    lighting: &Lighting,
    geometry_info: &GeometryInfo,
    plan: &mut impl PlanRecord,
    asks: &Asks,
) {
    let mesh = &call.geometry.mesh;
    let faces = mesh.triangles.len() as u64;
    let normal_bytes = size_of::<DVec3>() as u64;
    let flat = call.shade == ShadeMode::Flat;
    // A corner without a normal of its own takes the mean of its faces' normals.
    let all_given = geometry_info.all_normals_given;
    if flat || !all_given {
        let polygons = mesh.polygons.len() as u64;
        let reason = if flat { "SHADE flat lights with them" } else { "vertex normals are their means" };
        plan.add(Part::FaceNormals, reason, polygons, polygons * normal_bytes);
    } else {
        plan.leave_out(Part::FaceNormals, "the file gives every normal");
    }
    if !flat && !all_given {
        let positions = mesh.positions.len() as u64;
        let bytes = positions * (normal_bytes * 2 + 8);
        plan.add(Part::VertexNormals, "the file does not give them", positions, bytes);
    } else {
        let reason = if flat { "SHADE flat uses the faces'" } else { "the file gives every normal" };
        plan.leave_out(Part::VertexNormals, reason);
    }
    match call.shade {
        ShadeMode::Flat => plan.add(Part::LightFaces, "SHADE flat: once a face", faces, 0),
        ShadeMode::Gouraud => {
            plan.add(Part::LightVertices, "SHADE gouraud: once a corner", faces * 3, 0);
            plan.add(Part::InterpolateColors, "lit at the corners", faces, 0);
        }
        _ => {
            let by_tile = lighting.has_many_of_bounded_reach()
                && call.camera.matrices(1.0).is_ok_and(|camera| !camera.is_parallel);
            // Whichever path draws faces in order, it lights each of their pixels.
            let in_order =
                call.hide == HiddenSurface::Painter || asks.transparent || geometry_info.has_clear_colors;
            let reason = match (asks.highlight, asks.place, by_tile) {
                _ if in_order => "SHADE phong: once a pixel",
                (true, _, false) => {
                    "SHADE phong: once a pixel, large faces once in 2x2 to 8x8 where light is linear within 1/4 step; highlights where they reach 1/4 step"
                }
                (true, _, true) => {
                    "SHADE phong: once a pixel, large faces once in 2x2 to 8x8 where light is linear within 1/4 step; up to 16 materials by the lights that reach the tile, highlights where they reach 1/4 step"
                }
                (false, true, false) => {
                    "SHADE phong: once a pixel, large faces once in 2x2 to 8x8 where light is linear within 1/4 step"
                }
                (false, true, true) => {
                    "SHADE phong: once a pixel, large faces once in 2x2 to 8x8 where light is linear within 1/4 step; up to 16 materials by the lights that reach the tile"
                }
                (false, false, _) => "SHADE phong: once a pixel, and once a large face of one normal",
            };
            plan.add(Part::LightPixels, reason, lighting.light_count() as u64, 0);
            plan.add(Part::InterpolateNormals, "lit per pixel", faces, 0);
            match asks.place {
                true => plan.add(Part::InterpolatePositions, "lit per pixel", faces, 0),
                false => plan.leave_out(Part::InterpolatePositions, "matte, and lit from directions alone"),
            }
        }
    }
}

/// Leaves out everything that lighting needs: nothing depends on the lights.
fn leave_lighting_out(lighting: &Lighting, plan: &mut impl PlanRecord) {
    let reason = if lighting.light_count() == 0 { "no light" } else { "no material answers the lights" };
    for part in [
        Part::FaceNormals,
        Part::VertexNormals,
        Part::LightFaces,
        Part::LightVertices,
        Part::LightPixels,
        Part::InterpolateNormals,
        Part::InterpolatePositions,
    ] {
        plan.leave_out(part, reason);
    }
    plan.leave_out(Part::InterpolateColors, "one colour a face");
}

fn has_colors(call: &DrawCall) -> bool {
    !call.geometry.mesh.colors.is_empty()
}

/// Maximum product of faces and vertices at which a mesh is tested for convexity.
const CONVEX_LIMIT: u64 = 4_000_000;

/// Returns whether no face of this draw can lie in front of another: a single face, or a closed
/// convex solid of which CULL leaves one side. The caller must know that the faces are opaque, so
/// that a pixel on a seam is the same whichever face comes last. What is found of the mesh is kept in
/// its facts, if there are any.
pub(crate) fn cannot_self_occlude(call: &DrawCall, geometry_info: Option<&GeometryInfo>) -> bool {
    let mesh = &call.geometry.mesh;
    if !mesh.lines.is_empty() || !mesh.points.is_empty() || call.shade == ShadeMode::Wire {
        return false;
    }
    match mesh.triangles.len() {
        0 | 1 => true,
        _ if call.cull == Cull::None => false,
        _ => match geometry_info {
            Some(info) => *info.convex_body.get_or_init(|| is_convex_solid(call.geometry)),
            None => is_convex_solid(call.geometry),
        },
    }
}

/// Returns for each position the first index at which the same point stands: formats without indices
/// give each face points of its own.
fn welded(positions: &[DVec3]) -> Vec<u32> {
    let mut first = std::collections::HashMap::with_capacity(positions.len());
    // 0 and -0 are one place.
    let place = |p: &DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    (0..).zip(positions).map(|(i, p)| *first.entry(place(p)).or_insert(i)).collect()
}

/// Returns whether the triangles bound a closed convex body: every edge occurs once in each
/// direction, and no vertex lies above a face. Equal positions are one vertex.
fn is_convex_solid(geometry: &crate::scene::Geometry) -> bool {
    let mesh = &geometry.mesh;
    if mesh.triangles.len() as u64 * mesh.positions.len() as u64 > CONVEX_LIMIT {
        return false;
    }
    let welded = welded(&mesh.positions);
    let position = |c: u32| welded[mesh.corners[c as usize].position as usize];
    let mut edges = std::collections::HashSet::new();
    for t in &mesh.triangles {
        for i in 0..3 {
            if !edges.insert([position(t[i]), position(t[(i + 1) % 3])]) {
                return false;
            }
        }
    }
    if edges.iter().any(|&[a, b]| !edges.contains(&[b, a])) {
        return false;
    }
    let Some((low, high)) = mesh.bounds() else { return false };
    let slack = 1e-12 * (high - low).length();
    mesh.triangles.iter().all(|t| {
        let [a, b, c] = t.map(|c| mesh.positions[position(c) as usize]);
        let Some(normal) = crate::math::matrix::unit((b - a).cross(c - a)) else { return false };
        edges.iter().all(|&[p, _]| (mesh.positions[p as usize] - a).dot(normal) <= slack)
    })
}

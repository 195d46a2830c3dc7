//! Shapes ready to be drawn: each geometry node's mesh, computed once and shared by all its uses.

use super::appearance::{self, TextureMap};
use super::generate::{self, Generator, SurfaceFrame};
use super::geometry::{self, Built, ColorUse, Fault, LeftOut, Stuff};
use super::graph::{GraphView, NodeId};
use super::stages;
use fbptr_core::scene::{Camera, Geometry, Mesh, Object, PointShape, Style};
use glam::{DMat4, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// A mesh in the form that an appearance requires, with or without texture coordinates.
#[derive(Clone, Debug)]
pub(super) struct Prepared {
    pub(super) geometry: Arc<Geometry>,
    colors: ColorUse,
    stuff: Stuff,
}

/// Key of a prepared geometry: the source of the mesh (all solids of a kind share one of unit
/// size), and the treatment of its texture coordinates.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct ShapeKey {
    mesh: MeshKey,
    is_textured: bool,
    /// TextureTransform node, if it has an effect.
    map: Option<NodeId>,
}

/// Source of a mesh.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum MeshKey {
    Node(NodeId),
    /// A Box, Sphere, Cone or Cylinder of unit size: its type name, and which of its parts (side,
    /// bottom, top) exist.
    Solid(&'static str, [bool; 3]),
}

/// Meshes prepared so far.
pub(super) type MeshCache = HashMap<ShapeKey, Prepared>;

/// The nodes of a shape that determine its mesh.
pub(super) struct ShapeParts {
    pub(super) geometry: NodeId,
    appearance: Option<NodeId>,
    /// MultiTexture node.
    multi: Option<NodeId>,
    /// TextureTransform or MultiTextureTransform node.
    transform: Option<NodeId>,
    key: ShapeKey,
}

/// Returns half the side lengths of a solid; `None` for other nodes.
fn solid_size(view: &GraphView, id: NodeId) -> Option<DVec3> {
    let real = |field| view.real(id, field);
    match view.name(id) {
        "Box" => Some(view.vec3(id, "size") / 2.0),
        "Sphere" => Some(DVec3::splat(real("radius"))),
        "Cone" => Some(DVec3::new(real("bottomRadius"), real("height") / 2.0, real("bottomRadius"))),
        "Cylinder" => Some(DVec3::new(real("radius"), real("height") / 2.0, real("radius"))),
        _ => None,
    }
}

/// Returns the parts of a shape; `None` if it has no geometry.
pub(super) fn parts(view: &GraphView, shape: NodeId) -> Option<ShapeParts> {
    let geometry = view.child(shape, "geometry")?;
    let appearance = view.child(shape, "appearance");
    let is_textured = appearance::texture_node(view, appearance).is_some();
    let texture = appearance::texture_node(view, appearance);
    let transform = appearance.and_then(|a| view.child(a, "textureTransform"));
    let multi = texture.filter(|t| view.name(*t) == "MultiTexture");
    // Of several textures each has its own transform, and generated coordinates are transformed
    // later.
    let is_plain = is_textured && multi.is_none() && generator(view, geometry).is_none();
    let is_map = |m: &NodeId| view.name(*m) == "TextureTransform" && TextureMap::read(view, *m).is_some();
    let map = transform.filter(|m| is_plain && is_map(m));
    let part = |field| view.node(geometry).ty.field(field).is_some() && view.bool(geometry, field);
    let mesh = match solid_size(view, geometry) {
        Some(_) => MeshKey::Solid(view.name(geometry), ["side", "bottom", "top"].map(part)),
        None => MeshKey::Node(geometry),
    };
    Some(ShapeParts { geometry, appearance, multi, transform, key: ShapeKey { mesh, is_textured, map } })
}

/// Returns whether routes have changed the input of the mesh.
pub(super) fn is_driven(view: &GraphView, parts: &ShapeParts) -> bool {
    let of_geometry = view.node(parts.geometry).children.iter().any(|c| view.is_driven(c.node));
    // A solid's mesh has unit size: its own fields affect only its matrix.
    let own = matches!(parts.key.mesh, MeshKey::Node(_)) && view.is_driven(parts.geometry);
    own || of_geometry || parts.key.map.is_some_and(|m| view.is_driven(m))
}

/// Computes the geometry of a shape. Also returns remarks on repaired defects, and what was left out.
pub(super) fn prepare(
    view: &GraphView,
    parts: &ShapeParts,
) -> Result<(Prepared, Vec<String>, LeftOut), Fault> {
    let Built { mut mesh, colors, stuff, remarks, left_out } =
        geometry::build(view, parts.geometry, parts.key.is_textured)?;
    if let Some(map) = parts.key.map.and_then(|m| TextureMap::read(view, m)) {
        mesh.texcoords.iter_mut().for_each(|tc| *tc = map.apply(*tc));
    }
    mesh.shrink_to_fit();
    let geometry = Arc::new(Geometry { mesh, textures: Vec::new() });
    Ok((Prepared { geometry, colors, stuff }, remarks, left_out))
}

/// Stores a prepared geometry in the cache, and returns its key.
pub(super) fn store(mesh_cache: &mut MeshCache, parts: &ShapeParts, prepared: Prepared) -> ShapeKey {
    mesh_cache.insert(parts.key.clone(), prepared);
    parts.key.clone()
}

/// Returns the cached geometry of a shape.
pub(super) fn cached<'a>(mesh_cache: &'a MeshCache, parts: &ShapeParts) -> Option<&'a Prepared> {
    mesh_cache.get(&parts.key)
}

/// Returns a remark if a solid's size is not positive.
pub(super) fn size_remark(view: &GraphView, parts: &ShapeParts) -> Option<String> {
    let is_bad = solid_size(view, parts.geometry).is_some_and(|size| size.min_element() <= 0.0);
    is_bad.then(|| format!("<{}> has no face: its size must be positive", view.name(parts.geometry)))
}

/// Returns the generator of texture coordinates of a geometry with a single texture.
fn generator<'a>(view: &GraphView<'a>, geometry: NodeId) -> Option<Generator<'a>> {
    stages::entry(view, geometry, 0).and_then(|node| stages::generator(view, node))
}

/// Returns a copy of a geometry with generated texture coordinates, as seen from a camera; `None`
/// without a generator.
fn generated(
    view: &GraphView,
    parts: &ShapeParts,
    prepared: &Prepared,
    place: &SurfaceFrame,
) -> Option<Arc<Geometry>> {
    let generator = generator(view, parts.geometry).filter(|_| parts.key.is_textured)?;
    let mut mesh = prepared.geometry.mesh.clone();
    mesh.texcoords = generate::texcoords(&generator, &mesh, place);
    let map = parts.transform.filter(|t| view.name(*t) == "TextureTransform");
    if let Some(map) = map.and_then(|m| TextureMap::read(view, m)) {
        mesh.texcoords.iter_mut().for_each(|tc| *tc = map.apply(*tc));
    }
    mesh.corners.iter_mut().zip(0..).for_each(|(corner, i)| corner.texcoord = i);
    Some(Arc::new(Geometry { mesh, textures: Vec::new() }))
}

/// Returns the object of a shape with world matrix `model`, seen by a viewer; `None` if there is
/// nothing to draw.
pub(super) fn object(
    view: &GraphView,
    parts: &ShapeParts,
    prepared: &Prepared,
    model: DMat4,
    viewer: Option<&Camera>,
    name: String,
) -> Option<Object> {
    let mesh: &Mesh = &prepared.geometry.mesh;
    if mesh.triangles.is_empty() && mesh.lines.is_empty() && mesh.points.is_empty() {
        return None;
    }
    let size = solid_size(view, parts.geometry).unwrap_or(DVec3::ONE);
    let place = SurfaceFrame::new(size, model, viewer);
    let model = match solid_size(view, parts.geometry) {
        Some(size) if size.min_element() > 0.0 => model * fbptr_core::math::matrix::scale(size),
        Some(_) => return None,
        None => model,
    };
    if !model.is_finite() {
        return None;
    }
    let is_solid = geometry::is_solid(view, parts.geometry);
    let appearance = appearance::read(view, parts.appearance, prepared.stuff, prepared.colors);
    let multi = parts.multi.filter(|_| prepared.stuff == Stuff::Faces);
    let stages =
        multi.map(|multi| Arc::new(stages::read(view, multi, parts.geometry, parts.transform, mesh, &place)));
    let generated = match multi {
        None => generated(view, parts, prepared, &place),
        Some(_) => None,
    };
    Some(Object {
        name,
        geometry: generated.unwrap_or_else(|| Arc::clone(&prepared.geometry)),
        model,
        material: appearance.material,
        back_material: appearance.back,
        cull: if is_solid { fbptr_core::scene::Cull::Back } else { fbptr_core::scene::Cull::None },
        two_sided_lighting: !is_solid,
        shade: None,
        texture: appearance.texture,
        lights: None,
        light_error: None,
        style: Style {
            line: stages::line_style(view, parts.appearance),
            fill: stages::fill_style(view, parts.appearance),
            stages,
            maps: None,
            point_size: stages::point_size(view, parts.appearance),
            point_shape: PointShape::Square,
        },
    })
}

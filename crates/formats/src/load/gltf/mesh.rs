//! Primitives of a glTF file's meshes.
//!
//! In: attributes and indices of a primitive. Out: a mesh of triangles, lines or points, with the
//! material's texture coordinates: transformed, v turned up. Without normals faces are flat, as the
//! specification asks; lines and points without normals are unlit. Colours of vertices are encoded
//! (`material`); alpha counts with BLEND, and with MASK (`cutoff`).
//!
//! Source: glTF 2.0 Specification, section 3.7.2 (Meshes), with KHR_mesh_quantization.

use super::attributes::{attribute, vertex_attribute};
use super::cutoff;
use super::image::{Images, Source};
use super::json::Json;
use super::material::{self, Surface};
use super::pose::{Morph, Skinning};
use crate::load::{LoadError, LoadErrorKind};
use fbptr_core::math::matrix::unit;
use fbptr_core::scene::{
    Corner, Geometry, LightingModel, Material, Mesh, NONE, Sampling, SurfaceMaps, Texture,
};
use glam::{DVec3, DVec4};
use std::sync::Arc;

/// Bytes of the mesh for each vertex and for each index, at most.
const VERTEX_BYTES: u64 = 24 + 24 + 16 + 32;
const INDEX_BYTES: u64 = 2 * (16 + 12 + 12 + 4 + 24);

/// A primitive as it is drawn.
#[derive(Clone, Debug)]
pub(super) struct Primitive {
    pub(super) geometry: Arc<Geometry>,
    pub(super) material: Material,
    pub(super) texture: Option<(Arc<Texture>, Sampling)>,
    pub(super) maps: Option<Arc<SurfaceMaps>>,
    pub(super) is_double_sided: bool,
    /// Displacements of its positions.
    pub(super) morphs: Vec<Morph>,
    pub(super) skinning: Option<Skinning>,
}

impl Primitive {
    /// Returns the bytes of its tangents.
    pub(super) fn tangent_bytes(&self) -> usize {
        let normal = self.maps.as_ref().and_then(|maps| maps.normal.as_ref());
        normal.map_or(0, |normal| size_of_val(&*normal.tangents))
    }
}

/// Mode of a primitive.
#[derive(Clone, Copy, PartialEq)]
enum Topology {
    Points,
    Lines { is_strip: bool, is_loop: bool },
    Triangles,
    Strip,
    Fan,
}

impl Topology {
    fn read(mode: &Json) -> Topology {
        match mode.whole_or(4).unwrap_or(u64::MAX) {
            0 => Topology::Points,
            1 => Topology::Lines { is_strip: false, is_loop: false },
            2 => Topology::Lines { is_strip: true, is_loop: true },
            3 => Topology::Lines { is_strip: true, is_loop: false },
            4 => Topology::Triangles,
            5 => Topology::Strip,
            6 => Topology::Fan,
            _ => {
                mode.note_wrong("a mode from 0 to 6", "triangles are taken");
                Topology::Triangles
            }
        }
    }
}

/// Reads a primitive. `None` if nothing of it can be seen.
pub(super) fn read(
    source: &mut Source,
    images: &mut Images,
    json: &Json,
) -> Result<Option<Primitive>, LoadError> {
    let compressed = "KHR_draco_mesh_compression";
    let attributes = json.member("attributes");
    let accessors = source.root.member("accessors");
    let position = attributes.member("POSITION");
    if !position.is_there() {
        source.warn(json.warning("a primitive without positions is left out"));
        return Ok(None);
    }
    if json.extension(compressed).is_object() && !has_bytes(&accessors, &position)? {
        let reason = format!("{compressed} is not supported: {}", super::converter(compressed));
        return Err(json.refuse(LoadErrorKind::Undecodable { format: "glTF", reason }));
    }
    let topology = Topology::read(&json.member("mode"));
    let materials = source.root.member("materials");
    let number = json.member("material").index_if_there("material", materials.count())?;
    // An item that is not there has all defaults.
    let of_material = number.map_or_else(|| materials.item(usize::MAX), |i| materials.item(i));
    let mut surface = material::read(source, images, &of_material)?;
    if surface.is_invisible {
        return Ok(None);
    }
    let positions = attribute(source, &position, &[3])?;
    let count = positions.count();
    let indices = indices(source, json, count)?;
    let corners = indices.as_ref().map_or(count, Vec::len);
    // Cutting adds a vertex or two for each triangle.
    let most = (count + corners) as u64 * VERTEX_BYTES + corners as u64 * 3 * INDEX_BYTES;
    let _work = source.context.memory.work(most).map_err(|kind| json.refuse(kind))?;
    let mut mesh =
        Mesh { positions: positions.elements(0.0).map(DVec3::from_array).collect(), ..Mesh::default() };
    drop(positions);
    read_attributes(source, &attributes, &mut mesh, &surface)?;
    add_elements(&mut mesh, topology, indices.as_deref());
    let skinning = Skinning::read(source, &attributes, count)?;
    let morphs = Morph::read_all(source, &json.member("targets"), count)?;
    if let (Some(least), false) = (surface.least_alpha, mesh.colors.is_empty()) {
        if skinning.is_some() || !morphs.is_empty() {
            source.warn(json.warning("the alpha of vertices that bend is not compared with the cutoff"));
            mesh.colors.iter_mut().for_each(|color| color.w = 1.0);
        } else {
            if !surface.maps.is_empty() {
                surface.leave_maps_out(source, json, "maps of faces that the alpha of vertices cuts");
            }
            cutoff::cut(&mut mesh, least);
        }
    }
    if mesh.normals.is_empty() {
        match topology {
            Topology::Points | Topology::Lines { .. } => {
                let color = surface.material.kd;
                if surface.material.model != LightingModel::Unlit {
                    surface.material = material::unlit(color, surface.material);
                }
            }
            _ => add_flat_normals(&mut mesh),
        }
    }
    let maps = worn_maps(source, json, &mut surface, &mesh)?;
    mesh.shrink_to_fit();
    let bytes = mesh.size_bytes() as u64;
    source.context.memory.reserve_result(bytes).map_err(|kind| json.refuse(kind))?;
    let texture = surface.texture.map(|texture| (texture.made.texture, texture.made.sampling));
    let texture = texture.filter(|_| !mesh.texcoords.is_empty());
    Ok(Some(Primitive {
        geometry: Arc::new(Geometry::from(mesh)),
        material: surface.material,
        texture,
        maps,
        is_double_sided: surface.is_double_sided,
        morphs,
        skinning,
    }))
}

/// Returns the maps of a primitive's surface. Without one that limits it, the surface emits nothing.
fn worn_maps(
    source: &mut Source,
    json: &Json,
    surface: &mut Surface,
    mesh: &Mesh,
) -> Result<Option<Arc<SurfaceMaps>>, LoadError> {
    if !surface.maps.is_empty() && mesh.triangles.is_empty() {
        surface.leave_maps_out(source, json, "maps of lines and points");
    }
    let emits_by_map = surface.maps.emission.is_some();
    let maps = match std::mem::take(&mut surface.maps) {
        maps if maps.is_empty() => None,
        maps => maps.worn_by(source, &json.member("attributes"), mesh)?,
    };
    if emits_by_map && maps.as_ref().is_none_or(|maps| maps.emission.is_none()) {
        surface.material.emissive = DVec3::ZERO;
    }
    Ok(maps)
}

/// Returns whether an attribute's accessor has a buffer view.
fn has_bytes(accessors: &Json, attribute: &Json) -> Result<bool, LoadError> {
    let accessor = accessors.item(attribute.index("accessor", accessors.count())?);
    Ok(accessor.member("bufferView").is_there())
}

/// Reads the indices of a primitive, all below `count`.
fn indices(source: &mut Source, json: &Json, count: usize) -> Result<Option<Vec<u32>>, LoadError> {
    let json = json.member("indices");
    if !json.is_there() {
        return Ok(None);
    }
    let numbers = attribute(source, &json, &[1])?;
    if let Some(wrong) = numbers.values.iter().find(|i| !(0.0..count as f64).contains(*i)) {
        let (index, count) = (*wrong as i64, count as u64);
        return Err(json.refuse(LoadErrorKind::Index { what: "vertex", index, count }));
    }
    Ok(Some(numbers.values.iter().map(|i| *i as u32).collect()))
}

fn read_attributes(
    source: &mut Source,
    attributes: &Json,
    mesh: &mut Mesh,
    surface: &Surface,
) -> Result<(), LoadError> {
    let count = mesh.positions.len();
    if let Some(normals) = vertex_attribute(source, &attributes.member("NORMAL"), &[3], count)? {
        mesh.normals = normals.elements(0.0).map(DVec3::from_array).collect();
    }
    if let Some(texture) = &surface.texture {
        mesh.texcoords = texture.texcoords(source, attributes, count)?;
    }
    if let Some(colors) = vertex_attribute(source, &attributes.member("COLOR_0"), &[3, 4], count)? {
        let color = |[r, g, b, a]: [f64; 4]| {
            let rgb = material::encoded_color([r, g, b].map(|x| x.clamp(0.0, 1.0)));
            let counts = surface.blends || surface.least_alpha.is_some();
            DVec4::from((rgb, if counts { a.clamp(0.0, 1.0) } else { 1.0 }))
        };
        mesh.colors = colors.elements(1.0).map(color).collect();
    }
    Ok(())
}

/// Adds the corners and elements of a primitive.
fn add_elements(mesh: &mut Mesh, topology: Topology, indices: Option<&[u32]>) {
    let count = indices.map_or(mesh.positions.len(), <[u32]>::len);
    let vertex = |i: usize| indices.map_or(i as u32, |indices| indices[i]);
    let of = |is_empty: bool, i: u32| if is_empty { NONE } else { i };
    let lacks = [mesh.normals.is_empty(), mesh.texcoords.is_empty(), mesh.colors.is_empty()];
    let corner = |i: usize| {
        let position = vertex(i);
        let [normal, texcoord, color] = lacks.map(|lacks| of(lacks, position));
        Corner { position, normal, texcoord, color }
    };
    let triangles = count.saturating_sub(2);
    match topology {
        Topology::Triangles => {
            for i in 0..count / 3 {
                mesh.push_polygon(&[3 * i, 3 * i + 1, 3 * i + 2].map(corner), NONE);
            }
        }
        Topology::Strip => {
            for i in 0..triangles {
                let t = if i % 2 == 0 { [i, i + 1, i + 2] } else { [i + 1, i, i + 2] };
                mesh.push_polygon(&t.map(corner), NONE);
            }
        }
        Topology::Fan => {
            for i in 0..triangles {
                mesh.push_polygon(&[0, i + 1, i + 2].map(corner), NONE);
            }
        }
        Topology::Points => {
            mesh.corners = (0..count).map(corner).collect();
            mesh.points = (0..count as u32).collect();
        }
        Topology::Lines { is_strip, is_loop } => {
            mesh.corners = (0..count).map(corner).collect();
            let n = count as u32;
            mesh.lines = match is_strip {
                true => (1..n).map(|i| [i - 1, i]).collect(),
                false => (0..n / 2).map(|i| [2 * i, 2 * i + 1]).collect(),
            };
            if is_loop && n > 2 {
                mesh.lines.push([n - 1, 0]);
            }
        }
    }
}

/// Gives each triangle its own normal.
pub(super) fn add_flat_normals(mesh: &mut Mesh) {
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.positions[mesh.corners[i as usize].position as usize]);
        let normal = unit((b - a).cross(c - a)).unwrap_or(DVec3::Z);
        let number = mesh.normals.len() as u32;
        mesh.normals.push(normal);
        t.iter().for_each(|i| mesh.corners[*i as usize].normal = number);
    }
}

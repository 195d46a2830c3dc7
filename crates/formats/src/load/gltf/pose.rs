//! Meshes that bend: morph targets and skins.
//!
//! In: the displacements of a primitive, the joints and weights of its vertices, and the matrices
//! of a skin's joints at a moment. Out: the geometry at that moment.
//!
//! ```text
//! position = sum over joints of weight * (joint's world matrix * inverse bind matrix)
//!            applied to (position + sum over targets of weight * displacement)
//! ```
//!
//! A skinned mesh is in world space: the matrix of its own node does not count. Weights are divided
//! by their sum.
//!
//! Source: glTF 2.0 Specification, sections 3.7.2.2 (Morph Targets) and 3.7.3 (Skins).

use super::attributes::{attribute, vertex_attribute};
use super::image::Source;
use super::json::Json;
use super::mesh::{self, Primitive};
use crate::load::{LoadError, LoadErrorKind};
use fbptr_core::math::matrix::unit;
use fbptr_core::scene::{Geometry, Mesh, SurfaceMaps};
use glam::{DMat4, DVec3, DVec4};
use std::sync::Arc;

/// Most morph targets of a primitive.
const MAX_TARGETS: usize = 256;

/// Displacements of a morph target; empty where it has none.
#[derive(Clone, Debug)]
pub(super) struct Morph {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
}

impl Morph {
    /// Reads the targets of a primitive of `count` vertices.
    pub(super) fn read_all(
        source: &mut Source,
        targets: &Json,
        count: usize,
    ) -> Result<Vec<Morph>, LoadError> {
        let items = targets.items()?;
        if items.len() > MAX_TARGETS {
            let (found, limit) = (items.len() as u64, MAX_TARGETS as u64);
            return Err(targets.refuse(LoadErrorKind::TooBig { what: "morph targets", found, limit }));
        }
        let mut morphs = Vec::new();
        for target in items {
            let mut list = |name| {
                let numbers = vertex_attribute(source, &target.member(name), &[3], count)?;
                let bytes = numbers.as_ref().map_or(0, |n| n.count() as u64 * 24);
                source.context.memory.reserve_result(bytes).map_err(|kind| target.refuse(kind))?;
                let vectors = |n: super::buffers::Numbers| n.elements(0.0).map(DVec3::from_array).collect();
                Ok::<Vec<DVec3>, LoadError>(numbers.map_or(Vec::new(), vectors))
            };
            morphs.push(Morph { positions: list("POSITION")?, normals: list("NORMAL")? });
        }
        Ok(morphs)
    }
}

/// Joints and weights of vertices, four each.
#[derive(Clone, Debug)]
pub(super) struct Skinning {
    vertices: Vec<([u16; 4], [f32; 4])>,
}

impl Skinning {
    /// Reads the first four joints of each vertex.
    pub(super) fn read(
        source: &mut Source,
        attributes: &Json,
        count: usize,
    ) -> Result<Option<Skinning>, LoadError> {
        if attributes.member("JOINTS_1").is_there() {
            source.warn(attributes.warning("joints of a vertex beyond the fourth are left out"));
        }
        let joints = vertex_attribute(source, &attributes.member("JOINTS_0"), &[4], count)?;
        let weights = vertex_attribute(source, &attributes.member("WEIGHTS_0"), &[4], count)?;
        let (Some(joints), Some(weights)) = (joints, weights) else { return Ok(None) };
        let bytes = count as u64 * size_of::<([u16; 4], [f32; 4])>() as u64;
        source.context.memory.reserve_result(bytes).map_err(|kind| attributes.refuse(kind))?;
        let pairs = joints.elements::<4>(0.0).zip(weights.elements::<4>(0.0));
        let vertices = pairs.map(|(j, w)| (j.map(|j| j as u16), w.map(|w| w as f32))).collect();
        Ok(Some(Skinning { vertices }))
    }

    /// Returns the greatest joint number that is used, if any is.
    pub(super) fn greatest_joint(&self) -> Option<u16> {
        let used = |(j, w): &([u16; 4], [f32; 4])| (0..4).filter(|i| w[*i] != 0.0).map(|i| j[i]).max();
        self.vertices.iter().filter_map(used).max()
    }
}

/// A skin: its joints as nodes, and the matrix to each joint's space.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    pub(super) joints: Vec<usize>,
    pub(super) inverse_bind: Vec<DMat4>,
}

impl Skin {
    /// Reads a skin of a file with `nodes` nodes.
    pub(super) fn read(source: &mut Source, json: &Json, nodes: usize) -> Result<Skin, LoadError> {
        let joints = json.member("joints").items()?;
        let joints = joints.iter().map(|j| j.index("node", nodes)).collect::<Result<Vec<_>, _>>()?;
        let matrices = json.member("inverseBindMatrices");
        let mut inverse_bind = vec![DMat4::IDENTITY; joints.len()];
        if matrices.is_there() {
            let numbers = attribute(source, &matrices, &[16])?;
            if numbers.count() < joints.len() {
                let reason = format!("{} matrices for {} joints", numbers.count(), joints.len());
                return Err(matrices.refuse(LoadErrorKind::Undecodable { format: "glTF", reason }));
            }
            let read = numbers.elements::<16>(0.0).map(|m| DMat4::from_cols_array(&m));
            inverse_bind.iter_mut().zip(read).for_each(|(slot, m)| *slot = m);
        }
        let bytes = (joints.len() * (size_of::<DMat4>() + 8)) as u64;
        source.context.memory.reserve_result(bytes).map_err(|kind| json.refuse(kind))?;
        Ok(Skin { joints, inverse_bind })
    }

    /// Returns the matrix of each joint, from the mesh's space to the world.
    pub(super) fn matrices(&self, world: &[DMat4]) -> Vec<DMat4> {
        self.joints.iter().zip(&self.inverse_bind).map(|(j, bind)| world[*j] * *bind).collect()
    }
}

/// Returns a primitive's geometry with its targets at these weights, bent by these joints, and its
/// maps, whose tangents turn with the vertices. Morph targets do not move tangents.
pub(super) fn posed(
    primitive: &Primitive,
    weights: &[f64],
    joints: Option<&[DMat4]>,
) -> (Arc<Geometry>, Option<Arc<SurfaceMaps>>) {
    let is_moved = weights.iter().zip(&primitive.morphs).any(|(w, _)| *w != 0.0);
    let skinning = primitive.skinning.as_ref().zip(joints);
    if !is_moved && skinning.is_none() {
        return (Arc::clone(&primitive.geometry), primitive.maps.clone());
    }
    let mut geometry = Geometry::clone(&primitive.geometry);
    let mesh = &mut geometry.mesh;
    // Normals of the file belong to vertices; those of flat faces are computed again.
    let is_smooth =
        mesh.normals.len() == mesh.positions.len() && mesh.corners.iter().all(|c| c.normal == c.position);
    for (morph, weight) in primitive.morphs.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
        let add = |to: &mut [DVec3], from: &[DVec3]| {
            to.iter_mut().zip(from).for_each(|(p, d)| *p += *d * *weight);
        };
        add(&mut mesh.positions, &morph.positions);
        if is_smooth {
            add(&mut mesh.normals, &morph.normals);
        }
    }
    let mut maps = primitive.maps.clone();
    let turns = maps.as_ref().is_some_and(|maps| maps.normal.is_some());
    let mut matrices = Vec::new();
    if let Some((skinning, joints)) = skinning {
        for (i, (numbers, weights)) in skinning.vertices.iter().enumerate() {
            let sum: f32 = weights.iter().sum();
            if sum.is_nan() || sum <= 0.0 {
                matrices.extend(turns.then_some(DMat4::IDENTITY));
                continue;
            }
            let mut matrix = DMat4::ZERO;
            for (number, weight) in numbers.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
                let joint = joints.get(usize::from(*number)).copied().unwrap_or(DMat4::IDENTITY);
                matrix += joint * f64::from(*weight / sum);
            }
            matrices.extend(turns.then_some(matrix));
            mesh.positions[i] = matrix.transform_point3(mesh.positions[i]);
            if is_smooth {
                // Exact for joints that turn and move alone.
                mesh.normals[i] = matrix.transform_vector3(mesh.normals[i]);
            }
        }
    }
    if let Some(maps) = maps.as_mut().filter(|_| !matrices.is_empty()) {
        turn_tangents(Arc::make_mut(maps), mesh, &matrices);
    }
    for position in &mut mesh.positions {
        if !position.is_finite() {
            *position = DVec3::ZERO;
        }
    }
    if is_smooth {
        mesh.normals.iter_mut().for_each(|n| *n = unit(*n).unwrap_or(DVec3::Z));
    } else if !mesh.normals.is_empty() {
        mesh.normals.clear();
        mesh::add_flat_normals(mesh);
    }
    (Arc::new(geometry), maps)
}

/// Turns the tangents of a mesh's corners by the matrices of its vertices.
fn turn_tangents(maps: &mut SurfaceMaps, mesh: &Mesh, matrices: &[DMat4]) {
    let Some(normal) = &mut maps.normal else { return };
    let turned = mesh.corners.iter().zip(&*normal.tangents).map(|(corner, tangent)| {
        let turned = matrices[corner.position as usize].transform_vector3(tangent.truncate());
        if turned.is_finite() { turned.extend(tangent.w) } else { DVec4::ZERO }
    });
    normal.tangents = turned.collect();
}

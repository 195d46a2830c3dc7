//! A mesh as the tile renderer wants it, made once: every distinct corner is one vertex with all its attributes.
//!
//! Positions stay f64 (they are transformed in f64); normals, texture coordinates and colours become f32 records of
//! four numbers, as the shading kernels gather them. Nothing here depends on camera, light or frame.

use crate::scene::{Corner, Mesh, NONE};
use glam::{DVec3, DVec4};
use std::collections::HashMap;

/// Above this, a texture coordinate no longer has the digits in f32 that a texel needs; such faces are drawn plainly.
const LARGEST_TEXCOORD: f64 = 16.0;

/// See the module's text.
#[derive(Clone, Debug, Default)]
pub struct PreparedMesh {
    /// Object-space positions, x of every vertex, then y, then z.
    pub positions: [Vec<f64>; 3],
    /// Three vertex indices a triangle, in file order.
    pub indices: Vec<i32>,
    /// Unit normals in object space; w is 0.
    pub normals: Vec<[f32; 4]>,
    /// u, v, and a spare pair.
    pub texcoords: Vec<[f32; 4]>,
    /// R, G, B, A.
    pub colors: Vec<[f32; 4]>,
    /// For each triangle, 1 where only the plain path has the digits that it needs.
    pub plain_only: Vec<bool>,
}

impl PreparedMesh {
    /// The prepared form of `mesh`, whose corners' unit normals in object space are `normals`, one a corner.
    pub fn new(mesh: &Mesh, normals: &[DVec3]) -> Self {
        let mut prepared = PreparedMesh::default();
        let mut known: HashMap<([u64; 3], Corner), i32> = HashMap::with_capacity(mesh.positions.len());
        let has_texcoords = !mesh.texcoords.is_empty();
        let has_colors = !mesh.colors.is_empty();
        for triangle in &mesh.triangles {
            let mut is_plain_only = false;
            for &at in triangle {
                let corner = mesh.corners[at as usize];
                let normal = normals.get(at as usize).copied().unwrap_or(DVec3::ZERO);
                let key = (normal.to_array().map(f64::to_bits), Corner { normal: NONE, ..corner });
                let vertex = *known.entry(key).or_insert_with(|| {
                    let p = mesh.positions[corner.position as usize];
                    for (axis, list) in prepared.positions.iter_mut().enumerate() {
                        list.push(p[axis]);
                    }
                    prepared.normals.push(normal.extend(0.0).as_vec4().to_array());
                    if has_texcoords {
                        let uv = mesh.texcoords.get(corner.texcoord as usize).copied().unwrap_or_default();
                        prepared.texcoords.push([uv.x as f32, uv.y as f32, 0.0, 0.0]);
                    }
                    if has_colors {
                        let c = mesh.colors.get(corner.color as usize).copied().unwrap_or(DVec4::ONE);
                        prepared.colors.push(c.as_vec4().to_array());
                    }
                    prepared.positions[0].len() as i32 - 1
                });
                prepared.indices.push(vertex);
                let uv = mesh.texcoords.get(corner.texcoord as usize).copied().unwrap_or_default();
                is_plain_only |= uv.is_nan() || uv.abs().max_element() > LARGEST_TEXCOORD;
            }
            prepared.plain_only.push(is_plain_only);
        }
        prepared
    }

    /// How many vertices there are.
    pub fn vertex_count(&self) -> usize {
        self.positions[0].len()
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// Bytes that the arrays take.
    pub fn size_bytes(&self) -> usize {
        self.vertex_count() * 24
            + (self.normals.len() + self.texcoords.len() + self.colors.len()) * 16
            + self.indices.len() * 4
            + self.plain_only.len()
    }
}

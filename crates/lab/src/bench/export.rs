//! Export of the workloads' meshes and texture as plain files, for other programs.

use super::space;
use super::{BenchOptions, Workload};
use fbptr_core::scene::{Corner, Filter, Mesh};
use std::collections::HashMap;

/// Name and bytes of a file.
pub type ExportedFile = (&'static str, Vec<u8>);

/// Returns the two knots as `.bin` files and the texture as `.rgba`.
///
/// A mesh file has the vertex count and triangle count as u32; 8 f32 per vertex: position, normal,
/// texture coordinate; 3 u32 per triangle, counter-clockwise from outside; all little-endian. The
/// texture file has RGBA rows, row 0 at t = 0.
pub fn export(options: &BenchOptions) -> Vec<ExportedFile> {
    let mesh = |workload| mesh_bytes(&space::Space::new(workload, options).subject().geometry.mesh);
    let textured = space::Space::new(Workload::Textured(Filter::Nearest), options);
    let texture = textured.subject().texture.as_ref();
    let rows = texture.map_or(Vec::new(), |t| {
        t.bytes().chunks_exact(t.width() as usize * 4).rev().flatten().copied().collect()
    });
    vec![
        ("knot70k.bin", mesh(Workload::Phong70k)),
        ("knot1m.bin", mesh(Workload::Phong1M)),
        ("texture.rgba", rows),
    ]
}

/// Encodes the mesh's triangles over vertices with equal attributes merged.
fn mesh_bytes(mesh: &Mesh) -> Vec<u8> {
    let mut numbers: HashMap<Corner, u32> = HashMap::new();
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for &at in mesh.triangles.iter().flatten() {
        let corner = mesh.corners[at as usize];
        let next = numbers.len() as u32;
        let number = *numbers.entry(corner).or_insert_with(|| {
            let position = mesh.positions[corner.position as usize];
            let normal = mesh.normals.get(corner.normal as usize).copied().unwrap_or_default();
            let uv = mesh.texcoords.get(corner.texcoord as usize).copied().unwrap_or_default();
            let all = position.to_array().into_iter().chain(normal.to_array()).chain(uv.to_array());
            vertices.extend(all.flat_map(|v| (v as f32).to_le_bytes()));
            next
        });
        indices.extend(number.to_le_bytes());
    }
    let counts = [numbers.len() as u32, mesh.triangles.len() as u32].map(u32::to_le_bytes);
    [counts.as_flattened(), &vertices, &indices].concat()
}

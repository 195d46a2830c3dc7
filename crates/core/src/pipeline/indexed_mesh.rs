//! Indexed mesh, built once: every distinct corner is one vertex with all its
//! attributes.
//!
//! Positions stay f64 (they are transformed in f64); normals, texture coordinates and colours
//! become f32 records of four numbers, as the shading kernels gather them. Vertices are in the
//! order in which the faces first use them, so neighbours are close in memory. Nothing here depends
//! on camera, light or frame.

mod clusters;
mod distinct;

use crate::cancel::CancelToken;
use crate::memory::OverBudget;
use crate::scene::{Corner, Mesh, NONE};
use crate::simd::allocator::prefer_huge_pages;
pub(crate) use clusters::{BLOCK_VERTICES, CLUSTER_BYTES, CLUSTER_FACES, Clusters, LEAST_FACES};
use distinct::{DISTINCT_BYTES, Distinct, VertexKey};
use glam::{DVec3, DVec4};

/// The index lists are padded to a multiple of this with faces without area.
const PADDING: usize = 16;

/// Smallest number of faces in a chunk of set-up work.
pub const CHUNK_FACES: usize = 4096;
/// Largest number of chunks: each has a list for each tile, and a bit in the tile's visitors.
pub const MOST_CHUNKS: usize = 64;

/// Returns the number of faces in a chunk of set-up work for a mesh of `faces` faces.
pub fn chunk_faces(faces: usize) -> usize {
    faces.div_ceil(MOST_CHUNKS).next_multiple_of(16).max(CHUNK_FACES)
}

/// Indexed mesh with its attributes as the kernels read them.
#[derive(Clone, Debug, Default)]
pub struct IndexedMesh {
    /// Object-space positions: x of every vertex, then y, then z.
    pub positions: [Vec<f64>; 3],
    /// Vertex indices of the triangles, in file order: first corners, second corners, third
    /// corners. Padded with vertex 0.
    pub corners: [Vec<i32>; 3],
    /// One record for each triangle: the bits of its three vertex indices and of its material's
    /// index.
    pub screen_vertices: Vec<[f32; 4]>,
    /// Number of triangles.
    pub triangle_count: usize,
    /// For each chunk of [`chunk_faces`] faces, the number of vertices that it and the chunks
    /// before it use.
    pub asked: Vec<u32>,
    /// Unit normals in object space; w is 0.
    pub normals: Vec<[f32; 4]>,
    /// u and v in f32, then their rounding errors: together they have 48 bits.
    pub texcoords: Vec<[f32; 4]>,
    /// Vertex colours: R, G, B, A.
    pub colors: Vec<[f32; 4]>,
    /// Index in `materials` of each triangle; empty if there is only one material.
    pub face_materials: Vec<i32>,
    /// One polygon of each material that occurs, in order of first occurrence.
    pub materials: Vec<u32>,
    /// Runs of vertices of one material: end of the run, and index in `materials`.
    pub vertex_runs: Vec<(usize, usize)>,
    /// Largest distance of positions from 0, for each axis.
    pub farthest: [f64; 3],
    /// Bounds of consecutive faces, for culling.
    pub clusters: Clusters,
}

/// Inputs of per-face shading: centres and normals, in object space.
#[derive(Clone, Debug, Default)]
pub struct FaceTable {
    /// Centre of each triangle's polygon: x of all, then y, then z.
    pub centers: [Vec<f64>; 3],
    /// Unit normal of each triangle's polygon; w is 0.
    pub normals: Vec<[f32; 4]>,
    /// Mean colour of each triangle's polygon; empty without colours.
    pub colors: Vec<[f32; 4]>,
}

impl IndexedMesh {
    /// Builds the indexed form of `mesh`. `normal_of` returns the unit normal in object space for a
    /// triangle and one of its corners.
    #[cfg(test)]
    pub fn new(mesh: &Mesh, normal_of: impl Fn(u32, &Corner) -> DVec3, cancel: &CancelToken) -> Self {
        IndexedMesh::within(mesh, normal_of, |_| Ok(()), cancel).expect("nothing refuses")
    }

    /// Returns an upper bound on the bytes that building takes with at most `vertices` vertices:
    /// its lists, those that deduplicate corners, and the old allocation of a list that moves.
    fn most_bytes(mesh: &Mesh, vertices: u64) -> u64 {
        let faces = mesh.triangles.len() as u64;
        let per = |is_there: bool, bytes: u64| if is_there { bytes } else { 0 };
        let lists = 24 + 16 + per(!mesh.texcoords.is_empty(), 16) + per(!mesh.colors.is_empty(), 16);
        // A cluster uses 48 blocks at most; lists have a capacity of up to twice their items.
        let clusters = faces.div_ceil(CLUSTER_FACES as u64) * (2 * CLUSTER_BYTES + 3 * 48 * 4) + vertices;
        let padded = faces + PADDING as u64;
        vertices * (lists + 24 + DISTINCT_BYTES)
            + padded * (12 + 16 + 4)
            + mesh.positions.len() as u64 * 4
            + mesh.materials.len() as u64 * 4
            + per(faces >= LEAST_FACES as u64, clusters)
    }

    /// Builds the indexed form, calling `room` before it allocates, with the total bytes from the
    /// first list on. Without faces if it is cancelled.
    ///
    /// # Errors
    /// Those of `room`.
    pub fn within(
        mesh: &Mesh,
        normal_of: impl Fn(u32, &Corner) -> DVec3,
        mut room: impl FnMut(u64) -> Result<(), OverBudget>,
        cancel: &CancelToken,
    ) -> Result<Self, OverBudget> {
        // Number of vertices if corners differ in one attribute only.
        let distinct = [mesh.positions.len(), mesh.normals.len(), mesh.texcoords.len(), mesh.colors.len()];
        let most = distinct.into_iter().max().unwrap_or(0).min(mesh.corners.len());
        room(Self::most_bytes(mesh, most as u64))?;
        let mut builder = Builder::new(mesh, most);
        for t in 0..mesh.triangles.len() {
            if t % CHUNK_FACES == 0 && cancel.is_cancelled() {
                return Ok(Self::default());
            }
            builder.add_triangle(t, &normal_of, &mut room)?;
        }
        let mut prepared = builder.finish(most);
        prepared.count_asked();
        prepared.clusters =
            Clusters::of(&prepared.positions, &prepared.corners, prepared.triangle_count, cancel);
        Ok(if cancel.is_cancelled() { Self::default() } else { prepared })
    }

    /// Makes lists for a mesh with `most` vertices.
    fn with_lists(mesh: &Mesh, most: usize) -> Self {
        let mut prepared = IndexedMesh { triangle_count: mesh.triangles.len(), ..Self::default() };
        for list in &mut prepared.corners {
            list.reserve(mesh.triangles.len() + PADDING);
            prefer_huge_pages(list);
        }
        for list in &mut prepared.positions {
            list.reserve(most);
            prefer_huge_pages(list);
        }
        for (list, is_used) in [
            (&mut prepared.normals, true),
            (&mut prepared.texcoords, !mesh.texcoords.is_empty()),
            (&mut prepared.colors, !mesh.colors.is_empty()),
        ] {
            list.reserve(if is_used { most } else { 0 });
            prefer_huge_pages(list);
        }
        prepared
    }

    /// Counts the vertices that each chunk and the chunks before it use.
    fn count_asked(&mut self) {
        let size = chunk_faces(self.triangle_count);
        let mut asked = 0;
        for start in (0..self.triangle_count).step_by(size) {
            let end = (start + size).min(self.triangle_count);
            for list in &self.corners {
                asked = list[start..end].iter().fold(asked, |asked, &v| asked.max(v as u32 + 1));
            }
            self.asked.push(asked);
        }
    }

    /// Returns the corners of a triangle in object space.
    pub fn points_of(&self, triangle: u32) -> [DVec3; 3] {
        let [xs, ys, zs] = &self.positions;
        self.corners.each_ref().map(|list| {
            let vertex = list[triangle as usize] as usize;
            DVec3::new(xs[vertex], ys[vertex], zs[vertex])
        })
    }

    /// Returns the number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions[0].len()
    }

    /// Returns the bytes of the arrays.
    pub fn size_bytes(&self) -> usize {
        self.clusters.size_bytes()
            + self.vertex_count() * 24
            + (self.normals.len() + self.texcoords.len() + self.colors.len()) * 16
            + (self.corners[0].len() * 7 + self.face_materials.len() + self.materials.len()) * 4
    }
}

/// Indexed mesh while its triangles are added.
struct Builder<'m> {
    mesh: &'m Mesh,
    prepared: IndexedMesh,
    /// Distinct corners so far: the vertices.
    distinct: Distinct,
    /// Number of vertices that there is room for.
    granted: usize,
    /// Index in `prepared.materials` of each of the mesh's materials, `u32::MAX` before it occurs;
    /// the last one is that of faces without a material.
    slots: Vec<u32>,
    /// Index in `prepared.materials` of each triangle.
    face_materials: Vec<i32>,
}

impl<'m> Builder<'m> {
    /// Makes lists for `most` vertices, for which there is room.
    fn new(mesh: &'m Mesh, most: usize) -> Self {
        Builder {
            mesh,
            slots: vec![u32::MAX; mesh.materials.len() + 1],
            distinct: Distinct::new(mesh.positions.len()),
            face_materials: Vec::with_capacity(mesh.triangles.len()),
            prepared: IndexedMesh::with_lists(mesh, most),
            granted: most,
        }
    }

    /// Adds a triangle and those of its corners that are new vertices.
    fn add_triangle(
        &mut self,
        t: usize,
        normal_of: &impl Fn(u32, &Corner) -> DVec3,
        room: &mut impl FnMut(u64) -> Result<(), OverBudget>,
    ) -> Result<(), OverBudget> {
        let mesh = self.mesh;
        let slot = self.slot_of(mesh.triangle_polygon[t]);
        self.face_materials.push(slot as i32);
        for (k, &at) in mesh.triangles[t].iter().enumerate() {
            let corner = mesh.corners[at as usize];
            let key = (Corner { normal: NONE, ..corner }, slot, normal_of(t as u32, &corner));
            let vertex = match self.distinct.find(&key) {
                Some(vertex) => vertex,
                None => {
                    if self.distinct.len() == self.granted {
                        self.granted = 2 * self.granted.max(4);
                        room(IndexedMesh::most_bytes(mesh, self.granted as u64))?;
                    }
                    self.add_vertex(key)
                }
            };
            self.prepared.corners[k].push(vertex);
        }
        Ok(())
    }

    /// Returns the index of a polygon's material in the list of those that occur.
    fn slot_of(&mut self, polygon: u32) -> u32 {
        let material = self.mesh.polygons[polygon as usize].material as usize;
        let slot = &mut self.slots[material.min(self.mesh.materials.len())];
        if *slot == u32::MAX {
            *slot = self.prepared.materials.len() as u32;
            self.prepared.materials.push(polygon);
        }
        *slot
    }

    /// Adds a vertex with its attributes, and returns its index.
    fn add_vertex(&mut self, key: VertexKey) -> i32 {
        let (mesh, prepared) = (self.mesh, &mut self.prepared);
        let (corner, slot, normal) = key;
        let vertex = self.distinct.len() as i32;
        self.distinct.add(key);
        let p = mesh.positions[corner.position as usize];
        for (axis, list) in prepared.positions.iter_mut().enumerate() {
            list.push(p[axis]);
        }
        prepared.normals.push(normal.extend(0.0).as_vec4().to_array());
        if !mesh.texcoords.is_empty() {
            let uv = mesh.texcoords.get(corner.texcoord as usize).copied().unwrap_or_default();
            let near = [uv.x as f32, uv.y as f32];
            let rest = [uv.x - near[0] as f64, uv.y - near[1] as f64];
            prepared.texcoords.push([near[0], near[1], rest[0] as f32, rest[1] as f32]);
        }
        if !mesh.colors.is_empty() {
            let c = mesh.colors.get(corner.color as usize).copied().unwrap_or(DVec4::ONE);
            prepared.colors.push(c.as_vec4().to_array());
        }
        match prepared.vertex_runs.last_mut() {
            Some((end, last)) if *last == slot as usize => *end += 1,
            _ => prepared.vertex_runs.push((vertex as usize + 1, slot as usize)),
        }
        vertex
    }

    /// Returns the mesh with its lists as long as the kernels expect them; there was room for
    /// `most` vertices at first.
    fn finish(self, most: usize) -> IndexedMesh {
        let Builder { mesh, mut prepared, face_materials, .. } = self;
        if prepared.vertex_count() > most {
            prepared.positions.iter_mut().for_each(Vec::shrink_to_fit);
            [&mut prepared.normals, &mut prepared.texcoords, &mut prepared.colors]
                .into_iter()
                .for_each(Vec::shrink_to_fit);
        }
        prepared.screen_vertices.reserve_exact(mesh.triangles.len());
        prefer_huge_pages(&mut prepared.screen_vertices);
        prepared.screen_vertices.extend((0..mesh.triangles.len()).map(|t| {
            let bits = |v: i32| f32::from_bits(v as u32);
            let [a, b, c] = &prepared.corners;
            [bits(a[t]), bits(b[t]), bits(c[t]), bits(face_materials[t])]
        }));
        for list in &mut prepared.corners {
            list.resize(mesh.triangles.len().next_multiple_of(PADDING), 0);
        }
        if prepared.materials.len() > 1 {
            prepared.face_materials = face_materials;
        }
        let far = |list: &Vec<f64>| list.iter().fold(0.0f64, |far, v| far.max(v.abs()));
        prepared.farthest = prepared.positions.each_ref().map(far);
        prepared
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;

    #[test]
    fn corners_that_agree_are_one_vertex_and_seams_are_two() {
        let mesh = shapes::knot(12, 5).expect("a knot");
        let unit = |_: u32, c: &Corner| mesh.normals[c.normal as usize].normalize();
        let prepared = IndexedMesh::new(&mesh, unit, &Default::default());
        assert_eq!(prepared.triangle_count, 120);
        assert_eq!(prepared.corners[0].len(), 128);
        assert!(prepared.vertex_count() <= mesh.corners.len() && prepared.vertex_count() >= 60);
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for (k, &at) in triangle.iter().enumerate() {
                let vertex = prepared.corners[k][t] as usize;
                let corner = mesh.corners[at as usize];
                let p = mesh.positions[corner.position as usize].to_array();
                assert_eq!([0, 1, 2].map(|a| prepared.positions[a][vertex]), p);
                let n = unit(0, &corner).as_vec3().to_array();
                assert_eq!(prepared.normals[vertex][..3], n);
            }
        }
        assert!(prepared.face_materials.is_empty() && prepared.materials.len() == 1);
        assert_eq!(prepared.vertex_runs, [(prepared.vertex_count(), 0)]);
    }

    #[test]
    fn the_stated_bytes_are_enough_and_not_many_times_more() {
        for mesh in [
            Mesh::from_triangles(vec![DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2]]),
            shapes::cuboid(DVec3::ONE).unwrap(),
            shapes::knot(12, 5).unwrap(),
            shapes::knot(80, 30).unwrap(),
        ] {
            let mut asked = 0;
            let normal_of = |_: u32, _: &Corner| DVec3::Z;
            let room = |bytes| {
                asked = bytes;
                Ok(())
            };
            let made = IndexedMesh::within(&mesh, normal_of, room, &Default::default()).unwrap();
            let (held, faces) = (made.size_bytes() as u64, mesh.triangles.len());
            assert!((held..5 * held + 4096).contains(&asked), "{faces} faces: {asked} for {held}");
        }
    }
}

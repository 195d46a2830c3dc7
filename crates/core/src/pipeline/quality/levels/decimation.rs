//! Surface of a mesh while it loses vertices.
//!
//! In: a mesh. Out: meshes of fewer faces, each with a bound on the change of every point.
//!
//! Vertices are removed in passes, in the order of their numbers: a vertex goes to the neighbour for
//! which its star changes least ([`Star`]), if all its faces then stay within the pass's limit. Each
//! face keeps the change of its points so far; a new face has the largest one of the star that it
//! replaces, and the bound of the step. A step maps the old star onto the new one, one to one, so
//! all steps together map the first surface onto the last, and by the triangle inequality no point,
//! normal or colour changes by more than its face says. In a pass no star overlaps another.
//!
//! A vertex stays if its faces do not form one closed ring of equal materials, if it has several
//! normals or colours, or if a neighbour has several within the ring: borders, seams, creases and
//! non-manifold places are not touched. Positions with equal coordinates are one vertex. Texture
//! coordinates are left out.

use super::star::{Change, MOST_NEIGHBOURS, Point, Star};
use crate::cancel::{CancelToken, NEVER};
use crate::math::matrix::unit;
use crate::pipeline::normals::Normals;
use crate::scene::{Corner, Mesh, NONE};
use glam::{DVec3, DVec4};
use std::collections::HashMap;

/// Part of the vertices that a pass must remove to be followed by another within the same limit.
const LEAST_GAIN: f64 = 0.08;

/// Largest number of passes within the same limit.
const MOST_PASSES: usize = 12;

/// Vertices between two checks of the cancel token.
const VERTICES_AT_ONCE: usize = 4096;

/// Triangle: indices of its corners' points, of its material, and of the mesh's triangle that it
/// was at first.
#[derive(Clone, Copy, Debug)]
struct Face {
    points: [u32; 3],
    material: u32,
    origin: u32,
    change: Change,
}

/// Surface that loses vertices.
#[derive(Debug)]
pub(super) struct Decimation {
    /// Distinct corners.
    points: Vec<Point>,
    /// Vertex of each point.
    vertex_of: Vec<u32>,
    /// True for vertices that stay.
    is_fixed: Vec<bool>,
    faces: Vec<Face>,
    has_colors: bool,
}

/// Returns bits by which equal values are told: 0 and -0 are equal.
fn bits(v: DVec3) -> [u64; 3] {
    (v + DVec3::ZERO).to_array().map(f64::to_bits)
}

impl Decimation {
    /// Takes the triangles of a mesh whose indices are in range; `None` if it is cancelled, or if a
    /// triangle with area has no normal.
    pub fn of(mesh: &Mesh, cancel: &CancelToken) -> Option<Decimation> {
        let mut vertices: HashMap<[u64; 3], u32> = HashMap::with_capacity(mesh.positions.len());
        let vertex_at = |p: &DVec3| {
            let next = vertices.len() as u32;
            *vertices.entry(bits(*p)).or_insert(next)
        };
        let of_position: Vec<u32> = mesh.positions.iter().map(vertex_at).collect();
        let count = vertices.len();
        drop(vertices);
        let has_own = |c: &Corner| mesh.normals.get(c.normal as usize).and_then(|n| unit(*n)).is_some();
        let normals = Normals::of(mesh, !mesh.corners.iter().all(has_own), &NEVER);
        let mut surface = Decimation {
            points: Vec::with_capacity(count),
            vertex_of: Vec::with_capacity(count),
            is_fixed: vec![false; count],
            faces: Vec::with_capacity(mesh.triangles.len()),
            has_colors: !mesh.colors.is_empty(),
        };
        // Points of a vertex are chained.
        let (mut first, mut next) = (vec![NONE; count], Vec::with_capacity(count));
        for (t, (triangle, polygon)) in mesh.triangles.iter().zip(&mesh.triangle_polygon).enumerate() {
            if t % VERTICES_AT_ONCE == 0 && cancel.is_cancelled() {
                return None;
            }
            let corners = triangle.map(|c| mesh.corners[c as usize]);
            let face_normal = normals.of_polygon[*polygon as usize];
            let points = corners.map(|corner| {
                let given = mesh.normals.get(corner.normal as usize).and_then(|n| unit(*n));
                let mean = normals.of_position.get(corner.position as usize).filter(|n| **n != DVec3::ZERO);
                let point = Point {
                    position: mesh.positions[corner.position as usize],
                    normal: given.or(mean.copied()).unwrap_or(face_normal),
                    color: mesh.colors.get(corner.color as usize).copied().unwrap_or(DVec4::ONE),
                };
                surface.index_of(point, of_position[corner.position as usize], &mut first, &mut next)
            });
            let has_no_normal = |p: &u32| surface.points[*p as usize].normal == DVec3::ZERO;
            if points.iter().any(has_no_normal) {
                return None;
            }
            let material = mesh.polygons[*polygon as usize].material;
            let change = Change::default();
            surface.faces.push(Face { points, material, origin: t as u32, change });
        }
        Some(surface)
    }

    /// Returns the index of a point of a vertex; adds it if it is new.
    fn index_of(&mut self, point: Point, vertex: u32, first: &mut [u32], next: &mut Vec<u32>) -> u32 {
        let mut at = first[vertex as usize];
        // A vertex of two points stays; more of them need not be told apart.
        for _ in 0..MOST_NEIGHBOURS {
            if at == NONE {
                break;
            }
            let known = &self.points[at as usize];
            if known.normal == point.normal && known.color == point.color {
                return at;
            }
            at = next[at as usize];
        }
        let index = self.points.len() as u32;
        self.is_fixed[vertex as usize] = first[vertex as usize] != NONE;
        next.push(first[vertex as usize]);
        first[vertex as usize] = index;
        self.points.push(point);
        self.vertex_of.push(vertex);
        index
    }

    /// Returns the number of faces.
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// Returns a bound on the change of all points so far.
    pub fn change(&self) -> Change {
        self.faces.iter().fold(Change::default(), |most, face| most.max(face.change))
    }

    /// Removes vertices as long as that pays and the changes stay within `limit`. Returns `None` if
    /// it is cancelled.
    pub fn simplify(&mut self, limit: &Change, cancel: &CancelToken) -> Option<()> {
        for _ in 0..MOST_PASSES {
            let before = self.faces.len();
            Pass::new(self, *limit).run(cancel)?;
            self.faces.retain(|face| face.points[0] != NONE);
            if ((before - self.faces.len()) as f64) < LEAST_GAIN * before as f64 {
                break;
            }
        }
        Some(())
    }

    /// Returns the surface as a mesh with these materials' indices, and for each of its triangles
    /// the one that it was at first.
    pub fn to_mesh(&self) -> (Mesh, Vec<u32>) {
        let mut mesh = Mesh::default();
        let mut index = vec![NONE; self.points.len()];
        for face in &self.faces {
            let corners = face.points.map(|p| {
                let point = &self.points[p as usize];
                let known = &mut index[p as usize];
                if *known == NONE {
                    *known = mesh.positions.len() as u32;
                    mesh.positions.push(point.position);
                    mesh.normals.push(point.normal);
                    if self.has_colors {
                        mesh.colors.push(point.color);
                    }
                }
                let color = if self.has_colors { *known } else { NONE };
                Corner { position: *known, normal: *known, texcoord: NONE, color }
            });
            mesh.push_polygon(&corners, face.material);
        }
        mesh.shrink_to_fit();
        (mesh, self.faces.iter().map(|face| face.origin).collect())
    }
}

/// Pass over all vertices of a surface, each star of which changes at most once.
struct Pass<'s> {
    surface: &'s mut Decimation,
    limit: Change,
    /// Faces of vertex v are `faces_at[starts[v]..starts[v + 1]]`.
    starts: Vec<u32>,
    faces_at: Vec<u32>,
    /// True for vertices whose faces were changed in this pass.
    is_changed: Vec<bool>,
}

/// Ring of a vertex: its faces in order, counter-clockwise, and the point of each from which the
/// face's outer edge starts.
struct Ring {
    faces: [u32; MOST_NEIGHBOURS],
    points: [u32; MOST_NEIGHBOURS],
    len: usize,
}

impl<'s> Pass<'s> {
    fn new(surface: &'s mut Decimation, limit: Change) -> Pass<'s> {
        let count = surface.is_fixed.len();
        let mut starts = vec![0u32; count + 1];
        let vertices = |face: &Face| face.points.map(|p| surface.vertex_of[p as usize] as usize);
        for face in &surface.faces {
            vertices(face).iter().for_each(|v| starts[v + 1] += 1);
        }
        for v in 0..count {
            starts[v + 1] += starts[v];
        }
        let (mut faces_at, mut ends) = (vec![0u32; 3 * surface.faces.len()], starts.clone());
        for (f, face) in surface.faces.iter().enumerate() {
            for v in vertices(face) {
                faces_at[ends[v] as usize] = f as u32;
                ends[v] += 1;
            }
        }
        Pass { surface, limit, starts, faces_at, is_changed: vec![false; count] }
    }

    /// Goes over all vertices. Returns `None` if it is cancelled.
    fn run(mut self, cancel: &CancelToken) -> Option<()> {
        for vertex in 0..self.surface.is_fixed.len() {
            if vertex % VERTICES_AT_ONCE == 0 && cancel.is_cancelled() {
                return None;
            }
            if !self.surface.is_fixed[vertex] && !self.is_changed[vertex] {
                self.try_remove(vertex as u32);
            }
        }
        Some(())
    }

    /// Returns the faces of a vertex that is not changed yet.
    fn faces_of(&self, vertex: u32) -> &[u32] {
        &self.faces_at[self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize]
    }

    fn vertex_of(&self, point: u32) -> u32 {
        self.surface.vertex_of[point as usize]
    }

    /// Returns the point of a vertex, and its ring, if that is closed and all within it are equal.
    fn ring_of(&self, vertex: u32) -> Option<(u32, Ring)> {
        let faces = self.faces_of(vertex);
        let len = faces.len();
        if !(3..=MOST_NEIGHBOURS).contains(&len) {
            return None;
        }
        let surface = &*self.surface;
        // Center, start and end of each face's outer edge.
        let mut edges = [[0u32; 3]; MOST_NEIGHBOURS];
        for (edge, f) in edges.iter_mut().zip(faces) {
            let [a, b, c] = surface.faces[*f as usize].points;
            *edge = match [a, b, c].map(|p| self.vertex_of(p) == vertex) {
                [true, false, false] => [a, b, c],
                [false, true, false] => [b, c, a],
                [false, false, true] => [c, a, b],
                _ => return None,
            };
        }
        let material = surface.faces[faces[0] as usize].material;
        let mut ring = Ring { faces: [0; MOST_NEIGHBOURS], points: [0; MOST_NEIGHBOURS], len };
        let mut at = 0;
        for i in 0..len {
            let is_same = surface.faces[faces[at] as usize].material == material;
            if !is_same || edges[at][0] != edges[0][0] || (i > 0 && at == 0) {
                return None;
            }
            (ring.faces[i], ring.points[i]) = (faces[at], edges[at][1]);
            at = edges[..len].iter().position(|edge| edge[1] == edges[at][2])?;
        }
        (at == 0).then_some((edges[0][0], ring))
    }

    /// Removes a vertex if its star then changes within the limit.
    fn try_remove(&mut self, vertex: u32) {
        let Some((center, ring)) = self.ring_of(vertex) else { return };
        let points = &self.surface.points;
        let mut around = [points[center as usize]; MOST_NEIGHBOURS];
        for (point, at) in around.iter_mut().zip(&ring.points[..ring.len]) {
            *point = points[*at as usize];
        }
        let Some(star) = Star::of(&points[center as usize], &around[..ring.len]) else { return };
        let mut before = [Change::default(); MOST_NEIGHBOURS];
        for (change, f) in before.iter_mut().zip(&ring.faces[..ring.len]) {
            *change = self.surface.faces[*f as usize].change;
        }
        let mut best: Option<(f64, usize)> = None;
        for v in 0..ring.len {
            if self.is_changed[self.vertex_of(ring.points[v]) as usize] {
                continue;
            }
            if let Some(cost) = star.cost(v, &self.limit)
                && best.is_none_or(|(least, _)| cost < least)
                && self.keeps_manifold(&ring, v)
            {
                best = Some((cost, v));
            }
        }
        let Some((_, v)) = best else { return };
        let Some(after) = star.change(v, &before[..ring.len]) else { return };
        if after[1..ring.len - 1].iter().all(|change| change.is_within(self.limit)) {
            self.replace(vertex, &ring, v, &after);
        }
    }

    /// Returns whether no edge of the fan from neighbour `v` exists already outside of the star.
    fn keeps_manifold(&self, ring: &Ring, v: usize) -> bool {
        // Of a vertex with many faces each would be looked at for each other neighbour.
        let around = self.faces_of(self.vertex_of(ring.points[v]));
        if around.len() > MOST_NEIGHBOURS {
            return false;
        }
        let others = (2..ring.len - 1).map(|k| self.vertex_of(ring.points[(v + k) % ring.len]));
        let is_neighbour = |vertex: u32| {
            around
                .iter()
                .any(|f| self.surface.faces[*f as usize].points.iter().any(|p| self.vertex_of(*p) == vertex))
        };
        !others.into_iter().any(is_neighbour)
    }

    /// Replaces the star of a vertex by the fan from neighbour `v`.
    fn replace(&mut self, vertex: u32, ring: &Ring, v: usize, changes: &[Change; MOST_NEIGHBOURS]) {
        let len = ring.len;
        for (k, change) in changes[..len].iter().enumerate() {
            let face = &mut self.surface.faces[ring.faces[(v + k) % len] as usize];
            // The first and the last face have the edge from the vertex to v.
            if k == 0 || k == len - 1 {
                face.points = [NONE; 3];
                continue;
            }
            for point in &mut face.points {
                if self.surface.vertex_of[*point as usize] == vertex {
                    *point = ring.points[v];
                }
            }
            face.change = *change;
        }
        self.is_changed[vertex as usize] = true;
        for point in &ring.points[..len] {
            self.is_changed[self.surface.vertex_of[*point as usize] as usize] = true;
        }
    }
}

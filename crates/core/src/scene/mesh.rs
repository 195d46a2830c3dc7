//! Meshes: n-gons as the file gives them, and their triangulation.

use super::Material;
use glam::{DVec2, DVec3, DVec4};

/// Marks a missing attribute in a [`Corner`] or [`Polygon`].
pub const NONE: u32 = u32::MAX;

/// Corner of a polygon: indices into the mesh's arrays, [`NONE`] where the file gives nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Corner {
    /// Index into `positions`. Corners with equal indices are the same vertex.
    pub position: u32,
    /// Index into `normals`.
    pub normal: u32,
    /// Index into `texcoords`.
    pub texcoord: u32,
    /// Index into `colors`.
    pub color: u32,
}

/// Polygon of the file: a run of `corners`, counter-clockwise seen from its front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Polygon {
    /// Index of the first corner in `Mesh::corners`.
    pub first_corner: u32,
    /// Number of corners, at least 3.
    pub corner_count: u32,
    /// Index into `Mesh::materials`, or [`NONE`].
    pub material: u32,
}

/// Surface in object space, with lines and points where the file has them.
///
/// Positions are finite. Each entry of `triangles` is three indices into `corners`; triangle i
/// belongs to polygon `triangle_polygon[i]`. Triangles are in file order: convex n-gons are fanned
/// at their first corner, concave ones are cut into ears, in order. PICK counts triangles in this
/// order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions in object space.
    pub positions: Vec<DVec3>,
    /// Normals of the file, in object space, of any length.
    pub normals: Vec<DVec3>,
    /// Texture coordinates, (0,0) at the lower left of the texture.
    pub texcoords: Vec<DVec2>,
    /// Vertex colours R,G,B,A; 1 is full.
    pub colors: Vec<DVec4>,
    /// Corners of all polygons, one run after the other.
    pub corners: Vec<Corner>,
    /// Polygons in file order.
    pub polygons: Vec<Polygon>,
    /// Corner indices, three a triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Polygon number of each triangle.
    pub triangle_polygon: Vec<u32>,
    /// Line segments, as pairs of corner indices.
    pub lines: Vec<[u32; 2]>,
    /// Points, as corner indices.
    pub points: Vec<u32>,
    /// Material index of each line segment, or `NONE`; empty if all have the draw's material.
    pub line_materials: Vec<u32>,
    /// Material index of each point, or `NONE`; empty if all have the draw's material.
    pub point_materials: Vec<u32>,
    /// Materials that the file names.
    pub materials: Vec<Material>,
}

impl Mesh {
    /// Creates a mesh of plain triangles over shared positions. Smooth normals are derived from the
    /// faces when it is drawn. A draw refuses a mesh with an index that is not a position.
    pub fn from_triangles(positions: Vec<DVec3>, triangles: &[[u32; 3]]) -> Self {
        let mut mesh = Mesh { positions, ..Mesh::default() };
        for t in triangles {
            let corners = t.map(|position| Corner { position, normal: NONE, texcoord: NONE, color: NONE });
            mesh.push_polygon(&corners, NONE);
        }
        mesh
    }

    /// Adds a polygon. A convex one is fanned at its first corner, a concave one is cut into ears,
    /// in order.
    ///
    /// Fewer than three corners add nothing. A draw refuses a mesh with indices that are not valid.
    pub fn push_polygon(&mut self, corners: &[Corner], material: u32) {
        if corners.len() < 3 {
            return;
        }
        let first_corner = self.corners.len() as u32;
        let polygon = self.polygons.len() as u32;
        self.corners.extend_from_slice(corners);
        self.polygons.push(Polygon { first_corner, corner_count: corners.len() as u32, material });
        if corners.len() == 3 {
            self.triangles.push([first_corner, first_corner + 1, first_corner + 2]);
            self.triangle_polygon.push(polygon);
            return;
        }
        let position = |c: &Corner| self.positions.get(c.position as usize).copied().unwrap_or_default();
        let points: Vec<DVec3> = corners.iter().map(position).collect();
        for t in crate::math::polygon::triangulate(&points) {
            self.triangles.push(t.map(|i| first_corner + i));
            self.triangle_polygon.push(polygon);
        }
    }

    /// Returns the corners of polygon number `polygon`, counter-clockwise; none if there is no such
    /// polygon.
    pub fn polygon_corners(&self, polygon: usize) -> &[Corner] {
        let corners_of = |p: &Polygon| {
            let first = p.first_corner as usize;
            self.corners.get(first..first.checked_add(p.corner_count as usize)?)
        };
        self.polygons.get(polygon).and_then(corners_of).unwrap_or_default()
    }

    /// Returns the low and high corner of the object-space box around all positions, or `None`
    /// without any position.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.positions.first()?;
        Some(self.positions.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p))))
    }

    /// Releases the unused capacity of the arrays.
    pub fn shrink_to_fit(&mut self) {
        self.positions.shrink_to_fit();
        self.normals.shrink_to_fit();
        self.texcoords.shrink_to_fit();
        self.colors.shrink_to_fit();
        self.corners.shrink_to_fit();
        self.polygons.shrink_to_fit();
        self.triangles.shrink_to_fit();
        self.triangle_polygon.shrink_to_fit();
        self.lines.shrink_to_fit();
        self.points.shrink_to_fit();
        self.line_materials.shrink_to_fit();
        self.point_materials.shrink_to_fit();
        self.materials.shrink_to_fit();
    }

    /// Returns the bytes of the arrays' capacity and of the materials' names.
    pub fn size_bytes(&self) -> usize {
        fn of<T>(v: &Vec<T>) -> usize {
            v.capacity() * size_of::<T>()
        }
        let name = |m: &Material| m.name.capacity() + m.texture.as_ref().map_or(0, String::capacity);
        of(&self.positions)
            + of(&self.normals)
            + of(&self.texcoords)
            + of(&self.colors)
            + of(&self.corners)
            + of(&self.polygons)
            + of(&self.triangles)
            + of(&self.triangle_polygon)
            + of(&self.lines)
            + of(&self.points)
            + of(&self.line_materials)
            + of(&self.point_materials)
            + of(&self.materials)
            + self.materials.iter().map(name).sum::<usize>()
    }
}

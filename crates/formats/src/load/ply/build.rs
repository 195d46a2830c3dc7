//! The rows of a PLY file as a mesh.
//!
//! In: the rows of all elements. Out: a mesh, or an error with the byte at which its row ends.
//! Indices are checked here, because faces may come before the vertices.

use super::elements::Elements;
use super::rows::List;
use crate::load::LoadErrorKind;
use crate::load::mesh::PolygonSizes;
use fbptr_core::scene::{Corner, Mesh, NONE};
use glam::DVec2;

/// Makes the mesh. A file without faces, strips and edges gives points.
pub(super) fn mesh(elements: Elements) -> Result<Mesh, (usize, LoadErrorKind)> {
    let Elements { vertices, faces, strips, edges } = elements;
    let count = vertices.positions.len();
    // Of several vertex elements not all need have the same properties.
    let lengths = [vertices.normals.len(), vertices.texcoords.len(), vertices.colors.len()];
    let has = lengths.map(|length| length == count && count > 0);
    let mesh = Mesh {
        positions: vertices.positions,
        normals: vertices.normals,
        texcoords: vertices.texcoords,
        colors: vertices.colors,
        ..Mesh::default()
    };
    let mut builder = Builder { mesh, sizes: PolygonSizes::default(), has, corners: Vec::new() };
    for row in &faces.rows {
        let indices = &faces.indices[row.indices.clone()];
        builder.face(indices, count, row, &faces.texcoords).map_err(|kind| (row.at, kind))?;
    }
    for row in &strips.rows {
        for strip in strips.indices[row.indices.clone()].split(|index| *index == -1) {
            builder.strip(strip, count).map_err(|kind| (row.at, kind))?;
        }
    }
    for (at, ends) in &edges.0 {
        builder.set_corners(ends, count).map_err(|kind| (*at, kind))?;
        builder.sizes.add(2, false).map_err(|kind| (*at, kind))?;
        let first = builder.mesh.corners.len() as u32;
        builder.mesh.corners.append(&mut builder.corners);
        builder.mesh.lines.push([first, first + 1]);
    }
    if faces.rows.is_empty() && strips.rows.is_empty() && edges.0.is_empty() {
        let all = 0..count as u32;
        builder.mesh.corners = all.clone().map(|position| builder.corner(position)).collect();
        builder.mesh.points = all.collect();
    }
    Ok(builder.mesh)
}

/// A mesh in the making.
struct Builder {
    mesh: Mesh,
    sizes: PolygonSizes,
    /// Presence of normals, texture coordinates and colours at vertices.
    has: [bool; 3],
    /// Corners of the polygon that is being added.
    corners: Vec<Corner>,
}

impl Builder {
    /// Returns the corner of a vertex, with its attributes.
    fn corner(&self, position: u32) -> Corner {
        let [normal, texcoord, color] = self.has.map(|has| if has { position } else { NONE });
        Corner { position, normal, texcoord, color }
    }

    /// Sets `corners` to those of the vertices with these indices, of `count`.
    fn set_corners(&mut self, indices: &[i64], count: usize) -> Result<(), LoadErrorKind> {
        self.corners.clear();
        for &index in indices {
            let vertex = u32::try_from(index).ok().filter(|i| (*i as usize) < count);
            let wrong = LoadErrorKind::Index { what: "vertex", index, count: count as u64 };
            let corner = self.corner(vertex.ok_or(wrong)?);
            self.corners.push(corner);
        }
        Ok(())
    }

    /// Adds a face with its own colour and texture coordinates, if vertices have none. Fewer than
    /// three corners are none.
    fn face(
        &mut self,
        indices: &[i64],
        count: usize,
        row: &List,
        texcoords: &[DVec2],
    ) -> Result<(), LoadErrorKind> {
        self.set_corners(indices, count)?;
        self.sizes.add(indices.len(), true)?;
        if indices.len() < 3 {
            return Ok(());
        }
        let own = &texcoords[row.texcoords.clone()];
        if !self.has[1] && own.len() == indices.len() {
            let numbers = self.mesh.texcoords.len() as u32..;
            self.corners.iter_mut().zip(numbers).for_each(|(corner, number)| corner.texcoord = number);
            self.mesh.texcoords.extend_from_slice(own);
        }
        if let (false, Some(color)) = (self.has[2], row.color) {
            let number = self.mesh.colors.len() as u32;
            self.corners.iter_mut().for_each(|corner| corner.color = number);
            self.mesh.colors.push(color);
        }
        self.mesh.push_polygon(&self.corners, NONE);
        Ok(())
    }

    /// Adds the triangles of a strip: every second one has its corners in the other order.
    fn strip(&mut self, indices: &[i64], count: usize) -> Result<(), LoadErrorKind> {
        for (k, t) in indices.windows(3).enumerate() {
            let t = if k % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            self.set_corners(&t, count)?;
            // Triangles without area join the parts of a strip.
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                self.sizes.add(3, true)?;
                self.mesh.push_polygon(&self.corners, NONE);
            }
        }
        Ok(())
    }
}

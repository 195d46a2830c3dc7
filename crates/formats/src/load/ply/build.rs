//! The rows of a PLY file as a mesh.
//!
//! In: the rows of all elements. Out: a mesh, without the rows that name a vertex that is not there.
//! Indices are checked here, because faces may come before the vertices.

use super::elements::Elements;
use super::reader::Reader;
use super::rows::List;
use crate::load::defects::Defects;
use crate::load::mesh::PolygonSizes;
use crate::load::{LoadError, LoadErrorKind};
use fbptr_core::scene::{Corner, Mesh, NONE};
use glam::{DVec2, DVec4};

/// The mesh of a file, and the rows that it is made without.
pub(super) struct Built {
    pub(super) mesh: Mesh,
    /// Rows that name a vertex that is not there.
    pub(super) indices: Defects,
}

/// Makes the mesh. A file without faces, strips and edges gives points. `textures` is the number of
/// textures, each of which becomes a material.
pub(super) fn mesh(elements: Elements, reader: &Reader, textures: usize) -> Result<Built, LoadError> {
    let has_elements = elements.has_elements();
    let Elements { mut vertices, faces, strips, edges, .. } = elements;
    let count = vertices.positions.len();
    // Of several vertex elements not all need have the same properties.
    let lengths = [vertices.normals.len(), vertices.texcoords.len(), vertices.colors.len()];
    let has = lengths.map(|length| length == count && count > 0);
    // The box around the positions holds those that are used alone.
    let usable = (0..count).find(|i| vertices.unusable.get(*i) != Some(&(*i as u32)));
    if let Some(usable) = usable.map(|i| vertices.positions[i]) {
        vertices.unusable.iter().for_each(|i| vertices.positions[*i as usize] = usable);
    }
    let mesh = Mesh {
        positions: vertices.positions,
        normals: vertices.normals,
        texcoords: vertices.texcoords,
        colors: vertices.colors,
        ..Mesh::default()
    };
    let unusable = vertices.unusable;
    let sizes = PolygonSizes::default();
    let mut builder =
        Builder { mesh, sizes, has, corners: Vec::new(), unusable, indices: Defects::default(), textures };
    let refuse = |place, kind| LoadError::new(reader.position(place), kind);
    for row in &faces.rows {
        let indices = &faces.indices[row.indices.clone()];
        let added = builder.face(indices, row, &faces.texcoords);
        builder.note(added, |kind| refuse(row.place, kind))?;
    }
    for row in &strips.rows {
        for strip in strips.indices[row.indices.clone()].split(|index| *index == -1) {
            builder.strip(strip, |kind| refuse(row.place, kind))?;
        }
    }
    for (place, ends) in &edges.rows {
        let added = builder.edge(ends);
        builder.note(added, |kind| refuse(*place, kind))?;
    }
    if !has_elements {
        let all = (0..count as u32).filter(|i| builder.unusable.binary_search(i).is_err());
        builder.mesh.corners = all.map(|position| builder.corner(position)).collect();
        builder.mesh.points = (0..builder.mesh.corners.len() as u32).collect();
    }
    let bytes = |color: &mut DVec4| *color /= 255.0;
    if vertices.has_bytes || (!has[2] && faces.has_bytes) {
        builder.mesh.colors.iter_mut().for_each(bytes);
    }
    builder.mesh.colors.iter_mut().for_each(|color| *color = color.clamp(DVec4::ZERO, DVec4::ONE));
    Ok(Built { mesh: builder.mesh, indices: builder.indices })
}

/// A mesh in the making.
struct Builder {
    mesh: Mesh,
    sizes: PolygonSizes,
    /// Presence of normals, texture coordinates and colours at vertices.
    has: [bool; 3],
    /// Corners of the polygon that is being added.
    corners: Vec<Corner>,
    /// Vertices without a position, ascending.
    unusable: Vec<u32>,
    indices: Defects,
    textures: usize,
}

impl Builder {
    /// Returns the corner of a vertex, with its attributes.
    fn corner(&self, position: u32) -> Corner {
        let [normal, texcoord, color] = self.has.map(|has| if has { position } else { NONE });
        Corner { position, normal, texcoord, color }
    }

    /// Sets `corners` to those of the vertices with these indices.
    fn set_corners(&mut self, indices: &[i64]) -> Result<(), Unused> {
        self.corners.clear();
        let count = self.mesh.positions.len();
        for &index in indices {
            let vertex = u32::try_from(index).ok().filter(|i| (*i as usize) < count);
            let Some(vertex) = vertex else {
                let count = count as u64;
                return Err(Unused::Index(match index {
                    i64::MIN => {
                        LoadErrorKind::Number { what: "a vertex index", found: "another word".into() }
                    }
                    _ => LoadErrorKind::Index { what: "vertex", index, count },
                }));
            };
            if self.unusable.binary_search(&vertex).is_ok() {
                return Err(Unused::Vertex);
            }
            let corner = self.corner(vertex);
            self.corners.push(corner);
        }
        Ok(())
    }

    /// Counts what was left out; a limit that was passed is an error.
    fn note(
        &mut self,
        added: Result<(), Unused>,
        refuse: impl Fn(LoadErrorKind) -> LoadError,
    ) -> Result<(), LoadError> {
        match added {
            Ok(()) | Err(Unused::Vertex) => Ok(()),
            Err(Unused::Index(kind)) => {
                self.indices.note(|| refuse(kind));
                Ok(())
            }
            Err(Unused::Limit(kind)) => Err(refuse(kind)),
        }
    }

    /// Adds a face with its own colour and texture coordinates, if vertices have none. Fewer than
    /// three corners are none.
    fn face(&mut self, indices: &[i64], row: &List, texcoords: &[DVec2]) -> Result<(), Unused> {
        self.set_corners(indices)?;
        self.sizes.add(indices.len(), true).map_err(Unused::Limit)?;
        if indices.len() < 3 {
            return Ok(());
        }
        let own = &texcoords[row.texcoords.clone()];
        if !self.has[1] && own.len() == indices.len() && own.iter().all(|uv| uv.is_finite()) {
            let numbers = self.mesh.texcoords.len() as u32..;
            self.corners.iter_mut().zip(numbers).for_each(|(corner, number)| corner.texcoord = number);
            self.mesh.texcoords.extend_from_slice(own);
        }
        if let (false, Some(color)) = (self.has[2], row.color) {
            let number = self.mesh.colors.len() as u32;
            self.corners.iter_mut().for_each(|corner| corner.color = number);
            self.mesh.colors.push(color);
        }
        let material = if row.texture < self.textures { row.texture as u32 } else { NONE };
        self.mesh.push_polygon(&self.corners, material);
        Ok(())
    }

    /// Adds the triangles of a strip: every second one has its corners in the other order.
    fn strip(
        &mut self,
        indices: &[i64],
        refuse: impl Fn(LoadErrorKind) -> LoadError,
    ) -> Result<(), LoadError> {
        let material = if self.textures > 0 { 0 } else { NONE };
        for (k, t) in indices.windows(3).enumerate() {
            let t = if k % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            // Triangles without area join the parts of a strip.
            if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
                continue;
            }
            let added = self.set_corners(&t);
            let is_added = added.is_ok();
            self.note(added, &refuse)?;
            if is_added {
                self.sizes.add(3, true).map_err(&refuse)?;
                self.mesh.push_polygon(&self.corners, material);
            }
        }
        Ok(())
    }

    /// Adds an edge as a line.
    fn edge(&mut self, ends: &[i64; 2]) -> Result<(), Unused> {
        self.set_corners(ends)?;
        self.sizes.add(2, false).map_err(Unused::Limit)?;
        let first = self.mesh.corners.len() as u32;
        self.mesh.corners.append(&mut self.corners);
        self.mesh.lines.push([first, first + 1]);
        Ok(())
    }
}

/// Reason why a row adds nothing.
enum Unused {
    /// It names a vertex that is not there.
    Index(LoadErrorKind),
    /// It names a vertex whose position is not finite, which is counted with the vertices.
    Vertex,
    /// A limit of meshes is passed.
    Limit(LoadErrorKind),
}

//! Elements of a PLY file: their size before they are read, and their rows.
//!
//! In: an element of the header, and the bytes that are left. Out: an upper bound of the memory for
//! its rows, or a refusal if they cannot be in the file; then the rows.

use super::header::{Element, Encoding};
use super::reader::Reader;
use super::rows::{self, Edges, Lists, RowDefects, Skipped, Vertices};
use crate::load::error::short;
use crate::load::{LoadError, LoadErrorKind, LoadMemory};
use fbptr_core::scene::NONE;

/// Bytes for each vertex: its attributes in vectors that are copied as they grow, and as a point.
const VERTEX_BYTES: u64 = 3 * (24 + 24 + 16 + 32 + 4) + 16 + 8;
/// Bytes for each edge: read, as corners and a line, in such vectors.
const EDGE_BYTES: u64 = 3 * (24 + 32 + 8);
/// Bytes for each corner: as an index, in the mesh, and as part of a triangle, in such vectors.
const CORNER_BYTES: u64 = 3 * (8 + 16 + 16 + 16 + 16);
/// Bytes for each row with a list, and its polygon, in such vectors.
const ROW_BYTES: u64 = 3 * (128 + 12 + 32);

/// Rows of the elements that a mesh is made of.
#[derive(Default)]
pub(super) struct Elements {
    pub(super) vertices: Vertices,
    pub(super) faces: Lists,
    pub(super) strips: Lists,
    pub(super) edges: Edges,
    pub(super) defects: RowDefects,
}

impl Elements {
    /// Reads the rows of the next element.
    pub(super) fn read(
        &mut self,
        element: &Element,
        reader: &mut Reader,
        memory: &LoadMemory,
    ) -> Result<(), LoadError> {
        let defects = &mut self.defects;
        match element.name.as_str() {
            "vertex" => rows::read(reader, element, &mut self.vertices, defects, memory),
            "face" => rows::read(reader, element, &mut self.faces, defects, memory),
            "tristrips" => rows::read(reader, element, &mut self.strips, defects, memory),
            "edge" => rows::read(reader, element, &mut self.edges, defects, memory),
            _ => rows::read(reader, element, &mut Skipped, defects, memory),
        }
    }

    /// Returns whether there are rows of anything but vertices.
    pub(super) fn has_elements(&self) -> bool {
        self.faces.count + self.strips.count + self.edges.count > 0
    }
}

/// Returns an upper bound of the memory for the rows of an element and for what the mesh has of
/// them.
///
/// # Errors
/// If the rows need more bytes than are left, or are too many.
pub(super) fn most_bytes(element: &Element, reader: &Reader) -> Result<u64, LoadErrorKind> {
    let (rest, is_text) = (reader.rest(), reader.encoding() == Encoding::Text);
    // In a text a digit and a blank.
    let size = |scalar: super::header::Scalar| if is_text { 2 } else { scalar.size() as u64 };
    let (mut row, mut item) = (0_u64, None);
    for property in &element.properties {
        match property.length {
            None => row += size(property.scalar),
            Some(length) => {
                row += size(length);
                item = Some(item.unwrap_or(u64::MAX).min(size(property.scalar)));
            }
        }
    }
    let (count, name) = (element.count, short(&element.name));
    let undecodable = |reason| Err(LoadErrorKind::Undecodable { format: "PLY", reason });
    if row == 0 && count > 0 {
        return undecodable(format!("the {count} rows of {name:?} have no properties"));
    }
    // One more: the line end that a text may lack. A row of a text may lack values, but has a line.
    let least = if is_text { 2 } else { row };
    let (needed, left) = (count.saturating_mul(least), rest.len() as u64 + 1);
    if needed > left {
        let rows = format!("{count} rows of {name:?} need {needed} bytes or more");
        return undecodable(format!("{rows}, and {} are left", left - 1));
    }
    if count > u64::from(NONE - 1) {
        return Err(LoadErrorKind::TooBig { what: "rows", found: count, limit: u64::from(NONE - 1) });
    }
    let items = |size: u64| match is_text {
        true => rest.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count() as u64,
        false => (left - needed) / size,
    };
    let lists = item.map_or(0, |size| items(size) * CORNER_BYTES + count * ROW_BYTES);
    Ok(lists
        + match element.name.as_str() {
            "vertex" => count * VERTEX_BYTES,
            "edge" => count * EDGE_BYTES,
            _ => 0,
        })
}

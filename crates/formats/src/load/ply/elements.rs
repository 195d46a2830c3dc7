//! Elements of a PLY file: their size before they are read, and their rows.
//!
//! In: an element of the header, and the bytes that are left. Out: an upper bound of the memory for
//! its rows, or a refusal if they cannot be in the file; then the rows.

use super::rows::{self, Edges, Lists, Skipped, Vertices};
use crate::load::LoadErrorKind;
use crate::load::error::short;
use fbptr_core::scene::NONE;
use serde_ply::{DeserializeError, ElementDef, PlyFormat, PlyReader, PropertyType, ScalarType};
use std::cell::Cell;
use std::io::BufRead;

/// Bytes for each vertex: its attributes in vectors that are copied as they grow, and as a point.
const VERTEX_BYTES: u64 = 3 * (24 + 24 + 16 + 32) + 16 + 8;
/// Bytes for each edge: read, as corners and a line, in such vectors.
const EDGE_BYTES: u64 = 3 * (24 + 32 + 8);
/// Bytes for each corner: as an index, in the mesh, and as part of a triangle, in such vectors.
const CORNER_BYTES: u64 = 3 * (8 + 16 + 16 + 16 + 16);
/// Bytes for each row with a list, and its polygon, in such vectors.
const ROW_BYTES: u64 = 3 * (80 + 12 + 32);

/// Rows of the elements that a mesh is made of.
#[derive(Default)]
pub(super) struct Elements {
    pub(super) vertices: Vertices,
    pub(super) faces: Lists,
    pub(super) strips: Lists,
    pub(super) edges: Edges,
}

impl Elements {
    /// Reads the rows of the next element, which has this name. `at` counts the bytes read.
    pub(super) fn read<R: BufRead>(
        &mut self,
        name: &str,
        reader: &mut PlyReader<R>,
        at: &Cell<usize>,
    ) -> Result<(), DeserializeError> {
        match name {
            "vertex" => rows::read(reader, &mut self.vertices, at),
            "face" => rows::read(reader, &mut self.faces, at),
            "tristrips" => rows::read(reader, &mut self.strips, at),
            "edge" => rows::read(reader, &mut self.edges, at),
            _ => rows::read(reader, &mut Skipped, at),
        }
    }
}

/// Returns an upper bound of the memory for the rows of an element and for what the mesh has of
/// them; `left` is the rest of the file.
///
/// # Errors
/// If the rows need more bytes than are left, or are too many.
pub(super) fn most_bytes(element: &ElementDef, format: PlyFormat, left: &[u8]) -> Result<u64, LoadErrorKind> {
    let size = |t: &ScalarType| match (format, t) {
        // A digit and a blank.
        (PlyFormat::Ascii, _) => 2,
        (_, ScalarType::I8 | ScalarType::U8) => 1,
        (_, ScalarType::I16 | ScalarType::U16) => 2,
        (_, ScalarType::I32 | ScalarType::U32 | ScalarType::F32) => 4,
        (_, ScalarType::F64) => 8,
    };
    let (mut row, mut item) = (0_u64, None);
    for property in &element.properties {
        match &property.property_type {
            PropertyType::Scalar(t) => row += size(t),
            PropertyType::List { count_type, data_type } => {
                row += size(count_type);
                item = Some(item.unwrap_or(u64::MAX).min(size(data_type)));
            }
        }
    }
    let (count, name) = (element.count as u64, short(&element.name));
    let undecodable = |reason| Err(LoadErrorKind::Undecodable { format: "PLY", reason });
    if row == 0 && count > 0 {
        return undecodable(format!("the {count} rows of {name:?} have no properties"));
    }
    // One more: the line end that a text may lack.
    let (needed, left, rest) = (count.saturating_mul(row), left.len() as u64 + 1, left);
    if needed > left {
        let rows = format!("{count} rows of {name:?} need {needed} bytes or more");
        return undecodable(format!("{rows}, and {} are left", left - 1));
    }
    if count > u64::from(NONE - 1) {
        return Err(LoadErrorKind::TooBig { what: "rows", found: count, limit: u64::from(NONE - 1) });
    }
    let items = |size| match format {
        PlyFormat::Ascii => {
            rest.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count() as u64
        }
        _ => (left - needed) / size,
    };
    let lists = item.map_or(0, |size| items(size) * CORNER_BYTES + count * ROW_BYTES);
    Ok(lists
        + match element.name.as_str() {
            "vertex" => count * VERTEX_BYTES,
            "edge" => count * EDGE_BYTES,
            _ => 0,
        })
}

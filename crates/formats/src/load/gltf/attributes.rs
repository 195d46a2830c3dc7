//! Attributes of vertices.
//!
//! In: the JSON of an attribute, which names an accessor. Out: its numbers, or the error with its
//! pointer.

use super::buffers::Numbers;
use super::image::Source;
use super::json::Json;
use crate::load::{LoadError, LoadErrorKind};

/// Reads the accessor of an attribute.
pub(super) fn attribute(
    source: &mut Source,
    attribute: &Json,
    widths: &[usize],
) -> Result<Numbers, LoadError> {
    let accessors = source.root.member("accessors");
    let accessor = accessors.item(attribute.index("accessor", accessors.count())?);
    source.buffers.read_accessor(&source.root, &accessor, widths, source.context.memory)
}

/// Reads an attribute that must have as many elements as there are vertices.
pub(super) fn vertex_attribute(
    source: &mut Source,
    json: &Json,
    widths: &[usize],
    count: usize,
) -> Result<Option<Numbers>, LoadError> {
    if !json.is_there() {
        return Ok(None);
    }
    let numbers = attribute(source, json, widths)?;
    if numbers.count() != count {
        let reason = format!("{} elements for {count} vertices", numbers.count());
        return Err(json.refuse(LoadErrorKind::Undecodable { format: "glTF", reason }));
    }
    Ok(Some(numbers))
}

//! X3D in the classic encoding and VRML 97, as the XML of the same scene.
//!
//! In: a text that begins with `#X3D V` or `#VRML V2.0`. Out: the text of an XML file with the same
//! nodes, fields, names, prototypes and routes in the same order, and for each part its place in the
//! classic text. So both encodings have one reader behind them: one graph, one set of messages, whose
//! lines and columns are those of the classic file.
//!
//! Expected: nodes are elements; a field's numbers and strings are an attribute; nodes in a field are
//! elements inside, with the field as containerField where it is not their default; `USE` has the type
//! of its DEF; PROTO is ProtoDeclare, its instances ProtoInstance with fieldValue; `IS` is connect.
//! The names that VRML 97 had for X3D's: `choice` of Switch and `level` of LOD (children), `collide` of
//! Collision (enabled), eventIn, eventOut, field and exposedField (access types).
//!
//! Errors: a string, list, node or prototype that does not end, a field without a value, a value given
//! twice, nesting over the limit. Values are checked by the reader of XML fields.
//!
//! Sources: ISO/IEC 19776-2 (classic encoding), ISO/IEC 14772-1 (VRML 97) annex A, ISO/IEC 19776-1
//! (the XML that corresponds).

mod emit;
mod lexer;
mod parser;

use super::xml::{Part, XmlSource};
use crate::load::LoadError;
use fbptr_core::cancel::CancelToken;

/// First bytes of the files that this module reads; those of VRML 1.0 are others.
pub const HEADERS: [&[u8]; 2] = [b"#X3D V", b"#VRML V2.0"];

/// Returns whether a file is one of this encoding.
pub(super) fn is_classic(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    HEADERS.iter().any(|header| text.starts_with(header))
}

/// Returns the XML of a classic text, and the places of its parts.
///
/// # Errors
/// Those of the module's documentation.
pub(super) fn to_xml(source: &XmlSource, cancel: &CancelToken) -> Result<(String, Vec<Part>), LoadError> {
    let statements = parser::file(source, cancel)?;
    Ok(emit::document(&statements))
}

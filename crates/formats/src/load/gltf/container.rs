//! The container of a glTF file: JSON by itself, or binary (GLB) with JSON and one buffer.
//!
//! Source: Khronos Group, glTF 2.0 Specification, section 4 (GLB File Format).

use crate::load::{FilePosition, LoadError, LoadErrorKind, LoadWarning};

/// First bytes of a GLB file.
#[doc(hidden)]
pub const MAGIC: &[u8] = b"glTF";

/// Parts of a file.
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// The buffer of a GLB file.
    pub(super) binary: Option<&'a [u8]>,
}

/// Splits a file into its parts.
pub(super) fn split<'a>(
    bytes: &'a [u8],
    file: &str,
    warnings: &mut Vec<LoadWarning>,
) -> Result<Container<'a>, LoadError> {
    if !bytes.starts_with(MAGIC) {
        return Ok(Container { json: json(bytes), binary: None });
    }
    let word = |at: usize| {
        let four = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
    };
    let fail = |at: usize, reason: String| {
        let kind = LoadErrorKind::Undecodable { format: "GLB", reason };
        LoadError::new(FilePosition::byte(file, at as u64), kind)
    };
    let cut = |at: usize| fail(at, format!("the file ends after {} bytes", bytes.len()));
    let version = word(4).ok_or_else(|| cut(4))?;
    if version != 2 {
        return Err(fail(4, format!("expected version 2, found {version}")));
    }
    let length = word(8).ok_or_else(|| cut(8))? as usize;
    if length > bytes.len() {
        return Err(fail(8, format!("its length is {length} bytes, and the file has {}", bytes.len())));
    }
    let (mut at, mut found) = (12, [None, None]);
    while at < length {
        let size = word(at).ok_or_else(|| cut(at))? as usize;
        let kind = word(at + 4).ok_or_else(|| cut(at + 4))?;
        let start = at + 8;
        if size > length.saturating_sub(start) {
            let left = length.saturating_sub(start);
            return Err(fail(at, format!("a chunk of {size} bytes, and {left} are left")));
        }
        let place = match &kind.to_le_bytes() {
            b"JSON" => Some(0),
            b"BIN\0" => Some(1),
            _ => None,
        };
        match place {
            Some(place) if found[place].is_none() => found[place] = Some(&bytes[start..start + size]),
            _ => {
                let message = "a chunk of another kind is left out".into();
                warnings.push(LoadWarning { place: FilePosition::byte(file, at as u64), message });
            }
        }
        if warnings.len() > super::MAX_WARNINGS {
            return Err(fail(at, "too many chunks".into()));
        }
        at = start + size;
    }
    let text = found[0].ok_or_else(|| fail(12, "no chunk of JSON".into()))?;
    Ok(Container { json: json(text), binary: found[1] })
}

/// Returns a text without its byte order mark, and without the zeros that some programs fill it up
/// with.
fn json(bytes: &[u8]) -> &[u8] {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let end = text.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    &text[..end]
}

//! Memory estimates for OBJ and MTL files, by counts of the words in their text.
//!
//! In: a text. Out: an upper bound in bytes. A wrong figure is found by
//! tests/allocations/decoder_memory.rs, which counts allocated bytes.

use super::lexer::POINTS;
use super::lines::keyword;

/// Bytes per number of a vertex: in the decoder's vector, which is copied as it grows and has up to
/// twice the room, and in the mesh.
const NUMBER_BYTES: u64 = 40;
/// Bytes per element: in the decoder's vector, which is copied as it grows, our record of it, a
/// polygon and a triangle.
const ELEMENT_BYTES: u64 = 400;
/// Bytes per corner of an element: in the decoder's element and arrays, in our tables of first
/// uses, and in the mesh.
const CORNER_BYTES: u64 = 130;
/// Bytes per material: read, checked and stored.
const MATERIAL_BYTES: u64 = 4096;

/// Returns an upper bound of the bytes for reading an OBJ file, the mesh included: it is reserved
/// separately once it exists.
pub(super) fn obj_bytes(text: &[u8]) -> u64 {
    let (mut numbers, mut elements, mut corners, mut vertices) = (0, 0, 0, 0);
    // Where lines are joined, the first word of a line may be part of another statement.
    let (mut has_elements, is_joined) = (false, text.contains(&b'\\'));
    let (mut was_blank, mut first) = (true, None);
    for (i, &byte) in text.iter().enumerate() {
        let is_blank = byte.is_ascii_whitespace();
        if matches!(byte, b'\n' | b'\r') {
            first = None;
        } else if was_blank && !is_blank {
            match first {
                None => {
                    elements += u64::from(!matches!(byte, b'v' | b'#'));
                    vertices += u64::from(byte == b'v');
                    has_elements |= !is_joined && matches!(keyword(&text[i..]).0, b"f" | b"fo" | b"l" | b"p");
                }
                Some(b'#') => {}
                Some(b'v') => numbers += 1,
                Some(_) => corners += 1,
            }
            first = first.or(Some(byte));
        }
        was_blank = is_blank;
    }
    if !has_elements {
        // All positions become points.
        (elements, corners) = (elements + vertices / POINTS + 1, corners + vertices);
    }
    numbers * NUMBER_BYTES + elements * ELEMENT_BYTES + corners * CORNER_BYTES + 4 * longest_statement(text)
}

/// Returns an upper bound of the bytes for reading an MTL file.
pub(super) fn mtl_bytes(text: &[u8]) -> u64 {
    let materials = text.windows(6).filter(|w| *w == b"newmtl").count() as u64;
    (materials + 1) * MATERIAL_BYTES + 6 * text.len() as u64
}

/// Returns the length of the longest line, or of the whole text if lines are joined: a statement is
/// copied, and passed on word by word.
fn longest_statement(text: &[u8]) -> u64 {
    match text.contains(&b'\\') {
        true => text.len() as u64,
        false => text.split(|b| matches!(b, b'\n' | b'\r')).map(<[u8]>::len).max().unwrap_or(0) as u64,
    }
}

//! What reading an OBJ or MTL file takes, by what is counted in its text before it is read.
//!
//! In: a text. Out: bytes, at most. One would know a wrong figure by tests/allocations/decoder_memory.rs, which counts what is allocated.

/// Bytes for one number of a vertex: in the decoder's list, which has room for twice as many and moves, and in the mesh.
const NUMBER_BYTES: u64 = 40;
/// Bytes for one element: in the decoder's list, which moves, our note of it, a polygon and a triangle.
const ELEMENT_BYTES: u64 = 400;
/// Bytes for one corner of an element: in the decoder's element and arrays, in our lists of first uses, and in the mesh.
const CORNER_BYTES: u64 = 130;
/// Bytes of a material as it is read, checked and kept.
const MATERIAL_BYTES: u64 = 4096;

/// Bytes that reading an OBJ file takes, the mesh included: it is counted for itself once it is made.
pub(super) fn obj_bytes(text: &[u8]) -> u64 {
    let (mut numbers, mut elements, mut corners) = (0, 0, 0);
    let (mut was_blank, mut first) = (true, None);
    for &byte in text {
        let is_blank = byte.is_ascii_whitespace();
        if matches!(byte, b'\n' | b'\r') {
            first = None;
        } else if was_blank && !is_blank {
            match first {
                None => elements += u64::from(!matches!(byte, b'v' | b'#')),
                Some(b'#') => {}
                Some(b'v') => numbers += 1,
                Some(_) => corners += 1,
            }
            first = first.or(Some(byte));
        }
        was_blank = is_blank;
    }
    numbers * NUMBER_BYTES + elements * ELEMENT_BYTES + corners * CORNER_BYTES + 4 * longest_statement(text)
}

/// Bytes that reading an MTL file takes.
pub(super) fn mtl_bytes(text: &[u8]) -> u64 {
    let materials = text.windows(6).filter(|w| *w == b"newmtl").count() as u64;
    (materials + 1) * MATERIAL_BYTES + 6 * text.len() as u64
}

/// The longest line, or all lines where some are joined: a statement is copied, and handed on word by word.
fn longest_statement(text: &[u8]) -> u64 {
    match text.contains(&b'\\') {
        true => text.len() as u64,
        false => text.split(|b| matches!(b, b'\n' | b'\r')).map(<[u8]>::len).max().unwrap_or(0) as u64,
    }
}

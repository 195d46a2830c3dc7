//! PLY: the Polygon File Format, as text or binary in either byte order, read by `serde-ply`.
//!
//! In: the bytes of a file. Out: a mesh of the elements `vertex` (positions, normals, texture
//! coordinates, colours), `face` (polygons of any size; colours and texture coordinates of a face
//! where vertices have none), `tristrips` (-1 begins a new strip) and `edge`; a file with none of
//! the last three is a cloud of points. Other elements and properties are left out. Colours of
//! whole-number properties are parts of their type's largest number.
//!
//! `serde-ply` reports no place; it reads through a counter of bytes, and an error stands where the
//! counter does: in a line of a text, at a byte of a binary file. It believes the header's counts;
//! so each element's smallest size is compared with the bytes that are left, and memory is reserved,
//! before its rows are read. An index is checked when its row is. A line of a text with more values
//! than its row has is searched once an error is found.
//!
//! Source: G. Turk, The PLY Polygon File Format, 1994.

mod build;
mod elements;
mod long_row;
mod rows;
#[cfg(test)]
mod tests;

use super::error::short;
use super::mesh::{LoadedMesh, Smoothing, add_normals};
use super::{FilePosition, LoadError, LoadErrorKind, LoadMemory, LoadWarning};
use fbptr_core::cancel::CancelToken;
use fbptr_core::scene::Geometry;
use serde_ply::{DeserializeError, PlyFormat, PlyReader};
use std::cell::Cell;
use std::io::{self, BufRead, Read};

/// Most elements of a header, and most properties of an element.
const MAX_ELEMENTS: usize = 256;

/// Returns whether a file that begins with `first` is PLY.
pub(crate) fn is_ply(first: &[u8]) -> bool {
    first.starts_with(b"ply\n") || first.starts_with(b"ply\r")
}

/// Parses the PLY file `file_name` from its bytes. Room for the rows of an element is reserved
/// before they are read.
///
/// # Errors
/// If the file has an error, or `memory` has no room or is cancelled.
pub fn parse(
    bytes: &[u8],
    file_name: &str,
    memory: &mut LoadMemory,
    smoothing: Smoothing,
) -> Result<LoadedMesh, LoadError> {
    let refused = |kind| LoadError::new(FilePosition::file(file_name), kind);
    let _header = memory.work(header_bytes(bytes)).map_err(refused)?;
    let at = Cell::new(0);
    let cancel = memory.cancel().clone();
    let source = Counted { bytes, at: &at, is_ended: false, cancel: &cancel };
    // Until the header is read, its lines are the places.
    let mut place = Places { bytes, file_name, is_text: true };
    let fail = |place: &Places, e: DeserializeError| {
        let undecodable = LoadErrorKind::Undecodable { format: "PLY", reason: short(&e.0.to_string()) };
        place.refuse(at.get(), memory.check_cancelled().err().unwrap_or(undecodable))
    };
    let mut reader = PlyReader::from_reader(source).map_err(|e| fail(&place, e))?;
    let header = reader.header();
    let most = header.elem_defs.iter().map(|e| e.properties.len()).max().unwrap_or(0);
    let most = most.max(header.elem_defs.len());
    if most > MAX_ELEMENTS {
        let what = "elements, or properties of one";
        let (found, limit) = (most as u64, MAX_ELEMENTS as u64);
        return Err(place.refuse(at.get(), LoadErrorKind::TooBig { what, found, limit }));
    }
    place.is_text = header.format == PlyFormat::Ascii;
    let mut work = Vec::new();
    let mut elements = elements::Elements::default();
    for element in header.elem_defs.clone() {
        let left = bytes.get(at.get()..).unwrap_or(&[]);
        let reserved = elements::most_bytes(&element, reader.header().format, left)
            .and_then(|most| memory.work(most))
            .map_err(|kind| place.refuse(at.get(), kind))?;
        work.push(reserved);
        let start = at.get();
        elements.read(&element.name, &mut reader, &at).map_err(|e| {
            let long = long_row::find(&element, bytes, start..at.get()).filter(|_| place.is_text);
            match long.filter(|_| memory.check_cancelled().is_ok()) {
                Some((at, reason)) => place.refuse(at, LoadErrorKind::Undecodable { format: "PLY", reason }),
                None => fail(&place, e),
            }
        })?;
    }
    let lacks_normals = elements.vertices.normals.is_empty();
    let mut mesh = build::mesh(elements).map_err(|(at, kind)| place.refuse(at, kind))?;
    let is_open = lacks_normals
        && !mesh.polygons.is_empty()
        && add_normals(&mut mesh, &[], smoothing, memory).map_err(refused)?;
    mesh.shrink_to_fit();
    memory.reserve_result(mesh.size_bytes() as u64).map_err(refused)?;
    let mut warnings = Vec::new();
    if mesh.corners.is_empty() {
        let message = "no faces, lines or points: nothing is drawn".into();
        warnings.push(LoadWarning { place: FilePosition::file(file_name), message });
    }
    Ok(LoadedMesh { geometry: Geometry::from(mesh), warnings, is_open })
}

/// Returns the bytes for reading a header: its text, split and kept.
fn header_bytes(bytes: &[u8]) -> u64 {
    let end = b"end_header";
    let length = bytes.windows(end.len()).position(|w| w == end).unwrap_or(bytes.len());
    40 * length as u64 + 4096
}

/// A file's bytes, counted as they are read. After the last one comes a line end, which a text may
/// lack.
struct Counted<'a> {
    bytes: &'a [u8],
    at: &'a Cell<usize>,
    is_ended: bool,
    cancel: &'a CancelToken,
}

impl Read for Counted<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let piece = self.fill_buf()?;
        let count = piece.len().min(out.len());
        out[..count].copy_from_slice(&piece[..count]);
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Counted<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.cancel.is_cancelled() {
            return Err(io::Error::other("reading was given up"));
        }
        Ok(match self.bytes.get(self.at.get()..) {
            Some(rest) if !rest.is_empty() => rest,
            _ if self.is_ended => &[],
            _ => b"\n",
        })
    }

    fn consume(&mut self, count: usize) {
        match self.at.get() < self.bytes.len() {
            true => self.at.set(self.at.get() + count),
            false => self.is_ended |= count > 0,
        }
    }
}

/// Places of errors in a file: lines of a text, bytes of a binary file.
struct Places<'a> {
    bytes: &'a [u8],
    file_name: &'a str,
    is_text: bool,
}

impl Places<'_> {
    /// Returns an error at the byte `at`, up to which the file was read.
    fn refuse(&self, at: usize, kind: LoadErrorKind) -> LoadError {
        if !self.is_text {
            return LoadError::new(FilePosition::byte(self.file_name, at as u64), kind);
        }
        // The line end after the last word belongs to its line.
        let before = &self.bytes[..at.saturating_sub(1).min(self.bytes.len())];
        let line = before.iter().filter(|b| **b == b'\n').count() + 1;
        LoadError::new(FilePosition::line(self.file_name, u32::try_from(line).unwrap_or(u32::MAX)), kind)
    }
}

//! STL: facets of stereolithography, as text or binary, read by `stl_io`.
//!
//! In: the bytes of a file. Out: a mesh of triangles, each with its own positions, in the units of
//! the file; z is up in most files, and stays so. The normals of the file are ignored: the order of
//! the corners, counter-clockwise seen from outside, gives the same, and files with zero or wrong
//! normals are common. The format has no colours that programs agree on; attribute bytes are
//! ignored.
//!
//! A file is binary if its length is that of the records that it counts, or if it does not begin
//! with `solid`, or has a zero byte soon. `stl_io` goes by the first word alone, knows one solid a
//! file, wants lower case and reports no place; so it is given a binary file with its header
//! cleared, and a text solid by solid, line by line, in lower case: an error stands in the last line
//! that it was given. Counts are compared with the file's length before anything is allocated.
//!
//! Source: 3D Systems, StereoLithography Interface Specification, 1989 (as reprinted in M. Burns,
//! Automated Fabrication, section 6.5).

use super::error::short;
use super::mesh::{LoadedMesh, PolygonSizes, Smoothing, add_normals};
use super::{FilePosition, LoadError, LoadErrorKind, LoadMemory, LoadWarning};
use fbptr_core::scene::{Corner, Geometry, Mesh, NONE};
use glam::DVec3;
use std::io::{self, Read, Seek, SeekFrom};

/// Bytes before the records of a binary file: a comment and their number.
const HEADER_BYTES: u64 = 84;
/// Bytes of a record: a normal, three corners, an attribute.
const RECORD_BYTES: u64 = 50;
/// Bytes of the mesh for each facet: positions, corners, a polygon and a triangle.
const FACET_BYTES: u64 = 3 * 24 + 3 * 16 + 12 + 12 + 4;
/// Most warnings of a file.
const MAX_WARNINGS: usize = 100;

/// Returns whether a file of `length` bytes that begins with `first` is STL.
pub(crate) fn is_stl(first: &[u8], length: u64) -> bool {
    count(first).is_some_and(|n| length == binary_bytes(n)) || is_text(first)
}

/// Returns whether bytes begin like an STL text: `solid`, then a facet or the end.
fn is_text(first: &[u8]) -> bool {
    let mut words = first.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
    let is = |word: &[u8], known: &str| word.eq_ignore_ascii_case(known.as_bytes());
    words.next().is_some_and(|w| is(w, "solid")) && words.any(|w| is(w, "facet") || is(w, "endsolid"))
}

/// Returns whether a file begins with `solid` and with no zero byte, which a record has.
fn begins_as_text(bytes: &[u8]) -> bool {
    let word = bytes.trim_ascii_start().get(..5);
    let first = &bytes[..bytes.len().min(512)];
    word.is_some_and(|w| w.eq_ignore_ascii_case(b"solid")) && !first.contains(&0)
}

/// Returns the number of records that a binary file states.
fn count(bytes: &[u8]) -> Option<u32> {
    bytes.get(80..84).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]))
}

/// Returns the length of a binary file of `count` records.
fn binary_bytes(count: u32) -> u64 {
    HEADER_BYTES + RECORD_BYTES * u64::from(count)
}

/// Parses the STL file `file_name` from its bytes. Room for the mesh is reserved before it is
/// allocated, by the number of records or of the text's vertices.
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
    let is_counted = count(bytes).is_some_and(|n| bytes.len() as u64 == binary_bytes(n));
    let mut facets = Facets { file_name, mesh: Mesh::default(), sizes: PolygonSizes::default() };
    let mut warnings = Vec::new();
    let _work;
    if !is_counted && begins_as_text(bytes) {
        let corners = bytes.windows(6).filter(|w| w.eq_ignore_ascii_case(b"vertex")).count() as u64;
        // Vectors are copied as they grow.
        _work = memory.work(corners.div_ceil(3) * FACET_BYTES * 3 + longest_line(bytes)).map_err(refused)?;
        facets.read_text(bytes, memory, &mut warnings)?;
    } else {
        let count = checked_count(bytes, file_name, &mut warnings)?;
        _work = memory.work(u64::from(count) * FACET_BYTES).map_err(refused)?;
        facets.read_records(bytes, count, memory)?;
    }
    let mut mesh = facets.mesh;
    let is_open = add_normals(&mut mesh, &[], smoothing, memory).map_err(refused)?;
    mesh.shrink_to_fit();
    memory.reserve_result(mesh.size_bytes() as u64).map_err(refused)?;
    if mesh.polygons.is_empty() {
        let message = "no facets: nothing is drawn".into();
        warnings.push(LoadWarning { place: FilePosition::file(file_name), message });
    }
    Ok(LoadedMesh { geometry: Geometry::from(mesh), warnings, is_open })
}

/// Returns four times the length of the longest line: it is copied, and split into words.
fn longest_line(bytes: &[u8]) -> u64 {
    let longest = bytes.split(|b| *b == b'\n').map(<[u8]>::len).max().unwrap_or(0) as u64;
    40 * longest
}

/// Returns the number of records of a binary file.
///
/// # Errors
/// If the file is too short for them.
fn checked_count(bytes: &[u8], file_name: &str, warnings: &mut Vec<LoadWarning>) -> Result<u32, LoadError> {
    let length = bytes.len() as u64;
    let short = |offset, reason| {
        let kind = LoadErrorKind::Undecodable { format: "STL", reason };
        LoadError::new(FilePosition::byte(file_name, offset), kind)
    };
    let Some(count) = count(bytes) else {
        return Err(short(length, format!("a binary file has {HEADER_BYTES} bytes before its facets")));
    };
    let needed = binary_bytes(count);
    if needed > length {
        return Err(short(80, format!("{count} facets need {needed} bytes, and the file has {length}")));
    }
    if needed < length {
        let message = format!("{} bytes after the last of {count} facets are left out", length - needed);
        warnings.push(LoadWarning { place: FilePosition::byte(file_name, needed), message });
    }
    Ok(count)
}

/// The mesh as far as it is read.
struct Facets<'a> {
    file_name: &'a str,
    mesh: Mesh,
    sizes: PolygonSizes,
}

impl Facets<'_> {
    fn read_records(&mut self, bytes: &[u8], count: u32, memory: &LoadMemory) -> Result<(), LoadError> {
        let n = count as usize;
        self.mesh.positions.reserve_exact(3 * n);
        self.mesh.corners.reserve_exact(3 * n);
        self.mesh.polygons.reserve_exact(n);
        self.mesh.triangles.reserve_exact(n);
        self.mesh.triangle_polygon.reserve_exact(n);
        let mut source = Records { bytes, at: 0 };
        let place = |i: u64| FilePosition::byte(self.file_name, HEADER_BYTES + RECORD_BYTES * i);
        let failed = |i, e: io::Error| {
            let kind = LoadErrorKind::Undecodable { format: "STL", reason: short(&e.to_string()) };
            LoadError::new(place(i), kind)
        };
        let facets = stl_io::create_stl_reader(&mut source).map_err(|e| failed(0, e))?;
        for (i, facet) in (0..u64::from(count)).zip(facets) {
            if i.is_multiple_of(4096) {
                memory.check_cancelled().map_err(|kind| LoadError::new(place(i), kind))?;
            }
            let facet = facet.map_err(|e| failed(i, e))?;
            push(&mut self.mesh, &mut self.sizes, &facet).map_err(|kind| LoadError::new(place(i), kind))?;
        }
        Ok(())
    }

    fn read_text(
        &mut self,
        bytes: &[u8],
        memory: &LoadMemory,
        warnings: &mut Vec<LoadWarning>,
    ) -> Result<(), LoadError> {
        let mut lines = Lines { bytes, at: 0, line: 0, pending: Vec::new(), is_in_solid: false };
        while lines.begin_solid(self.file_name, warnings) {
            let given = std::cell::Cell::new(lines.line);
            let mut source = Solid { lines: &mut lines, given: &given };
            let place = || FilePosition::line(self.file_name, given.get());
            let failed = |e: io::Error| {
                let reason = short(&e.to_string());
                LoadError::new(place(), LoadErrorKind::Undecodable { format: "STL", reason })
            };
            let facets = stl_io::create_stl_reader(&mut source).map_err(failed)?;
            for (i, facet) in facets.enumerate() {
                if i.is_multiple_of(4096) {
                    memory.check_cancelled().map_err(|kind| LoadError::new(place(), kind))?;
                }
                let facet = facet.map_err(failed)?;
                push(&mut self.mesh, &mut self.sizes, &facet)
                    .map_err(|kind| LoadError::new(place(), kind))?;
            }
        }
        Ok(())
    }
}

/// Adds a facet to the mesh.
fn push(mesh: &mut Mesh, sizes: &mut PolygonSizes, facet: &stl_io::Triangle) -> Result<(), LoadErrorKind> {
    sizes.add(3, true)?;
    let first = mesh.positions.len() as u32;
    for vertex in &facet.vertices {
        for number in vertex.0 {
            if !number.is_finite() {
                let found = number.to_string();
                return Err(LoadErrorKind::Number { what: "a facet's corner", found });
            }
        }
        mesh.positions.push(DVec3::from_array(vertex.0.map(f64::from)));
    }
    let corner = |i| Corner { position: first + i, normal: NONE, texcoord: NONE, color: NONE };
    mesh.push_polygon(&[0, 1, 2].map(corner), NONE);
    Ok(())
}

/// A binary file whose header is cleared, so that it never looks like text: an empty line, which
/// the reader looks at, and zeros.
struct Records<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Read for Records<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let rest = self.bytes.get(self.at..).unwrap_or(&[]);
        let count = rest.len().min(out.len());
        out[..count].copy_from_slice(&rest[..count]);
        let header = 80_usize.saturating_sub(self.at).min(count);
        out[..header].fill(0);
        if self.at == 0 && header > 0 {
            out[0] = b'\n';
        }
        self.at += count;
        Ok(count)
    }
}

impl Seek for Records<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        seek_to_start(to)?;
        self.at = 0;
        Ok(0)
    }
}

/// Accepts the only seek that the reader asks for: to the beginning.
fn seek_to_start(to: SeekFrom) -> io::Result<()> {
    match to {
        SeekFrom::Start(0) => Ok(()),
        _ => Err(io::ErrorKind::Unsupported.into()),
    }
}

/// The lines of a text.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Number of lines passed.
    line: u32,
    /// Bytes of the line that is being given out, in reverse.
    pending: Vec<u8>,
    /// Set from `solid` to `endsolid`.
    is_in_solid: bool,
}

impl<'a> Lines<'a> {
    /// Returns the next line without its end.
    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return None;
        }
        let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let line = &rest[..end.unwrap_or(rest.len())];
        let ends = match rest.get(line.len()..) {
            Some([b'\r', b'\n', ..]) => 2,
            Some([_, ..]) => 1,
            _ => 0,
        };
        self.at += line.len() + ends;
        self.line = self.line.saturating_add(1);
        Some(line.trim_ascii())
    }

    /// Skips to the next solid. Returns false at the end of the file.
    fn begin_solid(&mut self, file_name: &str, warnings: &mut Vec<LoadWarning>) -> bool {
        self.pending.clear();
        while let Some(line) = self.next() {
            let word = line.split(u8::is_ascii_whitespace).next().unwrap_or(&[]);
            if word.eq_ignore_ascii_case(b"solid") {
                self.is_in_solid = true;
                // The name is not needed, and may be in any encoding.
                self.pending.extend(b"solid -\n".iter().rev());
                return true;
            }
            if !word.is_empty() && warnings.len() < MAX_WARNINGS {
                let place = FilePosition::line(file_name, self.line);
                warnings.push(LoadWarning { place, message: "text outside of a solid is left out".into() });
            }
        }
        false
    }
}

/// One solid of a text, line by line, in lower case.
struct Solid<'a, 'b> {
    lines: &'a mut Lines<'b>,
    /// Number of the last line given out.
    given: &'a std::cell::Cell<u32>,
}

impl Read for Solid<'_, '_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.lines.pending.is_empty() {
            if !self.lines.is_in_solid {
                return Ok(0);
            }
            let Some(line) = self.lines.next() else { return Ok(0) };
            self.given.set(self.lines.line);
            let is_last = line.get(..8).is_some_and(|w| w.eq_ignore_ascii_case(b"endsolid"));
            self.lines.is_in_solid = !is_last;
            let line = if is_last { b"endsolid" } else { line };
            self.lines.pending.push(b'\n');
            self.lines.pending.extend(line.iter().rev().map(|b| printable(*b)));
        }
        let mut count = 0;
        while let (Some(place), Some(byte)) = (out.get_mut(count), self.lines.pending.pop()) {
            *place = byte;
            count += 1;
        }
        Ok(count)
    }
}

/// Returns a byte in lower case; one that is not ASCII as `?`, which no number contains.
fn printable(byte: u8) -> u8 {
    if byte.is_ascii() { byte.to_ascii_lowercase() } else { b'?' }
}

impl Seek for Solid<'_, '_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        seek_to_start(to)?;
        // The reader has seen the first line, which stands for any.
        self.lines.pending.clear();
        self.lines.pending.extend(b"solid -\n".iter().rev());
        Ok(0)
    }
}

#[cfg(test)]
mod tests;

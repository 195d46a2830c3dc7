//! STL: facets of stereolithography, as text or binary.
//!
//! In: the bytes of a file. Out: a mesh of triangles, each with its own positions, in the units of
//! the file; z is up in most files, and stays so. The normals of the file are ignored: the order of
//! the corners, counter-clockwise seen from outside, gives the same, and files with zero or wrong
//! normals are common. The format has no colours that programs agree on; attribute bytes are
//! ignored. A facet with a corner that is not finite is left out.
//!
//! A file is binary if its length is that of the records that it counts, or if it has a zero byte
//! soon, whatever its first word. Counts are compared with the file's length before anything is
//! allocated.
//!
//! Source: 3D Systems, StereoLithography Interface Specification, 1989 (as reprinted in M. Burns,
//! Automated Fabrication, section 6.5).

mod text;

use super::defects::Defects;
use super::mesh::{LoadedMesh, PolygonSizes, Smoothing, add_normals};
use super::{FilePosition, LoadError, LoadErrorKind, LoadMemory, LoadWarning};
use fbptr_core::scene::{Corner, Geometry, Mesh, NONE};
use glam::DVec3;

/// Bytes before the records of a binary file: a comment and their number.
const HEADER_BYTES: u64 = 84;
/// Bytes of a record: a normal, three corners, an attribute.
const RECORD_BYTES: u64 = 50;
/// Bytes of the mesh for each facet: positions, corners, a polygon and a triangle.
const FACET_BYTES: u64 = 3 * 24 + 3 * 16 + 12 + 12 + 4;

/// Returns whether a file of `length` bytes that begins with `first` is STL.
pub(crate) fn is_stl(first: &[u8], length: u64) -> bool {
    count(first).is_some_and(|n| length == binary_bytes(n)) || is_text(first)
}

/// Returns a text without its byte order mark.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Returns whether bytes begin like an STL text: `solid`, then a facet or the end; or a facet.
fn is_text(first: &[u8]) -> bool {
    let mut words = without_mark(first).split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
    let is = |word: &[u8], known: &str| word.eq_ignore_ascii_case(known.as_bytes());
    match words.next() {
        Some(word) if is(word, "solid") => words.any(|w| is(w, "facet") || is(w, "endsolid")),
        Some(word) if is(word, "facet") => words.next().is_some_and(|w| is(w, "normal")),
        _ => false,
    }
}

/// Returns whether a file is a text: it has no zero byte soon, as the count of a binary file has.
/// Zeros at the end fill a block.
fn begins_as_text(bytes: &[u8]) -> bool {
    let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    end > 0 && !bytes[..end.min(512)].contains(&0)
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
        _work = memory.work(corners.div_ceil(3) * FACET_BYTES * 3).map_err(refused)?;
        text::read(without_mark(bytes), &mut facets, memory, &mut warnings)?;
    } else {
        let count = checked_count(bytes, file_name, &mut warnings)?;
        _work = memory.work(u64::from(count) * FACET_BYTES).map_err(refused)?;
        facets.read_records(bytes, count, memory, &mut warnings)?;
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
    let Some(stated) = count(bytes) else {
        return Err(short(length, format!("a binary file has {HEADER_BYTES} bytes before its facets")));
    };
    // Programs that do not know the number when they begin leave one of these.
    let there = (length - HEADER_BYTES) / RECORD_BYTES;
    let is_open = matches!(stated, 0 | u32::MAX) && (length - HEADER_BYTES).is_multiple_of(RECORD_BYTES);
    let count = match u32::try_from(there) {
        Ok(there) if is_open && there > 0 => {
            let message = format!("its number of facets is {stated}: the {there} that are there are read");
            warnings.push(LoadWarning { place: FilePosition::byte(file_name, 80), message });
            there
        }
        _ => stated,
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
    fn read_records(
        &mut self,
        bytes: &[u8],
        count: u32,
        memory: &LoadMemory,
        warnings: &mut Vec<LoadWarning>,
    ) -> Result<(), LoadError> {
        let n = count as usize;
        self.mesh.positions.reserve_exact(3 * n);
        self.mesh.corners.reserve_exact(3 * n);
        self.mesh.polygons.reserve_exact(n);
        self.mesh.triangles.reserve_exact(n);
        self.mesh.triangle_polygon.reserve_exact(n);
        let file_name = self.file_name;
        let place = |i: u64| FilePosition::byte(file_name, HEADER_BYTES + RECORD_BYTES * i);
        let mut not_finite = Defects::default();
        let records = bytes[HEADER_BYTES as usize..].as_chunks::<{ RECORD_BYTES as usize }>().0;
        for (i, record) in (0..u64::from(count)).zip(records) {
            if i.is_multiple_of(4096) {
                memory.check_cancelled().map_err(|kind| LoadError::new(place(i), kind))?;
            }
            let number = |k: usize| f32::from_le_bytes(std::array::from_fn(|b| record[4 * k + b]));
            // The first three are the normal.
            let corners = [3, 6, 9].map(|k| [number(k), number(k + 1), number(k + 2)]);
            if let Some(wrong) = corners.as_flattened().iter().find(|x| !x.is_finite()) {
                let kind = LoadErrorKind::Number { what: "a facet's corner", found: wrong.to_string() };
                not_finite.note(|| LoadError::new(place(i), kind));
                continue;
            }
            let corners = corners.map(|corner| DVec3::from_array(corner.map(f64::from)));
            self.push(&corners).map_err(|kind| LoadError::new(place(i), kind))?;
        }
        if self.mesh.polygons.is_empty()
            && let Some(error) = not_finite.first()
        {
            return Err(error.clone());
        }
        warnings.extend(not_finite.warning("the facet is left out"));
        Ok(())
    }

    /// Adds a facet to the mesh.
    fn push(&mut self, corners: &[DVec3]) -> Result<(), LoadErrorKind> {
        self.sizes.add(corners.len(), true)?;
        let mesh = &mut self.mesh;
        let first = mesh.positions.len() as u32;
        mesh.positions.extend_from_slice(corners);
        let corner = |i| Corner { position: first + i, normal: NONE, texcoord: NONE, color: NONE };
        if let &[_, _, _] = corners {
            mesh.push_polygon(&[0, 1, 2].map(corner), NONE);
        } else {
            mesh.push_polygon(&(0..corners.len() as u32).map(corner).collect::<Vec<_>>(), NONE);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;

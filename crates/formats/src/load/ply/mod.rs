//! PLY: the Polygon File Format, as text or binary in either byte order.
//!
//! In: the bytes of a file. Out: a mesh of the elements `vertex` (positions, normals, texture
//! coordinates, colours), `face` (polygons of any size; colours and texture coordinates of a face
//! where vertices have none), `tristrips` (-1 begins a new strip) and `edge`; a file with none of
//! the last three is a cloud of points. Other elements and properties are left out. Colours of
//! whole-number properties are parts of their type's largest number; of a cloud of splats the colour
//! is that of degree 0 (`f_dc_0` to `f_dc_2`). `comment TextureFile` names the texture.
//!
//! Passed over with a warning: vertices that are not finite and what uses them, indices out of range,
//! lines with more values or fewer than a row. The header's counts are believed by nobody: each
//! element's smallest size is compared with the bytes that are left, and memory is reserved, before
//! its rows are read.
//!
//! Sources: G. Turk, The PLY Polygon File Format, 1994; B. Kerbl et al., "3D Gaussian Splatting for
//! Real-Time Radiance Field Rendering", 2023 (spherical harmonics of the colours).

mod build;
mod elements;
mod header;
mod reader;
mod rows;
#[cfg(test)]
mod tests;

use super::defects::earliest;
use super::mesh::{LoadedMesh, Smoothing, add_normals};
use super::obj::SideFiles;
use super::side_files::{folder_of, picture};
use super::{FilePosition, LoadError, LoadErrorKind, LoadMemory, LoadWarning};
use build::Built;
use elements::{Elements, most_bytes};
use fbptr_core::scene::{Geometry, Material, NONE};
use glam::DVec3;
use header::Header;
use reader::Reader;
use std::sync::Arc;

/// Returns a file without its byte order mark.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Returns whether a file that begins with `first` is PLY.
pub(crate) fn is_ply(first: &[u8]) -> bool {
    let [word @ .., end] = without_mark(first).get(..4).unwrap_or(b"none") else { return false };
    word.eq_ignore_ascii_case(b"ply") && end.is_ascii_whitespace()
}

/// Parses the PLY file `file_name` from its bytes, without the textures that it names. Room for the
/// rows of an element is reserved before they are read.
///
/// # Errors
/// If the file has an error, or `memory` has no room or is cancelled.
pub fn parse(
    bytes: &[u8],
    file_name: &str,
    memory: &mut LoadMemory,
    smoothing: Smoothing,
) -> Result<LoadedMesh, LoadError> {
    parse_textured(bytes, &mut |_| None, file_name, memory, smoothing)
}

/// [`parse`], with the textures that the file names, which come from `side_files`.
///
/// # Errors
/// Those of [`parse`].
pub fn parse_textured(
    bytes: &[u8],
    side_files: &mut SideFiles<'_>,
    file_name: &str,
    memory: &mut LoadMemory,
    smoothing: Smoothing,
) -> Result<LoadedMesh, LoadError> {
    let refused = |kind| LoadError::new(FilePosition::file(file_name), kind);
    let bytes = without_mark(bytes);
    let _header = memory.work(header_bytes(bytes)).map_err(refused)?;
    let header = header::read(bytes, file_name)?;
    let start = (header.end, header.line);
    let mut reader = Reader::new(bytes, start, header.encoding, &header.elements, file_name);
    let (mut work, mut elements) = (Vec::new(), Elements::default());
    for element in &header.elements {
        let reserved = most_bytes(element, &reader).and_then(|most| memory.work(most));
        work.push(reserved.map_err(|kind| LoadError::new(reader.position(reader.place()), kind))?);
        elements.read(element, &mut reader, memory)?;
    }
    if elements.vertices.lacks_positions {
        let reason = "a vertex has no x, y and z".to_owned();
        let place = FilePosition::line(file_name, header.line - 1);
        return Err(LoadError::new(place, LoadErrorKind::Undecodable { format: "PLY", reason }));
    }
    let mut warnings = warnings_of_header(&header, file_name);
    let has_bytes = elements.vertices.has_bytes || elements.faces.has_bytes;
    let defects = std::mem::take(&mut elements.defects);
    let lacks_normals = elements.vertices.normals.is_empty();
    let Built { mut mesh, indices } = build::mesh(elements, &reader, header.textures.len())?;
    if mesh.corners.is_empty()
        && let Some(error) = earliest([&defects.positions, &indices, &defects.cut])
    {
        return Err(error);
    }
    warnings.extend(defects.long.warning("they are left out"));
    warnings.extend(defects.cut.warning("the row is left out"));
    warnings.extend(defects.positions.warning("the vertex and what uses it are left out"));
    warnings.extend(defects.attributes.warning("0 is taken, white for a colour"));
    warnings.extend(indices.warning("its row is left out"));
    let mut warn = |message: &str| {
        warnings.push(LoadWarning { place: FilePosition::file(file_name), message: message.into() });
    };
    if has_bytes {
        warn("colours above 1 are read as 0 to 255");
    }
    if mesh.corners.is_empty() {
        warn("no faces, lines or points: nothing is drawn");
    }
    if mesh.texcoords.is_empty() && !header.textures.is_empty() {
        warn("its texture is not shown: there are no texture coordinates");
    }
    let is_open = lacks_normals
        && !mesh.polygons.is_empty()
        && add_normals(&mut mesh, &[], smoothing, memory).map_err(refused)?;
    mesh.shrink_to_fit();
    memory.reserve_result(mesh.size_bytes() as u64).map_err(refused)?;
    let mut geometry = Geometry::from(mesh);
    if geometry.mesh.texcoords.is_empty() {
        geometry.mesh.polygons.iter_mut().for_each(|p| p.material = NONE);
    } else {
        read_textures(&header, &mut geometry, side_files, file_name, &mut warnings, memory)?;
    }
    Ok(LoadedMesh { geometry, warnings, is_open })
}

/// Returns the warning about lines of the header that are not known.
fn warnings_of_header(header: &Header, file_name: &str) -> Vec<LoadWarning> {
    let warning = header.unknown.as_ref().map(|(line, text, count)| {
        let more = if *count > 1 { format!(", and {} more", count - 1) } else { String::new() };
        let message = format!("{text:?}{more} is no line of a PLY header: it is left out");
        LoadWarning { place: FilePosition::line(file_name, *line), message }
    });
    warning.into_iter().collect()
}

/// Reads the textures, each as a white material's.
fn read_textures(
    header: &Header,
    geometry: &mut Geometry,
    side_files: &mut SideFiles<'_>,
    file_name: &str,
    warnings: &mut Vec<LoadWarning>,
    memory: &mut LoadMemory,
) -> Result<(), LoadError> {
    for (name, line) in &header.textures {
        let found = picture(std::slice::from_ref(name), side_files, folder_of(file_name), memory)?;
        let mut warn = |message| {
            warnings.push(LoadWarning { place: FilePosition::line(file_name, *line), message });
        };
        if let Some(note) = found.note {
            warn(note);
        }
        let texture =
            found.texture.map_err(|reason| warn(format!("texture {name:?} {reason}: it is left out")));
        let kd = if texture.is_ok() { DVec3::ONE } else { Material::default().kd };
        let name = name.clone();
        geometry.mesh.materials.push(Material { kd, name, ..Material::default() });
        geometry.textures.push(texture.ok().map(Arc::new));
    }
    Ok(())
}

/// Returns the bytes for reading a header: its text, split and kept.
fn header_bytes(bytes: &[u8]) -> u64 {
    let end = b"end_header";
    let length = bytes.windows(end.len()).position(|w| w.eq_ignore_ascii_case(end)).unwrap_or(bytes.len());
    40 * length as u64 + 4096
}

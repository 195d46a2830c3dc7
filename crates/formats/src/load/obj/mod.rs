//! OBJ and MTL: Wavefront's meshes and materials, read by `tobj` after a check of every line.
//!
//! In: the bytes of a file (UTF-8, UTF-16 or Latin-1, any line ends, a BOM, `\` continuations,
//! lines of any length). Out: the file's polygons in object space, each corner with its own
//! indices; a vertex is an OBJ position, so groups and objects do not split a surface. Numbers are
//! read as f64 and are finite. Unused positions are left out; a file without any `f`, `l` and `p` is
//! a cloud of points.
//!
//! `tobj` reports no line numbers, ignores `p`, accepts `nan`, splits vertices by group, and can
//! panic. So every line is checked first (`lexer`), with its line number; `tobj` gets the checked
//! lines alone, elements after vertices, in one group; and its result is combined with the
//! properties that the check recorded for each element (`assemble`). Unknown statements, elements
//! that cannot be read and what uses a vertex that cannot are left out with a warning; a file that
//! nothing is left of is refused with the first reason.
//!
//! Source: Wavefront, Advanced Visualizer Manual, appendix B1 (Object Files) and the MTL material
//! format 4.2.

mod assemble;
mod cost;
mod lexer;
mod libraries;
mod lines;
mod mtl;
mod opacity;
mod placement;
#[cfg(test)]
mod tests;
mod through_tobj;

use super::mesh::{LoadedMesh, Smoothing, add_normals};
use super::side_files::{folder_of, picture};
use super::{FilePosition, LoadError, LoadErrorKind, LoadMemory, LoadWarning};
use fbptr_core::memory::Reservation;
use fbptr_core::scene::{Geometry, Mesh, NONE, Texture};
use lexer::{ElementKind, Elements, Lexer};
use libraries::{Found, read_libraries};
use opacity::masked;
use placement::Placement;
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

/// Function that returns the bytes of a referenced file by the name in the OBJ file, `/` between
/// folders, relative to the OBJ's own folder; `None` if there is no such file or it may not be
/// read.
pub type SideFiles<'a> = dyn FnMut(&str) -> Option<Vec<u8>> + 'a;

/// Parses the OBJ file `file_name` from its bytes; MTL files and textures come from `side_files`.
///
/// A missing MTL file or material, or a texture that is missing or no picture, is a warning. A file
/// of vertices without any element is a cloud of points; one without any vertex gives an empty
/// mesh, with a warning.
pub fn parse(bytes: &[u8], side_files: &mut SideFiles<'_>, file_name: &str) -> Result<LoadedMesh, LoadError> {
    parse_within(bytes, side_files, file_name, &mut LoadMemory::unlimited())
}

/// [`parse`] within the limits of `memory`. Room for tables and mesh is reserved by counts of the
/// text's words before it is read, and room for each picture once its header gives its size.
///
/// # Errors
/// Those of [`parse`], and one if `memory` has no room or is cancelled.
pub fn parse_within(
    bytes: &[u8],
    side_files: &mut SideFiles<'_>,
    file_name: &str,
    memory: &mut LoadMemory,
) -> Result<LoadedMesh, LoadError> {
    parse_smooth(bytes, side_files, file_name, memory, Smoothing::Indices)
}

/// [`parse_within`], with a choice of normals for the faces that have none.
///
/// # Errors
/// Those of [`parse_within`].
pub fn parse_smooth(
    bytes: &[u8],
    side_files: &mut SideFiles<'_>,
    file_name: &str,
    memory: &mut LoadMemory,
    smoothing: Smoothing,
) -> Result<LoadedMesh, LoadError> {
    let refused = |kind| LoadError::new(FilePosition::file(file_name), kind);
    let (bytes, _decoded) = decoded(bytes, memory).map_err(refused)?;
    let bytes = &*bytes;
    let _tables = memory.work(cost::obj_bytes(bytes)).map_err(refused)?;
    let mut lexer = Lexer::new(bytes, file_name);
    let raw = through_tobj::obj(&mut lexer)?;
    let Elements { faces, uses, order, libraries, mut warnings, left_out } = lexer.into_elements();
    if let (true, Some(error)) = (faces.is_empty(), left_out.first()) {
        return Err(error);
    }
    let library = read_libraries(&libraries, side_files, file_name, &mut warnings, memory)?;
    let mut textures = Textures::default();
    // Only used materials are stored, in the order of first use.
    let mut geometry = Geometry::default();
    let mut material_of_use = Vec::with_capacity(uses.len());
    let mut placements = Vec::new();
    let (mut black, mut black_file) = (mtl::Alike::default(), None);
    for (name, line) in &uses {
        let Some(found) = library.materials.get(name.as_str()) else {
            // If no MTL file was found, that has been reported already. Some exporters write an empty
            // usemtl for faces without a material.
            if !name.is_empty() && (libraries.is_empty() || !library.materials.is_empty()) {
                let message = format!("material {name:?} is not defined: the faces keep the draw's material");
                warnings.push(LoadWarning { place: FilePosition::line(file_name, *line), message });
            }
            material_of_use.push(NONE);
            continue;
        };
        material_of_use.push(geometry.mesh.materials.len() as u32);
        let texture = textures.of(found, side_files, file_name, &mut warnings, memory)?;
        let mut material = found.material.material.clone();
        if texture.is_some() && material.texture.is_some() && mtl::show_texture(&mut material) {
            black.note(found.material.texture_place.line, &material.name);
            black_file.get_or_insert_with(|| found.material.texture_place.file.clone());
        }
        geometry.textures.push(texture);
        geometry.mesh.materials.push(material);
        placements.push(found.material.placement);
    }
    let why = "is read as 1 1 1: its texture would be black";
    warnings.extend(black.warning(black_file.as_deref().unwrap_or(file_name), "Kd 0 0 0", why));
    assemble::assemble(&mut geometry.mesh, raw, &faces, &order, &material_of_use).map_err(|reason| {
        LoadError::new(FilePosition::file(file_name), LoadErrorKind::Undecodable { format: "OBJ", reason })
    })?;
    place_pictures(&mut geometry.mesh, &placements, memory).map_err(refused)?;
    let lacks_normals = faces.iter().any(|f| f.kind == ElementKind::Face && !f.has_normals);
    let is_open = lacks_normals && {
        let polygons = faces.iter().filter(|f| f.kind == ElementKind::Face);
        let groups: Vec<u32> = polygons.map(|f| f.smoothing_group).collect();
        add_normals(&mut geometry.mesh, &groups, smoothing, memory).map_err(refused)?
    };
    geometry.mesh.shrink_to_fit();
    memory.reserve_result(geometry.mesh.size_bytes() as u64).map_err(refused)?;
    if faces.is_empty() {
        let message = "no faces, lines or points: nothing is drawn".into();
        warnings.push(LoadWarning { place: FilePosition::file(file_name), message });
    }
    Ok(LoadedMesh { geometry, warnings, is_open })
}

/// Applies the texture options of each material to the texture coordinates of its faces.
fn place_pictures(
    mesh: &mut Mesh,
    placements: &[Placement],
    memory: &LoadMemory,
) -> Result<(), LoadErrorKind> {
    if placements.iter().any(Placement::moves) {
        let _work = memory.work(placement::working_bytes(mesh))?;
        placement::place(mesh, placements);
    }
    Ok(())
}

/// Converts a file's text to UTF-8, or leaves it as UTF-8 or Latin-1: UTF-16 is recognized by its
/// byte order mark, or by the zero byte of its first letter.
fn decoded<'a>(
    bytes: &'a [u8],
    memory: &LoadMemory,
) -> Result<(Cow<'a, [u8]>, Option<Reservation>), LoadErrorKind> {
    let (unit, rest): (fn([u8; 2]) -> u16, _) = match bytes {
        [0xff, 0xfe, rest @ ..] => (u16::from_le_bytes, rest),
        [0xfe, 0xff, rest @ ..] => (u16::from_be_bytes, rest),
        [1..=255, 0, ..] => (u16::from_le_bytes, bytes),
        [0, 1..=255, ..] => (u16::from_be_bytes, bytes),
        _ => return Ok((Cow::Borrowed(bytes), None)),
    };
    // Each unit of two bytes becomes three bytes of UTF-8 at most, in a vector that is copied as it
    // grows.
    let held = memory.work(4 * bytes.len() as u64)?;
    let units = rest.as_chunks::<2>().0.iter().map(|b| unit(*b));
    let text: String = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    Ok((Cow::Owned(text.into_bytes()), Some(held)))
}

/// The textures of the materials read so far, by what they are made of, with the warnings that each
/// gave: materials that name the same pictures share one texture.
#[derive(Default)]
struct Textures(HashMap<TextureKey, NotedTexture>);

/// A texture, if there is one, and the warnings that it gave.
type NotedTexture = (Option<Arc<Texture>>, Vec<(Channel, String)>);

/// The parts of a texture: a folder, the picture of its colours and that of its opacity there, and
/// whether it is clamped.
type TextureKey = (String, [Option<String>; 2], bool);

/// The picture of a material that a warning is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Channel {
    Color,
    Opacity,
}

impl Textures {
    /// Returns the texture of a material; it is read if no other material has it.
    fn of(
        &mut self,
        found: &Found,
        side_files: &mut SideFiles<'_>,
        file_name: &str,
        warnings: &mut Vec<LoadWarning>,
        memory: &mut LoadMemory,
    ) -> Result<Option<Arc<Texture>>, LoadError> {
        let material = &found.material;
        let pictures = [material.material.texture.clone(), material.opacity_map.clone()];
        let key = (found.folder.clone(), pictures, material.placement.is_clamped);
        if !self.0.contains_key(&key) {
            let read = read_texture(found, side_files, file_name, memory)?;
            self.0.insert(key.clone(), read);
        }
        let (texture, notes) = &self.0[&key];
        warnings.extend(notes.iter().map(|(channel, message)| {
            let place = match channel {
                Channel::Color => &material.texture_place,
                Channel::Opacity => &material.opacity_place,
            };
            LoadWarning { place: place.clone(), message: message.clone() }
        }));
        Ok(texture.clone())
    }
}

/// Reads the texture of a material from the folder of its MTL file, or from that of the OBJ file. A
/// picture that is missing or cannot be decoded is left out with a warning.
fn read_texture(
    Found { material, folder }: &Found,
    side_files: &mut SideFiles<'_>,
    file_name: &str,
    memory: &mut LoadMemory,
) -> Result<NotedTexture, LoadError> {
    let mut notes = Vec::new();
    let mut read = |name: &Option<String>, channel: Channel| {
        let Some(name) = name else { return Ok(None) };
        let mut warn = |message| notes.push((channel, message));
        let names = [format!("{folder}{name}"), name.clone()];
        let found = picture(&names, side_files, folder_of(file_name), memory)?;
        if let Some(note) = found.note {
            warn(note);
        }
        let texture =
            found.texture.map_err(|reason| warn(format!("texture {name:?} {reason}: it is left out")));
        Ok(texture.ok())
    };
    let color = read(&material.material.texture, Channel::Color)?;
    let is_same = material.material.texture == material.opacity_map;
    let opacity = if is_same { None } else { read(&material.opacity_map, Channel::Opacity)? };
    let texture = match (color, opacity) {
        (color, None) => color,
        (color, Some(opacity)) => Some(
            masked(color, &opacity, memory)
                .map_err(|kind| LoadError::new(material.opacity_place.clone(), kind))?,
        ),
    };
    let clamped = |texture: Texture| if material.placement.is_clamped { texture.clamped() } else { texture };
    Ok((texture.map(|texture| Arc::new(clamped(texture))), notes))
}

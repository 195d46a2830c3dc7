//! Adapter to the crate `tobj`; no other file refers to it.

use super::lexer::Lexer;
use crate::load::{FilePosition, LoadError, LoadErrorKind, never_panicking};
use std::io::BufRead;

/// Result of `tobj` for the checked lines, all in one group: arrays in the order of first use, and
/// indices into them.
#[derive(Default)]
pub(super) struct RawMesh {
    /// x, y, z of each position.
    pub(super) positions: Vec<f64>,
    /// r, g, b of each position, or empty.
    pub(super) colors: Vec<f64>,
    /// u, v of each texture coordinate.
    pub(super) texcoords: Vec<f64>,
    /// x, y, z of each normal.
    pub(super) normals: Vec<f64>,
    /// Position index of each corner.
    pub(super) indices: Vec<u32>,
    /// Texture coordinate index of each corner, or empty.
    pub(super) texcoord_indices: Vec<u32>,
    /// Normal index of each corner, or empty.
    pub(super) normal_indices: Vec<u32>,
    /// Number of corners of each element; empty if all have three.
    pub(super) arities: Vec<u32>,
}

/// One material as read by `tobj`; `None` for each value that the file does not have.
#[derive(Default)]
pub(super) struct RawMaterial {
    pub(super) ka: Option<[f64; 3]>,
    pub(super) kd: Option<[f64; 3]>,
    pub(super) ks: Option<[f64; 3]>,
    pub(super) ke: Option<[f64; 3]>,
    pub(super) ns: Option<f64>,
    pub(super) d: Option<f64>,
    pub(super) illum: Option<u8>,
    pub(super) map_kd: Option<String>,
}

/// Separate indices for each attribute; points, lines and n-gons are not converted.
const AS_IT_STANDS: tobj::LoadOptions =
    tobj::LoadOptions { single_index: false, triangulate: false, ignore_points: false, ignore_lines: false };

/// Passes the checked lines to `tobj`. An error of the check is returned unchanged; one of `tobj`
/// itself, which the check should have prevented, with the line that was being read.
pub(super) fn obj(lexer: &mut Lexer<'_>) -> Result<RawMesh, LoadError> {
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let loaded = never_panicking(|| tobj::load_obj_buf(lexer, &AS_IT_STANDS, no_materials));
    if let Some(error) = lexer.take_error() {
        return Err(error);
    }
    let (models, _) = tobj_result(loaded, "OBJ", || lexer.place())?;
    let mesh = models.into_iter().next().map(|model| model.mesh).unwrap_or_default();
    Ok(RawMesh {
        positions: mesh.positions,
        colors: mesh.vertex_color,
        texcoords: mesh.texcoords,
        normals: mesh.normals,
        indices: mesh.indices,
        texcoord_indices: mesh.texcoord_indices,
        normal_indices: mesh.normal_indices,
        arities: mesh.face_arities,
    })
}

/// Passes the checked lines of an MTL file to `tobj`.
pub(super) fn mtl(checked: &mut impl BufRead, file_name: &str) -> Result<Vec<RawMaterial>, LoadError> {
    let loaded = never_panicking(|| tobj::load_mtl_buf(checked));
    let (materials, _) = tobj_result(loaded, "MTL", || FilePosition::file(file_name))?;
    let raw = |m: tobj::Material| RawMaterial {
        ka: m.ambient,
        kd: m.diffuse,
        ks: m.specular,
        ke: m.emissive,
        ns: m.shininess,
        d: m.dissolve,
        illum: m.illumination_model,
        map_kd: m.diffuse_texture,
    };
    Ok(materials.into_iter().map(raw).collect())
}

fn tobj_result<T>(
    loaded: Result<Result<T, tobj::LoadError>, String>,
    format: &'static str,
    place: impl FnOnce() -> FilePosition,
) -> Result<T, LoadError> {
    let reason = match loaded {
        Ok(Ok(value)) => return Ok(value),
        Ok(Err(error)) => error.to_string(),
        Err(panic) => panic,
    };
    Err(LoadError::new(place(), LoadErrorKind::Undecodable { format, reason }))
}

//! Memory estimates for draws by the tile renderer, for printed plans and for reservations.
//!
//! Exact figures: the data kept per mesh, screen vertices, lighting tables, the tiles' lists while
//! empty. Estimated figures: the number of vertices that corners with different normals or texture
//! coordinates make, and the face lists, which grow as faces are added.

use crate::memory::DepthFormat;
use crate::pipeline::draw_call::{DrawCall, Target};
use crate::pipeline::indexed_mesh::{CLUSTER_BYTES, LEAST_FACES};
use crate::pipeline::plan::{Part, Parts};
use crate::pipeline::tile::{DEPTH_VERTEX_BYTES, FastLight, MaterialBinding, SCREEN_VERTEX_BYTES, bin_bytes};
use crate::pipeline::working::{Working, WorkingBytes};
use crate::scene::{Cull, Interpolation, ShadeMode};

/// Bytes of a record of four f32.
const FOUR: u64 = 16;

/// Returns the estimated bytes of a draw by the tile renderer, without the frame's memories and the
/// plan's own tables of normals.
pub(crate) fn estimated_bytes(call: &DrawCall, target: &Target, parts: Parts) -> u64 {
    let mesh = &call.geometry.mesh;
    let faces = mesh.triangles.len() as u64;
    let distinct = [mesh.positions.len(), mesh.normals.len(), mesh.texcoords.len(), mesh.colors.len()];
    let most = distinct.into_iter().max().unwrap_or(0).min(mesh.corners.len());
    let vertices = most as u64;
    let is_lit = parts.is_lit();
    let is_textured = parts.uses(Part::SampleTextures);
    let is_flat = call.shade == ShadeMode::Flat;
    let per = |is_there: bool, bytes: u64| if is_there { bytes } else { 0 };

    // Per mesh: its indexed form, and the table of flat-shaded faces.
    let own = 24
        + per(is_lit && !is_flat, FOUR)
        + per(!mesh.texcoords.is_empty(), FOUR)
        + per(!mesh.colors.is_empty(), FOUR);
    let clusters = per(faces >= LEAST_FACES as u64, faces * CLUSTER_BYTES / 16 + vertices / 8);
    let prepared = vertices * own + faces * (12 + FOUR) + per(mesh.materials.len() > 1, faces * 4) + clusters;
    let has_face_table = is_flat && (is_lit || !mesh.colors.is_empty());
    let face_table = per(has_face_table, faces * (24 + FOUR + per(!mesh.colors.is_empty(), FOUR)));

    // Per draw: screen vertices, and the tables of light at vertices or faces.
    let is_deep = parts.uses(Part::DepthMemory) && target.depth_format != Default::default();
    let screen = vertices * (SCREEN_VERTEX_BYTES + per(is_deep, DEPTH_VERTEX_BYTES));
    let points = if is_flat { faces } else { vertices };
    let lit_first = has_face_table || parts.uses(Part::LightVertices);
    let tables = per(lit_first, points * (FOUR + per(is_textured, FOUR)));
    let runs_positions = parts.uses(Part::InterpolatePositions)
        && (call.is_parallel() || call.interp == Interpolation::Affine);
    let positions = per(runs_positions, vertices * FOUR);
    let kept_faces = if call.cull == Cull::None { faces } else { faces.div_ceil(2) };
    let size = (target.memory.width() as usize, target.memory.height() as usize);
    prepared + face_table + screen + tables + positions + bin_bytes(faces, kept_faces, size)
}

/// Returns the maximum working memory of a draw with `vertices` indexed vertices, without the
/// tiles' lists.
pub(crate) fn working_bytes(
    call: &DrawCall,
    format: DepthFormat,
    parts: Parts,
    vertices: u64,
) -> WorkingBytes {
    let mesh = &call.geometry.mesh;
    let faces = mesh.triangles.len() as u64;
    let is_lit = parts.is_lit();
    let points = if call.shade == ShadeMode::Flat { faces } else { vertices };
    let has_points = is_lit || call.shade == ShadeMode::Flat && !mesh.colors.is_empty();
    let per = |is_there: bool, bytes: u64| if is_there { bytes } else { 0 };
    // A few words per cluster and per block of vertices, in lists whose capacity can be twice their
    // length.
    let marks = (faces + vertices).div_ceil(4);
    let mut bytes = WorkingBytes::default();
    bytes[Working::ScreenVertices] = vertices * SCREEN_VERTEX_BYTES + marks;
    bytes[Working::DepthVertices] = per(format != DepthFormat::F32, vertices * DEPTH_VERTEX_BYTES);
    bytes[Working::Normals] = per(has_points, points * FOUR);
    bytes[Working::Lit] = per(has_points && call.shade != ShadeMode::Phong, points * FOUR);
    bytes[Working::Specular] = per(parts.uses(Part::SampleTextures), bytes[Working::Lit]);
    bytes[Working::Positions] = per(parts.uses(Part::InterpolatePositions), vertices * FOUR);
    bytes[Working::Surfaces] = binding_bytes(call);
    bytes
}

/// Returns the bytes of materials and lights in the kernels' format.
pub(crate) fn binding_bytes(call: &DrawCall) -> u64 {
    let lights = call.light_subset.map_or(call.lights.len(), <[u32]>::len);
    let binding = size_of::<MaterialBinding>() + size_of::<FastLight>() * 2 * lights;
    2 * (call.geometry.mesh.materials.len() as u64 + 1) * binding as u64
}

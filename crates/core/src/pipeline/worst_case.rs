//! Worst-case working memory of draws.
//!
//! In: a draw and its parts. Out: the most bytes that each part of the working memory can grow to.
//! tests/allocations/draw_memory.rs compares these figures with a counting allocator.

use super::draw_call::{DrawCall, Target};
use super::ordered::face_list_bytes;
use super::plan::{Part, Parts};
use super::reference::wire_bytes;
use super::tile::{DEPTH_VERTEX_BYTES, SCREEN_VERTEX_BYTES, worst_list_bytes};
use super::tile_frontend::{binding_bytes, working_bytes};
use super::vertex::Vertex;
use super::working::{FACE_ENTRY_BYTES, SORT_KEY_BYTES, Working, WorkingBytes};
use crate::scene::ShadeMode;

/// Limits of the lists that the tiles of a draw hold.
#[derive(Clone, Copy)]
pub(crate) struct ListLimits {
    /// Number of threads.
    pub threads: u64,
    /// Bytes of the lists beyond which a draw is split into pieces.
    pub list_bytes: u64,
}

/// Returns the worst-case bytes of a draw by the path that its plan chooses. `vertices` is the
/// vertex count of its indexed mesh, if computed; otherwise the corner count bounds it.
pub(crate) fn at_worst(
    call: &DrawCall,
    target: &Target,
    parts: Parts,
    vertices: Option<u64>,
    bound: ListLimits,
) -> WorkingBytes {
    let mesh = &call.geometry.mesh;
    let faces = mesh.triangles.len() as u64;
    if parts.uses(Part::TileRenderer) {
        let most = mesh.corners.len().min(3 * mesh.triangles.len()) as u64;
        let mut bytes = working_bytes(call, target.depth_format, parts, vertices.unwrap_or(most));
        let size = (target.memory.width() as usize, target.memory.height() as usize);
        bytes[Working::Lists] = worst_list_bytes(faces, bound.threads, size, bound.list_bytes);
        return bytes;
    }
    let mut bytes = WorkingBytes::default();
    bytes[Working::Surfaces] = binding_bytes(call);
    if parts.uses(Part::TransformVertices) {
        bytes[Working::Vertices] = mesh.positions.len() as u64 * size_of::<Vertex>() as u64;
    }
    if call.shade == ShadeMode::Wire {
        bytes[Working::Edges] = wire_bytes(mesh);
    } else {
        ordered(&mut bytes, faces, parts.uses(Part::SortFaces));
    }
    bytes
}

/// Maximum number of faces of a small draw.
pub(crate) const SMALL_FACES: usize = 512;

/// Returns the worst-case bytes of any small draw by the tile renderer, whatever its state.
/// `surfaces` is the size of its materials in bytes.
pub(crate) fn small_at_worst(surfaces: u64, target: &Target, bound: ListLimits) -> WorkingBytes {
    let (faces, size) =
        (SMALL_FACES as u64, (target.memory.width() as usize, target.memory.height() as usize));
    let mut bytes = WorkingBytes::default();
    bytes[Working::ScreenVertices] = 3 * faces * SCREEN_VERTEX_BYTES + faces;
    bytes[Working::DepthVertices] = 3 * faces * DEPTH_VERTEX_BYTES;
    for table in [Working::Normals, Working::Lit, Working::Specular, Working::Positions] {
        bytes[table] = 3 * faces * SCREEN_VERTEX_BYTES;
    }
    bytes[Working::Surfaces] = surfaces;
    bytes[Working::Lists] = worst_list_bytes(faces, bound.threads, size, bound.list_bytes);
    bytes
}

/// Adds the memory for drawing `faces` faces in submission order. A list's capacity can be twice
/// its length, and while it is reallocated the old buffer exists too.
pub(crate) fn ordered(bytes: &mut WorkingBytes, faces: u64, is_sorted: bool) {
    bytes[Working::Order] = 3 * faces * FACE_ENTRY_BYTES;
    bytes[Working::Sort] = if is_sorted { 3 * faces * SORT_KEY_BYTES } else { 0 };
    bytes[Working::Made] = face_list_bytes(faces);
}

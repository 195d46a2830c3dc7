//! Levels of detail of a mesh: the same surface in fewer faces, each with a bound of its change.
//!
//! In: a mesh of many faces. Out: a list of [`Level`]s, from fine to coarse. There is a one-to-one
//! map from the mesh's surface onto the level's, under which no point moves farther, no normal turns
//! more, and no vertex colour changes more than the level's [`Change`] says: so no point of either
//! surface is farther than that from the other surface. One would know by points of one surface at
//! random whose nearest point on the other one is farther (tests), and by pictures
//! (`tests/drawing/detail.rs`).
//!
//! Nothing here depends on time, threads or the order of hash tables: a mesh always has the same
//! levels.

mod decimation;
mod star;
#[cfg(test)]
mod tests;

pub use star::Change;

use crate::cancel::CancelToken;
use crate::scene::{Geometry, Mesh};
use decimation::Decimation;
use std::sync::Arc;

/// Least number of faces of a mesh with levels, and that of a level which needs no coarser one.
pub(super) const LEAST_FACES: usize = 4096;
const ENOUGH_FACES: usize = LEAST_FACES / 4;

/// Number of steps, each of which multiplies the limits by the square root of two.
const STEPS: u32 = 18;

/// Distance of the first step, as a part of the box's diagonal.
const FIRST_DISTANCE: f64 = 1.0 / 32_768.0;

/// Angle by which the first step and every step turn a normal at most, in radians. Under one light
/// diffuse light changes by two steps with the larger one.
const FIRST_TURN: f64 = 0.0005;
const MOST_TURN: f64 = 0.008;

/// Change of a vertex colour in the first step and in every step at most.
const FIRST_COLOR: f64 = 0.125 / 255.0;
const MOST_COLOR: f64 = 1.0 / 255.0;

/// Part of the faces of the level before that a level has at most.
const LEAST_GAIN: f64 = 0.85;

/// Bytes of a face of the mesh while levels are made of it, an upper bound: corners, faces and
/// their lists, and the levels themselves.
const BUILD_BYTES: u64 = 512;

/// Surface of a mesh in fewer faces.
#[derive(Clone, Debug)]
pub struct Level {
    /// The mesh; it has no texture coordinates.
    pub geometry: Arc<Geometry>,
    /// For each of its triangles one of the whole mesh, of which it is what is left.
    pub origins: Arc<[u32]>,
    /// Bound on the change of all points.
    pub change: Change,
}

impl Level {
    /// Returns the bytes of the level.
    pub fn size_bytes(&self) -> u64 {
        (self.geometry.mesh.size_bytes() + self.origins.len() * 4) as u64
    }
}

impl PartialEq for Level {
    fn eq(&self, other: &Level) -> bool {
        Arc::ptr_eq(&self.geometry, &other.geometry)
    }
}

/// Returns an upper bound on the bytes that making the levels of a mesh takes.
pub fn build_bytes(mesh: &Mesh) -> u64 {
    BUILD_BYTES * mesh.triangles.len() as u64
}

/// Returns whether a mesh may have levels: faces only, enough of them, and all indices in range.
pub(super) fn may_have_levels(mesh: &Mesh) -> bool {
    mesh.triangles.len() >= LEAST_FACES && mesh.lines.is_empty() && mesh.points.is_empty()
}

/// Returns whether all indices of a mesh are in range.
fn is_sound(mesh: &Mesh) -> bool {
    let corners = mesh.corners.len();
    mesh.corners.iter().all(|c| (c.position as usize) < mesh.positions.len())
        && mesh.positions.iter().all(|p| p.is_finite())
        && mesh.triangles.len() == mesh.triangle_polygon.len()
        && mesh.triangles.iter().flatten().all(|c| (*c as usize) < corners)
        && mesh.triangle_polygon.iter().all(|p| (*p as usize) < mesh.polygons.len())
        && mesh.polygons.iter().all(|p| p.first_corner as usize + p.corner_count as usize <= corners)
}

/// Makes the levels of a mesh, from fine to coarse; none for one that has no levels, or if it is
/// cancelled.
pub fn make_levels(mesh: &Mesh, cancel: &CancelToken) -> Vec<Level> {
    if !may_have_levels(mesh) || !is_sound(mesh) {
        return Vec::new();
    }
    make(mesh, cancel).unwrap_or_default()
}

fn make(mesh: &Mesh, cancel: &CancelToken) -> Option<Vec<Level>> {
    let (low, high) = mesh.bounds()?;
    let diagonal = (high - low).length();
    if !(diagonal > 0.0 && diagonal.is_finite()) {
        return None;
    }
    let mut surface = Decimation::of(mesh, cancel)?;
    let mut levels = Vec::new();
    let mut faces = surface.face_count() as f64;
    for step in 0..STEPS {
        let scale = libm::exp2(f64::from(step) / 2.0);
        let limit = Change {
            distance: diagonal * FIRST_DISTANCE * scale,
            turn: (FIRST_TURN * scale).min(MOST_TURN),
            color: (FIRST_COLOR * scale).min(MOST_COLOR),
        };
        surface.simplify(&limit, cancel)?;
        let left = surface.face_count();
        if left as f64 <= LEAST_GAIN * faces {
            faces = left as f64;
            let (mut level, origins) = surface.to_mesh();
            level.materials.clone_from(&mesh.materials);
            let geometry = Arc::new(Geometry { mesh: level, textures: Vec::new() });
            levels.push(Level { geometry, origins: origins.into(), change: surface.change() });
        }
        if left < ENOUGH_FACES {
            break;
        }
    }
    Some(levels)
}

//! Meshes that the program makes itself: X3D's solids, Newell's teapot, and the torus knot of the benchmarks.
//!
//! Out: meshes in object space, y up, right-handed, faces counter-clockwise seen from outside, with exact normals and with
//! texture coordinates ((0,0) at the lower left). Corners that meet share a position, so no edge can open. The same
//! arguments give the same bits on every machine (`libm`). Source of sizes, places and texture coordinates of the solids:
//! X3D (ISO/IEC 19775-1), Geometry3D component.

mod cuboid;
mod knot;
mod newell;
mod revolved;
mod teapot;

pub use cuboid::cuboid;
pub use knot::{knot, knot_bytes};
pub use revolved::{RevolvedParts, cone, cone_parts, cylinder, cylinder_parts, sphere};
pub use teapot::{DEFAULT_TEAPOT_LEVEL, MAX_TEAPOT_LEVEL, teapot, teapot_bytes};

use super::{Corner, Mesh, NONE, Polygon};
use crate::error::Code;
use glam::{DVec2, DVec3};

/// The most triangles that a made mesh has.
pub const MAX_FACES: u64 = 4 << 20;

/// Why a shape cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A length that is no length.
    #[error("{what} must be positive and finite, not {value}")]
    BadSize {
        /// Which length.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Too few steps to bound a body.
    #[error("{what} must be at least {least}, not {value}")]
    TooCoarse {
        /// Which count.
        what: &'static str,
        /// Its value.
        value: u32,
        /// The smallest that is allowed.
        least: u32,
    },
    /// More faces than [`MAX_FACES`].
    #[error("{faces} faces are over the limit of {MAX_FACES}")]
    TooFine {
        /// How many faces it would have.
        faces: u64,
    },
}

impl ShapeError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            ShapeError::BadSize { .. } | ShapeError::TooCoarse { .. } => Code::Range,
            ShapeError::TooFine { .. } => Code::TooBig,
        }
    }
}

/// A length that can be used as one.
fn length(what: &'static str, value: f64) -> Result<f64, ShapeError> {
    match value > 0.0 && value.is_finite() {
        true => Ok(value),
        false => Err(ShapeError::BadSize { what, value }),
    }
}

/// Lengths of the arrays of a shape's mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Counts {
    positions: u64,
    normals: u64,
    texcoords: u64,
    corners: u64,
    polygons: u64,
    triangles: u64,
}

impl Counts {
    /// Bytes of the arrays.
    fn bytes(self) -> u64 {
        let arrays = [
            (self.positions, size_of::<DVec3>()),
            (self.normals, size_of::<DVec3>()),
            (self.texcoords, size_of::<DVec2>()),
            (self.corners, size_of::<Corner>()),
            (self.polygons, size_of::<Polygon>()),
            // Each with the number of its polygon.
            (self.triangles, size_of::<[u32; 3]>() + size_of::<u32>()),
        ];
        let bytes = arrays.map(|(count, size)| count.saturating_mul(size as u64));
        bytes.into_iter().fold(0, u64::saturating_add)
    }

    /// A mesh without elements, whose arrays have room for all of them: they never move.
    fn empty_mesh(self) -> Mesh {
        Mesh {
            positions: Vec::with_capacity(self.positions as usize),
            normals: Vec::with_capacity(self.normals as usize),
            texcoords: Vec::with_capacity(self.texcoords as usize),
            corners: Vec::with_capacity(self.corners as usize),
            polygons: Vec::with_capacity(self.polygons as usize),
            triangles: Vec::with_capacity(self.triangles as usize),
            triangle_polygon: Vec::with_capacity(self.triangles as usize),
            ..Mesh::default()
        }
    }
}

/// A corner of a shape, which has everything but a colour.
fn corner(position: u32, texcoord: u32, normal: u32) -> Corner {
    Corner { position, normal, texcoord, color: NONE }
}

#[cfg(test)]
mod tests;

//! Generated meshes: X3D's solids, Newell's teapot, and the torus knot of the benchmarks.
//!
//! Out: meshes in object space, y up, right-handed, faces counter-clockwise seen from outside, with
//! exact normals and with texture coordinates ((0,0) at the lower left). Corners that meet share a
//! position, so that edges have no gaps. Equal arguments give equal bits on every machine (`libm`).
//!
//! Source of sizes, placement and texture coordinates of the solids: X3D (ISO/IEC 19775-1),
//! Geometry3D component.

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
use crate::error::{Code, Fault};
use glam::{DVec2, DVec3};
use std::fmt;

/// Largest number of triangles of a generated mesh.
pub const MAX_FACES: u64 = 4 << 20;

/// Error of generating a shape.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeError {
    /// A length is not positive and finite.
    BadSize {
        /// Name of the length.
        what: &'static str,
        /// Value of the length.
        value: f64,
    },
    /// Too few steps to bound a body.
    TooCoarse {
        /// Name of the count.
        what: &'static str,
        /// Value of the count.
        value: u32,
        /// Smallest valid count.
        least: u32,
    },
    /// More faces than [`MAX_FACES`].
    TooFine {
        /// Number of faces that the mesh would have.
        faces: u64,
    },
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ShapeError::BadSize { what, value } => {
                write!(f, "{what} must be positive and finite, not {value}")
            }
            ShapeError::TooCoarse { what, value, least } => {
                write!(f, "{what} must be at least {least}, not {value}")
            }
            ShapeError::TooFine { faces } => write!(f, "{faces} faces are over the limit of {MAX_FACES}"),
        }
    }
}

impl std::error::Error for ShapeError {}

impl ShapeError {
    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            ShapeError::BadSize { .. } | ShapeError::TooCoarse { .. } => Code::Range,
            ShapeError::TooFine { .. } => Code::TooBig,
        }
    }
}

impl From<ShapeError> for Fault {
    fn from(e: ShapeError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

/// Checks that a length is positive and finite.
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
    /// Returns the bytes of the arrays.
    fn bytes(self) -> u64 {
        let arrays = [
            (self.positions, size_of::<DVec3>()),
            (self.normals, size_of::<DVec3>()),
            (self.texcoords, size_of::<DVec2>()),
            (self.corners, size_of::<Corner>()),
            (self.polygons, size_of::<Polygon>()),
            // Each triangle with the number of its polygon.
            (self.triangles, size_of::<[u32; 3]>() + size_of::<u32>()),
        ];
        let bytes = arrays.map(|(count, size)| count.saturating_mul(size as u64));
        bytes.into_iter().fold(0, u64::saturating_add)
    }

    /// Returns an empty mesh whose arrays have the capacity for all elements: they never move.
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

/// Returns a corner of a shape: all attributes but a colour.
fn corner(position: u32, texcoord: u32, normal: u32) -> Corner {
    Corner { position, normal, texcoord, color: NONE }
}

#[cfg(test)]
mod tests;

//! Vertices with two f64 a number, for those that f64 places less exactly than a pixel needs.
//!
//! In: a transformed vertex. Out: its clip-space position, computed again from its object-space
//! position by the same matrices.

use super::vertex::{Transform, Vertex};
use crate::math::double_double::DoubleDouble;
use glam::{DMat4, DVec4};

/// A transformed vertex with two f64 a number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WideVertex {
    /// Clip-space position.
    pub clip: [DoubleDouble; 4],
    /// w - z in clip space.
    pub complement: DoubleDouble,
}

/// Returns the product of a matrix and a vector.
fn product(matrix: &DMat4, v: [DoubleDouble; 4]) -> [DoubleDouble; 4] {
    [0, 1, 2, 3].map(|row| dot(matrix.row(row), v))
}

fn dot(row: DVec4, v: [DoubleDouble; 4]) -> DoubleDouble {
    let [a, b, c, d] = row.to_array().map(DoubleDouble::from);
    a * v[0] + b * v[1] + (c * v[2] + d * v[3])
}

impl WideVertex {
    /// Transforms a vertex' object-space position again.
    pub fn of(t: &Transform, vertex: &Vertex) -> Self {
        let view = product(
            &t.camera.view,
            product(&t.model, vertex.position.extend(1.0).to_array().map(From::from)),
        );
        WideVertex {
            clip: product(&t.camera.projection, view),
            complement: dot(t.camera.one_minus_z_row, view),
        }
    }

    /// Returns a vertex' position in world space.
    pub fn world_of(t: &Transform, vertex: &Vertex) -> [DoubleDouble; 3] {
        let [x, y, z, _] = product(&t.model, vertex.position.extend(1.0).to_array().map(From::from));
        [x, y, z]
    }
}

//! Example shapes: regular polytopes of R^N, prisms over meshes, and demo scenes around them.
//!
//! Out: boundaries split into (N-1)-simplices that meet face to face, so that no ray slips between
//! them. Simplices of closed shapes have one winding: det(v_0, .., v_(N-1)) relative to an inner
//! point is positive.

mod demo_scene;
mod extrude;
mod regular;

pub use demo_scene::{DemoScene, PALETTE};
pub use extrude::{extrude, from_mesh};
pub use regular::{cell24, cross_polytope, cube, simplex};

use super::pose::sin_cos_deg;
use super::scene::Facet;
use std::fmt;

/// Error of creating a shape.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeError {
    /// A dimension in which the shape does not exist.
    Dimension {
        /// Name of the shape.
        shape: &'static str,
        /// Dimensions in which it exists.
        expected: &'static str,
        /// Requested dimension.
        found: usize,
    },
    /// A mesh without triangles.
    Empty,
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ShapeError::Dimension { shape, expected, found } => {
                write!(f, "a {shape} has {expected} dimensions, not {found}")
            }
            ShapeError::Empty => f.write_str("the mesh has no triangles"),
        }
    }
}

impl std::error::Error for ShapeError {}

/// A boundary in R^N as simplices over shared points.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Dimension N of the space.
    pub dim: usize,
    /// Points of N coordinates.
    pub points: Vec<Vec<f64>>,
    /// Simplices: N point indices each.
    pub simplices: Vec<Vec<u32>>,
    /// Index of the flat cell that each simplex is part of, from 0.
    pub cells: Vec<u32>,
}

impl Shape {
    /// Rotates the shape about 0 in the plane of two axes, from `a` towards `b`.
    ///
    /// # Panics
    /// Panics unless `a` and `b` are two different axes below the dimension.
    pub fn turned(mut self, a: usize, b: usize, angle_deg: f64) -> Self {
        assert!(a != b && a < self.dim && b < self.dim, "two axes below {}", self.dim);
        let (sin, cos) = sin_cos_deg(angle_deg);
        for p in &mut self.points {
            (p[a], p[b]) = (cos * p[a] - sin * p[b], sin * p[a] + cos * p[b]);
        }
        self
    }

    /// Scales about 0, then translates.
    ///
    /// # Panics
    /// Panics if `by` does not have N coordinates.
    pub fn placed(mut self, scale: f64, by: &[f64]) -> Self {
        assert_eq!(by.len(), self.dim, "a step of the space");
        for p in &mut self.points {
            p.iter_mut().zip(by).for_each(|(x, step)| *x = *x * scale + step);
        }
        self
    }

    /// Returns the distance of the farthest point from 0.
    pub fn radius(&self) -> f64 {
        self.points.iter().map(|p| p.iter().map(|x| x * x).sum::<f64>()).fold(0.0, f64::max).sqrt()
    }

    /// Returns the simplices as facets, one colour for each cell.
    pub fn facets(&self, color: impl Fn(u32) -> [f64; 3]) -> Vec<Facet> {
        let corner = |&i: &u32| self.points[i as usize].clone();
        let facet = |(simplex, &cell): (&Vec<u32>, &u32)| Facet {
            v: simplex.iter().map(corner).collect(),
            color: color(cell),
        };
        self.simplices.iter().zip(&self.cells).map(facet).collect()
    }
}

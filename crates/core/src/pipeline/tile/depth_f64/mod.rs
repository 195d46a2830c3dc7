//! Depth test of the formats in fixed point or reversed: depth is evaluated in f64, lane by lane.
//!
//! In: faces as [`super::setup`] made them, and each vertex's position and depth in f64: z/w, or
//! (w-z)/w free of cancellation for the reversed format. Out: the words that the format stores, at
//! each pixel from the face's own plane through its unsnapped corners, clamped to its corners'
//! depths:
//!
//! ```text
//! d(x, y) = da + (dx (x + 1/2 - xa) + dy (y + 1/2 - ya))     a = the corner that comes first by its position
//! word    = floor(scale d + 1/2)   or   not bits(f32(d))
//! ```

mod encoder;
mod plane;
mod vertices;

pub use encoder::DepthEncoder;
pub use vertices::{DepthVertex, DepthVertexKernel};

use super::depth_test::DepthTest;
use super::exact_faces::{self, ExactFace};
use crate::simd::Simd;
use plane::DepthPlane;

/// Depths in f64.
#[derive(Clone, Copy, Debug)]
pub(super) struct F64Depth<'a> {
    /// Encoder of the depth format.
    pub encoder: DepthEncoder,
    /// Vertex indices of each face with screen vertices.
    pub corners: &'a [[f32; 4]],
    /// Vertices with their depths in f64.
    pub vertices: &'a [DepthVertex],
}

/// Depth plane of an exact face, and the term that a row adds to its base.
#[derive(Clone, Copy, Debug)]
pub(super) struct F64Run {
    plane: DepthPlane,
    down: f64,
}

impl DepthTest for F64Depth<'_> {
    type Plane = DepthPlane;
    type Run = F64Run;

    const IS_COSTLY: bool = true;
    const STEEPEST: f64 = f64::INFINITY;

    #[inline(always)]
    fn flip(&self) -> i32 {
        self.encoder.flip()
    }

    #[inline(always)]
    fn fragment(&self, [at, _, face]: [i32; 3]) -> i32 {
        let plane = self.plane(face as u32, [0; 2], [0.0; 3]);
        self.word(&plane, at & 0xffff, at >> 16)
    }

    #[inline(always)]
    fn plane(&self, face: u32, _: [i32; 2], _: [f32; 3]) -> DepthPlane {
        let [a, b, c, _] = self.corners[face as usize];
        let at = |corner: f32| self.vertices[corner.to_bits() as usize];
        DepthPlane::through([at(a), at(b), at(c)])
    }

    #[inline(always)]
    fn word(&self, plane: &DepthPlane, x: i32, y: i32) -> i32 {
        self.encoder.word(plane.depth(x, plane.down(y)))
    }

    #[inline(always)]
    fn words<S: Simd>(&self, s: S, plane: &DepthPlane, x: i32, y: i32) -> S::I {
        self.encoder.words(s, &plane.row::<S>(x, plane.down(y)))
    }

    #[inline(always)]
    fn exact_words<S: Simd>(&self, s: S, face: &ExactFace, x: i32, y: i32) -> S::I {
        self.words(s, &DepthPlane::of_exact(face, &self.encoder), x, y)
    }

    #[inline(always)]
    fn clipped_words<S: Simd>(&self, s: S, face: &ExactFace, x: i32, y: i32) -> (S::I, S::M) {
        let z = exact_faces::depths(s, face, x, y);
        (self.exact_words(s, face, x, y), exact_faces::between_near_and_far(s, face, z, x, y))
    }

    #[inline(always)]
    fn slope(&self, face: &ExactFace) -> f64 {
        DepthPlane::of_exact(face, &self.encoder).slope()
    }

    #[inline(always)]
    fn run(&self, face: &ExactFace) -> F64Run {
        F64Run { plane: DepthPlane::of_exact(face, &self.encoder), down: 0.0 }
    }

    #[inline(always)]
    fn begin_run(&self, run: &mut F64Run, _: &ExactFace, _: i32, y: i32) {
        run.down = run.plane.down(y);
    }

    #[inline(always)]
    fn run_words<S: Simd>(&self, s: S, run: &F64Run, x: i32, _: S::F) -> S::I {
        self.encoder.words(s, &run.plane.row::<S>(x, run.down))
    }
}

#[cfg(test)]
mod tests;

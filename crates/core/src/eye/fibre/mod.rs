//! Search in a fibre: the nearest point of a facet that a pixel can see.
//!
//! The fibre of pixel P is the cone {x in span(P, hidden axes), x_0 > 0, |x_j| <= tan(alpha_j) x_0}
//! from the eye at 0.
//!
//! In: a facet, and a run of pixels along screen axis 1. Out: candidates, stored in [`Nearest`]
//! under the tie rule.
//!
//! Check: every face of the polytope tried in rational numbers (`tests/eye/exact.rs`).

mod cone;
mod fan;
mod nearest;
mod plane;
mod ray;
#[cfg(test)]
mod tests;

pub(super) use nearest::{Candidate, Nearest};

use super::eye_space::Visible;
use super::frame::Frame;
use super::method::Method;
use crate::math::nvec::signed_det;
use std::ops::Range;

/// Largest number of pixels of a tile.
pub(super) const TILE_PIXELS: usize = 64;

/// A run of pixels along screen axis 1.
pub(super) struct Run<const N: usize> {
    /// Direction of the pixels: d, c_1 (unused here), c_2, ..., c_M, zeros.
    pub direction: [f64; N],
    /// Range of pixels along axis 1.
    pub x: Range<u32>,
    /// Index in the tile of pixel `x.start`.
    pub local: usize,
}

/// Searches the fibres of a run of pixels for the nearest points of visible facet `index`.
#[inline]
pub(super) fn search<const N: usize>(frame: &Frame<N>, index: usize, run: &Run<N>, nearest: &mut Nearest<N>) {
    match frame.method {
        Method::Ray => ray::search(frame, index, run, nearest),
        Method::Plane => plane::search(frame, index, run, nearest),
        Method::Cone => cone::search(frame, index, run, nearest),
        Method::Fan(_) => fan::search(frame, index, run, nearest),
    }
}

/// Returns the squared distance of the eye from the facet's trace in the fibre, q = c^2 / |n_W|^2.
/// No point of the facet in the fibre is nearer, and of two equally near facets the one with the
/// larger q faces the eye more.
///
/// `along` is <n,P>.
#[inline(always)]
fn facing<const N: usize>(facet: &Visible<N>, along: f64, inverse_length2: f64) -> f64 {
    facet.offset * facet.offset / (along * along * inverse_length2 + facet.normal_hidden2)
}

/// Returns the determinant of f_a(v) = d v_a - c_a v_0, a = 1..=m, over the m vertices selected by
/// `among`, with a reliable sign.
///
/// Each f is rounded once and then taken as exact, and it is the same for all facets at the vertex:
/// the result is the exact incidence with a mesh whose vertices are moved by an ulp, so no ray
/// slips between facets.
#[cold]
fn sure_minor<const N: usize>(
    facet: &Visible<N>,
    direction: &[f64; N],
    m: usize,
    among: impl Fn(usize) -> bool,
) -> f64 {
    let mut rows = [[0.0; N]; N];
    for (row, k) in rows.iter_mut().zip((0..N).filter(|k| among(*k))) {
        let v = &facet.v[k];
        for a in 1..=m {
            row[a - 1] = direction[0] * v[a] - direction[a] * v[0];
        }
    }
    signed_det(&rows, m)
}

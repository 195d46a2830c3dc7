//! K >= 2: the fibre is a cone of K+1 dimensions, and the facet meets it in a polytope.
//!
//! In orthonormal coordinates (|P| s, h_1 .. h_K) of the fibre's span the problem is: least |x|^2
//! with b.x = 1 (the facet's hyperplane) and a_i.x >= 0 (the facet's N faces as seen from the eye,
//! and two sides of each aperture). All of the a_i pass through the eye, so the solution is found
//! by adding them one by one: if the nearest point satisfies the next constraint it stays;
//! otherwise the solution lies in that constraint's hyperplane, one dimension lower, under the
//! earlier ones.
//!
//! Source: R. Seidel, "Small-Dimensional Linear Programming and Convex Hulls Made Easy", 1991, for
//! a strictly convex objective.

use super::{Candidate, Nearest, Run, facing};
use crate::eye::eye_space::Visible;
use crate::eye::frame::Frame;
use crate::math::nvec::{MAX_DIM, add_scaled, dot, unit};

/// A side is violated if a.x is below this fraction of |x| (a being a unit vector of R^N): an angle
/// that rounding cannot distinguish from 0.
const VIOLATED: f64 = -1e-12;

/// Largest number of sides of a fibre's polytope: N faces and 2 K sides of apertures.
const MAX_SIDES: usize = MAX_DIM + 2 * (MAX_DIM - 2);

/// Searches the fibres of a run of pixels for the nearest points of polytopes.
pub(super) fn search<const N: usize>(frame: &Frame<N>, index: usize, run: &Run<N>, nearest: &mut Nearest<N>) {
    let facet = &frame.facets[index];
    for (step, x) in run.x.clone().enumerate() {
        let local = run.local + step;
        let mut direction = run.direction;
        direction[1] = frame.screen.centres[0][x as usize];
        let q = facing(facet, dot(&facet.normal, &direction), nearest.inverse_length2[local]);
        if q > nearest.limit2(local) {
            continue;
        }
        let length = (1.0 / nearest.inverse_length2[local]).sqrt();
        let ray = direction.map(|x| x / length);
        let reach = (facet.farthest * (1.0 + 1e-9)).powi(2).min(nearest.limit2(local));
        let Some(at) = nearest_in_fibre(frame, facet, frame.planes_of(index), &ray, reach) else { continue };
        let mut point = ray.map(|x| at[0] * x);
        for (axis, h) in open_axes(frame).zip(&at[1..]) {
            point[axis] = *h;
        }
        let distance2 = dot(&point, &point);
        nearest.offer(local, Candidate { distance2, facing: q, id: facet.id, index: index as u32, point });
    }
}

/// Returns the hidden axes whose aperture is not 0: along the others the fibre has no width.
fn open_axes<const N: usize>(frame: &Frame<N>) -> impl Iterator<Item = usize> {
    (frame.screen.dim() + 1..N).filter(|&axis| frame.screen.tan[axis] > 0.0)
}

/// Returns the nearest point within `reach2` (squared), in the coordinates (|P| s, open hidden
/// axes).
fn nearest_in_fibre<const N: usize>(
    frame: &Frame<N>,
    facet: &Visible<N>,
    planes: &[[f64; N]],
    ray: &[f64; N],
    reach2: f64,
) -> Option<[f64; N]> {
    let into_fibre = |functional: &[f64; N]| {
        let mut out = [0.0; N];
        out[0] = dot(functional, ray);
        for (slot, axis) in open_axes(frame).enumerate() {
            out[slot + 1] = functional[axis];
        }
        out
    };
    let mut sides = [[0.0; N]; MAX_SIDES];
    let mut count = 0;
    let mut add = |side: [f64; N]| {
        sides[count] = side;
        count += 1;
    };
    for (slot, axis) in open_axes(frame).enumerate() {
        for sign in [1.0, -1.0] {
            let mut side = [0.0; N];
            side[0] = frame.screen.tan[axis] * ray[0];
            side[slot + 1] = sign;
            add(unit(side));
        }
    }
    for plane in planes {
        add(into_fibre(plane));
    }
    let hyperplane = into_fibre(&facet.normal).map(|x| x / facet.offset);
    let at = least(&hyperplane, &sides[..count], reach2)?;
    (at[0] > 0.0).then_some(at)
}

/// Returns the shortest x with b.x = 1 and a.x >= 0 for all `sides`, or `None` if there is none
/// with |x|^2 <= `reach2`.
fn least<const N: usize>(b: &[f64; N], sides: &[[f64; N]], reach2: f64) -> Option<[f64; N]> {
    let b2 = dot(b, b);
    if !(b2 * reach2 >= 1.0 && b2 > 0.0) {
        return None; // the hyperplane is farther away than that, or does not meet the fibre
    }
    let mut x = b.map(|c| c / b2);
    for (i, side) in sides.iter().enumerate() {
        if dot(side, &x) >= VIOLATED * dot(&x, &x).sqrt() {
            continue;
        }
        let normal = unit(*side);
        let flat = |v: &[f64; N]| add_scaled(v, -dot(v, &normal), &normal);
        let mut before = [[0.0; N]; MAX_SIDES];
        for (out, side) in before.iter_mut().zip(&sides[..i]) {
            *out = flat(side);
        }
        x = least(&flat(b), &before[..i], reach2)?;
    }
    Some(x)
}

//! K = 1: the fibre is part of a plane, and the facet meets it in a segment.
//!
//! The segment's ends lie on faces of N-1 vertices, each of which meets the plane in a point: the
//! case K = 0 in the visible coordinates. In the plane x = s P + h e_hidden, |x|^2 = s^2 |P|^2 +
//! h^2: the segment A, B is clipped to s >= 0 and tan(alpha) d s -+ h >= 0, and the nearest point
//! is at u = clamp(-<A,B-A> / |B-A|^2, lo, hi). Closed form, no iteration.

use super::{Candidate, Nearest, Run, facing, sure_minor};
use crate::eye::eye_space::Visible;
use crate::eye::frame::Frame;
use crate::eye::method::{Method, pair_index};
use crate::math::nvec::{MAX_DIM, dot};

/// Number of vertex pairs of a facet in the largest dimension.
const MAX_PAIRS: usize = MAX_DIM * (MAX_DIM - 1) / 2;

/// Values of the aperture's border functions below this fraction of their terms count as 0.
const ON_BORDER: f64 = 1e-14;

/// Searches the fibres of a run of pixels in closed form.
pub(super) fn search<const N: usize>(frame: &Frame<N>, index: usize, run: &Run<N>, nearest: &mut Nearest<N>) {
    let pairs = const { Method::Plane.planes_per_facet(N) };
    let facet = &frame.facets[index];
    let planes = frame.planes_of(index);
    let hulls = frame.hulls_of(index);
    let mut direction = run.direction;
    direction[1] = 0.0;
    let (mut start, mut slope) = ([0.0; MAX_PAIRS], [0.0; MAX_PAIRS]);
    for k in 0..pairs {
        start[k] = dot(&planes[k], &direction);
        slope[k] = planes[k][1];
    }
    let along = dot(&facet.normal, &direction);
    let tan = frame.screen.tan[N - 1] * direction[0];
    for (step, x) in run.x.clone().enumerate() {
        let local = run.local + step;
        let c = frame.screen.centres[0][x as usize];
        let inverse_length2 = nearest.inverse_length2[local];
        let q = facing(facet, along + facet.normal[1] * c, inverse_length2);
        if q > nearest.limit2(local) {
            continue;
        }
        let mut minors = [0.0; MAX_PAIRS];
        let (mut least, mut inner) = (f64::INFINITY, f64::INFINITY);
        for k in 0..pairs {
            minors[k] = start[k] + slope[k] * c;
            least = least.min(minors[k].abs());
            inner = inner.min(minors[k] * hulls[k]);
        }
        if inner < -facet.doubt {
            continue; // outside the facet's outline
        }
        direction[1] = c;
        if least <= facet.doubt {
            for i in 0..N {
                for j in i + 1..N {
                    minors[pair_index(N, i, j)] = sure_minor(facet, &direction, N - 2, |k| k != i && k != j);
                }
            }
        }
        let Some((a, b)) = segment::<N>(facet, &minors, direction[0]) else { continue };
        let Some((s, h)) = nearest_of_segment(a, b, tan, inverse_length2) else { continue };
        let mut point = direction.map(|x| s * x);
        point[N - 1] = h;
        let distance2 = dot(&point, &point);
        nearest.offer(local, Candidate { distance2, facing: q, id: facet.id, index: index as u32, point });
    }
}

/// Returns, for each face of a simplex of n vertices (the one without vertex i), a mask of the
/// minors that are its barycentrics, and a mask of those with a minus sign.
const fn faces(n: usize) -> [[u32; 2]; MAX_DIM] {
    let mut faces = [[0; 2]; MAX_DIM];
    let mut i = 0;
    while i < n {
        let mut j = 0;
        while j < n {
            if j != i {
                let bit = 1 << pair_index(n, i, j);
                faces[i][0] |= bit;
                if (j - (j > i) as usize) % 2 == 1 {
                    faces[i][1] |= bit;
                }
            }
            j += 1;
        }
        i += 1;
    }
    faces
}

/// Returns the ends (s, h) of the facet's segment in the plane, from the minors of its vertex
/// pairs.
#[inline(always)]
fn segment<const N: usize>(
    facet: &Visible<N>,
    minors: &[f64; MAX_PAIRS],
    d: f64,
) -> Option<([f64; 2], [f64; 2])> {
    let pairs = const { Method::Plane.planes_per_facet(N) };
    let faces = const { faces(N) };
    let (mut negative, mut zero) = (0u32, 0u32);
    for k in 0..pairs {
        negative |= u32::from(minors[k] < 0.0) << k;
        zero |= u32::from(minors[k] == 0.0) << k;
    }
    // Ends as (depth, hidden, sum of weights), not yet divided.
    let mut ends = [[0.0; 3]; 2];
    let mut count = 0;
    for i in 0..N {
        let [mask, flip] = faces[i];
        // Met if the nonzero barycentrics have one sign. If all are 0 the face lies entirely in the
        // plane, and its own faces give the ends.
        let counted = mask & !zero;
        let signs = (negative ^ flip) & counted;
        if counted == 0 || (signs != 0 && signs != counted) {
            continue;
        }
        let mut end = [0.0; 3];
        for j in (0..N).filter(|&j| j != i) {
            let weight = minors[pair_index(N, i, j)].abs();
            end[0] += weight * facet.v[j][0];
            end[1] += weight * facet.v[j][N - 1];
            end[2] += weight;
        }
        match count {
            0 => ends = [end, end],
            1 => ends[1] = end,
            _ => {
                // More than two faces meet at an end of the segment: the farthest from the first is
                // taken.
                let part = |e: [f64; 3]| [e[0] / e[2], e[1] / e[2]];
                let span = |e: [f64; 3]| {
                    (part(e)[0] - part(ends[0])[0]).abs() + (part(e)[1] - part(ends[0])[1]).abs()
                };
                if span(end) > span(ends[1]) {
                    ends[1] = end;
                }
            }
        }
        count += 1;
    }
    if count == 0 {
        return None;
    }
    // One division for all four, unless the product of the sums leaves the range in which it is
    // accurate enough.
    let [a, b] = ends;
    let product = a[2] * b[2] * d;
    if !(1e-280..1e280).contains(&product) {
        let point = |e: [f64; 3]| [e[0] / (e[2] * d), e[1] / e[2]];
        return Some((point(a), point(b)));
    }
    let inverse = 1.0 / product;
    let (scale_a, scale_b) = (b[2] * inverse, a[2] * inverse);
    Some(([a[0] * scale_a, a[1] * scale_a * d], [b[0] * scale_b, b[1] * scale_b * d]))
}

/// Returns the point (s, h) of the segment a..b, clipped to the aperture, that is nearest to the
/// eye; `tan` is tan(alpha) d.
#[inline(always)]
fn nearest_of_segment(a: [f64; 2], b: [f64; 2], tan: f64, inverse_length2: f64) -> Option<(f64, f64)> {
    let (mut lo, mut hi) = (0.0f64, 1.0f64);
    let border = |p: [f64; 2], side: f64| {
        let g = tan * p[0] - side * p[1];
        if g.abs() <= ON_BORDER * (tan * p[0].abs() + p[1].abs()) { 0.0 } else { g }
    };
    for (at_a, at_b) in [(a[0], b[0]), (border(a, 1.0), border(b, 1.0)), (border(a, -1.0), border(b, -1.0))] {
        if at_a < 0.0 && at_b < 0.0 {
            return None;
        }
        if at_a < 0.0 {
            lo = lo.max(at_a / (at_a - at_b));
        }
        if at_b < 0.0 {
            hi = hi.min(at_a / (at_a - at_b));
        }
    }
    if lo > hi {
        return None;
    }
    let (ds, dh) = (b[0] - a[0], b[1] - a[1]);
    // Scaled by 1 / |P|^2: the metric is s s' + h h' / |P|^2.
    let along = a[0] * ds + a[1] * dh * inverse_length2;
    let length2 = ds * ds + dh * dh * inverse_length2;
    let u = if length2 > 0.0 { (-along / length2).clamp(lo, hi) } else { lo };
    Some((a[0] + u * ds, a[1] + u * dh))
}

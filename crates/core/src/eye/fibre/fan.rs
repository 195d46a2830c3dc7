//! The fan: m rays along each hidden axis of the fibre, each intersected with the facet in R^N. A
//! check and a preview of the exact methods: every hit is a point of the facet in the fibre, so the
//! fan is never nearer than exact; its error falls with 1/m.

use super::{Candidate, Nearest, Run, facing};
use crate::eye::frame::Frame;
use crate::math::nvec::dot;

/// Searches the fibres of a run of pixels by a fan of rays.
pub(super) fn search<const N: usize>(frame: &Frame<N>, index: usize, run: &Run<N>, nearest: &mut Nearest<N>) {
    let facet = &frame.facets[index];
    let planes = frame.planes_of(index);
    for (step, x) in run.x.clone().enumerate() {
        let local = run.local + step;
        let mut pixel = run.direction;
        pixel[1] = frame.screen.centres[0][x as usize];
        let q = facing(facet, dot(&facet.normal, &pixel), nearest.inverse_length2[local]);
        if q > nearest.limit2(local) {
            continue;
        }
        let start: [f64; N] = std::array::from_fn(|i| dot(&planes[i], &pixel));
        let mut best: Option<(f64, [f64; N])> = None;
        for ray in &frame.fan {
            let lambda: [f64; N] = std::array::from_fn(|i| start[i] + dot(&planes[i], ray));
            let least = lambda.iter().fold(f64::INFINITY, |m, l| m.min(*l));
            let most = lambda.iter().fold(f64::NEG_INFINITY, |m, l| m.max(*l));
            if least < -facet.doubt && most > facet.doubt {
                continue;
            }
            let (mut sum, mut depth) = (0.0, 0.0);
            for i in 0..N {
                sum += lambda[i];
                depth += lambda[i] * facet.v[i][0];
            }
            let t = depth / (sum * pixel[0]);
            // A sum that may consist of rounding errors alone means a ray in the hyperplane.
            if t > 0.0 && sum.abs() > N as f64 * facet.doubt {
                let point: [f64; N] = std::array::from_fn(|a| t * (pixel[a] + ray[a]));
                let distance2 = dot(&point, &point);
                if best.is_none_or(|(d2, _)| distance2 < d2) {
                    best = Some((distance2, point));
                }
            }
        }
        if let Some((distance2, point)) = best {
            nearest
                .offer(local, Candidate { distance2, facing: q, id: facet.id, index: index as u32, point });
        }
    }
}

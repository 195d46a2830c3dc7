//! K = 0: the fibre is a ray.
//!
//! lambda_i is proportional to det(P, vertices but i). If all have one sign (zeros allowed) it is a
//! hit, with t = sum(lambda x_0) / d > 0. Each functional belongs to a ridge. Where rounding could
//! change its sign, the minor of f decides instead.
//!
//! Source of the idea: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", 2013,
//! here in any N.

use super::{Candidate, Nearest, Run, sure_minor};
use crate::eye::frame::Frame;
use crate::math::nvec::dot;

/// Searches the rays of a run of pixels.
pub(super) fn search<const N: usize>(frame: &Frame<N>, index: usize, run: &Run<N>, nearest: &mut Nearest<N>) {
    let facet = &frame.facets[index];
    let planes = frame.planes_of(index);
    let mut direction = run.direction;
    direction[1] = 0.0;
    let start: [f64; N] = std::array::from_fn(|i| dot(&planes[i], &direction));
    let slope: [f64; N] = std::array::from_fn(|i| planes[i][1]);
    for (step, x) in run.x.clone().enumerate() {
        let c = frame.screen.centres[0][x as usize];
        let mut lambda: [f64; N] = std::array::from_fn(|i| start[i] + slope[i] * c);
        let smallest = lambda.iter().fold(f64::INFINITY, |m, l| m.min(l.abs()));
        direction[1] = c;
        if smallest <= facet.doubt {
            lambda = std::array::from_fn(|i| {
                let minor = sure_minor(facet, &direction, N - 1, |k| k != i);
                if i % 2 == 0 { minor } else { -minor }
            });
        }
        if lambda.iter().any(|&l| l > 0.0) == lambda.iter().any(|&l| l < 0.0) {
            continue; // both signs, or only zeros: the ray lies in the facet's hyperplane
        }
        let (mut sum, mut depth) = (0.0, 0.0);
        for i in 0..N {
            sum += lambda[i];
            depth += lambda[i] * facet.v[i][0];
        }
        let t = depth / (sum * direction[0]);
        if t > 0.0 {
            let point = direction.map(|x| t * x);
            let local = run.local + step;
            let distance2 = dot(&point, &point);
            nearest
                .offer(local, Candidate { distance2, facing: 0.0, id: facet.id, index: index as u32, point });
        }
    }
}

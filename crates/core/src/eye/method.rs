//! Methods to find the nearest point of a facet in a pixel's fibre, and the functionals that each
//! needs.
//!
//! With K = N-1-M hidden axes: for K = 0 a ray, for K = 1 a closed form in the plane of the fibre,
//! for K >= 2 the nearest point of a polytope; or, as a check and a preview, a fan of rays.

use super::eye_space::{Screen, Visible};
use crate::math::nvec::{dot, max_abs, sub, unit, wedge};

/// Search method requested by the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fibre {
    /// The exact nearest point.
    #[default]
    Exact,
    /// A fan of this many rays along each hidden axis, including the ends of the aperture. Its
    /// distance is never below the exact one.
    Fan(u32),
}

/// Largest number of rays of a fan in one fibre.
pub const MAX_FAN_RAYS: u64 = 1 << 16;

/// Search method for the scene's K.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// K = 0.
    Ray,
    /// K = 1.
    Plane,
    /// K >= 2.
    Cone,
    /// Sampled, with this many rays along each hidden axis.
    Fan(u32),
}

/// Returns the index of the pair i < j among the pairs of 0..n.
#[inline(always)]
pub(super) const fn pair_index(n: usize, i: usize, j: usize) -> usize {
    let (i, j) = if i < j { (i, j) } else { (j, i) };
    i * (2 * n - i - 1) / 2 + j - i - 1
}

impl Method {
    /// Returns the method for a space of n dimensions and a screen of m.
    pub fn new(n: usize, m: usize, fibre: Fibre) -> Self {
        match (n - 1 - m, fibre) {
            (0, _) => Method::Ray,
            (_, Fibre::Fan(rays)) => Method::Fan(rays),
            (1, Fibre::Exact) => Method::Plane,
            (_, Fibre::Exact) => Method::Cone,
        }
    }

    /// Returns the number of functionals of a facet of R^n.
    #[inline(always)]
    pub const fn planes_per_facet(self, n: usize) -> usize {
        if matches!(self, Method::Plane) { n * (n - 1) / 2 } else { n }
    }

    /// Returns the hidden coordinates of the fan's rays on the screen; empty for other methods.
    pub fn fan_rays<const N: usize>(self, screen: &Screen<N>) -> Vec<[f64; N]> {
        let Method::Fan(count) = self else { return Vec::new() };
        let mut rays = vec![[0.0; N]];
        for axis in screen.dim() + 1..N {
            rays = (0..count)
                .flat_map(|i| {
                    let part = match count {
                        1 => 0.0,
                        _ => (2.0 * f64::from(i) - f64::from(count - 1)) / f64::from(count - 1),
                    };
                    let h = screen.tan[axis] * screen.distance * part;
                    rays.iter().map(move |ray| {
                        let mut ray = *ray;
                        ray[axis] = h;
                        ray
                    })
                })
                .collect();
        }
        rays
    }

    /// Appends the functionals of a facet to `planes`, and to `hulls` the sign of each on the
    /// facet: 1, -1, or 0 where it takes both.
    ///
    /// Ray and fan: functional i is (-1)^i det(x, vertices but i). At the direction P all have one
    /// sign if P meets the facet, and they are proportional to its barycentrics there. Plane:
    /// functional (i,j) is det(x, vertices but i and j) in the visible coordinates alone. Cone:
    /// those of the ray as unit vectors, positive on the inner side.
    pub fn push_planes<const N: usize>(
        self,
        facet: &Visible<N>,
        m: usize,
        planes: &mut Vec<[f64; N]>,
        hulls: &mut Vec<f64>,
    ) {
        match self {
            Method::Plane => {
                for i in 0..N {
                    for j in i + 1..N {
                        let (plane, base) = through(&facet.v, |k| k != i && k != j, m + 1);
                        let sides = [i, j].map(|k| dot(&plane, &sub(&facet.v[k], base)));
                        // Within rounding the sign is undecided.
                        let sure = 1e-9 * max_abs(&plane) * facet.farthest;
                        let hull = f64::from(u8::from(sides.iter().all(|&s| s > sure)))
                            - f64::from(u8::from(sides.iter().all(|&s| s < -sure)));
                        planes.push(plane);
                        hulls.push(hull);
                    }
                }
            }
            Method::Ray | Method::Fan(_) | Method::Cone => {
                for i in 0..N {
                    let (plane, base) = through(&facet.v, |k| k != i, N);
                    // Vertex i lies on the inner side. Its height over the others decides, computed
                    // from differences.
                    let inner = if dot(&plane, &sub(&facet.v[i], base)) < 0.0 { -1.0 } else { 1.0 };
                    let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
                    if self == Method::Cone {
                        planes.push(unit(plane).map(|x| inner * x));
                        hulls.push(1.0);
                    } else {
                        planes.push(plane.map(|x| sign * x));
                        hulls.push(sign * inner);
                    }
                }
            }
        }
    }
}

/// Returns det(x, the vertices selected by `among`) on the first `len` coordinates, computed from
/// differences to the first of these vertices, which is returned too.
#[inline(always)]
fn through<const N: usize>(
    v: &[[f64; N]; N],
    among: impl Fn(usize) -> bool,
    len: usize,
) -> ([f64; N], &[f64; N]) {
    let mut rows = [[0.0; N]; N];
    let mut base = &v[0];
    let mut count = 0;
    for k in (0..N).filter(|&k| among(k)) {
        if count == 0 {
            base = &v[k];
            rows[0] = *base;
        } else {
            rows[count] = sub(&v[k], base);
        }
        count += 1;
    }
    (wedge(&rows[..count], len), base)
}

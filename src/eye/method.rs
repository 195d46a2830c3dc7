//! How the nearest point of a facet in a pixel's fibre is found, and the functionals that each way needs.
//!
//! With K = N-1-M hidden axes: K = 0 a ray, K = 1 a closed form in the plane of the fibre, K >= 2 the nearest point of a
//! polytope; or, as a check and a preview, a fan of rays.

use super::frame::{Screen, Visible};
use crate::math::nvec::{dot, max_abs, sub, unit, wedge};

/// What the caller asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fibre {
    /// The exact nearest point.
    #[default]
    Exact,
    /// A fan of this many rays along each hidden axis, the ends of the aperture included: never nearer than exact.
    Fan(u32),
}

/// The most rays of a fan in one fibre.
pub const MAX_FAN_RAYS: u64 = 1 << 16;

/// What is done for the K at hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// K = 0.
    Ray,
    /// K = 1.
    Plane,
    /// K >= 2.
    Cone,
    /// Sampled, this many rays along each hidden axis.
    Fan(u32),
}

/// The place of the pair i < j among the pairs of 0..n.
#[inline(always)]
pub(super) const fn pair_index(n: usize, i: usize, j: usize) -> usize {
    let (i, j) = if i < j { (i, j) } else { (j, i) };
    i * (2 * n - i - 1) / 2 + j - i - 1
}

impl Method {
    pub fn new(n: usize, m: usize, fibre: Fibre) -> Self {
        match (n - 1 - m, fibre) {
            (0, _) => Method::Ray,
            (_, Fibre::Fan(rays)) => Method::Fan(rays),
            (1, Fibre::Exact) => Method::Plane,
            (_, Fibre::Exact) => Method::Cone,
        }
    }

    /// How many functionals a facet of R^n has.
    #[inline(always)]
    pub const fn planes_per_facet(self, n: usize) -> usize {
        if matches!(self, Method::Plane) { n * (n - 1) / 2 } else { n }
    }

    /// The hidden coordinates of the fan's rays on the screen.
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

    /// Appends the functionals of a facet, and the sign that each has on the facet: 1 or -1, or 0 where it has both.
    ///
    /// Ray and fan: functional i is (-1)^i det(x, vertices but i): at the direction P all have one sign when P meets the facet,
    /// and they are its barycentrics there but for a factor. Plane: functional (i,j) is det(x, vertices but i and j) in
    /// the visible coordinates alone. Cone: those of the ray as unit vectors with inner sides positive.
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
                        // A side within rounding is none.
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
                    // Vertex i lies on the inner side. Its height over the others decides, summed from differences.
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

/// det(x, the vertices that `among` picks) on the first `len` coordinates, through differences from the first of them, which is
/// given too.
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

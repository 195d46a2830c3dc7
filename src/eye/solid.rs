//! A facet as an obstacle to light.
//!
//! In: points in eye space. Out: whether the facet stands between a point and a light.
//! One rule, without ids: facet g blocks iff h_p = n.p - c and h_L have strictly opposite signs, both over tau in size, and the
//! crossing p + s (p_L - p), s = h_p / (h_p - h_L), lies in the closed simplex. What is within tau of g's hyperplane cannot be
//! blocked by g: no acne, no self-shadow, and coincident or adjacent facets do not shadow each other.

use super::lights::{FrameLight, LightPlace};
use crate::math::nvec::{add_scaled, dot, max_abs, sub, unit, wedge};

/// tau over the largest coordinate of the point and the facet.
pub(super) const TAU: f64 = 1e-10;

/// How far outside the simplex still counts as inside, over the same: what rounding cannot tell.
const CLOSED: f64 = 1e-12;

/// How a light stands to a facet's hyperplane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stand {
    /// Radial: n.p_L - c. Parallel: n.u, u along the light.
    pub height: f64,
    /// The side that the light is on: 1, -1, or 0 in the hyperplane (or along it). For a light plane: of its direction.
    pub side: i8,
}

/// A facet that is not degenerate.
pub(super) struct Solid<const N: usize> {
    /// Unit normal.
    pub normal: [f64; N],
    /// n.x on the facet.
    pub offset: f64,
    /// The largest absolute coordinate.
    pub size: f64,
    /// The box around it.
    pub low: [f64; N],
    /// The box around it.
    pub high: [f64; N],
    /// Inside its hyperplane: entry i is the unit normal of the ridge opposite vertex i, towards it ...
    ridges: [[f64; N]; N],
    /// ... and its value on the ridge.
    ridge_offsets: [f64; N],
    /// Each light's stand.
    pub stands: Vec<Stand>,
}

impl<const N: usize> Solid<N> {
    pub fn new(v: &[[f64; N]; N], normal: [f64; N], offset: f64, lights: &[FrameLight<N>]) -> Self {
        let size = v.iter().map(max_abs).fold(0.0, f64::max);
        let mut ridges = [[0.0; N]; N];
        let mut ridge_offsets = [0.0; N];
        for i in 0..N {
            let base = &v[usize::from(i == 0)];
            // Perpendicular to the normal and to the ridge's edges.
            let mut rows = [normal; N];
            let mut count = 1;
            for (k, point) in v.iter().enumerate() {
                if k != i && k != usize::from(i == 0) {
                    rows[count] = sub(point, base);
                    count += 1;
                }
            }
            let mut ridge = unit(wedge(&rows[..N - 1], N));
            if dot(&ridge, &sub(&v[i], base)) < 0.0 {
                ridge = ridge.map(|x| -x);
            }
            ridges[i] = ridge;
            ridge_offsets[i] = dot(&ridge, base);
        }
        let stands = lights
            .iter()
            .map(|light| {
                let (height, zero) = match &light.place {
                    LightPlace::Radial { position } => (dot(&normal, position) - offset, TAU * size),
                    LightPlace::Sun { direction } | LightPlace::Plane { direction, .. } => {
                        (dot(&normal, direction), TAU)
                    }
                };
                let sign = if height.abs() <= zero { 0 } else { height.signum() as i8 };
                // The sun stands where its light comes from.
                Stand {
                    height,
                    side: if matches!(light.place, LightPlace::Sun { .. }) { -sign } else { sign },
                }
            })
            .collect();
        let corner = |pick: fn(f64, f64) -> f64| {
            std::array::from_fn(|a| v[1..].iter().fold(v[0][a], |m, p| pick(m, p[a])))
        };
        Solid {
            normal,
            offset,
            size,
            low: corner(f64::min),
            high: corner(f64::max),
            ridges,
            ridge_offsets,
            stands,
        }
    }

    /// Whether the facet stands between `p` (largest coordinate `p_size`) and the light at `target`.
    #[inline]
    pub fn blocks(&self, p: &[f64; N], p_size: f64, target: &Target<N>) -> bool {
        let scale = self.size.max(p_size);
        let tau = TAU * scale;
        let height = dot(&self.normal, p) - self.offset;
        if height.abs() <= tau {
            return false;
        }
        let crossing = match target {
            Target::Point { position, light } => {
                let other = match light {
                    Some(light) => self.stands[*light].height,
                    None => dot(&self.normal, position) - self.offset,
                };
                if other.abs() <= tau || (other > 0.0) == (height > 0.0) {
                    return false;
                }
                add_scaled(p, height / (height - other), &sub(position, p))
            }
            Target::Sun { direction, light } => {
                let fall = self.stands[*light].height;
                // Against the light, n.x changes by -fall a unit of length.
                if fall.abs() <= TAU || (fall > 0.0) != (height > 0.0) {
                    return false;
                }
                add_scaled(p, -height / fall, direction)
            }
        };
        self.ridges
            .iter()
            .zip(&self.ridge_offsets)
            .all(|(ridge, offset)| dot(ridge, &crossing) - offset >= -CLOSED * scale)
    }
}

/// Where the light is, seen from one point.
pub(super) enum Target<const N: usize> {
    /// At a place; `light` when its stand to every facet is known.
    Point {
        /// Its place.
        position: [f64; N],
        /// Its index, for a radial light.
        light: Option<usize>,
    },
    /// At infinity.
    Sun {
        /// Unit vector along the light.
        direction: [f64; N],
        /// Its index.
        light: usize,
    },
}

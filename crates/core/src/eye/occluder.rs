//! A facet as an obstacle to light.
//!
//! In: points in eye space. Out: whether the facet stands between a point and a light.
//!
//! There is one rule, without facet ids: facet g blocks iff h_p = n.p - c and h_L have strictly
//! opposite signs, both larger than tau in magnitude, and the crossing p + s (p_L - p), s = h_p /
//! (h_p - h_L), lies in the closed simplex. A point within tau of g's hyperplane cannot be blocked
//! by g: no acne, no self-shadow, and coincident or adjacent facets do not shadow each other.

use super::frame_light::{FrameLight, LightPlace};
use crate::math::nvec::{add_scaled, dot, max_abs, sub, unit, wedge};

/// tau divided by the largest coordinate of the point and the facet: the one tolerance for an eye, a
/// light or a point in a facet's hyperplane.
pub(super) const TAU: f64 = 1e-10;

/// Distance outside the simplex that still counts as inside, relative to the same coordinate: the
/// bound of rounding.
const CLOSED: f64 = 1e-12;

/// Position of a light relative to a facet's hyperplane.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightPlacement {
    /// Radial: n.p_L - c. Parallel: n.u, with u along the light.
    pub height: f64,
    /// Side of the facet that the light is on: 1, -1, or 0 in the hyperplane (or along it). For a
    /// light plane: the side of its direction.
    pub side: i8,
}

/// A facet that is not degenerate, as an obstacle to light.
pub(super) struct Occluder<const N: usize> {
    /// Unit normal.
    pub normal: [f64; N],
    /// n.x on the facet.
    pub offset: f64,
    /// Largest absolute coordinate of a vertex.
    pub size: f64,
    /// Lower corner of the bounding box.
    pub low: [f64; N],
    /// Upper corner of the bounding box.
    pub high: [f64; N],
    /// Entry i is the unit vector, in the facet's hyperplane, normal to the ridge opposite vertex i
    /// and pointing to it.
    ridges: [[f64; N]; N],
    /// Value of ridge normal i on its ridge.
    ridge_offsets: [f64; N],
}

impl<const N: usize> Occluder<N> {
    /// Creates the occluder of the facet with vertices `v` in the hyperplane `normal`.x = `offset`.
    pub fn new(v: &[[f64; N]; N], normal: [f64; N], offset: f64) -> Self {
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
        let corner = |pick: fn(f64, f64) -> f64| {
            std::array::from_fn(|a| v[1..].iter().fold(v[0][a], |m, p| pick(m, p[a])))
        };
        Occluder {
            normal,
            offset,
            size,
            low: corner(f64::min),
            high: corner(f64::max),
            ridges,
            ridge_offsets,
        }
    }

    /// Returns the placement of a light to the facet.
    pub fn placement(&self, light: &FrameLight<N>) -> LightPlacement {
        let (height, zero) = match &light.place {
            LightPlace::Radial { position } => (dot(&self.normal, position) - self.offset, TAU * self.size),
            LightPlace::Sun { direction } | LightPlace::Plane { direction, .. } => {
                (dot(&self.normal, direction), TAU)
            }
        };
        let sign = if height.abs() <= zero { 0 } else { height.signum() as i8 };
        // A sun is on the side that its light comes from.
        LightPlacement {
            height,
            side: if matches!(light.place, LightPlace::Sun { .. }) { -sign } else { sign },
        }
    }

    /// Returns whether the facet stands between `p` (largest coordinate `p_size`) and the light at
    /// `target`, whose position relative to the facet is `placement`.
    #[inline]
    pub fn blocks(
        &self,
        p: &[f64; N],
        p_size: f64,
        target: &LightTarget<N>,
        placement: &LightPlacement,
    ) -> bool {
        let scale = self.size.max(p_size);
        let tau = TAU * scale;
        let height = dot(&self.normal, p) - self.offset;
        if height.abs() <= tau {
            return false;
        }
        let crossing = match target {
            LightTarget::Sun { direction } => {
                let fall = placement.height;
                // Against the light, n.x changes by -fall for each unit of length.
                if fall.abs() <= TAU || (fall > 0.0) != (height > 0.0) {
                    return false;
                }
                add_scaled(p, -height / fall, direction)
            }
            LightTarget::Radial { position } | LightTarget::Foot { position } => {
                let other = match target {
                    LightTarget::Radial { .. } => placement.height,
                    _ => dot(&self.normal, position) - self.offset,
                };
                if other.abs() <= tau || (other > 0.0) == (height > 0.0) {
                    return false;
                }
                add_scaled(p, height / (height - other), &sub(position, p))
            }
        };
        self.ridges
            .iter()
            .zip(&self.ridge_offsets)
            .all(|(ridge, offset)| dot(ridge, &crossing) - offset >= -CLOSED * scale)
    }

    /// Returns whether the facet may stand between any point of the box `middle` +- `half` and the
    /// light; never false if one is blocked.
    ///
    /// The crossing's height over ridge i is, up to a positive factor, a linear function of p: with
    /// h = n.p - c and a point light, |h_L| (w_i.p - o_i) - sign(h_L) (w_i.p_L - o_i) h; with the
    /// sun along u and f = n.u, |f| (w_i.p - o_i) - sign(f) (w_i.u) h.
    pub fn may_block(
        &self,
        middle: &[f64; N],
        half: &[f64; N],
        target: &LightTarget<N>,
        placement: &LightPlacement,
    ) -> bool {
        let at = dot(&self.normal, middle) - self.offset;
        let reach = (0..N).fold(0.0, |sum, a| sum + self.normal[a].abs() * half[a]);
        // The sign that h must have somewhere in the box, and the bound below which the light's
        // height counts as 0.
        let (sign, zero) = match target {
            LightTarget::Sun { .. } => (placement.height.signum(), TAU),
            LightTarget::Radial { .. } => (-placement.height.signum(), TAU * self.size),
            LightTarget::Foot { .. } => return true,
        };
        if placement.height.abs() <= zero || sign * at + reach <= 0.9 * TAU * self.size {
            return false;
        }
        let scale = self.size + max_abs(middle) + max_abs(half);
        self.ridges.iter().zip(&self.ridge_offsets).all(|(ridge, offset)| {
            let of_light = match target {
                LightTarget::Sun { direction } => dot(ridge, direction),
                LightTarget::Radial { position } | LightTarget::Foot { position } => {
                    dot(ridge, position) - offset
                }
            };
            // In both cases the factor of the light's value has the sign opposite to
            // `placement.height`.
            let (own, other) = (placement.height.abs(), -placement.height.signum() * of_light);
            let value = own * (dot(ridge, middle) - offset) + other * at;
            let spread =
                (0..N).fold(0.0, |sum, a| sum + (own * ridge[a] + other * self.normal[a]).abs() * half[a]);
            let margin = 1e-10 * scale * (own + other.abs() + at.abs() + reach);
            value + spread >= -margin
        })
    }
}

/// Position of a light, as seen from one point.
#[derive(Clone, Copy)]
pub(super) enum LightTarget<const N: usize> {
    /// At infinity; its light travels along this unit vector.
    Sun { direction: [f64; N] },
    /// A position, the same for all points.
    Radial { position: [f64; N] },
    /// A position that belongs to one point: its foot on a light plane.
    Foot { position: [f64; N] },
}

#[cfg(test)]
mod tests;

//! Lighting: the lights that reach a point, and its colour.
//!
//! In: a point of a facet, in eye space, and its distance from the eye. Out: a lit flag for each
//! light, and the colour clamp(I_t I_R base, 0, 255) with I_t = min(1, I_d + sum of I_l(D_l)
//! colour_l over the lit), channel by channel.
//!
//! Source: sections 2.1.1 to 2.2 and equations 1 to 5; tinting and several lights complete its
//! section 6. There is no factor for the light's angle of incidence: the source has none.

use super::frame_light::{FrameLight, LightPlace};
use super::occluder::{LightPlacement, LightTarget, Occluder, TAU};
use crate::math::nvec::{add_scaled, dot, sub};

impl<const N: usize> FrameLight<N> {
    /// Returns the light's distance from point `p` of `occluder` and the target of the shadow test,
    /// or `None` if the light does not reach the side of the facet that is seen. `placement` is the
    /// light's position relative to `occluder`; `eye_side` (1 or -1) is the side of the facet on
    /// which the eye is.
    #[inline]
    pub fn reach(
        &self,
        placement: &LightPlacement,
        occluder: &Occluder<N>,
        eye_side: i8,
        p: &[f64; N],
    ) -> Option<(f64, LightTarget<N>)> {
        match &self.place {
            LightPlace::Sun { direction } => {
                (placement.side == eye_side).then_some((0.0, LightTarget::Sun { direction: *direction }))
            }
            LightPlace::Radial { position } => (placement.side == eye_side).then(|| {
                let to_light = sub(position, p);
                (dot(&to_light, &to_light).sqrt(), LightTarget::Radial { position: *position })
            }),
            LightPlace::Plane { direction, offset } => {
                // p_L = p - h u is the foot of the perpendicular on the plane: it lies on side
                // -sign(h) sign(n.u) of the facet.
                let h = dot(direction, p) - offset;
                let height = -h * placement.height;
                let is_seen = placement.side != 0
                    && height.abs() > TAU * occluder.size
                    && (height > 0.0) == (eye_side > 0);
                is_seen.then(|| (h.abs(), LightTarget::Foot { position: add_scaled(p, -h, direction) }))
            }
        }
    }
}

/// Returns the colour of a facet of colour `base` under total light `total`, with the eye's own
/// loss `view` (0..=1).
pub(super) fn shade(base: [f64; 3], total: [f64; 3], view: f64) -> [f64; 3] {
    std::array::from_fn(|c| (total[c].min(1.0) * view * base[c]).clamp(0.0, 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eye::Falloff;

    #[test]
    fn a_foot_on_a_light_plane_must_be_more_than_tau_before_the_facet() {
        // The facet x_0 = 0 of size 1, seen from below, and light planes parallel to it.
        let v = [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        let facet = Occluder::new(&v, [1.0, 0.0, 0.0], 0.0);
        let reached = |offset: f64, p: [f64; 3]| {
            let place = LightPlace::Plane { direction: [1.0, 0.0, 0.0], offset };
            let light = FrameLight { place, falloff: Falloff::OFF, color: [1.0; 3] };
            light.reach(&facet.placement(&light), &facet, -1, &p).map(|(distance, target)| {
                let LightTarget::Foot { position } = target else { panic!("a light plane has feet") };
                (distance, position)
            })
        };
        let p = [0.0, 0.25, 0.5];
        assert_eq!(reached(-0.5, p), Some((0.5, [-0.5, 0.25, 0.5])));
        let beyond = TAU.next_up();
        assert_eq!(reached(-beyond, p), Some((beyond, [-beyond, 0.25, 0.5])));
        assert_eq!([-TAU, 0.0, TAU, 0.5].map(|offset| reached(offset, p)), [None; 4]);
    }
}

//! Fog for a vector of points: `pipeline::shade::visibility` in f32.

use super::lighting::{V3, dot, exp2, splat3};
use crate::scene::{Fog, FogKind};
use crate::simd::{F32, Simd};
use std::f32::consts::LOG2_E;

/// Fog of a scene, in the shading space of a draw.
#[derive(Clone, Copy, Debug)]
pub struct FogParams {
    color: [f32; 3],
    range: f32,
    kind: FogKind,
    /// Position of the eye, from which distance is measured, in the space of the positions.
    eye: [f32; 3],
}

/// Bound on numbers whose squares fit f32.
const LARGEST: f32 = 1e15;

impl FogParams {
    /// Converts the fog of a scene seen from `eye`; `None` if f32 does not carry it.
    pub fn new(fog: &Fog, eye: [f32; 3]) -> Option<FogParams> {
        let color = fog.color.as_vec3().to_array();
        let range = fog.visibility_range as f32;
        let is_carried = eye.iter().chain(&color).all(|v| v.abs() < LARGEST);
        let has_range = (1e-12..LARGEST).contains(&range);
        (is_carried && has_range).then_some(FogParams { color, range, kind: fog.kind, eye })
    }

    /// Returns a colour at `position` as seen through the fog from the eye.
    #[inline(always)]
    pub fn over<S: Simd>(&self, s: S, color: V3<S>, position: V3<S>) -> V3<S> {
        let (zero, one, range) = (s.splat(0.0), s.splat(1.0), s.splat(self.range));
        let eye = splat3(s, self.eye);
        let away = [position[0] - eye[0], position[1] - eye[1], position[2] - eye[2]];
        let distance = dot::<S>(away, away).sqrt();
        let left = range - distance;
        let clear = match self.kind {
            FogKind::Linear => left / range,
            FogKind::Exponential => exp2(s, s.splat(-LOG2_E) * (distance / left)),
        };
        // Beyond its range, and where the distance is NaN, all is fog.
        let clear = s.select(zero.lt(left), clear, zero);
        let hidden = one - clear;
        let fog = splat3(s, self.color);
        [
            fog[0] * hidden + color[0] * clear,
            fog[1] * hidden + color[1] * clear,
            fog[2] * hidden + color[2] * clear,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::shade::visibility;
    use crate::simd::{Kernel, Level};
    use glam::DVec3;

    struct InFog<'a>(&'a FogParams, f32);

    impl Kernel for InFog<'_> {
        type Output = f32;
        fn run<S: Simd>(self, s: S) -> f32 {
            let white = [s.splat(1.0); 3];
            let at = [s.splat(self.1), s.splat(0.0), s.splat(0.0)];
            let mut out = [0.0; 16];
            s.store(self.0.over(s, white, at)[1], &mut out[..S::LANES]);
            out[S::LANES - 1]
        }
    }

    #[test]
    fn fog_is_as_thick_as_the_plain_path_has_it_and_alike_at_every_level() {
        for kind in [FogKind::Linear, FogKind::Exponential] {
            let fog = Fog { color: DVec3::ZERO, kind, visibility_range: 12.5 };
            let params = FogParams::new(&fog, [0.5, 0.0, 0.0]).unwrap();
            for i in 0..=300 {
                let x = 0.5 + i as f32 * 0.05;
                let got = Level::ALL.map(|level| level.dispatch(InFog(&params, x)));
                assert!(got.iter().all(|g| g.to_bits() == got[0].to_bits()), "{got:?}");
                let want = visibility(&fog, f64::from(x) - 0.5);
                assert!((f64::from(got[0]) - want).abs() < 2e-6, "{kind:?} at {x}: {} for {want}", got[0]);
            }
        }
        let none = Fog { color: DVec3::ONE, kind: FogKind::Linear, visibility_range: 1e300 };
        assert!(FogParams::new(&none, [0.0; 3]).is_none());
    }
}

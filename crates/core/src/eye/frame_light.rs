//! The scene's lights in eye space.

use super::eye_space::EyeSpace;
use super::scene::{EyeLightKind, EyeScene, Falloff};
use crate::math::nvec::dot;

/// Position or direction of a light in eye space.
pub(super) enum LightPlace<const N: usize> {
    Sun { direction: [f64; N] },
    Plane { direction: [f64; N], offset: f64 },
    Radial { position: [f64; N] },
}

/// A light of the scene, in eye space.
pub(super) struct FrameLight<const N: usize> {
    pub place: LightPlace<N>,
    pub falloff: Falloff,
    pub color: [f64; 3],
}

/// Returns the scene's lights in eye space.
pub(super) fn frame_lights<const N: usize>(scene: &EyeScene, eye: &EyeSpace<N>) -> Vec<FrameLight<N>> {
    let place = |kind: &EyeLightKind| match kind {
        EyeLightKind::Sun { direction } => LightPlace::Sun { direction: eye.direction(direction) },
        EyeLightKind::Plane { direction, point } => {
            let direction = eye.direction(direction);
            LightPlace::Plane { direction, offset: dot(&direction, &eye.point(point)) }
        }
        EyeLightKind::Radial { position } => LightPlace::Radial { position: eye.point(position) },
    };
    scene
        .lights
        .iter()
        .map(|l| FrameLight { place: place(&l.kind), falloff: l.falloff, color: l.color })
        .collect()
}

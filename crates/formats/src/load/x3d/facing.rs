//! LOD and Billboard: nodes that depend on the position of the viewer.
//!
//! LOD (ISO/IEC 19775-1 clause 23.4.3): the distance d from the viewer to `center`, both in the
//! LOD's own coordinates (enclosing scales count), selects the level: 0 if d < R0, i if R(i-1) <= d
//! < R(i), the number of ranges if d is no less than the last. Missing levels at the end are
//! replaced by the last existing one. Without ranges the choice is the browser's: here the first,
//! the finest. Bindable nodes of hidden levels can still be bound.
//!
//! Billboard (23.4.1): with an axis, the local z axis is turned about it into the plane of the axis
//! and the direction to the viewer, on the viewer's side. With the axis 0 0 0, z points at the
//! viewer and y is as close as possible to the viewer's up direction. The viewer's position and up
//! direction are taken in the Billboard's own coordinates. For a viewer on the axis the rotation is
//! the identity.

use fbptr_core::math::matrix::{rotate, unit};
use fbptr_core::scene::Camera;
use glam::{DMat3, DMat4, DVec3};

/// Returns the index of the child that a LOD shows; `None` if it has none.
pub(super) fn level(
    camera: &Camera,
    model: DMat4,
    center: DVec3,
    ranges: &[f64],
    children: usize,
) -> Option<usize> {
    let last = children.checked_sub(1)?;
    let Some(eye) = eye_in(camera, model) else { return Some(0) };
    let distance = (eye - center).length();
    Some(ranges.iter().take_while(|r| **r <= distance).count().min(last))
}

/// Returns the rotation of a Billboard with world matrix `model`.
pub(super) fn billboard(camera: &Camera, model: DMat4, axis: DVec3) -> DMat4 {
    let Some(to_viewer) = eye_in(camera, model).and_then(unit) else { return DMat4::IDENTITY };
    match unit(axis) {
        Some(axis) => about(axis, to_viewer),
        None => {
            let up = model.inverse().transform_vector3(camera.look_at.up);
            let Some(x) = unit(up.cross(to_viewer)) else { return DMat4::IDENTITY };
            DMat4::from_mat3(DMat3::from_cols(x, to_viewer.cross(x), to_viewer))
        }
    }
}

/// Returns the rotation about `axis` that brings z into the half plane of the axis and `to_viewer`.
fn about(axis: DVec3, to_viewer: DVec3) -> DMat4 {
    let across = |v: DVec3| unit(v - axis * axis.dot(v));
    let (Some(z), Some(viewer)) = (across(DVec3::Z), across(to_viewer)) else { return DMat4::IDENTITY };
    let angle = libm::atan2(axis.dot(z.cross(viewer)), z.dot(viewer));
    rotate(axis, angle).unwrap_or(DMat4::IDENTITY)
}

/// Returns the viewer's position in the coordinates of `model`; `None` if `model` has no inverse.
fn eye_in(camera: &Camera, model: DMat4) -> Option<DVec3> {
    let eye = model.inverse().transform_point3(camera.look_at.eye);
    eye.is_finite().then_some(eye)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::math::matrix::{scale, translate};
    use fbptr_core::scene::LookAt;
    use std::f64::consts::FRAC_PI_2;

    fn from(eye: [f64; 3], up: DVec3) -> Camera {
        let look_at = LookAt { eye: eye.into(), reference: DVec3::ZERO, up };
        Camera { look_at, ..Camera::default() }
    }

    fn close(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-12, "{a} is not {b}");
    }

    #[test]
    fn the_level_follows_the_distance_in_the_nodes_own_units() {
        let level_at = |z: f64, model: DMat4, children: usize| {
            level(&from([0.0, 0.0, z], DVec3::Y), model, DVec3::Z, &[2.0, 5.0], children)
        };
        let one = DMat4::IDENTITY;
        // From z, the center (0 0 1) is z - 1 away.
        assert_eq!([2.9, 3.0, 5.9, 6.0, 1e9].map(|z| level_at(z, one, 3)), [0, 1, 1, 2, 2].map(Some));
        assert_eq!([1e9, 4.0, 0.0].map(|z| level_at(z, one, 2)), [1, 1, 0].map(Some));
        assert_eq!(level_at(4.0, one, 0), None);
        // In a group ten times as large a distance of 30 is 3.
        assert_eq!(level_at(40.0, scale(DVec3::splat(10.0)), 3), Some(1));
        assert_eq!(level_at(40.0, scale(DVec3::ZERO), 3), Some(0));
        assert_eq!(level(&from([0.0; 3], DVec3::Y), one, DVec3::ZERO, &[], 4), Some(0));
    }

    #[test]
    fn a_billboard_turns_about_its_axis_alone() {
        let turned = |eye, axis: DVec3, v: DVec3| {
            billboard(&from(eye, DVec3::Y), DMat4::IDENTITY, axis).transform_vector3(v)
        };
        // From +x, 45 degrees up: z goes to x and stays level.
        close(turned([5.0, 5.0, 0.0], DVec3::Y, DVec3::Z), DVec3::X);
        close(turned([5.0, 5.0, 0.0], DVec3::Y, DVec3::Y), DVec3::Y);
        close(turned([-1.0, 3.0, 1.0], DVec3::Y * 2.0, DVec3::Z), DVec3::new(-1.0, 0.0, 1.0).normalize());
        close(turned([9.0, 0.0, -1.0], DVec3::X, DVec3::Z), DVec3::NEG_Z);
        for eye in [[0.0, 7.0, 0.0], [0.0, 0.0, 0.0]] {
            assert_eq!(turned(eye, DVec3::Y, DVec3::Z), DVec3::Z, "{eye:?}");
        }
        assert_eq!(turned([1.0, 0.0, 0.0], DVec3::Z, DVec3::Z), DVec3::Z);
    }

    #[test]
    fn without_an_axis_it_looks_at_the_viewer_and_keeps_the_viewers_up() {
        let camera = from([0.0, 4.0, 0.0], DVec3::NEG_Z);
        let model = translate(DVec3::new(0.0, 1.0, 0.0)) * rotate(DVec3::Z, FRAC_PI_2).unwrap();
        let turn = model * billboard(&camera, model, DVec3::ZERO);
        close(turn.transform_vector3(DVec3::Z), DVec3::Y);
        close(turn.transform_vector3(DVec3::Y), DVec3::NEG_Z);
        close(turn.transform_vector3(DVec3::X), DVec3::X);
        let slanted = from([3.0, 0.0, 4.0], DVec3::new(0.0, 1.0, 1.0));
        let turn = billboard(&slanted, DMat4::IDENTITY, DVec3::ZERO);
        close(turn.transform_vector3(DVec3::Z), DVec3::new(0.6, 0.0, 0.8));
        assert!(turn.transform_vector3(DVec3::Y).dot(slanted.look_at.up) > 0.7);
        assert!((turn.determinant() - 1.0).abs() < 1e-12);
    }
}

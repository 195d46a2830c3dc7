//! Navigation: a viewer's camera, relative to the one of the scene's author.
//!
//! In: the author's camera, which may itself move with time. Out: the viewer's. Angles in radians,
//! lengths in world units.
//!
//! A navigator is one rigid motion of the world (camera' = M camera), a zoom (a factor on the
//! distance to the reference point) and a choice of projection. Promise: a navigator at home
//! returns the author's camera bit for bit.

use super::auto_framing::{FRAME_FOV_RAD, box_corners};
use super::{Camera, LookAt, ObliqueKind, Projection, contain};
use crate::math::matrix;
use glam::{DMat4, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Projection that the viewer chose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum ProjectionChoice {
    /// As the author chose.
    #[default]
    AsGiven,
    /// Perspective.
    Perspective,
    /// Orthographic.
    Orthographic,
    /// Oblique, with receding lines halved (cabinet) and at 45 degrees.
    Oblique,
}

impl ProjectionChoice {
    /// Returns the next choice for a camera whose author chose the projection `given`. The cycle is
    /// as given, perspective (left out if `given` is one), orthographic, oblique.
    pub fn next(self, given: &Projection) -> Self {
        use ProjectionChoice::*;
        match (self, is_parallel(given)) {
            (AsGiven, false) | (Perspective, _) => Orthographic,
            (AsGiven, true) => Perspective,
            (Orthographic, _) => Oblique,
            (Oblique, _) => AsGiven,
        }
    }
}

/// Transformation from the author's camera to the viewer's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Navigator {
    motion: DMat4,
    zoom: f64,
    /// Projection that the viewer chose.
    pub projection: ProjectionChoice,
}

impl Default for Navigator {
    fn default() -> Self {
        Navigator { motion: DMat4::IDENTITY, zoom: 1.0, projection: ProjectionChoice::AsGiven }
    }
}

/// Least angle between an orbiting viewer and the poles.
const POLE_RAD: f64 = PI / 180.0;

/// Limits of the zoom, within which distances keep their precision.
const ZOOM: std::ops::RangeInclusive<f64> = 1e-4..=1e4;

/// Returns the part of a pitch that keeps the viewer, upright or upside down, [`POLE_RAD`] away from
/// the poles of `up`, or as near to them as it is.
fn pitch_to_pole([_, y, z]: [DVec3; 3], up: DVec3, pitch_rad: f64) -> f64 {
    // Elevation of the eye above the reference point: 0 on the equator, PI there upside down.
    let elevation = libm::atan2(z.dot(up), y.dot(up));
    let equator = if elevation.abs() > FRAC_PI_2 { PI.copysign(elevation) } else { 0.0 };
    let given = elevation - equator;
    let highest = (FRAC_PI_2 - POLE_RAD).max(given.abs());
    given - (given - pitch_rad).clamp(-highest, highest)
}

impl Navigator {
    /// Returns whether the viewer's camera is the author's.
    pub fn is_home(&self) -> bool {
        *self == Navigator::default()
    }

    /// Returns whether the projection is parallel, so that moving ahead changes only the clipping.
    pub fn is_parallel(&self, given: &Camera) -> bool {
        match self.projection {
            ProjectionChoice::AsGiven => is_parallel(&given.projection),
            ProjectionChoice::Perspective => false,
            ProjectionChoice::Orthographic | ProjectionChoice::Oblique => true,
        }
    }

    /// Rotates about the reference point: by `yaw_rad` about the world's up axis `up`, so that a
    /// level horizon stays level, then by `pitch_rad` about the viewer's right, not over the poles
    /// above and below the reference point. Yaw is reversed if the given camera is upside down, so
    /// that near objects still follow a drag.
    pub fn orbit(&mut self, given: &Camera, up: DVec3, yaw_rad: f64, pitch_rad: f64) {
        let is_upside_down = self.stand(given).axes().is_ok_and(|[_, y, _]| y.dot(up) < 0.0);
        self.turn(given, if is_upside_down { -up } else { up }, yaw_rad);
        if let Ok(axes) = self.stand(given).axes() {
            self.turn(given, axes[0], pitch_to_pole(axes, up, pitch_rad));
        }
    }

    fn turn(&mut self, given: &Camera, axis: DVec3, angle_rad: f64) {
        let center = self.stand(given).reference;
        if let Some(turn) = matrix::rotate(axis, angle_rad).filter(|t| t.is_finite()) {
            self.move_by(matrix::translate(center) * turn * matrix::translate(-center));
        }
    }

    /// Moves eye and reference point to the right, up and ahead, in units of their distance.
    pub fn walk(&mut self, given: &Camera, [right, up, ahead]: [f64; 3]) {
        let stand = self.stand(given);
        if let Ok([x, y, z]) = stand.axes() {
            let distance = (stand.eye - stand.reference).length();
            self.move_by(matrix::translate((x * right + y * up - z * ahead) * distance));
        }
    }

    fn move_by(&mut self, motion: DMat4) {
        let moved = motion * self.motion;
        // Beyond the range of numbers nothing is visible.
        if moved.is_finite() && moved.w_axis.truncate().length() < 1e150 {
            self.motion = moved;
        }
    }

    /// Multiplies the distance to the reference point by `factor`, within limits.
    pub fn zoom_by(&mut self, factor: f64) {
        let zoom = self.zoom * factor;
        if zoom.is_finite() {
            self.zoom = zoom.clamp(*ZOOM.start(), *ZOOM.end());
        }
    }

    /// Returns the viewer's eye, reference point and up vector.
    pub fn stand(&self, given: &Camera) -> LookAt {
        let LookAt { eye, reference, up } = stand(given);
        let moved = |p: DVec3| self.motion.transform_point3(p);
        let (eye, reference) = (moved(eye), moved(reference));
        LookAt {
            eye: reference + (eye - reference) * self.zoom,
            reference,
            up: self.motion.transform_vector3(up),
        }
    }

    /// Returns the viewer's camera for a viewport of `aspect` = width / height. With `bounds`, a
    /// box around the visible objects, the near and far planes are fitted to it.
    pub fn apply(&self, given: &Camera, bounds: Option<(DVec3, DVec3)>, aspect: f64) -> Camera {
        if self.is_home() {
            return *given;
        }
        let mut look_at = self.stand(given);
        let distance = (look_at.eye - look_at.reference).length();
        let [half_width, half_height] = half_window(given, aspect).map(|h| h * self.zoom);
        let window = [-half_width, half_width, -half_height, half_height];
        let [near, far] = given.projection.near_far();
        let (near, far) = (near * self.zoom.min(1.0), far * self.zoom.max(1.0));
        // A parallel box may begin behind the eye.
        let (back, front) = (-far.abs().max(distance), far.abs().max(distance));
        let projection = match self.projection {
            ProjectionChoice::AsGiven => self.own(given, near, far),
            ProjectionChoice::Perspective if is_parallel(&given.projection) => {
                let ahead = matrix::unit(look_at.eye - look_at.reference).unwrap_or(DVec3::Z);
                let away = half_height.max(half_width / aspect) / libm::tan(FRAME_FOV_RAD / 2.0);
                look_at.eye = look_at.reference + ahead * away;
                let (near, far) = (away * 1e-3, away * 10.0 + front);
                Projection::Perspective { fov_rad: FRAME_FOV_RAD, near, far, on_smaller_side: false }
            }
            ProjectionChoice::Perspective => self.own(given, near, far),
            ProjectionChoice::Orthographic => Projection::Ortho { window, near: back, far: front },
            ProjectionChoice::Oblique => Projection::Oblique {
                kind: ObliqueKind::Cabinet,
                angle_rad: std::f64::consts::FRAC_PI_4,
                window,
                near: back,
                far: front,
            },
        };
        let mut camera = Camera { look_at, projection };
        if let Some(bounds) = bounds {
            lay_about(&mut camera, bounds);
        }
        camera
    }

    /// Returns the author's projection at the viewer's zoom.
    fn own(&self, given: &Camera, near: f64, far: f64) -> Projection {
        let moved = |p: DVec3| self.motion.transform_point3(p);
        let sized = |window: [f64; 4]| window.map(|side| side * self.zoom);
        let mut projection = given.projection;
        match &mut projection {
            Projection::Perspective { near: n, far: f, .. } | Projection::Plane { near: n, far: f, .. } => {
                (*n, *f) = (near, far);
            }
            // The window lies on the near plane: they shrink together.
            Projection::Frustum { window, near: n, far: f } => {
                (*window, *n, *f) = (window.map(|side| side * self.zoom.min(1.0)), near, far);
            }
            Projection::Ortho { window, .. }
            | Projection::OrthoContain { window, .. }
            | Projection::Oblique { window, .. }
            | Projection::Isometric { window, .. }
            | Projection::PseudoIsometric { window, .. } => *window = sized(*window),
            Projection::Window { vrp, p, vup, near: n, far: f, .. } => {
                let (eye, reference) = (moved(*p), moved(*vrp));
                *p = reference + (eye - reference) * self.zoom;
                (*vrp, *vup) = (reference, self.motion.transform_vector3(*vup));
                (*n, *f) = (near, far);
            }
        }
        projection
    }
}

/// Returns eye, reference point and up of any camera; the viewing transformation has its own.
fn stand(camera: &Camera) -> LookAt {
    match camera.projection {
        Projection::Window { vrp, p, vup, .. } => LookAt { eye: p, reference: vrp, up: vup },
        _ => camera.look_at,
    }
}

fn is_parallel(projection: &Projection) -> bool {
    use Projection::*;
    matches!(
        projection,
        Ortho { .. } | OrthoContain { .. } | Oblique { .. } | Isometric { .. } | PseudoIsometric { .. }
    )
}

/// Returns half the width and height of the visible part of the plane through the reference point.
fn half_window(camera: &Camera, aspect: f64) -> [f64; 2] {
    let LookAt { eye, reference, .. } = stand(camera);
    let distance = (eye - reference).length();
    let half = |[l, r, b, t]: [f64; 4]| [(r - l).abs() / 2.0, (t - b).abs() / 2.0];
    match camera.projection {
        Projection::Perspective { fov_rad, on_smaller_side, .. } => {
            let side = distance * libm::tan(fov_rad / 2.0);
            if on_smaller_side && aspect < 1.0 { [side, side / aspect] } else { [side * aspect, side] }
        }
        Projection::Plane { d, .. } => [distance / d; 2],
        Projection::Frustum { window, near, .. } => half(window).map(|h| h * distance / near),
        Projection::OrthoContain { window, .. } => half(contain(window, aspect)),
        Projection::Ortho { window, .. }
        | Projection::Oblique { window, .. }
        | Projection::Isometric { window, .. }
        | Projection::PseudoIsometric { window, .. } => half(window),
        Projection::Window { half, dp, .. } => half.map(|h| h * distance / dp),
    }
}

/// Fits the near and far planes to a box, with a margin for objects that move slightly out of it.
fn lay_about(camera: &mut Camera, bounds: (DVec3, DVec3)) {
    let Ok([_, _, z]) = camera.look_at.axes() else { return };
    let ahead = box_corners(bounds).map(|corner| (camera.look_at.eye - corner).dot(z));
    let (nearest, farthest) =
        ahead.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)));
    let room = 0.1 * (farthest - nearest) + 1e-6 * farthest.abs();
    if !(room > 0.0 && room.is_finite()) {
        return;
    }
    match &mut camera.projection {
        Projection::Perspective { near, far, .. } | Projection::Plane { near, far, .. } => {
            // Nothing is visible behind the eye: any range is valid.
            let end = if farthest > 0.0 { farthest + room } else { room };
            (*near, *far) = (((nearest - room).max(0.5 * nearest)).max(end * 1e-4), end);
        }
        Projection::Ortho { near, far, .. } | Projection::OrthoContain { near, far, .. } => {
            (*near, *far) = (nearest - room, farthest + room);
        }
        // The window lies on the near plane, or depth is sheared or rotated: the author's range is
        // kept.
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{frame, shapes};

    fn given() -> (Camera, (DVec3, DVec3)) {
        let bounds = shapes::teapot(2).expect("a level").bounds().expect("a teapot");
        (frame(bounds, 1.5), bounds)
    }

    /// NDC of a world point.
    fn seen(camera: &Camera, p: DVec3, aspect: f64) -> DVec3 {
        let m = camera.matrices(aspect).expect("a camera");
        let clip = m.projection * (m.view * p.extend(1.0));
        clip.truncate() / clip.w
    }

    #[test]
    fn home_is_the_authors_camera_bit_for_bit() {
        let (camera, bounds) = given();
        assert_eq!(Navigator::default().apply(&camera, Some(bounds), 1.5), camera);
    }

    #[test]
    fn orbits_keep_the_reference_and_the_distance_and_come_back() {
        let (camera, bounds) = given();
        let distance = |c: &Camera| (c.look_at.eye - c.look_at.reference).length();
        let mut navigator = Navigator::default();
        for _ in 0..36 {
            navigator.orbit(&camera, DVec3::Y, std::f64::consts::PI / 18.0, 0.3);
            let moved = navigator.apply(&camera, Some(bounds), 1.5);
            assert!((moved.look_at.reference - camera.look_at.reference).length() < 1e-9);
            assert!((distance(&moved) - distance(&camera)).abs() < 1e-9);
            assert!(seen(&moved, camera.look_at.reference, 1.5).truncate().length() < 1e-9);
            for corner in box_corners(bounds) {
                let z = seen(&moved, corner, 1.5).z;
                assert!((0.0..=1.0).contains(&z), "{corner} at {z}");
            }
        }
        let mut once = Navigator::default();
        once.orbit(&camera, DVec3::Y, 0.7, 0.0);
        once.orbit(&camera, DVec3::Y, -0.7, 0.0);
        let back = once.apply(&camera, None, 1.5);
        assert!((back.look_at.eye - camera.look_at.eye).length() < 1e-12);
    }

    #[test]
    fn an_orbit_keeps_the_horizon_level_and_the_height() {
        let (camera, _) = given();
        assert!(camera.look_at.up.z.abs() > 0.1, "the author's camera looks down: its own up is tilted");
        let mut navigator = Navigator::default();
        for _ in 0..36 {
            navigator.orbit(&camera, DVec3::Y, std::f64::consts::PI / 18.0, 0.0);
            let look_at = navigator.stand(&camera);
            let [right, up, _] = look_at.axes().expect("axes");
            assert!(right.y.abs() < 1e-12 && up.y > 0.5, "{right} {up}");
            assert!((look_at.eye.y - camera.look_at.eye.y).abs() < 1e-9);
        }
    }

    #[test]
    fn an_orbit_ends_at_the_poles() {
        let (mut camera, _) = given();
        for is_upside_down in [false, true] {
            let mut navigator = Navigator::default();
            let mut heights = Vec::new();
            for pitch_rad in [-0.1; 40].into_iter().chain([0.3; 20]) {
                navigator.orbit(&camera, DVec3::Y, 0.2, pitch_rad);
                let [right, up, back] = navigator.stand(&camera).axes().expect("axes");
                assert!(right.y.abs() < 1e-9 && (up.y < 0.0) == is_upside_down, "{right} {up}");
                heights.push(libm::asin(back.y));
            }
            let (high, low) = (heights[39], heights[59]);
            let pole = FRAC_PI_2 - POLE_RAD;
            let ends = if is_upside_down { [-pole, pole] } else { [pole, -pole] };
            assert!((high - ends[0]).abs() < 1e-9 && (low - ends[1]).abs() < 1e-9, "{heights:?}");
            camera.look_at.up = -camera.look_at.up;
        }
        // A camera at a pole leaves it, and goes no nearer.
        camera.look_at = LookAt { eye: DVec3::Y * 9.0, reference: DVec3::ZERO, up: DVec3::Z };
        let mut navigator = Navigator::default();
        navigator.orbit(&camera, DVec3::Y, 0.0, -0.5);
        assert!((navigator.stand(&camera).eye - camera.look_at.eye).length() < 1e-9);
        navigator.orbit(&camera, DVec3::Y, 0.0, 0.5);
        let eye = navigator.stand(&camera).eye;
        assert!((eye.y - 9.0 * libm::cos(0.5)).abs() < 1e-9, "{eye}");
    }

    #[test]
    fn every_projection_shows_the_plane_of_the_reference_at_one_size() {
        let (camera, bounds) = given();
        let [right, up, _] = camera.look_at.axes().expect("axes");
        let point = camera.look_at.reference + right * 0.4 + up * 0.3;
        let want = seen(&camera, point, 1.5);
        let mut navigator = Navigator::default();
        for expected in [ProjectionChoice::Orthographic, ProjectionChoice::Oblique, ProjectionChoice::AsGiven]
        {
            navigator.projection = navigator.projection.next(&camera.projection);
            assert_eq!(navigator.projection, expected);
            let found = seen(&navigator.apply(&camera, Some(bounds), 1.5), point, 1.5);
            assert!((found - want).truncate().length() < 1e-9, "{expected:?}: {found} {want}");
        }
        let parallel = Camera {
            projection: Projection::Ortho { window: [-3.0, 3.0, -2.0, 2.0], near: 0.1, far: 50.0 },
            ..camera
        };
        navigator.projection = navigator.projection.next(&parallel.projection);
        assert_eq!(navigator.projection, ProjectionChoice::Perspective);
        let found = seen(&navigator.apply(&parallel, None, 1.5), point, 1.5);
        assert!((found - seen(&parallel, point, 1.5)).truncate().length() < 1e-9);
    }

    #[test]
    fn no_walk_and_no_zoom_makes_a_camera_that_makes_no_picture() {
        let (camera, bounds) = given();
        for choice in [ProjectionChoice::AsGiven, ProjectionChoice::Orthographic, ProjectionChoice::Oblique] {
            let mut navigator = Navigator { projection: choice, ..Navigator::default() };
            for step in 0..400 {
                match step % 4 {
                    0 => navigator.zoom_by(if step < 200 { 0.5 } else { 3.0 }),
                    1 => navigator.walk(&camera, [0.5, -3.0, f64::from(step)]),
                    2 => navigator.orbit(&camera, DVec3::Y, 1e3, -7.0),
                    _ => navigator.zoom_by([f64::NAN, 0.0, f64::INFINITY, -1.0][step as usize / 4 % 4]),
                }
                let moved = navigator.apply(&camera, Some(bounds), 1.5);
                assert!(moved.matrices(1.5).is_ok(), "step {step}: {moved:?}");
            }
        }
    }
}

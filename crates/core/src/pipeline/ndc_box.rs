//! Rectangle of normalised device coordinates around a box in space.
//!
//! In: a box, and the transform from its space to clip space. Out: the rectangle that its corners
//! span, within the view volume's sides from -1 to 1. It is right if no point of the box within these
//! sides is drawn outside the rectangle. As the projection maps straight lines to straight lines, that
//! is so if all of the box lies in front of the eye, but for rounding: a draw transforms by the model,
//! the view and the projection one after the other, and loses what the largest number on the way
//! rounds off. There is no rectangle for other boxes, nor where that could move a point by 1/10,000.

use crate::scene::{CameraMatrices, box_corners};
use glam::{DMat4, DVec2, DVec3, DVec4, Vec4Swizzles};

/// Largest allowed rounding error, relative to w.
const MOST_ROUNDING: f64 = 1e-4;

/// Transform to clip space, with a bound on its rounding errors.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct ClipTransform {
    matrix: DMat4,
    /// Coordinates of at most r in magnitude become numbers of at most `scale` * r + `offset` on the
    /// way, if no terms cancel.
    scale: f64,
    offset: f64,
}

impl ClipTransform {
    /// Creates the transform from the world.
    pub fn of(camera: &CameraMatrices) -> ClipTransform {
        ClipTransform::of_projection(camera.projection).after(&camera.view)
    }

    /// Creates the transform from view space.
    pub fn of_projection(matrix: DMat4) -> ClipTransform {
        ClipTransform { matrix, scale: 1.0, offset: 0.0 }.with_magnitudes(&matrix)
    }

    /// Returns the transform that applies `first`, and then this one.
    pub fn after(self, first: &DMat4) -> ClipTransform {
        ClipTransform { matrix: self.matrix * *first, ..self.with_magnitudes(first) }
    }

    /// Adds the magnitudes of a matrix that is applied first.
    fn with_magnitudes(self, first: &DMat4) -> ClipTransform {
        let [x, y, z, w] = [0, 1, 2, 3].map(|column| first.col(column).abs().max_element());
        ClipTransform { scale: self.scale * (x + y + z), offset: self.scale * w + self.offset, ..self }
    }

    /// Returns a point in clip space; `None` beside or behind the eye, and where rounding could move
    /// the point by more than [`MOST_ROUNDING`].
    pub fn project(&self, point: DVec3) -> Option<DVec4> {
        let clip = self.matrix * point.extend(1.0);
        let rounding = 16.0 * f64::EPSILON * (self.scale * point.abs().max_element() + self.offset);
        (clip.is_finite() && clip.w * MOST_ROUNDING > rounding).then_some(clip)
    }

    /// Returns the matrix.
    pub fn matrix(&self) -> &DMat4 {
        &self.matrix
    }
}

/// Rectangle around a box that lies before the eye.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct NdcBox {
    /// Least x and y, from -1 to 1.
    pub low: [f64; 2],
    /// Greatest x and y, from -1 to 1.
    pub high: [f64; 2],
    /// Least w of a corner in clip space.
    pub nearest_w: f64,
}

impl NdcBox {
    /// Projects the box with these corners; `None` if a corner has no place in clip space.
    pub fn of(bounds: (DVec3, DVec3), to_clip: &ClipTransform) -> Option<NdcBox> {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut nearest_w = f64::INFINITY;
        for corner in box_corners(bounds) {
            let clip = to_clip.project(corner)?;
            let at = clip.xy() / clip.w;
            (low, high, nearest_w) = (low.min(at), high.max(at), nearest_w.min(clip.w));
        }
        let within = |v: DVec2| v.clamp(DVec2::NEG_ONE, DVec2::ONE).to_array();
        Some(NdcBox { low: within(low), high: within(high), nearest_w })
    }

    /// Returns the sides of the rectangle, as parts of the view volume's.
    pub fn sides(&self) -> [f64; 2] {
        [0, 1].map(|axis| (self.high[axis] - self.low[axis]) / 2.0)
    }

    /// Returns an upper bound of the pixels whose centres lie in the rectangle, on a viewport of
    /// `view` pixels.
    pub fn pixels(&self, view: [f64; 2]) -> f64 {
        let [width, height] = self.sides();
        (width * view[0] + 1.0) * (height * view[1] + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, LookAt};

    /// Returns the transform of the usual projection, seen from `eye` along -z.
    fn seen_from(eye: DVec3) -> ClipTransform {
        let look_at = LookAt { eye, reference: eye - DVec3::Z, up: DVec3::Y };
        ClipTransform::of(&Camera { look_at, ..Camera::default() }.matrices(1.0).unwrap())
    }

    #[test]
    fn the_part_within_the_view_volume_counts() {
        let identity = ClipTransform::of_projection(DMat4::IDENTITY);
        let sides =
            |low: [f64; 3], high: [f64; 3]| NdcBox::of((low.into(), high.into()), &identity).unwrap().sides();
        assert_eq!(sides([-0.5, -0.25, 0.0], [0.75, 0.5, 1.0]), [0.625, 0.375]);
        assert_eq!(sides([-9.0, 0.0, 0.0], [0.0, 9.0, 1.0]), [0.5, 0.5]);
        assert_eq!(sides([2.0, 0.0, 0.0], [3.0, 1.0, 1.0]), [0.0, 0.5]);
    }

    #[test]
    fn a_box_beside_or_behind_the_eye_has_no_rectangle() {
        // w is z.
        let perspective = DMat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0,
        ]);
        let perspective = ClipTransform::of_projection(perspective);
        let of =
            |near: f64| NdcBox::of((DVec3::new(0.0, 0.0, near), DVec3::new(1.0, 1.0, 2.0)), &perspective);
        assert!(of(-1.0).is_none() && of(0.0).is_none() && of(f64::NAN).is_none() && of(-1e308).is_none());
        let before = of(1.0).unwrap();
        assert_eq!((before.low, before.high, before.nearest_w), ([0.0; 2], [1.0; 2], 1.0));
    }

    #[test]
    fn a_box_has_no_rectangle_where_rounding_could_move_it() {
        let near = |far: f64| {
            let corner = DVec3::new(0.1, 0.1, far - 1.0);
            NdcBox::of((corner - 0.01, corner), &seen_from(DVec3::new(0.0, 0.0, far)))
        };
        let width = near(10.0).unwrap().sides()[0];
        assert!((near(1e6).unwrap().sides()[0] - width).abs() < 1e-4);
        assert!(near(1e12).is_none());
        // The model brings the box to the eye, and the product of the matrices shows nothing of it.
        let cancelled = |far: f64| {
            let shift = DVec3::new(far, 0.0, 0.0);
            let to_clip = seen_from(shift).after(&DMat4::from_translation(shift));
            NdcBox::of((DVec3::new(0.0, 0.0, -2.0), DVec3::new(0.1, 0.1, -1.0)), &to_clip)
        };
        assert!(cancelled(1e6).is_some() && cancelled(1e16).is_none());
    }

    #[test]
    fn a_far_corner_does_not_hide_how_near_another_one_is() {
        let seen = |low: f64| {
            let bounds = (DVec3::new(0.0, 0.0, low), DVec3::new(0.0, 0.0, 0.9));
            NdcBox::of(bounds, &seen_from(DVec3::Z)).unwrap().nearest_w
        };
        assert!((seen(-1e17) / seen(0.5) - 1.0).abs() < 1e-12);
    }
}

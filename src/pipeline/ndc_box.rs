//! Rectangle of normalised device coordinates around a box in space.
//!
//! In: a box, and the matrix from its space to clip space. Out: the rectangle that its corners span,
//! within the view volume's sides from -1 to 1. It is right if no point of the box within these sides
//! lies outside the rectangle. As the projection maps straight lines to straight lines, that is so if
//! all of the box lies in front of the eye; there is no rectangle for other boxes, and none where
//! rounding could move a corner by a part of 10,000.

use crate::scene::box_corners;
use glam::{DMat4, DVec2, DVec3, DVec4, Vec4Swizzles};

/// Rounding errors that are borne, as a part of the least w.
const MOST_ROUNDING: f64 = 1e-4;

/// Rectangle around a box that lies before the eye.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NdcBox {
    /// Least x and y, from -1 to 1.
    pub low: [f64; 2],
    /// Greatest x and y, from -1 to 1.
    pub high: [f64; 2],
    /// Least w of a corner in clip space.
    pub nearest_w: f64,
}

impl NdcBox {
    /// Projects the box with these corners; `None` if a part of it lies beside or behind the eye.
    pub fn of(bounds: (DVec3, DVec3), to_clip: &DMat4) -> Option<NdcBox> {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (mut nearest_w, mut sum) = (f64::INFINITY, DVec4::ZERO);
        for corner in box_corners(bounds) {
            let clip = *to_clip * corner.extend(1.0);
            let at = clip.xy() / clip.w;
            (low, high) = (low.min(at), high.max(at));
            (nearest_w, sum) = (nearest_w.min(clip.w), sum + clip);
        }
        // The sums of products are rounded to their largest summands.
        let [x, y, z, w] = to_clip.to_cols_array_2d().map(|column| DVec4::from(column).abs().max_element());
        let farthest = bounds.0.abs().max(bounds.1.abs());
        let rounding = 4.0 * f64::EPSILON * (DVec3::new(x, y, z).dot(farthest) + w);
        if !sum.is_finite() || rounding.is_nan() || nearest_w * MOST_ROUNDING <= rounding {
            return None;
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

    #[test]
    fn the_part_within_the_view_volume_counts() {
        let sides = |low: [f64; 3], high: [f64; 3]| {
            NdcBox::of((low.into(), high.into()), &DMat4::IDENTITY).unwrap().sides()
        };
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
        let of =
            |near: f64| NdcBox::of((DVec3::new(0.0, 0.0, near), DVec3::new(1.0, 1.0, 2.0)), &perspective);
        assert!(of(-1.0).is_none() && of(0.0).is_none() && of(f64::NAN).is_none() && of(-1e308).is_none());
        let before = of(1.0).unwrap();
        assert_eq!((before.low, before.high, before.nearest_w), ([0.0; 2], [1.0; 2], 1.0));
    }

    #[test]
    fn a_box_has_no_rectangle_where_rounding_could_move_it() {
        // The eye is far from the origin, and the box near the eye.
        let seen_from = |far: f64| {
            let look_at = LookAt { eye: DVec3::new(0.0, 0.0, far), ..Camera::default().look_at };
            let matrices = Camera { look_at, ..Camera::default() }.matrices(1.0).unwrap();
            let near = DVec3::new(0.1, 0.1, far - 1.0);
            NdcBox::of((near - 0.01, near), &(matrices.projection * matrices.view))
        };
        let width = seen_from(10.0).unwrap().sides()[0];
        assert!((seen_from(1e9).unwrap().sides()[0] - width).abs() < 1e-4 * width + 1e-6);
        assert!(seen_from(1e12).is_none());
        // A corner at a great distance does not hide how near another one is.
        let matrices = Camera::default().matrices(1.0).unwrap();
        let eye = Camera::default().look_at.eye;
        let seen = |low: f64| {
            NdcBox::of((DVec3::new(0.0, 0.0, low), eye * 0.99), &(matrices.projection * matrices.view))
        };
        let (near, far) = (seen(eye.z * 0.9), seen(-1e17));
        assert!(far.is_none_or(|far| (far.nearest_w / near.unwrap().nearest_w - 1.0).abs() < 1e-6));
    }
}

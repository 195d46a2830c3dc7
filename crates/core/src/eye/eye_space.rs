//! Eye space: the eye at the origin, lengths scaled by a power of two; its screen and its facets.

use super::scene::EyeScene;
use crate::math::nvec::{dot, unit};

/// A facet that may be visible.
pub(super) struct Visible<const N: usize> {
    /// Index in the scene.
    pub id: u32,
    /// Index in the frame's occluders, if there are lights.
    pub occluder: u32,
    /// Vertices in eye space, in canonical order.
    pub v: [[f64; N]; N],
    /// Unit normal.
    pub normal: [f64; N],
    /// n.x on the facet, not 0.
    pub offset: f64,
    /// Sum of the squared hidden coordinates of the normal.
    pub normal_hidden2: f64,
    /// Lower bound of the distance of the facet's points.
    pub nearest: f64,
    /// Largest distance of a vertex.
    pub farthest: f64,
    /// Half-open range of pixels that may see it along each screen axis; 0..1 along the others.
    pub pixels: [[u32; 2]; N],
    /// Error bound: a functional of the frame's planes smaller than this may have the wrong sign.
    pub doubt: f64,
}

/// The screen in eye space.
pub(super) struct Screen<const N: usize> {
    /// Distance of the screen from the eye, scaled into 1..2.
    pub distance: f64,
    /// Coordinates of the pixel centres, one list for each screen axis.
    pub centres: Vec<Vec<f64>>,
    /// Tangents of the apertures of the hidden axes, by axis.
    pub tan: [f64; N],
}

/// Transform from world to eye space: translation, rotation, scale.
pub(super) struct EyeSpace<const N: usize> {
    origin: [f64; N],
    axes: [[f64; N]; N],
    /// A length here times 2^exponent is a length of the scene.
    pub exponent: i32,
}

impl<const N: usize> EyeSpace<N> {
    /// Creates the transform of a scene's pose, scaled by 2^-exponent.
    pub fn new(scene: &EyeScene, exponent: i32) -> Self {
        let axes = scene.pose.axes();
        EyeSpace {
            origin: std::array::from_fn(|i| rescale(scene.pose.position[i], exponent)),
            axes: std::array::from_fn(|j| std::array::from_fn(|i| axes[j][i])),
            exponent,
        }
    }

    /// Returns R^T (x - o), scaled.
    pub fn point(&self, x: &[f64]) -> [f64; N] {
        let shifted: [f64; N] = std::array::from_fn(|i| rescale(x[i], self.exponent) - self.origin[i]);
        self.turn(&shifted)
    }

    /// Returns R^T u as a unit vector.
    pub fn direction(&self, u: &[f64]) -> [f64; N] {
        let largest = u.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let exponent = exponent_of(largest);
        unit(self.turn(&std::array::from_fn(|i| rescale(u[i], exponent))))
    }

    /// Returns R^T x.
    fn turn(&self, x: &[f64; N]) -> [f64; N] {
        // + 0.0 turns -0 into 0, which the sort of the vertices would distinguish.
        std::array::from_fn(|j| dot(&self.axes[j], x) + 0.0)
    }
}

impl<const N: usize> Screen<N> {
    /// Returns the dimension M of the screen.
    pub fn dim(&self) -> usize {
        self.centres.len()
    }

    /// Creates the screen of a scene.
    pub fn new(scene: &EyeScene) -> Self {
        let exponent = exponent_of(scene.distance);
        let centre = |a: usize, j: u32| {
            let (n, size) = (i64::from(scene.pixels[a]), rescale(scene.size[a], exponent));
            // Integers first, so that the centres are exactly antisymmetric.
            size * (n - 1 - 2 * i64::from(j)) as f64 / (2 * n) as f64
        };
        let mut tan = [0.0; N];
        tan[scene.screen_dim() + 1..].copy_from_slice(&scene.aperture_tan);
        Screen {
            distance: rescale(scene.distance, exponent),
            centres: (0..scene.screen_dim())
                .map(|a| (0..scene.pixels[a]).map(|j| centre(a, j)).collect())
                .collect(),
            tan,
        }
    }
}

/// Returns e with 2^e <= x < 2^(e+1); 0 for 0.
pub(super) fn exponent_of(x: f64) -> i32 {
    if x == 0.0 { 0 } else { libm::ilogb(x) }
}

/// Returns x 2^-exponent, exact but for underflow, clamped so that squares and sums of results stay
/// finite.
pub(super) fn rescale(x: f64, exponent: i32) -> f64 {
    libm::scalbn(x, -exponent).clamp(-1e300, 1e300)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eye::test_scenes::scene;

    #[test]
    fn zero_has_one_sign_in_eye_space() {
        let triangle = vec![vec![1.0, 0.0, 0.0], vec![1.0, 1.0, 0.0], vec![1.0, 0.0, 1.0]];
        let eye = EyeSpace::<3>::new(&scene((1.0, 1.0, 0.0), &[1, 1], vec![triangle], vec![]), 0);
        for x in [[-0.0, -1.0, -2.0], [-3.0, -0.0, -2.0], [-0.0, -0.0, -0.0], [0.0, 0.0, 0.0]] {
            let point = eye.point(&x);
            assert_eq!(point, x);
            assert!(point.iter().all(|c| *c != 0.0 || c.is_sign_positive()), "{x:?}: {point:?}");
        }
    }
}

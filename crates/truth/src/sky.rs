//! Sky of the reference: the viewing direction of each pixel.
//!
//! A point (x, y, z) of view space has NDC (a, b) if r0 . p = a (r3 . p) and r1 . p = b (r3 . p),
//! with r the rows of the projection. At two depths z the two equations are solved for x and y by
//! Cramer's rule; the ray points from the nearer to the farther solution, and the transpose of the
//! view's rotation maps it to world space.

use super::camera::Sight;
use super::double_double::DoubleDouble;
use super::picture::TruthPicture;
use fbptr_core::scene::Sky;
use glam::DVec3;

/// Returns the world direction at the centre of pixel (x, y).
fn ray(sight: &Sight, x: i64, y: i64) -> DVec3 {
    let [a, b] = sight.ndc_of_pixel(x, y);
    let r = &sight.projection;
    let row = |k: usize, ndc: DoubleDouble| -> [DoubleDouble; 4] {
        std::array::from_fn(|c| r[k][c] - ndc * r[3][c])
    };
    let (first, second) = (row(0, a), row(1, b));
    let at = |z: DoubleDouble| {
        let (p, q) = (first[2] * z + first[3], second[2] * z + second[3]);
        let determinant = first[0] * second[1] - first[1] * second[0];
        let x = (first[1] * q - second[1] * p) / determinant;
        let y = (second[0] * p - first[0] * q) / determinant;
        [x, y, z]
    };
    let (near, far) = (at(-DoubleDouble::ONE), at(-DoubleDouble::new(2.0)));
    let along: [DoubleDouble; 3] = std::array::from_fn(|c| far[c] - near[c]);
    let world = |c: usize| (0..3).fold(DoubleDouble::ZERO, |sum, k| sum + sight.view[k][c] * along[k]);
    DVec3::new(world(0).to_f64(), world(1).to_f64(), world(2).to_f64())
}

impl TruthPicture {
    /// Paints a sky over the pixels of x0..x1, y0..y1.
    pub(super) fn paint_sky(&mut self, [x0, x1, y0, y1]: [i64; 4], sight: &Sight, sky: &Sky) {
        for y in y0..y1 {
            for x in x0..x1 {
                self.paint_pixel(x, y, sky.color(ray(sight, x, y)), sky.opacity);
            }
        }
    }
}

//! Position and orientation of the eye: navigation in R^N.
//!
//! x_eye = R^T (x - o). R starts as the identity; a rotation [a,b,angle] turns the eye's own frame,
//! columns of R: e_a -> cos e_a + sin e_b, e_b -> -sin e_a + cos e_b. Multiples of 90 degrees are
//! exact, and the columns are orthonormalised after each step, so that rounding does not accumulate
//! over a long navigation.
//!
//! A pose is stored as its list of rotations, so a viewer shows exactly, to the bit, the picture
//! that the JSON with that list gives.

use super::error::EyeError;
use super::validate::{finite_point, in_range};

/// A rotation in the plane of the eye's own axes `a` and `b`, from `a` towards `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// First axis.
    pub a: usize,
    /// Second axis.
    pub b: usize,
    /// Angle in degrees.
    pub angle_deg: f64,
}

/// Position and rotations of the eye, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Position of the eye.
    pub position: Vec<f64>,
    /// Rotations, in order, each in the frame that the earlier ones produced.
    pub rotations: Vec<Rotation>,
}

impl Pose {
    /// Returns the pose at the origin, not rotated.
    pub fn identity(dim: usize) -> Self {
        Pose { position: vec![0.0; dim], rotations: Vec::new() }
    }

    /// Returns the eye's axes: entry j is R e_j, the j-th axis in world coordinates.
    pub fn axes(&self) -> Vec<Vec<f64>> {
        let dim = self.position.len();
        let mut axes: Vec<Vec<f64>> =
            (0..dim).map(|j| (0..dim).map(|i| f64::from(u8::from(i == j))).collect()).collect();
        for rotation in &self.rotations {
            let (sin, cos) = sin_cos_deg(rotation.angle_deg);
            for i in 0..dim {
                let (x, y) = (axes[rotation.a][i], axes[rotation.b][i]);
                axes[rotation.a][i] = cos * x + sin * y;
                axes[rotation.b][i] = cos * y - sin * x;
            }
            orthonormalise(&mut axes);
        }
        axes
    }

    /// Moves the eye by `distance` along its own axis `axis` (0 forward, 1 left, 2 up, ...).
    ///
    /// # Panics
    /// Panics if `axis` is not below the dimension.
    pub fn advance(&mut self, axis: usize, distance: f64) {
        let direction = &self.axes()[axis];
        for (x, step) in self.position.iter_mut().zip(direction) {
            *x += distance * step;
        }
    }

    /// Rotates the eye in the plane of its axes `a` and `b`. Consecutive rotations in one plane are
    /// merged into one.
    ///
    /// # Panics
    /// Panics unless `a` and `b` are two different axes below the dimension.
    pub fn turn(&mut self, a: usize, b: usize, angle_deg: f64) {
        let dim = self.position.len();
        assert!(a != b && a < dim && b < dim, "a plane of two axes below {dim}");
        match self.rotations.last_mut() {
            Some(last) if (last.a, last.b) == (a, b) => last.angle_deg = (last.angle_deg + angle_deg) % 360.0,
            Some(last) if (last.a, last.b) == (b, a) => last.angle_deg = (last.angle_deg - angle_deg) % 360.0,
            _ => self.rotations.push(Rotation { a, b, angle_deg: angle_deg % 360.0 }),
        }
        self.rotations.retain(|r| r.angle_deg != 0.0);
    }

    /// Rotates the eye as [`Pose::turn`] does, and moves it so that the point `middle` stays where it
    /// is in the eye's own frame.
    ///
    /// # Panics
    /// As [`Pose::turn`], and unless `middle` has the eye's dimension.
    pub fn turn_about(&mut self, middle: &[f64], a: usize, b: usize, angle_deg: f64) {
        assert_eq!(middle.len(), self.position.len(), "a point of the eye's space");
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let along: Vec<f64> =
            self.axes().iter().map(|axis| dot(axis, middle) - dot(axis, &self.position)).collect();
        self.turn(a, b, angle_deg);
        self.position = middle.to_vec();
        for (axis, length) in self.axes().iter().zip(along) {
            self.position.iter_mut().zip(axis).for_each(|(x, e)| *x -= length * e);
        }
    }

    /// Returns every plane of rotation of R^N as a pair of axes, those of visible axes first.
    pub fn planes(dim: usize) -> Vec<[usize; 2]> {
        (1..dim).flat_map(|b| (0..b).map(move |a| [a, b])).collect()
    }

    /// Validates the pose for a space of `dim` dimensions.
    pub(super) fn check(&self, dim: usize) -> Result<(), EyeError> {
        finite_point("eye.position", &self.position, dim)?;
        for (i, r) in self.rotations.iter().enumerate() {
            for (j, axis) in [r.a, r.b].into_iter().enumerate() {
                in_range(format!("eye.rotations[{i}][{j}]"), axis as f64, axis < dim, || {
                    format!("an axis from 0 to {}", dim - 1)
                })?;
            }
            in_range(format!("eye.rotations[{i}][1]"), r.b as f64, r.a != r.b, || {
                "another axis than the first".into()
            })?;
            in_range(format!("eye.rotations[{i}][2]"), r.angle_deg, r.angle_deg.is_finite(), || {
                "a finite angle".into()
            })?;
        }
        Ok(())
    }
}

/// Returns sine and cosine of an angle in degrees; exact at multiples of 90.
pub fn sin_cos_deg(angle_deg: f64) -> (f64, f64) {
    let reduced = angle_deg % 360.0;
    let quarter = (reduced / 90.0).round();
    let (sin, cos) = libm::sincos((reduced - 90.0 * quarter) * (std::f64::consts::PI / 180.0));
    match quarter.rem_euclid(4.0) as u8 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Orthonormalises by Gram-Schmidt, in the order of the axes; exact for a frame of unit axes.
fn orthonormalise(axes: &mut [Vec<f64>]) {
    for j in 0..axes.len() {
        let (done, rest) = axes.split_at_mut(j);
        let current = &mut rest[0];
        for other in done {
            let along: f64 = current.iter().zip(&*other).map(|(x, y)| x * y).sum();
            current.iter_mut().zip(&*other).for_each(|(x, y)| *x -= along * y);
        }
        let norm = current.iter().map(|x| x * x).sum::<f64>().sqrt();
        current.iter_mut().for_each(|x| *x /= norm);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact() {
        for (angle, want) in
            [(0.0, (0.0, 1.0)), (90.0, (1.0, 0.0)), (-90.0, (-1.0, 0.0)), (180.0, (0.0, -1.0))]
        {
            for turns in [-720.0, 0.0, 3600.0] {
                assert_eq!(sin_cos_deg(angle + turns), want, "{angle} + {turns}");
            }
        }
        let (sin, cos) = sin_cos_deg(30.0);
        assert!((sin - 0.5).abs() < 1e-15 && (cos - 0.75f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn a_quarter_turn_to_the_left_looks_along_y() {
        let mut pose = Pose::identity(3);
        pose.turn(0, 1, 90.0);
        assert_eq!(pose.axes(), [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        pose.advance(0, 2.5);
        assert_eq!(pose.position, [0.0, 2.5, 0.0]);
    }

    #[test]
    fn turns_in_one_plane_become_one_and_cancel() {
        let mut pose = Pose::identity(4);
        for _ in 0..18 {
            pose.turn(0, 3, 5.0);
        }
        assert_eq!(pose.rotations, [Rotation { a: 0, b: 3, angle_deg: 90.0 }]);
        pose.turn(3, 0, 90.0);
        assert_eq!(pose.rotations, []);
    }

    #[test]
    fn a_long_walk_keeps_the_axes_orthonormal() {
        let mut pose = Pose::identity(5);
        for step in 0..2000 {
            pose.turn(step % 5, (step * 3 + 1 + usize::from(step % 5 == (step * 3 + 1) % 5)) % 5, 7.3);
        }
        let axes = pose.axes();
        for i in 0..5 {
            for j in 0..5 {
                let product: f64 = axes[i].iter().zip(&axes[j]).map(|(x, y)| x * y).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14, "{i} {j} {product}");
            }
        }
        assert_eq!(Pose::planes(5).len(), 10);
    }
}

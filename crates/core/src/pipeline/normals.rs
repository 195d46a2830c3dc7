//! Normals of faces and vertices, and their transformation to world space.
//!
//! In: object-space positions and polygons. Out: unit normals, in object space until
//! [`NormalMatrix`] transforms them. A vertex is a position index; its normal is the equal-weight
//! mean of the unit normals of its polygons, normalized again (notes 000: a sum of unit normals is
//! not one). Polygons without area do not count; a mean that vanishes yields no normal.

use crate::cancel::CancelToken;
use crate::math::matrix::unit;
use crate::scene::Mesh;
use glam::{DMat3, DMat4, DVec3};

/// Length per face below which a sum of unit normals has cancelled: the rest is rounding error.
const CANCELLED: f64 = 1e-12;

/// Polygons between two checks of the cancel token.
const POLYGONS_AT_ONCE: usize = 4096;

/// Returns the unit normal of a polygon by Newell's method, on its counter-clockwise side. Returns
/// `None` without area, or if the extent is not finite.
#[doc(hidden)]
pub fn polygon_normal(points: impl Iterator<Item = DVec3> + Clone) -> Option<DVec3> {
    let origin = points.clone().next()?;
    // Scaled to 1, so that neither huge nor tiny polygons over- or underflow.
    let extent = points.clone().fold(0.0f64, |m, p| m.max((p - origin).abs().max_element()));
    if !(extent > 0.0 && extent.is_finite()) {
        return None;
    }
    let mut last = DVec3::ZERO;
    let mut sum = DVec3::ZERO;
    for p in points.skip(1) {
        let p = (p - origin) / extent;
        sum += last.cross(p);
        last = p;
    }
    unit(sum)
}

/// Object-space unit normals per polygon and per position.
#[derive(Debug, Default)]
pub(crate) struct Normals {
    /// Zero for a polygon without area.
    pub of_polygon: Vec<DVec3>,
    /// Zero where there is none; empty if means were not requested.
    pub of_position: Vec<DVec3>,
}

impl Normals {
    /// Computes the polygons' normals and, if `smooth`, the means at the positions. Returns empty
    /// lists when it is cancelled.
    pub fn of(mesh: &Mesh, smooth: bool, cancel: &CancelToken) -> Self {
        let corners = |p: &crate::scene::Polygon| {
            &mesh.corners[p.first_corner as usize..p.first_corner as usize + p.corner_count as usize]
        };
        let point = |c: &crate::scene::Corner| mesh.positions[c.position as usize];
        let mut of_polygon: Vec<DVec3> = Vec::with_capacity(mesh.polygons.len());
        for some in mesh.polygons.chunks(POLYGONS_AT_ONCE) {
            if cancel.is_cancelled() {
                return Normals::default();
            }
            let normal = |p| polygon_normal(corners(p).iter().map(point)).unwrap_or(DVec3::ZERO);
            of_polygon.extend(some.iter().map(normal));
        }
        if !smooth {
            return Normals { of_polygon, of_position: Vec::new() };
        }
        let mut sums = vec![(DVec3::ZERO, 0u32); mesh.positions.len()];
        // A polygon counts once at each of its positions, even if it visits one repeatedly.
        let mut last_seen = vec![u32::MAX; mesh.positions.len()];
        for (i, (p, &n)) in mesh.polygons.iter().zip(&of_polygon).enumerate() {
            if i % POLYGONS_AT_ONCE == 0 && cancel.is_cancelled() {
                return Normals::default();
            }
            if n == DVec3::ZERO {
                continue;
            }
            for c in corners(p) {
                let at = c.position as usize;
                if last_seen[at] != i as u32 {
                    last_seen[at] = i as u32;
                    sums[at].0 += n;
                    sums[at].1 += 1;
                }
            }
        }
        let mean = |(sum, count): (DVec3, u32)| {
            let stands = sum.length() > CANCELLED * count as f64;
            Some(sum).filter(|_| stands).and_then(unit).unwrap_or(DVec3::ZERO)
        };
        Normals { of_polygon, of_position: sums.into_iter().map(mean).collect() }
    }
}

/// Inverse transpose of a model matrix, up to a positive factor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NormalMatrix(DMat3);

impl NormalMatrix {
    /// Computes the normal matrix of a model matrix, singular or not.
    pub fn of(model: &DMat4) -> Self {
        let m = DMat3::from_mat4(*model);
        // Scaled to 1 first: the cofactors are products of two entries.
        let size = m.to_cols_array().iter().fold(0.0f64, |a, v| a.max(v.abs()));
        let m = if size > 0.0 { m * (1.0 / size) } else { m };
        // inverse transpose = cofactors / determinant; a singular model has no inverse but still
        // has cofactors.
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        NormalMatrix(if m.determinant() < 0.0 { cofactors * -1.0 } else { cofactors })
    }

    /// Returns the unit world normal of an object-space normal; `None` if it has no direction.
    pub fn apply(&self, normal: DVec3) -> Option<DVec3> {
        unit(self.0 * unit(normal)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cancel::NEVER;
    use crate::math::matrix;

    #[test]
    fn a_polygon_of_any_size_anywhere_has_its_normal() {
        for size in [1e-300, 1e-150, 1.0, 1e150, 1e300] {
            for at in [DVec3::ZERO, DVec3::new(3.0, -2.0, 1.0) * size, DVec3::new(0.0, 0.0, 1.7e308)] {
                let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                    .map(|[x, y]| at + DVec3::new(x, y, 0.0) * size);
                assert_eq!(polygon_normal(points.into_iter()), Some(DVec3::Z), "{size:e} at {at}");
                assert_eq!(polygon_normal(points.into_iter().rev()), Some(-DVec3::Z), "{size:e} at {at}");
            }
        }
        let line = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        assert_eq!(polygon_normal(line.into_iter()), None);
    }

    #[test]
    fn a_mean_of_equal_weights_and_one_that_cancels() {
        // Two big faces and a tiny one at position 0: their weights are equal nevertheless.
        let p = [[0., 0., 0.], [9., 0., 0.], [0., 9., 0.], [0., 0., 1e-3], [0., 1e-3, 0.]].map(DVec3::from);
        let mesh = Mesh::from_triangles(p.to_vec(), &[[0, 1, 2], [0, 4, 3], [0, 0, 1]]);
        let n = Normals::of(&mesh, true, &NEVER);
        assert_eq!(n.of_polygon, [DVec3::Z, DVec3::X, DVec3::ZERO]);
        assert!((n.of_position[0] - DVec3::new(0.5f64.sqrt(), 0.0, 0.5f64.sqrt())).length() < 1e-15);
        let mesh = Mesh::from_triangles(p.to_vec(), &[[0, 1, 2], [0, 2, 1]]);
        assert_eq!(Normals::of(&mesh, true, &NEVER).of_position[1], DVec3::ZERO);
    }

    #[test]
    fn normals_stay_perpendicular_under_any_model() {
        for model in [
            matrix::scale(DVec3::new(1.0, 5.0, -0.1)),
            matrix::shear(0.3, 0.0, -1.0, 0.0, 0.0, 2.0),
            matrix::scale(DVec3::splat(1e-180)),
        ] {
            let (a, b) = (DVec3::new(1.0, 2.0, 0.5), DVec3::new(-1.0, 0.3, 2.0));
            let n = NormalMatrix::of(&model).apply(a.cross(b)).unwrap();
            for t in [a, b] {
                let t = unit(model.transform_vector3(t)).unwrap();
                assert!(n.dot(t).abs() < 1e-15, "{model}");
            }
        }
        // A mirror keeps normals outward: that of a box's face x = 1 points away from its middle.
        let mirror = NormalMatrix::of(&matrix::scale(DVec3::new(-1.0, 1.0, 1.0)));
        assert_eq!(mirror.apply(DVec3::X), Some(-DVec3::X));
        assert_eq!(NormalMatrix::of(&DMat4::ZERO).apply(DVec3::X), None);
    }
}

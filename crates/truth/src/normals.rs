//! Normals by the rules of the specification, in object and world space.
//!
//! Each polygon has one normal. At a vertex (an index into the positions) the normal is the
//! equal-weight mean of its polygons' unit normals, normalised. Normals of the file take
//! precedence. Zero-area polygons do not count; if the mean vanishes, the face's normal is used.
//! Normals are transformed to world space by the inverse transpose, so that the outside of a
//! mirrored model stays outside.

use fbptr_core::math::matrix::unit;
use fbptr_core::scene::{Mesh, NONE};
use glam::{DMat3, DMat4, DVec3};

/// Length below which a sum of unit normals has no direction.
const VANISHING: f64 = 1e-9;

/// Normals of a mesh in object space.
#[derive(Clone, Debug)]
pub struct Normals {
    /// Unit normal of each polygon; zero for a polygon without area.
    pub polygon: Vec<DVec3>,
    /// Unit mean at each position; zero if it vanishes.
    pub vertex: Vec<DVec3>,
}

impl Normals {
    /// Computes the normals of all polygons and vertices of a mesh.
    pub fn new(mesh: &Mesh) -> Normals {
        let corners_of = |p: &fbptr_core::scene::Polygon| {
            let first = p.first_corner as usize;
            &mesh.corners[first..first + p.corner_count as usize]
        };
        let polygon: Vec<DVec3> = mesh
            .polygons
            .iter()
            .map(|p| {
                let at: Vec<DVec3> =
                    corners_of(p).iter().map(|c| mesh.positions[c.position as usize]).collect();
                area_normal(&at)
            })
            .collect();
        let mut vertex = vec![DVec3::ZERO; mesh.positions.len()];
        for (p, &n) in mesh.polygons.iter().zip(&polygon) {
            let mut met: Vec<u32> = corners_of(p).iter().map(|c| c.position).collect();
            met.sort_unstable();
            met.dedup();
            for position in met {
                vertex[position as usize] += n;
            }
        }
        for n in &mut vertex {
            *n = if n.length() < VANISHING { DVec3::ZERO } else { unit(*n).unwrap_or(DVec3::ZERO) };
        }
        Normals { polygon, vertex }
    }

    /// Returns the object-space normal at a corner: the file's, else the vertex's, else `face`.
    pub fn at_corner(&self, mesh: &Mesh, corner: usize, face: DVec3) -> DVec3 {
        let c = &mesh.corners[corner];
        if c.normal != NONE {
            return unit(mesh.normals[c.normal as usize]).unwrap_or(face);
        }
        let mean = self.vertex[c.position as usize];
        if mean == DVec3::ZERO { face } else { mean }
    }
}

/// Returns the unit normal of a polygon: its area vector is half the sum of cross products from its
/// first corner.
pub fn area_normal(points: &[DVec3]) -> DVec3 {
    // Scaled by the largest edge, so that neither huge nor tiny polygons lose their direction.
    let edges: Vec<DVec3> = points.iter().map(|p| *p - points[0]).collect();
    let largest = edges.iter().fold(0.0, |m: f64, e| m.max(e.abs().max_element()));
    if !(largest > 0.0 && largest.is_finite()) {
        return DVec3::ZERO;
    }
    let sum: DVec3 = edges.windows(2).map(|w| (w[0] / largest).cross(w[1] / largest)).sum();
    unit(sum).unwrap_or(DVec3::ZERO)
}

/// Returns the inverse transpose of a model matrix up to a positive factor: its cofactors times the
/// sign of its determinant.
///
/// Unlike the inverse it exists for a flattened model too, with the normal of its plane.
pub fn normal_matrix(model: &DMat4) -> DMat3 {
    let m = DMat3::from_mat4(*model);
    // Normals have no length: the common scale is removed before products can overflow.
    let largest = m.to_cols_array().iter().fold(0.0, |a: f64, c| a.max(c.abs()));
    let m = if largest > 0.0 && largest.is_finite() { m * (1.0 / largest) } else { m };
    let cofactors =
        DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if is_mirrored(model) { cofactors * -1.0 } else { cofactors }
}

/// Returns whether the model reverses handedness.
pub fn is_mirrored(model: &DMat4) -> bool {
    let m = DMat3::from_mat4(*model);
    let largest = m.to_cols_array().iter().fold(0.0, |a: f64, c| a.max(c.abs()));
    largest > 0.0 && (m * (1.0 / largest)).determinant() < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::scene::Corner;

    fn corner(position: u32) -> Corner {
        Corner { position, normal: NONE, texcoord: NONE, color: NONE }
    }

    #[test]
    fn a_mean_counts_each_polygon_once_and_forgets_flat_ones() {
        // A square in z = 0 and a triangle in x = 0 that share an edge; a zero-area triangle beside
        // them.
        let positions =
            [[0., 0., 0.], [0., 1., 0.], [-1., 1., 0.], [-1., 0., 0.], [0., 0., 1.], [0., 2., 0.]]
                .map(DVec3::from_array);
        let mut mesh = Mesh { positions: positions.to_vec(), ..Mesh::default() };
        mesh.push_polygon(&[0, 1, 2, 3].map(corner), NONE);
        mesh.push_polygon(&[0, 4, 1].map(corner), NONE);
        mesh.push_polygon(&[0, 1, 5].map(corner), NONE);
        let n = Normals::new(&mesh);
        assert_eq!(n.polygon, [DVec3::Z, DVec3::NEG_X, DVec3::ZERO]);
        let half = 0.5f64.sqrt();
        assert!((n.vertex[0] - DVec3::new(-half, 0.0, half)).length() < 1e-15);
        assert_eq!(n.vertex[2], DVec3::Z);
        assert_eq!(n.vertex[5], DVec3::ZERO);
        assert_eq!(n.at_corner(&mesh, 9, DVec3::Y), DVec3::Y);
    }

    #[test]
    fn mirrored_normals_still_point_out() {
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert!(is_mirrored(&mirror));
        assert_eq!(unit(normal_matrix(&mirror) * DVec3::X), Some(DVec3::NEG_X));
        assert_eq!(unit(normal_matrix(&mirror) * DVec3::Z), Some(DVec3::Z));
        let flat = DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(unit(normal_matrix(&flat) * DVec3::new(0.6, 0.0, 0.8)), Some(DVec3::Z));
        // x stretched by 2: the normal of x + y = 1 tilts towards y.
        let n = normal_matrix(&DMat4::from_scale(DVec3::new(2.0, 1.0, 1.0))) * DVec3::new(1.0, 1.0, 0.0);
        assert!((n.y / n.x - 2.0).abs() < 1e-15);
    }
}

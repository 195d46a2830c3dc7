//! Extent of a mesh in space, and how many pixels its faces can cover.
//!
//! In: a mesh whose indices are valid. Out: its box and the sum of its faces' areas, measured once;
//! from them and a projection, upper bounds of the pixels that the faces cover. The bounds are right
//! if no view of the mesh covers more: a face covers its area in space at most, times the largest
//! scale that the projection gives it in the mesh's box.

use crate::scene::Mesh;
use glam::{DMat4, DVec3};

/// Upper bounds of the pixels that the faces of a mesh cover.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoverageBound {
    /// Number of pixels, those that several faces cover counted for each.
    pub covered: f64,
    /// Number of pixels in the box around all faces on the screen.
    pub boxed: f64,
}

/// Extent of a mesh in object space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshExtent {
    /// Low and high corner of the box around all positions.
    bounds: [DVec3; 2],
    /// Sum of the faces' areas.
    area: f64,
}

impl MeshExtent {
    /// Measures a mesh, in time linear in its faces. `bounds` are the corners of the box around its
    /// positions.
    pub fn of(mesh: &Mesh, bounds: [DVec3; 2]) -> Self {
        let position = |corner: u32| mesh.positions[mesh.corners[corner as usize].position as usize];
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(position);
            (b - a).cross(c - a).length() / 2.0
        };
        MeshExtent { bounds, area: mesh.triangles.iter().map(area).sum() }
    }

    /// Returns upper bounds of the pixels that the faces cover, in a viewport of `view` pixels;
    /// `None` if they may reach the eye's plane.
    pub fn coverage(&self, to_clip: &DMat4, view: [f64; 2]) -> Option<CoverageBound> {
        let (mut nearest, mut low, mut high) = (f64::INFINITY, [f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in 0..8 {
            let side = |axis: usize| self.bounds[corner >> axis & 1][axis];
            let clip = *to_clip * DVec3::new(side(0), side(1), side(2)).extend(1.0);
            if !clip.is_finite() || clip.w <= 0.0 {
                return None;
            }
            nearest = nearest.min(clip.w);
            for axis in 0..2 {
                let at = (clip[axis] / clip.w).clamp(-1.0, 1.0);
                (low[axis], high[axis]) = (low[axis].min(at), high[axis].max(at));
            }
        }
        // The derivative of x / w is (dx - x / w dw) / w, and |x / w| is at most `reach` where the
        // faces are seen.
        let scale = |axis: usize| {
            let reach = low[axis].abs().max(high[axis].abs());
            let [row, w] = [axis, 3].map(|row| to_clip.row(row).truncate().length());
            (row + reach * w) / nearest * view[axis] / 2.0
        };
        let side = |axis: usize| (high[axis] - low[axis]) * view[axis] / 2.0 + 1.0;
        Some(CoverageBound { covered: self.area * scale(0) * scale(1), boxed: side(0) * side(1) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, LookAt, Projection, shapes};

    fn knot() -> Mesh {
        shapes::knot(120, 24).unwrap()
    }

    fn extent_of(mesh: &Mesh) -> MeshExtent {
        MeshExtent::of(mesh, mesh.bounds().unwrap().into())
    }

    /// Returns the projection of an eye at `from` on the z axis, onto 400x300 pixels.
    fn seen_from(from: f64, projection: Projection) -> DMat4 {
        let look_at = LookAt { eye: DVec3::new(0.0, 0.0, from), ..Camera::default().look_at };
        let matrices = Camera { look_at, projection }.matrices(4.0 / 3.0).unwrap();
        matrices.projection * matrices.view
    }

    #[test]
    fn no_view_of_a_mesh_covers_more_pixels_than_the_bound() {
        let mesh = knot();
        let extent = extent_of(&mesh);
        let view = [400.0, 300.0];
        let parallel = Projection::Ortho { window: [-4.0, 4.0, -3.0, 3.0], near: 0.1, far: 100.0 };
        for projection in [Camera::default().projection, parallel] {
            for (from, turn) in [(5.0, 0.0), (5.0, 1.1), (8.0, 0.4), (20.0, 2.0)] {
                let to_clip = seen_from(from, projection) * DMat4::from_rotation_x(turn);
                let bound = extent.coverage(&to_clip, view).unwrap();
                let on_screen = |corner: u32| {
                    let clip =
                        to_clip * mesh.positions[mesh.corners[corner as usize].position as usize].extend(1.0);
                    [0, 1].map(|axis| clip[axis] / clip.w * view[axis] / 2.0)
                };
                let mut covered = 0.0;
                for triangle in &mesh.triangles {
                    let [a, b, c] = triangle.map(on_screen);
                    covered += ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs() / 2.0;
                }
                // Pixels beyond the viewport are not bounded; these views have none.
                assert!(covered <= bound.covered, "{from} {turn}: {covered} {bound:?}");
                assert!(bound.covered < 12.0 * covered, "{from} {turn}: {covered} {bound:?}");
            }
        }
    }

    #[test]
    fn a_mesh_around_the_eye_has_no_bound() {
        let extent = extent_of(&knot());
        assert!(extent.coverage(&seen_from(0.5, Camera::default().projection), [400.0, 300.0]).is_none());
    }
}

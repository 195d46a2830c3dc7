//! Extent of a mesh in space, and how many pixels its faces can cover.
//!
//! In: a mesh whose indices are valid. Out: its box, the sum of its faces' areas and that of their
//! edges' lengths, measured once; from them and a projection, upper bounds of the pixels that the
//! faces cover. The bounds are right if no view of the mesh covers more. A face has its area and
//! perimeter in space at most, times the largest scales that the projection has in the mesh's box;
//! and a convex figure of area A and perimeter P holds at most A + P/2 + 1 points of a grid.

use super::ndc_box::{ClipTransform, NdcBox};
use crate::scene::Mesh;
use glam::DVec3;

/// Upper bounds of the pixels that the faces of a mesh cover.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct CoverageBound {
    /// Number of pixels; one under several faces counts once for each of them.
    pub covered: f64,
    /// Sum of the faces' perimeters, in pixels.
    pub perimeter: f64,
    /// Number of pixels in the box around all faces on the screen.
    pub boxed: f64,
}

/// Extent of a mesh in object space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshExtent {
    /// Low and high corner of the box around all positions.
    bounds: (DVec3, DVec3),
    /// Sum of the faces' areas.
    area: f64,
    /// Sum of the faces' perimeters.
    perimeter: f64,
    /// Number of faces.
    faces: f64,
}

impl MeshExtent {
    /// Measures a mesh whose indices are valid, in time linear in its faces. `bounds` are the corners
    /// of the box around its positions.
    pub fn of(mesh: &Mesh, bounds: (DVec3, DVec3)) -> Self {
        let position = |corner: u32| mesh.positions[mesh.corners[corner as usize].position as usize];
        let (mut area, mut perimeter) = (0.0, 0.0);
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(position);
            area += (b - a).cross(c - a).length() / 2.0;
            perimeter += a.distance(b) + b.distance(c) + c.distance(a);
        }
        MeshExtent { bounds, area, perimeter, faces: mesh.triangles.len() as f64 }
    }

    /// Returns upper bounds of the pixels that the faces cover, in a viewport of `view` pixels;
    /// `None` if they may reach the eye's plane.
    pub fn coverage(&self, to_clip: &ClipTransform, view: [f64; 2]) -> Option<CoverageBound> {
        let seen = NdcBox::of(self.bounds, to_clip)?;
        // The gradient of x / w is (dx - x / w dw) / w, and |x / w| is at most `reach` where the faces
        // are seen. These rows are in pixels.
        let half = view.map(|side| side / 2.0);
        let row = |row: usize, scale: f64| to_clip.matrix().row(row).truncate() * scale;
        let (x, y, w) = (row(0, half[0]), row(1, half[1]), row(3, 1.0));
        let reach = [0, 1].map(|axis| seen.low[axis].abs().max(seen.high[axis].abs()) * half[axis]);
        let scales = [x.length() + reach[0] * w.length(), y.length() + reach[1] * w.length()];
        // A length grows by the root of the largest eigenvalue of the gradients' products at most.
        let product = x.dot(y).abs()
            + reach[1] * x.dot(w).abs()
            + reach[0] * y.dot(w).abs()
            + reach[0] * reach[1] * w.length_squared();
        let squares = scales.map(|scale| scale * scale);
        let length_scale =
            ((squares[0] + squares[1]) / 2.0 + f64::hypot((squares[0] - squares[1]) / 2.0, product)).sqrt();
        let (nearest, boxed) = (seen.nearest_w, seen.pixels(view));
        let perimeter = self.perimeter * length_scale / nearest;
        let covered = self.area * scales[0] * scales[1] / (nearest * nearest) + perimeter / 2.0 + self.faces;
        Some(CoverageBound { covered: covered.min(boxed * self.faces), perimeter, boxed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, LookAt, Projection, shapes};
    use glam::{DMat4, DVec2};

    fn knot() -> Mesh {
        shapes::knot(120, 24).unwrap()
    }

    fn extent_of(mesh: &Mesh) -> MeshExtent {
        MeshExtent::of(mesh, mesh.bounds().unwrap())
    }

    /// Returns the transform of an eye at `from` on the z axis, onto 400x300 pixels.
    fn seen_from(from: f64, projection: Projection) -> ClipTransform {
        let look_at = LookAt { eye: DVec3::new(0.0, 0.0, from), ..Camera::default().look_at };
        ClipTransform::of(&Camera { look_at, projection }.matrices(4.0 / 3.0).unwrap())
    }

    /// Returns the sums of the faces' areas and perimeters in a view of these pixels.
    fn drawn(mesh: &Mesh, to_clip: &ClipTransform, view: [f64; 2]) -> [f64; 2] {
        let on_screen = |corner: u32| {
            let position = mesh.positions[mesh.corners[corner as usize].position as usize];
            let clip = *to_clip.matrix() * position.extend(1.0);
            DVec2::new(clip.x / clip.w * view[0] / 2.0, clip.y / clip.w * view[1] / 2.0)
        };
        let (mut area, mut perimeter) = (0.0, 0.0);
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(on_screen);
            area += (b - a).perp_dot(c - a).abs() / 2.0;
            perimeter += a.distance(b) + b.distance(c) + c.distance(a);
        }
        [area, perimeter]
    }

    #[test]
    fn no_view_of_a_mesh_covers_more_pixels_than_the_bound() {
        let mesh = knot();
        let (extent, view) = (extent_of(&mesh), [400.0, 300.0]);
        let parallel = Projection::Ortho { window: [-4.0, 4.0, -3.0, 3.0], near: 0.1, far: 100.0 };
        // Pixels beyond the viewport are not bounded; these views have none.
        for projection in [Camera::default().projection, parallel] {
            for (from, turn) in [(5.0, 0.0), (5.0, 1.1), (8.0, 0.4), (20.0, 2.0)] {
                let to_clip = seen_from(from, projection).after(&DMat4::from_rotation_x(turn));
                let bound = extent.coverage(&to_clip, view).unwrap();
                let [area, perimeter] = drawn(&mesh, &to_clip, view);
                let covered = area + perimeter / 2.0 + extent.faces;
                assert!(covered <= bound.covered, "{from} {turn}: {covered} {bound:?}");
                assert!(bound.covered < 12.0 * covered, "{from} {turn}: {covered} {bound:?}");
                assert!(perimeter <= bound.perimeter && bound.perimeter < 5.0 * perimeter, "{bound:?}");
            }
        }
    }

    #[test]
    fn lengths_along_both_axes_are_bounded() {
        // A needle along x that is scaled, and then turned onto the diagonal.
        let corners = [DVec3::ZERO, DVec3::X * 1e-3, DVec3::new(0.0, 1e-9, 0.0)];
        let mesh = Mesh::from_triangles(corners.to_vec(), &[[0, 1, 2]]);
        let view = [400.0, 400.0];
        let (turn, scale) = (DMat4::from_rotation_z(0.785), DMat4::from_scale(DVec3::new(1e3, 1.0, 1.0)));
        let to_clip = ClipTransform::of_projection(turn * scale);
        let [_, perimeter] = drawn(&mesh, &to_clip, view);
        let bound = extent_of(&mesh).coverage(&to_clip, view).unwrap();
        assert!(perimeter <= bound.perimeter && bound.perimeter < 1.01 * perimeter, "{perimeter} {bound:?}");
        // At the corner of a wide view both axes grow towards the corner.
        let wide = Projection::Perspective { fov_rad: 2.6, near: 0.01, far: 100.0, on_smaller_side: true };
        let to_clip = ClipTransform::of(
            &Camera { look_at: LookAt { eye: DVec3::Z, ..Camera::default().look_at }, projection: wide }
                .matrices(1.0)
                .unwrap(),
        );
        let corners =
            [DVec3::new(3.4, 3.4, 0.0), DVec3::new(3.4, 3.4, 0.05), DVec3::new(3.4, 3.4 + 1e-9, 0.0)];
        let mesh = Mesh::from_triangles(corners.to_vec(), &[[0, 1, 2]]);
        let [_, perimeter] = drawn(&mesh, &to_clip, view);
        let bound = extent_of(&mesh).coverage(&to_clip, view).unwrap();
        assert!(perimeter <= bound.perimeter, "{perimeter} {bound:?}");
    }

    #[test]
    fn slivers_cover_a_pixel_for_each_of_their_length() {
        // A face of 300 x 0.02 pixels along a row of centres covers 150 of them.
        let sliver = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.5, 1e-4, 0.0)];
        let mesh = Mesh::from_triangles(sliver.to_vec(), &[[0, 1, 2]]);
        let to_clip = ClipTransform::of_projection(DMat4::IDENTITY);
        let bound = extent_of(&mesh).coverage(&to_clip, [400.0, 400.0]).unwrap();
        assert!(bound.covered >= 300.0 && bound.covered < 450.0, "{bound:?}");
        assert!(bound.perimeter >= 600.0 && bound.perimeter < 900.0, "{bound:?}");
    }

    #[test]
    fn a_mesh_around_the_eye_has_no_bound() {
        let extent = extent_of(&knot());
        assert!(extent.coverage(&seen_from(0.5, Camera::default().projection), [400.0, 300.0]).is_none());
    }
}

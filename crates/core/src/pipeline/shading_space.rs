//! Shading space, in which the vector kernels compute colours, and the view ray of each pixel in it.
//!
//! Its origin is the eye (the mesh's centre for parallel projections). Its axes are the mesh's own
//! if the model only rotates, translates and scales uniformly, so that normals need no
//! transformation, and those of world space otherwise.

use super::vertex::Transform;
use glam::{DMat3, DVec3};

/// Limit of values whose squares f32 can represent.
const LARGEST: f64 = 1e15;

/// Reconstruction of a pixel's position in shading space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// Eye-relative position = (ray 0 + ray 1 * column + ray 2 * row) * w; V points back along it.
    Perspective {
        /// Ray at pixel (0,0), and its steps per column and per row.
        ray: [[f32; 3]; 3],
    },
    /// The viewer is at the origin; positions are interpolated from the vertices.
    Interpolated,
    /// V is constant; positions are interpolated from the vertices.
    Parallel {
        /// Unit vector towards the viewer.
        to_viewer: [f32; 3],
    },
}

/// Shading space of a draw.
pub(crate) struct ShadingSpace {
    /// Rotation from world to shading axes.
    pub axes: DMat3,
    /// Origin in world space.
    pub origin: DVec3,
    /// True if the mesh's normals are valid in this space as they are.
    pub has_own_normals: bool,
    /// Source of view rays: direction to the viewer, or the rays of pixels.
    pub eye: Eye,
    /// True if f32 represents positions and rays in this space; otherwise `eye` is meaningless.
    pub is_in_range: bool,
}

impl ShadingSpace {
    /// Creates the shading space of a mesh with these bounds in object space.
    pub fn new(t: &Transform, bounds: Option<(DVec3, DVec3)>) -> Self {
        let linear = DMat3::from_mat4(t.model);
        let own = evenly_turned(&linear);
        let axes = own.unwrap_or(DMat3::IDENTITY);
        let (low, high) = bounds.unwrap_or_default();
        let center = t.world((low + high) * 0.5);
        let reach = (t.model.transform_vector3(high - low)).abs().max_element()
            + linear.to_cols_array().iter().fold(0.0f64, |m, v| m.max(v.abs())) * (high - low).max_element();
        let origin = if t.camera.is_parallel { center } else { t.camera.eye };
        let farthest = (center - origin).length() + reach;
        let eye = match t.camera.is_parallel {
            true => Some(Eye::Parallel { to_viewer: f32s(axes * t.camera.to_viewer) }),
            false => rays(t, &axes).map(|ray| Eye::Perspective { ray }),
        };
        ShadingSpace {
            axes,
            origin,
            has_own_normals: own.is_some(),
            eye: eye.unwrap_or(Eye::Parallel { to_viewer: [0.0; 3] }),
            is_in_range: (1e-12..LARGEST).contains(&farthest) && eye.is_some(),
        }
    }

    /// Transforms a point of world space to this space.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.axes * (p - self.origin)
    }
}

/// Returns the ray at pixel (0,0) and its steps per column and per row. The point seen at a pixel is
/// the eye plus the pixel's ray times w. Returns `None` if the projection's centre is not the eye,
/// or out of range for f32.
fn rays(t: &Transform, axes: &DMat3) -> Option<[[f32; 3]; 3]> {
    let complete = t.camera.projection * t.camera.view;
    let [x, y, _, w] = [0, 1, 2, 3].map(|r| complete.row(r));
    let rows = [x, y, w].map(|r| r.truncate());
    let from_eye = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
    // A perspective with its centre at the camera's eye maps the eye itself to x = y = w = 0.
    let at_eye = [x, y, w].map(|r| r.dot(t.camera.eye.extend(1.0)).abs());
    let size = from_eye.to_cols_array().iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let slack = 1e-9 * size * (1.0 + t.camera.eye.abs().max_element());
    if at_eye.iter().any(|v| v.is_nan() || *v > slack) {
        return None;
    }
    let back = from_eye.inverse();
    if !back.is_finite() {
        return None;
    }
    let ray = |x: i32, y: i32| {
        let ndc = t.screen.ndc_of_pixel(x, y);
        *axes * (back * DVec3::new(ndc[0], ndc[1], 1.0))
    };
    let first = ray(0, 0);
    let rays = [first, ray(1, 0) - first, ray(0, 1) - first];
    rays.iter().all(|r| r.is_finite() && r.length() < LARGEST).then(|| rays.map(f32s))
}

/// Returns the rotation from world axes to the mesh's own, if its model only rotates, translates
/// and scales uniformly.
fn evenly_turned(linear: &DMat3) -> Option<DMat3> {
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
    let s2 = x.length_squared();
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * s2;
    let even = s2 > 1e-200
        && s2 < 1e200
        && close(y.length_squared(), s2)
        && close(z.length_squared(), s2)
        && close(x.dot(y), 0.0)
        && close(y.dot(z), 0.0)
        && close(z.dot(x), 0.0)
        && linear.determinant() > 0.0;
    even.then(|| (*linear * (1.0 / s2.sqrt())).transpose())
}

/// Rounds a vector to f32.
pub(crate) fn f32s(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

//! Matrices of a camera: world to view, view to clip space.
//!
//! In every projection here w depends on view z alone, so points in front of the eye have w > 0; z
//! is 0 on the near plane and w on the far one.

use super::camera::{Camera, CameraError, CameraMatrices, FARTHEST_EYE, LookAt, ObliqueKind, Projection};
use crate::math::matrix::{self, unit};
use crate::math::projection::{self as proj, ViewingTransformation, with_rows};
use glam::{DMat4, DVec3, DVec4};

/// Sine of the angle below which the up vector counts as parallel to the view.
const PARALLEL_SINE: f64 = 1e-12;

impl LookAt {
    /// Returns the view's axes in world space: x right, y up, z towards the viewer.
    ///
    /// z = (eye-ref)/|eye-ref|, x = up x z / |..|, y = z x x (sources 001 and 004).
    ///
    /// # Errors
    /// If the eye is at the reference point, or the up vector is zero or parallel to the view.
    pub fn axes(&self) -> Result<[DVec3; 3], CameraError> {
        let z = unit(self.eye - self.reference).ok_or(CameraError::NoDirection)?;
        let x = unit(self.up).map(|up| up.cross(z)).filter(|x| x.length() > PARALLEL_SINE);
        let x = x.and_then(unit).ok_or(CameraError::BadUp)?;
        Ok([x, z.cross(x), z])
    }

    /// Returns the matrix R T from world to view space.
    ///
    /// # Errors
    /// See [`LookAt::axes`].
    pub fn matrix(&self) -> Result<DMat4, CameraError> {
        let [x, y, z] = self.axes()?;
        let rotation = with_rows(x.extend(0.0), y.extend(0.0), z.extend(0.0), DVec4::W);
        Ok(rotation * matrix::translate(-self.eye))
    }
}

fn check_depth(near: f64, far: f64, nearest: f64) -> Result<(), CameraError> {
    let sound = near > nearest
        && near < far
        && far.is_finite()
        && (far - near).is_finite()
        && 1.0 / (far - near) < f64::INFINITY;
    if sound { Ok(()) } else { Err(CameraError::BadDepthRange { near, far }) }
}

fn check(what: &'static str, value: f64, sound: bool) -> Result<(), CameraError> {
    if sound && value.is_finite() { Ok(()) } else { Err(CameraError::BadExtent { what, value }) }
}

/// Returns width and height of a window left, right, bottom, top.
fn extents([l, r, b, t]: [f64; 4]) -> Result<[f64; 2], CameraError> {
    let e = [r - l, t - b];
    check("window width", e[0], e[0] != 0.0 && (1.0 / e[0]).is_finite())?;
    check("window height", e[1], e[1] != 0.0 && (1.0 / e[1]).is_finite())?;
    Ok(e)
}

/// Returns the smallest window of this aspect (width / height) about the centre of `window` that
/// contains it.
pub fn contain([l, r, b, t]: [f64; 4], aspect: f64) -> [f64; 4] {
    let (w, h) = (r - l, t - b);
    let grow = |low: f64, high: f64, factor: f64| {
        let (middle, half) = (low / 2.0 + high / 2.0, (high - low) / 2.0 * factor);
        [middle - half, middle + half]
    };
    let ratio = (aspect * h / w).abs();
    let [l, r] = if ratio > 1.0 { grow(l, r, ratio) } else { [l, r] };
    let [b, t] = if ratio < 1.0 { grow(b, t, 1.0 / ratio) } else { [b, t] };
    [l, r, b, t]
}

/// Returns the matrix of a parallel box over a window.
fn parallel(window: [f64; 4], near: f64, far: f64) -> Result<DMat4, CameraError> {
    let [l, r, b, t] = window;
    let [w, h] = extents(window)?;
    check_depth(near, far, f64::NEG_INFINITY)?;
    Ok(with_rows(
        DVec4::new(2.0 / w, 0.0, 0.0, -(r + l) / w),
        DVec4::new(0.0, 2.0 / h, 0.0, -(t + b) / h),
        proj::parallel_z_row(near, far),
        DVec4::W,
    ))
}

/// Returns the scales of x and y for a field of view, of the height or of the smaller side.
fn field_of_view(fov_rad: f64, aspect: f64, on_smaller_side: bool) -> Result<[f64; 2], CameraError> {
    check("field of view", fov_rad, fov_rad > 0.0 && fov_rad < std::f64::consts::PI)?;
    let k = 1.0 / libm::tan(fov_rad / 2.0);
    check("field of view", fov_rad, k > 0.0 && k.is_finite())?;
    Ok(if on_smaller_side && aspect < 1.0 { [k, k * aspect] } else { [k / aspect, k] })
}

/// Returns the axes u, v and n of a WINDOW camera in world space, n into the scene.
fn window_axes(vrp: DVec3, p: DVec3, vup: DVec3) -> Result<[DVec3; 3], CameraError> {
    let n = unit(p - vrp).ok_or(CameraError::NoDirection)?;
    let up = unit(vup).ok_or(CameraError::BadUp)?;
    let v = Some(up - n * up.dot(n)).filter(|v| v.length() > PARALLEL_SINE);
    let v = v.and_then(unit).ok_or(CameraError::BadUp)?;
    Ok([n.cross(v), v, n])
}

/// Returns the matrices of a WINDOW camera at `eye`, from its viewing transformation.
fn window_matrices(
    t: &ViewingTransformation,
    eye: DVec3,
    to_viewer: DVec3,
    near: f64,
    far: f64,
) -> CameraMatrices {
    // The pipeline's view looks along -z: n is negated in the view and again in the projection.
    let turn = matrix::scale(DVec3::new(1.0, 1.0, -1.0));
    let sides = t.d * t.c * turn;
    // P after D: z' = (z - N)/(F - N), h = z/F; written so that the planes are exactly 0.
    let c = near / (far - near) / far;
    CameraMatrices {
        view: turn * t.b * t.a,
        projection: with_rows(
            sides.row(0),
            sides.row(1),
            proj::parallel_z_row(near, far),
            DVec4::new(0.0, 0.0, -1.0 / far, 0.0),
        ),
        one_minus_z_row: DVec4::new(0.0, 0.0, c, far * c),
        w_near: near / far,
        is_parallel: false,
        eye,
        to_viewer,
    }
}

impl Camera {
    /// Returns the matrices for a viewport of `aspect` = width / height.
    ///
    /// # Errors
    /// If the view has no direction, or the projection bounds no volume or area.
    pub fn matrices(&self, aspect: f64) -> Result<CameraMatrices, CameraError> {
        check("aspect", aspect, aspect > 0.0)?;
        let points = match self.projection {
            Projection::Window { vrp, p, .. } => [vrp, p],
            _ => [self.look_at.eye, self.look_at.reference],
        };
        let distance = points.iter().fold(0.0f64, |most, p| most.max(p.abs().max_element()));
        if distance > FARTHEST_EYE {
            return Err(CameraError::TooFar { distance });
        }
        match self.projection {
            Projection::Perspective { fov_rad, near, far, on_smaller_side } => {
                let [kx, ky] = field_of_view(fov_rad, aspect, on_smaller_side)?;
                let (x, y) = (DVec4::X * kx, DVec4::Y * ky);
                self.perspective(x, y, 1.0, near, far)
            }
            Projection::Plane { d, near, far } => {
                check("view-plane distance", d, d > 0.0 && (1.0 / d).is_finite())?;
                self.perspective(DVec4::X, DVec4::Y, 1.0 / d, near, far)
            }
            Projection::Frustum { window, near, far } => {
                let [l, r, b, t] = window;
                let [w, h] = extents(window)?;
                let x = DVec4::new(2.0 * near / w, 0.0, (r + l) / w, 0.0);
                let y = DVec4::new(0.0, 2.0 * near / h, (t + b) / h, 0.0);
                self.perspective(x, y, 1.0, near, far)
            }
            Projection::OrthoContain { window, near, far } => {
                extents(window)?;
                let window = contain(window, aspect);
                Camera { projection: Projection::Ortho { window, near, far }, ..*self }.matrices(aspect)
            }
            Projection::Ortho { window, near, far } => {
                let view = self.look_at.matrix()?;
                self.parallel_matrices(view, parallel(window, near, far)?, DVec3::Z, near, far)
            }
            Projection::Oblique { kind, angle_rad, window, near, far } => {
                check("angle", angle_rad, true)?;
                let view = self.look_at.matrix()?;
                let (about, along) = self.oblique(kind, angle_rad);
                self.parallel_matrices(view, parallel(window, near, far)? * about, along, near, far)
            }
            Projection::Isometric { window, near, far } => {
                let view = proj::isometric() * self.look_at.matrix()?;
                self.parallel_matrices(view, parallel(window, near, far)?, DVec3::Z, near, far)
            }
            Projection::PseudoIsometric { window, near, far } => {
                let view = proj::isometric() * self.look_at.matrix()?;
                let k = proj::pseudo_isometric_scale();
                let wider = matrix::scale(DVec3::new(k, k, 1.0));
                self.parallel_matrices(view, parallel(window, near, far)? * wider, DVec3::Z, near, far)
            }
            Projection::Window { vrp, near, far, .. } => {
                let t = self.viewing_transformation()?.expect("the projection is a window");
                Ok(window_matrices(&t, vrp, -t.b.row(2).truncate(), near, far))
            }
        }
    }

    /// Returns the matrices A, B, C, D and P of a viewing transformation (source 000); `None` for
    /// other projections.
    ///
    /// # Errors
    /// If the view has no direction, or the window no area or depth.
    pub fn viewing_transformation(&self) -> Result<Option<ViewingTransformation>, CameraError> {
        let Projection::Window { vrp, p, vup, center, half, dp, near, far } = self.projection else {
            return Ok(None);
        };
        check("window distance", dp, dp > 0.0)?;
        check("window half width", half[0], half[0] > 0.0)?;
        check("window half height", half[1], half[1] > 0.0)?;
        check("window centre", center[0] + center[1], true)?;
        check_depth(near, far, 0.0)?;
        let axes = window_axes(vrp, p, vup)?;
        Ok(Some(ViewingTransformation::new(vrp, axes, center, half, dp, [near, far])))
    }

    /// Returns the shear of an oblique projection about the plane through the reference point, so
    /// that points on it stay in place, and the view vector along which points coincide: the
    /// direction of projection, towards the viewer.
    fn oblique(&self, kind: ObliqueKind, angle_rad: f64) -> (DMat4, DVec3) {
        let l = match kind {
            ObliqueKind::Cavalier => 1.0,
            ObliqueKind::Cabinet => 0.5,
        };
        let shear = proj::oblique(l, angle_rad);
        let to_reference = DVec3::Z * (self.look_at.eye - self.look_at.reference).length();
        let about = matrix::translate(-to_reference) * shear * matrix::translate(to_reference);
        (about, DVec3::new(-shear.z_axis.x, -shear.z_axis.y, 1.0))
    }

    /// Returns a perspective camera with rows x and y, and w = -z * `w_scale`.
    fn perspective(
        &self,
        x: DVec4,
        y: DVec4,
        w_scale: f64,
        near: f64,
        far: f64,
    ) -> Result<CameraMatrices, CameraError> {
        check_depth(near, far, 0.0)?;
        let [_, _, z] = self.look_at.axes()?;
        Ok(CameraMatrices {
            view: self.look_at.matrix()?,
            projection: with_rows(
                x,
                y,
                proj::perspective_z_row(near, far) * w_scale,
                DVec4::new(0.0, 0.0, -w_scale, 0.0),
            ),
            one_minus_z_row: proj::perspective_complement_row(near, far) * w_scale,
            w_near: near * w_scale,
            is_parallel: false,
            eye: self.look_at.eye,
            to_viewer: z,
        })
    }

    /// Returns a parallel camera; `along` is the direction of projection in view space, towards the
    /// viewer.
    fn parallel_matrices(
        &self,
        view: DMat4,
        projection: DMat4,
        along: DVec3,
        near: f64,
        far: f64,
    ) -> Result<CameraMatrices, CameraError> {
        // The view's rotation is orthonormal, so its transpose maps directions to world space.
        let world = DVec3::new(
            view.x_axis.truncate().dot(along),
            view.y_axis.truncate().dot(along),
            view.z_axis.truncate().dot(along),
        );
        Ok(CameraMatrices {
            view,
            projection,
            one_minus_z_row: proj::parallel_complement_row(near, far),
            w_near: 1.0,
            is_parallel: true,
            eye: self.look_at.eye,
            to_viewer: unit(world).unwrap_or(DVec3::Z),
        })
    }
}

#[cfg(test)]
mod tests;

//! Cameras of the reference: world to view to clip space, and NDC to screen, derived from the
//! sources.
//!
//! Column vectors; matrices as written on paper (row by row). Clip space: -w<=x<=w, -w<=y<=w,
//! 0<=z<=w. Sources: 001 (view, view plane at d, viewport), 000 (A, B, C, D, P), 004 (frustum to
//! box, parallel projections).

use super::double_double::{
    DoubleDouble, DoubleDouble3, DoubleDouble4, cross, dot3, double_double3, narrow3, sub3, unit3,
};
use fbptr_core::scene::{
    Camera, CameraError, FARTHEST_EYE, LookAt, ObliqueKind, Projection, Viewport, ViewportRule,
};
use glam::DVec3;

/// 4x4 matrix as an array of rows.
pub type Matrix = [[DoubleDouble; 4]; 4];

/// Origin of the vector V to the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewerPosition {
    /// V points from the surface to this world point.
    Eye(DVec3),
    /// V is this unit world vector everywhere (parallel projections).
    Axis(DVec3),
}

/// Matrices and viewer of a camera for one viewport.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// Matrix from world to view space: the camera at the origin, looking along -z.
    pub view: Matrix,
    /// Matrix from view to clip space.
    pub projection: Matrix,
    /// Origin of V.
    pub viewer: ViewerPosition,
    /// Eye in world space, from which distances (fog) are measured.
    pub eye: DVec3,
    viewport: Viewport,
}

/// Returns the product M p.
pub fn transform(m: &Matrix, p: DoubleDouble4) -> DoubleDouble4 {
    std::array::from_fn(|r| m[r][0] * p[0] + m[r][1] * p[1] + m[r][2] * p[2] + m[r][3] * p[3])
}

/// Returns the product A B.
pub fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|r| {
        std::array::from_fn(|c| a[r][0] * b[0][c] + a[r][1] * b[1][c] + a[r][2] * b[2][c] + a[r][3] * b[3][c])
    })
}

/// Returns R T of source 001: rows x, y, z of R, after translating the eye to the origin.
fn rotate_and_translate(axes: [DoubleDouble3; 3], origin: DoubleDouble3) -> Matrix {
    let row = |a: DoubleDouble3| [a[0], a[1], a[2], -dot3(a, origin)];
    let last = [DoubleDouble::ZERO, DoubleDouble::ZERO, DoubleDouble::ZERO, DoubleDouble::ONE];
    [row(axes[0]), row(axes[1]), row(axes[2]), last]
}

/// Returns the view of eye, reference and up, with its three axes: z = (eye-ref)/|..|, x = up x
/// z/|..|, y = z x x.
fn look_at(l: &LookAt) -> Result<(Matrix, [DoubleDouble3; 3]), CameraError> {
    let z =
        unit3(sub3(double_double3(l.eye), double_double3(l.reference))).ok_or(CameraError::NoDirection)?;
    let up = unit3(double_double3(l.up)).ok_or(CameraError::BadUp)?;
    let side = cross(up, z);
    if dot3(side, side).to_f64() < 1e-24 {
        return Err(CameraError::BadUp);
    }
    let x = unit3(side).ok_or(CameraError::BadUp)?;
    let axes = [x, cross(z, x), z];
    Ok((rotate_and_translate(axes, double_double3(l.eye)), axes))
}

/// Returns the z row that maps -z_view = near to 0 and -z_view = far to w = -z_view: z_ndc =
/// f(d-n)/(d(f-n)) (003).
fn perspective_z_row(near: DoubleDouble, far: DoubleDouble) -> [DoubleDouble; 4] {
    let depth = far - near;
    [DoubleDouble::ZERO, DoubleDouble::ZERO, -far / depth, -(far * near) / depth]
}

/// Returns the matrix of a perspective frustum: window [l, r, b, t] at the near plane, w = -z.
fn frustum([l, r, b, t]: [DoubleDouble; 4], near: DoubleDouble, far: DoubleDouble) -> Matrix {
    let (zero, two) = (DoubleDouble::ZERO, DoubleDouble::new(2.0));
    [
        [two * near / (r - l), zero, (r + l) / (r - l), zero],
        [zero, two * near / (t - b), (t + b) / (t - b), zero],
        perspective_z_row(near, far),
        [zero, zero, -DoubleDouble::ONE, zero],
    ]
}

/// Returns the matrix of a parallel box: window [l, r, b, t], depth (-z - n)/(f - n), w = 1.
fn parallel([l, r, b, t]: [DoubleDouble; 4], near: DoubleDouble, far: DoubleDouble) -> Matrix {
    let (zero, two) = (DoubleDouble::ZERO, DoubleDouble::new(2.0));
    [
        [two / (r - l), zero, zero, -(r + l) / (r - l)],
        [zero, two / (t - b), zero, -(t + b) / (t - b)],
        [zero, zero, -DoubleDouble::ONE / (far - near), -near / (far - near)],
        [zero, zero, zero, DoubleDouble::ONE],
    ]
}

/// Returns the two rotations of the golden (004): -45 degrees about y, then asin(1/sqrt 3) about x.
fn isometric_turns() -> Matrix {
    let h = DoubleDouble::new(0.5).sqrt();
    let s = DoubleDouble::ONE / DoubleDouble::new(3.0).sqrt();
    let c = (DoubleDouble::new(2.0) / DoubleDouble::new(3.0)).sqrt();
    let (o, i) = (DoubleDouble::ZERO, DoubleDouble::ONE);
    let about_y = [[h, o, -h, o], [o, i, o, o], [h, o, h, o], [o, o, o, i]];
    let about_x = [[i, o, o, o], [o, c, -s, o], [o, s, c, o], [o, o, o, i]];
    multiply(&about_x, &about_y)
}

/// Returns B A, and P D C, of source 000: the view of a WINDOW camera and its projection.
///
/// The source's axes u, v, n (n into the scene) are left-handed; here z is -n, so that view space
/// is as for the other cameras, and the signs of C, D and P follow. The result on the screen is M1
/// of the golden.
#[expect(clippy::too_many_arguments, reason = "the numbers of WINDOW, in the source's letters")]
fn window_camera(
    vrp: DVec3,
    p: DVec3,
    vup: DVec3,
    [cu, cv]: [f64; 2],
    [su, sv]: [f64; 2],
    dp: f64,
    near: f64,
    far: f64,
) -> Result<(Matrix, Matrix), CameraError> {
    let n = unit3(sub3(double_double3(p), double_double3(vrp))).ok_or(CameraError::NoDirection)?;
    let up = unit3(double_double3(vup)).ok_or(CameraError::BadUp)?;
    let along = dot3(up, n);
    let upright: DoubleDouble3 = std::array::from_fn(|i| up[i] - along * n[i]);
    if dot3(upright, upright).to_f64() < 1e-24 {
        return Err(CameraError::BadUp);
    }
    let v = unit3(upright).ok_or(CameraError::BadUp)?;
    let u = cross(n, v);
    let view = rotate_and_translate([u, v, n.map(|c| -c)], double_double3(vrp));
    let (o, i) = (DoubleDouble::ZERO, DoubleDouble::ONE);
    let [cu, cv, su, sv, dp, near, far] = [cu, cv, su, sv, dp, near, far].map(DoubleDouble::new);
    // From -z to n: the matrices below are the source's, in u, v, n.
    let to_n = [[i, o, o, o], [o, i, o, o], [o, o, -i, o], [o, o, o, i]];
    let c = [[i, o, -cu / dp, o], [o, i, -cv / dp, o], [o, o, i, o], [o, o, o, i]];
    let d = [[dp / (su * far), o, o, o], [o, dp / (sv * far), o, o], [o, o, i / far, o], [o, o, o, i]];
    let p = [[i, o, o, o], [o, i, o, o], [o, o, far / (far - near), -near / (far - near)], [o, o, i, o]];
    Ok((view, multiply(&p, &multiply(&d, &multiply(&c, &to_n)))))
}

fn check_range(near: f64, far: f64, perspective: bool) -> Result<(DoubleDouble, DoubleDouble), CameraError> {
    let sound = near.is_finite() && far.is_finite() && near < far && (!perspective || near > 0.0);
    if sound { Ok((near.into(), far.into())) } else { Err(CameraError::BadDepthRange { near, far }) }
}

fn check_window(w: [f64; 4]) -> Result<[DoubleDouble; 4], CameraError> {
    let (across, up) = (w[1] - w[0], w[3] - w[2]);
    if !(across.is_finite() && across != 0.0) {
        return Err(CameraError::BadExtent { what: "window width", value: across });
    }
    if !(up.is_finite() && up != 0.0) {
        return Err(CameraError::BadExtent { what: "window height", value: up });
    }
    Ok(w.map(DoubleDouble::new))
}

fn check_positive(what: &'static str, value: f64) -> Result<DoubleDouble, CameraError> {
    let sound = value.is_finite() && value > 0.0;
    if sound { Ok(value.into()) } else { Err(CameraError::BadExtent { what, value }) }
}

/// Matrices of a camera, and V in view space if it is the same everywhere.
struct CameraMatrices {
    view: Matrix,
    projection: Matrix,
    to_viewer: Option<DoubleDouble3>,
}

impl CameraMatrices {
    /// Makes the matrices of a perspective camera.
    fn perspective(view: Matrix, projection: Matrix) -> CameraMatrices {
        CameraMatrices { view, projection, to_viewer: None }
    }

    /// Makes the matrices of a parallel camera that looks along its axis.
    fn along_axis(view: Matrix, projection: Matrix) -> CameraMatrices {
        let (o, i) = (DoubleDouble::ZERO, DoubleDouble::ONE);
        CameraMatrices { view, projection, to_viewer: Some([o, o, i]) }
    }

    /// Computes the matrices of a camera for a viewport.
    fn of(camera: &Camera, viewport: &Viewport) -> Result<CameraMatrices, CameraError> {
        let points = match camera.projection {
            Projection::Window { vrp, p, .. } => [vrp, p],
            _ => [camera.look_at.eye, camera.look_at.reference],
        };
        let distance = points.iter().flat_map(|p| p.to_array()).fold(0.0f64, |m, v| m.max(v.abs()));
        if distance > FARTHEST_EYE {
            return Err(CameraError::TooFar { distance });
        }
        let l = &camera.look_at;
        Ok(match camera.projection {
            Projection::Perspective { fov_rad, near, far, on_smaller_side } => {
                let (n, f) = check_range(near, far, true)?;
                let window = field_of_view(fov_rad, n, viewport, on_smaller_side)?;
                Self::perspective(look_at(l)?.0, frustum(window, n, f))
            }
            Projection::Plane { d, near, far } => {
                let (n, f) = check_range(near, far, true)?;
                let d = check_positive("view-plane distance", d)?;
                let (o, i) = (DoubleDouble::ZERO, DoubleDouble::ONE);
                // Rows x, y, w of 001 are 1, 1, -1/d; all three are multiplied by d, so that w is
                // FRUSTUM's and its z row fits.
                let p = [[d, o, o, o], [o, d, o, o], perspective_z_row(n, f), [o, o, -i, o]];
                Self::perspective(look_at(l)?.0, p)
            }
            Projection::Frustum { window, near, far } => {
                let (n, f) = check_range(near, far, true)?;
                Self::perspective(look_at(l)?.0, frustum(check_window(window)?, n, f))
            }
            Projection::OrthoContain { window, near, far } => {
                let window = contain(check_window(window)?, viewport);
                let (n, f) = check_range(near, far, false)?;
                Self::along_axis(look_at(l)?.0, parallel(window, n, f))
            }
            Projection::Ortho { window, near, far } => {
                let (n, f) = check_range(near, far, false)?;
                Self::along_axis(look_at(l)?.0, parallel(check_window(window)?, n, f))
            }
            Projection::Oblique { kind, angle_rad, window, near, far } => {
                let (n, f) = check_range(near, far, false)?;
                let (shear, to_viewer) = oblique(l, kind, angle_rad);
                let projection = multiply(&parallel(check_window(window)?, n, f), &shear);
                CameraMatrices { view: look_at(l)?.0, projection, to_viewer: Some(to_viewer) }
            }
            Projection::Isometric { window, near, far } => {
                let (n, f) = check_range(near, far, false)?;
                let view = multiply(&isometric_turns(), &look_at(l)?.0);
                Self::along_axis(view, parallel(check_window(window)?, n, f))
            }
            Projection::PseudoIsometric { window, near, far } => {
                let (n, f) = check_range(near, far, false)?;
                let view = multiply(&isometric_turns(), &look_at(l)?.0);
                let (o, i) = (DoubleDouble::ZERO, DoubleDouble::ONE);
                // Every axis unforeshortened: x and y over sqrt(2/3).
                let k = (DoubleDouble::new(3.0) / DoubleDouble::new(2.0)).sqrt();
                let stretch = [[k, o, o, o], [o, k, o, o], [o, o, i, o], [o, o, o, i]];
                Self::along_axis(view, multiply(&parallel(check_window(window)?, n, f), &stretch))
            }
            Projection::Window { vrp, p, vup, center, half, dp, near, far } => {
                check_range(near, far, true)?;
                check_positive("half width", half[0])?;
                check_positive("half height", half[1])?;
                check_positive("view-plane distance", dp)?;
                let (view, projection) = window_camera(vrp, p, vup, center, half, dp, near, far)?;
                Self::perspective(view, projection)
            }
        })
    }
}

/// Returns the window at the near plane of a field of view, of the height or of the smaller side.
fn field_of_view(
    fov_rad: f64,
    near: DoubleDouble,
    viewport: &Viewport,
    on_smaller_side: bool,
) -> Result<[DoubleDouble; 4], CameraError> {
    if !(fov_rad > 0.0 && fov_rad < std::f64::consts::PI) {
        return Err(CameraError::BadExtent { what: "field of view", value: fov_rad });
    }
    let half = DoubleDouble::new(libm::tan(fov_rad / 2.0));
    let (w, h) = (DoubleDouble::new(viewport.width.into()), DoubleDouble::new(viewport.height.into()));
    let (half_w, half_h) = if on_smaller_side && w < h {
        (half * near, half * near * h / w)
    } else {
        (half * near * w / h, half * near)
    };
    Ok([-half_w, half_w, -half_h, half_h])
}

/// Returns the smallest window of the viewport's aspect about the centre of a window that contains
/// it.
fn contain([l, r, b, t]: [DoubleDouble; 4], viewport: &Viewport) -> [DoubleDouble; 4] {
    // Half sizes about the centre; the smaller one relative to the viewport grows.
    let two = DoubleDouble::new(2.0);
    let aspect = DoubleDouble::new(viewport.width.into()) / DoubleDouble::new(viewport.height.into());
    let (x, y) = ((l + r) / two, (b + t) / two);
    let (mut half_x, mut half_y) = ((r - l) / two, (t - b) / two);
    if half_x < half_y * aspect {
        half_x = half_y * aspect;
    } else {
        half_y = half_x / aspect;
    }
    [x - half_x, x + half_x, y - half_y, y + half_y]
}

/// Returns the shear of an oblique camera, and its direction of projection towards the viewer:
/// x' = x - l cos(a) (z - z_ref), y' = y - l sin(a) (z - z_ref), z' = z.
fn oblique(l: &LookAt, kind: ObliqueKind, angle_rad: f64) -> (Matrix, DoubleDouble3) {
    let (o, i) = (DoubleDouble::ZERO, DoubleDouble::ONE);
    let factor = match kind {
        ObliqueKind::Cavalier => 1.0,
        ObliqueKind::Cabinet => 0.5,
    };
    let (sin, cos) = libm::sincos(angle_rad);
    let (a, b) = (DoubleDouble::new(factor) * cos.into(), DoubleDouble::new(factor) * sin.into());
    let away = sub3(double_double3(l.eye), double_double3(l.reference));
    let z_ref = -dot3(away, away).sqrt();
    let shear = [[i, o, -a, a * z_ref], [o, i, -b, b * z_ref], [o, o, i, o], [o, o, o, i]];
    (shear, [a, b, i])
}

impl Sight {
    /// Computes the matrices of a camera for a viewport.
    ///
    /// # Errors
    /// If the view has no direction, or the projection bounds no volume or area.
    pub fn new(camera: &Camera, viewport: &Viewport) -> Result<Sight, CameraError> {
        let CameraMatrices { view, projection, to_viewer } = CameraMatrices::of(camera, viewport)?;
        let eye = match camera.projection {
            Projection::Window { vrp, .. } => vrp,
            _ => camera.look_at.eye,
        };
        let viewer = match to_viewer {
            None => ViewerPosition::Eye(eye),
            // The view's rows are the axes of view space in the world: V_world = R^T V_view.
            Some(v) => {
                let world =
                    std::array::from_fn(|c| view[0][c] * v[0] + view[1][c] * v[1] + view[2][c] * v[2]);
                let axis =
                    unit3(world).unwrap_or([DoubleDouble::ZERO, DoubleDouble::ZERO, DoubleDouble::ONE]);
                ViewerPosition::Axis(narrow3(axis))
            }
        };
        Ok(Sight { view, projection, viewer, eye, viewport: *viewport })
    }

    /// Maps NDC x and y to screen pixels, y down, with the centre of pixel (i, j) at (i+.5, j+.5).
    pub fn to_screen(&self, x_ndc: DoubleDouble, y_ndc: DoubleDouble) -> [DoubleDouble; 2] {
        let v = &self.viewport;
        let (x0, y0) = (DoubleDouble::new(v.x.into()), DoubleDouble::new(v.y.into()));
        let (w, h) = (DoubleDouble::new(v.width.into()), DoubleDouble::new(v.height.into()));
        let (one, half) = (DoubleDouble::ONE, DoubleDouble::new(0.5));
        match v.rule {
            ViewportRule::Corners => [x0 + (x_ndc + one) * w * half, y0 + (one - y_ndc) * h * half],
            ViewportRule::Centres => {
                [x0 + (x_ndc + one) * (w - one) * half + half, y0 + (one - y_ndc) * (h - one) * half + half]
            }
        }
    }

    /// Returns the NDC of the centre of pixel (x, y); not finite for a `centres` viewport one pixel
    /// wide or high.
    pub fn ndc_of_pixel(&self, x: i64, y: i64) -> [DoubleDouble; 2] {
        let v = &self.viewport;
        let (dx, dy) =
            (DoubleDouble::new((x - v.x as i64) as f64), DoubleDouble::new((y - v.y as i64) as f64));
        let (w, h) = (DoubleDouble::new(v.width.into()), DoubleDouble::new(v.height.into()));
        let (one, two, half) = (DoubleDouble::ONE, DoubleDouble::new(2.0), DoubleDouble::new(0.5));
        match v.rule {
            ViewportRule::Corners => [two * (dx + half) / w - one, one - two * (dy + half) / h],
            ViewportRule::Centres => [two * dx / (w - one) - one, one - two * dy / (h - one)],
        }
    }

    /// Returns the screen pixels per unit of NDC in x and y.
    pub fn pixels_per_ndc(&self) -> [f64; 2] {
        let less = match self.viewport.rule {
            ViewportRule::Corners => 0.0,
            ViewportRule::Centres => 1.0,
        };
        [(self.viewport.width as f64 - less) / 2.0, (self.viewport.height as f64 - less) / 2.0]
    }
}

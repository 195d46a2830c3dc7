//! Projection and viewing matrices of the source documents: column vectors, one function per
//! matrix.
//!
//! View space looks along -z. Clip space is -w<=x<=w, -w<=y<=w, 0<=z<=w (0 near, 1 far after the
//! division).
//!
//! Sources: notes 001 (view plane at distance d, viewport), 000 (viewing transformation A B C D P,
//! J K L M), 004 (frustum to box, oblique, isometric).

use super::matrix::{from_rows, scale, shear, translate};
use glam::{DMat4, DVec3, DVec4};

/// Returns the z row of a perspective projection, for w = -z: 0 at `near`, w at `far`.
pub fn perspective_z_row(near: f64, far: f64) -> DVec4 {
    let a = far / (far - near);
    DVec4::new(0.0, 0.0, -a, -near * a)
}

/// Returns w - z of [`perspective_z_row`] without its cancellation: n (z + f) / (f - n).
pub fn perspective_complement_row(near: f64, far: f64) -> DVec4 {
    let c = near / (far - near);
    DVec4::new(0.0, 0.0, c, far * c)
}

/// Returns the z row of a parallel projection: 0 at distance `near`, 1 at `far`.
pub fn parallel_z_row(near: f64, far: f64) -> DVec4 {
    // One factor for both terms, so that a point on the near plane gets exactly 0.
    let a = 1.0 / (far - near);
    DVec4::new(0.0, 0.0, -a, -near * a)
}

/// Returns 1 - z of [`parallel_z_row`] without its cancellation.
pub fn parallel_complement_row(near: f64, far: f64) -> DVec4 {
    let a = 1.0 / (far - near);
    DVec4::new(0.0, 0.0, a, far * a)
}

/// Returns the matrix with the given rows.
pub fn with_rows(x: DVec4, y: DVec4, z: DVec4, w: DVec4) -> DMat4 {
    DMat4::from_cols(x, y, z, w).transpose()
}

/// Returns the projection on the view plane z = -d, with w = -z/d (source 001).
pub fn view_plane(d: f64) -> DMat4 {
    from_rows([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, d, 0.0, 0.0, -1.0 / d, 0.0])
}

/// Returns the map of the frustum to a box of equal height, zp from -near to -far; x and y keep
/// their size at the near plane (source 004).
pub fn frustum_to_box(near: f64, far: f64) -> DMat4 {
    let (n, f) = (near, far);
    from_rows([n, 0.0, 0.0, 0.0, 0.0, n, 0.0, 0.0, 0.0, 0.0, n + f, n * f, 0.0, 0.0, -1.0, 0.0])
}

/// Returns the simple conical projection, zp = -d everywhere (source 004).
pub fn simple_conical(d: f64) -> DMat4 {
    from_rows([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0 / d, 0.0])
}

/// Returns the oblique shear x' = x - l cos(a) z, y' = y - l sin(a) z, z kept (l = 1 cavalier, 1/2
/// cabinet; source 004).
pub fn oblique(l: f64, angle_rad: f64) -> DMat4 {
    let (sin, cos) = libm::sincos(angle_rad);
    shear(0.0, -l * cos, 0.0, -l * sin, 0.0, 0.0)
}

/// Returns the isometric rotation: -45 degrees about y, then asin(1/sqrt 3) about x, so that every
/// axis is seen at sqrt(2/3) of its length (source 004).
pub fn isometric() -> DMat4 {
    // The sines and cosines of both angles are square roots, so no trigonometry is needed.
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let (s, c) = ((1.0f64 / 3.0).sqrt(), (2.0f64 / 3.0).sqrt());
    let about_y = from_rows([h, 0.0, -h, 0.0, 0.0, 1.0, 0.0, 0.0, h, 0.0, h, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let about_x = from_rows([1.0, 0.0, 0.0, 0.0, 0.0, c, -s, 0.0, 0.0, s, c, 0.0, 0.0, 0.0, 0.0, 1.0]);
    about_x * about_y
}

/// Returns the factor from x and y of the isometric picture to those of the pseudo-isometric one,
/// 1 / sqrt(2/3).
pub fn pseudo_isometric_scale() -> f64 {
    1.5f64.sqrt()
}

/// Returns S2 T1 S1, which takes NDC to a `width` x `height` screen whose pixel centres are
/// integers, y down (source 001).
pub fn viewport_centres(width: u32, height: u32) -> DMat4 {
    let flip = scale(DVec3::new(1.0, -1.0, 1.0));
    let s2 = scale(DVec3::new((width as f64 - 1.0) / 2.0, (height as f64 - 1.0) / 2.0, 1.0));
    s2 * translate(DVec3::new(1.0, 1.0, 0.0)) * flip
}

/// Matrices of the viewing transformation (source 000).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewingTransformation {
    /// Translates the view reference point (VRP) to the origin.
    pub a: DMat4,
    /// Rows u, v, n: n into the scene, v up, u = n x v (left-handed).
    pub b: DMat4,
    /// Skews by -CU/DP, -CV/DP: moves the window's centre onto the n axis.
    pub c: DMat4,
    /// Scales by DP/(SU F), DP/(SV F), 1/F.
    pub d: DMat4,
    /// Projects: h = z, z' = (F z - N) / (F - N).
    pub p: DMat4,
}

impl ViewingTransformation {
    /// Returns the matrices for the axes u, v, n at `vrp`, and the window's centre and half extents
    /// on the plane at distance `dp`.
    pub fn new(
        vrp: DVec3,
        [u, v, n]: [DVec3; 3],
        center: [f64; 2],
        half: [f64; 2],
        dp: f64,
        [near, far]: [f64; 2],
    ) -> Self {
        ViewingTransformation {
            a: translate(-vrp),
            b: with_rows(u.extend(0.0), v.extend(0.0), n.extend(0.0), DVec4::W),
            c: shear(0.0, -center[0] / dp, 0.0, -center[1] / dp, 0.0, 0.0),
            d: scale(DVec3::new(dp / (half[0] * far), dp / (half[1] * far), 1.0 / far)),
            p: from_rows([
                1.0,
                0.0,
                0.0,
                0.0,
                0.0,
                1.0,
                0.0,
                0.0,
                0.0,
                0.0,
                far / (far - near),
                -near / (far - near),
                0.0,
                0.0,
                1.0,
                0.0,
            ]),
        }
    }

    /// Returns M1 = P D C B A: world to clip space.
    pub fn m1(&self) -> DMat4 {
        self.p * self.d * self.c * self.b * self.a
    }

    /// Returns M2 = M L K J: NDC to screen, where `u` and `v` are the first and last pixel and `z`
    /// is the depth range. Pixel centres are integers, plus the half that turns truncation into
    /// rounding.
    pub fn m2(u: [f64; 2], v: [f64; 2], z: [f64; 2]) -> DMat4 {
        let j = scale(DVec3::new(1.0, -1.0, 1.0));
        let k = translate(DVec3::new(0.5, 0.5, 0.0)) * scale(DVec3::new(0.5, 0.5, 1.0));
        let l = translate(DVec3::new(u[0], v[0], z[0]))
            * scale(DVec3::new(u[1] - u[0], v[1] - v[0], z[1] - z[0]));
        let m = translate(DVec3::new(0.5, 0.5, 0.0));
        m * l * k * j
    }
}

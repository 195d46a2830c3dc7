//! TextureCoordinateGenerator: texture coordinates from positions and normals.
//!
//! Source: ISO/IEC 19775-1 clause 18.4.8, table 18.6. N is the unit normal and P the position in
//! camera space (x right, y up, z towards the viewer), R = 2 (E.N) N - E the reflection of the unit
//! vector E from the surface to the eye, p and n position and normal in the geometry's own
//! coordinates; s and t are the first two components of the table's vector.
//!
//! ```text
//! SPHERE                       (N + 1) / 2        SPHERE-LOCAL      (n + 1) / 2
//! CAMERASPACENORMAL            N                  COORD             p
//! CAMERASPACEPOSITION          P                  COORD-EYE         P
//! CAMERASPACEREFLECTIONVECTOR  R                  NOISE, NOISE-EYE  noise of p, P times scale
//!                                                                   plus translation
//! SPHERE-REFLECT               (R + 1) / 2, or with parameter[0] = index of refraction > 1
//!                              the refracted ray in R's place
//! SPHERE-REFLECT-LOCAL         the same with p and n, the eye at parameter[1..4]
//! ```
//!
//! Limits: coordinates are computed at the corners and interpolated linearly between them; the
//! noise function is this project's own (the standard only says "Perlin solid noise", without
//! parameters).

use fbptr_core::math::matrix::unit;
use fbptr_core::scene::{Camera, Mesh};
use glam::{DMat3, DMat4, DVec2, DVec3};

/// Fields of a generator.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Generator<'a> {
    pub(super) mode: Mode,
    pub(super) parameter: &'a [f64],
}

/// Source of the generated coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Sphere,
    CameraNormal,
    CameraPosition,
    CameraReflection,
    SphereLocal,
    Coord,
    CoordEye,
    Noise,
    NoiseEye,
    SphereReflect,
    SphereReflectLocal,
}

impl Mode {
    /// Returns the mode for an X3D keyword, in either case.
    pub(super) fn from_word(word: &str) -> Option<Mode> {
        Some(match word.trim().to_ascii_uppercase().as_str() {
            "SPHERE" => Mode::Sphere,
            "CAMERASPACENORMAL" => Mode::CameraNormal,
            "CAMERASPACEPOSITION" => Mode::CameraPosition,
            "CAMERASPACEREFLECTIONVECTOR" => Mode::CameraReflection,
            "SPHERE-LOCAL" => Mode::SphereLocal,
            "COORD" => Mode::Coord,
            "COORD-EYE" => Mode::CoordEye,
            "NOISE" => Mode::Noise,
            "NOISE-EYE" => Mode::NoiseEye,
            "SPHERE-REFLECT" => Mode::SphereReflect,
            "SPHERE-REFLECT-LOCAL" => Mode::SphereReflectLocal,
            _ => return None,
        })
    }

    /// Returns whether the coordinates depend on the position of the viewer.
    pub(super) fn depends_on_viewer(self) -> bool {
        !matches!(self, Mode::SphereLocal | Mode::Coord | Mode::Noise | Mode::SphereReflectLocal)
    }
}

/// Transformations from a mesh to its geometry's own coordinates and to camera space.
pub(super) struct SurfaceFrame {
    /// Scale from mesh coordinates to the geometry's own: the half sides of a solid.
    size: DVec3,
    to_camera: DMat4,
    normal_to_camera: DMat3,
}

impl SurfaceFrame {
    /// Creates the frame of a mesh that is scaled by `size` and has world matrix `model`. Without a
    /// camera, world space is used as camera space.
    pub(super) fn new(size: DVec3, model: DMat4, camera: Option<&Camera>) -> SurfaceFrame {
        let view = camera.and_then(|c| c.look_at.matrix().ok()).unwrap_or(DMat4::IDENTITY);
        let to_camera = view * model;
        SurfaceFrame { size, to_camera, normal_to_camera: DMat3::from_mat4(to_camera).inverse().transpose() }
    }
}

/// Returns texture coordinates for each corner of a mesh.
pub(super) fn texcoords(generator: &Generator, mesh: &Mesh, place: &SurfaceFrame) -> Vec<DVec2> {
    let at = |corner: &fbptr_core::scene::Corner| {
        let p = mesh.positions[corner.position as usize] * place.size;
        let n = mesh.normals.get(corner.normal as usize).map(|n| *n / place.size);
        let n = n.filter(|n| n.is_finite()).and_then(unit).unwrap_or(DVec3::Z);
        let found = one(generator, p, n, place);
        let found = DVec2::new(found.x, found.y);
        if found.is_finite() { found } else { DVec2::ZERO }
    };
    mesh.corners.iter().map(at).collect()
}

fn one(generator: &Generator, p: DVec3, n: DVec3, place: &SurfaceFrame) -> DVec3 {
    let camera_p = || place.to_camera.transform_point3(p);
    let camera_n = || unit(place.normal_to_camera * n).unwrap_or(DVec3::Z);
    let half = |v: DVec3| (v + DVec3::ONE) / 2.0;
    let parameter = |i: usize| generator.parameter.get(i).copied();
    let index = parameter(0).filter(|i| *i > 1.0);
    match generator.mode {
        Mode::Sphere => half(camera_n()),
        Mode::CameraNormal => camera_n(),
        Mode::CameraPosition | Mode::CoordEye => camera_p(),
        Mode::CameraReflection => reflected(-camera_p(), camera_n(), None),
        Mode::SphereReflect => half(reflected(-camera_p(), camera_n(), index)),
        Mode::SphereReflectLocal => {
            let eye = DVec3::from_array([1, 2, 3].map(|i| parameter(i).unwrap_or(0.0)));
            half(reflected(eye - p, n, index))
        }
        Mode::SphereLocal => half(n),
        Mode::Coord => p,
        Mode::Noise => noise_at(generator.parameter, p),
        Mode::NoiseEye => noise_at(generator.parameter, camera_p()),
    }
}

/// Returns the direction of the ray that reaches the eye by reflection at the surface, or by
/// refraction into a body with this index.
fn reflected(to_eye: DVec3, n: DVec3, index: Option<f64>) -> DVec3 {
    let Some(e) = unit(to_eye) else { return n };
    let cos = e.dot(n);
    match index {
        None => n * (2.0 * cos) - e,
        Some(index) => {
            let ratio = 1.0 / index;
            let under = 1.0 - ratio * ratio * (1.0 - cos * cos);
            n * (ratio * cos - under.max(0.0).sqrt()) - e * ratio
        }
    }
}

/// Returns two noise values at a position; `parameter` is a scale (one number or three) followed by
/// a translation.
fn noise_at(parameter: &[f64], p: DVec3) -> DVec3 {
    let triple = |i: usize| parameter.get(i..i + 3).map(|v| DVec3::new(v[0], v[1], v[2]));
    let scale = triple(0).or(parameter.first().map(|s| DVec3::splat(*s))).unwrap_or(DVec3::ONE);
    let at = p * scale + triple(3).unwrap_or(DVec3::ZERO);
    DVec3::new(noise(at), noise(at + DVec3::new(37.25, -19.5, 11.75)), 0.0)
}

/// Returns gradient noise in -1..1: each lattice point has a gradient, and their contributions are
/// blended by 6t^5 - 15t^4 + 10t^3.
fn noise(at: DVec3) -> f64 {
    let cell = at.floor();
    let inside = at - cell;
    let fade = inside * inside * inside * (inside * (inside * 6.0 - 15.0) + 10.0);
    let corner = |dx: f64, dy: f64, dz: f64| {
        let d = DVec3::new(dx, dy, dz);
        gradient(cell + d).dot(inside - d)
    };
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let along_x = |y: f64, z: f64| mix(corner(0.0, y, z), corner(1.0, y, z), fade.x);
    let along_y = |z: f64| mix(along_x(0.0, z), along_x(1.0, z), fade.y);
    mix(along_y(0.0), along_y(1.0), fade.z)
}

/// Returns the gradient of a lattice point: the direction to one of a cube's twelve edges, by a
/// hash of its position.
fn gradient(cell: DVec3) -> DVec3 {
    let mut hash = 0x9e37_79b9_7f4a_7c15_u64;
    for c in cell.to_array() {
        hash = (hash ^ c.to_bits()).wrapping_mul(0xff51_afd7_ed55_8ccd);
        hash ^= hash >> 32;
    }
    let [a, b] = [1, 2].map(|bit| if hash >> bit & 1 == 1 { 1.0 } else { -1.0 });
    match hash >> 8 & 0xff {
        0..85 => DVec3::new(a, b, 0.0),
        85..170 => DVec3::new(a, 0.0, b),
        _ => DVec3::new(0.0, a, b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::scene::{LookAt, NONE};

    /// Returns the coordinates of one corner at `p` with normal `n`, for a camera on +x that looks
    /// at 0 0 0 with y up.
    fn at(mode: Mode, parameter: &[f64], p: DVec3, n: DVec3) -> DVec2 {
        let corner = fbptr_core::scene::Corner { position: 0, normal: 0, texcoord: NONE, color: NONE };
        let mesh = Mesh { positions: vec![p], normals: vec![n], corners: vec![corner], ..Mesh::default() };
        let look_at = LookAt { eye: DVec3::X * 5.0, reference: DVec3::ZERO, up: DVec3::Y };
        let camera = Camera { look_at, ..Camera::default() };
        let place = SurfaceFrame::new(DVec3::new(2.0, 1.0, 1.0), DMat4::IDENTITY, Some(&camera));
        texcoords(&Generator { mode, parameter }, &mesh, &place)[0]
    }

    #[test]
    fn every_mode_is_the_tables() {
        let (p, n) = (DVec3::new(0.5, 2.0, 3.0), DVec3::new(0.0, 0.6, 0.8));
        // In the camera: x is -z, y is y, z is x; the position is 1 2 3 there as a geometry, 4
        // behind the eye's plane.
        for (mode, parameter, expected) in [
            (Mode::Sphere, &[][..], [0.1, 0.8]),
            (Mode::CameraNormal, &[], [-0.8, 0.6]),
            (Mode::CameraPosition, &[], [-3.0, 2.0]),
            (Mode::CoordEye, &[], [-3.0, 2.0]),
            (Mode::SphereLocal, &[], [0.5, 0.8]),
            (Mode::Coord, &[], [1.0, 2.0]),
            (Mode::SphereReflectLocal, &[0.0, 1.0, 2.0, 8.0], [0.5, 0.98]),
        ] {
            let found = at(mode, parameter, p, n);
            assert!((found - DVec2::from(expected)).length() < 1e-12, "{mode:?}: {found}");
        }
        // At the center of the picture, a mirror at 45 degrees shows what is above.
        let up = at(
            Mode::CameraReflection,
            &[],
            DVec3::ZERO,
            DVec3::new(2.0, 1.0, 0.0) * DVec3::new(1.0, 1.0, 1.0),
        );
        assert!((up - DVec2::Y).length() < 1e-12, "{up}");
        let up = at(Mode::SphereReflect, &[1.0], DVec3::ZERO, DVec3::new(2.0, 1.0, 0.0));
        assert!((up - DVec2::new(0.5, 1.0)).length() < 1e-12, "{up}");
        // Seen perpendicularly, a refracted ray is not deflected.
        let on = at(Mode::SphereReflect, &[1.5], DVec3::ZERO, DVec3::X);
        assert!((on - DVec2::splat(0.5)).length() < 1e-12, "{on}");
    }

    #[test]
    fn noise_is_0_on_the_lattice_and_smooth_between() {
        assert_eq!(noise(DVec3::new(3.0, -2.0, 7.0)), 0.0);
        let mut last = noise(DVec3::ZERO);
        let (mut least, mut most) = (0.0_f64, 0.0_f64);
        for k in 1..4000 {
            let now = noise(DVec3::new(0.37, 0.81, 0.59) * f64::from(k) * 0.01);
            assert!((now - last).abs() < 0.05 && now.abs() <= 1.0, "{k}: {last} then {now}");
            (least, most, last) = (least.min(now), most.max(now), now);
        }
        assert!(least < -0.3 && most > 0.3, "{least} {most}");
        let scaled = noise_at(&[2.0, 2.0, 2.0, 0.5, 0.0, 0.0], DVec3::new(0.25, 0.5, 1.0));
        assert_eq!(scaled.x, noise(DVec3::new(1.0, 1.0, 2.0)));
        assert_eq!(noise_at(&[3.0], DVec3::splat(0.1)).x, noise(DVec3::splat(0.1) * 3.0));
    }

    #[test]
    fn the_tables_words_are_modes() {
        for word in [
            "SPHERE",
            "CAMERASPACENORMAL",
            "CAMERASPACEPOSITION",
            "CAMERASPACEREFLECTIONVECTOR",
            "SPHERE-LOCAL",
            "COORD",
        ] {
            assert!(Mode::from_word(word).is_some(), "{word}");
        }
        for word in ["COORD-EYE", "NOISE", "NOISE-EYE", "SPHERE-REFLECT", "SPHERE-REFLECT-LOCAL"] {
            assert!(Mode::from_word(word).is_some(), "{word}");
        }
        assert_eq!(Mode::from_word("CUBE"), None);
    }
}

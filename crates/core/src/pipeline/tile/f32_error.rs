//! Error of a blended face's colour in f32, which decides how near to the boundary between two bytes
//! the plain path computes a pixel.
//!
//! Right: the estimate is at least what f32 loses in all but a pixel of some hundred thousand, so that
//! bytes are the plain path's; too large an estimate costs time alone. What is estimated: a highlight
//! multiplies a cosine's error by its exponent, the edge of a spot by its slope, a light by its colour;
//! positions between far corners lose digits that a light, an eye or fog nearby needs. Not estimated:
//! attenuated lights beyond white, whether a light faces the surface, and the ends of radii and cones,
//! which either side of a tie decides.

use super::lighting::{Cone, Exponent, LightPosition, MaterialLighting, NEAR_LIGHT};
use glam::{DVec3, Vec3};

/// Distance from the boundary between two bytes within which f32 does not decide, in bytes.
pub const EDGE: f32 = 1.0 / 1024.0;

/// This distance under fog, for colours up to white: distances in f32 lose some digits.
pub const FOG_EDGE: f32 = 1.0 / 128.0;

/// Error of a cosine in f32.
const COSINE_ERROR: f64 = 3.5e-7;

/// Error of a position in f32, in parts of the distance of the farthest corner.
const POSITION_ERROR: f64 = 1.5e-7;

/// Error of directions that is neglected beside [`EDGE`] but for highlights: few pixels have it.
const SMALL_ANGLE: f64 = 1.5e-5;

/// Largest slope of fog, in parts of 1 / its range: exponential fog's at half the range.
const FOG_SLOPE: f64 = 1.5;

/// Error of a face's colours in f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct F32Error {
    /// Bytes for each unit of colour, from 1 unit on.
    pub color: f32,
    /// Bytes for each unit of a highlight.
    pub highlight: f32,
}

impl F32Error {
    /// Error of colours that are known at the corners.
    pub const OF_COLORS: F32Error = F32Error { color: EDGE, highlight: 0.0 };

    /// Returns the error of a face's colours that are lit per pixel. Corners and lights are in the same
    /// space; the eye is at its origin unless the projection `is_parallel`.
    pub fn of_pixels(lighting: &MaterialLighting, corners: [DVec3; 3], is_parallel: bool) -> F32Error {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let sphere = Sphere::around(corners);
        // A point is at least as far from the face as from its plane, and from a sphere around it.
        let distance = |p: DVec3| normal.dot(p - a).abs().max(sphere.distance(p));
        F32Error::with_angle(lighting, angle_error(lighting, farthest(corners), distance, is_parallel))
    }

    /// Returns the error for all faces of a mesh within a sphere, in the same space, if lights and eye
    /// are so far from it that hardly more is estimated than for any face.
    pub fn of_mesh(lighting: &MaterialLighting, sphere: &Sphere, is_parallel: bool) -> Option<F32Error> {
        let farthest = sphere.center.length() + sphere.radius;
        let angle = angle_error(lighting, farthest, |p| sphere.distance(p), is_parallel);
        let root = highlight_exponent(lighting).max(1.0).sqrt();
        let is_small = angle <= (f64::from(EDGE) / (255.0 * root)).max(root * COSINE_ERROR);
        is_small.then(|| F32Error::with_angle(lighting, angle))
    }

    /// Returns the error of colours whose directions to lights and eye are off by `angle` radians.
    fn with_angle(lighting: &MaterialLighting, angle: f64) -> F32Error {
        let exponent = highlight_exponent(lighting);
        let beyond = (angle - SMALL_ANGLE).max(0.0) + cone_slope(lighting) * (COSINE_ERROR + angle);
        // Where a highlight is bright, the angle is below 1 / sqrt(n), and so is its cosine's slope.
        let highlight = exponent * COSINE_ERROR + exponent.sqrt() * angle;
        // A byte is 255 of a unit.
        let cosine = EDGE.max((255.0 * COSINE_ERROR * brightness(lighting)) as f32);
        F32Error { color: cosine + (255.0 * beyond) as f32, highlight: (255.0 * highlight) as f32 }
    }

    /// Returns the error with fog of this range, whose corners are given relative to the eye.
    pub fn in_fog(self, range: f64, corners: [DVec3; 3]) -> F32Error {
        let position = POSITION_ERROR * farthest(corners);
        F32Error { color: self.color.max(FOG_EDGE) + (255.0 * FOG_SLOPE * position / range) as f32, ..self }
    }
}

/// Returns the distance of the farthest corner from the origin.
fn farthest(corners: [DVec3; 3]) -> f64 {
    corners.iter().fold(0.0, |m, p| m.max(p.length()))
}

/// Sphere around points.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    /// Its centre.
    pub center: DVec3,
    /// Its radius.
    pub radius: f64,
}

impl Sphere {
    /// Returns a sphere around a face's corners.
    fn around(corners: [DVec3; 3]) -> Sphere {
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        let radius2 = corners.iter().fold(0.0f64, |m, p| m.max(p.distance_squared(center)));
        Sphere { center, radius: radius2.sqrt() }
    }

    /// Returns the distance of a point from the sphere; below 0 inside.
    fn distance(&self, p: DVec3) -> f64 {
        p.distance(self.center) - self.radius
    }
}

/// Returns the error of directions to lights and eye, in radians, that the error of positions up to
/// `farthest` from the origin makes, for points at least `distance` from each of those.
fn angle_error(
    lighting: &MaterialLighting,
    farthest: f64,
    distance: impl Fn(DVec3) -> f64,
    is_parallel: bool,
) -> f64 {
    let eye = if is_parallel { f64::INFINITY } else { distance(DVec3::ZERO) };
    // Nearer lights are left to f64 by the kernels.
    let least = if is_parallel { 0.0 } else { f64::from(NEAR_LIGHT) * eye };
    let nearest = lighting.lights.iter().fold(eye, |nearest, light| match light.position {
        LightPosition::Toward(_) => nearest,
        LightPosition::At(p) => nearest.min(distance(Vec3::from(p).as_dvec3()).max(least)),
    });
    POSITION_ERROR * farthest / nearest.max(f64::MIN_POSITIVE)
}

/// Returns the sum of the diffuse lights without attenuation, in the brightest channel.
fn brightness(lighting: &MaterialLighting) -> f64 {
    let even = lighting.lights.iter().filter(|light| light.attenuation.is_none());
    even.map(|light| f64::from(light.diffuse.iter().fold(0.0f32, |m, c| m.max(c.abs())))).sum()
}

/// Returns the largest slope within the cone of a spot, in parts of its light for each unit of a cosine.
fn cone_slope(lighting: &MaterialLighting) -> f64 {
    let slope = |cone: Cone| match cone {
        Cone::None => 0.0,
        Cone::Power { exponent, .. } => f64::from(exponent.at_least_one()),
        Cone::Linear { beam, cut_off, .. } if beam < cut_off => {
            let (beam, cut_off) = (f64::from(beam), f64::from(cut_off));
            // An angle's error is that of its cosine over its sine, and at 0 the root of it.
            let sine = libm::sin(beam).min(libm::sin(cut_off)).max(1e-3);
            1.0 / (sine * (cut_off - beam))
        }
        Cone::Linear { .. } => 0.0,
    };
    lighting.lights.iter().map(|light| slope(light.cone)).fold(0.0, f64::max)
}

/// Returns the exponent of the highlights; 0 if there are none.
fn highlight_exponent(lighting: &MaterialLighting) -> f64 {
    match lighting.lights.iter().any(|light| light.specular != [0.0; 3]) {
        true => f64::from(lighting.exponent.at_least_one()),
        false => 0.0,
    }
}

/// Returns whether f32 carries an exponent where bytes are to be the plain path's: near 0, powers below
/// 1 are steeper than any estimate.
pub fn has_estimate(exponent: Exponent) -> bool {
    match exponent {
        Exponent::Integer(_) => true,
        Exponent::Real(n) => n >= 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::tile::lighting::FastLight;

    /// Returns the lighting of a material with one lamp.
    fn lit_by(lamp: [f32; 3], exponent: u32) -> MaterialLighting {
        let light = FastLight {
            position: LightPosition::At(lamp),
            cone: Cone::None,
            reach2: f32::INFINITY,
            is_reach_faded: false,
            least_cosine2: -1.0,
            ambient: [0.0; 3],
            diffuse: [1.0; 3],
            specular: [if exponent > 0 { 1.0 } else { 0.0 }; 3],
            dark_cosine: -1.0,
            attenuation: None,
            is_clamped: false,
        };
        let constant = MaterialLighting::constant([0.0; 3], [0.0; 3]);
        MaterialLighting { lights: vec![light], exponent: Exponent::Integer(exponent), ..constant }
    }

    /// Returns ground two units below the eye that reaches `far` to three sides.
    fn ground(far: f64) -> [DVec3; 3] {
        [[-far, -far], [far, -far], [0.0, far]].map(|[x, z]| DVec3::new(x, -2.0, z))
    }

    #[test]
    fn far_corners_matter_by_the_distance_of_the_nearest_of_eye_and_lamp() {
        let color = |lamp, far| F32Error::of_pixels(&lit_by(lamp, 0), ground(far), false).color - EDGE;
        assert_eq!(color([0.0, 3.0, 0.0], 10.0), 0.0);
        // 1414 from the eye, 2 above the ground: 255 * (1.5e-7 * 1414 / 2 - 1.5e-5) bytes.
        assert!((color([0.0, 3.0, 0.0], 1e3) - 0.0232).abs() < 1e-3);
        assert!(color([0.0, -1.5, 0.0], 1e3) > 3.0 * color([0.0, 3.0, 0.0], 1e3));
    }

    #[test]
    fn a_mesh_away_from_eye_and_lamp_has_one_error_and_no_smaller_one_than_its_faces() {
        let lighting = lit_by([0.0, 5.0, 0.0], 32);
        let near = ground(1.0);
        let sphere = Sphere::around(near);
        let of_mesh = F32Error::of_mesh(&lighting, &Sphere { radius: 1.0, ..sphere }, false).unwrap();
        let of_face =
            F32Error::of_pixels(&lighting, near.map(|p| sphere.center + (p - sphere.center) * 0.5), false);
        assert!(of_mesh.highlight >= of_face.highlight && of_mesh.color >= of_face.color);
        assert_eq!(F32Error::of_mesh(&lighting, &Sphere::around(ground(1e3)), false), None);
    }

    #[test]
    fn sharp_highlights_and_narrow_spots_have_large_errors() {
        let of = |lighting: &MaterialLighting| F32Error::of_pixels(lighting, ground(1.0), false);
        let [dull, sharp] = [8, 1000].map(|n| of(&lit_by([0.0, 5.0, 0.0], n)).highlight);
        assert!(sharp > 50.0 * dull && sharp > 0.05, "{dull} {sharp}");
        let mut lighting = lit_by([0.0, 5.0, 0.0], 0);
        let mut color = |beam, cut_off| {
            lighting.lights[0].cone = Cone::Linear { axis: [0.0, -1.0, 0.0], beam, cut_off };
            of(&lighting).color
        };
        assert!(color(0.045, 0.055) > 0.1 && color(0.3, 0.9) < 2.0 * EDGE);
        assert_eq!(color(1.57, 0.78), EDGE);
    }
}

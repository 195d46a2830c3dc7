//! Lighting equations, term by term, in f64.
//!
//! Phong (000): Ke + Ka Ia + sum att (Kd max(N.L,0) + Ks max(R.V,0)^n), R = 2(N.L)N - L; X3D and
//! MTL: Blinn's H = (L+V)/|L+V| in place of R.V. The specular term is added only if N.L > 0.
//! Colours are never clamped here. If a decision is borderline (N.L = 0, a spot's edge, a light's
//! radius, each within 1e-6), both results are returned.

use super::camera::ViewerPosition;
use fbptr_core::math::matrix::unit;
use fbptr_core::scene::{Attenuation, Light, LightKind, LightingModel, Material};
use glam::DVec3;

/// Distance from N.L = 0 or from a spot's edge (as a cosine) within which both sides are accepted.
pub const LIGHT_TURN: f64 = 1e-6;

/// Largest number of results for one point: borderline decisions beyond it are taken as computed.
const MAX_ANSWERS: usize = 8;

/// Result of the lighting equation: the part that a texture multiplies, and the part that it does
/// not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitColor {
    /// Ka and Kd terms (the emission, for an unlit material).
    pub diffuse_ambient: DVec3,
    /// Ks and Ke terms.
    pub specular_emissive: DVec3,
}

/// Lights of a draw that reach one object.
#[derive(Clone, Debug)]
pub struct ObjectLighting<'a> {
    /// Ambient light Ia.
    pub ambient: DVec3,
    /// Lights that reach the object.
    pub lights: Vec<&'a Light>,
    /// Origin of V.
    pub viewer: ViewerPosition,
}

/// Returns the accepted values of a factor: one, or both sides of a borderline decision.
fn sides(value: f64, turns: bool, other: f64) -> Vec<f64> {
    if turns && value != other { vec![value, other] } else { vec![value] }
}

fn attenuation(a: &Attenuation, d: f64, clamp: bool) -> f64 {
    let sum = a.c + a.l * d + a.q * d * d;
    1.0 / if clamp { sum.max(1.0) } else { sum }
}

/// Returns the unit direction from `p` to the light and the accepted factors on its colour, or
/// `None` if it adds nothing.
fn reach(light: &Light, p: DVec3) -> Option<(DVec3, Vec<f64>)> {
    let clamp = light.clamp_attenuation;
    let from_point = |position: DVec3| {
        let to_light = unit(position - p)?;
        Some((to_light, position.distance(p)))
    };
    let within = |d: f64, radius: f64| {
        let inside = if d <= radius { 1.0 } else { 0.0 };
        sides(inside, radius.is_finite() && (d - radius).abs() <= LIGHT_TURN * radius.max(1.0), 1.0 - inside)
    };
    match light.kind {
        LightKind::Directional { direction } => Some((-unit(direction)?, vec![1.0])),
        LightKind::Point { position, attenuation: a, radius } => {
            let (l, d) = from_point(position)?;
            let k = attenuation(&a, d, clamp);
            Some((l, within(d, radius).into_iter().map(|w| w * k).collect()))
        }
        LightKind::Spot { position, direction, angle_rad, exponent, attenuation: a } => {
            let (l, d) = from_point(position)?;
            let cos = (-l).dot(unit(direction)?);
            let edge = libm::cos(angle_rad.min(std::f64::consts::PI));
            let full = libm::pow(cos.max(0.0), exponent) * attenuation(&a, d, clamp);
            let value = if cos >= edge { full } else { 0.0 };
            let turns = (cos - edge).abs() <= LIGHT_TURN && angle_rad < std::f64::consts::PI;
            Some((l, sides(value, turns, full - value)))
        }
        LightKind::X3dSpot { position, direction, beam_width_rad, cut_off_rad, attenuation: a, radius } => {
            let (l, d) = from_point(position)?;
            let cos = (-l).dot(unit(direction)?);
            let angle = libm::acos(cos.clamp(-1.0, 1.0));
            let factor = if angle >= cut_off_rad {
                0.0
            } else if angle <= beam_width_rad {
                1.0
            } else {
                (angle - cut_off_rad) / (beam_width_rad - cut_off_rad)
            };
            // Only a beam at least as wide as the cone ends in a step.
            let jumps = beam_width_rad >= cut_off_rad && (cos - libm::cos(cut_off_rad)).abs() <= LIGHT_TURN;
            let k = attenuation(&a, d, clamp);
            let mut values = Vec::new();
            for spot in sides(factor, jumps, 1.0 - factor) {
                values.extend(within(d, radius).into_iter().map(|w| w * k * spot));
            }
            Some((l, values))
        }
    }
}

/// Returns the base of the specular power: max(R.V, 0) or max(N.H, 0).
fn specular_cosine(model: LightingModel, n: DVec3, l: DVec3, v: DVec3) -> f64 {
    match model {
        LightingModel::Phong => (2.0 * n.dot(l) * n - l).dot(v).max(0.0),
        LightingModel::Blinn => unit(l + v).map_or(0.0, |h| n.dot(h).max(0.0)),
        LightingModel::Unlit => 0.0,
    }
}

/// Returns the accepted colours of a surface point, usually one.
///
/// `p` is the world point, `n` its unit normal, `albedo` the vertex colour there (1 if there is
/// none), which multiplies the same part as a texture.
pub fn light_point(
    m: &Material,
    albedo: DVec3,
    p: DVec3,
    n: DVec3,
    lighting: &ObjectLighting,
) -> Vec<LitColor> {
    if m.model == LightingModel::Unlit {
        return vec![LitColor { diffuse_ambient: m.emissive * albedo, specular_emissive: DVec3::ZERO }];
    }
    let v = match lighting.viewer {
        ViewerPosition::Eye(eye) => unit(eye - p).unwrap_or(DVec3::ZERO),
        ViewerPosition::Axis(axis) => axis,
    };
    let mut answers =
        vec![LitColor { diffuse_ambient: m.ka * lighting.ambient, specular_emissive: m.emissive }];
    for light in &lighting.lights {
        let Some((l, factors)) = reach(light, p) else { continue };
        let n_dot_l = n.dot(l);
        let shine = m.ks * libm::pow(specular_cosine(m.model, n, l, v), m.n);
        let is_lit = if n_dot_l > 0.0 { 1.0 } else { 0.0 };
        let mut options = Vec::new();
        for factor in factors {
            for gate in sides(is_lit, n_dot_l.abs() <= LIGHT_TURN, 1.0 - is_lit) {
                let diffuse = m.ka * light.ambient + m.kd * n_dot_l.max(0.0) * light.color;
                options.push((factor * diffuse, factor * gate * shine * light.color));
            }
        }
        if answers.len() * options.len() > MAX_ANSWERS {
            options.truncate(1);
        }
        answers = answers
            .iter()
            .flat_map(|a| {
                options.iter().map(|o| LitColor {
                    diffuse_ambient: a.diffuse_ambient + o.0,
                    specular_emissive: a.specular_emissive + o.1,
                })
            })
            .collect();
    }
    for a in &mut answers {
        a.diffuse_ambient *= albedo;
    }
    answers.dedup();
    answers
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(kind: LightKind) -> Light {
        Light { kind, color: DVec3::ONE, ambient: DVec3::ZERO, clamp_attenuation: false }
    }

    fn one(m: &Material, n: DVec3, p: DVec3, lights: &[Light]) -> Vec<LitColor> {
        let lighting = ObjectLighting {
            ambient: DVec3::ONE,
            lights: lights.iter().collect(),
            viewer: ViewerPosition::Eye(DVec3::new(0.0, 0.0, 5.0)),
        };
        light_point(m, DVec3::ONE, p, n, &lighting)
    }

    #[test]
    fn phong_by_hand() {
        // L = (0, .6, .8), N = V = z: N.L = .8, R = (0, -.6, .8), R.V = .8, .8^2 = .64.
        let m = Material { ka: DVec3::splat(0.1), ks: DVec3::splat(0.5), n: 2.0, ..Material::default() };
        let dir = light(LightKind::Directional { direction: DVec3::new(0.0, -0.6, -0.8) });
        let lit = one(&m, DVec3::Z, DVec3::ZERO, &[dir]);
        assert_eq!(lit.len(), 1);
        assert!((lit[0].diffuse_ambient - DVec3::splat(0.1 + 0.8 * 0.8)).length() < 1e-15);
        assert!((lit[0].specular_emissive - DVec3::splat(0.5 * 0.64)).length() < 1e-15);
    }

    #[test]
    fn a_light_at_the_point_gives_nothing_and_zero_to_the_zero_is_one() {
        let a = Attenuation { c: 0.0, l: 0.0, q: 1.0 };
        let at = light(LightKind::Point { position: DVec3::ZERO, attenuation: a, radius: f64::INFINITY });
        let m = Material { ks: DVec3::ONE, n: 0.0, ..Material::default() };
        assert_eq!(one(&m, DVec3::Z, DVec3::ZERO, &[at])[0].diffuse_ambient, DVec3::ZERO);
        // R.V < 0 but N.L > 0: 0 to the power 0 counts as 1.
        let low = light(LightKind::Directional { direction: DVec3::new(-1.0, 0.0, -0.1) });
        let eye_side = one(&m, DVec3::Z, DVec3::new(9.0, 0.0, 4.9), &[low]);
        assert_eq!(eye_side[0].specular_emissive, DVec3::ONE);
    }

    #[test]
    fn both_sides_of_a_turn_are_given() {
        let m = Material { ks: DVec3::ONE, n: 1.0, ..Material::default() };
        let grazing = light(LightKind::Directional { direction: DVec3::new(0.0, -1.0, -1e-8) });
        let answers = one(&m, DVec3::Z, DVec3::new(0.0, 1.0, 0.0), &[grazing]);
        assert_eq!(answers.len(), 2);
        assert!(answers[0].specular_emissive != answers[1].specular_emissive);
        let spot = light(LightKind::Spot {
            position: DVec3::Z,
            direction: -DVec3::Z,
            angle_rad: std::f64::consts::FRAC_PI_4,
            exponent: 0.0,
            attenuation: Attenuation::NONE,
        });
        assert_eq!(one(&m, DVec3::Z, DVec3::X, &[spot]).len(), 2);
        assert_eq!(one(&m, DVec3::Z, DVec3::X * 0.9, &[spot]).len(), 1);
    }
}

//! Lights, in world space.

use glam::DVec3;

/// Attenuation 1 / (c + l d + q d^2) over the distance d from light to surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attenuation {
    /// Constant term.
    pub c: f64,
    /// Linear term, per unit of distance.
    pub l: f64,
    /// Quadratic term, per square unit of distance.
    pub q: f64,
}

impl Attenuation {
    /// No attenuation: 1, 0, 0.
    pub const NONE: Attenuation = Attenuation { c: 1.0, l: 0.0, q: 0.0 };
}

/// Kind of a light source, with its position or direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Point light: shines in all directions. It adds 0 at a surface point in the same place.
    Point {
        /// World position.
        position: DVec3,
        /// Attenuation over distance.
        attenuation: Attenuation,
        /// Distance beyond which the light adds nothing (X3D's radius), or infinity.
        radius: f64,
    },
    /// Directional light: infinitely far away.
    Directional {
        /// World direction in which the light travels.
        direction: DVec3,
    },
    /// Spot light of the command language: scaled by cos^exponent inside `angle_rad`, nothing
    /// outside.
    Spot {
        /// World position.
        position: DVec3,
        /// World direction of the cone's axis, in which the light travels.
        direction: DVec3,
        /// Half angle of the cone in radians.
        angle_rad: f64,
        /// Exponent of the cosine between axis and ray.
        exponent: f64,
        /// Attenuation over distance.
        attenuation: Attenuation,
    },
    /// Spot light of X3D: full strength inside `beam_width_rad`, falling to 0 at `cut_off_rad`.
    X3dSpot {
        /// World position.
        position: DVec3,
        /// World direction of the cone's axis, in which the light travels.
        direction: DVec3,
        /// Half angle of the full beam in radians.
        beam_width_rad: f64,
        /// Half angle in radians at which the light ends.
        cut_off_rad: f64,
        /// Attenuation over distance.
        attenuation: Attenuation,
        /// Distance beyond which the light adds nothing.
        radius: f64,
    },
}

/// Light source of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Kind and placement.
    pub kind: LightKind,
    /// R, G, B strength, with the intensity multiplied in; may exceed 1.
    pub color: DVec3,
    /// X3D's ambientIntensity times colour: added to the ambient term, with the same attenuation.
    /// Elsewhere 0.
    pub ambient: DVec3,
    /// True if the attenuation's denominator is at least 1 (X3D); false for the command language.
    pub clamp_attenuation: bool,
}

impl Light {
    /// Creates a light at `position` that shines equally in all directions, without attenuation.
    pub fn point(position: DVec3, color: DVec3) -> Self {
        let kind = LightKind::Point { position, attenuation: Attenuation::NONE, radius: f64::INFINITY };
        Light { kind, color, ambient: DVec3::ZERO, clamp_attenuation: false }
    }

    /// Creates a light from infinitely far away that travels along `direction`.
    pub fn directional(direction: DVec3, color: DVec3) -> Self {
        let kind = LightKind::Directional { direction };
        Light { kind, color, ambient: DVec3::ZERO, clamp_attenuation: false }
    }
}

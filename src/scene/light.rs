//! Lights, in world space.

use glam::DVec3;

/// 1 / (c + l d + q d^2) over the distance d from light to surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attenuation {
    /// Constant term.
    pub c: f64,
    /// Linear term, per unit of distance.
    pub l: f64,
    /// Quadratic term, per square unit.
    pub q: f64,
}

impl Attenuation {
    /// No attenuation: 1, 0, 0.
    pub const NONE: Attenuation = Attenuation { c: 1.0, l: 0.0, q: 0.0 };
}

/// Where a light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// From a point, in all directions. A light at the surface point gives 0.
    Point {
        /// World position.
        position: DVec3,
        /// Attenuation over distance.
        attenuation: Attenuation,
        /// Beyond this distance the light gives nothing (X3D's radius); infinity otherwise.
        radius: f64,
    },
    /// From infinitely far away.
    Directional {
        /// The world direction in which light travels.
        direction: DVec3,
    },
    /// From a point, in a cone of the command language: full strength times cos^exponent inside `angle`, none outside.
    Spot {
        /// World position.
        position: DVec3,
        /// The world direction of the cone's axis, in which light travels.
        direction: DVec3,
        /// Half angle of the cone, radians.
        angle_rad: f64,
        /// The power of the cosine between axis and ray.
        exponent: f64,
        /// Attenuation over distance.
        attenuation: Attenuation,
    },
    /// X3D's SpotLight: full inside `beam_width`, falling off to 0 at `cut_off`.
    X3dSpot {
        /// World position.
        position: DVec3,
        /// The world direction of the cone's axis.
        direction: DVec3,
        /// Half angle of the full beam, radians.
        beam_width_rad: f64,
        /// Half angle at which the light ends, radians.
        cut_off_rad: f64,
        /// Attenuation over distance.
        attenuation: Attenuation,
        /// Beyond this distance the light gives nothing.
        radius: f64,
    },
}

/// One light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Kind and place.
    pub kind: LightKind,
    /// R, G, B strength (intensity already multiplied in); may exceed 1.
    pub color: DVec3,
    /// X3D's ambientIntensity times colour: what this light adds to the ambient term, attenuated with it. 0 elsewhere.
    pub ambient: DVec3,
    /// X3D clamps the attenuation's denominator at 1 from below; the command language does not.
    pub clamp_attenuation: bool,
}

impl Light {
    /// A light at `position` that shines everywhere alike.
    pub fn point(position: DVec3, color: DVec3) -> Self {
        let kind = LightKind::Point { position, attenuation: Attenuation::NONE, radius: f64::INFINITY };
        Light { kind, color, ambient: DVec3::ZERO, clamp_attenuation: false }
    }

    /// A light from infinitely far away that travels along `direction`.
    pub fn directional(direction: DVec3, color: DVec3) -> Self {
        let kind = LightKind::Directional { direction };
        Light { kind, color, ambient: DVec3::ZERO, clamp_attenuation: false }
    }
}

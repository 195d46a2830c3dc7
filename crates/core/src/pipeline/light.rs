//! Lighting equations: the colour of a point of a surface.
//!
//! Phong (notes 000): Ke + Ka Ia + sum att (Kd max(N.L,0) + Ks max(R.V,0)^n) Il, R = 2(N.L)N - L;
//! Blinn (X3D, MTL): H = (L+V)/|L+V| in place of R. Specular light occurs only where N.L > 0. All
//! vectors are unit vectors in world space; L points to the light, V to the viewer. The terms that
//! a texture multiplies (Ka and Kd) and those that it does not (Ks and Ke) are separate.

use crate::math::matrix::unit;
use crate::math::power::pow;
use crate::scene::{Attenuation, CameraMatrices, Light, LightKind, LightingModel, Material};
use glam::DVec3;

/// Maximum attenuation factor: with 1/0 a black colour would become 0 * inf.
const MAX_FACTOR: f64 = 1e30;

/// A lit colour in two parts, each R, G, B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LitColor {
    /// The Ka and Kd terms: multiplied by vertex colour and texture.
    pub diffuse_ambient: DVec3,
    /// The Ks and Ke terms.
    pub specular_emissive: DVec3,
}

/// A point to be lit, in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePoint {
    pub position: DVec3,
    /// Unit vector, or zero if the surface has none.
    pub normal: DVec3,
}

/// Source of the view vector V.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ViewerPosition {
    /// V points from each surface point to this eye position.
    Eye(DVec3),
    /// V is constant (parallel projections).
    Axis(DVec3),
}

impl ViewerPosition {
    /// Returns the viewer's position or direction for a camera.
    pub fn of(camera: &CameraMatrices) -> Self {
        match camera.is_parallel {
            true => ViewerPosition::Axis(camera.to_viewer),
            false => ViewerPosition::Eye(camera.eye),
        }
    }

    /// Returns V; zero at the eye itself.
    fn direction_from(&self, position: DVec3) -> DVec3 {
        match *self {
            ViewerPosition::Eye(eye) => unit(eye - position).unwrap_or(DVec3::ZERO),
            ViewerPosition::Axis(axis) => axis,
        }
    }
}

/// Number of lights from which on each tile of a frame has a list of those that reach it.
pub(crate) const MANY_LIGHTS: usize = 6;

/// A light with the values that do not depend on the surface point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedLight {
    pub light: Light,
    /// For a directional light, the unit vector towards it; for spots, the unit axis; zero without
    /// direction.
    pub direction: DVec3,
    /// Cosine of a SPOT's half angle.
    pub cos_angle: f64,
}

impl PreparedLight {
    fn new(light: &Light) -> Self {
        let (direction, cos_angle) = match light.kind {
            LightKind::Point { .. } => (DVec3::ZERO, 0.0),
            LightKind::Directional { direction } => (-unit(direction).unwrap_or(DVec3::ZERO), 0.0),
            LightKind::Spot { direction, angle_rad, .. } => (
                unit(direction).unwrap_or(DVec3::ZERO),
                libm::cos(angle_rad.clamp(0.0, std::f64::consts::PI)),
            ),
            LightKind::X3dSpot { direction, .. } => (unit(direction).unwrap_or(DVec3::ZERO), 0.0),
        };
        PreparedLight { light: *light, direction, cos_angle }
    }

    /// Returns L and the light's strength at `p` (attenuation times cone); `None` if the light does
    /// not reach it.
    fn reach(&self, p: DVec3) -> Option<(DVec3, f64)> {
        let clamped = self.light.clamp_attenuation;
        match self.light.kind {
            LightKind::Directional { .. } => Some((self.direction, 1.0)),
            LightKind::Point { position, attenuation, radius } => {
                let (l, d) = towards(position, p)?;
                (d <= radius).then(|| (l, strength(attenuation, d, clamped)))
            }
            LightKind::Spot { position, exponent, attenuation, .. } => {
                let (l, d) = towards(position, p)?;
                let cos = (-l).dot(self.direction);
                (cos >= self.cos_angle)
                    .then(|| (l, strength(attenuation, d, clamped) * pow(cos.clamp(0.0, 1.0), exponent)))
            }
            LightKind::X3dSpot { position, beam_width_rad, cut_off_rad, attenuation, radius, .. } => {
                let (l, d) = towards(position, p)?;
                let angle = libm::acos((-l).dot(self.direction).clamp(-1.0, 1.0));
                let cone = if angle >= cut_off_rad {
                    return None;
                } else if angle <= beam_width_rad {
                    1.0
                } else {
                    (cut_off_rad - angle) / (cut_off_rad - beam_width_rad)
                };
                (d <= radius).then(|| (l, strength(attenuation, d, clamped) * cone))
            }
        }
    }
}

/// Contribution of one light at one point, with intermediate values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightTerm {
    /// L, the unit vector to the light.
    pub to_light: DVec3,
    /// Attenuation times cone.
    pub strength: f64,
    /// N.L; at most 0 if the light is behind the surface.
    pub n_dot_l: f64,
    /// R, or H in the Blinn model; `None` without a specular term.
    pub mirror: Option<DVec3>,
    /// R.V or N.H, clamped to 0..1, and its n-th power.
    pub cosine: f64,
    pub power: f64,
    /// R, G, B of the three terms.
    pub ambient: DVec3,
    pub diffuse: DVec3,
    pub specular: DVec3,
}

impl PreparedLight {
    /// Returns the light's terms at a point; `None` if it does not reach it. `v` is V.
    #[inline]
    fn term(&self, point: SurfacePoint, material: &Material, v: DVec3) -> Option<LightTerm> {
        let (l, strength) = self.reach(point.position)?;
        let n = point.normal;
        let n_dot_l = n.dot(l);
        let mut term = LightTerm {
            to_light: l,
            strength,
            n_dot_l,
            mirror: None,
            cosine: 0.0,
            power: 0.0,
            ambient: material.ka * self.light.ambient * strength,
            diffuse: DVec3::ZERO,
            specular: DVec3::ZERO,
        };
        if n_dot_l.is_nan() || n_dot_l <= 0.0 {
            return Some(term);
        }
        term.diffuse = material.kd * self.light.color * (strength * n_dot_l);
        if material.ks != DVec3::ZERO {
            let (mirror, cosine) = match material.model {
                LightingModel::Blinn => {
                    let h = unit(l + v).unwrap_or(DVec3::ZERO);
                    (h, n.dot(h))
                }
                _ => {
                    let r = n * (2.0 * n_dot_l) - l;
                    (r, r.dot(v))
                }
            };
            term.mirror = Some(mirror);
            term.cosine = cosine.clamp(0.0, 1.0);
            term.power = pow(term.cosine, material.n);
            term.specular = material.ks * self.light.color * (strength * term.power);
        }
        Some(term)
    }
}

/// Returns unit vector and distance from `p` to a light; `None` if they coincide.
fn towards(light: DVec3, p: DVec3) -> Option<(DVec3, f64)> {
    let to = light - p;
    let l = unit(to)?;
    Some((l, to.dot(l)))
}

/// Returns 1 / (c + l d + q d^2); X3D clamps the sum to at least 1.
fn strength(a: Attenuation, d: f64, clamped: bool) -> f64 {
    let sum = a.c + a.l * d + a.q * d * d;
    if sum.is_nan() {
        return 0.0;
    }
    let sum = if clamped { sum.max(1.0) } else { sum };
    (1.0 / sum).clamp(-MAX_FACTOR, MAX_FACTOR)
}

/// The lights of one draw.
#[derive(Clone, Debug)]
pub(crate) struct Lighting {
    prepared_lights: Vec<PreparedLight>,
    ambient: DVec3,
    viewer: ViewerPosition,
}

impl Lighting {
    /// Collects the lights that can contribute, in order; black ones are left out.
    #[cfg(test)]
    pub fn new<'a>(lights: impl Iterator<Item = &'a Light>, ambient: DVec3, viewer: ViewerPosition) -> Self {
        Lighting::new_in(lights, ambient, viewer, Vec::new())
    }

    /// Collects the lights that can contribute into a recycled list.
    pub fn new_in<'a>(
        lights: impl Iterator<Item = &'a Light>,
        ambient: DVec3,
        viewer: ViewerPosition,
        mut prepared_lights: Vec<PreparedLight>,
    ) -> Self {
        let shines = |l: &&Light| l.color != DVec3::ZERO || l.ambient != DVec3::ZERO;
        prepared_lights.clear();
        prepared_lights.extend(lights.filter(shines).map(PreparedLight::new));
        Lighting { prepared_lights, ambient, viewer }
    }

    /// Takes the list, for another draw to reuse.
    pub fn take_lights(&mut self) -> Vec<PreparedLight> {
        std::mem::take(&mut self.prepared_lights)
    }

    /// Returns the lights that can contribute, in order.
    pub fn lights(&self) -> &[PreparedLight] {
        &self.prepared_lights
    }

    /// Returns the number of lights that can contribute.
    pub fn light_count(&self) -> usize {
        self.prepared_lights.len()
    }

    /// Returns whether the lights are so many that each tile has a list of those that reach it, and
    /// some have a radius or an attenuation.
    pub fn has_many_of_bounded_reach(&self) -> bool {
        let is_bounded = |l: &PreparedLight| match l.light.kind {
            LightKind::Directional { .. } => false,
            LightKind::Point { attenuation, radius, .. } | LightKind::X3dSpot { attenuation, radius, .. } => {
                radius < f64::INFINITY || attenuation != Attenuation::NONE
            }
            LightKind::Spot { attenuation, .. } => attenuation != Attenuation::NONE,
        };
        self.light_count() >= MANY_LIGHTS && self.lights().iter().any(is_bounded)
    }

    /// Returns whether the colour of `material` depends on a point's position and normal.
    pub fn depends_on_point(&self, material: &Material) -> bool {
        let answers = |c: DVec3| c != DVec3::ZERO;
        material.model != LightingModel::Unlit
            && self.prepared_lights.iter().any(|l| {
                (answers(l.light.color) && (answers(material.kd) || answers(material.ks)))
                    || (answers(l.light.ambient) && answers(material.ka))
            })
    }

    /// Returns whether the light of `material` depends on where a point is, or on the viewer: it has
    /// highlights, or some light does not come from a direction.
    pub fn depends_on_place(&self, material: &Material) -> bool {
        let comes_from_afar =
            |l: &PreparedLight| matches!(l.light.kind, crate::scene::LightKind::Directional { .. });
        self.depends_on_point(material)
            && (material.ks != DVec3::ZERO || !self.prepared_lights.iter().all(comes_from_afar))
    }

    /// Returns the colour of a material that no light affects.
    pub fn constant(&self, material: &Material) -> LitColor {
        match material.model {
            // The emissive colour is all there is: vertex colour and texture multiply it.
            LightingModel::Unlit => {
                LitColor { diffuse_ambient: material.emissive, specular_emissive: DVec3::ZERO }
            }
            _ => {
                LitColor { diffuse_ambient: material.ka * self.ambient, specular_emissive: material.emissive }
            }
        }
    }

    /// Returns the colour of one point.
    pub fn at(&self, point: SurfacePoint, material: &Material) -> LitColor {
        let mut lit = self.constant(material);
        if material.model == LightingModel::Unlit {
            return lit;
        }
        let v = self.viewer.direction_from(point.position);
        for prepared_light in &self.prepared_lights {
            let Some(term) = prepared_light.term(point, material, v) else { continue };
            lit.diffuse_ambient += term.ambient;
            lit.diffuse_ambient += term.diffuse;
            lit.specular_emissive += term.specular;
        }
        lit
    }

    /// Returns the ambient part of the colour of a point: what of [`Lighting::at`] has Ka as a
    /// factor.
    pub fn ambient_at(&self, position: DVec3, material: &Material) -> DVec3 {
        let reaching = self.prepared_lights.iter().filter_map(|light| {
            let (_, strength) = light.reach(position)?;
            Some(material.ka * light.light.ambient * strength)
        });
        reaching.fold(material.ka * self.ambient, |sum, ambient| sum + ambient)
    }

    /// Returns V at a point, and the terms of each light that reaches it, in order.
    pub fn terms(&self, point: SurfacePoint, material: &Material) -> (DVec3, Vec<LightTerm>) {
        let v = self.viewer.direction_from(point.position);
        let prepared_lights = self.prepared_lights.iter().filter(|_| material.model != LightingModel::Unlit);
        (v, prepared_lights.filter_map(|prepared_light| prepared_light.term(point, material, v)).collect())
    }

    /// Returns the ambient light.
    pub fn ambient(&self) -> DVec3 {
        self.ambient
    }
}

#[cfg(test)]
mod tests;

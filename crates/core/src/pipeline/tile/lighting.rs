//! Lighting of a vector of points: the pipeline's equations in f32, in shading space.
//!
//! Shading space has its origin at the eye, so that no digits are lost far from the world's origin,
//! and the axes in which the normals are given. The equations are those of `pipeline::light`;
//! exponents are 0, or 0.4 to 1000.

use crate::scene::LightingModel;
use crate::simd::{F32, I32, Mask, Simd};
use std::f32::consts::FRAC_PI_2;
use std::f64::consts::PI;

/// Vector of points or directions: x, y, z.
pub type V3<S> = [<S as Simd>::F; 3];

/// Position of a light in shading space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightPosition {
    /// Unit vector towards the light.
    Toward([f32; 3]),
    /// Position of the light.
    At([f32; 3]),
}

/// Directions in which a light shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cone {
    /// All directions.
    None,
    /// Within an angle of the axis, with a power of the cosine.
    Power {
        /// Unit vector in which the light travels.
        axis: [f32; 3],
        /// Cosine of the angle.
        cos_angle: f32,
        /// Power of the cosine.
        exponent: Exponent,
    },
    /// Full within one angle, none from another on, linear between.
    Linear {
        /// Unit vector in which the light travels.
        axis: [f32; 3],
        /// Angle of the full beam, in radians.
        beam: f32,
        /// Angle at which the light ends, in radians.
        cut_off: f32,
    },
}

/// Light with the material's coefficients multiplied in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FastLight {
    /// Position, or direction towards the light.
    pub position: LightPosition,
    /// Directions in which it shines.
    pub cone: Cone,
    /// Square of the distance beyond which it gives nothing, or so little that it is left out (see
    /// [`FaintLight`]). Below 0 for a light that reaches nothing.
    pub reach2: f32,
    /// True if that distance is one of fading, not the light's radius.
    pub is_reach_faded: bool,
    /// Square of a cosine below which a point is outside of the cone; below 0 for none.
    pub least_cosine2: f32,
    /// Ka times the light's own ambient colour.
    pub ambient: [f32; 3],
    /// Kd times the light's colour.
    pub diffuse: [f32; 3],
    /// Ks times the light's colour; if all are 0 the specular term is skipped.
    pub specular: [f32; 3],
    /// Cosine up to which the specular term is left out (see [`FaintLight`]). Below 0 where nothing is.
    pub dark_cosine: f32,
    /// Coefficients c, l, q of the attenuation 1 / (c + l d + q d^2); `None` for none.
    pub attenuation: Option<[f32; 3]>,
    /// True if that sum is clamped to at least 1.
    pub is_clamped: bool,
}

impl FastLight {
    /// Returns whether the light has an end: a radius, a cone, an attenuation.
    fn is_bounded(&self) -> bool {
        self.reach2 < f32::INFINITY || self.cone != Cone::None
    }
}

/// Specular exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent {
    /// Integer, evaluated by repeated squaring.
    Integer(u32),
    /// Any other number.
    Real(f32),
}

impl Exponent {
    /// Returns the exponent, or 1 if it is less.
    pub(super) fn at_least_one(self) -> f32 {
        match self {
            Exponent::Integer(n) => n.max(1) as f32,
            Exponent::Real(n) => n.max(1.0),
        }
    }

    /// Returns the representation of exponent `n`; `None` for those that f32 does not carry: outside
    /// 0..=1000, and near 0 but not 0. A cosine of 0 may be 1e-7 in f32, and (1e-7)^n must be
    /// below half a step of a byte.
    pub fn new(n: f64) -> Option<Exponent> {
        match n {
            n if !(0.0..=1000.0).contains(&n) => None,
            n if n > 0.0 && n < LEAST_EXPONENT => None,
            n if n == n.trunc() => Some(Exponent::Integer(n as u32)),
            n => Some(Exponent::Real(n as f32)),
        }
    }
}

/// Least exponent above 0 of the kernels: (1e-7)^0.4 is 0.0016, less than 1/510.
const LEAST_EXPONENT: f64 = 0.4;

/// Light that a point may lack, in units of colour.
#[derive(Clone, Copy, Debug)]
pub struct FaintLight {
    /// Sum over the lights' highlights.
    pub highlights: f64,
    /// Sum over the lights that have faded.
    pub faded: f64,
}

impl FaintLight {
    /// For bytes within a step of the plain path's: a quarter and an eighth of a step.
    pub const WITHIN_A_STEP: FaintLight = FaintLight { highlights: 0.25 / 255.0, faded: 0.125 / 255.0 };

    /// For the plain path's bytes: an eighth of `edge`, the distance in bytes from the boundary between
    /// two bytes within which f32 does not decide.
    pub const fn beside(edge: f32) -> FaintLight {
        let each = edge as f64 / (16.0 * 255.0);
        FaintLight { highlights: each, faded: each }
    }
}

/// Material and lights of a draw, as the kernels read them.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialLighting {
    /// Constant part that texture and vertex colour multiply: Ka times ambient light.
    pub diffuse: [f32; 3],
    /// Constant part that nothing multiplies: Ke.
    pub specular: [f32; 3],
    /// Lights that are on; empty if no light reaches the material.
    pub lights: Vec<FastLight>,
    /// Specular exponent.
    pub exponent: Exponent,
    /// Lighting model: Phong or Blinn.
    pub model: LightingModel,
    /// True if light depends on the place of a point or on the viewer.
    pub needs_place: bool,
}

impl MaterialLighting {
    /// Finds the cosines up to which highlights are left out: a light whose highlight at cosine c is
    /// m c^n, in units of colour, has its share of `tolerance` where c^n is the share over m.
    pub fn find_dark_cosines(&mut self, tolerance: FaintLight) {
        let brightest = |light: &FastLight| light.specular.iter().fold(0.0f32, |m, c| m.max(c.abs()));
        let count = self.lights.iter().filter(|l| brightest(l) > 0.0).count();
        let exponent = match self.exponent {
            Exponent::Integer(n) => f64::from(n),
            Exponent::Real(n) => f64::from(n),
        };
        for light in &mut self.lights {
            let share = tolerance.highlights / (count.max(1) as f64 * f64::from(brightest(light)));
            // A light that fades by a sum below 1 is brighter than its colour.
            let is_at_most_one = light.attenuation.is_none() || light.is_clamped;
            light.dark_cosine = match exponent > 0.0 && is_at_most_one {
                true if share >= 1.0 => f32::INFINITY,
                true => libm::pow(share, 1.0 / exponent) as f32,
                false => -1.0,
            };
        }
    }

    /// Finds the distances beyond which attenuated lights are left out: a light that gives at most m,
    /// in units of colour, has its share of `tolerance` where m / (c + l d + q d^2) is that share.
    pub fn find_faded_distances(&mut self, tolerance: FaintLight) {
        let count = self.lights.iter().filter(|l| l.attenuation.is_some()).count();
        for light in &mut self.lights {
            let Some([c, l, q]) = light.attenuation.map(|sum| sum.map(f64::from)) else { continue };
            // Coefficients below 0 may make a far light brighter than a near one.
            if !(c >= 0.0 && l >= 0.0 && q >= 0.0 && l + q > 0.0) {
                continue;
            }
            let of_channel = |i: usize| {
                [light.ambient, light.diffuse, light.specular]
                    .iter()
                    .map(|part| f64::from(part[i].abs()))
                    .sum()
            };
            let brightest = (0..3).map(of_channel).fold(0.0, f64::max);
            // c + l d + q d^2 = sum, in a form without cancellation.
            let sum = brightest * count as f64 / tolerance.faded - c;
            let distance = if sum > 0.0 { 2.0 * sum / (l + (l * l + 4.0 * q * sum).sqrt()) } else { 0.0 };
            // Rounded up by more than f32 loses.
            let squared = (distance * distance * (1.0 + 1e-5)) as f32;
            if squared < light.reach2 {
                light.reach2 = squared.max(f32::MIN_POSITIVE);
                light.is_reach_faded = true;
            }
        }
    }

    /// Finds the cosines below which points are well outside of a cone.
    pub fn find_least_cosines(&mut self) {
        for light in &mut self.lights {
            let cosine = match light.cone {
                Cone::None => continue,
                Cone::Power { cos_angle, .. } => f64::from(cos_angle),
                Cone::Linear { cut_off, .. } => libm::cos(f64::from(cut_off).min(PI)),
            };
            // Of wide cones nothing is left out: near a right angle the squares are too small.
            if cosine > 0.05 {
                light.least_cosine2 = (cosine * cosine * 0.999) as f32;
            }
        }
    }

    /// Creates the lighting of a material that no light reaches, with these constant parts.
    pub const fn constant(diffuse: [f32; 3], specular: [f32; 3]) -> Self {
        MaterialLighting {
            diffuse,
            specular,
            lights: Vec::new(),
            exponent: Exponent::Integer(0),
            model: LightingModel::Phong,
            needs_place: false,
        }
    }
}

/// Returns a . b, summed in a fixed order.
#[inline(always)]
pub fn dot<S: Simd>(a: V3<S>, b: V3<S>) -> S::F {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// Colours of a vector of points: `diffuse` is the part that a texture multiplies, `specular` the
/// rest.
pub struct LitPoints<S: Simd> {
    /// Ambient and diffuse terms.
    pub diffuse: V3<S>,
    /// Emissive and specular terms.
    pub specular: V3<S>,
    /// Lanes where f32 lacks the digits: a light much nearer than the eye, or almost opposite to
    /// it.
    pub needs_f64: S::M,
}

/// Ratio of a light's distance to the eye's below which a point is shaded in f64.
pub(super) const NEAR_LIGHT: f32 = 1.0 / 64.0;

/// Bound on 1 + L.V per unit of the exponent, below which f32 has too few digits of the length of
/// Blinn's half vector, which is short where light and viewer are almost opposite.
const OPPOSITE: f32 = 1e-4;

/// Largest attenuation factor, as in the plain path.
const MAX_FACTOR: f32 = 1e30;

/// Place of points relative to a light.
struct FromLight<S: Simd> {
    /// Vector to the light; a unit vector if it is directional.
    to_light: V3<S>,
    /// 1 / its length, 0 at the light.
    inverse: S::F,
    /// Fraction of the light that arrives: attenuation, radius, cone.
    strength: S::F,
}

/// Lights points at `position` with unit normals `normal`, seen along unit `to_viewer`. Neither of the
/// two places counts if the lighting needs none.
///
/// A light that reaches no lane is left out early; lanes that it does not reach get exactly 0 from
/// it, so that a lane's colour does not depend on its neighbours. Likewise the power
/// of a highlight is computed where N.L > 0 and the cosine is above [`FastLight::dark_cosine`] in
/// some lane, and the other lanes get 0.
#[inline(always)]
pub fn light<S: Simd>(
    s: S,
    lighting: &MaterialLighting,
    position: V3<S>,
    normal: V3<S>,
    to_viewer: V3<S>,
) -> LitPoints<S> {
    let zero = s.splat(0.0);
    let one = s.splat(1.0);
    let mut diffuse = splat3(s, lighting.diffuse);
    let mut specular = splat3(s, lighting.specular);
    let mut needs_f64 = s.mask(0);
    let n_dot_v = dot::<S>(normal, to_viewer);
    let away2 = dot::<S>(position, position);
    for light in &lighting.lights {
        let has_ambient = light.ambient != [0.0; 3];
        let (n_dot_l, from) = match light.position {
            LightPosition::Toward(d) => {
                let to_light = splat3(s, d);
                let n_dot_l = dot::<S>(normal, to_light);
                if !has_ambient && !zero.lt(n_dot_l).any() {
                    continue;
                }
                (n_dot_l, FromLight::<S> { to_light, inverse: one, strength: one })
            }
            LightPosition::At(p) => {
                let d =
                    [s.splat(p[0]) - position[0], s.splat(p[1]) - position[1], s.splat(p[2]) - position[2]];
                let d2 = dot::<S>(d, d);
                let is_near = d2.lt(away2 * s.splat(NEAR_LIGHT * NEAR_LIGHT));
                let n_dot_d = dot::<S>(normal, d);
                let mut is_reached = s.mask(u32::MAX);
                if light.is_bounded() {
                    is_reached = d2.le(s.splat(light.reach2)) & is_in_cone(s, light, d, d2);
                    if !is_reached.any() {
                        continue;
                    }
                }
                needs_f64 = needs_f64 | (is_near & is_reached);
                if !has_ambient && !(is_reached & zero.lt(n_dot_d)).any() {
                    continue;
                }
                let length = d2.sqrt();
                // A light at the surface point contributes 0: its direction is made 0.
                let inverse = s.select(zero.lt(d2), one / length, zero);
                let mut strength = attenuation(s, light, length, d2);
                if light.is_bounded() {
                    strength = s.select(is_reached, in_cone(s, light, d, inverse, strength), zero);
                }
                (n_dot_d * inverse, FromLight::<S> { to_light: d, inverse, strength })
            }
        };
        if has_ambient {
            diffuse = add_scaled(s, diffuse, light.ambient, from.strength);
        }
        diffuse = add_scaled(s, diffuse, light.diffuse, n_dot_l.max(zero) * from.strength);
        if light.specular != [0.0; 3] {
            let is_facing = zero.lt(n_dot_l);
            let l_dot_v = dot::<S>(from.to_light, to_viewer) * from.inverse;
            let (cosine, is_unsure) = mirror_cosine(s, lighting, n_dot_l, n_dot_v, l_dot_v);
            needs_f64 = needs_f64 | (is_unsure & is_facing);
            let is_bright = is_facing & s.splat(light.dark_cosine).lt(cosine);
            if is_bright.any() {
                // 0 in the others: powers of small numbers are slow once they are subnormal.
                let cosine = s.select(is_bright, cosine, zero);
                let factor = power(s, cosine, lighting.exponent) * from.strength;
                specular = add_scaled(s, specular, light.specular, s.select(is_bright, factor, zero));
            }
        }
    }
    LitPoints { diffuse, specular, needs_f64 }
}

/// Returns the diffuse part of [`light`] where light depends on nothing but the normal, the same bits:
/// matte materials under directional lights. The other part is the material's constant one.
#[inline(always)]
pub fn light_by_normal<S: Simd>(s: S, lighting: &MaterialLighting, normal: V3<S>) -> V3<S> {
    let zero = s.splat(0.0);
    let mut diffuse = splat3(s, lighting.diffuse);
    for light in &lighting.lights {
        let LightPosition::Toward(direction) = light.position else { continue };
        let n_dot_l = dot::<S>(normal, splat3(s, direction));
        if light.ambient != [0.0; 3] {
            diffuse = add_scaled(s, diffuse, light.ambient, s.splat(1.0));
        } else if !zero.lt(n_dot_l).any() {
            continue;
        }
        diffuse = add_scaled(s, diffuse, light.diffuse, n_dot_l.max(zero));
    }
    diffuse
}

/// Returns R.V or, in Blinn's model, N.H, in 0..1, and the lanes where f32 has too few digits of it.
#[inline(always)]
fn mirror_cosine<S: Simd>(
    s: S,
    lighting: &MaterialLighting,
    n_dot_l: S::F,
    n_dot_v: S::F,
    l_dot_v: S::F,
) -> (S::F, S::M) {
    let (zero, one) = (s.splat(0.0), s.splat(1.0));
    let (cosine, is_unsure) = match lighting.model {
        LightingModel::Blinn => {
            // |L + V|^2 = 2 + 2 L.V for unit vectors.
            let half = (l_dot_v + one).max(zero);
            let is_opposite = half.lt(s.splat(lighting.exponent.at_least_one() * OPPOSITE));
            let length = (half + half).sqrt();
            (s.select(zero.lt(length), (n_dot_l + n_dot_v) / length, zero), is_opposite)
        }
        _ => ((n_dot_l + n_dot_l) * n_dot_v - l_dot_v, s.mask(0)),
    };
    (cosine.max(zero).min(one), is_unsure)
}

/// Returns the fraction of a light that is left at a distance, without its radius.
#[inline(always)]
fn attenuation<S: Simd>(s: S, light: &FastLight, length: S::F, d2: S::F) -> S::F {
    let (zero, one) = (s.splat(0.0), s.splat(1.0));
    let strength = match light.attenuation {
        Some([c, l, q]) => {
            let sum = s.splat(c) + (s.splat(l) * length + s.splat(q) * d2);
            let sum = if light.is_clamped { sum.max(one) } else { sum };
            (one / sum).min(s.splat(MAX_FACTOR)).max(s.splat(-MAX_FACTOR))
        }
        None if light.ambient == [0.0; 3] => return one,
        None => one,
    };
    s.select(zero.lt(d2), strength, zero)
}

/// Returns the lanes that are not well outside of a light's cone, without a root.
#[inline(always)]
fn is_in_cone<S: Simd>(s: S, light: &FastLight, d: V3<S>, d2: S::F) -> S::M {
    let (Cone::Power { axis, .. } | Cone::Linear { axis, .. }) = light.cone else { return s.mask(u32::MAX) };
    if light.least_cosine2 < 0.0 {
        return s.mask(u32::MAX);
    }
    // d is the vector to the light, against the axis.
    let along = dot::<S>(d, splat3(s, axis));
    along.le(s.splat(0.0)) & (d2 * s.splat(light.least_cosine2)).le(along * along)
}

/// Returns the part of `strength` that a light's cone lets through to points; `d` is the vector to the
/// light, `inverse` 1 / its length.
#[inline(always)]
fn in_cone<S: Simd>(s: S, light: &FastLight, d: V3<S>, inverse: S::F, strength: S::F) -> S::F {
    let (zero, one) = (s.splat(0.0), s.splat(1.0));
    let (Cone::Power { axis, .. } | Cone::Linear { axis, .. }) = light.cone else { return strength };
    let cos = zero - dot::<S>(d, splat3(s, axis)) * inverse;
    match light.cone {
        Cone::None => strength,
        Cone::Power { cos_angle, exponent, .. } => {
            let part = power(s, cos.max(zero).min(one), exponent);
            s.select(s.splat(cos_angle).le(cos), strength * part, zero)
        }
        Cone::Linear { beam, cut_off, .. } => {
            let angle = acos(s, cos);
            let part = (s.splat(cut_off) - angle) / s.splat(cut_off - beam);
            let part = s.select(angle.le(s.splat(beam)), one, part);
            s.select(angle.lt(s.splat(cut_off)), strength * part, zero)
        }
    }
}

/// Returns the angle in 0..pi of a cosine, to about 2e-7: Abramowitz, Stegun, "Handbook of
/// mathematical functions", 4.4.46.
#[inline(always)]
pub(super) fn acos<S: Simd>(s: S, cos: S::F) -> S::F {
    let one = s.splat(1.0);
    let x = cos.abs().min(one);
    let mut series = s.splat(-0.001_262_491_1);
    for c in
        [0.006_670_09, -0.017_088_126, 0.030_891_88, -0.050_174_303, 0.088_978_99, -0.214_598_8, FRAC_PI_2]
    {
        series = series * x + s.splat(c);
    }
    let angle = (one - x).sqrt() * series;
    s.select(cos.lt(s.splat(0.0)), s.splat(std::f32::consts::PI) - angle, angle)
}

/// Returns x^n for x in [0, about 1]; 0^0 = 1.
#[inline(always)]
pub fn power<S: Simd>(s: S, x: S::F, n: Exponent) -> S::F {
    match n {
        Exponent::Integer(mut n) => {
            let (mut result, mut quad) = (s.splat(1.0), x);
            while n > 0 {
                if n & 1 == 1 {
                    result = result * quad;
                }
                n >>= 1;
                if n > 0 {
                    quad = quad * quad;
                }
            }
            result
        }
        Exponent::Real(n) => exp2(s, s.splat(n) * log2(s, x)),
    }
}

/// Returns log2 of x > 0, to about 1e-7 relative near 1 and absolute elsewhere; x = 0 gives -150.
///
/// x = m 2^e with m in [1/sqrt 2, sqrt 2); log2 m = 2/ln 2 (t + t^3/3 + t^5/5 + ...), t =
/// (m-1)/(m+1).
#[inline(always)]
pub fn log2<S: Simd>(s: S, x: S::F) -> S::F {
    let bits = x.bits();
    // After subtraction of the bits of 1/sqrt 2, the exponent bits are those of e.
    let e = (bits - s.splat_i(0x3f35_04f3)).sar::<23>();
    let m = (bits - e.shl::<23>()).as_f32();
    let one = s.splat(1.0);
    let t = (m - one) / (m + one);
    let t2 = t * t;
    // The remaining terms are less than 2e-9: t is at most 0.172.
    let mut series = s.splat(1.0 / 9.0);
    for c in [1.0 / 7.0, 0.2, 1.0 / 3.0] {
        series = series * t2 + s.splat(c);
    }
    let log_m = (t + t * t2 * series) * s.splat(2.0 * std::f32::consts::LOG2_E);
    s.select(s.splat(1e-38).lt(x), e.to_f32() + log_m, s.splat(-150.0))
}

/// Returns 2^x for x <= 0 or slightly above; 0 below -126.
#[inline(always)]
pub fn exp2<S: Simd>(s: S, x: S::F) -> S::F {
    let integer = x.max(s.splat(-200.0)).min(s.splat(126.0)).floor();
    let f = (x - integer) * s.splat(std::f32::consts::LN_2);
    // e^f, f in [0, ln 2): Taylor to f^8, below 1e-8.
    let mut series = s.splat(1.0 / 40320.0);
    for c in [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        series = series * f + s.splat(c);
    }
    let scale = (integer.to_i32() + s.splat_i(127)).shl::<23>().as_f32();
    s.select(s.splat(-126.0).le(integer), series * scale, s.splat(0.0))
}

/// Converts colours in 0..1 and beyond to bytes: floor(255 clamp(c) + 0.5), alpha 255, R lowest.
#[inline(always)]
pub fn pack<S: Simd>(s: S, color: V3<S>) -> S::I {
    let (r, g, b) = (byte(s, color[0]), byte(s, color[1]), byte(s, color[2]));
    (r | g.shl::<8>()) | (b.shl::<16>() | s.splat_i(255 << 24))
}

#[inline(always)]
fn byte<S: Simd>(s: S, c: S::F) -> S::I {
    (c.max(s.splat(0.0)).min(s.splat(1.0)) * s.splat(255.0) + s.splat(0.5)).to_i32()
}

/// Returns `v` in every lane.
#[inline(always)]
pub fn splat3<S: Simd>(s: S, v: [f32; 3]) -> V3<S> {
    [s.splat(v[0]), s.splat(v[1]), s.splat(v[2])]
}

/// Returns v * k.
#[inline(always)]
pub fn scale<S: Simd>(v: V3<S>, k: S::F) -> V3<S> {
    [v[0] * k, v[1] * k, v[2] * k]
}

/// Returns sum + color * k.
#[inline(always)]
fn add_scaled<S: Simd>(s: S, sum: V3<S>, color: [f32; 3], k: S::F) -> V3<S> {
    [sum[0] + s.splat(color[0]) * k, sum[1] + s.splat(color[1]) * k, sum[2] + s.splat(color[2]) * k]
}

#[cfg(test)]
mod tests;

//! Fragments: coverage, depth and colours of one face at one pixel, with every accepted result of a
//! borderline decision.
//!
//! Weights p_i = b_i / sum b_j are the perspective-correct ones of source 003, b_i w_i those linear
//! on the screen. If a pixel's centre is covered only because the outline was snapped, both
//! extrapolating the plane and clamping the weights are accepted, and so is everything between: the
//! results are ranges.

use super::camera::Sight;
use super::coverage::Coverage;
use super::double_double::{DoubleDouble, DoubleDouble3};
use super::face::{Face, Weights};
use super::light::{LitColor, light_point};
use super::maps::FootprintOf;
use super::texture::UvFootprint;
use fbptr_core::scene::{Filling, Filter, Fog, FogKind, Interpolation, Material, ShadeMode};
use glam::{DVec3, DVec4};

/// Colour with its opacity; `lo` and `hi` differ only if a range is accepted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorRange {
    /// Smallest R, G, B, unclamped.
    pub lo: DVec3,
    /// Largest R, G, B, unclamped.
    pub hi: DVec3,
    /// Smallest and largest opacity.
    pub alpha: [f64; 2],
}

/// One face at one pixel.
#[derive(Clone, Debug)]
pub struct Fragment {
    /// Coverage combined with the test 0 <= z <= 1.
    pub presence: Coverage,
    /// Smallest and largest accepted depth.
    pub z: [DoubleDouble; 2],
    /// Accepted colours.
    pub colors: Vec<ColorRange>,
}

/// 2 ulp of f32 just below 1: within this distance of z = 0 or z = 1 both sides are accepted.
const DEPTH_EDGE: f64 = 2.0 / 16_777_216.0;

/// Data of a draw for all of its fragments.
#[derive(Clone, Copy)]
pub struct FragmentContext<'a> {
    /// Camera of the draw.
    pub sight: &'a Sight,
    /// Interpolation of attributes: perspective-correct or linear on the screen.
    pub interpolation: Interpolation,
    /// Fog, if any.
    pub fog: Option<Fog>,
}

impl ColorRange {
    /// Returns the smallest range that contains both.
    pub fn hull(self, other: ColorRange) -> ColorRange {
        ColorRange {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
            alpha: [self.alpha[0].min(other.alpha[0]), self.alpha[1].max(other.alpha[1])],
        }
    }
}

impl FragmentContext<'_> {
    /// Returns the fragment of `face` at pixel (x, y), or `None` if there is none.
    pub fn fragment(&self, face: &Face, x: i64, y: i64, coverage: Coverage) -> Option<Fragment> {
        let weights = face.weights(self.sight.ndc_of_pixel(x, y));
        let sets = weight_sets(face, &weights);
        if sets.is_empty() {
            return None;
        }
        let depths: Vec<DoubleDouble> = sets.iter().map(|p| depth(face, *p)).collect();
        let z = depths.iter().fold([depths[0]; 2], |[a, b], &d| [a.min(d), b.max(d)]);
        let presence = coverage.min(in_depth_range(face, z));
        if presence == Coverage::No {
            return None;
        }
        let footprint = self.footprint(face, x, y, &weights);
        let of_map = |uv: &dyn Fn(usize) -> [f64; 2]| self.footprint_of(face, [x, y], &weights, uv);
        let mut colors = Vec::new();
        match face.fill.at(x as i32, y as i32) {
            Filling::Nothing => return None,
            Filling::Hatch(color) => colors.push(ColorRange { lo: color, hi: color, alpha: [1.0; 2] }),
            Filling::Face => {
                colors.extend(sets.iter().flat_map(|p| self.colors(face, *p, footprint, &of_map)))
            }
        }
        if sets.len() > 1 {
            let hull = colors.iter().skip(1).fold(colors[0], |a, &b| a.hull(b));
            colors = vec![hull];
        }
        Some(Fragment { presence, z: z.map(|z| z.max(DoubleDouble::ZERO).min(DoubleDouble::ONE)), colors })
    }

    /// Returns the weights for attributes: perspective-correct, or linear on the screen.
    fn attribute_weights(&self, face: &Face, p: DoubleDouble3) -> DoubleDouble3 {
        match self.interpolation {
            Interpolation::Perspective => p,
            Interpolation::Affine => straight(face, p),
        }
    }

    /// Returns the accepted colours for perspective-correct weights p.
    fn colors(
        &self,
        face: &Face,
        p: DoubleDouble3,
        footprint: UvFootprint,
        of_map: FootprintOf,
    ) -> Vec<ColorRange> {
        let a = self.attribute_weights(face, p);
        let weigh =
            |value: &dyn Fn(usize) -> DoubleDouble| a[0] * value(0) + a[1] * value(1) + a[2] * value(2);
        let vector = |part: &dyn Fn(usize, usize) -> DoubleDouble| {
            DVec3::from_array(std::array::from_fn(|k| weigh(&|i| part(i, k)).to_f64()))
        };
        let c = &face.corners;
        let point = vector(&|i, k| c[i].world[k]);
        let color = match face.shade {
            ShadeMode::Flat => face.flat_color,
            _ => DVec4::from_array(std::array::from_fn(|k| weigh(&|i| c[i].color[k].into()).to_f64())),
        };
        let n = vector(&|i, k| c[i].normal[k].into());
        let n = if n.length() < 1e-12 { face.normal } else { n / n.length() };
        let lights_pixels = matches!(face.shade, ShadeMode::Phong | ShadeMode::Wire);
        let surfaces = match &face.maps {
            None => vec![(face.material.clone(), n)],
            Some(maps) => maps.surfaces(face.material, n, a, lights_pixels, of_map),
        };
        let lit_by = |(material, n): &(Material, DVec3)| -> Vec<[LitColor; 2]> {
            let glow = material.emissive - face.material.emissive;
            let glowing = |l: LitColor| LitColor { specular_emissive: l.specular_emissive + glow, ..l };
            match face.shade {
                ShadeMode::Flat => face.flat.iter().map(|&l| [glowing(l); 2]).collect(),
                ShadeMode::Gouraud => vec![gouraud(face, a.map(DoubleDouble::to_f64)).map(glowing)],
                ShadeMode::Phong | ShadeMode::Wire => {
                    let answers = light_point(material, color.truncate(), point, *n, &face.lighting);
                    answers.into_iter().map(|l| [l, l]).collect()
                }
            }
        };
        let lit: Vec<[LitColor; 2]> = surfaces.iter().flat_map(lit_by).collect();
        let texels = match &face.texture {
            None => vec![[1.0; 4]],
            Some((mip_chain, rules)) => {
                let uv = std::array::from_fn(|k| {
                    weigh(&|i| c[i].uv.map_or(DoubleDouble::ZERO, |uv| uv[k].into())).to_f64()
                });
                mip_chain.sample(*rules, uv, footprint)
            }
        };
        let opacity = (1.0 - face.material.transparency) * color.w;
        let mut colors = Vec::with_capacity(lit.len() * texels.len());
        if let Some(stages) = &face.stages {
            let a = a.map(DoubleDouble::to_f64);
            for ends in &lit {
                let [p, q] = ends.map(|l| {
                    let (base, alpha) = stages.colored(a, (l.diffuse_ambient, opacity), l.specular_emissive);
                    (self.fogged(base + l.specular_emissive, point), alpha)
                });
                let alpha = [p.1.min(q.1), p.1.max(q.1)];
                colors.push(ColorRange { lo: p.0.min(q.0), hi: p.0.max(q.0), alpha });
            }
            return colors;
        }
        for [low, high] in &lit {
            for t in &texels {
                let rgb = DVec3::new(t[0], t[1], t[2]);
                let lo = self.fogged(low.diffuse_ambient * rgb + low.specular_emissive, point);
                let hi = self.fogged(high.diffuse_ambient * rgb + high.specular_emissive, point);
                colors.push(ColorRange { lo, hi, alpha: [t[3] * opacity; 2] });
            }
        }
        colors.dedup();
        colors
    }

    /// Applies X3D's fog: f C + (1-f) fog, f = (range-d)/range or exp(-d/(range-d)), 0 from the
    /// range on.
    pub fn fogged(&self, color: DVec3, point: DVec3) -> DVec3 {
        let Some(fog) = self.fog.filter(|f| f.visibility_range > 0.0 && f.visibility_range < f64::INFINITY)
        else {
            return color;
        };
        let (d, range) = (point.distance(self.sight.eye), fog.visibility_range);
        let f = match fog.kind {
            _ if d >= range => 0.0,
            FogKind::Linear => (range - d) / range,
            FogKind::Exponential => libm::exp(-d / (range - d)),
        };
        color * f + fog.color * (1.0 - f)
    }

    /// Returns the footprint of the face's own texture.
    fn footprint(&self, face: &Face, x: i64, y: i64, here: &Weights) -> UvFootprint {
        match &face.texture {
            Some((_, rules)) if matches!(rules.filter, Filter::Mipmap | Filter::Trilinear) => {
                let uv = |i: usize| face.corners[i].uv.unwrap_or([0.0; 2]);
                self.footprint_of(face, [x, y], here, &uv)
            }
            _ => UvFootprint::Steps([[0.0; 2]; 2]),
        }
    }

    /// Returns the forward differences of u and v to (x+1, y) and (x, y+1) on the face's plane, for
    /// texture coordinates given at its corners.
    fn footprint_of(
        &self,
        face: &Face,
        [x, y]: [i64; 2],
        here: &Weights,
        uv_at: &dyn Fn(usize) -> [f64; 2],
    ) -> UvFootprint {
        if face.is_degenerate() {
            return UvFootprint::Steps([[0.0; 2]; 2]);
        }
        let uv = |w: &Weights| -> Option<[DoubleDouble; 2]> {
            let sum = w.inverse_w();
            if sum <= DoubleDouble::ZERO {
                return None;
            }
            let a = self.attribute_weights(face, w.b.map(|b| b / sum));
            Some(std::array::from_fn(|k| {
                (0..3).fold(DoubleDouble::ZERO, |s, i| s + a[i] * DoubleDouble::new(uv_at(i)[k]))
            }))
        };
        let right = face.weights(self.sight.ndc_of_pixel(x + 1, y));
        let below = face.weights(self.sight.ndc_of_pixel(x, y + 1));
        match (uv(here), uv(&right), uv(&below)) {
            (Some(o), Some(r), Some(b)) => {
                UvFootprint::Steps([r, b].map(|p| std::array::from_fn(|k| (p[k] - o[k]).to_f64())))
            }
            _ => UvFootprint::AcrossHorizon,
        }
    }
}

/// Interpolates the corners' colours (Gouraud); a range if a corner has more than one accepted
/// colour.
fn gouraud(face: &Face, a: [f64; 3]) -> [LitColor; 2] {
    let zero = LitColor { diffuse_ambient: DVec3::ZERO, specular_emissive: DVec3::ZERO };
    let mut range = [zero; 2];
    for (i, corner) in face.corners.iter().enumerate() {
        let ends = corner.lit.iter().fold([corner.lit[0]; 2], |[lo, hi], l| {
            [
                LitColor {
                    diffuse_ambient: lo.diffuse_ambient.min(l.diffuse_ambient),
                    specular_emissive: lo.specular_emissive.min(l.specular_emissive),
                },
                LitColor {
                    diffuse_ambient: hi.diffuse_ambient.max(l.diffuse_ambient),
                    specular_emissive: hi.specular_emissive.max(l.specular_emissive),
                },
            ]
        });
        let (low, high) = if a[i] >= 0.0 { (ends[0], ends[1]) } else { (ends[1], ends[0]) };
        for (sum, end) in range.iter_mut().zip([low, high]) {
            sum.diffuse_ambient += a[i] * end.diffuse_ambient;
            sum.specular_emissive += a[i] * end.specular_emissive;
        }
    }
    range
}

/// Returns the screen-linear weights for perspective-correct ones: p_i w_i, scaled to sum 1.
fn straight(face: &Face, p: DoubleDouble3) -> DoubleDouble3 {
    let raw: DoubleDouble3 = std::array::from_fn(|i| p[i] * face.corners[i].clip[3]);
    let sum = raw[0] + raw[1] + raw[2];
    raw.map(|r| r / sum)
}

/// Returns z at weights p: sum p_i z_i / sum p_i w_i.
fn depth(face: &Face, p: DoubleDouble3) -> DoubleDouble {
    let sum = |k: usize| (0..3).fold(DoubleDouble::ZERO, |s, i| s + p[i] * face.corners[i].clip[k]);
    sum(2) / sum(3)
}

/// Returns the accepted weights at a pixel: one set inside the true face; extrapolated and clamped
/// ones outside.
fn weight_sets(face: &Face, weights: &Weights) -> Vec<DoubleDouble3> {
    let (o, i) = (DoubleDouble::ZERO, DoubleDouble::ONE);
    if face.is_degenerate() {
        return vec![[i, o, o], [o, i, o], [o, o, i]];
    }
    let scaled = |v: DoubleDouble3| {
        let sum = v[0] + v[1] + v[2];
        v.map(|c| c / sum)
    };
    let mut sets = Vec::new();
    if weights.inverse_w() > DoubleDouble::ZERO {
        sets.push(scaled(weights.b));
    }
    if !weights.is_inside() && weights.b.iter().any(|&b| b > o) {
        sets.push(scaled(weights.b.map(|b| b.max(o))));
        let w = |k: usize| face.corners[k].clip[3];
        if (0..3).all(|k| w(k) > o) {
            // The screen-linear weights b_i w_i clamped, then made perspective-correct.
            let clamped: DoubleDouble3 = std::array::from_fn(|k| (weights.b[k] * w(k)).max(o).min(i));
            sets.push(scaled(std::array::from_fn(|k| clamped[k] / w(k))));
        }
    }
    sets
}

/// Tests 0 <= z <= 1, closed at 0. Near either end both results are accepted, unless the face lies
/// exactly in the near plane.
fn in_depth_range(face: &Face, z: [DoubleDouble; 2]) -> Coverage {
    let edge = DoubleDouble::new(DEPTH_EDGE);
    if face.corners.iter().all(|c| c.clip[2] == DoubleDouble::ZERO) {
        return Coverage::Yes;
    }
    if z[1] < -edge || z[0] > DoubleDouble::ONE + edge {
        Coverage::No
    } else if z[0] > edge && z[1] < DoubleDouble::ONE - edge {
        Coverage::Yes
    } else {
        Coverage::Maybe
    }
}

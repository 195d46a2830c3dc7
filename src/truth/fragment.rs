//! What one face gives to one pixel: coverage, depth and colour, with every right answer where a decision turns.
//!
//! Weights p_i = b_i / sum b_j are the perspective-correct ones of source 003, b_i w_i the straight ones of the screen.
//! Where the pixel's centre is covered only because the outline was snapped, extrapolating the plane and clamping the
//! weights are both right, and so is what lies between: the answers then are ranges.

use super::camera::Sight;
use super::coverage::Coverage;
use super::face::{Face, Weights};
use super::light::{Lit, light_point};
use super::texture::Footprint;
use super::wide::{Wide, Wide3};
use crate::scene::{Filling, Filter, Fog, FogKind, Interpolation, ShadeMode};
use glam::{DVec3, DVec4};

/// A colour with its opacity; `lo` and `hi` differ only where a range is right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// Least R, G, B, unclamped.
    pub lo: DVec3,
    /// Largest R, G, B, unclamped.
    pub hi: DVec3,
    /// Least and largest opacity.
    pub alpha: [f64; 2],
}

/// One face at one pixel.
#[derive(Clone, Debug)]
pub struct Fragment {
    /// Whether it is there at all: coverage, and 0 <= z <= 1.
    pub presence: Coverage,
    /// Least and largest right depth.
    pub z: [Wide; 2],
    /// Its right colours.
    pub tones: Vec<Tone>,
}

/// 2 ulp of f32 just below 1: within this of z = 0 or z = 1 a fragment may be in or out.
const DEPTH_EDGE: f64 = 2.0 / 16_777_216.0;

/// What a draw asks of every pixel.
#[derive(Clone, Copy)]
pub struct Lens<'a> {
    /// The camera.
    pub sight: &'a Sight,
    /// Perspective-correct or straight.
    pub interpolation: Interpolation,
    /// Fog, if any.
    pub fog: Option<Fog>,
}

impl Tone {
    /// The range that holds both.
    pub fn hull(self, other: Tone) -> Tone {
        Tone {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
            alpha: [self.alpha[0].min(other.alpha[0]), self.alpha[1].max(other.alpha[1])],
        }
    }
}

impl Lens<'_> {
    /// The fragment of `face` at pixel (x, y), or `None` where the face is not.
    pub fn fragment(&self, face: &Face, x: i64, y: i64, coverage: Coverage) -> Option<Fragment> {
        let weights = face.weights(self.sight.ndc_of_pixel(x, y));
        let sets = weight_sets(face, &weights);
        if sets.is_empty() {
            return None;
        }
        let depths: Vec<Wide> = sets.iter().map(|p| depth(face, *p)).collect();
        let z = depths.iter().fold([depths[0]; 2], |[a, b], &d| [a.min(d), b.max(d)]);
        let presence = coverage.min(in_depth_range(face, z));
        if presence == Coverage::No {
            return None;
        }
        let footprint = self.footprint(face, x, y, &weights);
        let mut tones = Vec::new();
        match face.fill.at(x as i32, y as i32) {
            Filling::Nothing => return None,
            Filling::Hatch(color) => tones.push(Tone { lo: color, hi: color, alpha: [1.0; 2] }),
            Filling::Face => tones.extend(sets.iter().flat_map(|p| self.tones(face, *p, footprint))),
        }
        if sets.len() > 1 {
            let hull = tones.iter().skip(1).fold(tones[0], |a, &b| a.hull(b));
            tones = vec![hull];
        }
        Some(Fragment { presence, z: z.map(|z| z.max(Wide::ZERO).min(Wide::ONE)), tones })
    }

    /// Weights for attributes: the perspective-correct ones, or the straight ones.
    fn attribute_weights(&self, face: &Face, p: Wide3) -> Wide3 {
        match self.interpolation {
            Interpolation::Perspective => p,
            Interpolation::Affine => straight(face, p),
        }
    }

    /// The right colours for perspective-correct weights p.
    fn tones(&self, face: &Face, p: Wide3, footprint: Footprint) -> Vec<Tone> {
        let a = self.attribute_weights(face, p);
        let weigh = |value: &dyn Fn(usize) -> Wide| a[0] * value(0) + a[1] * value(1) + a[2] * value(2);
        let vector = |part: &dyn Fn(usize, usize) -> Wide| {
            DVec3::from_array(std::array::from_fn(|k| weigh(&|i| part(i, k)).to_f64()))
        };
        let c = &face.corners;
        let point = vector(&|i, k| c[i].world[k]);
        let color = match face.shade {
            ShadeMode::Flat => face.flat_color,
            _ => DVec4::from_array(std::array::from_fn(|k| weigh(&|i| c[i].color[k].into()).to_f64())),
        };
        let lit: Vec<[Lit; 2]> = match face.shade {
            ShadeMode::Flat => face.flat.iter().map(|&l| [l, l]).collect(),
            ShadeMode::Gouraud => vec![gouraud(face, a.map(Wide::to_f64))],
            ShadeMode::Phong | ShadeMode::Wire => {
                let n = vector(&|i, k| c[i].normal[k].into());
                let n = if n.length() < 1e-12 { face.normal } else { n / n.length() };
                light_point(face.material, color.truncate(), point, n, &face.lighting)
                    .into_iter()
                    .map(|l| [l, l])
                    .collect()
            }
        };
        let texels = match &face.texture {
            None => vec![[1.0; 4]],
            Some((pyramid, rules)) => {
                let uv = std::array::from_fn(|k| {
                    weigh(&|i| c[i].uv.map_or(Wide::ZERO, |uv| uv[k].into())).to_f64()
                });
                pyramid.sample(*rules, uv, footprint)
            }
        };
        let opacity = (1.0 - face.material.transparency) * color.w;
        let mut tones = Vec::with_capacity(lit.len() * texels.len());
        if let Some(stages) = &face.stages {
            let a = a.map(Wide::to_f64);
            for ends in &lit {
                let [p, q] = ends.map(|l| {
                    let (base, alpha) = stages.colored(a, (l.base, opacity), l.extra);
                    (self.fogged(base + l.extra, point), alpha)
                });
                let alpha = [p.1.min(q.1), p.1.max(q.1)];
                tones.push(Tone { lo: p.0.min(q.0), hi: p.0.max(q.0), alpha });
            }
            return tones;
        }
        for [low, high] in &lit {
            for t in &texels {
                let rgb = DVec3::new(t[0], t[1], t[2]);
                let lo = self.fogged(low.base * rgb + low.extra, point);
                let hi = self.fogged(high.base * rgb + high.extra, point);
                tones.push(Tone { lo, hi, alpha: [t[3] * opacity; 2] });
            }
        }
        tones.dedup();
        tones
    }

    /// X3D's fog: f C + (1-f) fog, f = (range-d)/range or exp(-d/(range-d)), 0 from the range on.
    pub fn fogged(&self, color: DVec3, point: DVec3) -> DVec3 {
        let Some(fog) = self.fog.filter(|f| f.visibility_range > 0.0) else { return color };
        let (d, range) = (point.distance(self.sight.eye), fog.visibility_range);
        let f = match fog.kind {
            _ if d >= range => 0.0,
            FogKind::Linear => (range - d) / range,
            FogKind::Exponential => libm::exp(-d / (range - d)),
        };
        color * f + fog.color * (1.0 - f)
    }

    /// Forward differences of u and v to (x+1, y) and (x, y+1) on the face's plane.
    fn footprint(&self, face: &Face, x: i64, y: i64, here: &Weights) -> Footprint {
        let none = Footprint::Steps([[0.0; 2]; 2]);
        let Some((_, rules)) = &face.texture else { return none };
        if !matches!(rules.filter, Filter::Mipmap | Filter::Trilinear) || face.is_degenerate {
            return none;
        }
        let uv = |w: &Weights| -> Option<[Wide; 2]> {
            let sum = w.inverse_w();
            if sum <= Wide::ZERO {
                return None;
            }
            let a = self.attribute_weights(face, w.b.map(|b| b / sum));
            Some(std::array::from_fn(|k| {
                (0..3).fold(Wide::ZERO, |s, i| {
                    s + a[i] * face.corners[i].uv.map_or(Wide::ZERO, |uv| uv[k].into())
                })
            }))
        };
        let right = face.weights(self.sight.ndc_of_pixel(x + 1, y));
        let below = face.weights(self.sight.ndc_of_pixel(x, y + 1));
        match (uv(here), uv(&right), uv(&below)) {
            (Some(o), Some(r), Some(b)) => {
                Footprint::Steps([r, b].map(|p| std::array::from_fn(|k| (p[k] - o[k]).to_f64())))
            }
            _ => Footprint::AcrossHorizon,
        }
    }
}

/// Gouraud: the corners' colours weighed; a range where a corner has more than one right colour.
fn gouraud(face: &Face, a: [f64; 3]) -> [Lit; 2] {
    let zero = Lit { base: DVec3::ZERO, extra: DVec3::ZERO };
    let mut range = [zero; 2];
    for (i, corner) in face.corners.iter().enumerate() {
        let ends = corner.lit.iter().fold([corner.lit[0]; 2], |[lo, hi], l| {
            [
                Lit { base: lo.base.min(l.base), extra: lo.extra.min(l.extra) },
                Lit { base: hi.base.max(l.base), extra: hi.extra.max(l.extra) },
            ]
        });
        let (low, high) = if a[i] >= 0.0 { (ends[0], ends[1]) } else { (ends[1], ends[0]) };
        for (sum, end) in range.iter_mut().zip([low, high]) {
            sum.base += a[i] * end.base;
            sum.extra += a[i] * end.extra;
        }
    }
    range
}

/// The straight screen weights that go with perspective-correct ones: p_i w_i, scaled to sum 1.
fn straight(face: &Face, p: Wide3) -> Wide3 {
    let raw: Wide3 = std::array::from_fn(|i| p[i] * face.corners[i].clip[3]);
    let sum = raw[0] + raw[1] + raw[2];
    raw.map(|r| r / sum)
}

/// z at weights p: sum p_i z_i / sum p_i w_i.
fn depth(face: &Face, p: Wide3) -> Wide {
    let sum = |k: usize| (0..3).fold(Wide::ZERO, |s, i| s + p[i] * face.corners[i].clip[k]);
    sum(2) / sum(3)
}

/// The weights that may be used at a pixel: one set inside the true face; outside, extrapolated and clamped ones.
fn weight_sets(face: &Face, weights: &Weights) -> Vec<Wide3> {
    let (o, i) = (Wide::ZERO, Wide::ONE);
    if face.is_degenerate {
        return vec![[i, o, o], [o, i, o], [o, o, i]];
    }
    let scaled = |v: Wide3| {
        let sum = v[0] + v[1] + v[2];
        v.map(|c| c / sum)
    };
    let mut sets = Vec::new();
    if weights.inverse_w() > Wide::ZERO {
        sets.push(scaled(weights.b));
    }
    if !weights.is_inside() && weights.b.iter().any(|&b| b > o) {
        sets.push(scaled(weights.b.map(|b| b.max(o))));
        let w = |k: usize| face.corners[k].clip[3];
        if (0..3).all(|k| w(k) > o) {
            // Clamping the straight weights b_i w_i, then making them perspective-correct.
            let clamped: Wide3 = std::array::from_fn(|k| (weights.b[k] * w(k)).max(o).min(i));
            sets.push(scaled(std::array::from_fn(|k| clamped[k] / w(k))));
        }
    }
    sets
}

/// 0 <= z <= 1, closed at 0; near either end both answers are right, unless the face lies exactly there.
fn in_depth_range(face: &Face, z: [Wide; 2]) -> Coverage {
    let edge = Wide::new(DEPTH_EDGE);
    if face.corners.iter().all(|c| c.clip[2] == Wide::ZERO) {
        return Coverage::Yes;
    }
    if z[1] < -edge || z[0] > Wide::ONE + edge {
        Coverage::No
    } else if z[0] > edge && z[1] < Wide::ONE - edge {
        Coverage::Yes
    } else {
        Coverage::Maybe
    }
}

//! The bound against dense samples of the lighting model in f64.

use super::*;
use crate::pipeline::tile::lighting::Exponent;
use crate::simd::{Kernel, Level};
use glam::DVec3;

/// Samples along each side of a block.
const SAMPLES: usize = 24;

/// A block of a face's pixels: linear functions over the unit square, as value, step across and step down.
#[derive(Clone, Copy, Debug)]
struct Block {
    q: [f64; 3],
    ray: [DVec3; 3],
    normal: [DVec3; 3],
}

impl Block {
    fn q_at(&self, x: f64, y: f64) -> f64 {
        self.q[0] + self.q[1] * x + self.q[2] * y
    }

    fn vector(of: &[DVec3; 3], x: f64, y: f64) -> DVec3 {
        of[0] + of[1] * x + of[2] * y
    }
}

struct Bound<'a>(&'a MaterialLighting, &'a Block);

impl Kernel for Bound<'_> {
    /// Of cells of 2x2, 4x4 and 8x8.
    type Output = [f32; 3];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> [f32; 3] {
        let Bound(lighting, block) = self;
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        let vector =
            |of: &[DVec3; 3], (x, y)| splat3(s, Block::vector(of, x, y).to_array().map(|v| v as f32));
        let block = BlockCorners {
            q: corners.map(|(x, y)| s.splat(block.q_at(x, y) as f32)),
            points: corners.map(|at| vector(&block.ray, at)),
            normals: corners.map(|at| vector(&block.normal, at)),
            to_viewer: None,
        };
        let errors = errors_of_cells(s, lighting, &block);
        let mut bounds = [0.0; 3];
        for (side, bound) in [2, 4, 8].into_iter().zip(&mut bounds) {
            let mut out = [0.0; 16];
            s.store(errors.of_cell(s, side), &mut out[..S::LANES]);
            *bound = out[0];
        }
        bounds
    }
}

/// The lighting model in f64: the sum of all parts, of the first channel.
fn light_at(lighting: &MaterialLighting, block: &Block, x: f64, y: f64) -> f64 {
    let point = Block::vector(&block.ray, x, y) / block.q_at(x, y);
    let (normal, viewer) = (Block::vector(&block.normal, x, y).normalize(), -point.normalize());
    let of = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let power = |x: f64, n: Exponent| match n {
        Exponent::Integer(n) => x.max(0.0).powi(n as i32),
        Exponent::Real(n) => libm::pow(x.max(0.0), f64::from(n)),
    };
    let mut sum = 0.0;
    for light in &lighting.lights {
        let (to_light, mut strength) = match light.position {
            LightPosition::Toward(d) => (of(d), 1.0),
            LightPosition::At(p) => {
                let d = of(p) - point;
                let distance = d.length();
                let [c, l, q] = light.attenuation.unwrap_or([1.0, 0.0, 0.0]).map(f64::from);
                let fading = c + l * distance + q * distance * distance;
                let strength = 1.0 / if light.is_clamped { fading.max(1.0) } else { fading };
                let is_reached = distance * distance <= f64::from(light.reach2);
                (d / distance, if is_reached { strength } else { 0.0 })
            }
        };
        let along = |axis: [f32; 3]| -to_light.dot(of(axis));
        strength *= match light.cone {
            Cone::None => 1.0,
            Cone::Power { axis, cos_angle, .. } if along(axis) < f64::from(cos_angle) => 0.0,
            Cone::Power { axis, exponent, .. } => power(along(axis), exponent),
            Cone::Linear { axis, beam, cut_off } => {
                let angle = libm::acos(along(axis).clamp(-1.0, 1.0));
                match angle {
                    outside if outside >= f64::from(cut_off) => 0.0,
                    full if full <= f64::from(beam) => 1.0,
                    part => (f64::from(cut_off) - part) / f64::from(cut_off - beam),
                }
            }
        };
        let facing = normal.dot(to_light);
        sum +=
            strength * f64::from(light.ambient[0]) + strength * f64::from(light.diffuse[0]) * facing.max(0.0);
        if facing > 0.0 {
            let cosine = match lighting.model {
                LightingModel::Blinn => normal.dot((to_light + viewer).normalize()),
                _ => 2.0 * facing * normal.dot(viewer) - to_light.dot(viewer),
            };
            sum += strength * f64::from(light.specular[0]) * power(cosine, lighting.exponent);
        }
    }
    sum
}

/// Returns the largest difference between light and its interpolation over the cells of a block.
fn true_error(lighting: &MaterialLighting, block: &Block, side: usize) -> f64 {
    let [w, h] = BLOCK.map(|pixels| side as f64 / pixels as f64);
    let mut most: f64 = 0.0;
    for i in 0..=SAMPLES * SAMPLES {
        let (x, y) = ((i % SAMPLES) as f64 / (SAMPLES - 1) as f64, (i / SAMPLES) as f64 / SAMPLES as f64);
        let [left, top] = [(x / w).floor().min(1.0 / w - 1.0) * w, (y / h).floor().min(1.0 / h - 1.0) * h];
        let at = |x: f64, y: f64| light_at(lighting, block, left + x, top + y);
        let (across, down) = ((x - left) / w, (y - top) / h);
        let upper = at(0.0, 0.0) + (at(w, 0.0) - at(0.0, 0.0)) * across;
        let lower = at(0.0, h) + (at(w, h) - at(0.0, h)) * across;
        most = most.max((light_at(lighting, block, x, y) - (upper + (lower - upper) * down)).abs());
    }
    most
}

/// A generator of pseudo-random numbers (xorshift).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn one_of(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            if v.length() > 0.1 && v.length() < 1.0 {
                return v.normalize();
            }
        }
    }

    /// Returns a block of a face's pixels, 1 to 10 from the eye, of 0.001 to 0.3 of that.
    fn block(&mut self) -> Block {
        let size = 10f64.powf(self.between(-3.0, -0.5));
        let ahead = self.direction();
        let (across, down) = (self.direction() * size, self.direction() * size * 0.5);
        let q = 1.0 / self.between(1.0, 10.0);
        let curve = self.one_of(2) as f64;
        let normal = (-ahead + 0.9 * self.direction()).normalize();
        let q = [q, q * size * self.between(-0.5, 0.5), q * size * self.between(-0.5, 0.5)];
        let turned = |k: f64, v: DVec3| normal * (k / q[0]) + curve * v;
        let normal = [normal, turned(q[1], across * 0.5), turned(q[2], down * 0.5)];
        Block { q, ray: [ahead, across, down], normal }
    }

    /// Returns a light near a face's block.
    fn light(&mut self, block: &Block) -> FastLight {
        let point = block.ray[0] / block.q[0];
        let f32s = |v: DVec3| v.to_array().map(|v| v as f32);
        let toward = (block.normal[0] + 0.8 * self.direction()).normalize();
        let distance = self.between(0.3, 8.0);
        let away = if self.one_of(4) == 0 { 1.0 } else { -1.0 };
        let axis = f32s((away * toward + 0.3 * self.direction()).normalize());
        let gray = |v: f64| [v as f32; 3];
        FastLight {
            position: match self.one_of(4) {
                0 => LightPosition::Toward(f32s(toward)),
                _ => LightPosition::At(f32s(point + toward * distance)),
            },
            cone: match self.one_of(4) {
                0 => Cone::Power { axis, cos_angle: 0.6, exponent: Exponent::Integer(3) },
                1 => {
                    let cut_off = self.between(0.4, 3.4) as f32;
                    Cone::Linear { axis, beam: cut_off * self.between(0.1, 1.2) as f32, cut_off }
                }
                _ => Cone::None,
            },
            reach2: if self.one_of(4) == 0 {
                (distance * distance * self.between(0.9, 1.2)) as f32
            } else {
                f32::INFINITY
            },
            is_reach_faded: false,
            least_cosine2: -1.0,
            ambient: gray(if self.one_of(3) == 0 { 0.2 } else { 0.0 }),
            diffuse: gray(self.unit()),
            specular: gray(if self.one_of(2) == 0 { self.unit() } else { 0.0 }),
            dark_cosine: -1.0,
            attenuation: (self.one_of(2) == 0)
                .then(|| [self.unit() as f32, (self.unit() * 0.3) as f32, (self.unit() * 0.1) as f32]),
            is_clamped: self.one_of(2) == 0,
        }
    }
}

#[test]
fn interpolated_light_is_within_the_bound() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut known, mut unseen, mut tight) = (0, 0, 0);
    for round in 0..6000 {
        let block = random.block();
        let mut lighting = MaterialLighting::constant([0.0; 3], [0.0; 3]);
        lighting.model = if random.one_of(2) == 0 { LightingModel::Phong } else { LightingModel::Blinn };
        lighting.exponent = match random.one_of(3) {
            0 => Exponent::Integer(8),
            1 => Exponent::Integer(60),
            _ => Exponent::Real(12.5),
        };
        lighting.needs_place = true;
        lighting.lights = (0..=random.one_of(3)).map(|_| random.light(&block)).collect();
        // Directions have no cone, no reach and no attenuation in any scene.
        for light in &mut lighting.lights {
            if let LightPosition::Toward(_) = light.position {
                (light.cone, light.attenuation, light.reach2) = (Cone::None, None, f32::INFINITY);
            }
        }
        let bounds = Level::in_four_lanes(Bound(&lighting, &block)).map(f64::from);
        if !bounds[0].is_finite() {
            continue;
        }
        known += 1;
        let errors = [2, 4, 8].map(|side| true_error(&lighting, &block, side));
        for (error, bound) in errors.into_iter().zip(bounds) {
            assert!(
                error <= bound * 1.001 + 1e-6,
                "round {round}: {error} is more than {bound}: {block:?} {lighting:?}"
            );
        }
        unseen += i32::from(bounds[1] <= 0.25 / 255.0);
        tight += i32::from(errors[1] * 12.0 > bounds[1]);
    }
    // A bound that nothing reaches would be of no use, nor one that nothing comes near.
    assert!(known > 3000 && unseen > 800 && tight > 300, "{known} bounds, {unseen} unseen, {tight} tight");
}

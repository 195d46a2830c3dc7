use super::*;
use crate::simd::{Kernel, Level, Portable, Simd};

struct Angles(Vec<f32>);

impl Kernel for Angles {
    type Output = Vec<f32>;
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Vec<f32> {
        let mut out = vec![0.0; self.0.len()];
        for (from, to) in self.0.chunks_exact(S::LANES).zip(out.chunks_exact_mut(S::LANES)) {
            s.store(acos(s, s.load(from)), to);
        }
        out
    }
}

#[test]
fn angles_are_those_of_their_cosines() {
    let cos: Vec<f32> = (0..4096).map(|i| i as f32 / 2047.5 - 1.0).collect();
    let truth = Angles(cos.clone()).run(Portable::<16>);
    for (c, a) in cos.iter().zip(&truth) {
        assert!((libm::acos(*c as f64) - *a as f64).abs() < 4e-7, "acos {c} is not {a}");
    }
    for level in Level::ALL {
        assert_eq!(level.dispatch(Angles(cos.clone())), truth, "{level:?}");
    }
}

struct Powers(Vec<f32>, Exponent);

impl Kernel for Powers {
    type Output = Vec<f32>;
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Vec<f32> {
        let mut out = vec![0.0; self.0.len()];
        for (from, to) in self.0.chunks_exact(S::LANES).zip(out.chunks_exact_mut(S::LANES)) {
            s.store(power(s, s.load(from), self.1), to);
        }
        out
    }
}

#[test]
fn powers_are_within_a_hundredth_of_a_byte_and_alike_at_every_level() {
    let xs: Vec<f32> =
        (0..4096).map(|i| i as f32 / 4095.0).chain((0..4096).map(|i| 1.0 - i as f32 * 1e-6)).collect();
    for n in [0.0, 0.5, 1.0, 2.0, 25.6, 32.0, 100.3, 999.5, 1000.0] {
        let exponent = Exponent::new(n).expect("in range");
        let truth = Powers(xs.clone(), exponent).run(Portable::<16>);
        for (x, p) in xs.iter().zip(&truth) {
            let exact = if n == 0.0 { 1.0 } else { libm::pow(*x as f64, n) };
            assert!((*p as f64 - exact).abs() < 1e-4, "{x}^{n} = {exact}, not {p}");
        }
        for level in Level::ALL {
            let fast = level.dispatch(Powers(xs.clone(), exponent));
            assert!(fast.iter().zip(&truth).all(|(a, b)| a.to_bits() == b.to_bits()), "{level:?} n = {n}");
        }
    }
    for n in [1000.5, f64::NAN, -1.0, 0.399, 1e-3, f64::MIN_POSITIVE] {
        assert_eq!(Exponent::new(n), None, "{n}");
    }
    for n in [0.0, 0.4, 1.0, 1000.0] {
        let exponent = Exponent::new(n).expect("in range");
        let least = Powers(vec![1e-7; 16], exponent).run(Portable::<16>)[0];
        assert!(n == 0.0 || least < 1.0 / 510.0, "1e-7^{n} is {least}");
    }
}

/// Lights points by their normals in both ways.
struct ByNormal<'a>(&'a MaterialLighting, &'a [[f32; 3]]);

impl Kernel for ByNormal<'_> {
    type Output = Vec<[u32; 2]>;
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Vec<[u32; 2]> {
        let (mut out, nowhere) = (Vec::new(), [s.splat(0.0); 3]);
        for normals in self.1.chunks_exact(S::LANES) {
            let mut lanes = [[0.0; 16]; 3];
            for (i, normal) in normals.iter().enumerate() {
                (0..3).for_each(|k| lanes[k][i] = normal[k]);
            }
            let normal = [s.load(&lanes[0]), s.load(&lanes[1]), s.load(&lanes[2])];
            let colors =
                [light_by_normal(s, self.0, normal), light(s, self.0, nowhere, normal, nowhere).diffuse];
            let mut bits = [[0.0; 16]; 2];
            for (fast, all) in colors[0].into_iter().zip(colors[1]) {
                s.store(fast, &mut bits[0]);
                s.store(all, &mut bits[1]);
                out.extend((0..S::LANES).map(|i| [bits[0][i].to_bits(), bits[1][i].to_bits()]));
            }
        }
        out
    }
}

#[test]
fn light_by_the_normal_alone_is_that_of_all_equations() {
    let light = |toward: [f32; 3], ambient: f32| FastLight {
        position: LightPosition::Toward(toward),
        cone: Cone::None,
        reach2: f32::INFINITY,
        is_reach_faded: false,
        least_cosine2: -1.0,
        ambient: [ambient, 0.5 * ambient, 0.0],
        diffuse: [0.7, 0.4, 0.1],
        specular: [0.0; 3],
        dark_cosine: -1.0,
        attenuation: None,
        is_clamped: false,
    };
    let mut lighting = MaterialLighting::constant([0.1, 0.0, 0.3], [0.2; 3]);
    lighting.lights =
        vec![light([0.0, 0.0, 1.0], 0.0), light([0.6, -0.8, 0.0], 0.3), light([-1.0, 0.0, 0.0], 0.0)];
    let turned = |i: usize| {
        let (sin, cos) = (i as f32 * 0.37).sin_cos();
        [sin * cos, sin * sin, cos]
    };
    let normals: Vec<[f32; 3]> = (0..512).map(turned).collect();
    for level in Level::ALL {
        let colors = level.dispatch(ByNormal(&lighting, &normals));
        assert_eq!(colors.len(), 3 * normals.len());
        assert!(colors.iter().all(|[fast, all]| fast == all), "{level:?}");
        assert!(colors.iter().any(|[fast, _]| *fast != colors[0][0]), "one colour");
    }
}

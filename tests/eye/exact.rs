//! The eye against the reference in rational numbers that tries every face: nearest points,
//! visible facets and shadows must not be lost to rounding or to a search that skips facets.

use fbptr::eye::{EyeLight, EyeLightKind, EyeScene, Facet, Falloff, Pose, SceneParts, render};
use fbptr::truth::Rational;
use fbptr::truth::eye::see;

/// A small generator (xorshift64*), seeded by the case.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: i64) -> i64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        ((self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as i64).rem_euclid(n)
    }

    /// Returns a multiple of 1/8 in lo..hi.
    fn real(&mut self, lo: i64, hi: i64) -> f64 {
        lo as f64 + self.below((hi - lo) * 8) as f64 / 8.0
    }

    fn point(&mut self, dim: usize, lo: i64, hi: i64) -> Vec<f64> {
        (0..dim).map(|_| self.real(lo, hi)).collect()
    }
}

fn parts(dim: usize, pixels: &[u32], aperture: f64) -> SceneParts {
    SceneParts {
        dim,
        pixels: pixels.to_vec(),
        distance: 1.0,
        size: vec![2.0; pixels.len()],
        aperture_tan: vec![aperture; dim - 1 - pixels.len()],
        diffuse: [0.125, 0.25, 0.0],
        view: Falloff { k: 2.0, n: 1.0 },
        background: [3.0, 2.0, 1.0],
        pose: Pose::identity(dim),
        lights: Vec::new(),
        facets: Vec::new(),
    }
}

fn check(name: &str, parts: SceneParts) -> usize {
    let scene = EyeScene::new(parts).unwrap();
    let picture = render(&scene);
    let mut hits = 0;
    for (i, want) in see::<Rational>(&scene, 0..scene.pixel_count()).iter().enumerate() {
        assert_eq!(picture.facet[i], want.facet, "{name}: facet of pixel {i}");
        if want.facet >= 0 {
            hits += 1;
            let off = (picture.dist[i] - want.distance).abs();
            assert!(off <= 1e-12 * want.distance.max(1.0), "{name}: distance of pixel {i} is {off} off");
            assert_eq!(picture.flags(i), want.lit, "{name}: lit flags of pixel {i}");
        }
        for c in 0..3 {
            let off = (picture.color[i][c] - want.color[c]).abs();
            assert!(off <= 1e-9, "{name}: channel {c} of pixel {i} is {off} off");
        }
    }
    hits
}

/// Returns random facets with coordinates that are multiples of 1/8, so that coincidences are
/// common, and a light of each kind.
fn random_scene(dim: usize, pixels: &[u32], facets: usize, seed: u64) -> SceneParts {
    let dice = &mut Dice(seed * 0x9E37_79B9 + 1);
    let mut scene = parts(dim, pixels, [0.5, 0.25, 1.0][dice.below(3) as usize]);
    let color = |dice: &mut Dice| std::array::from_fn(|_| dice.real(0, 1));
    for i in 0..facets {
        // Some begin with a vertex of the previous one: shared corners and ridges.
        let shared = if i == 0 { 0 } else { dice.below(dim as i64) as usize };
        let mut v: Vec<Vec<f64>> = if i == 0 { vec![] } else { scene.facets[i - 1].v[..shared].to_vec() };
        while v.len() < dim {
            let reach = dim as i64 * (dim as i64 - 1) / 2;
            let mut point = dice.point(dim, -reach, reach);
            point[0] += reach as f64 / 2.0;
            v.push(point);
        }
        scene.facets.push(Facet { v, color: color(dice).map(|x: f64| x * 255.0) });
    }
    let mut direction = dice.point(dim, -2, 2);
    direction[1] += 5.0;
    let kinds = [
        EyeLightKind::Sun { direction: direction.clone() },
        EyeLightKind::Plane { direction, point: dice.point(dim, -1, 2) },
        EyeLightKind::Radial { position: dice.point(dim, -3, 3) },
    ];
    for (i, kind) in kinds.into_iter().enumerate() {
        let falloff = Falloff { k: 2.0, n: if i == 0 { 0.0 } else { 1.0 } };
        scene.lights.push(EyeLight { kind, falloff, color: color(dice) });
    }
    scene
}

fn random(dim: usize, pixels: &[u32], facets: usize, seeds: std::ops::Range<u64>, least_hits: usize) {
    let mut hits = 0;
    for seed in seeds {
        hits += check(&format!("{dim} on {pixels:?}, seed {seed}"), random_scene(dim, pixels, facets, seed));
    }
    assert!(hits >= least_hits, "only {hits} pixels hit anything");
}

#[test]
fn random_scenes_seen_by_rays() {
    random(2, &[16], 8, 0..30, 100);
    random(3, &[8, 4], 8, 0..10, 100);
    random(4, &[4, 4, 2], 6, 0..6, 30);
    random(5, &[2, 2, 2, 2], 4, 0..3, 5);
}

#[test]
fn random_scenes_with_one_hidden_axis() {
    random(3, &[16], 6, 0..12, 100);
    random(4, &[4, 4], 6, 0..8, 50);
    random(5, &[2, 2, 2], 4, 0..4, 10);
}

#[test]
fn random_scenes_with_two_hidden_axes() {
    random(4, &[8], 4, 0..6, 20);
    random(5, &[4, 2], 4, 0..3, 5);
}

#[test]
fn random_scenes_with_three_hidden_axes() {
    random(5, &[4], 3, 0..2, 3);
    random(6, &[2, 2], 2, 0..2, 0);
}

#[test]
fn the_truth_reproduces_the_worked_cases() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/nd-cases");
    for name in
        ["c01_2to1_parallel", "c02_2to1_radial", "c05_3to1_cubes", "h01_edge_on", "h02_shared_vertices_2d"]
    {
        let text = std::fs::read(folder.join(format!("{name}.json"))).unwrap();
        let case: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let scene = EyeScene::from_json(&text).unwrap();
        let expected = fbptr::eye::EyePicture::from_value(&case["expected"], &scene).unwrap();
        for (i, seen) in see::<Rational>(&scene, 0..scene.pixel_count()).iter().enumerate() {
            assert_eq!(
                (seen.facet, &seen.lit[..]),
                (expected.facet[i], if seen.facet < 0 { &[] } else { expected.flags(i) })
            );
            assert!(seen.facet < 0 || (seen.distance - expected.dist[i]).abs() <= 1e-9 * seen.distance);
            assert!((0..3).all(|c| (seen.color[c] - expected.color[i][c]).abs() <= 1e-6), "{name} {i}");
        }
    }
}

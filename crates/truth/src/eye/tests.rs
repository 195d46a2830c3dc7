//! The eye in either arithmetic sees the same.

use super::super::{Rational, scenes::Random};
use super::{Number, see};
use crate::DoubleDouble;
use fbptr_core::eye::{EyeLight, EyeLightKind, EyeScene, Facet, Falloff, Pose, SceneParts};

/// Returns random simplices with a light, of multiples of 1/8.
fn scene(seed: u64, dim: usize, pixels: &[u32]) -> EyeScene {
    let mut r = Random::new(seed);
    let mut eighths = |lo: f64, hi: f64| (r.real(lo, hi) * 8.0).round() / 8.0;
    let facets = (0..6)
        .map(|i| {
            let center: Vec<f64> =
                (0..dim).map(|k| if k == 0 { eighths(3.0, 6.0) } else { eighths(-1.0, 1.0) }).collect();
            let v = (0..dim).map(|_| center.iter().map(|c| c + eighths(-1.5, 1.5)).collect()).collect();
            Facet { v, color: [40.0 * f64::from(i), 90.0, 120.0] }
        })
        .collect();
    let position = (0..dim).map(|k| if k == 1 { 6.0 } else { 0.25 }).collect();
    let light = EyeLight {
        kind: EyeLightKind::Radial { position },
        falloff: Falloff { k: 4.0, n: 1.0 },
        color: [0.5, 0.4, 0.3],
    };
    EyeScene::new(SceneParts {
        dim,
        pixels: pixels.to_vec(),
        distance: 1.0,
        size: vec![2.0; pixels.len()],
        aperture_tan: vec![0.5; dim - 1 - pixels.len()],
        diffuse: [0.125, 0.25, 0.0],
        view: Falloff { k: 2.0, n: 1.0 },
        background: [3.0, 2.0, 1.0],
        pose: Pose::identity(dim),
        lights: vec![light],
        facets,
    })
    .unwrap()
}

#[test]
fn thirty_two_digits_see_what_rational_numbers_see() {
    let mut hits = 0;
    for (seed, dim, pixels) in [(1, 3, vec![12]), (2, 3, vec![4, 4]), (3, 4, vec![4, 4]), (4, 4, vec![8])] {
        let scene = scene(seed, dim, &pixels);
        let all = 0..scene.pixel_count();
        let (exact, found) = (see::<Rational>(&scene, all.clone()), see::<DoubleDouble>(&scene, all));
        assert_eq!(exact, found, "{dim} dimensions on {}", pixels.len());
        hits += exact.iter().filter(|s| s.facet >= 0).count();
    }
    assert!(hits > 10, "{hits}");
}

#[test]
fn both_solve_and_both_refuse_what_is_singular() {
    fn solved<N: Number>(rows: [[f64; 3]; 2]) -> Option<Vec<f64>> {
        let rows = rows.map(|r| r.map(N::of).to_vec()).to_vec();
        Some(N::solve(rows)?.iter().map(N::to_f64).collect())
    }
    for rows in [[[0.0, 2.0, 6.0], [4.0, 1.0, 5.0]], [[1.0, 2.0, 3.0], [2.0, 4.0, 7.0]]] {
        assert_eq!(solved::<Rational>(rows), solved::<DoubleDouble>(rows));
    }
    assert_eq!(solved::<Rational>([[0.0, 2.0, 6.0], [4.0, 1.0, 5.0]]), Some(vec![0.5, 3.0]));
    assert_eq!(solved::<DoubleDouble>([[1.0, 2.0, 3.0], [2.0, 4.0, 7.0]]), None);
}

//! Hard cases of the N-dimensional eye: units from 1e-6 to 1e6, ties, and apertures of zero, against
//! rational numbers, on every number of threads.

use super::{HardRow, THREADS};
use crate::fibre_fan::shown;
use fbptr_core::executor::Executor;
use fbptr_core::eye::{EyePicture, EyeScene, Fibre, MISS, render_with};
use fbptr_server::worker_pool;
use fbptr_truth::Rational;
use fbptr_truth::eye::{SeenPoint, see};
use fbptr_truth::scenes::Random;
use serde_json::{Value, json};

/// Returns the rows of all cases.
pub(super) fn rows() -> Vec<HardRow> {
    let mut rows = scales();
    rows.extend(exact_cases().iter().map(|(name, scene)| against_rational(name, scene)));
    rows
}

fn scene(text: &Value) -> EyeScene {
    EyeScene::from_json(text.to_string().as_bytes()).expect("a scene of this file's own making")
}

/// Returns random simplices of multiples of 1/8 before the eye.
fn simplices(seed: u64, dim: usize, count: usize) -> Vec<Vec<Vec<f64>>> {
    let mut r = Random::new(seed);
    let mut eighths = |lo: f64, hi: f64| (8.0 * r.real(lo, hi)).round() / 8.0;
    let mut simplex = || -> Vec<Vec<f64>> {
        let center: Vec<f64> =
            (0..dim).map(|k| if k == 0 { eighths(3.0, 6.0) } else { eighths(-1.0, 1.0) }).collect();
        (0..dim).map(|_| center.iter().map(|c| c + eighths(-1.2, 1.2)).collect()).collect()
    };
    (0..count).map(|_| simplex()).collect()
}

fn view(dim: usize, pixels: &[u32], aperture: f64, facets: &[Vec<Vec<f64>>]) -> EyeScene {
    let facets: Vec<Value> =
        (0..).zip(facets).map(|(i, v)| json!({ "v": v, "color": [40 + 20 * (i % 10), 90, 120] })).collect();
    scene(&json!({
        "dim": dim, "pixels": pixels, "d": 1, "S": vec![1.5; pixels.len()],
        "aperture_tan": vec![aperture; dim - 1 - pixels.len()], "I_d": 0.5,
        "view": { "k": 2, "n": 1 }, "lights": [], "facets": facets,
    }))
}

/// Returns scenes with ties, and with apertures of zero.
fn exact_cases() -> Vec<(String, EyeScene)> {
    let mut cases = Vec::new();
    for (dim, pixels) in [(3usize, vec![12]), (4, vec![4, 4])] {
        let (once, m) = (simplices(11, dim, 5), pixels.len());
        let twice: Vec<_> = once.iter().chain(&once).cloned().collect();
        let mirrored: Vec<_> = once
            .iter()
            .cloned()
            .chain(once.iter().map(|s| {
                let mirror = |p: &Vec<f64>| {
                    p.iter().enumerate().map(|(k, x)| if k == dim - 1 { -x } else { *x }).collect()
                };
                s.iter().map(mirror).collect()
            }))
            .collect();
        cases.push((format!("each facet twice, {dim} dimensions on {m}"), view(dim, &pixels, 0.5, &twice)));
        let name = format!("facets and their mirror images at one distance, {dim} dimensions on {m}");
        cases.push((name, view(dim, &pixels, 0.5, &mirrored)));
        cases.push((format!("an aperture of zero, {dim} dimensions on {m}"), view(dim, &pixels, 0.0, &once)));
    }
    cases
}

fn against_rational(name: &str, scene: &EyeScene) -> HardRow {
    let all: Vec<usize> = (0..scene.pixel_count()).collect();
    let exact = see::<Rational>(scene, all.iter().copied());
    let pictures = THREADS.map(|threads| {
        let pool = Executor::of_pool(worker_pool(Some(threads)));
        render_with(scene, Fibre::Exact, &pool).expect("no fan")
    });
    let unlike = pictures.iter().filter(|p| !is_same(p, &pictures[0])).count();
    let found = shown(&pictures[0], &all);
    let other = found.iter().zip(&exact).filter(|(a, b)| a.facet != b.facet).count();
    let off = |(a, b): (&SeenPoint, &SeenPoint)| {
        if b.facet == MISS || a.facet == MISS { 0.0 } else { (a.distance / b.distance - 1.0).abs() }
    };
    let worst = found.iter().zip(&exact).map(off).fold(0f64, f64::max);
    HardRow {
        case: format!("N-D: {name}"),
        promise: "the facets of rational numbers, distances to 1e-12, the same on 1, 2, 3 and 16 threads"
            .into(),
        measured: format!("{other} other facets, distances to {worst:.1e}, {unlike} pictures differ"),
        passed: other == 0 && worst <= 1e-12 && unlike == 0,
    }
}

fn is_same(a: &EyePicture, b: &EyePicture) -> bool {
    let bits = |p: &EyePicture| p.color.iter().flatten().map(|c| c.to_bits()).collect::<Vec<_>>();
    a.facet == b.facet && bits(a) == bits(b)
}

/// Compares the same world in units from 1e-6 to 1e6: equal facets, and distances in proportion.
fn scales() -> Vec<HardRow> {
    let pools = THREADS.map(|threads| Executor::of_pool(worker_pool(Some(threads))));
    // The picture of one thread, and the number of those of others that differ from it.
    let picture = |scale: f64| {
        let mut r = Random::new(77);
        let facets: Vec<_> = (0..20)
            .map(|_| {
                let c = [r.real(3.0, 6.0), r.real(-1.0, 1.0), r.real(-1.0, 1.0)];
                let v: Vec<Vec<f64>> =
                    (0..3).map(|_| c.iter().map(|c| scale * (c + r.real(-0.7, 0.7))).collect()).collect();
                json!({ "v": v, "color": [200, 100, 50] })
            })
            .collect();
        let scene = scene(&json!({
            "dim": 3, "pixels": [64], "d": scale, "S": [1.6 * scale], "aperture_tan": [0.5], "I_d": 0.3,
            "view": { "k": 2, "n": 1 }, "lights": [], "facets": facets,
        }));
        let [first, others @ ..] =
            pools.each_ref().map(|pool| render_with(&scene, Fibre::Exact, pool).expect("no fan"));
        let unlike = others.iter().filter(|other| !is_same(&first, other)).count();
        (first, unlike)
    };
    let (unit, _) = picture(1.0);
    [1e-6, 1e-3, 1e3, 1e6]
        .map(|scale| {
            let (scaled, unlike) = picture(scale);
            let other = unit.facet.iter().zip(&scaled.facet).filter(|(a, b)| a != b).count();
            let off = unit.dist.iter().zip(&scaled.dist).filter(|(a, _)| a.is_finite());
            let worst = off.fold(0f64, |m, (a, b)| m.max((b / scale / a - 1.0).abs()));
            let digits = 1e-12;
            HardRow {
                case: format!("an N-dimensional world in units of {scale:e}"),
                promise: format!(
                    "the same facets, distances to {digits:e} of themselves, the same on 1, 2, 3 and 16 threads"
                ),
                measured: format!(
                    "{other} other facets, distances to {worst:.1e}, {unlike} pictures differ"
                ),
                passed: other == 0 && worst <= digits && unlike == 0,
            }
        })
        .to_vec()
}

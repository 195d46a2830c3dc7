//! The N-dimensional eye: a fan of rays compared with the exact fibre.

use super::experiment::{Bound, Effort, Experiment, Row};
use crate::executor::Executor;
use crate::eye::{EyePicture, EyeScene, Fibre, MISS, render_with};
use crate::truth::scenes::Random;
use serde_json::json;

/// Experiment on fans of rays.
pub(super) const FAN: Experiment = Experiment {
    id: "fan",
    title: "The fibre of the N-dimensional eye",
    about: "Random simplices of N dimensions on screens of M. Each pixel sees the \
            nearest point within its fibre; a fan of rays samples the fibre and so sees further or past it, never nearer.",
    columns: &[
        "pixels that miss",
        "pixels with another facet",
        "largest extra distance",
        "colour RMSE, 1/255",
        "pixels seen nearer",
    ],
    plotted: 3,
    unit: "pixel",
    rows,
};

/// Returns simplices around a point in front of the eye.
fn scene(dim: usize, pixels: &[u32], facets: usize) -> EyeScene {
    let mut r = Random::new(2002 + dim as u64);
    // In more dimensions a fibre passes between small simplices.
    let reach = if dim > 4 { 1.6 } else { 0.6 };
    let facets: Vec<_> = (0..facets)
        .map(|_| {
            let center: Vec<f64> =
                (0..dim).map(|k| if k == 0 { r.real(3.0, 6.0) } else { r.real(-1.5, 1.5) }).collect();
            let vertices: Vec<Vec<f64>> =
                (0..dim).map(|_| center.iter().map(|c| c + r.real(-reach, reach)).collect()).collect();
            let color: Vec<u32> = (0..3).map(|_| 60 + r.below(190)).collect();
            json!({ "v": vertices, "color": color })
        })
        .collect();
    let text = json!({
        "dim": dim,
        "pixels": pixels,
        "d": 1,
        "S": pixels.iter().map(|_| 1.6).collect::<Vec<f64>>(),
        "aperture_tan": vec![0.5; dim - 1 - pixels.len()],
        "I_d": 0.3,
        "view": { "k": 2, "n": 1 },
        "lights": [],
        "facets": facets,
    })
    .to_string();
    EyeScene::from_json(text.as_bytes()).expect("a scene of this file's own making")
}

fn errors(found: &EyePicture, truth: &EyePicture) -> Vec<f64> {
    let (mut missed, mut other, mut nearer, mut further, mut squares) = (0, 0, 0, 0f64, 0f64);
    for i in 0..truth.facet.len() {
        if truth.facet[i] != MISS && found.facet[i] == MISS {
            missed += 1;
        } else if truth.facet[i] != found.facet[i] {
            other += 1;
        }
        let is_nearer = truth.facet[i] == MISS || found.dist[i] < truth.dist[i] * (1.0 - 1e-9);
        nearer += u32::from(found.facet[i] != MISS && is_nearer);
        if truth.facet[i] != MISS && found.facet[i] != MISS {
            further = further.max(found.dist[i] - truth.dist[i]);
        }
        squares += (0..3).map(|c| found.color[i][c] - truth.color[i][c]).map(|d| d * d).sum::<f64>();
    }
    let n = truth.facet.len() as f64;
    vec![missed as f64, other as f64, further, (squares / (3.0 * n)).sqrt(), f64::from(nearer)]
}

/// Returns the rays of a fan in one fibre; 0 for the exact search.
fn rays(fibre: Fibre, hidden: usize) -> u64 {
    match fibre {
        Fibre::Exact => 0,
        Fibre::Fan(rays) => u64::from(rays).pow(hidden as u32),
    }
}

fn rows(effort: &Effort) -> Vec<Row> {
    let (line, side, cube) = effort.pick((256, 24, 8), (2048, 96, 24));
    let subjects = [
        ("3 dimensions on 1", scene(3, &[line], 40)),
        ("4 dimensions on 2", scene(4, &[side, side], 30)),
        ("5 dimensions on 3", scene(5, &[cube, cube, cube], 30)),
        ("4 dimensions on 1", scene(4, &[line / 4], 40)),
        ("5 dimensions on 2", scene(5, &[side / 2, side / 2], 30)),
        ("5 dimensions on 1", scene(5, &[line / 16], 40)),
    ];
    let ways = [
        ("exact", Fibre::Exact),
        ("fan of 3 rays", Fibre::Fan(3)),
        ("fan of 9 rays", Fibre::Fan(9)),
        ("fan of 33 rays", Fibre::Fan(33)),
        ("fan of 129 rays", Fibre::Fan(129)),
    ];
    let mut rows = Vec::new();
    for (subject, scene) in &subjects {
        let draw = |fibre| render_with(scene, fibre, &Executor::default()).expect("fans of at most 129 rays");
        let truth = draw(Fibre::Exact);
        // A fan has as many rays as the power of its size to the number of hidden axes.
        let hidden = scene.hidden_dim();
        for (name, fibre) in ways.into_iter().filter(|(_, fibre)| rays(*fibre, hidden) <= 2_000) {
            let (picture, timing) = effort.run(|| draw(fibre));
            let bounds = match fibre {
                Fibre::Exact => (0..5).map(|column| Bound { column, at_most: 0.0 }).collect(),
                Fibre::Fan(_) => vec![Bound { column: 4, at_most: 0.0 }],
            };
            rows.push(Row {
                subject: (*subject).into(),
                alternative: name.into(),
                is_default: fibre == Fibre::Exact,
                errors: errors(&picture, &truth),
                bounds,
                is_run: true,
                timing,
                work: truth.facet.len() as f64,
                picture: None,
            });
        }
    }
    rows
}

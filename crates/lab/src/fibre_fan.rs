//! The N-dimensional eye: a fan of rays compared with the exact fibre.

use super::clock::Work;
use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use fbptr_core::executor::Executor;
use fbptr_core::eye::{EyePicture, EyeScene, Fibre, MISS, render_with};
use fbptr_truth::eye::{SeenPoint, see};
use fbptr_truth::scenes::Random;
use fbptr_truth::{DoubleDouble, Rational};
use serde_json::json;

/// Experiment on fans of rays.
pub(super) const FAN: Experiment = Experiment {
    id: "fan",
    title: "The fibre of the N-dimensional eye",
    about: "Random simplices of N dimensions on screens of M. Each pixel sees the \
            nearest point within its fibre; a fan of rays samples the fibre and so sees further or past it, never nearer. \
            Whole pictures are timed; up to 64 pixels of each, evenly spread, are compared.",
    truth: Truth {
        is: "the least norm over every set of active inequalities of every facet, without any search",
        digits: "32",
        second_way: "rational numbers on small scenes; the largest relative difference of a distance",
    },
    check,
    columns: &[
        "pixels that miss",
        "pixels with another facet",
        "largest difference of distance",
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

/// Pixels compared at most.
const COMPARED: usize = 64;

/// Returns the numbers of `COMPARED` pixels of a picture, evenly spread; all of a smaller one.
pub(super) fn spread(pixels: usize) -> Vec<usize> {
    let count = pixels.min(COMPARED);
    (0..count).map(|i| (2 * i + 1) * pixels / (2 * count)).collect()
}

/// Returns what a picture shows at some pixels.
pub(super) fn shown(picture: &EyePicture, pixels: &[usize]) -> Vec<SeenPoint> {
    let seen = |&i: &usize| SeenPoint {
        facet: picture.facet[i],
        distance: if picture.facet[i] == MISS { f64::INFINITY } else { picture.dist[i] },
        lit: if picture.facet[i] == MISS { Vec::new() } else { picture.flags(i).to_vec() },
        color: picture.color[i],
    };
    pixels.iter().map(seen).collect()
}

/// Compares rational numbers with 32 digits on three small scenes.
fn check(_: &Effort) -> Check {
    let mut difference = 0f64;
    for scene in [scene(3, &[12], 8), scene(4, &[3, 3], 6), scene(4, &[4], 4)] {
        let all = 0..scene.pixel_count();
        for (a, b) in see::<Rational>(&scene, all.clone()).iter().zip(see::<DoubleDouble>(&scene, all)) {
            let off = if a.facet == MISS { 0.0 } else { (a.distance / b.distance - 1.0).abs() };
            difference = difference.max(if a.facet == b.facet { off } else { f64::INFINITY });
        }
    }
    Check { difference, at_most: 1e-15 }
}

fn errors(found: &[SeenPoint], truth: &[SeenPoint]) -> Vec<f64> {
    let (mut missed, mut other, mut nearer, mut off, mut squares) = (0, 0, 0, 0f64, 0f64);
    for (found, truth) in found.iter().zip(truth) {
        if truth.facet != MISS && found.facet == MISS {
            missed += 1;
        } else if truth.facet != found.facet {
            other += 1;
        }
        let is_nearer = truth.facet == MISS || found.distance < truth.distance * (1.0 - TIE);
        nearer += u32::from(found.facet != MISS && is_nearer);
        if truth.facet != MISS && found.facet != MISS {
            off = off.max((found.distance - truth.distance).abs());
        }
        squares += (0..3).map(|c| found.color[c] - truth.color[c]).map(|d| d * d).sum::<f64>();
    }
    vec![missed as f64, other as f64, off, (squares / (3 * truth.len()) as f64).sqrt(), f64::from(nearer)]
}

/// Relative difference of two distances that counts as a tie.
const TIE: f64 = 1e-9;

/// Turns a pixel that sees a facet into one that misses or sees another, or moves distance or colour
/// by a little more than the bound.
fn mutate(found: &mut [SeenPoint], truth: &[SeenPoint], bound: &Bound) {
    let count = found.len() as f64;
    let Some((found, truth)) = found.iter_mut().zip(truth).find(|(_, t)| t.facet != MISS) else { return };
    match bound.column {
        0 => found.facet = MISS,
        1 => found.facet = truth.facet + 1,
        2 => found.distance = truth.distance + 2.0 * bound.at_most,
        // One pixel's part of the mean.
        _ => found.color[0] = truth.color[0] + 2.0 * bound.at_most * (3.0 * count).sqrt(),
    }
}

/// Returns the bounds of the exact fibre.
fn exact_bounds() -> Vec<Bound> {
    let promise = "an exact fibre loses no facet; ties are within 1e-9 of the distance";
    let digits = "exact fibres: 12 digits of distances below 10, by the specification";
    let colors = "exact fibres: the colour falls by less than 255 a unit of distance, 12 digits";
    let bound = |column, at_most, because| Bound { column, at_most, because };
    vec![
        bound(0, 0.0, promise),
        bound(1, 0.0, promise),
        bound(2, 1e-11, digits),
        bound(3, 255.0 * 1e-11, colors),
        bound(4, 0.0, promise),
    ]
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
        let compared = spread(scene.pixel_count());
        let truth = see::<DoubleDouble>(scene, compared.iter().copied());
        // A fan has as many rays as the power of its size to the number of hidden axes.
        let hidden = scene.hidden_dim();
        let ways: Vec<_> = ways.into_iter().filter(|(_, fibre)| rays(*fibre, hidden) <= 2_000).collect();
        let work = |&(_, fibre): &(_, Fibre)| Box::new(move || draw(fibre)) as Work<EyePicture>;
        let drawn = effort.run_in_turns(ways.iter().map(work).collect());
        for ((name, fibre), (picture, timing)) in ways.into_iter().zip(drawn) {
            let (standing, bounds) = match fibre {
                Fibre::Exact => (Standing::Default, exact_bounds()),
                Fibre::Fan(_) => {
                    let because = "a fan's rays lie in the fibre, whose nearest point is the truth";
                    (Standing::Mode, vec![Bound { column: 4, at_most: 0.0, because }])
                }
            };
            let found = shown(&picture, &compared);
            let judge = |found: &Vec<SeenPoint>| errors(found, &truth);
            let mutate = |found: &mut Vec<SeenPoint>, bound: &Bound| match bound.column {
                // The facet must be one that the way sees.
                4 => {
                    if let Some((f, t)) = found.iter_mut().zip(&truth).find(|(_, t)| t.facet != MISS) {
                        (f.facet, f.distance) = (t.facet, t.distance * (1.0 - 2.0 * TIE));
                    }
                }
                _ => mutate(found, &truth, bound),
            };
            let row = Row::judged(effort, (subject, name, standing), &found, bounds, judge, mutate);
            rows.push(row.timed(timing, picture.facet.len() as f64));
        }
    }
    rows
}

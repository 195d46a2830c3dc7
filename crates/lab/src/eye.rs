//! Speed of the N-dimensional eye on several threads, with identical pictures.

use super::clock::Work;
use super::experiment::{Bound, Check, Effort, Experiment, Row, Truth};
use super::fibre_fan::{shown, spread};
use super::memory;
use super::scaling::{Scaling, ScalingPoint};
use super::threads::standing_of;
use fbptr_core::executor::Executor;
use fbptr_core::eye::shapes::{DemoScene, Shape, cross_polytope, cube};
use fbptr_core::eye::{EyePicture, EyeScene, Fibre, render_with};
use fbptr_truth::eye::{SeenPoint, see};
use fbptr_truth::scenes::Random;
use fbptr_truth::{DoubleDouble, Rational};
use serde_json::json;
use std::sync::Arc;

/// Experiment on the eye's threads.
pub(super) const EYE: Experiment = Experiment {
    id: "eye",
    title: "The N-dimensional eye on threads",
    about: "Whole pictures of the N-dimensional eye, exact fibres, lights with shadows, on one thread and on several. 64 pixels, \
            evenly spread, are compared with the truth, and every picture, bit by bit, with that of another number of threads.",
    truth: Truth {
        is: "the least norm over every set of active inequalities of every facet; lights past every facet",
        digits: "32",
        second_way: "rational numbers at four pixels of each scene; pixels that differ",
    },
    check,
    columns: &["compared pixels unlike the truth", "pixels unlike another number of threads"],
    plotted: 0,
    unit: "pixel",
    rows,
};

/// Returns two rotated tesseracts, one partly in front of the other, with a point light and a sun.
pub(super) fn two_tesseracts(pixels: [u32; 2]) -> EyeScene {
    let turns = vec![(0, 1, 30.0), (0, 2, 20.0), (1, 3, 40.0), (0, 3, 25.0)];
    let demo = DemoScene { pixels: pixels.to_vec(), aperture_tan: 0.4, turns };
    let mut parts = demo.scene(tesseract()).expect("turns in planes of its axes").into_parts();
    let small = tesseract().turned(0, 3, 33.0).turned(1, 2, 15.0).placed(0.45, &[-1.4, 0.9, -0.5, 0.1]);
    parts.facets.extend(small.facets(|cell| [40.0 + 25.0 * f64::from(cell), 90.0, 230.0]));
    EyeScene::new(parts).expect("a scene of this file's own making")
}

fn tesseract() -> Shape {
    cube(4).expect("4 is a dimension of cubes")
}

/// Returns the 16 tetrahedra of a cross-polytope in a volume, with one point light.
fn sixteen_tetrahedra(side: u32) -> EyeScene {
    let turns = vec![(0, 1, 30.0), (0, 2, 20.0), (1, 3, 40.0)];
    let demo = DemoScene { pixels: vec![side; 3], aperture_tan: 0.0, turns };
    let shape = cross_polytope(4).expect("4 is a dimension of cross-polytopes");
    let mut parts = demo.scene(shape).expect("turns in planes of its axes").into_parts();
    parts.lights.truncate(1);
    EyeScene::new(parts).expect("a scene of this file's own making")
}

fn pixels_unlike(a: &EyePicture, b: &EyePicture) -> usize {
    let lights = a.lit.len() / a.facet.len().max(1);
    let same_bits = |i: usize| {
        let color = |p: &EyePicture| p.color[i].map(f64::to_bits);
        a.facet[i] == b.facet[i]
            && a.dist[i].to_bits() == b.dist[i].to_bits()
            && a.lit[i * lights..][..lights] == b.lit[i * lights..][..lights]
            && color(a) == color(b)
    };
    (0..a.facet.len()).filter(|&i| !same_bits(i)).count()
}

/// Subject of the goal for whole pictures on a plane.
pub(super) const ON_A_PLANE: &str = "4-D on a plane: two tesseracts, 2 lights with shadows, 640x480";
/// Subject of the goal for whole pictures in a volume.
pub(super) const IN_A_VOLUME: &str = "4-D in a volume: 16 tetrahedra, 1 light, 64x64x64";

fn subjects(effort: &Effort) -> [(&'static str, EyeScene); 2] {
    [
        (
            effort.pick("4-D on a plane, 160x120", ON_A_PLANE),
            two_tesseracts(effort.pick([160, 120], [640, 480])),
        ),
        (effort.pick("4-D in a volume, 16x16x16", IN_A_VOLUME), sixteen_tetrahedra(effort.pick(16, 64))),
    ]
}

/// Counts the pixels at which rational numbers and 32 digits see something else.
fn check(effort: &Effort) -> Check {
    let mut differ = 0;
    for (_, scene) in subjects(effort) {
        let some: Vec<usize> = spread(scene.pixel_count()).into_iter().skip(8).step_by(16).collect();
        let exact = see::<Rational>(&scene, some.iter().copied());
        let found = see::<DoubleDouble>(&scene, some.iter().copied());
        differ += exact.iter().zip(&found).filter(|(a, b)| !is_alike(a, b)).count();
    }
    Check { difference: differ as f64, at_most: 0.0 }
}

/// Returns whether two pixels show the same facet and lights, and distance and colour to 12 digits.
fn is_alike(a: &SeenPoint, b: &SeenPoint) -> bool {
    let near = |a: f64, b: f64, most: f64| a == b || (a - b).abs() <= most;
    a.facet == b.facet
        && a.lit == b.lit
        && near(a.distance, b.distance, 1e-12 * a.distance.abs())
        && (0..3).all(|c| near(a.color[c], b.color[c], 1e-9))
}

/// The comparison: the pixels with a truth, and the pixels unlike another picture.
type Output = (Vec<SeenPoint>, usize);

fn rows(effort: &Effort) -> Vec<Row> {
    let of_truth = "facets, lights and 12 digits, by the specification";
    let of_threads = "every pixel is computed alone, by the same operations";
    let bounds = [(0, of_truth), (1, of_threads)];
    let bounds = bounds.map(|(column, because)| Bound { column, at_most: 0.0, because });
    let mut rows = Vec::new();
    for (subject, scene) in &subjects(effort) {
        let compared = spread(scene.pixel_count());
        let truth = see::<DoubleDouble>(scene, compared.iter().copied());
        let work = |threads| -> Work<EyePicture> {
            let pool = pool(threads);
            Box::new(move || draw(scene, &pool))
        };
        let drawn = effort.run_in_turns([1, 2, 3].map(work).into());
        for (i, (picture, timing)) in drawn.iter().enumerate() {
            let (threads, (other, _)) = (i + 1, &drawn[(i + 1) % drawn.len()]);
            let output = (shown(picture, &compared), pixels_unlike(picture, other));
            let judge = |(seen, unlike): &Output| {
                let off = seen.iter().zip(&truth).filter(|(a, b)| !is_alike(a, b)).count();
                vec![off as f64, *unlike as f64]
            };
            let mutate = |(seen, unlike): &mut Output, bound: &Bound| match bound.column {
                0 => seen[0].color[0] += 1e-8,
                _ => {
                    let mut wrong = picture.clone();
                    wrong.color[0][0] = f64::from_bits(wrong.color[0][0].to_bits() + 1);
                    *unlike = pixels_unlike(&wrong, other);
                }
            };
            let standing = standing_of(threads, true);
            let name = if threads == 1 { "1 thread".into() } else { format!("{threads} threads") };
            let row =
                Row::judged(effort, (subject, &name, standing), &output, bounds.to_vec(), judge, mutate);
            rows.push(row.timed(timing.clone(), picture.facet.len() as f64));
        }
    }
    rows
}

fn draw(scene: &EyeScene, pool: &Executor) -> EyePicture {
    render_with(scene, Fibre::Exact, pool).expect("no fan")
}

fn pool(threads: usize) -> Executor {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok();
    Executor::of_pool(pool.filter(|_| threads > 1).map(Arc::new))
}

/// Returns simplices of R^4 in a box in front of the eye, with vertices within `reach` of their
/// centres and one point light.
fn cloud(facets: usize, reach: f64, pixels: [u32; 2]) -> EyeScene {
    let mut r = Random::new(4004);
    let facets: Vec<_> = (0..facets)
        .map(|_| {
            let centre: Vec<f64> =
                (0..4).map(|a| if a == 0 { r.real(3.0, 7.0) } else { r.real(-2.0, 2.0) }).collect();
            let v: Vec<Vec<f64>> =
                (0..4).map(|_| centre.iter().map(|c| c + r.real(-reach, reach)).collect()).collect();
            json!({ "v": v, "color": [60 + r.below(190), 60 + r.below(190), 60 + r.below(190)] })
        })
        .collect();
    let text = json!({
        "dim": 4, "pixels": pixels, "d": 1, "S": [1.2, 0.9], "aperture_tan": [0.4], "I_d": 0.3,
        "lights": [{ "type": "radial", "position": [0, 3, 3, 0.5], "k": 20, "n": 1 }], "facets": facets,
    });
    EyeScene::from_json(text.to_string().as_bytes()).expect("a scene of this file's own making")
}

/// Measures the time per picture against the number of facets: in a full room with smaller and
/// smaller facets, and with facets of constant size.
pub(super) fn scaling_with_facets(effort: &Effort) -> Vec<Scaling> {
    let counts: &[usize] =
        effort.pick(&[100, 1_000, 10_000], &[100, 316, 1_000, 3_162, 10_000, 31_623, 100_000]);
    let pixels = effort.pick([96, 72], [640, 480]);
    let grow = |title: &str, reach: &dyn Fn(usize) -> f64| {
        let points = counts.iter().map(|&count| {
            let scene = cloud(count, reach(count), pixels);
            memory::forget_peak();
            let (_, timing) = effort.run(|| draw(&scene, &Executor::default()));
            ScalingPoint { x: count as f64, timing, peak_bytes: memory::peak() }
        });
        Scaling {
            title: format!(
                "{title}, 4-D on a plane of {}x{}, one light with shadows, one thread",
                pixels[0], pixels[1]
            ),
            grows: "facets",
            // The goal is stated for 100 to 100,000 facets.
            at_most: (!effort.is_quick).then_some(0.6),
            points: points.collect(),
        }
    };
    vec![
        grow("a room filled with ever smaller facets", &|n| 3.0 / libm::cbrt(n as f64)),
        grow("ever more facets of one size", &|_| 0.3),
    ]
}

//! Vector width and threads: identical bytes, different times.

use super::experiment::{Bound, Effort, Experiment, Row};
use super::picture::BenchFrame;
use crate::pipeline::{RenderOptions, RenderPath, Renderer};
use crate::scene::{Scene, shapes};
use crate::server::worker_pool;
use crate::simd::Level;
use crate::truth::scenes::{lit_triangle, object};
use glam::DVec3;

/// Experiment on vector widths and numbers of threads.
pub(super) const THREADS: Experiment = Experiment {
    id: "threads",
    title: "Vector width and threads",
    about: "A shaded knot drawn by the plain path, and by the fast one at every vector width and on one to three threads. The \
            error is held to the fast path on one thread with portable vectors: it has to be none. A width that this \
            machine lacks is not run.",
    columns: &["pixels unlike portable vectors on one thread", "largest difference, 1/255"],
    plotted: 1,
    unit: "pixel",
    rows,
};

/// Largest number of threads in the experiment.
const MOST_THREADS: usize = 3;

/// Returns a scene of a lit, Phong-shaded knot of 2 `nu` `nv` triangles.
pub(super) fn knot(nu: u32, nv: u32) -> Scene {
    let mut scene = lit_triangle();
    let mut knot = object("knot", shapes::knot(nu, nv).expect("a knot of more than 3 by 3"));
    knot.material.ks = DVec3::splat(0.4);
    knot.material.n = 20.0;
    let mesh = &knot.geometry.mesh;
    let radius = mesh.positions.iter().fold(0.0f64, |m, p| m.max(p.length()));
    knot.model = glam::DMat4::from_scale(DVec3::splat(1.8 / radius));
    scene.objects = vec![knot];
    scene
}

/// Returns the default number of threads of a program.
pub(super) fn usual_threads() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}

fn rows(effort: &Effort) -> Vec<Row> {
    let (width, height) = effort.pick((320, 240), (1280, 960));
    let scene = knot(effort.pick(120, 400), effort.pick(24, 60));
    let options = |path, simd, threads| RenderOptions {
        pool: worker_pool(Some(threads)),
        simd: Some(simd),
        path,
        ..RenderOptions::default()
    };
    let frame = |options| BenchFrame::new(Renderer::new(options), width, height);
    let mut base = frame(options(RenderPath::Fast, Level::Portable, 1));
    base.draw(&scene);
    let mut ways = vec![(
        "plain path, 1 thread".to_owned(),
        options(RenderPath::Plain, Level::Portable, 1),
        true,
        false,
    )];
    for level in Level::ALL {
        for threads in 1..=MOST_THREADS {
            let plural = if threads == 1 { "" } else { "s" };
            let name = format!("{} vectors, {threads} thread{plural}", level.as_str());
            let is_usual = level == Level::best() && threads == usual_threads().min(MOST_THREADS);
            ways.push((name, options(RenderPath::Fast, level, threads), level.is_available(), is_usual));
        }
    }
    ways.into_iter()
        .map(|(name, options, is_available, is_default)| {
            let subject = format!("a knot of {} triangles", scene.objects[0].geometry.mesh.triangles.len());
            if !is_available {
                return Row::not_run(subject, name, THREADS.columns.len());
            }
            let is_plain = options.path == RenderPath::Plain;
            let mut frame = frame(options);
            let ((), timing) = effort.run(|| frame.draw(&scene));
            let pairs = frame.memory.bytes().chunks_exact(4).zip(base.memory.bytes().chunks_exact(4));
            let off = pairs.clone().filter(|(a, b)| a != b).count();
            let worst = pairs.flat_map(|(a, b)| a.iter().zip(b)).fold(0, |m, (a, b)| m.max(a.abs_diff(*b)));
            // The plain path computes differently; both are within a step of the reference.
            let bounds = if is_plain {
                vec![Bound { column: 1, at_most: 2.0 }]
            } else {
                vec![Bound { column: 0, at_most: 0.0 }]
            };
            Row {
                subject,
                is_default,
                alternative: name,
                errors: vec![off as f64, f64::from(worst)],
                bounds,
                is_run: true,
                timing,
                work: f64::from(width) * f64::from(height),
                picture: None,
            }
        })
        .collect()
}

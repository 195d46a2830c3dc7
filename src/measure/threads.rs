//! Vector width and threads: the same bytes, different time.

use super::experiment::{Bound, Effort, Experiment, Row};
use crate::memory::{DepthFormat, VideoMemory};
use crate::pipeline::{RenderOptions, RenderPath, Renderer, SceneOptions, Target};
use crate::scene::{Scene, shapes};
use crate::server::worker_pool;
use crate::simd::Level;
use crate::truth::scenes::{lit_triangle, object};
use glam::DVec3;

/// The experiment.
pub(super) const THREADS: Experiment = Experiment {
    id: "threads",
    title: "Vector width and threads",
    about: "A shaded knot drawn by the plain path, and by the fast one at every vector width and on one to three threads. The \
            error is held to the fast path on one thread with portable vectors: it has to be none. A width that this \
            machine lacks shows no time.",
    columns: &["pixels unlike portable vectors on one thread", "largest difference, 1/255"],
    plotted: 1,
    unit: "pixel",
    rows,
};

/// A knot of 2 n^2 / 4 triangles, lit, Phong.
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

/// Draws a scene on a new frame; its bytes.
pub(super) fn draw(renderer: &mut Renderer, scene: &Scene, width: u32, height: u32) -> VideoMemory {
    let mut memory = VideoMemory::new(width, height).expect("a frame of at most 8K");
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
    let options = SceneOptions::new(width, height);
    renderer.draw_scene(&mut target, scene, &options).expect("a scene of this file's own making");
    memory
}

fn rows(effort: &Effort) -> Vec<Row> {
    let (width, height) = effort.pick((320, 240), (1280, 960));
    let scene = knot(effort.pick(120, 400), effort.pick(24, 60));
    let options =
        |path, simd, threads| RenderOptions { pool: worker_pool(Some(threads)), simd: Some(simd), path };
    let base = draw(&mut Renderer::new(options(RenderPath::Fast, Level::Portable, 1)), &scene, width, height);
    let mut ways =
        vec![("plain path, 1 thread".to_owned(), options(RenderPath::Plain, Level::Portable, 1), true)];
    for level in Level::ALL {
        for threads in 1..=3 {
            let plural = if threads == 1 { "" } else { "s" };
            let name = format!("{} vectors, {threads} thread{plural}", level.as_str());
            ways.push((name, options(RenderPath::Fast, level, threads), level.is_available()));
        }
    }
    ways.into_iter()
        .map(|(name, options, is_available)| {
            let is_plain = options.path == RenderPath::Plain;
            let mut renderer = Renderer::new(options);
            let (memory, timing) = effort.run(|| draw(&mut renderer, &scene, width, height));
            let pairs = memory.bytes().chunks_exact(4).zip(base.bytes().chunks_exact(4));
            let off = pairs.clone().filter(|(a, b)| a != b).count();
            let worst = pairs.flat_map(|(a, b)| a.iter().zip(b)).fold(0, |m, (a, b)| m.max(a.abs_diff(*b)));
            // The plain path is another way of working; both are within a step of the truth.
            let bounds = if is_plain {
                vec![Bound { column: 1, at_most: 2.0 }]
            } else {
                vec![Bound { column: 0, at_most: 0.0 }]
            };
            Row {
                subject: format!("a knot of {} triangles", scene.objects[0].geometry.mesh.triangles.len()),
                is_default: name == "avx2 vectors, 2 threads",
                alternative: name,
                errors: vec![off as f64, f64::from(worst)],
                bounds,
                timing: timing.filter(|_| is_available),
                work: f64::from(width) * f64::from(height),
                picture: None,
            }
        })
        .collect()
}

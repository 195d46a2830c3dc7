//! Growth of the 3-D pipeline's and the server's cost: triangles, pixels, lights, overdraw,
//! clients.

use super::experiment::Effort;
use super::memory;
use super::picture::BenchFrame;
use super::scaling::{Scaling, ScalingPoint};
use super::threads::knot;
use fbptr_core::pipeline::{RenderOptions, Renderer};
use fbptr_core::scene::{Light, Mesh, Scene, ShadeMode};
use fbptr_server::{Engine, Finish, RenderThread, worker_pool};
use fbptr_truth::scenes::{lit_triangle, object};
use glam::DVec3;

/// Returns the default renderer of programs on this machine.
fn renderer() -> Renderer {
    Renderer::new(RenderOptions { pool: worker_pool(None), ..RenderOptions::default() })
}

const VGA: [u32; 2] = [640, 480];

/// Returns the numbers of lights, layers or clients to measure.
fn to_64(effort: &Effort) -> &'static [u32] {
    effort.pick(&[1, 8, 64], &[1, 2, 4, 8, 16, 32, 64])
}

/// Times a scene for each size; creating the scene is not timed.
fn series(
    effort: &Effort,
    title: String,
    grows: &'static str,
    sizes: &[(f64, [u32; 2])],
    scene: impl Fn(f64) -> Scene,
) -> Scaling {
    let points = sizes.iter().map(|&(x, [width, height])| {
        let scene = scene(x);
        let mut frame = BenchFrame::new(renderer(), width, height);
        memory::forget_peak();
        let ((), timing) = effort.run(|| frame.draw(&scene));
        ScalingPoint { x, timing, peak_bytes: memory::peak() }
    });
    Scaling { title, grows, at_most: None, points: points.collect() }
}

/// Measures knots of more and more triangles on one frame size.
pub(super) fn triangles(effort: &Effort) -> Vec<Scaling> {
    // nu x nv quads of 2 triangles.
    let knots: &[[u32; 2]] = effort.pick(
        &[[10, 5], [50, 10], [250, 20], [500, 100]],
        &[[10, 5], [50, 10], [250, 20], [500, 100], [2500, 200], [8000, 250]],
    );
    let sizes: Vec<(f64, [u32; 2])> = knots.iter().map(|[nu, nv]| (f64::from(2 * nu * nv), VGA)).collect();
    let scene = |x: f64| {
        let [nu, nv] = knots.iter().find(|[nu, nv]| f64::from(2 * nu * nv) == x).copied().unwrap_or([10, 5]);
        knot(nu, nv)
    };
    vec![series(effort, "a Phong-shaded knot on 640x480".into(), "triangles", &sizes, scene)]
}

/// Measures one knot on larger and larger frames.
pub(super) fn pixels(effort: &Effort) -> Vec<Scaling> {
    let frames: &[[u32; 2]] = effort.pick(
        &[[640, 480], [1280, 720], [1920, 1080]],
        &[[640, 480], [1280, 720], [1920, 1080], [3840, 2160], [7680, 4320]],
    );
    let sizes: Vec<(f64, [u32; 2])> =
        frames.iter().map(|f| (f64::from(f[0]) * f64::from(f[1]), *f)).collect();
    let title = "a Phong-shaded knot of 10,000 triangles, VGA to 8K".to_owned();
    vec![series(effort, title, "pixels", &sizes, |_| knot(250, 20))]
}

/// Measures a knot under more and more lights.
pub(super) fn lights(effort: &Effort) -> Vec<Scaling> {
    let sizes: Vec<(f64, [u32; 2])> = to_64(effort).iter().map(|&n| (f64::from(n), VGA)).collect();
    let scene = |x: f64| {
        let mut scene = knot(250, 20);
        scene.lights = (0..x as u32)
            .map(|i| {
                let (sin, cos) = libm::sincos(f64::from(i));
                Light::directional(DVec3::new(cos, sin, -1.0), DVec3::splat(1.0 / x))
            })
            .collect();
        scene
    };
    let title = "a Phong-shaded knot of 10,000 triangles on 640x480".to_owned();
    vec![series(effort, title, "lights", &sizes, scene)]
}

/// Measures more and more overlapping walls, the farthest first.
pub(super) fn overdraw(effort: &Effort) -> Vec<Scaling> {
    let sizes: Vec<(f64, [u32; 2])> = to_64(effort).iter().map(|&n| (f64::from(n), VGA)).collect();
    let scene = |x: f64| {
        let mut scene = lit_triangle();
        let wall = |i: u32| {
            let z = -2.0 + 4.0 * f64::from(i) / x;
            let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
            let positions = corners.map(|[x, y]| DVec3::new(x, y, z)).to_vec();
            let mut wall = object("wall", Mesh::from_triangles(positions, &[[0, 1, 2], [0, 2, 3]]));
            wall.shade = Some(ShadeMode::Gouraud);
            wall
        };
        scene.objects = (0..x as u32).map(wall).collect();
        scene
    };
    let title = "Gouraud-shaded walls over the whole of 640x480, far to near".to_owned();
    vec![series(effort, title, "layers", &sizes, scene)]
}

/// Measures the same work sent by more and more clients inside the process.
pub(super) fn clients(effort: &Effort) -> Vec<Scaling> {
    const RECTS: u32 = 6400;
    let points = to_64(effort).iter().filter_map(|&count| {
        let engine = Engine::new(640, 480).ok()?;
        let thread = RenderThread::start(engine).ok()?;
        let clients: Vec<_> = (0..count).map(|_| thread.client()).collect();
        memory::forget_peak();
        let work = || {
            std::thread::scope(|scope| {
                for (i, client) in clients.iter().enumerate() {
                    scope.spawn(move || {
                        for k in 0..RECTS / count {
                            let (x, y) = ((k * 7 % 600) as i32, (i as i32 * 31 + k as i32) % 440);
                            client.fill_rect([x, y, 40, 40], [k as u8, i as u8, 90, 255]);
                        }
                        // If the client's connection is closed, there is no work to wait for.
                        let _ = client.sync();
                    });
                }
            });
        };
        let (_, timing) = effort.run(work);
        drop(clients);
        thread.finish(Finish::Now);
        Some(ScalingPoint { x: f64::from(count), timing, peak_bytes: memory::peak() })
    });
    vec![Scaling {
        title: format!("{RECTS} rectangles of 40x40 in all, shared among clients of one server"),
        grows: "clients",
        at_most: None,
        points: points.collect(),
    }]
}

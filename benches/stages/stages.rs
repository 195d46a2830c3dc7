//! Benchmarks of the stages of a 3-D draw, by pictures in which one of them does nearly all the
//! work. Quick: `cargo bench -p fbptr-stages --bench stages`.
//!
//! Each is a complete draw by the renderer, on one thread and on all cores, after a clear of colour
//! and depth; the cost of the stage itself is the difference to the picture above it. `fbptr bench`
//! compares the pictures with the truth; here the counts of the draw are asserted, so that no stage
//! is timed without work.

use criterion::{
    BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use fbptr::math::matrix;
use fbptr::memory::{DepthFormat, VideoMemory};
use fbptr::pipeline::{DrawCall, DrawStats, RenderOptions, Renderer, Target};
use fbptr::scene::{
    Camera, Cull, Filter, Geometry, Light, LookAt, Material, Projection, Sampling, ShadeMode, Texture, Wrap,
    shapes,
};
use fbptr::server::worker_pool;
use fbptr::simd::{Level, scan_out};
use glam::{DMat4, DVec3};
use std::hint::black_box;
use std::time::Duration;

const W: u32 = 1920;
const H: u32 = 1080;

struct Stage {
    name: &'static str,
    geometry: Geometry,
    size: [u32; 2],
    shade: ShadeMode,
    cull: Cull,
    texture: Option<Filter>,
    is_lit: bool,
    model: DMat4,
    /// Returns whether the counts show that the stage has worked.
    has_worked: fn(&DrawStats) -> bool,
}

fn knot(nu: u32, nv: u32) -> Geometry {
    Geometry { mesh: shapes::knot(nu, nv).expect("a knot"), textures: Vec::new() }
}

fn stages() -> Vec<Stage> {
    let turned =
        matrix::rotate(DVec3::X, 0.3).expect("an axis") * matrix::rotate(DVec3::Y, 0.4).expect("an axis");
    let base = || Stage {
        name: "",
        geometry: knot(500, 70),
        size: [W, H],
        shade: ShadeMode::Flat,
        cull: Cull::Back,
        texture: None,
        is_lit: false,
        model: turned,
        has_worked: |s| s.faces_drawn > 10_000 && s.pixels_written > 200_000,
    };
    vec![
        Stage {
            name: "vertex: 250,000 faces beside the view",
            geometry: knot(1000, 125),
            model: matrix::translate(DVec3::new(50.0, 0.0, 0.0)) * turned,
            has_worked: |s| s.faces == 250_000 && s.pixels_written == 0,
            ..base()
        },
        Stage {
            name: "setup: 250,000 faces in 48x27 pixels",
            geometry: knot(1000, 125),
            size: [48, 27],
            has_worked: |s| s.faces == 250_000 && s.pixels_written > 100,
            ..base()
        },
        Stage { name: "raster: 70,000 faces of one colour", ..base() },
        Stage {
            name: "raster, fill: one face over the frame",
            geometry: Geometry {
                mesh: shapes::cuboid(DVec3::splat(20.0)).expect("a box"),
                textures: Vec::new(),
            },
            cull: Cull::None,
            model: matrix::translate(DVec3::new(0.0, 0.0, -13.0)),
            has_worked: |s| s.pixels_written >= u64::from(W * H),
            ..base()
        },
        Stage { name: "resolve, gouraud", shade: ShadeMode::Gouraud, is_lit: true, ..base() },
        Stage { name: "resolve, phong", shade: ShadeMode::Phong, is_lit: true, ..base() },
        Stage { name: "resolve, nearest", texture: Some(Filter::Nearest), ..base() },
        Stage { name: "resolve, bilinear", texture: Some(Filter::Bilinear), ..base() },
        Stage { name: "resolve, trilinear", texture: Some(Filter::Trilinear), ..base() },
    ]
}

fn draw(group: &mut BenchmarkGroup<WallTime>, stage: &Stage, threads: Option<usize>) {
    let [width, height] = stage.size;
    let material = match stage.is_lit {
        true => Material { ks: DVec3::splat(0.5), n: 32.0, ..Material::default() },
        false => Material { ka: DVec3::ONE, kd: DVec3::ZERO, ..Material::default() },
    };
    let lights = [Light::point(DVec3::new(3.0, 4.0, 5.0), DVec3::ONE)];
    let texels = (0..256u32 * 256).flat_map(|i| [i as u8, (i >> 8) as u8, 99, 255]).collect();
    let texture = Texture::new(256, 256, texels).expect("a texture");
    let camera = Camera {
        look_at: LookAt { eye: DVec3::new(0.0, 0.0, 5.2), reference: DVec3::ZERO, up: DVec3::Y },
        projection: Projection::Perspective {
            fov_rad: 60f64.to_radians(),
            near: 1.0,
            far: 100.0,
            on_smaller_side: false,
        },
    };
    let call = DrawCall {
        model: stage.model,
        camera,
        ambient: DVec3::splat(0.3),
        lights: if stage.is_lit { &lights } else { &[] },
        texture: stage.texture.map(|_| &texture),
        sampling: Sampling {
            filter: stage.texture.unwrap_or_default(),
            wrap_s: Wrap::Repeat,
            wrap_t: Wrap::Repeat,
        },
        shade: stage.shade,
        cull: stage.cull,
        ..DrawCall::new(&stage.geometry, &material, width, height)
    };
    let pool = worker_pool(threads);
    let name = format!("{} threads", pool.as_ref().map_or(1, |p| p.current_num_threads()));
    let mut renderer = Renderer::new(RenderOptions { pool, ..RenderOptions::default() });
    let mut memory = VideoMemory::new(width, height).expect("a frame");
    let mut depth = None;
    let mut frame = || {
        memory.clear(VideoMemory::CLEAR);
        let mut target =
            Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
        if let Some(depth) = target.depth {
            depth.clear();
        }
        renderer.draw(&mut target, &call).expect("a sound scene")
    };
    let stats = frame();
    assert!((stage.has_worked)(&stats), "{}: {stats:?}", stage.name);
    group.bench_function(name, |b| b.iter(|| black_box(frame())));
}

fn all(c: &mut Criterion) {
    for stage in stages() {
        let mut group = c.benchmark_group(stage.name);
        group.throughput(Throughput::Elements(stage.geometry.mesh.triangles.len() as u64));
        draw(&mut group, &stage, Some(1));
        draw(&mut group, &stage, None);
        group.finish();
    }
}

fn scan(c: &mut Criterion) {
    let rgba: Vec<u8> = (0..W * H).flat_map(|i| i.wrapping_mul(2_654_435_761).to_le_bytes()).collect();
    let (mut words, mut copy) = (vec![0u32; (W * H) as usize], vec![0u8; rgba.len()]);
    let mut group = c.benchmark_group("scan-out of a frame");
    group.throughput(Throughput::Bytes(rgba.len() as u64));
    group.bench_function("memcpy", |b| b.iter(|| black_box(&mut copy).copy_from_slice(&rgba)));
    for level in Level::ALL.into_iter().filter(|l| l.is_available()) {
        group.bench_function(level.as_str(), |b| b.iter(|| scan_out(level, &rgba, black_box(&mut words))));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800));
    targets = all, scan
}
criterion_main!(benches);

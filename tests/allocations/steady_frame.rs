//! Verifies that a frame like the last one allocates nothing.
//!
//! Guards against draws that allocate in every frame, and stutter when the system is slow to
//! answer.

use crate::TURN;
use crate::counting::{counted_pool, steady_calls};
use fbptr::draw2d::{Area, AreaColors, Blend};
use fbptr::executor::Executor;
use fbptr::memory::{DepthFormat, DepthMemory, VideoMemory};
use fbptr::pipeline::{DrawCall, DrawStats, RenderOptions, Renderer, SceneOptions, Target};
use fbptr::scene::{
    Cull, Filter, Fog, FogKind, Geometry, HiddenSurface, Light, Material, Mesh, Object, Sampling, Scene,
    ShadeMode, Texture, TransparencyOrder, Wrap, shapes,
};
use fbptr::truth::scenes::object;
use glam::{DMat4, DVec2, DVec3};
use std::hint::black_box;
use std::sync::{Arc, Barrier};

/// Number of counted frames.
const FRAMES: usize = 4 * INJECTOR_BLOCK;

/// Jobs in a block of the queue through which rayon's pool receives each frame. These blocks are
/// rayon's, and the only memory that is allocated again.
const INJECTOR_BLOCK: usize = 63;

/// A frame with its depth, and the renderer that draws into it.
struct Stage {
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    depth_format: DepthFormat,
    renderer: Renderer,
}

impl Stage {
    fn new(options: RenderOptions, depth_format: DepthFormat) -> Self {
        let memory = VideoMemory::new(320, 200).unwrap();
        Stage { memory, depth: None, depth_format, renderer: Renderer::new(options) }
    }

    /// Clears the frame and draws into it.
    fn frame(&mut self, draw: impl FnOnce(&mut Renderer, &mut Target) -> DrawStats) {
        self.memory.clear(VideoMemory::CLEAR);
        if let Some(depth) = &mut self.depth {
            depth.clear();
        }
        let mut target = Target {
            memory: &mut self.memory,
            depth: &mut self.depth,
            depth_format: self.depth_format,
            ids: None,
        };
        let stats = draw(&mut self.renderer, &mut target);
        assert!(stats.pixels_written > 5000, "{stats:?}");
    }
}

fn two_threads() -> RenderOptions {
    let pool = counted_pool(2);
    // Each thread takes work from the other once: what it asks for at its first time would come late on
    // a busy machine, in counted frames.
    let (begun, taken) = (Barrier::new(2), Barrier::new(2));
    let wait = |barrier: &Barrier| {
        barrier.wait();
    };
    let second = || {
        wait(&begun);
        rayon::join(|| wait(&taken), || wait(&taken));
    };
    pool.install(|| rayon::join(|| wait(&begun), second));
    RenderOptions { pool: Some(Arc::new(pool)), ..RenderOptions::default() }
}

fn lights(count: usize) -> Vec<Light> {
    let lamp = |i: usize| {
        let at = i as f64 * 0.7;
        Light::point(DVec3::new(3.0 - at, 4.0, 5.0 - 0.3 * at), DVec3::splat(1.0 / count as f64))
    };
    let mut lights: Vec<Light> = (1..count).map(lamp).collect();
    lights.push(Light::directional(DVec3::new(-1.0, -1.0, -2.0), DVec3::splat(0.6)));
    lights
}

/// Returns the allocator calls in `FRAMES` frames of one draw each, after some frames that may
/// allocate.
fn calls_of_steady_frames(options: RenderOptions, shade: ShadeMode) -> usize {
    let geometry = Arc::new(Geometry { mesh: shapes::knot(200, 40).unwrap(), textures: Vec::new() });
    let material = Material { ks: DVec3::splat(0.4), n: 20.0, ..Material::default() };
    let lights = lights(1);
    let mut stage = Stage::new(options, DepthFormat::F32);
    let call = DrawCall {
        shared: Some(&geometry),
        lights: &lights,
        shade,
        ..DrawCall::new(&geometry, &material, stage.memory.width(), stage.memory.height())
    };
    steady_calls(8, FRAMES, || stage.frame(|renderer, target| renderer.draw(target, &call).unwrap()))
}

#[test]
fn a_steady_frame_asks_for_no_memory() {
    let _turn = TURN.lock();
    for shade in [ShadeMode::Phong, ShadeMode::Gouraud, ShadeMode::Flat] {
        assert_eq!(calls_of_steady_frames(RenderOptions::default(), shade), 0, "{shade:?} on one thread");
        let calls = calls_of_steady_frames(two_threads(), shade);
        let most = FRAMES / INJECTOR_BLOCK + 1;
        assert!(calls <= most, "{shade:?}: {calls} calls in {FRAMES} frames of two threads, {most} allowed");
    }
}

#[test]
fn a_figure_in_bands_asks_for_no_memory() {
    let _turn = TURN.lock();
    let executor = Executor::of_pool(two_threads().pool);
    let mut memory = VideoMemory::new(320, 200).unwrap();
    let corners = [[-30.0, 5.0], [350.0, -20.0], [90.0, 260.0]];
    let areas = [
        Area::Disc([150.0, 99.5], 97.0, [90, 80, 70, 60]),
        Area::WideLine([[9.0, 9.0], [300.0, 190.0]], 30.0, [90, 80, 70, 60]),
        Area::Triangle(corners, AreaColors::Three([[255, 0, 0, 90], [0, 255, 0, 80], [0, 0, 255, 70]])),
        Area::SmoothLine([[3.0, 5.0], [310.0, 190.0]], [90, 80, 70, 60]),
    ];
    for area in areas {
        let (before, mut draws) = (8, 0);
        let calls = steady_calls(before, FRAMES, || {
            // Those before must ask for some.
            let asked = if draws < before { 30 } else { 0 };
            (0..asked).for_each(|i| drop(black_box(vec![i; 100])));
            draws += 1;
            area.draw_in_bands(&executor, &mut memory, 8, Blend::Over).unwrap();
        });
        let most = FRAMES / INJECTOR_BLOCK + 1;
        assert!(calls <= most, "{area:?}: {calls} calls in {FRAMES} draws, {most} allowed");
    }
}

#[test]
fn calls_of_other_threads_are_not_counted() {
    let _turn = TURN.lock();
    let (before, gate) = (2, Barrier::new(2));
    std::thread::scope(|scope| {
        // As the thread of the test harness does when a test takes long.
        scope.spawn(|| {
            for _ in 0..before + FRAMES {
                gate.wait();
                drop(black_box(String::from("a test has been running for long")));
                gate.wait();
            }
        });
        let mut frames = 0;
        let calls = steady_calls(before, FRAMES, || {
            let asked = if frames < before { 30 } else { 0 };
            (0..asked).for_each(|i| drop(black_box(vec![i; 100])));
            frames += 1;
            gate.wait();
            gate.wait();
        });
        // This thread may allocate once to wait at the barrier; the other one does in every frame.
        assert!(
            calls <= FRAMES / 100,
            "{calls} in {FRAMES} frames, in each of which another thread asks once"
        );
    });
}

/// A scene that is anything but opaque faces with f32 depth under a few lights.
struct Case {
    name: &'static str,
    scene: Scene,
    shade: ShadeMode,
    hide: HiddenSurface,
    depth_format: DepthFormat,
    is_sorted: bool,
}

fn square() -> Mesh {
    let corners = [[-2.0, -1.5], [2.0, -1.5], [2.0, 1.5], [-2.0, 1.5]];
    let positions = corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
    let mut mesh = Mesh::from_triangles(positions, &[[0, 1, 2], [0, 2, 3]]);
    mesh.texcoords = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(DVec2::from_array).to_vec();
    mesh.corners.iter_mut().for_each(|c| c.texcoord = c.position);
    mesh
}

/// Returns `count` layers before each other, each rotated a little; the last one passes through the
/// eye plane.
fn layers(count: u32) -> Vec<Object> {
    let layer = |i: u32| {
        let mut layer = object("layer", square());
        let turn = DMat4::from_rotation_y(0.2 + 0.1 * (i % 5) as f64);
        let size = if i + 1 == count { DVec3::splat(20.0) } else { DVec3::ONE };
        let at = DVec3::new(0.0, 0.0, -2.0 + 3.0 * i as f64 / count as f64);
        layer.model = DMat4::from_translation(at) * turn * DMat4::from_scale(size);
        layer.material = Material { kd: DVec3::new(0.7, 0.5, 0.2), ..Material::default() };
        layer.material.transparency = 0.7;
        layer.cull = Cull::None;
        layer
    };
    (0..count).map(layer).collect()
}

fn cases() -> Vec<Case> {
    let case = |name, objects: Vec<Object>, lamps| Case {
        name,
        scene: Scene { ambient: DVec3::splat(0.4), lights: lights(lamps), objects, ..Scene::default() },
        shade: ShadeMode::Phong,
        hide: HiddenSurface::ZBuffer,
        depth_format: DepthFormat::F32,
        is_sorted: false,
    };
    let knot = |transparency| {
        let mut thing = object("knot", shapes::knot(60, 12).unwrap());
        thing.material = Material { ks: DVec3::splat(0.4), n: 20.0, transparency, ..Material::default() };
        thing
    };
    let textured = |alpha: u8| {
        let texels = (0..64u8).flat_map(|i| [i * 3, 200, 90, if i % 2 == 0 { alpha } else { 255 }]).collect();
        let texture = Arc::new(Texture::new(8, 8, texels).unwrap());
        let sampling = Sampling { filter: Filter::Trilinear, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat };
        let mut objects = layers(6);
        objects.iter_mut().for_each(|o| o.texture = Some((Arc::clone(&texture), sampling)));
        objects
    };
    let opaque = |mut objects: Vec<Object>| {
        objects.iter_mut().for_each(|o| o.material.transparency = 0.0);
        objects
    };
    let fog = Fog { color: DVec3::splat(0.5), kind: FogKind::Exponential, visibility_range: 20.0 };
    let fogged = |mut case: Case| {
        case.scene.fog = Some(fog);
        case
    };
    let sharp = |mut objects: Vec<Object>| {
        objects.iter_mut().for_each(|o| (o.material.ks, o.material.n) = (DVec3::ONE, 5000.0));
        objects
    };
    let mut cases = vec![
        case("64 layers", layers(64), 1),
        case("layers under 16 lights", layers(8), 16),
        Case { shade: ShadeMode::Gouraud, ..case("layers lit at corners", layers(8), 4) },
        Case { shade: ShadeMode::Flat, ..case("layers lit as wholes", layers(8), 4) },
        Case { is_sorted: true, ..case("layers sorted", layers(16), 1) },
        Case { hide: HiddenSurface::Painter, ..case("a painter's knot", vec![knot(0.0)], 2) },
        Case { hide: HiddenSurface::Painter, ..case("a painter's layers", layers(8), 2) },
        Case { hide: HiddenSurface::None, ..case("nothing hidden", vec![knot(0.0), knot(0.5)], 2) },
        case("a knot before a clear one", vec![knot(0.0), knot(0.5)], 64),
        case("blended textures", textured(100), 1),
        fogged(case("blended textures in fog", textured(100), 1)),
        fogged(case("layers in fog", layers(8), 3)),
        fogged(case("an opaque knot in fog", vec![knot(0.0)], 3)),
        case("opaque textures", opaque(textured(255)), 1),
        case("exponents that f32 lacks", sharp(vec![knot(0.0), knot(0.3)]), 2),
    ];
    for depth_format in [DepthFormat::U16, DepthFormat::U24, DepthFormat::U32, DepthFormat::Reversed] {
        let opaque = case("a knot in other depths", vec![knot(0.0)], 2);
        cases.push(Case { depth_format, ..opaque });
        let mixed = case("layers before a knot in other depths", layers(8), 2);
        cases.push(Case { depth_format, ..mixed });
    }
    cases
}

/// Number of counted frames of a scene, and the most jobs that each sends to the pool.
const SCENE_FRAMES: usize = 8;
const HANDED: usize = 8;

#[test]
fn steady_frames_of_every_kind_ask_for_no_memory() {
    let _turn = TURN.lock();
    for options in [RenderOptions::default(), two_threads()] {
        for case in cases() {
            let Case { name, depth_format, .. } = case;
            let mut stage = Stage::new(options.clone(), depth_format);
            let scene_options = SceneOptions {
                shade: case.shade,
                hide: case.hide,
                transparency: match case.is_sorted {
                    true => TransparencyOrder::Sorted,
                    false => TransparencyOrder::FileOrder,
                },
                ..SceneOptions::new(stage.memory.width(), stage.memory.height())
            };
            let calls = steady_calls(3, SCENE_FRAMES, || {
                let draw = |renderer: &mut Renderer, target: &mut Target| {
                    renderer.draw_scene(target, &case.scene, &scene_options).unwrap()
                };
                stage.frame(draw);
            });
            let handed = case.scene.objects.len() + HANDED;
            let (threads, most) = match options.pool {
                None => (1, 0),
                Some(_) => (2, SCENE_FRAMES * handed / INJECTOR_BLOCK + 1),
            };
            assert!(
                calls <= most,
                "{name}, {depth_format:?}: {calls} calls on {threads} threads, {most} allowed"
            );
        }
    }
}

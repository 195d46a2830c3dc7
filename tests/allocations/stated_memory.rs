//! The plan's stated bytes against those that a renderer allocates, and scenes that are redrawn
//! without an allocation.
//!
//! Guards against a plan whose numbers were never compared with the memory that is taken.

use crate::TURN;
use crate::counting::{HELD, counted_pool, steady_calls};
use fbptr::memory::{DepthFormat, DepthMemory, VideoMemory};
use fbptr::pipeline::{DrawCall, Part, Plan, RenderOptions, Renderer, SceneOptions, Target};
use fbptr::scene::{
    Filter, Geometry, HiddenSurface, Light, Material, Mesh, Sampling, Scene, ShadeMode, Texture, shapes,
};
use fbptr::truth::scenes::object;
use glam::{DMat4, DVec3};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

fn knot(around: u32, across: u32) -> Mesh {
    shapes::knot(around, across).unwrap()
}

#[test]
fn a_draw_holds_what_its_plan_states() {
    let _turn = TURN.lock();
    let texture = Texture::new(64, 64, [200, 100, 50, 255].repeat(64 * 64)).unwrap();
    let square = Mesh::from_triangles(
        [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec(),
        &[[0, 1, 2], [0, 2, 3]],
    );
    let cases = [
        ("a knot lit per pixel", knot(400, 50), ShadeMode::Phong, DepthFormat::F32, false),
        ("the same lit at vertices", knot(400, 50), ShadeMode::Gouraud, DepthFormat::F32, false),
        ("the same lit at faces", knot(400, 50), ShadeMode::Flat, DepthFormat::F32, false),
        ("the same with whole depths", knot(400, 50), ShadeMode::Phong, DepthFormat::U24, false),
        ("the same in 16 bits with a texture", knot(400, 50), ShadeMode::Phong, DepthFormat::U16, true),
        ("a fine knot", knot(1600, 100), ShadeMode::Phong, DepthFormat::F32, false),
        ("a sphere", shapes::sphere(1.0).unwrap(), ShadeMode::Phong, DepthFormat::Reversed, true),
        ("a square", square.clone(), ShadeMode::Phong, DepthFormat::F32, false),
    ];
    let as_is = (0.0, HiddenSurface::ZBuffer);
    let blended = (0.5, HiddenSurface::ZBuffer);
    let in_order = [
        (
            "a painter's knot",
            knot(200, 50),
            ShadeMode::Phong,
            DepthFormat::F32,
            false,
            (0.0, HiddenSurface::Painter),
        ),
        ("a clear knot", knot(400, 50), ShadeMode::Gouraud, DepthFormat::F32, false, blended),
        ("a small clear knot", knot(60, 12), ShadeMode::Phong, DepthFormat::U24, true, blended),
        ("a clear square", square, ShadeMode::Phong, DepthFormat::U16, true, blended),
    ];
    let cases = cases.map(|(name, mesh, shade, depth, textured)| (name, mesh, shade, depth, textured, as_is));
    for (name, mesh, shade, depth_format, is_textured, (transparency, hide)) in
        cases.into_iter().chain(in_order)
    {
        let (width, height) = (800, 600);
        let geometry = Arc::new(Geometry { mesh, textures: Vec::new() });
        let material = Material { ks: DVec3::splat(0.4), n: 20.0, transparency, ..Material::default() };
        let lights = [Light::directional(DVec3::new(-1.0, -1.0, -2.0), DVec3::ONE)];
        let call = DrawCall {
            shared: Some(&geometry),
            lights: &lights,
            shade,
            hide,
            texture: is_textured.then_some(&texture),
            sampling: Sampling { filter: Filter::Bilinear, ..Sampling::default() },
            ..DrawCall::new(&geometry, &material, width, height)
        };
        let mut memory = VideoMemory::new(width, height).unwrap();
        let mut depth = None;
        let mut renderer = Renderer::new(RenderOptions::default());
        let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
        let plan = Plan::of_draw(&call, &target);
        let is_in_order = (transparency, hide) != as_is;
        assert!(
            plan.uses(if is_in_order { Part::FacesInOrder } else { Part::TileRenderer }),
            "{name}: {plan}"
        );
        let before = HELD.load(Relaxed);
        let stats = renderer.draw(&mut target, &call).unwrap();
        let held = (HELD.load(Relaxed) - before) as f64;
        assert!(stats.pixels_written > 5000, "{name}: {stats:?}");
        // Frame and texture belong to the caller.
        let callers = plan.item(Part::VideoMemory).bytes + plan.item(Part::Textures).bytes;
        let stated = (plan.bytes() - callers) as f64;
        println!("{name}: {stated} bytes stated, {held} held, {:.2}", held / stated);
        assert!(held < 1.35 * stated && stated < 1.35 * held, "{name}: {stated} stated, {held} held\n{plan}");
        let depth_bytes = depth.as_ref().map_or(0, DepthMemory::size_bytes) as f64;
        let own = renderer.size_bytes() as f64 + depth_bytes;
        assert!(held < 1.2 * own && own < 1.2 * held, "{name}: {own} told by the renderer, {held} held");
    }
}

/// Returns the allocator calls in `frames` frames of a scene of small boxes, no two neighbours
/// alike, after some frames that may allocate.
fn calls_of_boxes(options: RenderOptions, count: u32, frames: usize) -> usize {
    let (width, height) = (320, 200);
    let mesh = shapes::cuboid(DVec3::ONE).unwrap();
    let shared = Arc::new(Geometry { mesh, textures: Vec::new() });
    let skin = Arc::new(Texture::new(8, 8, [90, 200, 50, 255].repeat(64)).unwrap());
    let thing = |i: u32| {
        let mut thing = object("box", Mesh::default());
        thing.geometry =
            if i.is_multiple_of(2) { Arc::clone(&shared) } else { Arc::new(Geometry::clone(&shared)) };
        let at = DVec3::new((i % 20) as f64 * 0.2 - 2.0, (i / 20) as f64 * 0.15 - 1.4, (i % 7) as f64 * 0.1);
        thing.model = DMat4::from_translation(at) * DMat4::from_scale(DVec3::splat(0.08));
        thing.shade = Some([ShadeMode::Phong, ShadeMode::Gouraud, ShadeMode::Flat][i as usize % 3]);
        thing.texture = i.is_multiple_of(5).then(|| (Arc::clone(&skin), Sampling::default()));
        thing.lights = i.is_multiple_of(7).then(|| vec![i % 2]);
        thing
    };
    let scene = Scene {
        ambient: DVec3::splat(0.4),
        lights: vec![
            Light::point(DVec3::new(3.0, 4.0, 9.0), DVec3::splat(0.7)),
            Light::directional(DVec3::new(-1.0, -0.5, -0.7), DVec3::splat(0.4)),
        ],
        objects: (0..count).map(thing).collect(),
        ..Scene::default()
    };
    let scene_options = SceneOptions::new(width, height);
    let mut memory = VideoMemory::new(width, height).unwrap();
    let mut depth = None;
    let mut renderer = Renderer::new(options);
    let frame = || {
        memory.clear(VideoMemory::CLEAR);
        if let Some(depth) = &mut depth {
            DepthMemory::clear(depth);
        }
        let mut target =
            Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
        let stats = renderer.draw_scene(&mut target, &scene, &scene_options).unwrap();
        assert!(stats.pixels_written > 2000, "{stats:?}");
    };
    steady_calls(4, frames, frame)
}

#[test]
fn a_steady_scene_asks_for_no_memory() {
    let _turn = TURN.lock();
    assert_eq!(calls_of_boxes(RenderOptions::default(), 400, 50), 0, "on one thread");
    let pool = counted_pool(2);
    let options = RenderOptions { pool: Some(Arc::new(pool)), ..RenderOptions::default() };
    // Rayon's injector queue allocates a block for every 63 jobs from threads outside the pool, and a
    // thread's lists grow where it gets more of the work than in any frame before. One call a frame
    // would be 50.
    let calls = calls_of_boxes(options, 400, 50);
    assert!(calls <= 8, "{calls} calls in 50 frames of two threads");
}

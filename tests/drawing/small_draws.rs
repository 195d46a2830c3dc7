//! Small objects drawn in batches over threads, against the same objects drawn one after the other
//! by one thread.
//!
//! Guards against a batch drawn in another order, or with a neighbour's state.

use crate::fast_path::{CLEARED_FACE, cleared_pick_buffer};
use fbptr::memory::{DepthFormat, VideoMemory};
use fbptr::pipeline::{DrawCall, DrawStats, RenderOptions, Renderer, SceneOptions, Target};
use fbptr::scene::{Fog, FogKind, HiddenSurface, Material, Mesh, Object, Scene, ShadeMode, shapes};
use fbptr::truth::scenes::{object, random};
use glam::{DMat4, DVec3};
use std::sync::Arc;

/// Bytes, depths, face at each pixel, and counts.
type Picture = (Vec<u8>, Option<Vec<u32>>, Vec<Option<(u32, u32)>>, DrawStats);

fn draw(renderer: &mut Renderer, scene: &Scene, hide: HiddenSurface, depth_format: DepthFormat) -> Picture {
    let (width, height) = (333, 190);
    let mut memory = VideoMemory::new(width, height).unwrap();
    let (mut depth, mut ids) = (None, cleared_pick_buffer(width, height));
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: Some(&mut ids) };
    let mut options = SceneOptions { hide, ..SceneOptions::new(width, height) };
    // A viewport that neither begins at the frame's corner nor lies inside of it.
    (options.viewport.x, options.viewport.y) = (9, -7);
    let stats = renderer.draw_scene(&mut target, scene, &options).unwrap();
    let depth = depth.map(|d| (0..(width * height) as usize).map(|i| d.word(i)).collect());
    let at = |i: u32| ids.get((i % width) as i32, (i / width) as i32);
    let ids: Vec<_> = (0..width * height).map(at).collect();
    assert!(!ids.contains(&Some(CLEARED_FACE)), "a clear of the pick buffer is lost");
    (memory.bytes().to_vec(), depth, ids, stats)
}

pub fn of_threads(threads: usize) -> Renderer {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    Renderer::new(RenderOptions { pool: Some(Arc::new(pool)), ..RenderOptions::default() })
}

/// Returns a scene with the objects of many random scenes, most of them scaled down.
fn crowd(seed: u64, count: usize) -> Scene {
    let mut scene = random(seed);
    let mut all = std::mem::take(&mut scene.scene.objects);
    for next in 1.. {
        for mut object in random(seed + 1000 * next).scene.objects {
            let i = all.len() as f64;
            if !all.len().is_multiple_of(9) {
                let at = DVec3::new((i * 0.37) % 2.0 - 1.0, (i * 0.61) % 1.6 - 0.8, (i * 0.23) % 1.5);
                object.model =
                    DMat4::from_translation(at) * DMat4::from_scale(DVec3::splat(0.12)) * object.model;
            }
            object.lights = None;
            // Supported by the tile renderer, but for every seventh.
            if !all.len().is_multiple_of(7) {
                object.material.transparency = 0.0;
                object.texture = None;
            }
            all.push(object);
        }
        if all.len() >= count {
            break;
        }
    }
    // Some objects twice, so that depths tie; some whose lighting f32 cannot hold; some with lines.
    let twice: Vec<Object> = all.iter().step_by(11).cloned().collect();
    all.extend(twice);
    for object in all.iter_mut().skip(5).step_by(29) {
        object.material = Material { ks: DVec3::ONE, n: 4000.0, ..object.material.clone() };
        object.shade = Some(ShadeMode::Phong);
    }
    for i in (3..all.len()).step_by(31) {
        let mut mesh: Mesh = shapes::cuboid(DVec3::ONE).unwrap();
        mesh.lines = vec![[0, 1], [2, 3], [4, 5]];
        let model = all[i].model;
        all[i] = Object { model, ..object("with lines", mesh) };
    }
    Scene { objects: all, ..scene.scene }
}

#[test]
fn objects_drawn_together_are_those_drawn_one_by_one() {
    let mut alone = Renderer::default();
    let mut crews = [2, 3, 16].map(|threads| (threads, of_threads(threads)));
    let formats = [DepthFormat::F32, DepthFormat::U16, DepthFormat::U24, DepthFormat::Reversed];
    let hides = [HiddenSurface::ZBuffer, HiddenSurface::ZBuffer, HiddenSurface::None, HiddenSurface::Painter];
    for seed in 0..12 {
        // Fewer and more than one thread prepares, and more than one batch holds.
        let mut scene = crowd(seed, [40, 150, 400][seed as usize % 3]);
        if seed % 5 == 4 {
            let fog = Fog { color: DVec3::splat(0.4), kind: FogKind::Linear, visibility_range: 12.0 };
            scene.fog = Some(fog);
        }
        let (hide, format) = (hides[seed as usize / 2 % 4], formats[seed as usize % 4]);
        let one = draw(&mut alone, &scene, hide, format);
        assert!(one.3.pixels_written > 1000, "seed {seed}: {:?}", one.3);
        for (threads, renderer) in &mut crews {
            // Twice: the second draw finds the lists of the first.
            for _ in 0..2 {
                let other = draw(renderer, &scene, hide, format);
                assert_eq!(other.3, one.3, "seed {seed}, {threads} threads, {hide:?}, {format:?}");
                assert!(other == one, "seed {seed}, {threads} threads, {hide:?}, {format:?}: other bytes");
            }
        }
    }
}

#[test]
fn draws_drawn_together_are_those_drawn_one_after_the_other() {
    let (width, height) = (333, 190);
    let formats = [DepthFormat::F32, DepthFormat::U16, DepthFormat::U24, DepthFormat::Reversed];
    for seed in 0..12 {
        let scene = crowd(seed, [40, 150, 400][seed as usize % 3]);
        let mut calls: Vec<DrawCall> = Vec::new();
        for (i, object) in scene.objects.iter().enumerate() {
            let mut options = SceneOptions::new(width, height);
            // Other viewports, and other uses of depth, in between.
            options.viewport.x = if i % 40 > 30 { 50 } else { 0 };
            options.hide = [HiddenSurface::ZBuffer, HiddenSurface::None, HiddenSurface::Painter]
                [if i % 50 > 40 { i % 3 } else { 0 }];
            let mut call = DrawCall::of_object(object, &scene, &options);
            call.name = i as u32;
            // Refused calls, with fewer and with more calls between them than one thread prepares.
            let run = if seed % 3 == 2 { 197 } else { 37 };
            if i % run == run - 1 {
                call.model.w_axis.x = f64::NAN;
            }
            calls.push(call);
        }
        let depth_format = formats[seed as usize % 4];
        let draw = |renderer: &mut Renderer, is_together: bool| {
            let mut memory = VideoMemory::new(width, height).unwrap();
            let (mut depth, mut ids) = (None, cleared_pick_buffer(width, height));
            let mut target =
                Target { memory: &mut memory, depth: &mut depth, depth_format, ids: Some(&mut ids) };
            let results = match is_together {
                true => renderer.draw_all(&mut target, &calls),
                false => calls.iter().map(|call| renderer.draw(&mut target, call)).collect(),
            };
            let depth = depth.map(|d| (0..(width * height) as usize).map(|i| d.word(i)).collect::<Vec<_>>());
            let at = |i: u32| ids.get((i % width) as i32, (i / width) as i32);
            let picked: Vec<_> = (0..width * height).map(at).collect();
            assert!(!picked.contains(&Some(CLEARED_FACE)), "a clear of the pick buffer is lost");
            (memory.bytes().to_vec(), depth, picked, results)
        };
        let mut alone = Renderer::default();
        let want = draw(&mut alone, false);
        let refused = want.3.iter().filter(|result| result.is_err()).count();
        assert!(refused > 0 && want.3.len() == calls.len(), "seed {seed}");
        assert!(draw(&mut alone, true) == want, "seed {seed}, one thread");
        for threads in [2, 3, 16] {
            let mut renderer = of_threads(threads);
            // Twice: the second draw finds the lists of the first.
            for _ in 0..2 {
                let got = draw(&mut renderer, true);
                assert_eq!(got.3, want.3, "seed {seed}, {threads} threads, {depth_format:?}");
                assert!(got == want, "seed {seed}, {threads} threads, {depth_format:?}: other bytes");
            }
        }
    }
}

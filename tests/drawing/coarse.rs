//! Hierarchical z on and off: equal bytes, and less work.
//!
//! Guards against culling a face of which something would have been seen.

use fbptr::memory::{DepthFormat, PickBuffer, VideoMemory};
use fbptr::pipeline::{
    CoarseDepth, DrawStats, Part, PlanItem, RenderOptions, Renderer, SceneOptions, Target,
};
use fbptr::scene::{Background, Camera, LookAt, Mesh, Object, Projection, Scene, ShadeMode, shapes};
use fbptr::simd::Level;
use fbptr::truth::scenes::{Random, object, random};
use glam::{DMat4, DVec3};
use proptest::prelude::*;
use std::sync::Arc;

/// Bytes, depths, face at each pixel, and counts.
type Picture = (Vec<u8>, Option<Vec<u32>>, Vec<Option<(u32, u32)>>, DrawStats);

fn draw(renderer: &mut Renderer, scene: &Scene, size: [u32; 2], format: DepthFormat, times: u32) -> Picture {
    let [width, height] = size;
    let mut memory = VideoMemory::new(width, height).unwrap();
    let (mut depth, mut ids) = (None, PickBuffer::new(width, height));
    let mut stats = DrawStats::default();
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: Some(&mut ids) };
    let options = SceneOptions::new(width, height);
    // In the second pass every face meets its own depths.
    for _ in 0..times {
        stats += renderer.draw_scene(&mut target, scene, &options).unwrap();
    }
    let depth = depth.map(|d| (0..(width * height) as usize).map(|i| d.word(i)).collect());
    let at = |i: u32| ids.get((i % width) as i32, (i / width) as i32);
    (memory.bytes().to_vec(), depth, (0..width * height).map(at).collect(), stats)
}

fn renderer(level: Level, threads: usize, coarse: CoarseDepth) -> Renderer {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let options = RenderOptions::default();
    Renderer::new(RenderOptions { pool: Some(Arc::new(pool)), simd: Some(level), coarse, ..options })
}

/// Returns a frame's plan for coarse depth, its counts and its bytes.
fn frame(renderer: &mut Renderer, scene: &Scene, size: [u32; 2]) -> (PlanItem, DrawStats, Vec<u8>) {
    let [width, height] = size;
    let mut memory = VideoMemory::new(width, height).unwrap();
    let (mut depth, depth_format) = (None, DepthFormat::F32);
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
    let options = SceneOptions::new(width, height);
    let plan = *renderer.plan_scene(&target, scene, &options).item(Part::CoarseDepth);
    let stats = renderer.draw_scene(&mut target, scene, &options).unwrap();
    (plan, stats, memory.bytes().to_vec())
}

/// Verifies that the pictures are equal; returns the number of culled faces.
fn hidden_faces(scene: &Scene, size: [u32; 2], format: DepthFormat, (level, threads): (Level, usize)) -> u64 {
    let [on, off] = [CoarseDepth::On, CoarseDepth::Off]
        .map(|coarse| draw(&mut renderer(level, threads, coarse), scene, size, format, 2));
    assert!(on.0 == off.0, "other bytes");
    assert!(on.1 == off.1, "other depths");
    assert!(on.2 == off.2, "other faces are seen");
    assert_eq!(off.3.faces_hidden, 0);
    // The pixels that pass are the same; culled faces were not tested.
    assert_eq!(on.3.pixels_written, off.3.pixels_written);
    assert!(on.3.pixels_tested <= off.3.pixels_tested);
    let others = |s: DrawStats| DrawStats { faces_hidden: 0, coarse_draws: 0, pixels_tested: 0, ..s };
    assert_eq!(others(on.3), others(off.3));
    on.3.faces_hidden
}

/// Returns faces of every size before and behind one another: a large one through the frame, grids,
/// knots, near to far or in any order.
fn heap(seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let thing = |random: &mut Random, i: u32| -> Object {
        let mesh = match i % 4 {
            0 => {
                let corners = [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]];
                let positions = corners.map(|[x, y]| DVec3::new(x, y, random.real(-0.2, 0.2))).to_vec();
                Mesh::from_triangles(positions, &[[0, 1, 2], [0, 2, 3]])
            }
            1 => shapes::knot(40 + random.real(0.0, 200.0) as u32, 12).unwrap(),
            2 => shapes::sphere(1.0).unwrap(),
            _ => shapes::cuboid(DVec3::new(3.0, 2.0, 0.1)).unwrap(),
        };
        let mut thing = object("thing", mesh);
        let z = if seed.is_multiple_of(2) { 1.5 - 0.3 * f64::from(i) } else { random.real(-3.0, 1.5) };
        let at = DVec3::new(random.real(-1.0, 1.0), random.real(-1.0, 1.0), z);
        let turn =
            DMat4::from_rotation_y(random.real(-0.4, 0.4)) * DMat4::from_rotation_x(random.real(-0.4, 0.4));
        thing.model = DMat4::from_translation(at) * turn;
        thing.material.kd = random.point(0.1, 1.0);
        thing.material.emissive = random.point(0.0, 0.5);
        thing.shade = Some([ShadeMode::Flat, ShadeMode::Phong][i as usize % 2]);
        thing
    };
    let projection = match seed % 3 {
        0 => Projection::Ortho { window: [-2.0, 2.0, -2.0, 2.0], near: 0.5, far: 12.0 },
        _ => Projection::Perspective { fov_rad: 1.0, near: 0.5, far: 12.0, on_smaller_side: false },
    };
    let look_at = LookAt { eye: DVec3::new(0.0, 0.0, 4.0), reference: DVec3::ZERO, up: DVec3::Y };
    Scene {
        camera: Some(Camera { look_at, projection }),
        background: Background { color: Some(DVec3::splat(0.1)) },
        objects: (0..9).map(|i| thing(&mut random, i)).collect(),
        ..Scene::default()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn nothing_that_is_seen_is_left_out(seed in any::<u32>(), way in 0..6usize, size in 0..3usize) {
        let level = [Level::best(), Level::Portable][way % 2];
        let ways = (level, [1, 2, 3][way / 2]);
        let size = [[150, 97], [288, 70], [401, 160]][size];
        hidden_faces(&heap(seed.into()), size, DepthFormat::F32, ways);
        let case = random(seed.into());
        hidden_faces(&case.scene, size, case.format, ways);
    }
}

#[test]
fn hidden_faces_are_left_out_and_counted() {
    for level in Level::ALL.into_iter().filter(|l| l.is_available()) {
        for seed in [2, 4, 6] {
            let hidden = hidden_faces(&heap(seed), [401, 160], DepthFormat::F32, (level, 2));
            assert!(hidden > 100, "seed {seed}, {level:?}: {hidden} faces left out");
        }
        assert_eq!(hidden_faces(&heap(2), [401, 160], DepthFormat::U24, (level, 2)), 0, "only f32 has it");
    }
}

#[test]
fn the_plan_says_whether_hidden_faces_are_left_out_and_what_that_takes() {
    let scene = heap(2);
    let mut memory = VideoMemory::new(64, 48).unwrap();
    let mut depth = None;
    let mut item = |coarse, depth_format| {
        let target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
        let plan = renderer(Level::best(), 3, coarse).plan_scene(&target, &scene, &SceneOptions::new(64, 48));
        *plan.item(Part::CoarseDepth)
    };
    let on = item(CoarseDepth::On, DepthFormat::F32);
    assert!(on.used && on.count > 1000 && on.bytes > 3 * 256 && on.bytes < 3 * 400, "{on:?}");
    let off = item(CoarseDepth::Off, DepthFormat::F32);
    assert!(!off.used && off.bytes == 0 && off.reason == "off, on request", "{off:?}");
    let other = item(CoarseDepth::On, DepthFormat::U16);
    assert!(!other.used && other.reason.contains("f32"), "{other:?}");
}

/// Returns a knot behind a wall that leaves a part of the frame open, or beside it.
fn wall_and_knot(is_hidden: bool) -> Scene {
    let mut scene = heap(0);
    scene.objects.truncate(2);
    let [wall, knot] = &mut scene.objects[..] else { panic!("two objects") };
    wall.model = DMat4::from_translation(DVec3::new(0.0, 0.0, if is_hidden { 2.0 } else { -5.0 }));
    knot.model = DMat4::from_scale(DVec3::splat(0.8));
    scene
}

#[test]
fn what_was_hidden_before_decides_by_itself() {
    let (hidden, mut seen) = (wall_and_knot(true), wall_and_knot(false));
    // The same meshes, elsewhere.
    for (there, here) in seen.objects.iter_mut().zip(&hidden.objects) {
        there.geometry = Arc::clone(&here.geometry);
    }
    let faces = hidden.objects[1].geometry.mesh.triangles.len() as u64;
    let size = [720, 480];
    let frames: Vec<&Scene> =
        [vec![&hidden; 3], vec![&seen; 3], vec![&hidden; 40], vec![&seen; 2]].into_iter().flatten().collect();
    let run = |level, threads, coarse| -> Vec<_> {
        let mut renderer = renderer(level, threads, coarse);
        frames.iter().map(|scene| frame(&mut renderer, scene, size)).collect()
    };
    let off = run(Level::best(), 1, CoarseDepth::Off);
    let auto = run(Level::best(), 1, CoarseDepth::Auto);
    let used: Vec<bool> = auto.iter().map(|(plan, ..)| plan.used).collect();
    let times = |n: usize, used: bool| vec![used; n];
    let want = [
        // Counted first; then on until the knot is seen, and off the frame after.
        times(1, false),
        times(3, true),
        times(3, false),
        // Hidden again: on, but for a frame in which it is counted anew.
        times(32, true),
        times(1, false),
        times(7, true),
        times(1, false),
    ];
    assert_eq!(used, want.concat());
    for (i, ((plan, stats, bytes), (_, plain, want))) in auto.iter().zip(&off).enumerate() {
        assert!(bytes == want, "frame {i}: other bytes");
        assert_eq!(stats.pixels_written, plain.pixels_written, "frame {i}");
        assert_eq!(plan.count, if plan.used { faces } else { 0 }, "frame {i}: the knot alone");
        assert!(plan.used || stats.faces_hidden == 0, "frame {i}: {plan:?}");
    }
    assert!(auto[1].1.faces_hidden > faces / 4 && auto[1].1.pixels_tested < off[1].1.pixels_tested);
    assert!(auto[0].0.reason.contains("not been drawn") && auto[1].0.reason.contains("most of the mesh"));
    assert!(auto[4].0.reason.contains("counted again") && auto[5].0.reason.contains("little of the mesh"));
    // The same decisions whatever draws.
    for level in Level::ALL.into_iter().filter(|l| l.is_available()) {
        for threads in [1, 3] {
            let other = run(level, threads, CoarseDepth::Auto);
            for (i, ((plan, _, bytes), (want, _, want_bytes))) in other.iter().zip(&auto).enumerate() {
                let same = |p: &PlanItem| (p.used, p.count, p.reason);
                assert_eq!(same(plan), same(want), "frame {i}, {level:?}, {threads} threads");
                assert!(bytes == want_bytes, "frame {i}, {level:?}, {threads} threads: other bytes");
            }
        }
    }
}

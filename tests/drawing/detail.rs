//! Levels of detail: a picture under a shift S must be right, within E, for what the exact picture
//! shows within S pixels.
//!
//! The exact picture is drawn four times as wide and high; each pixel of the coarse one that differs
//! must then lie, within E, in the range of the samples up to half a pixel farther than S from its
//! centre, in each channel. Between samples a colour may be any of those beside it: at a contour the
//! normal turns by many degrees from one sample to the next. A face that is lit otherwise, or missing
//! beyond S, is brighter or darker than all of them.

use fbptr::memory::{DepthFormat, MemoryBudget, VideoMemory};
use fbptr::pipeline::quality::{Budget, Choice, Detail, MeshShapes, WholeReason, prove};
use fbptr::pipeline::{RenderOptions, Renderer, SceneOptions, Target};
use fbptr::scene::{Light, LightingModel, MaxError, Scene, Texture, shapes};
use fbptr::truth::scenes::{lit_triangle, object};
use glam::{DMat4, DVec3};
use std::sync::Arc;

const WIDTH: u32 = 320;
const HEIGHT: u32 = 240;

/// Returns a knot of 96,000 faces before a camera, under a point light and one from a direction.
fn knot(model: LightingModel) -> Scene {
    let mut scene = lit_triangle();
    let mut thing = object("knot", shapes::knot(800, 60).unwrap());
    thing.material.kd = DVec3::new(0.7, 0.4, 0.2);
    (thing.material.ks, thing.material.n, thing.material.model) = (DVec3::splat(0.2), 12.0, model);
    thing.model =
        DMat4::from_rotation_x(0.3) * DMat4::from_rotation_y(0.4) * DMat4::from_scale(DVec3::splat(0.4));
    scene.objects = vec![thing];
    scene.lights.push(Light::point(DVec3::new(3.0, 4.0, 5.0), DVec3::splat(0.4)));
    scene.lights[0].color = DVec3::splat(0.5);
    scene
}

fn frame(scene: &Scene, scale: u32, threads: usize) -> VideoMemory {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let mut memory = VideoMemory::new(WIDTH * scale, HEIGHT * scale).unwrap();
    let mut target =
        Target { memory: &mut memory, depth: &mut None, depth_format: DepthFormat::F32, ids: None };
    let options = SceneOptions::new(WIDTH * scale, HEIGHT * scale);
    let mut renderer =
        Renderer::new(RenderOptions { pool: Some(Arc::new(pool)), ..RenderOptions::default() });
    renderer.draw_scene(&mut target, scene, &options).unwrap();
    memory
}

/// Returns the choice for a scene that is drawn so often that levels pay.
fn choice(scene: &Scene, steps: f64, shift: f64) -> Choice {
    choice_with(scene, steps, shift, &mut MeshShapes::at_once().expecting(1000))
}

fn choice_with(scene: &Scene, steps: f64, shift: f64, shapes: &mut MeshShapes) -> Choice {
    let options = SceneOptions::new(WIDTH, HEIGHT);
    prove(&Budget { scene, options: &options, max_error: MaxError { steps, shift } }, shapes)
}

fn coarse(scene: &Scene, choice: &Choice) -> Scene {
    let mut scene = scene.clone();
    choice.apply(&mut scene);
    scene
}

fn pixel(memory: &VideoMemory, x: u32, y: u32) -> [u8; 3] {
    let at = 4 * (y as usize * memory.width() as usize + x as usize);
    std::array::from_fn(|c| memory.bytes()[at + c])
}

/// Returns the number of pixels that differ from the exact picture, and of those without a sample that
/// explains them.
fn compare(scene: &Scene, choice: &Choice, steps: f64, shift: f64) -> [usize; 2] {
    let (exact, fine, drawn) = (frame(scene, 1, 2), frame(scene, 4, 2), frame(&coarse(scene, choice), 1, 2));
    let reach = ((shift + 0.5) * 4.0) as i64;
    let (mut differing, mut unexplained) = (0, 0);
    for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
        let color = pixel(&drawn, x, y);
        if color == pixel(&exact, x, y) {
            continue;
        }
        let samples = |n: u32, end: u32| {
            let middle = i64::from(4 * n + 2);
            (middle - reach..middle + reach).map(move |i| i.clamp(0, i64::from(end) - 1) as u32)
        };
        let (mut low, mut high) = ([u8::MAX; 3], [0; 3]);
        for j in samples(y, 4 * HEIGHT) {
            for sample in samples(x, 4 * WIDTH).map(|i| pixel(&fine, i, j)) {
                low = std::array::from_fn(|c| low[c].min(sample[c]));
                high = std::array::from_fn(|c| high[c].max(sample[c]));
            }
        }
        let is_within = |c: usize| {
            f64::from(low[c]) - steps <= f64::from(color[c])
                && f64::from(color[c]) <= f64::from(high[c]) + steps
        };
        differing += 1;
        unexplained += usize::from(!(0..3).all(is_within));
    }
    [differing, unexplained]
}

#[test]
fn every_pixel_is_right_within_the_shift() {
    for (model, steps, shift) in [(LightingModel::Phong, 4.0, 0.5), (LightingModel::Blinn, 8.0, 0.25)] {
        let scene = knot(model);
        let choice = choice(&scene, steps, shift);
        let Some((Detail::Level { level, faces, shift: bound, steps: of_color }, 1)) = choice.details.first()
        else {
            panic!("{choice}");
        };
        assert!(level.geometry.mesh.triangles.len() * 3 < faces * 2, "{choice}");
        assert!(*bound <= shift && *of_color <= steps, "{choice}");
        let [differing, unexplained] = compare(&scene, &choice, steps, shift);
        assert!(differing > 0 && unexplained == 0, "{unexplained} of {differing}\n{choice}");
    }
}

#[test]
fn the_check_finds_what_is_not_right() {
    let scene = knot(LightingModel::Phong);
    // A knot of few faces in place of a level of the fine one.
    let mut wrong = choice(&scene, 4.0, 0.5);
    let coarse = object("knot", shapes::knot(20, 4).unwrap()).geometry;
    wrong.settings[0].level.as_mut().unwrap().geometry = coarse;
    assert!(compare(&scene, &wrong, 4.0, 0.5)[1] > 100);
}

#[test]
fn without_a_shift_all_is_as_before_and_levels_are_the_same_with_any_threads() {
    let scene = knot(LightingModel::Phong);
    let [none, some] = [0.0, 0.5].map(|shift| choice(&scene, 4.0, shift));
    assert!(none.details.is_empty() && none.is_exact() && !some.is_exact(), "{none}{some}");
    assert!(frame(&coarse(&scene, &none), 1, 1).bytes() == frame(&scene, 1, 1).bytes());
    let again = choice(&scene, 4.0, 0.5);
    let first = frame(&coarse(&scene, &some), 1, 1);
    assert!(frame(&coarse(&scene, &again), 1, 3).bytes() == first.bytes());
}

#[test]
fn levels_are_refused_where_nothing_is_proven_or_they_do_not_pay() {
    let scene = knot(LightingModel::Phong);
    let why = |change: &dyn Fn(&mut Scene), steps: f64, shift: f64| {
        let mut scene = scene.clone();
        change(&mut scene);
        match choice(&scene, steps, shift).details.first() {
            Some((Detail::Whole(reason), _)) => *reason,
            other => panic!("{other:?}"),
        }
    };
    let is_different = |reason| matches!(reason, WholeReason::TooDifferent { .. });
    assert!(is_different(why(&|s| s.objects[0].material.n = 2000.0, 4.0, 0.5)));
    assert!(is_different(why(&|_| {}, 2.01, 0.5)));
    assert!(matches!(why(&|_| {}, 4.0, 1e-4), WholeReason::TooFar { .. }));
    let is_unproven = |change: &dyn Fn(&mut Scene)| {
        assert!(matches!(why(change, 4.0, 0.5), WholeReason::Unproven(_)));
    };
    is_unproven(&|s| s.objects[0].shade = Some(fbptr::scene::ShadeMode::Flat));
    is_unproven(&|s| s.objects[0].model = DMat4::from_scale(DVec3::new(0.4, 0.5, 0.4)));
    is_unproven(&|s| s.objects[0].model = DMat4::from_translation(s.camera.unwrap().look_at.eye));
    is_unproven(&|s| {
        let texture = Texture::new(1, 1, vec![200, 100, 50, 255]).unwrap();
        s.objects[0].texture = Some((Arc::new(texture), Default::default()));
    });
    // A light whose strength depends on the place.
    is_unproven(&|s| {
        let fbptr::scene::LightKind::Point { attenuation, .. } = &mut s.lights[1].kind else {
            unreachable!()
        };
        attenuation.q = 0.1;
    });
    let mut shapes = MeshShapes::at_once();
    let reason = |shapes: &mut MeshShapes| match choice_with(&scene, 4.0, 0.5, shapes).details.pop() {
        Some((Detail::Whole(reason), _)) => Some(reason),
        _ => None,
    };
    assert_eq!(reason(&mut shapes), Some(WholeReason::Unpaid { draws: 1, needed: 512 }));
    for _ in 2..512 {
        reason(&mut shapes);
    }
    assert_eq!(reason(&mut shapes), None);
    let mut shapes = MeshShapes::at_once().expecting(1000);
    shapes.set_budget(&MemoryBudget::new(1 << 20));
    assert_eq!(reason(&mut shapes), Some(WholeReason::NoLevels));
}

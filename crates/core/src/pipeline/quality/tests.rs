//! Tests with evident choices; `tests/drawing/budget.rs` compares pictures with the reference.

use super::*;
use crate::scene::{Light, LightKind, Object, ShadeMode, shapes};
use crate::truth::scenes::{lit_triangle, object};
use glam::{DMat4, DVec3};

/// Returns the choice for a scene of this size whose meshes were all drawn before, and the number of
/// faces that were measured for it.
fn chosen(scene: &Scene, max_error: f64, [width, height]: [u32; 2]) -> (Choice, u64) {
    let options = SceneOptions::new(width, height);
    let mut shapes = MeshShapes::at_once();
    let choice = prove(&Budget { scene, options: &options, max_error: max_error.into() }, &mut shapes);
    (choice, shapes.measured_faces())
}

fn proven(scene: &Scene, max_error: f64) -> Choice {
    chosen(scene, max_error, [1600, 1200]).0
}

/// A ball in place of the triangle.
fn ball(scene: &mut Scene) {
    scene.objects = vec![object("ball", shapes::sphere(1.0).unwrap())];
}

#[test]
fn a_flat_triangle_under_the_sun_needs_one_colour() {
    let choice = proven(&lit_triangle(), 1.0);
    assert_eq!(choice.settings[0].shade, Some(ShadeMode::Flat), "{choice}");
    assert!(choice.costs[1] < choice.costs[0] && choice.proven == 1.0, "{choice}");
}

#[test]
fn under_one_step_and_without_objects_all_is_exact() {
    assert!(proven(&lit_triangle(), 0.5).to_string().contains("nothing but exact"));
    let mut scene = lit_triangle();
    scene.objects.clear();
    assert!(proven(&scene, 5.0).is_exact());
}

#[test]
fn the_bound_decides_between_the_shading_modes() {
    let mut scene = lit_triangle();
    ball(&mut scene);
    let shade = |e: f64| proven(&scene, e).settings[0].shade;
    assert_eq!((shade(2.0), shade(60.0)), (None, Some(ShadeMode::Flat)), "{}", proven(&scene, 60.0));
    // A highlight may add all of itself.
    scene.objects[0].material.ks = DVec3::splat(0.9);
    assert_eq!(proven(&scene, 100.0).settings[0].shade, None);
}

#[test]
fn what_is_not_seen_to_hold_for_any_camera_is_exact() {
    let mut scene = lit_triangle();
    let is_exact = |change: &dyn Fn(&mut Object)| {
        let mut scene = scene.clone();
        change(&mut scene.objects[0]);
        proven(&scene, 8.0).is_exact()
    };
    assert!(!is_exact(&|_| {}));
    assert!(is_exact(&|o| (o.two_sided_lighting, o.cull) = (true, crate::scene::Cull::None)));
    assert!(is_exact(&|o| o.back_material = Some(o.material.clone())));
    assert!(is_exact(&|o| o.material.transparency = 0.5));
    assert!(is_exact(&|o| o.model = DMat4::from_scale(DVec3::new(1.0, 2.0, 1.0))));
    assert!(!is_exact(&|o| o.model = DMat4::from_scale(DVec3::splat(1.25))));
    assert!(is_exact(&|o| o.shade = Some(ShadeMode::Wire)));
    // A point light: near it the direction turns over the face.
    // Light of a large face is interpolated where it is nearly linear, which is decided as it is drawn.
    scene.lights = vec![Light::point(DVec3::new(0.0, 0.0, 1.0), DVec3::ONE)];
    let near = proven(&scene, 8.0);
    assert_eq!((near.settings[0].shade, near.settings[0].light_error, near.proven), (None, Some(6.0), 8.0));
    scene.lights = vec![Light::point(DVec3::new(0.0, 0.0, 1e4), DVec3::ONE)];
    assert!(!proven(&scene, 8.0).is_exact());
    // Of a matte face under a directional light it is computed in less time.
    scene.lights = vec![Light::directional(DVec3::new(0.3, 0.1, -1.0), DVec3::ONE)];
    assert!(proven(&scene, 8.0).settings[0].light_error.is_none());
    scene.objects[0].material.ks = DVec3::splat(0.2);
    assert!(proven(&scene, 8.0).settings[0].light_error.is_some());
}

#[test]
fn lights_that_add_too_little_are_left_out() {
    let mut scene = lit_triangle();
    ball(&mut scene);
    let mut dim = scene.lights[0];
    dim.color = DVec3::splat(0.002);
    scene.lights.extend([dim; 8]);
    let mut far = Light::point(DVec3::splat(100.0), DVec3::splat(50.0));
    let LightKind::Point { radius, .. } = &mut far.kind else { unreachable!() };
    *radius = 10.0;
    scene.lights.push(far);
    // Kd is at most 0.8: a light of 0.002 adds up to 0.41 steps.
    assert_eq!(proven(&scene, 2.9).settings[0].lights, Some(vec![0, 3, 4, 5, 6, 7, 8]));
    assert_eq!(proven(&scene, 5.5).settings[0].lights, Some(vec![0]), "{}", proven(&scene, 5.5));
}

#[test]
fn a_large_mesh_is_not_lit_ahead_of_the_pixels_but_loses_dark_lights() {
    let mut scene = lit_triangle();
    scene.objects = vec![object("ball", shapes::teapot(40).unwrap())];
    assert!(proven(&scene, 200.0).is_exact());
    let mut dim = scene.lights[0];
    dim.color = DVec3::splat(0.001);
    scene.lights.extend([dim; 8]);
    let choice = proven(&scene, 8.0);
    assert_eq!((choice.settings[0].shade, choice.settings[0].lights.as_deref()), (None, Some(&[0][..])));
}

#[test]
fn no_mesh_is_measured_that_costs_more_than_two_exact_frames() {
    let mut scene = lit_triangle();
    scene.objects = vec![object("pot", shapes::teapot(20).unwrap())];
    let faces = scene.objects[0].geometry.mesh.triangles.len() as u64;
    let (mut refused, mut measured) = (0, 0);
    for height in [60, 120, 240, 480, 960, 1920] {
        let (choice, measured_faces) = chosen(&scene, 60.0, [height * 4 / 3, height]);
        // 45 units a face, as the calibration has it.
        let is_cheap = 45.0 * faces as f64 <= 2.0 * choice.costs[0];
        assert!(measured_faces == 0 || is_cheap && measured_faces == faces, "{height}: {choice}");
        assert!(choice.unmeasured == 0 || !is_cheap && measured_faces == 0, "{height}: {choice}");
        let text = choice.to_string();
        let is_told = text.contains("1 meshes would cost more to measure than two exact frames");
        assert_eq!(is_told, choice.unmeasured == 1, "{text}");
        (refused, measured) = (refused + choice.unmeasured, measured + u64::from(measured_faces > 0));
    }
    assert!(refused > 0 && measured > 0, "{refused} refused, {measured} measured");
}

#[test]
fn nothing_is_chosen_for_an_object_whose_pixels_cost_less_than_choosing() {
    let mut scene = lit_triangle();
    let shade = |scene: &Scene| proven(scene, 8.0).settings[0].shade;
    assert_eq!(shade(&scene), Some(ShadeMode::Flat));
    scene.objects[0].model = DMat4::from_scale(DVec3::splat(0.02));
    assert_eq!(shade(&scene), None);
}

#[test]
fn a_choice_is_made_for_each_object() {
    let mut scene = lit_triangle();
    let mut shiny = object("shiny", shapes::teapot(2).unwrap());
    shiny.material.ks = DVec3::splat(0.7);
    scene.objects.push(shiny);
    let choice = proven(&scene, 8.0);
    assert_eq!([0, 1].map(|i| choice.settings[i].shade), [Some(ShadeMode::Flat), None], "{choice}");
    let mut cheaper = scene.clone();
    choice.apply(&mut cheaper);
    assert_eq!((cheaper.objects[0].shade, cheaper.objects[1].shade), (Some(ShadeMode::Flat), None));
    let options = SceneOptions::new(1600, 1200);
    let first = prove(
        &Budget { scene: &scene, options: &options, max_error: 8.0.into() },
        &mut MeshShapes::default(),
    );
    assert!(
        first.is_exact() && first.to_string().contains("2 meshes are drawn for the first time"),
        "{first}"
    );
}

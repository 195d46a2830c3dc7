//! Tests with evident choices; `tests/drawing/budget.rs` compares pictures with the reference.

use super::*;
use crate::pipeline::Renderer;
use crate::scene::{Filter, Light, LightKind, Sampling, ShadeMode, Texture, shapes};
use crate::truth::scenes::{lit_triangle, object};
use glam::DVec3;
use std::sync::Arc;

fn with_budget<T>(
    scene: &Scene,
    [width, height]: [u32; 2],
    max_error: f64,
    then: impl FnOnce(&Budget) -> T,
) -> T {
    let options = SceneOptions::new(width, height);
    let (kind, depth_format) = (BudgetKind::Scene, DepthFormat::F32);
    then(&Budget { scene, options: &options, kind, depth_format, width, height, max_error })
}

fn proven(scene: &Scene, max_error: f64) -> Choice {
    with_budget(scene, [1600, 1200], max_error, |budget| {
        prove(budget, |geometry| MeshShape::of(&geometry.mesh))
    })
}

fn tried(scene: &Scene, max_error: f64) -> Choice {
    with_budget(scene, [160, 120], max_error, |budget| {
        let exact = Choice::exact(budget, "not proven here");
        try_out(&mut Renderer::default(), budget, exact).unwrap()
    })
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
    assert!(tried(&scene, 5.0).is_exact());
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
    assert!(is_exact(&|o| o.model = glam::DMat4::from_scale(DVec3::new(1.0, 2.0, 1.0))));
    assert!(!is_exact(&|o| o.model = glam::DMat4::from_scale(DVec3::splat(1.25))));
    assert!(is_exact(&|o| o.shade = Some(ShadeMode::Wire)));
    // A point light: near it the direction turns over the face.
    scene.lights = vec![Light::point(DVec3::new(0.0, 0.0, 1.0), DVec3::ONE)];
    assert!(proven(&scene, 8.0).is_exact());
    scene.lights = vec![Light::point(DVec3::new(0.0, 0.0, 1e4), DVec3::ONE)];
    assert!(!proven(&scene, 8.0).is_exact());
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
fn a_large_mesh_is_not_lit_ahead_of_the_pixels() {
    let mut scene = lit_triangle();
    scene.objects = vec![object("ball", shapes::teapot(40).unwrap())];
    assert!(proven(&scene, 200.0).is_exact());
    assert!(tried(&scene, 200.0).is_exact());
}

#[test]
fn a_trial_keeps_what_stays_within_the_limit_object_by_object() {
    let mut scene = lit_triangle();
    let mut shiny = object("shiny", shapes::teapot(2).unwrap());
    shiny.material.ks = DVec3::splat(0.7);
    shiny.material.n = 40.0;
    shiny.model = glam::DMat4::from_translation(DVec3::new(1.0, 1.0, 0.5));
    scene.objects.push(shiny);
    let choice = tried(&scene, 8.0);
    assert_eq!(choice.settings[0].shade, Some(ShadeMode::Flat), "{choice}");
    assert_eq!(choice.settings[1].shade, None, "{choice}");
    let trial = choice.trial.as_ref().unwrap();
    assert_eq!((trial.objects, trial.holds_for), (2, 1), "{choice}");
    let mut cheaper = scene.clone();
    choice.apply(&mut cheaper);
    assert_eq!((cheaper.objects[0].shade, cheaper.objects[1].shade), (Some(ShadeMode::Flat), None));
}

#[test]
fn a_magnified_texture_needs_no_levels() {
    let mut scene = lit_triangle();
    let texels: Vec<u8> = (0..64u8).map(|i| if i % 4 == 3 { 255 } else { i.wrapping_mul(37) }).collect();
    let sampling = Sampling { filter: Filter::Trilinear, ..Sampling::default() };
    let o = &mut scene.objects[0];
    let mut mesh = o.geometry.mesh.clone();
    mesh.texcoords = vec![glam::DVec2::ZERO, glam::DVec2::X, glam::DVec2::Y];
    mesh.corners.iter_mut().enumerate().for_each(|(i, c)| c.texcoord = i as u32);
    o.geometry = Arc::new(crate::scene::Geometry { mesh, textures: Vec::new() });
    o.texture = Some((Arc::new(Texture::new(4, 4, texels).unwrap()), sampling));
    let choice = tried(&scene, 4.0);
    assert_eq!(choice.settings[0].filter, Some(Filter::Bilinear), "{choice}");
}

//! Tests with evident choices; `tests/drawing/budget.rs` compares pictures with the reference.

use super::*;
use crate::scene::{Filter, Sampling, ShadeMode, Texture, shapes};
use crate::truth::scenes::{lit_triangle, object};
use std::sync::Arc;

fn chosen(scene: &Scene, max_error: f64) -> Choice {
    let (width, height) = (48, 36);
    let options = SceneOptions::new(width, height);
    let budget = Budget {
        scene,
        options: &options,
        kind: BudgetKind::Scene,
        depth_format: DepthFormat::F32,
        width,
        height,
        max_error,
    };
    choose(&mut Renderer::default(), &budget).unwrap()
}

#[test]
fn a_flat_triangle_under_the_sun_needs_one_colour() {
    let scene = lit_triangle();
    let choice = chosen(&scene, 1.0);
    assert_eq!(choice.recipes[0].shade, Some(ShadeMode::Flat), "{choice}");
    assert!(choice.costs[1] < choice.costs[0] && choice.confidence == 1.0, "{choice}");
    assert_eq!(choice.sampled, choice.pixels);
}

#[test]
fn under_one_step_all_is_exact() {
    let choice = chosen(&lit_triangle(), 0.5);
    assert!(choice.is_exact(&SceneOptions::new(48, 36)), "{choice}");
    assert!(choice.to_string().contains("nothing but exact"));
}

#[test]
fn a_ball_with_a_highlight_is_not_flat() {
    let mut scene = lit_triangle();
    let mut ball = object("ball", shapes::sphere(1.2).unwrap());
    ball.material.ks = glam::DVec3::splat(0.7);
    ball.material.n = 40.0;
    scene.objects = vec![ball];
    let choice = chosen(&scene, 2.0);
    assert_eq!(choice.recipes[0].shade, None, "{choice}");
    assert!(choice.trials.len() > 2);
    // Without an effective bound the cheapest settings are chosen: no light, and no division.
    let choice = chosen(&scene, 255.0);
    assert_eq!(
        (choice.recipes[0].lights.clone(), choice.interp),
        (Some(vec![]), Interpolation::Affine),
        "{choice}"
    );
    assert!(choice.trials.iter().all(|t| t.cost >= choice.costs[1]), "{choice}");
}

#[test]
fn each_object_takes_its_own_recipe() {
    let mut scene = lit_triangle();
    let mut ball = object("ball", shapes::sphere(0.5).unwrap());
    ball.material.ks = glam::DVec3::splat(0.7);
    ball.material.n = 40.0;
    ball.model = glam::DMat4::from_translation(glam::DVec3::new(1.0, 1.0, 0.5));
    scene.objects.push(ball);
    let choice = chosen(&scene, 1.0);
    assert_eq!(choice.recipes[0].shade, Some(ShadeMode::Flat), "{choice}");
    assert_eq!(choice.recipes[1].shade, None, "{choice}");
    let (mut cheaper, mut options) = (scene.clone(), SceneOptions::new(48, 36));
    choice.apply(&mut cheaper, &mut options);
    assert_eq!((cheaper.objects[0].shade, cheaper.objects[1].shade), (Some(ShadeMode::Flat), None));
}

#[test]
fn a_plain_texture_needs_no_filter_and_a_black_light_is_left_out() {
    let mut scene = lit_triangle();
    let white = Texture::new(4, 4, vec![255; 64]).unwrap();
    let sampling = Sampling { filter: Filter::Trilinear, ..Sampling::default() };
    let o = &mut scene.objects[0];
    let mut mesh = o.geometry.mesh.clone();
    mesh.texcoords = vec![glam::DVec2::ZERO, glam::DVec2::X, glam::DVec2::Y];
    mesh.corners.iter_mut().enumerate().for_each(|(i, c)| c.texcoord = i as u32);
    o.geometry = Arc::new(crate::scene::Geometry { mesh, textures: Vec::new() });
    o.texture = Some((Arc::new(white), sampling));
    let mut dark = scene.lights[0];
    dark.color = glam::DVec3::splat(1e-6);
    scene.lights.push(dark);
    let choice = chosen(&scene, 1.0);
    assert_eq!(choice.recipes[0].filter, Some(Filter::Nearest), "{choice}");
    assert_eq!(choice.recipes[0].lights, Some(vec![0]), "{choice}");
}

#[test]
fn nothing_in_view_is_exact() {
    let mut scene = lit_triangle();
    scene.objects.clear();
    assert!(chosen(&scene, 5.0).is_exact(&SceneOptions::new(48, 36)));
}

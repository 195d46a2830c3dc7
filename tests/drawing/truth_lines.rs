//! Verifies position, depth and colour of lines and points in space.
//!
//! Random lines, points and wireframes among faces, through the eye plane, transparent and in fog,
//! are compared with the reference.

use fbptr::measure::draw_case;
use fbptr::scene::{Camera, Corner, Fog, FogKind, Geometry, HiddenSurface, LightingModel};
use fbptr::scene::{Material, Mesh, NONE, ShadeMode};
use fbptr::truth::scenes::{Case, Random, object, random};
use fbptr::truth::{Transparency, compare, render};
use glam::DVec3;
use std::sync::Arc;

/// Returns random segments and points with colours, some through the eye plane.
fn strokes(r: &mut Random, reach: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let alpha = r.pick(&[1.0, 1.0, 0.6]);
    for i in 0..40u32 {
        mesh.positions.push(r.point(-reach, reach));
        mesh.colors.push(r.point(0.0, 1.2).extend(alpha));
        let color = if i % 3 == 0 { NONE } else { i };
        mesh.corners.push(Corner { position: i, normal: NONE, texcoord: NONE, color });
    }
    mesh.lines = (0..14).map(|i| [2 * i, 2 * i + 1]).collect();
    mesh.points = (28..40).collect();
    mesh
}

/// Gives lines and points one of three materials each, or the draw's.
fn give_materials(geometry: &mut Arc<Geometry>, r: &mut Random) {
    let mesh = &mut Arc::make_mut(geometry).mesh;
    mesh.materials = vec![Material { kd: DVec3::X, ..Material::default() }; 3];
    mesh.materials[1] =
        Material { model: LightingModel::Unlit, emissive: r.point(0.1, 0.9), ..Material::default() };
    mesh.materials[2].transparency = 0.5;
    mesh.line_materials = mesh.lines.iter().map(|_| r.pick(&[0, 1, 2, NONE])).collect();
    mesh.point_materials = mesh.points.iter().map(|_| r.pick(&[0, 1, 2, NONE])).collect();
}

fn case(seed: u64) -> Case {
    let mut case = random(seed);
    let mut r = Random::new(seed ^ 0xabcd);
    let reach = r.pick(&[1.5, 2.5, 12.0]);
    let mut own = object("strokes", strokes(&mut r, reach));
    own.material.kd = r.point(0.2, 0.9);
    own.material.emissive = r.point(0.0, 0.3);
    own.material.model = r.pick(&[LightingModel::Phong, LightingModel::Unlit]);
    own.material.transparency = if r.one_in(4) { 0.3 } else { 0.0 };
    if r.one_in(3) {
        give_materials(&mut own.geometry, &mut r);
    }
    case.scene.objects.insert(r.below(2) as usize, own);
    if r.one_in(3) {
        case.scene.fog = Some(Fog {
            color: DVec3::splat(0.4),
            kind: FogKind::Linear,
            visibility_range: r.real(4.0, 12.0),
        });
    }
    case
}

fn check(cases: impl Iterator<Item = Case>) -> (usize, usize) {
    let (mut drawn, mut turns) = (0, 0);
    for case in cases {
        let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
        let found = draw_case(&case);
        let report = compare(&found.memory, found.depth.as_ref(), &truth);
        assert!(report.is_right(), "{}\n{:?}\n{report}", case.name, case.settings);
        drawn += found.memory.bytes().chunks_exact(4).filter(|p| p[..3] != [0; 3]).count();
        turns += report.turns;
    }
    (drawn, turns)
}

#[test]
fn lines_and_points_among_faces() {
    let (drawn, turns) = check((500..560).map(case));
    assert!(drawn > 10_000 && turns * 4 < drawn, "{drawn} pixels, {turns} either way");
}

#[test]
fn lines_and_points_alone_are_nearly_everywhere_sure() {
    let (drawn, turns) = check((700..740).map(|seed| {
        let mut case = case(seed);
        case.scene.objects.retain(|o| o.name == "strokes");
        case.scene.background = Default::default();
        case
    }));
    assert!(drawn > 2_000 && turns * 2 < drawn, "{drawn} pixels, {turns} either way");
}

#[test]
fn wireframes_whose_lines_are_all_seen() {
    let (drawn, _) = check((800..840).map(|seed| {
        let mut case = random(seed);
        case.settings.hide = if seed % 2 == 0 { HiddenSurface::None } else { HiddenSurface::Painter };
        case.settings.shade = ShadeMode::Wire;
        case.scene.objects.iter_mut().for_each(|o| o.shade = None);
        case
    }));
    assert!(drawn > 4_000, "{drawn} pixels");
}

#[test]
fn wireframes_with_hidden_lines() {
    let (drawn, turns) = check((840..880).map(|seed| {
        let mut case = random(seed);
        case.settings.hide = HiddenSurface::ZBuffer;
        case.settings.shade = ShadeMode::Wire;
        case.settings.transparency = Transparency::AtOnce;
        case.scene.background = Default::default();
        case.scene.objects.iter_mut().for_each(|o| o.shade = None);
        case
    }));
    assert!(drawn > 4_000 && turns * 4 < drawn, "{drawn} pixels, {turns} either way");
}

#[test]
fn of_two_segments_at_one_depth_the_first_stays() {
    let mut case = random(1);
    let segment = |name: &str, emissive: DVec3| {
        let mut mesh = Mesh::from_triangles(vec![DVec3::new(-1.0, 0.1, 0.0), DVec3::new(1.0, 0.1, 0.0)], &[]);
        mesh.corners =
            (0..2).map(|position| Corner { position, normal: NONE, texcoord: NONE, color: NONE }).collect();
        mesh.lines = vec![[0, 1]];
        let mut own = object(name, mesh);
        own.material.model = LightingModel::Unlit;
        own.material.emissive = emissive;
        own
    };
    case.scene.objects = vec![segment("first", DVec3::X), segment("second", DVec3::Y)];
    (case.scene.fog, case.scene.background.color, case.scene.camera) = (None, None, Some(Camera::default()));
    (case.settings.hide, case.settings.viewport) = (HiddenSurface::ZBuffer, None);
    let found = draw_case(&case);
    let count = |channel: usize| found.memory.bytes().chunks_exact(4).filter(|p| p[channel] == 255).count();
    assert!(count(0) > 10 && count(1) == 0, "{} red and {} green pixels", count(0), count(1));
}

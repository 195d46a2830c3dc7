//! Tests of the parts that a plan leaves out, and that the draw then does without.

use super::*;
use crate::memory::{DepthFormat, VideoMemory};
use crate::pipeline::draw_call::Backend;
use crate::pipeline::path_plan::{add_path, plan_call};
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::scene::{NOTHING_HIDDEN, calls_of, leaves_depth_out};
use crate::pipeline::{DepthUse, DrawStats, SceneOptions, Target, draw_scene, plan_scene};
use crate::scene::*;
use glam::{DMat4, DVec2, DVec3};
use std::sync::Arc;

const LIGHTING: [Part; 7] = [
    Part::FaceNormals,
    Part::VertexNormals,
    Part::LightFaces,
    Part::LightVertices,
    Part::LightPixels,
    Part::InterpolateNormals,
    Part::InterpolatePositions,
];

fn object(mesh: Mesh) -> Object {
    Object {
        name: "thing".into(),
        geometry: Arc::new(Geometry { mesh, textures: Vec::new() }),
        model: DMat4::IDENTITY,
        material: Material::default(),
        back_material: None,
        cull: Cull::Back,
        two_sided_lighting: false,
        shade: None,
        texture: None,
        lights: None,
        light_error: None,
        style: Default::default(),
    }
}

fn triangle() -> Mesh {
    let mut mesh = Mesh::from_triangles(
        vec![DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0), DVec3::new(0.0, 1.0, 0.0)],
        &[[0, 1, 2]],
    );
    mesh.texcoords = vec![DVec2::ZERO, DVec2::X, DVec2::Y];
    for (i, c) in mesh.corners.iter_mut().enumerate() {
        c.texcoord = i as u32;
    }
    mesh
}

/// Returns a tetrahedron: closed and convex.
fn solid() -> Mesh {
    let p = [[1., 1., 1.], [-1., -1., 1.], [-1., 1., -1.], [1., -1., -1.]].map(DVec3::from);
    Mesh::from_triangles(p.to_vec(), &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
}

fn prepared_light() -> Light {
    Light::directional(DVec3::NEG_Z, DVec3::ONE)
}

fn scene(objects: Vec<Object>) -> Scene {
    Scene { camera: Some(Camera::default()), lights: vec![prepared_light()], objects, ..Scene::default() }
}

fn texture(alpha: u8) -> Option<(Arc<Texture>, Sampling)> {
    Some((Arc::new(Texture::new(2, 2, vec![alpha; 16]).unwrap()), Sampling::default()))
}

/// Returns the plan of a scene on 20x20 pixels, the statistics of drawing it, and whether it
/// created a depth memory.
fn plan_and_draw(scene: &Scene, change: impl FnOnce(&mut SceneOptions)) -> (Plan, DrawStats, bool) {
    let mut options = SceneOptions::new(20, 20);
    change(&mut options);
    let mut memory = VideoMemory::new(20, 20).unwrap();
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::U16, ids: None };
    let plan = plan_scene(&target, scene, &options);
    assert_same_parts(&target, scene, &options);
    let stats = draw_scene(&mut target, scene, &options).unwrap();
    (plan, stats, depth.is_some())
}

/// Asserts that the draw of each object has the parts of its printed plan.
#[track_caller]
fn assert_same_parts(target: &Target, scene: &Scene, options: &SceneOptions) {
    let calls = calls_of(scene, options);
    let keeps_depth = !leaves_depth_out(&calls, None, options);
    for call in &calls {
        let plan = plan_call(call, target, Backend::default(), keeps_depth, None);
        let mut prepared = PreparedDraw::new(call, target, &mut DrawStats::default()).unwrap();
        add_path(&mut prepared, target, Backend::default(), keeps_depth);
        assert_eq!(prepared.parts, Parts::from(&plan), "{plan}");
        for part in Part::ALL {
            assert_eq!(prepared.parts.uses(part), plan.uses(part), "{part:?}");
        }
    }
}

fn whole(options: &mut SceneOptions) {
    options.depth_use = DepthUse::SceneOnly;
}

#[track_caller]
fn assert_absent(plan: &Plan, parts: &[Part]) {
    for part in parts {
        assert!(!plan.uses(*part), "{part:?} is there:\n{plan}");
        let item = plan.item(*part);
        assert!(item.bytes == 0 && item.count == 0 && !item.reason.is_empty());
    }
}

#[test]
fn a_2d_stream_has_a_frame_and_nothing_else() {
    let plan = Plan::of_2d(640, 480);
    assert_absent(&plan, &Part::ALL[1..]);
    assert_eq!(plan.bytes(), 640 * 480 * 4);
}

#[test]
fn an_unchanged_frame_draws_nothing() {
    let plan = Plan::of_unchanged_frame(64, 64);
    assert_absent(&plan, &Part::ALL[1..]);
    assert!(plan.to_string().contains("nothing moved"));
}

#[test]
fn one_emissive_triangle_needs_no_light_no_attribute_and_no_depth() {
    let mut thing = object(triangle());
    thing.material.emissive = DVec3::X;
    thing.cull = Cull::None;
    let dark = Scene { lights: Vec::new(), ..scene(vec![thing.clone()]) };
    let (plan, stats, has_depth) = plan_and_draw(&dark, whole);
    assert_absent(&plan, &LIGHTING);
    let without = [
        Part::DepthMemory,
        Part::InterpolateColors,
        Part::InterpolateTexcoords,
        Part::Textures,
        Part::SampleTextures,
        Part::ReadBack,
        Part::CullFaces,
    ];
    assert_absent(&plan, &without);
    assert!(!has_depth && stats.pixels_written > 30 && stats.pixels_lit + stats.vertices_lit == 0);
    // A stream may continue, so its depth is kept.
    let (plan, _, has_depth) = plan_and_draw(&dark, |_| {});
    assert!(plan.uses(Part::DepthMemory) && has_depth);
    assert_eq!(plan.item(Part::DepthMemory).bytes, 800);
    // A black light contributes nothing, and an unlit material needs no light.
    let black = Scene { lights: vec![Light { color: DVec3::ZERO, ..prepared_light() }], ..dark };
    assert_absent(&plan_and_draw(&black, whole).0, &LIGHTING);
    thing.material.model = LightingModel::Unlit;
    assert_absent(&plan_and_draw(&scene(vec![thing]), whole).0, &LIGHTING);
}

#[test]
fn a_flat_convex_solid_needs_no_depth_and_no_interpolation() {
    let mut thing = object(solid());
    thing.shade = Some(ShadeMode::Flat);
    let (plan, stats, has_depth) = plan_and_draw(&scene(vec![thing.clone()]), whole);
    let without = [
        Part::DepthMemory,
        Part::VertexNormals,
        Part::LightPixels,
        Part::LightVertices,
        Part::InterpolateNormals,
        Part::InterpolatePositions,
        Part::InterpolateColors,
    ];
    assert_absent(&plan, &without);
    assert!(plan.uses(Part::FaceNormals) && plan.uses(Part::LightFaces) && plan.uses(Part::CullFaces));
    assert!(!has_depth && stats.vertices_lit == stats.faces_drawn && stats.faces_culled > 0);
    // Seen from both sides, dented, open, or beside another object, faces may hide each other.
    let mut cases = vec![vec![thing.clone(), thing.clone()]];
    let mut both = thing.clone();
    both.cull = Cull::None;
    cases.push(vec![both]);
    let mut dented = solid();
    dented.positions.push(DVec3::ZERO);
    let inner = |corner: u32| Corner { position: corner, normal: NONE, texcoord: NONE, color: NONE };
    let open = Mesh::from_triangles(solid().positions, &[[0, 2, 1], [0, 1, 3]]);
    cases.push(vec![object(open)]);
    let mut folded = Mesh { positions: dented.positions, ..Mesh::default() };
    for t in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4], [2, 3, 4], [3, 1, 4]] {
        folded.push_polygon(&t.map(inner), NONE);
    }
    cases.push(vec![object(folded)]);
    for objects in cases {
        let (plan, _, has_depth) = plan_and_draw(&scene(objects), whole);
        assert!(plan.uses(Part::DepthMemory) && has_depth, "{plan}");
    }
}

/// Returns a mesh in which no two faces share a position, as in STL.
fn unshared(mesh: Mesh) -> Mesh {
    let positions: Vec<DVec3> = mesh
        .triangles
        .iter()
        .flatten()
        .map(|c| mesh.positions[mesh.corners[*c as usize].position as usize])
        .collect();
    let triangles: Vec<[u32; 3]> =
        (0..mesh.triangles.len() as u32).map(|t| [0, 1, 2].map(|k| 3 * t + k)).collect();
    Mesh::from_triangles(positions, &triangles)
}

#[test]
fn a_convex_solid_is_known_by_its_positions_not_by_their_numbers() {
    let mut thing = object(unshared(solid()));
    thing.shade = Some(ShadeMode::Flat);
    let (plan, _, has_depth) = plan_and_draw(&scene(vec![thing]), whole);
    assert!(!has_depth && !plan.uses(Part::DepthMemory), "{plan}");
    assert_eq!(plan.item(Part::DepthMemory).reason, NOTHING_HIDDEN);
    // One face turned over: edges run twice in one direction.
    let mut turned = unshared(solid());
    turned.triangles[0].swap(1, 2);
    let (plan, _, has_depth) = plan_and_draw(&scene(vec![object(turned)]), whole);
    assert!(has_depth && plan.uses(Part::DepthMemory), "{plan}");
}

#[test]
fn a_fog_without_end_is_no_fog() {
    let picture = |range: Option<f64>| {
        let mut s = scene(vec![object(solid())]);
        let fog = |visibility_range| Fog { color: DVec3::X, kind: FogKind::Exponential, visibility_range };
        s.fog = range.map(fog);
        let (plan, ..) = plan_and_draw(&s, whole);
        let mut memory = VideoMemory::new(40, 40).unwrap();
        let mut depth = None;
        let mut target =
            Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
        draw_scene(&mut target, &s, &SceneOptions::new(40, 40)).unwrap();
        (memory.bytes().to_vec(), plan)
    };
    let (without, _) = picture(None);
    for range in [0.0, f64::INFINITY] {
        let (bytes, plan) = picture(Some(range));
        assert!(bytes == without && !plan.uses(Part::Fog));
        assert_eq!(plan.item(Part::Fog).reason, "a visibility range of 0 or without end is no fog");
    }
    let (bytes, plan) = picture(Some(9.0));
    assert!(bytes != without && plan.uses(Part::Fog));
}

#[test]
fn the_convex_solid_without_depth_looks_as_with_it() {
    for seed in 0..20 {
        let mut thing = object(if seed % 2 == 0 { solid() } else { unshared(solid()) });
        thing.model = crate::math::matrix::rotate(DVec3::new(1.0, 0.3, 2.0), seed as f64).unwrap();
        let scene = scene(vec![thing]);
        let picture = |depth_use| {
            let mut memory = VideoMemory::new(40, 40).unwrap();
            let mut depth = None;
            let mut target =
                Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
            let options = SceneOptions { depth_use, ..SceneOptions::new(40, 40) };
            draw_scene(&mut target, &scene, &options).unwrap();
            memory.bytes().to_vec()
        };
        let seen = picture(DepthUse::SceneOnly);
        assert!(seen.as_chunks::<4>().0.iter().filter(|p| p[..3] != [0; 3]).count() > 100, "{seed}");
        assert_eq!(picture(DepthUse::Keep), seen);
    }
}

#[test]
fn an_orthographic_scene_divides_by_nothing() {
    let mut s = scene(vec![object(solid())]);
    let window = [-2.0, 2.0, -2.0, 2.0];
    s.camera =
        Some(Camera { projection: Projection::Ortho { window, near: 0.1, far: 9.0 }, ..Camera::default() });
    let (plan, stats, _) = plan_and_draw(&s, whole);
    assert_absent(&plan, &[Part::PerspectiveDivision, Part::CutFaces]);
    assert!(stats.pixels_written > 50);
    s.camera = None;
    assert!(plan_and_draw(&s, whole).0.uses(Part::PerspectiveDivision));
}

#[test]
fn an_untextured_scene_runs_no_u_and_v() {
    let parts = [Part::Textures, Part::InterpolateTexcoords, Part::SampleTextures];
    let mut thing = object(triangle());
    assert_absent(&plan_and_draw(&scene(vec![thing.clone()]), whole).0, &parts);
    thing.texture = texture(255);
    let (plan, _, _) = plan_and_draw(&scene(vec![thing]), whole);
    assert!(parts.iter().all(|p| plan.uses(*p)));
    assert_eq!(plan.item(Part::Textures).bytes, 16 + 16);
}

#[test]
fn an_opaque_scene_reads_nothing_back() {
    let plan_of = |change: &dyn Fn(&mut Object)| {
        let mut thing = object(triangle());
        change(&mut thing);
        plan_and_draw(&scene(vec![thing]), whole).0
    };
    assert_absent(&plan_of(&|_| {}), &[Part::ReadBack]);
    assert_absent(&plan_of(&|o| o.texture = texture(255)), &[Part::ReadBack]);
    assert!(plan_of(&|o| o.material.transparency = 0.1).uses(Part::ReadBack));
    assert!(plan_of(&|o| o.texture = texture(128)).uses(Part::ReadBack));
}

#[test]
fn each_shading_lights_where_it_should() {
    for (shade, part, others) in [
        (ShadeMode::Flat, Part::LightFaces, [Part::LightVertices, Part::LightPixels]),
        (ShadeMode::Gouraud, Part::LightVertices, [Part::LightFaces, Part::LightPixels]),
        (ShadeMode::Phong, Part::LightPixels, [Part::LightFaces, Part::LightVertices]),
    ] {
        let (plan, stats, _) = plan_and_draw(&scene(vec![object(solid())]), |o| o.shade = shade);
        assert!(plan.uses(part) && !others.iter().any(|p| plan.uses(*p)), "{plan}");
        assert_eq!(stats.pixels_lit > 0, shade == ShadeMode::Phong);
    }
    // Normals given by the file need no face normals.
    let mut mesh = solid();
    mesh.normals = vec![DVec3::Z];
    mesh.corners.iter_mut().for_each(|c| c.normal = 0);
    let (plan, _, _) = plan_and_draw(&scene(vec![object(mesh)]), |_| {});
    assert_absent(&plan, &[Part::FaceNormals, Part::VertexNormals]);
}

#[test]
fn hidden_surfaces_cost_what_their_method_needs() {
    let s = scene(vec![object(solid())]);
    let (plan, _, has_depth) = plan_and_draw(&s, |o| o.hide = HiddenSurface::None);
    assert_absent(&plan, &[Part::DepthMemory, Part::SortFaces, Part::PickBuffer]);
    assert!(!has_depth);
    let (plan, _, has_depth) = plan_and_draw(&s, |o| o.hide = HiddenSurface::Painter);
    assert!(plan.uses(Part::SortFaces) && !plan.uses(Part::DepthMemory) && !has_depth);
    let (plan, _, _) = plan_and_draw(&s, |o| (o.shade, o.hide) = (ShadeMode::Wire, HiddenSurface::None));
    assert_absent(&plan, &LIGHTING);
    assert!(plan.uses(Part::Lines) && !plan.uses(Part::Coverage));
}

#[test]
fn a_plan_prints_every_part_with_its_reason() {
    let (plan, _, _) = plan_and_draw(&scene(vec![object(solid()), object(triangle())]), |_| {});
    let text = plan.to_string();
    assert_eq!(text.lines().count(), 1 + Part::ALL.len());
    assert!(text.starts_with("plan: scene of 2 objects, "), "{text}");
    for line in [
        "  + video memory       the frame; 400 pixels, 1600 bytes",
        "  + transform vertices every position once; 7 vertices",
        "  - textures           no texture",
        "  + light pixels       SHADE phong: once a pixel, and once a large face of one normal; 2 lights",
    ] {
        assert!(text.lines().any(|l| l == line), "no {line:?} in\n{text}");
    }
}

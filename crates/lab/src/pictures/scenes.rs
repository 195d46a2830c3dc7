//! Scenes of the whole pictures.

use super::super::experiment::Effort;
use super::super::textures::bricks;
use super::super::threads::knot;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{
    Camera, Corner, Filter, Light, LookAt, Mesh, NONE, Object, Projection, Sampling, Scene, Wrap, shapes,
};
use fbptr_formats::load::obj;
use fbptr_truth::scenes::{Case, box_mesh, object};
use fbptr_truth::{Settings, Transparency};
use glam::{DMat4, DVec3};

/// Returns the number of faces of a case.
pub(super) fn faces(case: &Case) -> usize {
    case.scene.objects.iter().map(|o| o.geometry.mesh.triangles.len()).sum()
}

fn case(effort: &Effort, name: String, scene: Scene) -> Case {
    let (width, height) = effort.pick((320, 240), (640, 480));
    let settings =
        Settings { transparency: Transparency::AfterOpaque(Default::default()), ..Settings::default() };
    Case { name, scene, settings, format: DepthFormat::F32, width, height }
}

/// Returns the scenes that the program makes.
pub(in super::super) fn made(effort: &Effort) -> Vec<Case> {
    let [nu, nv] = effort.pick([250, 60], [4_000, 500]);
    let large = knot(nu, nv);
    let count = large.objects[0].geometry.mesh.triangles.len();
    vec![
        case(
            effort,
            "teapot".into(),
            teapot(&[Light::directional(DVec3::new(-0.3, -0.4, -1.0), DVec3::ONE)]),
        ),
        case(effort, "shiny teapot under 8 lights".into(), teapot(&eight_lights())),
        case(effort, "Suzanne under 8 lights".into(), suzanne(&eight_lights())),
        case(effort, "textured room with two lights".into(), room()),
        case(effort, "columns of few faces under 8 lights".into(), columns()),
        case(effort, format!("knot of {count} faces"), large),
    ]
}

fn eight_lights() -> Vec<Light> {
    let at = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / 8.0;
        DVec3::new(4.0 * libm::cos(angle), 1.0 + 2.0 * f64::from(i % 3), 4.0 * libm::sin(angle))
    };
    let color = |i: u32| DVec3::new(0.1 + 0.2 * f64::from(i % 2), 0.2, 0.3 - 0.2 * f64::from(i % 2));
    (0..8).map(|i| Light::point(at(i), color(i))).collect()
}

fn teapot(lights: &[Light]) -> Scene {
    let pot = object("teapot", shapes::teapot(6).expect("a level of 6"));
    alone(pot, DVec3::new(0.0, 1.0, 2.2), lights)
}

fn suzanne(lights: &[Light]) -> Scene {
    let loaded = obj::parse(fbptr_formats::models::SUZANNE, &mut |_| None, "monkey_head2.obj")
        .expect("a mesh of the program's own");
    alone(object("Suzanne", loaded.geometry.mesh), DVec3::new(0.7, 0.3, 2.2), lights)
}

/// Returns one object in the middle, shiny under more than one light.
fn alone(mut object: Object, eye: DVec3, lights: &[Light]) -> Scene {
    object.material.kd = DVec3::new(0.7, 0.5, 0.3);
    if lights.len() > 1 {
        (object.material.ks, object.material.n) = (DVec3::splat(0.4), 32.0);
    }
    let (low, high) = object.geometry.mesh.bounds().expect("a mesh with positions");
    let scale = 2.4 / (high - low).length();
    object.model = DMat4::from_scale(DVec3::splat(scale)) * DMat4::from_translation(-(low + high) / 2.0);
    let look_at = LookAt { eye, reference: DVec3::ZERO, up: DVec3::Y };
    Scene {
        camera: Some(camera(look_at)),
        lights: lights.to_vec(),
        objects: vec![object],
        ..Scene::default()
    }
}

fn camera(look_at: LookAt) -> Camera {
    let projection = Projection::Perspective { fov_rad: 0.9, near: 0.1, far: 100.0, on_smaller_side: false };
    Camera { look_at, projection }
}

/// Returns a box seen from inside.
fn inside(h: DVec3) -> Mesh {
    let outer = box_mesh(h);
    let mut mesh =
        Mesh { positions: outer.positions.clone(), texcoords: outer.texcoords.clone(), ..Mesh::default() };
    for polygon in &outer.polygons {
        let first = polygon.first_corner as usize;
        let mut corners: Vec<Corner> = outer.corners[first..first + polygon.corner_count as usize].to_vec();
        corners.reverse();
        mesh.push_polygon(&corners, NONE);
    }
    mesh
}

/// Returns a room of brick walls, a box in it, and two lights.
fn room() -> Scene {
    let sampling = Sampling { filter: Filter::Trilinear, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat };
    let mut walls = inside(DVec3::new(3.0, 1.5, 4.0));
    walls.texcoords.iter_mut().for_each(|t| *t *= 6.0);
    let mut objects = vec![object("walls", walls), object("box", box_mesh(DVec3::new(0.5, 0.5, 0.5)))];
    for o in &mut objects {
        o.texture = Some((bricks(), sampling));
        (o.material.kd, o.material.ks) = (DVec3::splat(0.9), DVec3::ZERO);
    }
    objects[1].model = DMat4::from_translation(DVec3::new(0.4, -1.0, 0.0)) * DMat4::from_rotation_y(0.6);
    let look_at =
        LookAt { eye: DVec3::new(-0.8, 0.2, 3.4), reference: DVec3::new(0.4, -0.5, 0.0), up: DVec3::Y };
    let lights = vec![
        Light::point(DVec3::new(1.5, 1.0, 1.0), DVec3::splat(0.6)),
        Light::directional(DVec3::new(0.3, -1.0, -0.5), DVec3::splat(0.4)),
    ];
    Scene { camera: Some(camera(look_at)), lights, objects, ..Scene::default() }
}

/// Returns five boxes on a floor under eight point lights: large faces, so that light at each pixel
/// is most of the work.
fn columns() -> Scene {
    let mut objects = vec![object("floor", box_mesh(DVec3::new(4.0, 0.1, 4.0)))];
    for i in 0..5 {
        let mut column = object("column", box_mesh(DVec3::new(0.4, 1.2, 0.4)));
        let x = f64::from(i) - 2.0;
        column.model = DMat4::from_translation(DVec3::new(1.1 * x, 1.3, -0.6 * x.abs()))
            * DMat4::from_rotation_y(0.4 * x);
        objects.push(column);
    }
    for o in &mut objects {
        (o.material.kd, o.material.ks, o.material.n) = (DVec3::new(0.6, 0.6, 0.5), DVec3::splat(0.3), 24.0);
    }
    let look_at =
        LookAt { eye: DVec3::new(0.5, 2.6, 4.6), reference: DVec3::new(0.0, 0.9, 0.0), up: DVec3::Y };
    Scene { camera: Some(camera(look_at)), lights: eight_lights(), objects, ..Scene::default() }
}

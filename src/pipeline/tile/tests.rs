//! The tile renderer against the plain path: the same coverage, depth and colour, at every width and crew.

use super::*;
use crate::memory::{DepthFormat, VideoMemory};
use crate::pipeline::{DrawCall, Target, draw};
use crate::scene::{
    Camera, Cull, Geometry, Light, LightKind, LightingModel, LookAt, Material, Projection, shapes,
};
use glam::{DMat3, DMat4, DVec3};
use std::sync::Arc;

const WIDTH: usize = 150;
const HEIGHT: usize = 110;

struct Scene {
    geometry: Geometry,
    camera: Camera,
    model: DMat4,
    material: Material,
    light: Light,
}

fn scene() -> Scene {
    let camera = Camera {
        look_at: LookAt { eye: DVec3::new(0.4, 0.3, 5.2), reference: DVec3::ZERO, up: DVec3::Y },
        projection: Projection::Perspective { fov_rad: 1.0, near: 1.0, far: 10.0, on_smaller_side: false },
    };
    let material = Material {
        ka: DVec3::new(0.08, 0.04, 0.02),
        kd: DVec3::new(0.56, 0.28, 0.14),
        ks: DVec3::splat(0.5),
        n: 32.0,
        model: LightingModel::Phong,
        ..Material::default()
    };
    let light = Light {
        kind: LightKind::Point {
            position: DVec3::new(3.0, 4.0, 5.0),
            attenuation: crate::scene::Attenuation::NONE,
            radius: f64::INFINITY,
        },
        color: DVec3::ONE,
        ambient: DVec3::ZERO,
        clamp_attenuation: false,
    };
    let geometry = Geometry { mesh: shapes::knot(160, 24).expect("a knot"), textures: Vec::new() };
    let model = crate::math::matrix::rotate(DVec3::new(1.0, 1.3, 0.2), 0.5).expect("an axis");
    Scene { geometry, camera, model, material, light }
}

/// The plain picture: bytes and depths.
fn plain(scene: &Scene) -> (Vec<u8>, Vec<f64>) {
    let mut memory = VideoMemory::new(WIDTH as u32, HEIGHT as u32).expect("a frame");
    let mut depth = None;
    let lights = [scene.light];
    let call = DrawCall {
        model: scene.model,
        camera: scene.camera,
        ambient: DVec3::ONE,
        lights: &lights,
        cull: Cull::Back,
        ..DrawCall::new(&scene.geometry, &scene.material, WIDTH as u32, HEIGHT as u32)
    };
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
    draw(&mut target, &call).expect("a picture");
    let depth = depth.expect("depth under zbuffer");
    let at = |i: usize| depth.z((i % WIDTH) as i32, (i / WIDTH) as i32).expect("on the frame");
    (memory.bytes().to_vec(), (0..WIDTH * HEIGHT).map(at).collect())
}

/// The tile renderer's picture: bytes and depth words.
fn tiled<C: Crew>(scene: &Scene, level: Level, crew: &C) -> (Vec<u8>, Vec<i32>, TileStats) {
    let mesh = &scene.geometry.mesh;
    let unit = |c: &crate::scene::Corner| {
        crate::math::matrix::unit(mesh.normals[c.normal as usize]).expect("a normal")
    };
    let normals: Vec<DVec3> = mesh.corners.iter().map(unit).collect();
    let prepared = PreparedMesh::new(mesh, &normals);
    let aspect = WIDTH as f64 / HEIGHT as f64;
    let camera = scene.camera.matrices(aspect).expect("a camera");
    let clip = camera.projection * (camera.view * scene.model);
    let half = [WIDTH as f64 / 2.0, HEIGHT as f64 / 2.0];
    let to_screen =
        ToScreen { rows: clip.transpose().to_cols_array_2d(), center: half, half: [half[0], -half[1]] };
    // The shading frame: the eye, and the mesh's own axes.
    let turn = DMat3::from_mat4(scene.model).transpose();
    let view_to_world = DMat3::from_mat4(camera.view).transpose();
    let [x, y] = [camera.projection.x_axis.x, camera.projection.y_axis.y];
    let ray = |column: f64, row: f64| {
        let ndc = [(column + 0.5) / half[0] - 1.0, 1.0 - (row + 0.5) / half[1]];
        turn * (view_to_world * DVec3::new(ndc[0] / x, ndc[1] / y, -1.0))
    };
    let f32s = |v: DVec3| v.as_vec3().to_array();
    let ray = [ray(0.0, 0.0), ray(1.0, 0.0) - ray(0.0, 0.0), ray(0.0, 1.0) - ray(0.0, 0.0)].map(f32s);
    let LightKind::Point { position, .. } = scene.light.kind else { panic!("a point light") };
    let material = &scene.material;
    let lighting = Lighting {
        base: f32s(material.ka),
        emissive: [0.0; 3],
        lights: vec![FastLight {
            place: Place::At(f32s(turn * (position - camera.eye))),
            diffuse: f32s(material.kd),
            specular: f32s(material.ks),
            attenuation: None,
        }],
        exponent: Exponent::new(material.n).expect("a small exponent"),
        model: material.model,
    };
    let shading = Shading {
        mode: Mode::Phong,
        eye: Eye::Perspective { ray },
        lighting: &lighting,
        normals: &prepared.normals,
        colors: &[],
        positions: &[],
        slenderest: 4096.0,
        is_affine: false,
        plain: &|face, _, _| panic!("face {face} is no sliver"),
    };
    let job = Job {
        mesh: &prepared,
        to_screen,
        keep: Keep::CounterClockwise,
        view: View { x0: 0, y0: 0, x1: WIDTH as i32, y1: HEIGHT as i32 },
        shading,
        plain_face: &|face, _, _| panic!("face {face} needs no plain path"),
    };
    let mut bytes = VideoMemory::CLEAR.repeat(WIDTH * HEIGHT);
    let mut depth = vec![1f32.to_bits() as i32; WIDTH * HEIGHT];
    let mut scratch = Scratch::default();
    let mut frame = Frame { width: WIDTH, bytes: &mut bytes, depth: &mut depth };
    let stats = render(level, crew, &mut scratch, &job, &mut frame);
    (bytes, depth, stats)
}

#[test]
fn a_lit_mesh_is_the_plain_path_within_its_limits() {
    let scene = scene();
    let (bytes, depths) = plain(&scene);
    let (fast, words, stats) = tiled(&scene, Level::best(), &Alone);
    assert!(stats.shaded > 2000, "{stats:?}");
    let mut worst = (0, 0.0f64);
    let mut beyond_limit = 0;
    for (i, &z) in depths.iter().enumerate() {
        let word = f32::from_bits(words[i] as u32) as f64;
        assert_eq!(z == 1.0, word == 1.0, "coverage of pixel {i}");
        worst.1 = worst.1.max((z - word).abs());
        beyond_limit += ((z - word).abs() > 4e-7) as u64;
        let pixel = |from: &[u8]| <[u8; 4]>::try_from(&from[i * 4..i * 4 + 4]).expect("4 bytes");
        let (a, b) = (pixel(&bytes), pixel(&fast));
        worst.0 = worst.0.max((0..4).map(|c| a[c].abs_diff(b[c])).max().expect("4 channels"));
    }
    // Where a centre lies outside the true face, by less than 1/256 pixel, the plain path clamps and this one extrapolates:
    // both are right, and on a steep face that is more than the limit.
    assert!(
        worst.0 <= 1 && worst.1 <= 5e-6 && beyond_limit * 1000 <= stats.shaded,
        "{worst:?}, {beyond_limit}"
    );
}

#[test]
fn every_width_and_every_crew_gives_the_same_bytes() {
    let scene = scene();
    let first = tiled(&scene, Level::Portable, &Alone);
    for level in Level::ALL {
        for threads in [1, 2, 3, 16] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let other = tiled(&scene, level, &Pool(Arc::new(pool)));
            assert!(other == first, "{level:?} with {threads} threads");
        }
    }
}

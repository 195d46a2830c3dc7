//! Every row of the specification's table of hard cases that a draw can meet, by name, compared
//! with the truth where the row asks for more than "no panic".

mod geometry;
mod machines;
mod textures;
mod values;

use fbptr::math::matrix;
use fbptr::memory::{DepthFormat, DepthMemory, VideoMemory};
use fbptr::pipeline::{self, DrawCall, DrawStats, SceneOptions, Target};
use fbptr::scene::*;
use fbptr::truth::compare::compare;
use fbptr::truth::scenes::{object, terrain};
use fbptr::truth::{Settings, Transparency, TruthPicture};
use glam::{DVec2, DVec3};
use std::sync::Arc;
use std::time::{Duration, Instant};

const ORIGIN_VIEW: LookAt = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };

/// Returns a camera at the origin that looks along -z with an angle of 90 degrees.
fn eye_at_origin(near: f64, far: f64) -> Camera {
    let fov_rad = std::f64::consts::FRAC_PI_2;
    let projection = Projection::Perspective { fov_rad, near, far, on_smaller_side: false };
    Camera { look_at: ORIGIN_VIEW, projection }
}

/// Returns a parallel camera under which x and y are pixels, y up from the middle of a frame of
/// `size` pixels; z from 0 to -10.
fn pixel_camera(size: u32) -> Camera {
    let h = size as f64 / 2.0;
    Camera {
        look_at: ORIGIN_VIEW,
        projection: Projection::Ortho { window: [-h, h, -h, h], near: 0.0, far: 10.0 },
    }
}

fn glowing(color: DVec3) -> Material {
    Material { emissive: color, kd: DVec3::ZERO, ..Material::default() }
}

fn lamp(position: DVec3) -> Light {
    Light::point(position, DVec3::ONE)
}

fn triangle(points: [[f64; 3]; 3]) -> Mesh {
    Mesh::from_triangles(points.map(DVec3::from).to_vec(), &[[0, 1, 2]])
}

/// Returns an object that is drawn from both sides.
fn both_sides(mesh: Mesh, material: Material) -> Object {
    Object { material, cull: Cull::None, ..object("thing", mesh) }
}

struct Drawn {
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    stats: DrawStats,
}

impl Drawn {
    fn lit_pixels(&self) -> usize {
        self.memory.bytes().as_chunks::<4>().0.iter().filter(|p| p[..3] != [0; 3]).count()
    }
}

fn draw(scene: &Scene, size: u32, format: DepthFormat, settings: &Settings) -> Drawn {
    let mut memory = VideoMemory::new(size, size).unwrap();
    let mut depth = None;
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: None };
    let mut options = SceneOptions::new(size, size);
    options.viewport = settings.viewport.unwrap_or(options.viewport);
    (options.shade, options.hide, options.interp) = (settings.shade, settings.hide, settings.interpolation);
    let stats = pipeline::draw_scene(&mut target, scene, &options).unwrap();
    Drawn { memory, depth, stats }
}

/// Draws a scene, and compares every pixel with the truth.
#[track_caller]
fn draw_right(scene: &Scene, size: u32, settings: &Settings) -> Drawn {
    let settings =
        Settings { transparency: Transparency::AfterOpaque(TransparencyOrder::FileOrder), ..*settings };
    let drawn = draw(scene, size, DepthFormat::F32, &settings);
    let mut truth = TruthPicture::new(size, size, DepthFormat::F32);
    truth.draw(scene, &settings).unwrap();
    let report = compare(&drawn.memory, drawn.depth.as_ref(), &truth);
    assert!(report.is_right(), "{report}");
    drawn
}

fn scene(camera: Camera, objects: Vec<Object>) -> Scene {
    Scene {
        camera: Some(camera),
        ambient: DVec3::splat(0.3),
        lights: vec![lamp(DVec3::new(1.0, 2.0, 0.5))],
        objects,
        ..Scene::default()
    }
}

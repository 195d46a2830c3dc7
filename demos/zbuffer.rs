//! The contents of a z-buffer. Left: a knot with a ball that it passes through, drawn in any order. Right: the
//! depth of every pixel as a map, near gold and far blue, with contour lines of equal depth.

mod common;

use common::look::{BLUE, CORAL, GOLD, LESSER, PAPER, TEAL, mixed};
use common::{Motion, show};
use fbptr::memory::{DepthFormat, VideoMemory};
use fbptr::pipeline::{DrawCall, Target, draw};
use fbptr::scene::{Camera, Geometry, Light, LookAt, Material, Projection, ShadeMode, shapes};
use glam::{DMat4, DVec3};
use std::process::ExitCode;

const SIDE: u32 = 300;
const NEAR: f64 = 3.5;
const FAR: f64 = 9.5;

/// Returns the distance from the eye along the view of a depth from 0 to 1 (a perspective camera).
fn distance(z: f64) -> f64 {
    NEAR * FAR / (FAR - z * (FAR - NEAR))
}

/// Returns the color of the map at a distance: contour lines are dark.
fn map_color(distance: f64) -> [u8; 4] {
    let part = ((distance - 4.2) / 3.4).clamp(0.0, 1.0);
    let stops = [GOLD, CORAL, TEAL, BLUE, BLUE];
    let color = mixed(stops[(part * 3.0) as usize], stops[(part * 3.0) as usize + 1], (part * 3.0).fract());
    let off_line = ((distance * 6.0).fract() - 0.5).abs() * 2.0;
    mixed(color, PAPER, if off_line > 0.86 { 0.75 } else { 0.35 * part })
}

fn main() -> ExitCode {
    let geometry = Geometry::from(shapes::knot(260, 22).expect("a knot"));
    let ball = Geometry::from(shapes::sphere(0.75).expect("a sphere"));
    show("z-buffer", [2 * SIDE, SIDE + 24], Motion::Moving, move |client, frame| {
        let turn = DMat4::from_rotation_y(0.3 + frame as f64 * 0.02);
        let look_at = LookAt { eye: DVec3::new(0.0, 1.2, 6.0), reference: DVec3::ZERO, up: DVec3::Y };
        let projection =
            Projection::Perspective { fov_rad: 0.62, near: NEAR, far: FAR, on_smaller_side: false };
        let lights = [
            Light::directional(DVec3::new(0.7, -0.9, -1.0), DVec3::new(0.9, 0.86, 0.78)),
            Light::directional(DVec3::new(-1.0, -0.1, -0.6), DVec3::new(0.16, 0.24, 0.4)),
        ];
        let (mut memory, mut depth) = (VideoMemory::new(SIDE, SIDE).expect("a frame"), None);
        memory.clear(PAPER);
        for (geometry, kd) in [(&geometry, DVec3::new(1.0, 0.69, 0.2)), (&ball, DVec3::new(0.36, 0.55, 1.0))]
        {
            let material = Material { ka: kd, kd, ks: DVec3::splat(0.4), n: 30.0, ..Material::default() };
            let call = DrawCall {
                model: turn,
                camera: Camera { look_at, projection },
                lights: &lights,
                ambient: DVec3::splat(0.12),
                shade: ShadeMode::Phong,
                ..DrawCall::new(geometry, &material, SIDE, SIDE)
            };
            let mut target =
                Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
            draw(&mut target, &call).expect("both can be drawn");
        }
        let depth = depth.expect("the z-buffer needs depths");
        let map = |i: u32| match depth.z((i % SIDE) as i32, (i / SIDE) as i32) {
            Some(z) if z < 1.0 => map_color(distance(z)),
            _ => PAPER,
        };
        let side = SIDE as i32;
        client.clear(PAPER);
        client.blit([0, 0, side, side], memory.bytes().to_vec());
        client.blit([side, 0, side, side], (0..SIDE * SIDE).flat_map(map).collect());
        client.text([16, side + 2], "a ball in a knot, in any order", LESSER);
        client.text([side + 16, side + 2], "what the z-buffer holds", LESSER);
        Ok(())
    })
}

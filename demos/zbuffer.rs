//! The z-buffer while it fills. Left: the picture. Right: the depth of every pixel, near white and
//! far dark, as the teapot's faces are added in an arbitrary order.

mod common;

use common::{Motion, show};
use fbptr::memory::{DepthFormat, VideoMemory};
use fbptr::pipeline::{DrawCall, Target, draw};
use fbptr::scene::{Camera, Geometry, Light, LookAt, Material, Projection, shapes};
use glam::DVec3;
use std::process::ExitCode;

const SIDE: u32 = 240;
const FACES_A_FRAME: usize = 24;

fn main() -> ExitCode {
    let mut mesh = shapes::teapot(6).expect("a teapot");
    // Every 37th face (a prime), wrapping around, so that neighbours are drawn at different times.
    let count = mesh.triangles.len();
    let step =
        [37, 41, 43].into_iter().find(|p| !count.is_multiple_of(*p)).expect("not all of them divide it");
    let shuffle = |i: usize| i * step % count;
    let triangles: Vec<[u32; 3]> = (0..count).map(|i| mesh.triangles[shuffle(i)]).collect();
    let polygons: Vec<u32> = (0..count).map(|i| mesh.triangle_polygon[shuffle(i)]).collect();
    show("z-buffer", [2 * SIDE, SIDE + 16], Motion::Moving, move |client, frame| {
        let shown = FACES_A_FRAME + frame as usize * FACES_A_FRAME % (count + 60 * FACES_A_FRAME);
        mesh.triangles = triangles[..shown.min(count)].to_vec();
        mesh.triangle_polygon = polygons[..shown.min(count)].to_vec();
        let geometry = Geometry { mesh: mesh.clone(), ..Default::default() };
        let material = Material { kd: DVec3::new(0.9, 0.6, 0.3), ..Material::default() };
        let light = Light::directional(DVec3::new(-1.0, -1.5, -2.0), DVec3::ONE);
        let look_at =
            LookAt { eye: DVec3::new(2.0, 4.5, 8.0), reference: DVec3::new(0.2, 1.4, 0.0), up: DVec3::Y };
        let projection =
            Projection::Perspective { fov_rad: 0.95, near: 5.0, far: 13.0, on_smaller_side: false };
        let call = DrawCall {
            camera: Camera { look_at, projection },
            lights: &[light],
            ..DrawCall::new(&geometry, &material, SIDE, SIDE)
        };
        let (mut memory, mut depth) = (VideoMemory::new(SIDE, SIDE).expect("a frame"), None);
        let mut target =
            Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
        draw(&mut target, &call).expect("the teapot can be drawn");
        client.clear([0, 0, 0, 255]);
        client.blit([0, 0, SIDE as i32, SIDE as i32], memory.bytes().to_vec());
        let depth = depth.expect("the z-buffer needs depths");
        let z = |i: u32| depth.z((i % SIDE) as i32, (i / SIDE) as i32).expect("inside");
        let gray = |i: u32| {
            // A depth that was never written is 1; the teapot lies between 0.4 and 0.9.
            let v = if z(i) < 1.0 { (255.0 * (1.0 - z(i)) / 0.62).clamp(20.0, 255.0) as u8 } else { 0 };
            [v, v, v, 255]
        };
        client.blit([SIDE as i32, 0, SIDE as i32, SIDE as i32], (0..SIDE * SIDE).flat_map(gray).collect());
        let text = format!("{} of {count} faces", shown.min(count));
        client.text([8, SIDE as i32 + 4], &text, [170, 170, 170, 255]);
        client.text([SIDE as i32 + 8, SIDE as i32 + 4], "what the z-buffer holds", [170, 170, 170, 255]);
        Ok(())
    })
}

//! Newell's teapot, for the demos that compare shading methods.

use super::look::{LESSER, PAPER};
use fbptr::command::{Command, LightCommand, MeshSource};
use fbptr::error::Fault;
use fbptr::scene::{Attenuation, Cull, Material, Projection, ShadeMode, ViewportRule};
use fbptr::server::Client;
use glam::DVec3;

/// Size of the demos' frame.
pub const SIZE: [u32; 2] = [640, 300];

/// Returns a point light without attenuation.
fn light(position: [f64; 3], color: [f64; 3]) -> LightCommand {
    let (position, color) = (DVec3::from(position), DVec3::from(color));
    LightCommand::Point { position, color, attenuation: Attenuation::NONE }
}

/// Draws a frame of the rotating teapot, coarsely tessellated: on the left shaded, on the right the
/// same faces as wires.
pub fn teapot(client: &Client, frame: u64, shade: ShadeMode, caption: &str) -> Result<(), Fault> {
    if frame == 0 {
        client.mesh("teapot", MeshSource::Teapot(4));
        client.look_at(DVec3::new(0.25, 4.2, 8.0), DVec3::new(0.35, 1.4, 0.0), DVec3::Y);
        client.projection(Projection::Perspective {
            fov_rad: 0.74,
            near: 1.0,
            far: 30.0,
            on_smaller_side: false,
        });
        client.ambient(DVec3::splat(0.14));
        client.light(0, light([-5.0, 8.0, 7.0], [0.95, 0.9, 0.8]));
        client.light(1, light([8.0, 2.0, 5.0], [0.2, 0.35, 0.6]));
        client.light(2, light([3.0, 6.0, -9.0], [0.5, 0.6, 0.8]));
    }
    client.clear(PAPER);
    client.identity();
    client.rotate(DVec3::Y, -0.4 + frame as f64 * 0.02);
    for (x, is_wire) in [(0, false), (SIZE[0] as i32 / 2, true)] {
        client.viewport([x, 0, SIZE[0] as i32 / 2, 276], ViewportRule::Corners);
        let gold = DVec3::new(0.95, 0.62, 0.18);
        let material = match is_wire {
            false => Material { ka: gold, kd: gold, ks: DVec3::splat(0.85), n: 48.0, ..Material::default() },
            true => Material { kd: DVec3::new(0.18, 0.77, 0.71), ..Material::default() },
        };
        client.material(material);
        client.shade(if is_wire { ShadeMode::Wire } else { shade });
        client.cull(Cull::Back);
        client.draw("teapot");
    }
    client.text([16, 280], caption, LESSER);
    client.text([SIZE[0] as i32 / 2 + 16, 280], "its faces", LESSER);
    client.send(Command::Cull(Cull::default()));
    Ok(())
}

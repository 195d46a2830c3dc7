//! Newell's teapot, for the demos that compare shading methods.

use fbptr::command::{Command, LightCommand, MeshSource};
use fbptr::error::Fault;
use fbptr::scene::{Attenuation, Material, ShadeMode};
use fbptr::server::Client;
use glam::DVec3;

/// Draws a frame of the rotating teapot, coarsely tessellated.
pub fn teapot(client: &Client, frame: u64, shade: ShadeMode) -> Result<(), Fault> {
    if frame == 0 {
        client.mesh("teapot", MeshSource::Teapot(6));
        client.look_at(DVec3::new(0.0, 4.2, 8.0), DVec3::new(0.2, 1.3, 0.0), DVec3::Y);
        client.send(Command::Shade(shade));
        client.send(Command::Ambient(DVec3::splat(0.15)));
        let light = LightCommand::Point {
            position: DVec3::new(5.0, 9.0, 7.0),
            color: DVec3::ONE,
            attenuation: Attenuation::NONE,
        };
        client.send(Command::Light { index: 0, light: Box::new(light) });
        client.send(Command::Material(Box::new(Material {
            ka: DVec3::new(0.9, 0.55, 0.2),
            kd: DVec3::new(0.9, 0.55, 0.2),
            ks: DVec3::splat(0.7),
            n: 60.0,
            ..Material::default()
        })));
    }
    client.clear([24, 28, 40, 255]);
    client.send(Command::Identity);
    client.rotate(DVec3::Y, -0.4 + frame as f64 * 0.02);
    client.draw("teapot");
    Ok(())
}

//! A rotating wireframe cube: object to world to view to clip space to pixels, and nothing else.

mod common;

use common::{Motion, show};
use fbptr::command::{Command, MeshSource};
use fbptr::scene::{Cull, HiddenSurface, Material, ShadeMode};
use glam::DVec3;
use std::process::ExitCode;

fn main() -> ExitCode {
    show("wire cube", [320, 240], Motion::Moving, |client, frame| {
        if frame == 0 {
            client.mesh("cube", MeshSource::Box(DVec3::splat(2.0)));
            client.look_at(DVec3::new(0.0, 1.0, 5.0), DVec3::ZERO, DVec3::Y);
            client.send(Command::Shade(ShadeMode::Wire));
            // All edges, including those behind.
            client.send(Command::Cull(Cull::None));
            client.send(Command::Hide(HiddenSurface::None));
            // Wires have the diffuse colour of their material, with or without lights.
            let green = Material { kd: DVec3::new(0.3, 1.0, 0.4), ..Material::default() };
            client.send(Command::Material(Box::new(green)));
        }
        client.clear([0, 0, 0, 255]);
        client.send(Command::Identity);
        client.rotate(DVec3::new(1.0, 2.0, 0.5), 0.6 + frame as f64 * 0.02);
        client.draw("cube");
        client.text([8, 224], "12 edges, each once", [120, 120, 120, 255]);
        Ok(())
    })
}

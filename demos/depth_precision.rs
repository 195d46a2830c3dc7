//! Depth precision at near = 0.01 and far = 1000: a red and a blue wall at distance 400 cross in
//! the middle of each picture. The range beyond 10 has only the last 0.1 % of a perspective depth;
//! the pictures show which formats still separate red from blue there.

mod common;

use common::{Motion, show};
use fbptr::command::{Command, MeshSource, Rect};
use fbptr::memory::DepthFormat;
use fbptr::scene::{Cull, Material, Projection, ViewportRule};
use glam::DVec3;
use std::process::ExitCode;

const SIZE: [i32; 2] = [220, 120];
/// Two walls that lean back and cross in a vertical line, 8 apart at their left and right ends.
const RED: &[u8] = b"v -500 -300 -376\nv 500 -300 -384\nv 500 300 -424\nv -500 300 -416\nf 1 2 3 4\n";
const BLUE: &[u8] = b"v -500 -300 -384\nv 500 -300 -376\nv 500 300 -416\nv -500 300 -424\nf 1 2 3 4\n";

fn main() -> ExitCode {
    let size = [2 * SIZE[0] as u32, 2 * (SIZE[1] as u32 + 16)];
    show("depth precision", size, Motion::Still, |client, _| {
        client.mesh("red", MeshSource::Obj(RED.to_vec()));
        client.mesh("blue", MeshSource::Obj(BLUE.to_vec()));
        client.look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y);
        let projection =
            Projection::Perspective { fov_rad: 1.0, near: 0.01, far: 1000.0, on_smaller_side: false };
        client.send(Command::Projection(Box::new(projection)));
        client.send(Command::Cull(Cull::None));
        client.clear([20, 22, 30, 255]);
        let formats = [
            (DepthFormat::U16, "16 bits"),
            (DepthFormat::U24, "24 bits"),
            (DepthFormat::F32, "32-bit float"),
            (DepthFormat::Reversed, "reversed 32-bit float"),
        ];
        for (i, (format, name)) in (0..).zip(formats) {
            let (x, y) = (i % 2 * SIZE[0], i / 2 * (SIZE[1] + 16));
            let rect = Rect { x: x + 4, y: y + 4, w: SIZE[0] - 8, h: SIZE[1] - 4 };
            client.send(Command::Viewport { rect, rule: ViewportRule::Corners });
            client.send(Command::Depth(format));
            for (wall, emissive) in [("red", DVec3::new(0.9, 0.2, 0.2)), ("blue", DVec3::new(0.25, 0.4, 1.0))]
            {
                let paint = Material { emissive, kd: DVec3::ZERO, ..Material::default() };
                client.send(Command::Material(Box::new(paint)));
                client.draw(wall);
            }
            client.text([x + 8, y + SIZE[1] + 4], name, [200, 200, 200, 255]);
        }
        Ok(())
    })
}

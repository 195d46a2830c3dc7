//! Depth precision at near = 0.01 and far = 1000: a red and a blue wall at distance 400 cross in
//! the middle of each picture. The range beyond 10 has only the last 0.1 % of a perspective depth;
//! the pictures show which formats still separate red from blue there.

mod common;

use common::look::{LESSER, MARGIN, PAPER};
use common::{Motion, show};
use fbptr::command::{Command, MeshSource, Rect};
use fbptr::memory::DepthFormat;
use fbptr::scene::{Cull, Material, Projection, ViewportRule};
use glam::DVec3;
use std::process::ExitCode;

const SIZE: [i32; 2] = [220, 120];
/// Rows below each picture: a gap, a caption, and the margin.
const BELOW: i32 = 8 + 8 + MARGIN;
/// Two walls that lean back and cross in a vertical line, 8 apart at their left and right ends.
const RED: &[u8] = b"v -500 -300 -376\nv 500 -300 -384\nv 500 300 -424\nv -500 300 -416\nf 1 2 3 4\n";
const BLUE: &[u8] = b"v -500 -300 -384\nv 500 -300 -376\nv 500 300 -416\nv -500 300 -424\nf 1 2 3 4\n";

fn main() -> ExitCode {
    let size = [2 * SIZE[0] + 3 * MARGIN, MARGIN + 2 * (SIZE[1] + BELOW)].map(|n| n as u32);
    show("depth precision", size, Motion::Still, |client, _| {
        client.mesh("red", MeshSource::Obj(RED.to_vec()));
        client.mesh("blue", MeshSource::Obj(BLUE.to_vec()));
        client.look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y);
        let projection =
            Projection::Perspective { fov_rad: 1.0, near: 0.01, far: 1000.0, on_smaller_side: false };
        client.send(Command::Projection(Box::new(projection)));
        client.send(Command::Cull(Cull::None));
        client.clear(PAPER);
        let formats = [
            (DepthFormat::U16, "16 bits"),
            (DepthFormat::U24, "24 bits"),
            (DepthFormat::F32, "32-bit float"),
            (DepthFormat::Reversed, "reversed 32-bit float"),
        ];
        for (i, (format, name)) in (0..).zip(formats) {
            let (x, y) = (MARGIN + i % 2 * (SIZE[0] + MARGIN), MARGIN + i / 2 * (SIZE[1] + BELOW));
            let rect = Rect { x, y, w: SIZE[0], h: SIZE[1] };
            client.send(Command::Viewport { rect, rule: ViewportRule::Corners });
            client.send(Command::Depth(format));
            let walls = [("red", DVec3::new(1.0, 0.365, 0.365)), ("blue", DVec3::new(0.357, 0.549, 1.0))];
            for (wall, emissive) in walls {
                let paint = Material { emissive, kd: DVec3::ZERO, ..Material::default() };
                client.send(Command::Material(Box::new(paint)));
                client.draw(wall);
            }
            client.text([x, y + SIZE[1] + 8], name, LESSER);
        }
        Ok(())
    })
}

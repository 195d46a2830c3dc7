//! Transparency in both orders: two transparent panes, red before blue. Drawn far to near, each
//! pane tints what is behind it; drawn near to far, the blue one is blended over the red one, as if
//! it stood in front.

mod common;

use common::look::{LESSER, MARGIN, PAPER};
use common::{Motion, show};
use fbptr::command::{Command, MeshSource, Rect};
use fbptr::scene::{Cull, Material, ViewportRule};
use glam::DVec3;
use std::process::ExitCode;

const SIDE: i32 = 220;
const PANE: &[u8] = b"v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";

fn main() -> ExitCode {
    show("transparency", [2 * SIDE as u32, SIDE as u32 + 24], Motion::Moving, |client, frame| {
        if frame == 0 {
            client.mesh("pane", MeshSource::Obj(PANE.to_vec()));
            client.mesh("ball", MeshSource::Sphere(0.55));
            client.look_at(DVec3::new(1.2, 0.9, 5.0), DVec3::ZERO, DVec3::Y);
            client.send(Command::Cull(Cull::None));
        }
        let swing = 0.35 * libm::sin(frame as f64 * 0.03);
        let red = (DVec3::new(-0.3, 0.2, 0.9 + swing), DVec3::new(1.0, 0.365, 0.365));
        let blue = (DVec3::new(0.4, -0.2, -0.9 - swing), DVec3::new(0.357, 0.549, 1.0));
        client.clear(PAPER);
        let halves = [(0, [blue, red], "far, then near"), (SIDE, [red, blue], "near, then far")];
        for (x, panes, name) in halves {
            let rect = Rect { x, y: 0, w: SIDE, h: SIDE };
            client.send(Command::Viewport { rect, rule: ViewportRule::Corners });
            // Opaque objects first: they hide transparent ones, which hide nothing themselves.
            let gold =
                Material { emissive: DVec3::new(1.0, 0.69, 0.0), kd: DVec3::ZERO, ..Material::default() };
            client.send(Command::Material(Box::new(gold)));
            client.send(Command::Identity);
            client.draw("ball");
            for (place, emissive) in panes {
                let glass = Material { emissive, transparency: 0.4, kd: DVec3::ZERO, ..Material::default() };
                client.send(Command::Material(Box::new(glass)));
                client.send(Command::Identity);
                client.send(Command::Translate(place));
                client.draw("pane");
            }
            client.text([x + MARGIN, SIDE], name, LESSER);
        }
        Ok(())
    })
}

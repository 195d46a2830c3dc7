//! Affine and perspective texture mapping of one floor of two triangles. Left: u and v are
//! interpolated linearly on the screen, as old consoles did. Right: u/w, v/w and 1/w are, with a
//! division at every pixel.

mod common;

use common::look::{LESSER, MARGIN, PAPER};
use common::{Motion, show};
use fbptr::command::{Command, MeshSource, Rect};
use fbptr::scene::{Filter, Interpolation, Material, Sampling, ViewportRule, Wrap};
use glam::DVec3;
use std::process::ExitCode;

const SIDE: i32 = 240;
const FLOOR: &[u8] =
    b"v -2 0 2\nv 2 0 2\nv 2 0 -6\nv -2 0 -6\nvt 0 0\nvt 4 0\nvt 4 8\nvt 0 8\nf 1/1 2/2 3/3 4/4\n";

/// Encodes a checkerboard of 2x2 squares, 32x32 pixels, as a PPM file.
fn checks() -> Vec<u8> {
    let texel = |i: u32| {
        let is_light = (i % 32 / 16 + i / 32 / 16).is_multiple_of(2);
        if is_light { [255, 176, 0] } else { [31, 58, 95] }
    };
    b"P6 32 32 255\n".iter().copied().chain((0..32 * 32).flat_map(texel)).collect()
}

fn main() -> ExitCode {
    show("affine texture", [2 * SIDE as u32, SIDE as u32 + 24], Motion::Moving, |client, frame| {
        if frame == 0 {
            client.mesh("floor", MeshSource::Obj(FLOOR.to_vec()));
            client.send(Command::Texture { name: "checks".into(), file: checks() });
            let sampling = Sampling { filter: Filter::Nearest, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat };
            client.send(Command::UseTexture { name: Some("checks".into()), sampling });
            client.send(Command::Ambient(DVec3::ONE));
            let paper = Material { ka: DVec3::ONE, kd: DVec3::ZERO, ..Material::default() };
            client.send(Command::Material(Box::new(paper)));
            client.look_at(DVec3::new(0.0, 1.3, 4.0), DVec3::new(0.0, 0.0, 0.0), DVec3::Y);
        }
        client.clear(PAPER);
        client.send(Command::Identity);
        client.rotate(DVec3::Y, 0.25 * libm::sin(frame as f64 * 0.02 + 0.8));
        let halves =
            [(0, Interpolation::Affine, "affine"), (SIDE, Interpolation::Perspective, "perspective")];
        for (x, interp, name) in halves {
            let rect = Rect { x, y: 0, w: SIDE, h: SIDE };
            client.send(Command::Viewport { rect, rule: ViewportRule::Corners });
            client.send(Command::Interp(interp));
            client.draw("floor");
            client.text([x + MARGIN, SIDE], name, LESSER);
        }
        Ok(())
    })
}

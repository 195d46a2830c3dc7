//! A case in which the painter's algorithm fails and the z-buffer does not: three bars, each over
//! the next and under the one before. No order of the bars draws them correctly; the z-buffer decides
//! per pixel.

mod common;

use common::look::{LESSER, MARGIN, PAPER};
use common::{Motion, show};
use fbptr::command::{Command, MeshSource, Rect};
use fbptr::scene::{Cull, HiddenSurface, Material, ViewportRule};
use glam::DVec3;
use std::process::ExitCode;

const SIDE: i32 = 240;

/// Returns an OBJ file of three slanted bars around a centre, coloured at their vertices.
fn bars() -> Vec<u8> {
    let mut obj = String::new();
    for (i, color) in (0..).zip(["1 .36 .36", "1 .69 0", ".36 .55 1"]) {
        let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::TAU / 3.0);
        // A bar along x, low at its left end and high at its right one, beside the centre and
        // rotated about it.
        for (x, y, z) in [(-1.5, -0.8, -0.5), (1.5, -0.8, 0.5), (1.5, -0.35, 0.5), (-1.5, -0.35, -0.5)] {
            obj += &format!("v {} {} {z} {color}\n", x * cos - y * sin, x * sin + y * cos);
        }
        obj += "f -4 -3 -2 -1\n";
    }
    obj.into_bytes()
}

fn main() -> ExitCode {
    show("painter", [2 * SIDE as u32, SIDE as u32 + 24], Motion::Moving, |client, frame| {
        if frame == 0 {
            client.mesh("bars", MeshSource::Obj(bars()));
            client.look_at(DVec3::new(0.0, 0.0, 5.4), DVec3::ZERO, DVec3::Y);
            client.send(Command::Cull(Cull::None));
            client.send(Command::Ambient(DVec3::ONE));
            let paper = Material { ka: DVec3::ONE, kd: DVec3::ZERO, ..Material::default() };
            client.send(Command::Material(Box::new(paper)));
        }
        client.clear(PAPER);
        client.send(Command::Identity);
        client.rotate(DVec3::Z, 0.3 + frame as f64 * 0.01);
        let halves = [(0, HiddenSurface::Painter, "painter"), (SIDE, HiddenSurface::ZBuffer, "z-buffer")];
        for (x, hide, name) in halves {
            let rect = Rect { x, y: 0, w: SIDE, h: SIDE };
            client.send(Command::Viewport { rect, rule: ViewportRule::Corners });
            client.send(Command::Hide(hide));
            client.draw("bars");
            client.text([x + MARGIN, SIDE], name, LESSER);
        }
        Ok(())
    })
}

//! A crystal of wireframe cubes: object to world to view to clip space to pixels, and nothing else.
//!
//! Each cube is the same mesh, drawn with a matrix and a colour of its own, from far to near: no
//! depth is stored, and none is needed. The wave that runs through the crystal turns the cubes.

mod common;

use common::look::{BLUE, GOLD, LESSER, PAPER, TEAL, mixed};
use common::{Motion, show};
use fbptr::command::{Command, MeshSource};
use fbptr::memory::Rgba;
use fbptr::scene::{Cull, HiddenSurface, Material, ShadeMode};
use glam::{DMat3, DVec3};
use std::process::ExitCode;

const SIDE: i32 = 5;

/// Returns a material whose wires have a colour, with or without lights.
fn wire([r, g, b, _]: Rgba) -> Box<Material> {
    Box::new(Material { kd: DVec3::new(r.into(), g.into(), b.into()) / 255.0, ..Material::default() })
}

fn main() -> ExitCode {
    show("wire cube", [480, 400], Motion::Moving, |client, frame| {
        let eye = DVec3::new(0.0, 3.2, 11.5);
        if frame == 0 {
            client.mesh("cube", MeshSource::Box(DVec3::ONE));
            client.look_at(eye, DVec3::new(0.0, -0.75, 0.0), DVec3::Y);
            client.send(Command::Shade(ShadeMode::Wire));
            // All edges, including those behind.
            client.send(Command::Cull(Cull::None));
            client.send(Command::Hide(HiddenSurface::None));
        }
        client.clear(PAPER);
        let time = frame as f64 * 0.02;
        let turn = DMat3::from_rotation_y(0.5 + time * 0.5);
        let half = SIDE / 2;
        let steps = || -half..=half;
        let mut places: Vec<DVec3> = steps()
            .flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])))
            .map(|place| turn * DVec3::from(place.map(f64::from)) * 1.25)
            .collect();
        places.sort_by(|a, b| b.distance_squared(eye).total_cmp(&a.distance_squared(eye)));
        for place in places {
            // Near cubes are gold, far ones sink into the paper.
            let far = ((place.distance(eye) - 7.6) / 8.6).clamp(0.0, 1.0);
            let hue =
                if far < 0.4 { mixed(GOLD, TEAL, far / 0.4) } else { mixed(TEAL, BLUE, (far - 0.4) / 0.6) };
            client.send(Command::Material(wire(mixed(hue, PAPER, 0.85 * far))));
            let wave = libm::sin(place.length() * 1.1 - time * 3.0);
            client.identity();
            client.translate(place);
            client.rotate(DVec3::new(1.0, 2.0, 0.5), wave * 0.9);
            client.scale(DVec3::splat(0.62 + 0.26 * wave));
            client.draw("cube");
        }
        client.text([16, 380], "125 cubes of 12 edges, far to near", LESSER);
        Ok(())
    })
}

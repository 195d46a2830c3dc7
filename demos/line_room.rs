//! A three-dimensional room on a one-dimensional screen, explored with keys: W and S move forward
//! and back, A and D turn, Q and E look up and down (the hidden axis), while held. Every row of the
//! frame is the line that the eye saw, the newest at the bottom, so the path becomes a picture.
//! Until the first key the eye moves by itself.

mod common;

use common::{Motion, show};
use fbptr::command::Command;
use fbptr::eye::shapes::{DemoScene, PALETTE, cross_polytope, cube};
use fbptr::eye::{self, EyeLightKind, EyeScene, Falloff, Pose, Rotation};
use fbptr::input::InputEvent;
use std::collections::BTreeSet;
use std::process::ExitCode;

const WIDTH: i32 = 480;
const ROWS: i32 = 320;

/// Builds a closed room with three solids, the eye and two lights.
fn room() -> EyeScene {
    let demo = DemoScene { pixels: vec![WIDTH as u32], aperture_tan: 0.35, turns: vec![] };
    let walls = cube(3).expect("a cube").placed(6.0, &[0.0; 3]);
    let mut parts = demo.scene(walls).expect("a room").into_parts();
    for (i, at) in [[2.0, 1.5, 0.0], [-1.0, -2.5, 0.3], [-3.0, 2.5, -0.2]].into_iter().enumerate() {
        let thing = if i == 1 { cube(3) } else { cross_polytope(3) };
        let thing = thing.expect("a thing of 3 dimensions").turned(0, 1, 25.0).placed(0.9, &at);
        parts.facets.extend(thing.facets(|cell| PALETTE[(cell as usize + i) % PALETTE.len()]));
    }
    for (light, at) in parts.lights.iter_mut().zip([[0.5, -0.5, 3.0], [-4.0, 4.0, -2.0]]) {
        light.kind = EyeLightKind::Radial { position: at.to_vec() };
        light.falloff = Falloff { k: 7.0, n: 1.0 };
    }
    parts.size = vec![2.0];
    parts.pose =
        Pose { position: vec![0.0, -4.3, 0.0], rotations: vec![Rotation { a: 0, b: 1, angle_deg: 90.0 }] };
    parts.view = Falloff { k: 7.0, n: 1.0 };
    EyeScene::new(parts).expect("a room of sound numbers")
}

fn main() -> ExitCode {
    let mut scene = room();
    let mut rows: Vec<u8> = Vec::new();
    let (mut held, mut is_steered) = (BTreeSet::new(), false);
    show("a room on a line", [WIDTH as u32, ROWS as u32], Motion::Moving, move |client, _| {
        client.send(Command::Events(true));
        let mut pose = scene.pose.clone();
        for event in client.events() {
            match event {
                InputEvent::Key { name, down: true } => is_steered |= held.insert(name),
                InputEvent::Key { name, down: false } => is_steered |= held.remove(&name),
                _ => {}
            }
        }
        for key in &held {
            match key.as_str() {
                "w" => pose.advance(0, 0.05),
                "s" => pose.advance(0, -0.05),
                "a" => pose.turn(0, 1, 1.5),
                "d" => pose.turn(0, 1, -1.5),
                "q" => pose.turn(0, 2, 1.5),
                "e" => pose.turn(0, 2, -1.5),
                _ => {}
            }
        }
        if !is_steered {
            // Sideways round the room, facing its middle.
            pose.advance(1, -0.05);
            pose.turn(0, 1, 2.0 / 3.0);
        }
        scene = scene.clone().with_pose(pose).expect("a pose of this space");
        let (_, line) = eye::contact_sheet(&eye::render(&scene));
        rows.extend_from_slice(line.as_flattened());
        let stride = WIDTH as usize * 4;
        let extra = rows.len().saturating_sub(ROWS as usize * stride);
        rows.drain(..extra);
        let count = (rows.len() / stride) as i32;
        client.blit([0, ROWS - count, WIDTH, count], rows.clone());
        Ok(())
    })
}

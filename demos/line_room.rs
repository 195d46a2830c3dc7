//! A three-dimensional room on a one-dimensional screen, explored with keys: W and S move forward
//! and back, A and D turn, Q and E look up and down (the hidden axis), while held. Below is the line
//! that the eye sees; the rows above it are the lines of the frames before, so the path becomes a
//! picture. On the left is the room from above, which the eye never sees. Until the first key it
//! moves by itself.

mod common;

use common::look::{AROUND, BLUE, CORAL, GOLD, LESSER, MARGIN, PAPER, TEAL, TEXT};
use common::{Motion, show};
use fbptr::command::Command;
use fbptr::eye::shapes::{DemoScene, PALETTE, cross_polytope, cube};
use fbptr::eye::{self, EyeLightKind, EyeScene, Falloff, Pose, Rotation};
use fbptr::input::InputEvent;
use fbptr::server::Client;
use std::collections::BTreeSet;
use std::process::ExitCode;

const WIDTH: i32 = 480;
const ROWS: i32 = 272;
/// Height of the line that the eye sees now.
const BAND: i32 = 32;
/// Side of the map, and pixels for a unit of length on it.
const MAP: i32 = 240;
const SCALE: f64 = 19.0;
const SIZE: [i32; 2] = [3 * MARGIN + MAP + WIDTH, 3 * MARGIN + ROWS + BAND];
/// Places and sizes of the things: x, y, z; the second is a box.
const THINGS: [[f64; 3]; 3] = [[2.0, 1.5, 0.0], [-1.0, -2.5, 0.3], [-3.0, 2.5, -0.2]];

/// Builds a closed room with three solids, the eye and two lights.
fn room() -> EyeScene {
    let demo = DemoScene { pixels: vec![WIDTH as u32], aperture_tan: 0.35, turns: vec![] };
    let walls = cube(3).expect("a cube").placed(6.0, &[0.0; 3]);
    let mut parts = demo.scene(walls).expect("a room").into_parts();
    for (i, at) in THINGS.into_iter().enumerate() {
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

/// Draws the room from above: walls, things, the eye and what it has in view.
fn map(client: &Client, scene: &EyeScene) {
    let middle = [f64::from(MARGIN + MAP / 2), f64::from(MARGIN + MAP / 2)];
    let at = |p: [f64; 2]| [middle[0] + p[0] * SCALE, middle[1] - p[1] * SCALE];
    let pose = &scene.pose;
    let axes = pose.axes();
    let eye = [pose.position[0], pose.position[1]];
    let ray = |slope: f64| [0, 1].map(|i| eye[i] + 4.5 * (axes[0][i] + slope * axes[1][i]));
    client.fill_rect([f64::from(MARGIN), f64::from(MARGIN), f64::from(MAP), f64::from(MAP)], AROUND);
    client.fill([at(eye), at(ray(1.0)), at(ray(-1.0))], [GOLD, AROUND, AROUND]);
    for (i, [x, y, _]) in THINGS.into_iter().enumerate() {
        let (sides, first) = if i == 1 { (1.27, 25.0 + 45.0) } else { (0.9, 25.0) };
        let corner = |k: i32| {
            let (sin, cos) = libm::sincos((first + 90.0 * f64::from(k)) * std::f64::consts::PI / 180.0);
            at([x + sides * cos, y + sides * sin])
        };
        client.fill_poly((0..4).map(corner).collect(), [TEAL, CORAL, BLUE][i]);
    }
    let wall = |x: f64, y: f64| at([x, y]).map(|v| v as i32);
    client.poly(vec![wall(-6.0, -6.0), wall(6.0, -6.0), wall(6.0, 6.0), wall(-6.0, 6.0)], LESSER);
    client.fill_circle(at(eye), 4.0, TEXT);
    client.text([MARGIN, 2 * MARGIN + MAP], "the room from above", LESSER);
    client.text([MARGIN, 2 * MARGIN + MAP + 12], "W S go, A D turn", LESSER);
    client.text([MARGIN, 2 * MARGIN + MAP + 24], "Q E look up and down", LESSER);
}

fn main() -> ExitCode {
    let mut scene = room();
    let mut rows: Vec<u8> = Vec::new();
    let (mut held, mut is_steered) = (BTreeSet::new(), false);
    show("a room on a line", SIZE.map(|s| s as u32), Motion::Moving, move |client, _| {
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
        let x = 2 * MARGIN + MAP;
        client.clear(PAPER);
        map(client, &scene);
        client.blit([x, MARGIN + ROWS - count, WIDTH, count], rows.clone());
        client.blit([x, 2 * MARGIN + ROWS, WIDTH, BAND], line.as_flattened().repeat(BAND as usize));
        Ok(())
    })
}

//! A two-dimensional world and the one-dimensional picture that an eye sees of it: figure 1 of the
//! report that the N-dimensional eye comes from (P. R. R. da Silva Filho, 2023), with six walls, a
//! sun from the left and twenty pixels. A ray drawn dark ends at a point that the sun does not
//! light.

mod common;

use common::look::{LESSER, MARGIN, PAPER};
use common::{Motion, show};
use fbptr::eye::{self, EyeLightKind, EyeScene};
use std::process::ExitCode;

const SCENE: &[u8] = include_bytes!("../tests/data/nd-cases/c01_2to1_parallel.json");
const SIZE: [i32; 2] = [480, 440];

/// Maps a point of the eye's plane to the frame: forward is up, left is left.
fn place(p: &[f64]) -> [i32; 2] {
    [240 - (p[1] * 55.0).round() as i32, 380 - (p[0] * 55.0).round() as i32]
}

fn opaque([r, g, b]: [f64; 3]) -> [u8; 4] {
    [r as u8, g as u8, b as u8, 255]
}

fn main() -> ExitCode {
    show("flatland", SIZE.map(|n| n as u32), Motion::Moving, |client, frame| {
        let scene = EyeScene::from_json(SCENE).expect("the scene of the figure is sound");
        let mut parts = scene.into_parts();
        // The sun's direction oscillates; light does not fall off with the distance to the eye.
        let swing = eye::sin_cos_deg(frame as f64).0 * 0.6;
        for light in &mut parts.lights {
            light.kind = EyeLightKind::Sun { direction: vec![swing, -1.0] };
        }
        parts.view = eye::Falloff::OFF;
        let scene = EyeScene::new(parts).expect("only the sun has moved");
        let picture = eye::render(&scene);

        client.clear(PAPER);
        for (j, &distance) in picture.dist.iter().enumerate() {
            let n = picture.dist.len() as f64;
            let c = scene.size[0] * (n - 1.0 - 2.0 * j as f64) / (2.0 * n);
            let length = (distance / (1.0 + c * c).sqrt()).min(6.5);
            let is_lit = picture.lit[j];
            let color = if is_lit { [90, 90, 70, 255] } else { [40, 42, 55, 255] };
            client.line(place(&[0.0, 0.0]), place(&[length, c * length]), color);
            // The pixel of this ray in the eye's picture.
            let [red, green, blue] = picture.color[j];
            client.fill_rect([j as i32 * 24, 400, 24, 40], opaque([red, green, blue]));
        }
        for facet in &scene.facets {
            client.line(place(&facet.v[0]), place(&facet.v[1]), opaque(facet.color));
        }
        client.text([MARGIN, MARGIN], "the plane; below, what the eye sees of it", LESSER);
        Ok(())
    })
}

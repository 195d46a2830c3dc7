//! Filled triangles: colours are interpolated between the corners, and faces that share an edge
//! light each pixel once.
//!
//! The rose is drawn with half-transparent triangles: a seam that was lit twice, or not at all,
//! would show as a line. There are 1152 seams.

mod common;

use common::look::{BLUE, CORAL, GOLD, MARGIN, PAPER, TEAL, mixed};
use common::{Motion, show};
use fbptr::command::Command;
use fbptr::memory::Rgba;
use std::process::ExitCode;

const SIZE: [u32; 2] = [480, 320];
const RINGS: u32 = 12;
const PETALS: u32 = 48;

/// Returns a point of the rose: each ring is turned by half a petal, and its petals breathe.
fn point(ring: u32, petal: u32) -> [f64; 2] {
    let part = f64::from(ring) / f64::from(RINGS);
    let angle = (f64::from(petal) + f64::from(ring) / 2.0) / f64::from(PETALS) * std::f64::consts::TAU;
    let (sin, cos) = libm::sincos(angle + 0.9 * part);
    let wave = 1.0 + 0.16 * part * libm::cos(8.0 * angle);
    let radius = 124.0 * libm::pow(part, 0.8) * wave;
    [f64::from(SIZE[0]) / 2.0 + radius * 1.45 * cos, f64::from(SIZE[1]) / 2.0 + radius * sin]
}

/// Returns the color of a point: gold in the middle, by coral and blue to teal outside.
fn color(ring: u32, petal: u32) -> Rgba {
    let part = f64::from(ring) / f64::from(RINGS) * 3.0;
    let stops = [GOLD, CORAL, BLUE, TEAL, TEAL];
    let [r, g, b, _] = mixed(stops[part as usize], stops[part as usize + 1], part.fract());
    // Every second petal is paler.
    [r, g, b, if (petal / 3).is_multiple_of(2) { 230 } else { 120 }]
}

fn main() -> ExitCode {
    show("triangles", SIZE, Motion::Still, |client, _| {
        client.clear(PAPER);
        client.send(Command::Blend { over: true });
        for ring in 0..RINGS {
            for petal in 0..PETALS {
                let inner = [(ring, petal), (ring, petal + 1)];
                let outer = [(ring + 1, petal), (ring + 1, petal + 1)];
                for corners in [[inner[0], outer[0], inner[1]], [inner[1], outer[0], outer[1]]] {
                    client.fill(corners.map(|(r, p)| point(r, p)), corners.map(|(r, p)| color(r, p)));
                }
            }
        }
        // Slivers, thinner to the right: each covers exactly the pixels whose centres lie in it.
        client.send(Command::Blend { over: false });
        let [width, height] = SIZE.map(f64::from);
        for i in 0..45 {
            let (x, thin) = (f64::from(MARGIN) + 10.2 * f64::from(i), 3.0 - f64::from(i) / 15.0);
            let top = height - 30.0;
            client.fill(
                [[x, top], [x + 4.0 + thin, height - 8.0], [x + 4.0 - thin, height - 8.0]],
                [GOLD, CORAL, BLUE],
            );
            client.fill(
                [[width - x, 30.0], [width - x - 4.0, 8.0], [width - x - 4.0 - thin, 8.0]],
                [TEAL, BLUE, BLUE],
            );
        }
        Ok(())
    })
}

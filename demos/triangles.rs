//! Filled triangles: colours are interpolated between the corners, and faces that share an edge
//! light each pixel once.

mod common;

use common::{Motion, show};
use fbptr::command::Command;
use fbptr::memory::Rgba;
use std::process::ExitCode;

const RED: Rgba = [255, 40, 40, 255];
const GREEN: Rgba = [40, 255, 40, 255];
const BLUE: Rgba = [60, 60, 255, 255];

fn main() -> ExitCode {
    show("triangles", [320, 200], Motion::Still, |client, _| {
        client.clear([16, 16, 24, 255]);
        client.fill([[12.5, 180.0], [150.0, 150.5], [80.0, 12.0]], [RED, GREEN, BLUE]);
        // A fan around one vertex, half transparent: a seam that was lit twice, or not at all,
        // would show as a line.
        client.send(Command::Blend { over: true });
        let hub = [235.3, 72.7];
        let rim = |i: u32| {
            let (sin, cos) = libm::sincos(f64::from(i % 24) / 24.0 * std::f64::consts::TAU);
            [hub[0] + 60.0 * cos, hub[1] + 60.0 * sin]
        };
        for i in 0..24 {
            client.fill([hub, rim(i), rim(i + 1)], [[255, 220, 120, 128]; 3]);
        }
        // Slivers: each covers exactly the pixels whose centres lie in it.
        client.send(Command::Blend { over: false });
        for i in 0..12 {
            let (x, dy) = (172.0 + 11.0 * f64::from(i), 0.3 * f64::from(i));
            client.fill([[x, 142.0], [x + 4.0 + dy, 194.0], [x + 5.0 - dy, 194.0]], [GREEN, BLUE, RED]);
        }
        Ok(())
    })
}

//! A rotating tesseract before an eye with two screen axes and one hidden axis. Left: its slice,
//! with the hidden aperture shut. Right: the view of the same eye through an aperture of 30 degrees
//! to either side.

mod common;

use common::{Motion, show};
use fbptr::executor::Executor;
use fbptr::eye::shapes::{DemoScene, cube};
use fbptr::eye::{self, Fibre};
use fbptr::server::worker_pool;
use std::process::ExitCode;

const SIDE: i32 = 280;

fn main() -> ExitCode {
    let threads = Executor::of_pool(worker_pool(None));
    show("tesseract", [2 * SIDE as u32, SIDE as u32 + 20], Motion::Moving, move |client, frame| {
        let angle = frame as f64 * 0.7;
        let turns = vec![(0, 1, 30.0), (0, 2, 20.0), (0, 3, angle), (1, 3, 40.0 + angle * 0.6)];
        client.clear([0, 0, 0, 255]);
        let views = [(0.0, "its slice"), (0.577, "seen through its aperture")];
        for (x, (aperture_tan, name)) in [0, SIDE].into_iter().zip(views) {
            let demo = DemoScene { pixels: vec![SIDE as u32; 2], aperture_tan, turns: turns.clone() };
            let tesseract = cube(4).expect("there is a cube of 4 dimensions");
            let scene = demo.scene(tesseract).expect("the stage fits the tesseract");
            let picture = eye::render_with(&scene, Fibre::Exact, &threads).expect("no fan, no refusal");
            let (_, pixels) = eye::contact_sheet(&picture);
            client.blit([x, 0, SIDE, SIDE], pixels.into_flattened());
            client.text([x + 8, SIDE + 6], name, [170, 170, 170, 255]);
        }
        Ok(())
    })
}

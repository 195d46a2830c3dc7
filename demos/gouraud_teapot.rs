//! Newell's teapot after Gouraud: lit at the vertices, the colours run between them.
//!
//! The patches are cut coarsely, so that it shows: the highlight keeps to the vertices, and wanders with them as the pot turns.

mod common;

use common::teapot::teapot;
use common::{Motion, show};
use fbptr::scene::ShadeMode;
use std::process::ExitCode;

fn main() -> ExitCode {
    show("gouraud teapot", [400, 300], Motion::Moving, |client, frame| {
        teapot(client, frame, ShadeMode::Gouraud)
    })
}

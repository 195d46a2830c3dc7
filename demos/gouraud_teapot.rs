//! Newell's teapot with Gouraud shading: lit at the vertices, with colours interpolated between
//! them.
//!
//! The coarse tessellation makes the weakness visible: the highlight sticks to the vertices, and
//! jumps between them as the teapot rotates.

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

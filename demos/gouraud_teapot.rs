//! Newell's teapot with Gouraud shading: lit at the vertices, with colours interpolated between
//! them.
//!
//! The coarse tessellation makes the weakness visible: the highlight is a star of faces, sticks to
//! the vertices, and jumps between them as the teapot rotates. `phong_teapot` has the same faces.

mod common;

use common::teapot::{SIZE, teapot};
use common::{Motion, show};
use fbptr::scene::ShadeMode;
use std::process::ExitCode;

fn main() -> ExitCode {
    show("gouraud teapot", SIZE, Motion::Moving, |client, frame| {
        teapot(client, frame, ShadeMode::Gouraud, "Gouraud: lit at the corners")
    })
}

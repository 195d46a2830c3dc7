//! Newell's teapot with Phong shading: normals are interpolated between the vertices, and every
//! pixel is lit.
//!
//! The tessellation is as coarse as in the Gouraud demo: the outline shows it, the highlight does
//! not.

mod common;

use common::teapot::{SIZE, teapot};
use common::{Motion, show};
use fbptr::scene::ShadeMode;
use std::process::ExitCode;

fn main() -> ExitCode {
    show("phong teapot", SIZE, Motion::Moving, |client, frame| {
        teapot(client, frame, ShadeMode::Phong, "Phong: lit at every pixel")
    })
}

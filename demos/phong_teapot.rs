//! Newell's teapot after Phong: the normals run between the vertices, and every pixel is lit for itself.
//!
//! As coarse as the Gouraud demo's teapot: the outline shows it, the highlight no longer does.

mod common;

use common::teapot::teapot;
use common::{Motion, show};
use fbptr::scene::ShadeMode;
use std::process::ExitCode;

fn main() -> ExitCode {
    show("phong teapot", [400, 300], Motion::Moving, |client, frame| teapot(client, frame, ShadeMode::Phong))
}

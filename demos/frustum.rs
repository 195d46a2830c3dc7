//! Clipping, seen by a second camera: the view volume of the first one is a frustum, and a triangle
//! is cut at its six planes.
//!
//! White: the frustum. Coral: the triangle. Teal: its part inside the frustum, cut in clip space
//! before the division by w.

mod common;

use common::look::{CORAL, LESSER, MARGIN, PAPER, TEAL, TEXT, mixed};
use common::{Motion, show};
use fbptr::command::{Command, Figure};
use fbptr::pipeline::{ClipVertex, clip_line, clip_polygon};
use fbptr::scene::{Camera, LookAt, Projection};
use fbptr::server::Client;
use glam::{DMat4, DVec3, DVec4};
use std::process::ExitCode;

const SIZE: [u32; 2] = [400, 300];

fn world_to_clip(eye: DVec3, reference: DVec3, near: f64, far: f64, fov_rad: f64) -> DMat4 {
    let projection = Projection::Perspective { fov_rad, near, far, on_smaller_side: false };
    let camera = Camera { look_at: LookAt { eye, reference, up: DVec3::Y }, projection };
    let m = camera.matrices(4.0 / 3.0).expect("both cameras are sound");
    m.projection * m.view
}

fn vertex(pos_clip: DVec4) -> ClipVertex<0> {
    ClipVertex { pos_clip, varyings: [] }
}

fn on_screen(p: DVec4) -> [f64; 2] {
    [(p.x / p.w + 1.0) * 0.5 * f64::from(SIZE[0]), (1.0 - p.y / p.w) * 0.5 * f64::from(SIZE[1])]
}

/// Draws a line in world space, as the second camera sees it.
fn line(client: &Client, from_outside: &DMat4, a: DVec3, b: DVec3, color: [u8; 4]) {
    let clip = |p: DVec3| vertex(*from_outside * p.extend(1.0));
    if let Some(seen) = clip_line(clip(a), clip(b)) {
        let [p0, p1] = seen.ends.map(|v| on_screen(v.pos_clip));
        client.send(Command::Figure(Figure::LineAa { p0, p1, color }));
    }
}

fn main() -> ExitCode {
    show("frustum", SIZE, Motion::Moving, |client, frame| {
        let inner = world_to_clip(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, 1.2, 5.0, 0.8);
        let back = inner.inverse();
        let outside = world_to_clip(DVec3::new(8.4, 3.6, 5.4), DVec3::new(0.0, -0.2, 0.1), 0.1, 50.0, 0.62);
        let turn = DMat4::from_rotation_y(0.5 + frame as f64 * 0.015) * DMat4::from_rotation_x(0.5);
        let corners = [DVec3::new(-2.6, -1.0, 0.0), DVec3::new(2.4, -1.4, 0.4), DVec3::new(0.2, 2.2, -0.3)]
            .map(|p| turn.transform_point3(p));
        client.clear(PAPER);
        // The part that is left: clipped in clip space, then transformed back to world space.
        let ring = clip_polygon(&corners.map(|p| vertex(inner * p.extend(1.0))));
        let left: Vec<DVec3> =
            ring.iter().map(|v| back.project_point3(v.pos_clip.truncate() / v.pos_clip.w)).collect();
        let points = left.iter().map(|p| on_screen(outside * p.extend(1.0))).collect();
        client.send(Command::Figure(Figure::FillPoly { color: mixed(PAPER, TEAL, 0.5), points }));
        for i in 0..left.len() {
            line(client, &outside, left[i], left[(i + 1) % left.len()], TEAL);
        }
        for i in 0..3 {
            line(client, &outside, corners[i], corners[(i + 1) % 3], CORAL);
        }
        // The frustum is the box -1..1, -1..1, 0..1 of NDC, transformed back to world space.
        let corner = |i: usize| {
            let side = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            back.project_point3(DVec3::new(side(0), side(1), (side(2) + 1.0) / 2.0))
        };
        for i in 0..8 {
            for bit in (0..3).filter(|bit| i >> bit & 1 == 0) {
                line(client, &outside, corner(i), corner(i | 1 << bit), TEXT);
            }
        }
        client.text([MARGIN, MARGIN], &format!("3 corners in, {} out", left.len()), LESSER);
        Ok(())
    })
}

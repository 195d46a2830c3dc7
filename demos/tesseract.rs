//! A rotating tesseract, three times. Left: its edges, in perspective along both directions of view,
//! gold where they are near along the fourth axis. Right: its slice, with the hidden aperture of the
//! eye shut, and below the view of the same eye through an aperture of 30 degrees to either side.

mod common;

use common::look::{BLUE, GOLD, LESSER, MARGIN, PAPER, TEAL, mixed};
use common::{Motion, show};
use fbptr::executor::Executor;
use fbptr::eye::shapes::{DemoScene, Shape, cube};
use fbptr::eye::{self, Fibre};
use fbptr::server::{Client, worker_pool};
use std::process::ExitCode;

const LARGE: i32 = 392;
const SMALL: i32 = 180;

/// Returns the tesseract turned in three planes.
fn turned(turns: &[(usize, usize, f64)]) -> Shape {
    let tesseract = cube(4).expect("there is a cube of 4 dimensions");
    turns.iter().fold(tesseract, |shape, &(a, b, angle)| shape.turned(a, b, angle))
}

/// Draws the edges: pairs of corners that differ in one coordinate before any turn.
fn edges(client: &Client, shape: &Shape, radius: f64) {
    let corners = cube(4).expect("there is a cube of 4 dimensions").points;
    let seen: Vec<([f64; 2], f64, f64)> = shape
        .points
        .iter()
        .map(|p| {
            let [ahead, left, up, hidden] = [0, 1, 2, 3].map(|i| p[i] / radius);
            let nearer = 2.4 / (2.4 - hidden);
            let scale = nearer * 3.4 / (3.4 + ahead * nearer) * 0.4 * f64::from(LARGE);
            let middle = f64::from(MARGIN) + f64::from(LARGE) / 2.0;
            ([middle - left * scale, middle - up * scale], ahead, hidden)
        })
        .collect();
    let is_edge =
        |a: usize, b: usize| corners[a].iter().zip(&corners[b]).filter(|(x, y)| x != y).count() == 1;
    let pairs = (0..16).flat_map(|a| (a + 1..16).map(move |b| [a, b])).filter(|&[a, b]| is_edge(a, b));
    let mut pairs: Vec<[usize; 2]> = pairs.collect();
    // Far edges first, and fainter.
    pairs.sort_by(|x, y| (seen[y[0]].1 + seen[y[1]].1).total_cmp(&(seen[x[0]].1 + seen[x[1]].1)));
    for [a, b] in pairs {
        let ([p, q], ahead) = ([seen[a].0, seen[b].0], (seen[a].1 + seen[b].1) / 2.0);
        let hidden = (seen[a].2 + seen[b].2) / 2.0 + 0.5;
        let hue = if hidden < 0.5 {
            mixed(BLUE, TEAL, hidden.max(0.0) * 2.0)
        } else {
            mixed(TEAL, GOLD, (hidden * 2.0 - 1.0).min(1.0))
        };
        let light = (0.62 - 0.5 * ahead).clamp(0.2, 1.0);
        // A wide faint line, then narrower and brighter ones, the last one pixel wide.
        for (width, alpha) in [(4_i32, 9.0), (3, 14.0), (2, 22.0), (1, 50.0), (0, 235.0)] {
            for (dx, dy) in
                (-width..=width).flat_map(|dx| [(dx, width), (dx, -width), (width, dx), (-width, dx)])
            {
                let by = [f64::from(dx), f64::from(dy)];
                let moved = |p: [f64; 2]| [p[0] + by[0], p[1] + by[1]];
                let share = alpha * light / f64::from(8 * width).max(1.0) * 2.2;
                client.line_aa(moved(p), moved(q), [hue[0], hue[1], hue[2], share.min(255.0) as u8]);
                if width == 0 {
                    break;
                }
            }
        }
    }
}

fn main() -> ExitCode {
    let threads = Executor::of_pool(worker_pool(None));
    let size = [(3 * MARGIN + LARGE + SMALL) as u32, (2 * MARGIN + LARGE) as u32];
    show("tesseract", size, Motion::Moving, move |client, frame| {
        let angle = frame as f64 * 0.7;
        let turns = vec![(0, 1, 30.0), (0, 2, 20.0), (0, 3, angle), (1, 3, 40.0 + angle * 0.6)];
        client.clear(PAPER);
        let shape = turned(&turns);
        edges(client, &shape, shape.radius());
        let views = [(0.0, "its slice"), (0.577, "through an aperture")];
        for (y, (aperture_tan, name)) in [MARGIN, MARGIN + LARGE / 2 + 6].into_iter().zip(views) {
            let demo = DemoScene { pixels: vec![SMALL as u32; 2], aperture_tan, turns: turns.clone() };
            let tesseract = cube(4).expect("there is a cube of 4 dimensions");
            let scene = demo.scene(tesseract).expect("the stage fits the tesseract");
            let picture = eye::render_with(&scene, Fibre::Exact, &threads).expect("no fan, no refusal");
            let (_, pixels) = eye::contact_sheet(&picture);
            let x = 2 * MARGIN + LARGE;
            client.blit([x, y, SMALL, SMALL], pixels.into_flattened());
            client.text([x, y + SMALL + 4], name, LESSER);
        }
        Ok(())
    })
}

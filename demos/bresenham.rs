//! Bresenham's line algorithm step by step: one integer, printed beside each step, selects the next
//! pixel.
//!
//! d begins at 2 dy - dx. If d > 0, the line has passed the middle between two rows: y moves on,
//! and d falls by 2 dx. Each step adds 2 dy. A cell of the grid is one pixel, sixteen times as
//! large.

mod common;

use common::{Motion, show};
use std::process::ExitCode;

const CELL: i32 = 16;
const FROM: [i32; 2] = [1, 2];
const TO: [i32; 2] = [18, 9];

fn main() -> ExitCode {
    show("bresenham", [512, 208], Motion::Moving, |client, frame| {
        let (dx, dy) = (TO[0] - FROM[0], TO[1] - FROM[1]);
        let steps = (frame as i32 + 1).min(dx + 1);
        client.clear([14, 16, 24, 255]);
        for i in 0..=20 {
            client.line([i * CELL, 0], [i * CELL, 12 * CELL], [44, 48, 64, 255]);
            client.line(
                [0, (i * CELL).min(12 * CELL)],
                [20 * CELL, (i * CELL).min(12 * CELL)],
                [44, 48, 64, 255],
            );
        }
        let (mut y, mut d) = (FROM[1], 2 * dy - dx);
        for step in 0..steps {
            let x = FROM[0] + step;
            let newest = step == steps - 1;
            let color = if newest { [255, 220, 80, 255] } else { [90, 130, 220, 255] };
            client.fill_rect([x * CELL + 1, y * CELL + 1, CELL - 1, CELL - 1], color);
            let move_on = d > 0;
            let text = format!("x {x:2} y {y} d {d:4}{}", if move_on { " y+1" } else { "" });
            let grey = if newest { [255, 255, 255, 255] } else { [130, 134, 150, 255] };
            client.text([20 * CELL + 12, 8 + step * 10], &text, grey);
            // The decision: the next pixel, and the next d.
            d += 2 * dy;
            if move_on {
                (y, d) = (y + 1, d - 2 * dx);
            }
        }
        // The ideal line, through the centres of its end pixels.
        let center = |[x, y]: [i32; 2]| [x * CELL + CELL / 2, y * CELL + CELL / 2];
        client.line(center(FROM), center(TO), [255, 80, 80, 255]);
        client.text([8, 12 * CELL + 4], &format!("dx {dx}, dy {dy}: d = 2 dy - dx"), [170, 170, 170, 255]);
        Ok(())
    })
}

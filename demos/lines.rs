//! Bresenham's lines in all eight octants, each with a colour ramp from end to end.

mod common;

use common::{Motion, show};
use std::process::ExitCode;

const SIDE: i32 = 256;

fn main() -> ExitCode {
    show("lines", [SIDE as u32; 2], Motion::Still, |client, _| {
        let (centre, reach) = ([SIDE / 2; 2], SIDE / 2 - 8);
        // The far ends go once around a square: slopes of every octant, including the axes and
        // diagonals.
        for i in 0..64 {
            let (side, along) = (i / 16, i % 16 * (2 * reach) / 16 - reach);
            let [x, y] = match side {
                0 => [along, -reach],
                1 => [reach, along],
                2 => [-along, reach],
                _ => [-reach, -along],
            };
            let hue = |shift: i32| (255 - ((i + shift) % 64 - 32).abs() * 8).clamp(0, 255) as u8;
            let far = [hue(0), hue(21), hue(42), 255];
            client.line(centre, [centre[0] + x, centre[1] + y], [[255; 4], far]);
        }
        // Clipping: a line that leaves the frame lights the same pixels as the unclipped line.
        client.line(
            [-2_000_000_000, SIDE - 4],
            [2_000_000_000, SIDE - 4],
            [[255, 0, 0, 255], [0, 255, 0, 255]],
        );
        client.line([4, -2_000_000_000], [4, 2_000_000_000], [80, 80, 80, 255]);
        Ok(())
    })
}

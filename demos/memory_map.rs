//! Pixels and the memory map: the frame is one array of bytes, R G B A from the upper left corner,
//! row by row.
//!
//! The colour of every pixel encodes its position: red the row, green the column, blue the position
//! in the array. Then bytes are written by offset alone: a white border around a rectangle, and the
//! red bytes of the last 16 rows.

mod common;

use common::{Motion, show};
use fbptr::command::Command;
use fbptr::memory::FbPtr;
use std::process::ExitCode;

const SIDE: u32 = 256;

fn main() -> ExitCode {
    show("memory map", [SIDE, SIDE], Motion::Still, |client, _| {
        // put_pixel computes the offset.
        for y in 0..SIDE {
            for x in 0..SIDE {
                let number = SIDE * y + x;
                client.put_pixel(x as i32, y as i32, [y as u8, x as u8, (number / 61) as u8, 255]);
            }
        }
        // POKE takes an offset. The next row is SIDE * 4 bytes on, the next pixel to the right is
        // 4.
        let poke = |at: FbPtr, bytes: Vec<u8>| {
            client.send(Command::Poke { offset: at.offset_bytes() as i32, bytes });
        };
        let corner = FbPtr::of_pixel(SIDE, 48, 40);
        for row in 0..24 {
            let start = corner.checked_add(row * i64::from(SIDE) * 4).expect("inside the frame");
            match row {
                0 | 23 => poke(start, vec![255; 160 * 4]),
                _ => {
                    poke(start, [255; 4].into_iter().chain([0, 0, 0, 255].repeat(158)).collect());
                    poke(start.checked_add(159 * 4).expect("inside the frame"), vec![255; 4]);
                }
            }
        }
        client.text([53, 44], "offset =", [255; 4]);
        client.text([53, 53], "(width*y + x) * 4", [255, 255, 0, 255]);
        // The first byte of a pixel is its red: every fourth byte of the last 16 rows.
        for number in SIDE * (SIDE - 16)..SIDE * SIDE {
            poke(FbPtr::new(u64::from(number) * 4), vec![255]);
        }
        Ok(())
    })
}

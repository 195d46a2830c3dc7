//! W7 on breakwater's frame buffer, as its Pixelflut server writes it: one `set` per pixel. It has
//! no lines and no meshes.

use breakwater_parser::{FrameBuffer, SimpleFrameBuffer};
use fbptr_peers::*;

const PEER: &str = "breakwater";

/// Converts a word to breakwater's format: R in the lowest byte.
fn as_kept(word: u32) -> u32 {
    u32::from_be(word << 8)
}

fn main() {
    if !is_wanted("W7") {
        return;
    }
    let frame = SimpleFrameBuffer::new(WIDTH, HEIGHT);
    let clear = || {
        for y in 0..HEIGHT {
            (0..WIDTH).for_each(|x| frame.set(x, y, as_kept(BACKGROUND), ()));
        }
    };
    measure(PEER, "W7_putpixel_100M", || {
        clear();
        each_pixel(100_000_000, |x, y, [r, g, b]| {
            frame.set(x as usize, y as usize, u32::from_le_bytes([r, g, b, 0]), ());
        });
    });
    let kept = (0..WIDTH * HEIGHT).map(|i| frame.get(i % WIDTH, i / WIDTH).expect("inside the frame"));
    let words: Vec<u32> = kept.map(|k| u32::from_be(k) >> 8).collect();
    save_picture(PEER, "W7_putpixel_100M", &words);
}

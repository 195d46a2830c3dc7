//! Helpers of this module's tests: small frames, frames printed as text, the golden files.

use crate::memory::{Rgba, VideoMemory};

/// Width in pixels of the frames that exhaustive tests draw into.
pub const FRAME_W: i32 = 7;
/// Height in pixels of the frames that exhaustive tests draw into.
pub const FRAME_H: i32 = 5;

pub fn memory(width: u32, height: u32) -> VideoMemory {
    VideoMemory::new(width, height).unwrap()
}

/// Prints the frame as text, a line break before each row: `#` for a pixel that is not black.
pub fn picture(memory: &VideoMemory) -> String {
    let mark = |p: &Rgba| if p[..3] == [0; 3] { '.' } else { '#' };
    let rows = memory.bytes().chunks(memory.stride_bytes());
    rows.map(|row| format!("\n{}", row.as_chunks::<4>().0.iter().map(mark).collect::<String>())).collect()
}

/// Returns the pixels whose red is `value`, row by row. Panics if another pixel is not black.
pub fn lit(memory: &VideoMemory, value: u8) -> Vec<(i32, i32)> {
    let width = memory.width() as usize;
    let pixels = memory.bytes().as_chunks::<4>().0.iter().enumerate();
    let lit =
        pixels.filter(|(_, p)| p[0] != 0).inspect(|(i, p)| assert_eq!(p[0], value, "pixel {i} lit twice"));
    lit.map(|(i, _)| ((i % width) as i32, (i / width) as i32)).collect()
}

/// Returns coordinates around the frame's edges and at the ends of i32.
pub fn extremes() -> [i32; 10] {
    [i32::MIN, i32::MIN + 1, -3, -1, 0, 1, 4, 6, 9, i32::MAX]
}

/// Reads a golden file from `tests/data/golden`.
pub fn golden(name: &str) -> serde_json::Value {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden").join(name);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

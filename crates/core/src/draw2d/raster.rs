//! Helpers of this module's tests: small frames, frames printed as text, the golden files.

use crate::memory::{Rgba, VideoMemory};
use num_bigint::BigInt;
use proptest::prelude::*;

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
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/golden").join(name);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Returns a number in units of 2^-1074, the smallest positive f64, read from its bits.
fn in_smallest_units(v: f64) -> BigInt {
    let (exponent, fraction) = ((v.to_bits() >> 52) as u32 & 0x7ff, v.to_bits() & ((1 << 52) - 1));
    let mantissa = if exponent == 0 { fraction } else { fraction | 1 << 52 };
    let size = BigInt::from(mantissa) << exponent.saturating_sub(1);
    if v.is_sign_negative() { -size } else { size }
}

/// Returns the definition of a filled ellipse, evaluated in integers: whether the centre of pixel
/// (x, y) is inside. It shares no code with what draws.
pub fn ellipse_definition(centre: [f64; 2], radii: [f64; 2]) -> impl Fn(i32, i32) -> bool {
    let (centre, [rx, ry]) = (centre.map(in_smallest_units), radii.map(in_smallest_units));
    let limit = &rx * &ry * &rx * &ry;
    move |x, y| {
        // (2x + 1) / 2 pixels, less the centre.
        let from_centre = |v: i32, k: usize| (BigInt::from(2 * v + 1) << 1073) - &centre[k];
        let (u, v) = (from_centre(x, 0) * &ry, from_centre(y, 1) * &rx);
        &u * &u + &v * &v < limit
    }
}

/// Generates coordinates in pixels: halves, others near the frame, far ones, and all magnitudes of
/// f64.
pub fn real() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => (-20..40i32).prop_map(|v| f64::from(v) / 2.0),
        3 => -10.0..20.0,
        1 => -1e6..1e6,
        1 => (-1.0..1.0, -320..308i32).prop_map(|(m, e): (f64, i32)| m * 10f64.powi(e)),
        1 => prop::sample::select(vec![f64::MAX, -f64::MAX, 5e-324, -5e-324, 0.0, f64::MIN_POSITIVE]),
    ]
}

/// Generates coordinates about a frame of 1920x1080, in pixels: multiples of a power of two down to
/// 2^-12, so that many lie on pixels' centres and borders.
pub fn fractional() -> impl Strategy<Value = f64> {
    (-120..2000i32, 0..4096u32, 0..=12u32)
        .prop_map(|(v, part, bits)| f64::from(v) + f64::from(part >> (12 - bits) << (12 - bits)) / 4096.0)
}

//! The palette and the margin of docs/look.md.

use fbptr::memory::Rgba;

pub const PAPER: Rgba = [0x0e, 0x14, 0x20, 255];
pub const AROUND: Rgba = [0x16, 0x1d, 0x2c, 255];
pub const TEXT: Rgba = [0xe8, 0xe8, 0xf0, 255];
pub const LESSER: Rgba = [0x80, 0x8c, 0xa5, 255];
pub const GOLD: Rgba = [0xff, 0xb0, 0x00, 255];
pub const TEAL: Rgba = [0x2e, 0xc4, 0xb6, 255];
pub const CORAL: Rgba = [0xff, 0x5d, 0x5d, 255];
pub const BLUE: Rgba = [0x5b, 0x8c, 0xff, 255];
/// Pixels on every side, and between columns.
pub const MARGIN: i32 = 16;

/// Returns the color a part `t` of the way from `a` to `b`.
pub fn mixed(a: Rgba, b: Rgba, t: f64) -> Rgba {
    let part = |i: usize| (f64::from(a[i]) + (f64::from(b[i]) - f64::from(a[i])) * t + 0.5) as u8;
    [part(0), part(1), part(2), part(3)]
}

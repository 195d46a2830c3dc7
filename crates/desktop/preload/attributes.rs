//! Writing the files of `/sys/class/graphics/fb0`: what a text asks of the device.
//!
//! Source: the `store_` functions of the kernel's `drivers/video/fbdev/core/fbsysfs.c`. Pure
//! functions; the program and the preload library include this file.

use super::mode::{self, DeviceLimits, INVALID, Var};

/// The files that can be written.
pub const WRITABLE: [&str; 9] =
    ["bits_per_pixel", "virtual_size", "pan", "blank", "mode", "rotate", "state", "console", "cursor"];

/// A change of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Sets a mode that has been checked.
    Mode(Var),
    /// Moves the visible part.
    Pan(u32, u32),
    /// Sets the blanking level.
    Blank(u32),
    /// Nothing that the device has.
    Nothing,
}

/// Returns the change that a text written to a file asks for.
///
/// # Errors
/// `EINVAL` for a text that is none, and what the mode's check answers.
pub fn change(file: &str, text: &[u8], var: &Var, device: &DeviceLimits) -> Result<Change, i32> {
    let checked = |wanted: Var| mode::check(&wanted, device).map(Change::Mode);
    match file {
        "bits_per_pixel" => checked(Var { bits_per_pixel: number(text).0, ..*var }),
        "rotate" => checked(Var { rotate: number(text).0, ..*var }),
        "virtual_size" => {
            let (xres_virtual, yres_virtual) = pair(text)?;
            checked(Var { xres_virtual, yres_virtual, ..*var })
        }
        "mode" => {
            let (xres, yres) = size(text).ok_or(INVALID)?;
            checked(Var {
                xres,
                yres,
                xres_virtual: xres,
                yres_virtual: yres,
                xoffset: 0,
                yoffset: 0,
                ..*var
            })
        }
        "pan" => {
            let (xoffset, yoffset) = pair(text)?;
            if mode::can_pan(var, xoffset, yoffset) {
                Ok(Change::Pan(xoffset, yoffset))
            } else {
                Err(INVALID)
            }
        }
        // FB_BLANK_POWERDOWN is the highest level, and stands for those above it.
        "blank" => Ok(Change::Blank(number(text).0.min(4))),
        _ => Ok(Change::Nothing),
    }
}

/// Reads a number as `simple_strtoul` does: decimal, octal after 0, hexadecimal after 0x, and 0 for
/// what is none. Returns it and its length.
fn number(text: &[u8]) -> (u32, usize) {
    let (base, start) = match text {
        [b'0', b'x' | b'X', digit, ..] if digit.is_ascii_hexdigit() => (16, 2),
        [b'0', ..] => (8, 0),
        _ => (10, 0),
    };
    let mut value = 0u32;
    let mut len = start;
    while let Some(digit) = text.get(len).and_then(|byte| char::from(*byte).to_digit(base)) {
        value = value.wrapping_mul(base).wrapping_add(digit);
        len += 1;
    }
    (value, len)
}

/// Reads two numbers with a character between them.
fn pair(text: &[u8]) -> Result<(u32, u32), i32> {
    let (first, len) = number(text);
    let rest = text.get(len + 1..).filter(|rest| !rest.is_empty()).ok_or(INVALID)?;
    Ok((first, number(rest).0))
}

/// Reads the size of a mode as the kernel writes one: `U:640x480p-60`.
fn size(text: &[u8]) -> Option<(u32, u32)> {
    let text = text.get(2..).filter(|_| text[1] == b':')?;
    let (width, len) = number(text);
    let text = text.get(len..)?.strip_prefix(b"x")?;
    let (height, len) = number(text);
    let is_rate =
        matches!(text.get(len..), Some([b'p' | b'i' | b'd', b'-', digit, ..]) if digit.is_ascii_digit());
    is_rate.then_some((width, height))
}

//! Frame sizes as arguments: `WxH`.

use crate::memory::MAX_SIDE;
use std::str::FromStr;

/// Width and height of a frame in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameSize {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

impl FrameSize {
    /// Size used if none is given.
    pub const DEFAULT: FrameSize = FrameSize { width: 640, height: 480 };
}

impl From<FrameSize> for (u32, u32) {
    fn from(size: FrameSize) -> Self {
        (size.width, size.height)
    }
}

impl FromStr for FrameSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |digits: &str| {
            let is_number = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
            digits.parse().ok().filter(|n| is_number && (1..=MAX_SIDE).contains(n))
        };
        let sizes = text.split_once(['x', 'X']).and_then(|(w, h)| Some((side(w)?, side(h)?)));
        match sizes {
            Some((width, height)) => Ok(FrameSize { width, height }),
            None => Err(format!("a size is WxH with 1 to {MAX_SIDE} pixels a side, as in 640x480")),
        }
    }
}

impl std::fmt::Display for FrameSize {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers_from_1_on() {
        assert_eq!("10x6".parse(), Ok(FrameSize { width: 10, height: 6 }));
        for bad in [
            "",
            "x",
            "10",
            "10x",
            "x6",
            "0x6",
            "10x0",
            "-1x5",
            "+1x5",
            "10x6x7",
            "1e3x5",
            "40000x1",
            "10*6",
            "9999999999x1",
        ] {
            assert!(bad.parse::<FrameSize>().is_err(), "{bad}");
        }
    }
}

//! Byte offsets into video memory, with checked arithmetic.

use std::fmt;

/// Byte offset into video memory, from the first byte of the top left pixel.
///
/// Moves by bytes and converts from and to pixels. An offset may lie outside the memory: reading or
/// writing there is an error that names it, and no operation wraps around.
#[doc(alias = "FBptr")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct FbPtr(u64);

impl FbPtr {
    /// Returns the pointer to byte `offset_bytes`.
    pub const fn new(offset_bytes: u64) -> Self {
        FbPtr(offset_bytes)
    }

    /// Returns the pointer to the first byte (R) of pixel (x, y) in a frame `width` pixels wide:
    /// `(width * y + x) * 4`, which saturates beyond all frames.
    pub const fn of_pixel(width: u32, x: u32, y: u32) -> Self {
        FbPtr((width as u64 * y as u64 + x as u64).saturating_mul(4))
    }

    /// Returns the offset in bytes.
    pub const fn offset_bytes(self) -> u64 {
        self.0
    }

    /// Returns this pointer moved by `bytes`, or `None` if the result does not fit a `u64`.
    pub const fn checked_add(self, bytes: i64) -> Option<Self> {
        match self.0.checked_add_signed(bytes) {
            Some(offset) => Some(FbPtr(offset)),
            None => None,
        }
    }

    /// Returns the column and row of the pixel that holds this byte, and the byte's index 0..4 in
    /// it, in a frame `width` pixels wide.
    ///
    /// Returns `None` for a width of 0.
    pub const fn pixel(self, width: u32) -> Option<(u64, u64, u8)> {
        if width == 0 {
            return None;
        }
        let pixel = self.0 / 4;
        Some((pixel % width as u64, pixel / width as u64, (self.0 % 4) as u8))
    }
}

impl fmt::Display for FbPtr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FBptr[{}]", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offset_is_width_times_y_plus_x_times_four() {
        assert_eq!(FbPtr::of_pixel(512, 511, 0).offset_bytes(), 2044);
        assert_eq!(FbPtr::of_pixel(512, 0, 511).offset_bytes(), 1_046_528);
        assert_eq!(FbPtr::of_pixel(512, 511, 511).pixel(512), Some((511, 511, 0)));
        assert_eq!(FbPtr::new(7).pixel(0), None);
    }

    #[test]
    fn arithmetic_never_wraps() {
        assert_eq!(FbPtr::new(3).checked_add(-4), None);
        assert_eq!(FbPtr::new(u64::MAX).checked_add(1), None);
        assert_eq!(FbPtr::new(4).checked_add(-4), Some(FbPtr::new(0)));
    }
}

//! Why a 2-D verb was refused. Nothing is drawn then.

use super::Rect;
use crate::error::Code;

/// Why a 2-D verb was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DrawError {
    /// A width or a height below zero.
    #[error("sizes are 0 or more, not {w}x{h}")]
    NegativeSize {
        /// Width asked for, in pixels.
        w: Size,
        /// Height asked for, in pixels.
        h: Size,
    },
    /// A radius below zero.
    #[error("a radius is 0 or more, not {r}")]
    NegativeRadius {
        /// Radius asked for, in pixels.
        r: Size,
    },
    /// A source that is not wholly inside the frame.
    #[error("{}x{} pixels from ({},{}) are not all inside the frame's {width}x{height}", .rect.w, .rect.h, .rect.x, .rect.y)]
    SourceOutside {
        /// What was asked for.
        rect: Rect,
        /// The frame's width in pixels.
        width: u32,
        /// The frame's height in pixels.
        height: u32,
    },
    /// A payload of another length than the rectangle's.
    #[error("{expected} bytes expected for {w}x{h} pixels, {found} found")]
    WrongLength {
        /// Width in pixels.
        w: i32,
        /// Height in pixels.
        h: i32,
        /// Bytes that the rectangle takes.
        expected: u64,
        /// Bytes that came.
        found: u64,
    },
    /// A payload that does not end with a whole record.
    #[error("records of {record} bytes expected, {found} bytes found")]
    BrokenRecord {
        /// Bytes of one record.
        record: u64,
        /// Bytes that came.
        found: u64,
    },
    /// Text that is not UTF-8.
    #[error("utf-8 expected, broken at byte {at}")]
    NotUtf8 {
        /// Bytes of the payload that are sound.
        at: u64,
    },
}

/// A real size in an error: the bits of an f64, so that errors can be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(u64);

impl<T: Into<f64>> From<T> for Size {
    fn from(v: T) -> Self {
        Size(v.into().to_bits())
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Exponent form for the very large, so that a message stays one short line.
        let v = f64::from_bits(self.0);
        if v.abs() < 1e15 { write!(f, "{v}") } else { write!(f, "{v:e}") }
    }
}

impl DrawError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            DrawError::NegativeSize { .. }
            | DrawError::NegativeRadius { .. }
            | DrawError::SourceOutside { .. } => Code::Range,
            DrawError::WrongLength { .. } | DrawError::BrokenRecord { .. } | DrawError::NotUtf8 { .. } => {
                Code::Format
            }
        }
    }
}

impl Rect {
    /// This rectangle, refused when a side is below zero.
    pub(super) fn checked(self) -> Result<Self, DrawError> {
        let Rect { w, h, .. } = self;
        if w < 0 || h < 0 { Err(DrawError::NegativeSize { w: w.into(), h: h.into() }) } else { Ok(self) }
    }
}

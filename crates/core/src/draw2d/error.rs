//! Errors of the 2-D drawing functions. A function that returns one has drawn nothing.

use super::Rect;
use crate::error::{Code, Fault};
use std::fmt;

/// Error of a 2-D drawing function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawError {
    /// A width or a height below zero.
    NegativeSize {
        /// Requested width in pixels.
        w: Size,
        /// Requested height in pixels.
        h: Size,
    },
    /// A radius below zero.
    NegativeRadius {
        /// Requested radius in pixels.
        r: Size,
    },
    /// A line's width below zero.
    NegativeWidth {
        /// Requested width in pixels.
        w: Size,
    },
    /// A point of a curve that is too far from the frame for its steps to be exact.
    FarPoint {
        /// Largest coordinate in pixels.
        most: i32,
        /// The coordinate.
        at: Size,
    },
    /// A source rectangle that is not entirely inside the frame.
    SourceOutside {
        /// The requested rectangle.
        rect: Rect,
        /// Width of the frame in pixels.
        width: u32,
        /// Height of the frame in pixels.
        height: u32,
    },
    /// A payload whose length does not match its rectangle.
    WrongLength {
        /// Width in pixels.
        w: i32,
        /// Height in pixels.
        h: i32,
        /// Length of the rectangle's pixels in bytes.
        expected: u64,
        /// Length of the payload in bytes.
        found: u64,
    },
    /// A payload that ends within a record.
    BrokenRecord {
        /// Length of one record in bytes.
        record: u64,
        /// Length of the payload in bytes.
        found: u64,
    },
    /// Text that is not UTF-8.
    NotUtf8 {
        /// Length in bytes of the valid UTF-8 before the error.
        at: u64,
    },
}

impl fmt::Display for DrawError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DrawError::NegativeSize { w, h } => write!(f, "sizes are 0 or more, not {w}x{h}"),
            DrawError::NegativeRadius { r } => write!(f, "a radius is 0 or more, not {r}"),
            DrawError::NegativeWidth { w } => write!(f, "a width is 0 or more, not {w}"),
            DrawError::FarPoint { most, at } => {
                write!(f, "the points of a curve are within {most} pixels of (0,0), not at {at}")
            }
            DrawError::SourceOutside { rect: Rect { x, y, w, h }, width, height } => {
                write!(f, "{w}x{h} pixels from ({x},{y}) are not all inside the frame's {width}x{height}")
            }
            DrawError::WrongLength { w, h, expected, found } => {
                write!(f, "{expected} bytes expected for {w}x{h} pixels, {found} found")
            }
            DrawError::BrokenRecord { record, found } => {
                write!(f, "records of {record} bytes expected, {found} bytes found")
            }
            DrawError::NotUtf8 { at } => write!(f, "utf-8 expected, broken at byte {at}"),
        }
    }
}

impl std::error::Error for DrawError {}

/// A real size in an error, stored as the bits of an f64 so that errors implement `Eq`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(u64);

impl<T: Into<f64>> From<T> for Size {
    fn from(v: T) -> Self {
        Size(v.into().to_bits())
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Exponent form for very large sizes, so that a message stays one short line.
        let v = f64::from_bits(self.0);
        if v.abs() < 1e15 { write!(f, "{v}") } else { write!(f, "{v:e}") }
    }
}

impl DrawError {
    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            DrawError::NegativeSize { .. }
            | DrawError::NegativeRadius { .. }
            | DrawError::NegativeWidth { .. }
            | DrawError::FarPoint { .. }
            | DrawError::SourceOutside { .. } => Code::Range,
            DrawError::WrongLength { .. } | DrawError::BrokenRecord { .. } | DrawError::NotUtf8 { .. } => {
                Code::Format
            }
        }
    }
}

impl From<DrawError> for Fault {
    fn from(e: DrawError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

impl Rect {
    /// Returns this rectangle, or an error if a side is negative.
    pub(super) fn checked(self) -> Result<Self, DrawError> {
        let Rect { w, h, .. } = self;
        if w < 0 || h < 0 { Err(DrawError::NegativeSize { w: w.into(), h: h.into() }) } else { Ok(self) }
    }
}

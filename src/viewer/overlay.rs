//! What lies over the picture: text in two corners, and the inspector's enlarged pixels. Data alone; the window draws it.

use crate::memory::Rgba;

/// Everything over the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlay {
    /// In the upper left corner: help, plan.
    pub top: Vec<String>,
    /// In the lower left corner: what is seen, messages.
    pub bottom: Vec<String>,
    /// The inspector.
    pub zoom: Option<Zoom>,
}

/// The pixels about the pointer, enlarged, and what is known of the middle one.
#[derive(Clone, Debug, PartialEq)]
pub struct Zoom {
    /// Pixels a side, odd; the one in the middle is under the pointer.
    pub side: usize,
    /// The pixels, row after row; `None` off the frame.
    pub colors: Vec<Option<Rgba>>,
    /// Text below them.
    pub lines: Vec<String>,
    /// Whether the pointer is in the right half of the frame, so that this belongs in the left.
    pub belongs_left: bool,
}

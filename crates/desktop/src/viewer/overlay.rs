//! The overlay: text in two corners, and the inspector's enlarged pixels. Plain data; the window
//! draws it.

use fbptr_core::memory::Rgba;

/// Contents drawn over the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlay {
    /// The list of keys, or the plan: stands below the picture, which is made smaller for it.
    pub list: Vec<String>,
    /// Lines in the upper left corner: the frame rate.
    pub top: Vec<String>,
    /// Lines in the lower left corner: status, messages.
    pub bottom: Vec<String>,
    /// The inspector, if it is shown.
    pub zoom: Option<Zoom>,
    /// Rectangles of the frame that hold text, which the lower text must not cover: left, top,
    /// right, bottom, in pixels.
    pub captions: Vec<[usize; 4]>,
}

/// The enlarged pixels around the pointer, and details of the middle one.
#[derive(Clone, Debug, PartialEq)]
pub struct Zoom {
    /// Pixels on each side, odd; the middle one is under the pointer.
    pub side: usize,
    /// The pixels, row after row; `None` outside the frame.
    pub colors: Vec<Option<Rgba>>,
    /// Lines of text below the pixels.
    pub lines: Vec<String>,
    /// True if the pointer is in the right half of the frame, so the inspector is placed on the
    /// left.
    pub belongs_left: bool,
}

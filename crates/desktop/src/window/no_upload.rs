//! Fallback of `upload.rs` without X11: minifb uploads the whole window.

use std::ops::Range;

/// Uploads to one window.
pub(super) struct Upload;

impl Upload {
    /// Prepares uploads.
    pub fn new(_: &minifb::Window) -> Upload {
        Upload
    }

    /// Shows `words`, the window of `size` pixels. Returns whether they are on the screen;
    /// if not, the next call must have all words.
    pub fn show(
        &mut self,
        window: &mut minifb::Window,
        words: &[u32],
        size: [usize; 2],
        _: Range<usize>,
    ) -> bool {
        window.update_with_buffer(words, size[0], size[1]).is_ok()
    }

    /// Handles the window's events.
    pub fn idle(&mut self, window: &mut minifb::Window) {
        window.update();
    }
}

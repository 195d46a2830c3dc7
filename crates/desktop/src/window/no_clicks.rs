//! Fallback of `clicks.rs` without X11: only presses that a frame's button state shows are
//! detected.

/// A type without values.
pub(super) enum Clicks {}

impl Clicks {
    /// Returns `None`: presses between two frames are not reported.
    pub fn new(_: &minifb::Window) -> Option<Clicks> {
        None
    }

    /// Never called, as the type has no values.
    pub fn missed(&mut self, _: u8, _: u8) -> Option<([f32; 2], [u32; 3])> {
        match *self {}
    }
}

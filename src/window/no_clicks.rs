//! Where there is no X11: no presses but those that a frame of the window shows.

/// Never made.
pub(super) enum Clicks {}

impl Clicks {
    /// `None`: nothing tells of presses between two frames.
    pub fn new(_: &minifb::Window) -> Option<Clicks> {
        None
    }

    /// Never called.
    pub fn missed(&mut self, _: u8, _: u8) -> Option<([f32; 2], [u32; 3])> {
        match *self {}
    }
}

//! Fullscreen where the window system has no way to it past minifb.

use minifb::Window;

/// See `fullscreen.rs`.
#[derive(Default)]
pub(super) struct Fullscreen;

impl Fullscreen {
    /// # Errors
    /// Always.
    pub fn toggle(&mut self, _: &Window) -> Result<(), String> {
        Err("no fullscreen: only windows on X11 can have it".to_owned())
    }
}

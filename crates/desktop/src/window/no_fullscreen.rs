//! Fallback of `fullscreen.rs` for window systems other than X11.

use minifb::Window;

/// Fullscreen state; the mode is not available.
#[derive(Default)]
pub(super) struct Fullscreen;

impl Fullscreen {
    /// # Errors
    /// Always: fullscreen needs X11.
    pub fn toggle(&mut self, _: &Window) -> Result<(), String> {
        Err("no fullscreen: only windows on X11 can have it".to_owned())
    }
}

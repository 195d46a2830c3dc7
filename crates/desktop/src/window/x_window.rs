//! A window as the X server knows it, with a connection to it beside minifb's.
//!
//! minifb's own connection is inside of Xlib, which ends the process at an error and keeps the events.

use minifb::HasWindowHandle;
use raw_window_handle::RawWindowHandle;
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{Screen, Window};
use x11rb::rust_connection::RustConnection;

pub(super) type Error = Box<dyn std::error::Error>;

/// A window, and a connection of its own.
pub(super) struct XWindow {
    pub connection: RustConnection,
    pub window: Window,
    /// Index of its screen.
    screen: usize,
}

impl XWindow {
    /// Connects to the server of `window`.
    ///
    /// # Errors
    /// If it is no window on X11, or there is no more room for connections.
    pub fn of(window: &minifb::Window) -> Result<XWindow, Error> {
        let handle = window.window_handle().map(|handle| handle.as_raw());
        let Ok(RawWindowHandle::Xlib(handle)) = handle else { return Err("it is no window on X11".into()) };
        let window = Window::try_from(handle.window)?;
        let (connection, screen) = x11rb::connect(None)?;
        Ok(XWindow { connection, window, screen })
    }

    /// Returns its screen.
    pub fn screen(&self) -> Option<&Screen> {
        self.connection.setup().roots.get(self.screen)
    }
}

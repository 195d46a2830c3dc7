//! Detection of windows that others destroy.
//!
//! A window manager asks a window to close, but `xkill` ends its client's connection, and any
//! client may destroy the window itself. The next call of Xlib would then end the process at once.
//! A connection of our own is told of the destruction, and survives it.
//!
//! In: a window. Out: whether it is still there, asked before each use of it. Runs on the main
//! thread and never blocks after its creation. Without X every window counts as present.

use super::x_window::XWindow;
use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{ChangeWindowAttributesAux, ConnectionExt as _, EventMask, Window};
use x11rb::rust_connection::RustConnection;

/// Watches one window.
pub(super) struct Presence {
    connection: Option<(RustConnection, Window)>,
    is_lost: bool,
}

impl Presence {
    /// Starts watching `window`.
    pub fn new(window: &minifb::Window) -> Presence {
        Presence { connection: connect(window), is_lost: false }
    }

    /// Returns whether the window has been destroyed, or the window system has ended.
    pub fn is_lost(&mut self) -> bool {
        if let Some((connection, window)) = &self.connection {
            loop {
                match connection.poll_for_event() {
                    Ok(Some(Event::DestroyNotify(event))) => self.is_lost |= event.window == *window,
                    Ok(Some(_)) => {}
                    Ok(None) => break,
                    Err(_) => {
                        self.is_lost = true;
                        break;
                    }
                }
            }
        }
        self.is_lost
    }
}

fn connect(window: &minifb::Window) -> Option<(RustConnection, Window)> {
    let XWindow { connection, window, .. } = XWindow::of(window).ok()?;
    let wanted = ChangeWindowAttributesAux::new().event_mask(EventMask::STRUCTURE_NOTIFY);
    connection.change_window_attributes(window, &wanted).ok()?.check().ok()?;
    connection.flush().ok()?;
    Some((connection, window))
}

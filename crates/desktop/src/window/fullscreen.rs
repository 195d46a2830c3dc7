//! Fullscreen mode of a window on X11.
//!
//! minifb neither has such a call nor reports the screen's size. Its windows on X11 (XWayland
//! included) have an id, with which a second connection to the X server can request it: from the
//! window manager (`_NET_WM_STATE_FULLSCREEN` of the Extended Window Manager Hints 1.5), or,
//! without one, by moving and resizing the window. On native Wayland, Windows and macOS minifb
//! gives no access to the window, so the request fails with a message.

use super::x_window::{Error, XWindow};
use minifb::Window;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConfigureWindowAux, ConnectionExt, EventMask, Window as WindowId,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// Fullscreen state of one window.
#[derive(Default)]
pub(super) struct Fullscreen {
    screen: Option<RootWindow>,
    is_on: bool,
}

impl Fullscreen {
    /// Switches between fullscreen and the previous size.
    ///
    /// # Errors
    /// A message of one line if fullscreen is not available.
    pub fn toggle(&mut self, window: &Window) -> Result<(), String> {
        let refused = |e: Error| format!("no fullscreen: {e}");
        let screen = match self.screen.take() {
            Some(screen) => screen,
            None => RootWindow::of(window).map_err(refused)?,
        };
        let screen = self.screen.insert(screen);
        screen.set_fullscreen(!self.is_on).map_err(refused)?;
        self.is_on = !self.is_on;
        Ok(())
    }
}

/// An X screen with the window on it.
struct RootWindow {
    connection: RustConnection,
    root: WindowId,
    size: [u32; 2],
    window: WindowId,
    /// Position and size to restore, if the window was moved without a window manager.
    before: Option<[i32; 4]>,
}

impl RootWindow {
    fn of(window: &Window) -> Result<RootWindow, Error> {
        let place = XWindow::of(window)?;
        let screen = place.screen().ok_or("the window has no screen")?;
        let (root, size) = (screen.root, [screen.width_in_pixels.into(), screen.height_in_pixels.into()]);
        let XWindow { connection, window, .. } = place;
        Ok(RootWindow { connection, root, size, window, before: None })
    }

    fn set_fullscreen(&mut self, on: bool) -> Result<(), Error> {
        match self.has_window_manager()? {
            true => self.ask_window_manager(on)?,
            false => self.place(on)?,
        }
        self.connection.sync()?;
        Ok(())
    }

    fn atom(&self, name: &str) -> Result<u32, Error> {
        Ok(self.connection.intern_atom(false, name.as_bytes())?.reply()?.atom)
    }

    fn has_window_manager(&self) -> Result<bool, Error> {
        let check = self.atom("_NET_SUPPORTING_WM_CHECK")?;
        let reply = self.connection.get_property(false, self.root, check, AtomEnum::WINDOW, 0, 1)?.reply()?;
        Ok(reply.value_len > 0)
    }

    /// Requests the state from the window manager.
    fn ask_window_manager(&self, on: bool) -> Result<(), Error> {
        let (state, fullscreen) = (self.atom("_NET_WM_STATE")?, self.atom("_NET_WM_STATE_FULLSCREEN")?);
        // 1 adds, 0 removes; the last 1 marks the sender as an application.
        let event = ClientMessageEvent::new(32, self.window, state, [u32::from(on), fullscreen, 0, 1, 0]);
        let mask = EventMask::SUBSTRUCTURE_REDIRECT | EventMask::SUBSTRUCTURE_NOTIFY;
        self.connection.send_event(false, self.root, mask, event)?;
        Ok(())
    }

    /// Moves and resizes the window without a window manager.
    fn place(&mut self, on: bool) -> Result<(), Error> {
        let [width, height] = self.size.map(|side| side as i32);
        let [x, y, width, height] = match (on, self.before.take()) {
            (true, _) => {
                let now = self.connection.get_geometry(self.window)?.reply()?;
                self.before = Some([now.x.into(), now.y.into(), now.width.into(), now.height.into()]);
                [0, 0, width, height]
            }
            (false, Some(before)) => before,
            (false, None) => return Ok(()),
        };
        let (width, height) = (width.max(1) as u32, height.max(1) as u32);
        let aux = ConfigureWindowAux::new().x(x).y(y).width(width).height(height);
        self.connection.configure_window(self.window, &aux)?;
        Ok(())
    }
}

//! Finds the mouse presses that minifb's state of the buttons does not show.
//!
//! minifb 0.29 has no callback for the mouse. Its `update` takes all waiting events at once and keeps
//! the last state of each button, so a press and its release within one frame leave no trace. An X
//! server sends core button events to one client of a window only, but the raw events of XInput 2.1
//! to any number of clients.
//!
//! In: raw presses and releases from a connection of its own to the X server, and the state of the
//! buttons at each frame. Out: the number of presses that are over and that no frame has shown, each
//! once. On the main thread; nothing waits but short questions to the X server, one to three a press.
//! Without X or XInput 2.1 there are no raw events, and a press must last until the next frame.
//! `tests/window/events.rs` would notice presses that are lost or told twice.

use minifb::HasWindowHandle;
use raw_window_handle::RawWindowHandle;
use x11rb::connection::Connection;
use x11rb::errors::ReplyError;
use x11rb::protocol::Event;
use x11rb::protocol::xinput::{ConnectionExt as _, Device, EventMask, XIEventMask};
use x11rb::protocol::xproto::{ConnectionExt as _, Window};
use x11rb::rust_connection::RustConnection;

/// The buttons that are followed: left, middle, right.
const BUTTONS: usize = 3;

/// Counts presses by button: those of the X server, and those that the state has shown.
#[derive(Debug, Default)]
struct Tally {
    /// Raw presses.
    told: [u32; BUTTONS],
    /// Presses that the state has shown, or that were reported as missed.
    seen: [u32; BUTTONS],
    /// Buttons that are down after the raw events so far, as bits.
    down: u8,
}

impl Tally {
    fn press(&mut self, button: usize) {
        self.told[button] += 1;
        self.down |= 1 << button;
    }

    fn release(&mut self, button: usize) {
        self.down &= !(1 << button);
    }

    /// The presses that are over and were missed, by button, when the state goes from `before` to
    /// `now`. Both sources come at their own times, so they are compared when both have the button up.
    fn missed(&mut self, before: u8, now: u8) -> [u32; BUTTONS] {
        std::array::from_fn(|b| {
            let is = |state: u8| state >> b & 1 == 1;
            if is(now) && !is(before) {
                self.seen[b] += 1;
            }
            // The state will show one that is still down, and the raw event of one that it has shown
            // may still come.
            if is(now) || is(before) || is(self.down) {
                return 0;
            }
            self.told[b].saturating_sub(std::mem::replace(&mut self.seen[b], self.told[b]))
        })
    }
}

/// Watches the presses on one window.
pub(super) struct Clicks {
    connection: RustConnection,
    root: Window,
    window: Window,
    tally: Tally,
}

impl Clicks {
    /// A watch on `window`, or `None` without X or XInput 2.1.
    pub fn new(window: &minifb::Window) -> Option<Clicks> {
        let RawWindowHandle::Xlib(handle) = window.window_handle().ok()?.as_raw() else { return None };
        let window = Window::try_from(handle.window).ok()?;
        let (connection, screen) = x11rb::connect(None).ok()?;
        let version = connection.xinput_xi_query_version(2, 2).ok()?.reply().ok()?;
        if (version.major_version, version.minor_version) < (2, 1) {
            return None;
        }
        let root = connection.setup().roots.get(screen)?.root;
        let mask = XIEventMask::RAW_BUTTON_PRESS | XIEventMask::RAW_BUTTON_RELEASE;
        let masks = [EventMask { deviceid: Device::ALL_MASTER.into(), mask: vec![mask] }];
        connection.xinput_xi_select_events(root, &masks).ok()?.check().ok()?;
        Some(Clicks { connection, root, window, tally: Tally::default() })
    }

    /// The presses that are over and were missed, by button, when the state of the buttons goes
    /// from `before` to `now`; and the pointer's place now, in pixels of the window. `None` if
    /// there are none.
    pub fn missed(&mut self, before: u8, now: u8) -> Option<([f32; 2], [u32; BUTTONS])> {
        while let Ok(Some(event)) = self.connection.poll_for_event() {
            match event {
                Event::XinputRawButtonPress(e) => {
                    if let Some(button) = self.button(e.detail)
                        && self.is_on_window().unwrap_or(false)
                    {
                        self.tally.press(button);
                    }
                }
                Event::XinputRawButtonRelease(e) => {
                    if let Some(button) = self.button(e.detail) {
                        self.tally.release(button);
                    }
                }
                _ => {}
            }
        }
        let missed = self.tally.missed(before, now);
        if missed == [0; BUTTONS] {
            return None;
        }
        let pointer = self.connection.query_pointer(self.window).ok()?.reply().ok()?;
        Some(([pointer.win_x.into(), pointer.win_y.into()], missed))
    }

    /// The button that a device's button stands for: raw events do not know the user's mapping of
    /// left and right.
    fn button(&self, detail: u32) -> Option<usize> {
        let mapping = self.connection.get_pointer_mapping().ok()?.reply().ok()?.map;
        let logical = *mapping.get(usize::try_from(detail).ok()?.checked_sub(1)?)?;
        usize::from(logical).checked_sub(1).filter(|b| *b < BUTTONS)
    }

    /// Whether the pointer is on the window: within its bounds, where no other window covers it.
    fn is_on_window(&self) -> Result<bool, ReplyError> {
        let (pointer, size, top) = (
            self.connection.query_pointer(self.window)?,
            self.connection.get_geometry(self.window)?,
            self.connection.query_pointer(self.root)?,
        );
        let (pointer, size, top) = (pointer.reply()?, size.reply()?, top.reply()?.child);
        let is_within = |at: i16, length: u16| (0..i32::from(length)).contains(&i32::from(at));
        if !pointer.same_screen
            || !is_within(pointer.win_x, size.width)
            || !is_within(pointer.win_y, size.height)
        {
            return Ok(false);
        }
        // The root's child is the window itself, or the frame that a window manager put around it.
        let mut window = self.window;
        loop {
            let parent = self.connection.query_tree(window)?.reply()?.parent;
            if parent == self.root || parent == x11rb::NONE {
                return Ok(window == top);
            }
            window = parent;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_press_is_shown_or_missed_once_whichever_source_is_first() {
        // Down and up between two frames.
        let mut tally = Tally::default();
        tally.press(0);
        tally.release(0);
        assert_eq!(tally.missed(0, 0), [1, 0, 0]);
        assert_eq!(tally.missed(0, 0), [0; 3]);
        // Down in one frame, up in the next.
        tally.press(2);
        assert_eq!(tally.missed(0, 4), [0; 3]);
        tally.release(2);
        assert_eq!(tally.missed(4, 0), [0; 3]);
        assert_eq!(tally.missed(0, 0), [0; 3]);
        // The raw press comes before a frame, its release after it.
        tally.press(1);
        assert_eq!(tally.missed(0, 0), [0; 3]);
        tally.release(1);
        assert_eq!(tally.missed(0, 0), [0, 1, 0]);
        // The state shows it before its raw events come.
        assert_eq!(tally.missed(0, 1), [0; 3]);
        tally.press(0);
        tally.release(0);
        assert_eq!(tally.missed(1, 0), [0; 3]);
        assert_eq!(tally.missed(0, 0), [0; 3]);
        // Three in a row, of which a frame showed one.
        tally.press(0);
        assert_eq!(tally.missed(0, 1), [0; 3]);
        for _ in 0..2 {
            tally.release(0);
            tally.press(0);
        }
        tally.release(0);
        assert_eq!(tally.missed(1, 0), [0; 3]);
        assert_eq!(tally.missed(0, 0), [2, 0, 0]);
        // A press without raw events does not hide a later one.
        assert_eq!(tally.missed(0, 1), [0; 3]);
        assert_eq!(tally.missed(1, 0), [0; 3]);
        assert_eq!(tally.missed(0, 0), [0; 3]);
        tally.press(0);
        tally.release(0);
        assert_eq!(tally.missed(0, 0), [1, 0, 0]);
    }
}

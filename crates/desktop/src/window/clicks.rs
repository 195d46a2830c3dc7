//! Detection of mouse presses that minifb's button state does not show.
//!
//! minifb 0.29 has no mouse callback. Its `update` processes all pending events at once and stores
//! the last state of each button, so a press and release within one frame leave no trace. An X
//! server sends core button events to only one client of a window, but the raw events of XInput 2.1
//! to any number of clients.
//!
//! In: raw presses and releases from a separate connection to the X server, and the button state at
//! each frame. Out: the number of completed presses that no frame has shown, each counted once.
//! Runs on the main thread; it blocks only for short queries to the X server, one to three for each
//! press. Without X or XInput 2.1 there are no raw events, and a press must last until the next
//! frame. `tests/window/events.rs` detects presses that are lost or reported twice.

use super::x_window::XWindow;
use x11rb::connection::Connection;
use x11rb::errors::ReplyError;
use x11rb::protocol::Event;
use x11rb::protocol::xinput::{ConnectionExt as _, Device, EventMask, XIEventMask};
use x11rb::protocol::xproto::{ConnectionExt as _, Window};
use x11rb::rust_connection::RustConnection;

/// Number of tracked buttons: left, middle, right.
const BUTTONS: usize = 3;

/// Counts of presses for each button: those reported by the X server, and those shown by the button
/// state.
#[derive(Debug, Default)]
struct Tally {
    /// Number of raw presses.
    told: [u32; BUTTONS],
    /// Number of presses that the state has shown, or that were reported as missed.
    seen: [u32; BUTTONS],
    /// Bit mask of the buttons that are down according to the raw events so far.
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

    /// Returns for each button how many completed presses were missed, when the state goes from
    /// `before` to `now`. The two sources are not synchronised, so they are compared when both have
    /// the button up.
    fn missed(&mut self, before: u8, now: u8) -> [u32; BUTTONS] {
        std::array::from_fn(|b| {
            let is = |state: u8| state >> b & 1 == 1;
            if is(now) && !is(before) {
                self.seen[b] += 1;
            }
            // A button that is still down will be shown by the state, and the raw event of a press
            // that it has shown may still come.
            if is(now) || is(before) || is(self.down) {
                return 0;
            }
            self.told[b].saturating_sub(std::mem::replace(&mut self.seen[b], self.told[b]))
        })
    }
}

/// Tracks the presses on one window.
pub(super) struct Clicks {
    connection: RustConnection,
    root: Window,
    window: Window,
    tally: Tally,
}

impl Clicks {
    /// Starts tracking `window`; `None` without X or XInput 2.1.
    pub fn new(window: &minifb::Window) -> Option<Clicks> {
        let place = XWindow::of(window).ok()?;
        let root = place.screen()?.root;
        let XWindow { connection, window, .. } = place;
        let version = connection.xinput_xi_query_version(2, 2).ok()?.reply().ok()?;
        if (version.major_version, version.minor_version) < (2, 1) {
            return None;
        }
        let mask = XIEventMask::RAW_BUTTON_PRESS | XIEventMask::RAW_BUTTON_RELEASE;
        let masks = [EventMask { deviceid: Device::ALL_MASTER.into(), mask: vec![mask] }];
        connection.xinput_xi_select_events(root, &masks).ok()?.check().ok()?;
        Some(Clicks { connection, root, window, tally: Tally::default() })
    }

    /// Returns the pointer's current position, in pixels of the window, and for each button how
    /// many completed presses were missed, when the button state goes from `before` to `now`.
    /// `None` if there are none.
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

    /// Maps a device's button number to a logical button: raw events ignore the user's mapping of
    /// left and right.
    fn button(&self, detail: u32) -> Option<usize> {
        let mapping = self.connection.get_pointer_mapping().ok()?.reply().ok()?.map;
        let logical = *mapping.get(usize::try_from(detail).ok()?.checked_sub(1)?)?;
        usize::from(logical).checked_sub(1).filter(|b| *b < BUTTONS)
    }

    /// Returns whether the pointer is on the window: within its bounds, and not over another window
    /// that covers it.
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

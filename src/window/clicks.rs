//! Presses of mouse buttons that are over before anybody looks.
//!
//! minifb tells which buttons are down when it is asked, and takes all waiting events at once: a press and its release in
//! between leave no trace there. An X server with XInput 2.1 tells whoever asks of each press on any window. This keeps count
//! of those on ours, on the main thread, and answers which ones the looks at minifb's state have missed. Elsewhere there
//! are none to be had, and a press must last from one look to the next.

/// The buttons that are followed: left, middle, right.
const BUTTONS: usize = 3;

/// What was pressed, beside what was seen.
#[derive(Debug, Default)]
struct Tally {
    /// Presses of each button that the system told of, and that were seen or made up for.
    told: [u32; BUTTONS],
    seen: [u32; BUTTONS],
    /// Buttons that are down, as the system tells.
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

    /// The presses that are over and were missed, by button, when the state goes from `before` to `now`; counted once both
    /// know of none that is down.
    fn missed(&mut self, before: u8, now: u8) -> [u32; BUTTONS] {
        std::array::from_fn(|b| {
            let is = |state: u8| state >> b & 1 == 1;
            if is(now) && !is(before) {
                self.seen[b] += 1;
            }
            // One that is still down will be seen, and one that was seen first will be told of.
            if is(now) || is(before) || is(self.down) {
                return 0;
            }
            self.told[b].saturating_sub(std::mem::replace(&mut self.seen[b], self.told[b]))
        })
    }
}

#[cfg(all(unix, not(target_os = "macos")))]
pub use x11::Clicks;

#[cfg(all(unix, not(target_os = "macos")))]
mod x11 {
    use super::{BUTTONS, Tally};
    use raw_window_handle::{HasWindowHandle, RawWindowHandle};
    use x11rb::connection::Connection;
    use x11rb::errors::ReplyError;
    use x11rb::protocol::Event;
    use x11rb::protocol::xinput::{ConnectionExt as _, Device, EventMask, XIEventMask};
    use x11rb::protocol::xproto::{ConnectionExt as _, Window};
    use x11rb::rust_connection::RustConnection;

    /// Counts the presses on one window.
    pub struct Clicks {
        connection: RustConnection,
        root: Window,
        window: Window,
        tally: Tally,
    }

    impl Clicks {
        /// `None` where the window system does not tell.
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

        /// The presses since the last call that are over and were not seen, by button; and where the pointer is now, in
        /// pixels of the window. The buttons held went from `before` to `now` meanwhile.
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

        /// The button that the user means by a device's button: raw events do not know who is left-handed.
        fn button(&self, detail: u32) -> Option<usize> {
            let mapping = self.connection.get_pointer_mapping().ok()?.reply().ok()?.map;
            let logical = *mapping.get(usize::try_from(detail).ok()?.checked_sub(1)?)?;
            usize::from(logical).checked_sub(1).filter(|b| *b < BUTTONS)
        }

        /// Whether the window under the pointer is ours, or the frame that a window manager put around it.
        fn is_on_window(&self) -> Result<bool, ReplyError> {
            let under = self.connection.query_pointer(self.root)?.reply()?.child;
            let mut window = self.window;
            loop {
                let parent = self.connection.query_tree(window)?.reply()?.parent;
                if parent == self.root || parent == x11rb::NONE {
                    return Ok(window == under);
                }
                window = parent;
            }
        }
    }
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
pub struct Clicks;

#[cfg(not(all(unix, not(target_os = "macos"))))]
impl Clicks {
    /// Nobody tells.
    pub fn new(_: &minifb::Window) -> Option<Clicks> {
        None
    }

    /// Never asked.
    pub fn missed(&mut self, _: u8, _: u8) -> Option<([f32; 2], [u32; BUTTONS])> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_seen_is_not_told_again_in_whatever_order_it_comes() {
        // Down and up between two looks.
        let mut tally = Tally::default();
        tally.press(0);
        tally.release(0);
        assert_eq!(tally.missed(0, 0), [1, 0, 0]);
        assert_eq!(tally.missed(0, 0), [0; 3]);
        // Seen down at one look, up at the next.
        tally.press(2);
        assert_eq!(tally.missed(0, 4), [0; 3]);
        tally.release(2);
        assert_eq!(tally.missed(4, 0), [0; 3]);
        assert_eq!(tally.missed(0, 0), [0; 3]);
        // Told down before the look, and up after the next one, which saw neither.
        tally.press(1);
        assert_eq!(tally.missed(0, 0), [0; 3]);
        tally.release(1);
        assert_eq!(tally.missed(0, 0), [0, 1, 0]);
        // Seen before it was told of.
        assert_eq!(tally.missed(0, 1), [0; 3]);
        tally.press(0);
        tally.release(0);
        assert_eq!(tally.missed(1, 0), [0; 3]);
        assert_eq!(tally.missed(0, 0), [0; 3]);
        // Three in a row, of which one was seen.
        tally.press(0);
        assert_eq!(tally.missed(0, 1), [0; 3]);
        for _ in 0..2 {
            tally.release(0);
            tally.press(0);
        }
        tally.release(0);
        assert_eq!(tally.missed(1, 0), [0; 3]);
        assert_eq!(tally.missed(0, 0), [2, 0, 0]);
        // One that nobody told of is none that is owed.
        assert_eq!(tally.missed(0, 1), [0; 3]);
        assert_eq!(tally.missed(1, 0), [0; 3]);
        assert_eq!(tally.missed(0, 0), [0; 3]);
        tally.press(0);
        tally.release(0);
        assert_eq!(tally.missed(0, 0), [1, 0, 0]);
    }
}

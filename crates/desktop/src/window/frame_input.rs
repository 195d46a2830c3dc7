//! Input of one frame of a program that draws in a window by itself: keys, text, mouse and time.
//!
//! In: the window's reports since the last frame. Out: the state at this frame, and what happened in
//! between: a key that was pressed and released between two frames is not lost. Uses no window
//! system, so all of it is tested without a screen.

use minifb::Key;

/// Keyboard, mouse, time, and the flag that ends the program; see [`run`](super::program::run).
///
/// Keys have the names of `EVENT key` lines: `a`, `7`, `left`, `space`, `escape`, `f5`.
#[derive(Clone, Debug, Default)]
pub struct FrameInput {
    /// Seconds since the last frame; 0 in the first one.
    pub delta_s: f64,
    /// Number of the frame, from 0.
    pub frame: u64,
    /// Column and row under the pointer, which may be off the frame.
    pub mouse: [i32; 2],
    /// Mouse buttons that are held: left, middle, right.
    pub buttons: [bool; 3],
    /// Steps of the wheel since the last frame: to the right, and upwards.
    pub wheel: [i32; 2],
    /// Characters typed since the last frame.
    pub text: String,
    /// Ends the program after this frame when it is set.
    pub close: bool,
    /// Set while the frame is shown as a cathode ray tube does. K and F8 change it before the frame; a
    /// program may set it, too, as one does for which K means something else.
    pub crt: bool,
    /// Names of the keys that are held.
    held: Vec<String>,
    /// Names of the keys that went down since the last frame.
    pressed: Vec<String>,
    /// Set when the first frame has begun.
    has_begun: bool,
}

impl FrameInput {
    /// Returns whether a key is held.
    pub fn is_down(&self, key: &str) -> bool {
        self.held.iter().any(|held| held == key)
    }

    /// Returns whether a key went down since the last frame; holding it counts once.
    pub fn was_pressed(&self, key: &str) -> bool {
        self.pressed.iter().any(|pressed| pressed == key)
    }

    /// Begins a frame, `delta_s` seconds after the last one: forgets what happened before it.
    pub(super) fn begin(&mut self, delta_s: f64) {
        match self.has_begun {
            true => (self.frame, self.delta_s) = (self.frame + 1, delta_s),
            false => self.has_begun = true,
        }
        self.wheel = [0; 2];
        self.text.clear();
        self.pressed.clear();
    }

    /// Notes a key that went down or up.
    pub(super) fn key(&mut self, key: Key, is_down: bool) {
        let name = key_name(key);
        match is_down {
            true if self.is_down(&name) => {}
            true => {
                self.pressed.push(name.clone());
                self.held.push(name);
            }
            false => self.held.retain(|held| *held != name),
        }
    }
}

/// Returns the key's name in `EVENT` lines: minifb's name in lower case, digits as themselves.
pub(super) fn key_name(key: Key) -> String {
    let name = format!("{key:?}").to_ascii_lowercase();
    match name.strip_prefix("key") {
        Some(digit) => digit.to_string(),
        None => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_counts_once_however_long_it_is_held() {
        let mut input = FrameInput::default();
        input.begin(0.0);
        input.key(Key::Left, true);
        input.key(Key::Left, true);
        assert!(input.is_down("left") && input.was_pressed("left"));
        assert!(!input.is_down("right") && !input.was_pressed("right"));
        input.begin(0.5);
        input.key(Key::Left, true);
        assert!(input.is_down("left") && !input.was_pressed("left"), "a repeat is no press");
        input.key(Key::Left, false);
        assert!(!input.is_down("left"));
    }

    #[test]
    fn a_tap_between_two_frames_is_a_press() {
        let mut input = FrameInput::default();
        input.begin(0.0);
        input.key(Key::Key7, true);
        input.key(Key::Key7, false);
        assert!(input.was_pressed("7") && !input.is_down("7"));
        input.begin(0.1);
        assert!(!input.was_pressed("7"));
    }

    #[test]
    fn the_first_frame_takes_no_time_and_later_ones_are_counted() {
        let mut input = FrameInput::default();
        let frames: Vec<_> = [9.0, 0.25, 0.5]
            .map(|delta_s| {
                input.begin(delta_s);
                (input.frame, input.delta_s)
            })
            .into();
        assert_eq!(frames, [(0, 0.0), (1, 0.25), (2, 0.5)]);
        (input.wheel, input.text) = ([0, 3], "a".into());
        input.begin(0.1);
        assert!(input.wheel == [0, 0] && input.text.is_empty());
    }
}

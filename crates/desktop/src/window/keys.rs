//! Key bindings of the window: one table that the window acts on and that the help overlay prints.

use minifb::Key;

/// An action that a key triggers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// Close the window.
    Quit,
    /// Save the shown frame as PNG.
    Snapshot,
    /// Pause the stream, or resume it.
    Pause,
    /// Let a paused stream continue by one frame.
    Step,
    /// Show or hide the list of keys.
    Help,
    /// Show or hide the frame rate, and a server's addresses, clients and rates.
    FrameRate,
    /// Switch between fullscreen and the window.
    Fullscreen,
    /// Switch between scaling the frame to the window and integer factors.
    Scaling,
    /// Show or hide details of the pixel under the pointer.
    Inspect,
    /// Show the frame as a cathode ray tube does, or its pixels as they are.
    Crt,
}

/// A key, its name and its action.
pub struct Binding {
    /// The key.
    pub key: Key,
    /// Name of the key on the help overlay.
    pub name: &'static str,
    /// The action that the key triggers.
    pub action: Action,
    /// Description on the help overlay.
    pub help: &'static str,
    /// True if holding the key down repeats the action.
    pub repeats: bool,
}

const fn bind(key: Key, name: &'static str, action: Action, help: &'static str) -> Binding {
    Binding { key, name, action, help, repeats: matches!(action, Action::Step) }
}

/// The bindings of all keys.
pub const BINDINGS: &[Binding] = &[
    bind(Key::Escape, "Esc", Action::Quit, "quit"),
    bind(Key::Q, "Q", Action::Quit, "quit"),
    bind(Key::F12, "F12", Action::Snapshot, "save a snapshot (PNG)"),
    bind(Key::Space, "Space", Action::Pause, "pause, go on"),
    bind(Key::Period, ".", Action::Step, "one step while paused"),
    bind(Key::F1, "F1", Action::Help, "this list"),
    bind(Key::F3, "F3", Action::FrameRate, "rates, clients, addresses"),
    bind(Key::F8, "F8", Action::Crt, "look of a tube (CRT)"),
    bind(Key::F10, "F10", Action::Scaling, "scale: whole, fit, smooth"),
    bind(Key::F11, "F11", Action::Fullscreen, "fullscreen (X11)"),
    bind(Key::I, "I", Action::Inspect, "pixel under the pointer"),
    bind(Key::K, "K", Action::Crt, "look of a tube, as F8"),
];

/// Returns the binding of a key, if it has one.
pub fn binding(key: Key) -> Option<&'static Binding> {
    BINDINGS.iter().find(|b| b.key == key)
}

impl Binding {
    /// Returns whether the key acts on the window even while clients listen to keys: Esc and the F
    /// keys do.
    pub fn is_kept(&self) -> bool {
        self.name == "Esc" || (self.name.len() > 1 && self.name.starts_with('F'))
    }
}

/// Returns the lines of the help overlay: the keys that currently have an effect.
pub fn help_lines(has_listeners: bool, is_paused: bool) -> Vec<String> {
    let works = |b: &&Binding| (b.is_kept() || !has_listeners) && (is_paused || b.action != Action::Step);
    let mut lines: Vec<String> =
        BINDINGS.iter().filter(works).map(|b| format!("{:<6} {}", b.name, b.help)).collect();
    if has_listeners {
        lines.push("all other keys go to the clients that listen".into());
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_is_bound_twice_and_all_are_in_the_help() {
        for (i, b) in BINDINGS.iter().enumerate() {
            assert!(BINDINGS[i + 1..].iter().all(|o| o.key != b.key), "{} is bound twice", b.name);
            assert!(help_lines(false, true)[i].contains(b.help));
        }
        assert!(binding(Key::Z).is_none());
    }

    #[test]
    fn the_help_names_the_keys_that_work_now() {
        let has = |lines: &[String], key: &str| lines.iter().any(|l| l.starts_with(key));
        let running = help_lines(false, false);
        assert!(has(&running, "Space") && !has(&running, ". "), "there is no step in a running stream");
        assert!(has(&help_lines(false, true), ". "));
        let listened = help_lines(true, true);
        assert!(has(&listened, "Esc") && has(&listened, "F11") && has(&listened, "F3"));
        assert!(!has(&listened, "Space") && !has(&listened, "Q ") && !has(&listened, "I "));
    }
}

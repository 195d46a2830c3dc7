//! What each key does: one table that the window acts on and that the help overlay prints.

use minifb::Key;

/// What the user asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// Close the window.
    Quit,
    /// Save what is shown as PNG.
    Snapshot,
    /// Stop the stream, or let it go on.
    Pause,
    /// Let one frame of a paused stream pass.
    Step,
    /// Show or hide the list of keys.
    Help,
    /// Show or hide the frame rate.
    FrameRate,
    /// Show or hide what lies under the pointer.
    Inspect,
}

/// A key, how it is written, and what it does.
pub struct Binding {
    /// The key.
    pub key: Key,
    /// Its name on the help overlay.
    pub name: &'static str,
    /// What it asks for.
    pub action: Action,
    /// What the help overlay says of it.
    pub help: &'static str,
    /// Whether holding it down repeats it.
    pub repeats: bool,
}

const fn bind(key: Key, name: &'static str, action: Action, help: &'static str) -> Binding {
    Binding { key, name, action, help, repeats: matches!(action, Action::Step) }
}

/// Every key of the window.
pub const BINDINGS: &[Binding] = &[
    bind(Key::Escape, "Esc", Action::Quit, "quit"),
    bind(Key::Q, "Q", Action::Quit, "quit"),
    bind(Key::F12, "F12", Action::Snapshot, "save a snapshot (PNG)"),
    bind(Key::Space, "Space", Action::Pause, "pause, go on"),
    bind(Key::Period, ".", Action::Step, "one step while paused"),
    bind(Key::F1, "F1", Action::Help, "this list"),
    bind(Key::F3, "F3", Action::FrameRate, "frame rate"),
    bind(Key::I, "I", Action::Inspect, "pixel under the pointer"),
];

/// The action of a key, if it has one.
pub fn binding(key: Key) -> Option<&'static Binding> {
    BINDINGS.iter().find(|b| b.key == key)
}

/// The lines of the help overlay.
pub fn help_lines() -> Vec<String> {
    BINDINGS.iter().map(|b| format!("{:<6} {}", b.name, b.help)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_is_bound_twice_and_all_are_in_the_help() {
        for (i, b) in BINDINGS.iter().enumerate() {
            assert!(BINDINGS[i + 1..].iter().all(|o| o.key != b.key), "{} is bound twice", b.name);
            assert!(help_lines()[i].contains(b.help));
        }
        assert!(binding(Key::Z).is_none());
    }
}

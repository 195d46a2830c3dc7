//! Key bindings: one table that the viewer acts on, and that the overlay, the help and the manual
//! print.

/// A key of the viewer. Names of a window system are translated in the window module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "keys are called what is written on them")]
pub enum Key {
    Escape,
    F1,
    F2,
    F3,
    F9,
    F10,
    F11,
    F12,
    Zero,
    One,
    Two,
    Three,
    Four,
    Five,
    A,
    B,
    C,
    D,
    E,
    G,
    H,
    I,
    J,
    K,
    N,
    O,
    P,
    Q,
    R,
    S,
    T,
    U,
    V,
    W,
    Z,
    Space,
    Period,
    Comma,
    Left,
    Right,
    Up,
    Down,
    PageUp,
    PageDown,
    Equal,
    Minus,
    LeftBracket,
    RightBracket,
    Tab,
    Backspace,
}

/// Shading style, chosen by the number keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Look {
    /// Shading as in the file.
    #[default]
    AsGiven,
    /// Edges; in N dimensions, the outlines of facets.
    Wire,
    /// Flat shading; in N dimensions, the facets' own colours.
    Flat,
    /// Gouraud shading; in N dimensions, light and shadow alone.
    Gouraud,
    /// Phong shading without textures; in N dimensions, colour and light.
    Phong,
    /// Phong shading with textures; in N dimensions, a colour for each facet's number.
    Textured,
}

/// An action that a key triggers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the table says what each does")]
pub enum Action {
    Quit,
    Help,
    Status,
    FrameRate,
    Record,
    Snapshot,
    Fullscreen,
    Scaling,
    Crt,
    Ground,
    Turntable,
    Compare,
    SaveView,
    Pause,
    StepForward,
    StepBack,
    PixelForward,
    PixelBack,
    Look(Look),
    Projection,
    Cull,
    Hide,
    Depth,
    Difference,
    Plan,
    Inspect,
    Reset,
    /// Moves along one of the viewer's axes by a number of steps: 0 ahead, 1 left, 2 up.
    Walk(usize, f64),
    /// Turns by a number of steps: left and right (1), up and down (2).
    Turn(usize, f64),
    Zoom(f64),
    NextPlane(i32),
    TurnPlane(f64),
    TurnAbout,
}

/// A key, its name and its action.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// The key.
    pub key: Key,
    /// Name of the key on the overlay.
    pub name: &'static str,
    /// The action that the key triggers.
    pub action: Action,
    /// Description for three-dimensional scenes and streams; empty if the key does nothing there.
    pub help: &'static str,
    /// Description for N-dimensional scenes; empty if the key does nothing there.
    pub help_nd: &'static str,
}

impl Binding {
    /// Returns whether holding the key down repeats the action.
    pub fn repeats(&self) -> bool {
        use Action::*;
        matches!(
            self.action,
            StepForward
                | StepBack
                | PixelForward
                | PixelBack
                | Walk(..)
                | Turn(..)
                | Zoom(..)
                | TurnPlane(..)
        )
    }
}

/// Creates a binding with separate descriptions for three and for N dimensions.
const fn bind(
    key: Key,
    name: &'static str,
    action: Action,
    help: &'static str,
    help_nd: &'static str,
) -> Binding {
    Binding { key, name, action, help, help_nd }
}

/// Creates a binding with one description.
const fn same(key: Key, name: &'static str, action: Action, help: &'static str) -> Binding {
    bind(key, name, action, help, help)
}

/// The bindings of all keys.
pub const BINDINGS: &[Binding] = &[
    same(Key::F1, "F1", Action::Help, "this list"),
    same(Key::Escape, "Esc", Action::Quit, "quit"),
    same(Key::Q, "Q", Action::Quit, "quit too"),
    bind(Key::One, "1", Action::Look(Look::Wire), "wire", "outlines of facets"),
    bind(Key::Two, "2", Action::Look(Look::Flat), "flat", "facets' own colours"),
    bind(Key::Three, "3", Action::Look(Look::Gouraud), "Gouraud", "light and shadow alone"),
    bind(Key::Four, "4", Action::Look(Look::Phong), "Phong, no textures", "colour and light"),
    bind(Key::Five, "5", Action::Look(Look::Textured), "textured", "numbers of facets as colours"),
    same(Key::Zero, "0", Action::Look(Look::AsGiven), "as the file has it"),
    bind(Key::P, "P", Action::Projection, "parallel, oblique, perspective", ""),
    bind(Key::C, "C", Action::Cull, "cull front, none, back faces", "slice, aperture as given"),
    bind(Key::H, "H", Action::Hide, "painter, none, z-buffer", "fans of 3, 9; exact fibres"),
    bind(Key::Z, "Z", Action::Depth, "the depth buffer", "distances"),
    bind(Key::G, "G", Action::Ground, "ground and shadow, or none", ""),
    bind(Key::T, "T", Action::Turntable, "turntable, stop it", ""),
    bind(Key::V, "V", Action::Compare, "compare two modes, the next", "wireframe beside slice, shadow"),
    same(Key::E, "E", Action::Difference, "off from exact, magnified"),
    same(Key::B, "B", Action::Plan, "plan and budget"),
    same(Key::I, "I", Action::Inspect, "inspect address and bytes"),
    same(Key::W, "W", Action::Walk(0, 1.0), "walk ahead"),
    same(Key::S, "S", Action::Walk(0, -1.0), "walk back"),
    same(Key::A, "A", Action::Walk(1, 1.0), "walk left"),
    same(Key::D, "D", Action::Walk(1, -1.0), "walk right"),
    same(Key::PageUp, "PgUp", Action::Walk(2, 1.0), "rise"),
    same(Key::PageDown, "PgDn", Action::Walk(2, -1.0), "sink"),
    bind(Key::Left, "Left", Action::Turn(1, 1.0), "orbit left", "turn left"),
    bind(Key::Right, "Right", Action::Turn(1, -1.0), "orbit right", "turn right"),
    bind(Key::Up, "Up", Action::Turn(2, 1.0), "orbit up", "turn up"),
    bind(Key::Down, "Down", Action::Turn(2, -1.0), "orbit down", "turn down"),
    bind(Key::Tab, "Tab", Action::NextPlane(1), "", "choose the next plane"),
    bind(Key::Backspace, "Bksp", Action::NextPlane(-1), "", "plane before"),
    bind(Key::RightBracket, "]", Action::TurnPlane(1.0), "", "turn in that plane"),
    bind(Key::LeftBracket, "[", Action::TurnPlane(-1.0), "", "turn back in it"),
    bind(Key::Equal, "=", Action::Zoom(1.0), "nearer", "walk along its second axis"),
    bind(Key::Minus, "-", Action::Zoom(-1.0), "farther", "walk back along it"),
    bind(Key::O, "O", Action::TurnAbout, "", "turn about eye or middle"),
    same(Key::R, "R", Action::Reset, "back to the file's view"),
    same(Key::Space, "Space", Action::Pause, "let time run, stop it"),
    same(Key::Period, ".", Action::StepForward, "one frame on"),
    same(Key::Comma, ",", Action::StepBack, "one frame back"),
    bind(Key::N, "N", Action::PixelForward, "one pixel of a figure on", ""),
    bind(Key::U, "U", Action::PixelBack, "one pixel of it back", ""),
    bind(Key::J, "J", Action::SaveView, "print the camera as commands", "save this view as JSON"),
    same(Key::K, "K", Action::Crt, "look of a tube (CRT)"),
    same(Key::F2, "F2", Action::Status, "line at the bottom"),
    same(Key::F3, "F3", Action::FrameRate, "frame rate"),
    same(Key::F9, "F9", Action::Record, "begin, end a GIF"),
    same(Key::F12, "F12", Action::Snapshot, "save a PNG"),
    same(Key::F10, "F10", Action::Scaling, "scale: whole, fit, smooth"),
    same(Key::F11, "F11", Action::Fullscreen, "fullscreen (X11)"),
];

/// Mouse actions: name, description in three dimensions, description in N dimensions.
pub const MOUSE: [(&str, &str, &str); 3] = [
    ("drag", "orbit", "turn"),
    ("right", "pan", "walk left, right, up, down"),
    ("wheel", "nearer, farther", "walk ahead, back"),
];

/// Keys that share a line of the help: the first of them, how many follow it in the table, the line's
/// name, its description in three dimensions and in N.
const SHARED_LINES: &[(Key, usize, &str, &str, &str)] = &[
    (Key::Escape, 1, "Esc Q", "quit", "quit"),
    (Key::W, 3, "WASD", "walk ahead, left, back, right", "walk ahead, left, back, right"),
    (Key::PageUp, 1, "PgUp", "rise; PgDn sink", "rise; PgDn sink"),
    (Key::Left, 3, "Arrow", "keys orbit", "keys turn"),
    (Key::Tab, 1, "Tab", "", "next plane; Bksp plane before"),
    (Key::RightBracket, 1, "] [", "", "turn in that plane, back"),
    (Key::Equal, 1, "= -", "nearer, farther", "walk along its second axis"),
    (Key::Period, 1, ". ,", "one frame on, back", "one frame on, back"),
    (Key::N, 1, "N U", "one pixel of a figure on, back", ""),
    (Key::F2, 1, "F2 F3", "status, frame rate", "status, frame rate"),
    (Key::F9, 1, "F9", "begin, end a GIF; F12 a PNG", "begin, end a GIF; F12 a PNG"),
];

/// Returns the binding of a key.
pub fn binding(key: Key) -> &'static Binding {
    // Every key has a binding: the test below covers them all.
    BINDINGS.iter().find(|b| b.key == key).unwrap_or(&BINDINGS[0])
}

/// Returns the lines of the help, for N-dimensional scenes or for others.
pub fn help_lines(is_nd: bool) -> Vec<String> {
    help_lines_of(is_nd, |_| true)
}

/// Returns those lines of the help whose keys have an effect, according to `works`.
pub(super) fn help_lines_of(is_nd: bool, works: impl Fn(Action) -> bool) -> Vec<String> {
    let line = |(name, help, help_nd): (&str, &str, &str)| {
        let help = if is_nd { help_nd } else { help };
        (!help.is_empty()).then(|| format!("{name:<6}{help}"))
    };
    let mut keys = Vec::new();
    let mut rest = BINDINGS;
    while let Some((first, others)) = rest.split_first() {
        let shared = SHARED_LINES.iter().find(|(key, ..)| *key == first.key);
        let count = shared.map_or(0, |(_, count, ..)| *count).min(others.len());
        let is_whole = works(first.action) && others[..count].iter().all(|b| works(b.action));
        match shared.filter(|_| is_whole) {
            Some((_, _, name, help, help_nd)) => {
                keys.push((*name, *help, *help_nd));
                rest = &others[count..];
            }
            None => {
                keys.extend(works(first.action).then_some((first.name, first.help, first.help_nd)));
                rest = others;
            }
        }
    }
    keys.into_iter().chain(MOUSE).filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_is_bound_twice_and_all_are_in_the_help() {
        for (i, b) in BINDINGS.iter().enumerate() {
            assert!(BINDINGS[i + 1..].iter().all(|o| o.key != b.key), "{} is bound twice", b.name);
            assert_eq!(binding(b.key).name, b.name);
        }
        let (space, nd) = (help_lines(false), help_lines(true));
        let shared: usize = SHARED_LINES.iter().map(|(_, count, ..)| count).sum();
        assert_eq!(nd.len(), BINDINGS.len() + MOUSE.len() - 4 - shared);
        // Without the planes' four keys and the centre of rotation.
        assert_eq!(space.len(), BINDINGS.len() + MOUSE.len() - 5 - (shared - 2));
        // Where one of the keys has no effect, the others have lines of their own.
        let still = help_lines_of(false, |action| action != Action::Walk(0, 1.0));
        assert!(still.iter().any(|l| l == "S     walk back") && !still.iter().any(|l| l.contains("ahead")));
        for (key, count, ..) in SHARED_LINES {
            let at = BINDINGS.iter().position(|b| b.key == *key).expect("a key of the table");
            assert!(
                BINDINGS[at..=at + count].iter().all(|b| b.help.is_empty() == BINDINGS[at].help.is_empty())
            );
        }
        assert!(space.iter().chain(&nd).all(|l| l.len() <= 36), "two columns fit a small window");
    }
}

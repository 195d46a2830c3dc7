//! Input events of the user, in the window or replayed, and their form in the protocol.

/// An event of the user. Its `Display` is the line that is sent to clients with `EVENTS on`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InputEvent {
    /// A key went down or up: `EVENT key down|up name`.
    Key {
        /// Name of the key in lower case, without blanks: `a`, `left`, `f5`, `space`.
        name: String,
        /// True if the key went down.
        down: bool,
    },
    /// A character was typed: `EVENT text u+0041 A`; control characters carry the code alone.
    Text(char),
    /// The mouse moved, or a button changed: `EVENT mouse x y buttons`, in frame coordinates, which
    /// may be off the frame.
    Mouse {
        /// Column in frame pixels.
        x: i32,
        /// Row in frame pixels.
        y: i32,
        /// Buttons held, as a sum of 1 (left), 2 (middle) and 4 (right).
        buttons: u8,
    },
    /// The wheel turned: `EVENT wheel dx dy`, in steps.
    Wheel {
        /// Steps to the right.
        dx: i32,
        /// Steps upwards.
        dy: i32,
    },
    /// The window has a new size in screen pixels: `EVENT resize w h`. The frame's size stays the
    /// same.
    Resize {
        /// Width of the window in pixels.
        width: u32,
        /// Height of the window in pixels.
        height: u32,
    },
    /// The window was closed: `EVENT close`.
    Close,
}

impl std::fmt::Display for InputEvent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            InputEvent::Key { name, down } => {
                write!(f, "EVENT key {} {name}", if *down { "down" } else { "up" })
            }
            InputEvent::Text(c) if c.is_control() || c.is_whitespace() => {
                write!(f, "EVENT text u+{:04x}", *c as u32)
            }
            InputEvent::Text(c) => write!(f, "EVENT text u+{:04x} {c}", *c as u32),
            InputEvent::Mouse { x, y, buttons } => write!(f, "EVENT mouse {x} {y} {buttons}"),
            InputEvent::Wheel { dx, dy } => write!(f, "EVENT wheel {dx} {dy}"),
            InputEvent::Resize { width, height } => write!(f, "EVENT resize {width} {height}"),
            InputEvent::Close => write!(f, "EVENT close"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_lines_of_the_protocol() {
        let lines = [
            (InputEvent::Key { name: "left".into(), down: true }, "EVENT key down left"),
            (InputEvent::Text('A'), "EVENT text u+0041 A"),
            (InputEvent::Text('\n'), "EVENT text u+000a"),
            (InputEvent::Mouse { x: -3, y: 7, buttons: 5 }, "EVENT mouse -3 7 5"),
            (InputEvent::Resize { width: 640, height: 480 }, "EVENT resize 640 480"),
            (InputEvent::Close, "EVENT close"),
        ];
        for (event, line) in lines {
            assert_eq!(event.to_string(), line);
        }
    }
}

//! The terminal of the prompt, as it was before the line editor changed it.

#[cfg(unix)]
use rustix::termios::{OptionalActions, Termios, tcgetattr, tcsetattr};
use std::io::{self, Write};

/// The attributes of the terminal on standard input; `None` without one.
pub(super) struct Attributes {
    #[cfg(unix)]
    saved: Option<Termios>,
}

impl Attributes {
    /// Notes the terminal's attributes.
    pub fn note() -> Attributes {
        Attributes {
            #[cfg(unix)]
            saved: tcgetattr(io::stdin()).ok(),
        }
    }

    /// Gives the terminal its attributes back: the line editor does that only where a line ends,
    /// and a shell would be left without echo.
    pub fn restore(&self) {
        #[cfg(unix)]
        if let Some(saved) = &self.saved {
            // Fails if the terminal is gone, and then nobody types there.
            let _ = tcsetattr(io::stdin(), OptionalActions::Now, saved);
            // What is pasted is no longer marked.
            let _ = io::stdout().write_all(b"\x1b[?2004l\r\n").and_then(|()| io::stdout().flush());
        }
    }
}

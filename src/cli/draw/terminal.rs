//! The terminal of the prompt, which a signal finds as the line editor has changed it.

#[cfg(unix)]
use rustix::termios::{OptionalActions, Termios, tcgetattr, tcsetattr};
use std::sync::atomic::{AtomicBool, Ordering};
#[cfg(unix)]
use std::time::{Duration, Instant};

/// Time that the line editor has to change the terminal after it has begun to read.
#[cfg(unix)]
const BEGINS_WITHIN: Duration = Duration::from_millis(200);

/// The terminal on standard input: its attributes before the line editor changed them, and who has
/// it.
pub(super) struct Terminal {
    /// `None` without a terminal.
    #[cfg(unix)]
    saved: Option<Termios>,
    is_reading: AtomicBool,
    has_ended: AtomicBool,
}

impl Terminal {
    /// Notes the terminal's attributes.
    pub fn note() -> Terminal {
        Terminal {
            #[cfg(unix)]
            saved: tcgetattr(std::io::stdin()).ok(),
            is_reading: AtomicBool::new(false),
            has_ended: AtomicBool::new(false),
        }
    }

    /// Lets the line editor have the terminal while it reads. Does not return once the terminal was
    /// given back for good: the process is about to end.
    pub fn while_reading<T>(&self, read: impl FnOnce() -> T) -> T {
        self.is_reading.store(true, Ordering::SeqCst);
        while self.has_ended.load(Ordering::SeqCst) {
            std::thread::park();
        }
        let line = read();
        self.is_reading.store(false, Ordering::SeqCst);
        line
    }

    /// Gives the terminal its attributes back for good. The line editor does that only where a line
    /// ends, and a shell would be left without echo.
    pub fn give_back(&self) {
        self.has_ended.store(true, Ordering::SeqCst);
        #[cfg(unix)]
        if let Some(saved) = &self.saved {
            use std::io::Write;
            let (stdin, began) = (std::io::stdin(), Instant::now());
            let is_as_before = || {
                let now = tcgetattr(&stdin).ok();
                now.is_some_and(|now| now.local_modes == saved.local_modes)
            };
            // A line editor that has just begun to read is about to change them.
            while self.is_reading.load(Ordering::SeqCst) && is_as_before() && began.elapsed() < BEGINS_WITHIN
            {
                std::thread::sleep(Duration::from_millis(5));
            }
            // Fails if the terminal is gone, and then nobody types there.
            let _ = tcsetattr(&stdin, OptionalActions::Now, saved);
            // What is pasted is no longer marked.
            let mut out = std::io::stdout();
            let _ = out.write_all(b"\x1b[?2004l\r\n").and_then(|()| out.flush());
        }
    }
}

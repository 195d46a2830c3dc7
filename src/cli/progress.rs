//! Progress on long work: a line on standard error, where that is a terminal; in colour unless `NO_COLOR` is set.
//!
//! Nothing is shown of what is done within half a second, and nothing is left of the line when the work is.

use std::fs::File;
use std::io::{self, IsTerminal, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Before this, nobody is kept waiting.
const BEGINS_AFTER: Duration = Duration::from_millis(500);
/// Between two drawings of the line.
const EVERY: Duration = Duration::from_millis(100);
/// Characters of the bar.
const CELLS: u64 = 30;

/// How far some work is.
pub(super) struct Progress {
    what: &'static str,
    total: u64,
    done: u64,
    /// Of one that is not done yet.
    part: u64,
    begun: Instant,
    drawn: Option<Instant>,
    style: Style,
}

/// How it may be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Style {
    Hidden,
    Plain,
    Colored,
}

/// Whether colours may be used, given what `NO_COLOR` holds (<https://no-color.org>: any text that is not empty forbids them).
fn style(is_terminal: bool, term: Option<&str>, no_color: Option<&std::ffi::OsStr>) -> Style {
    match (is_terminal && term != Some("dumb"), no_color.is_some_and(|v| !v.is_empty())) {
        (false, _) => Style::Hidden,
        (true, true) => Style::Plain,
        (true, false) => Style::Colored,
    }
}

impl Progress {
    /// Work of `total` things, called `what`.
    pub fn new(what: &'static str, total: u64) -> Self {
        let (term, no_color) = (std::env::var("TERM").ok(), std::env::var_os("NO_COLOR"));
        let style = style(io::stderr().is_terminal(), term.as_deref(), no_color.as_deref());
        Progress { what, total, done: 0, part: 0, begun: Instant::now(), drawn: None, style }
    }

    /// So many more are done.
    pub fn advance(&mut self, by: u64) {
        self.done += by;
        let (now, elapsed) = (Instant::now(), self.begun.elapsed());
        let is_due = self.drawn.is_none_or(|t| now >= t + EVERY) || self.done >= self.total;
        if self.style != Style::Hidden && elapsed >= BEGINS_AFTER && is_due {
            self.drawn = Some(now);
            IS_SHOWN.store(true, Ordering::Release);
            let line = line(self.what, self.done, self.total, elapsed, self.style);
            // A terminal that is gone needs no progress.
            let _ = write!(io::stderr().lock(), "\r{line}\x1b[K");
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        clear_line();
    }
}

/// Whether a line stands on the terminal that the next message has to take away.
static IS_SHOWN: AtomicBool = AtomicBool::new(false);

/// Takes the line away, if there is one: for messages, and the end.
pub(super) fn clear_line() {
    if IS_SHOWN.swap(false, Ordering::AcqRel) {
        let _ = write!(io::stderr().lock(), "\r\x1b[K");
    }
}

/// A file that tells how far it was read.
pub(super) struct Watched {
    file: File,
    progress: Progress,
}

impl Watched {
    /// A file of so many bytes, to be read from where it stands.
    pub fn new(file: File, bytes: u64) -> Self {
        Watched { file, progress: Progress::new("KiB", bytes / 1024) }
    }
}

impl Read for Watched {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.progress.part += count as u64;
        let whole = self.progress.part / 1024;
        self.progress.part %= 1024;
        self.progress.advance(whole);
        if count == 0 {
            clear_line();
        }
        Ok(count)
    }
}

fn line(what: &str, done: u64, total: u64, elapsed: Duration, style: Style) -> String {
    let full = (done.min(total) * CELLS / total.max(1)) as usize;
    let (bar, rest) = ("#".repeat(full), "-".repeat(CELLS as usize - full));
    let left = elapsed.as_secs_f64() / done.max(1) as f64 * total.saturating_sub(done) as f64;
    let bar = if style == Style::Colored { format!("\x1b[32m{bar}\x1b[0m") } else { bar };
    format!("[{bar}{rest}] {done}/{total} {what}, {left:.0} s left")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_for_terminals_that_want_them() {
        let (on, off) = (Some(std::ffi::OsStr::new("1")), Some(std::ffi::OsStr::new("")));
        assert_eq!(style(false, None, None), Style::Hidden);
        assert_eq!(style(true, Some("dumb"), None), Style::Hidden);
        assert_eq!(style(true, Some("xterm"), on), Style::Plain);
        assert_eq!(style(true, Some("xterm"), off), Style::Colored);
    }

    #[test]
    fn the_line_says_how_much_is_left() {
        let text = line("frames", 10, 40, Duration::from_secs(5), Style::Plain);
        assert_eq!(text, format!("[{}{}] 10/40 frames, 15 s left", "#".repeat(7), "-".repeat(23)));
        assert!(!line("frames", 1, 0, Duration::ZERO, Style::Plain).contains('\x1b'));
    }
}

//! Progress of long work: a line on standard error if that is a terminal, in colour unless
//! `NO_COLOR` is set.
//!
//! Work that ends within half a second shows nothing, and the line is removed when the work ends.

use std::fs::File;
use std::io::{self, IsTerminal, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time before the line is first shown.
const BEGINS_AFTER: Duration = Duration::from_millis(500);
/// Time between two updates of the line.
const EVERY: Duration = Duration::from_millis(100);
/// Width of the bar in characters.
const CELLS: u64 = 30;

/// Progress of some work.
pub(super) struct Progress {
    what: &'static str,
    total: u64,
    done: u64,
    /// Bytes of an item that is not complete.
    part: u64,
    begun: Instant,
    drawn: Option<Instant>,
    style: Style,
}

/// Style of the progress line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Style {
    Hidden,
    Plain,
    Colored,
}

/// Returns the style, given the value of `NO_COLOR` (<https://no-color.org>: any text that is not
/// empty forbids colours).
fn style(is_terminal: bool, term: Option<&str>, no_color: Option<&std::ffi::OsStr>) -> Style {
    match (is_terminal && term != Some("dumb"), no_color.is_some_and(|v| !v.is_empty())) {
        (false, _) => Style::Hidden,
        (true, true) => Style::Plain,
        (true, false) => Style::Colored,
    }
}

impl Progress {
    /// Starts the progress of `total` items, called `what`.
    pub fn new(what: &'static str, total: u64) -> Self {
        let (term, no_color) = (std::env::var("TERM").ok(), std::env::var_os("NO_COLOR"));
        let style = style(io::stderr().is_terminal(), term.as_deref(), no_color.as_deref());
        Progress { what, total, done: 0, part: 0, begun: Instant::now(), drawn: None, style }
    }

    /// Records that `by` more items are done.
    pub fn advance(&mut self, by: u64) {
        self.done += by;
        let (now, elapsed) = (Instant::now(), self.begun.elapsed());
        let is_due = self.drawn.is_none_or(|t| now >= t + EVERY) || self.done >= self.total;
        if self.style != Style::Hidden && elapsed >= BEGINS_AFTER && is_due {
            self.drawn = Some(now);
            IS_SHOWN.store(true, Ordering::Release);
            let line = line(self.what, self.done, self.total, elapsed, self.style);
            // The terminal may be gone.
            let _ = write!(io::stderr().lock(), "\r{line}\x1b[K");
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        clear_line();
    }
}

/// Set while a line is shown, which the next message has to remove.
static IS_SHOWN: AtomicBool = AtomicBool::new(false);

/// Removes the line, if one is shown: before messages, and at the end.
pub(super) fn clear_line() {
    if IS_SHOWN.swap(false, Ordering::AcqRel) {
        let _ = write!(io::stderr().lock(), "\r\x1b[K");
    }
}

/// A file that reports how much of it was read.
pub(super) struct Watched {
    file: File,
    progress: Progress,
}

impl Watched {
    /// Wraps a file with `bytes` bytes left to read.
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

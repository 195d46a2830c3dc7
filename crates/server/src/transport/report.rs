//! Reports of trouble that does not end the server, on standard error.
//!
//! In: descriptions of errors, from any thread. Out: lines that begin with `fbptr: `, at most one
//! of a kind in [`EVERY`]; the next one says how many were left out. Promises: never blocks, not
//! even on a standard error that nobody reads. Tested by the unit test below, and by the process
//! tests that read such lines.

use std::fmt::Display;
use std::io::{self, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Shortest time between two lines of a kind.
const EVERY: Duration = Duration::from_secs(5);

/// Kinds of trouble.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Trouble {
    /// The server has as many connections as are allowed.
    Full,
    /// An address has as many connections as are allowed.
    AddressFull,
    /// No descriptor is left for a connection.
    Descriptors,
    /// Accepting failed.
    Accept,
    /// A thread could not be started.
    Threads,
    /// Waiting for sockets failed.
    Watching,
}

const KINDS: usize = Trouble::Watching as usize + 1;

/// Time of the last report of a kind, and the number of reports left out since.
#[derive(Clone, Copy)]
struct Throttle {
    reported_at: Option<Instant>,
    omitted: u64,
}

impl Throttle {
    const NEW: Throttle = Throttle { reported_at: None, omitted: 0 };

    /// Returns the number of lines left out if one may be written, and otherwise counts one more.
    fn pass(&mut self, now: Instant) -> Option<u64> {
        if self.reported_at.is_some_and(|reported| now < reported + EVERY) {
            self.omitted += 1;
            return None;
        }
        self.reported_at = Some(now);
        Some(std::mem::take(&mut self.omitted))
    }
}

static THROTTLES: Mutex<[Throttle; KINDS]> = Mutex::new([Throttle::NEW; KINDS]);

/// Reports trouble on standard error, unless its kind was reported within [`EVERY`].
pub(crate) fn report(trouble: Trouble, what: impl Display) {
    // The counts are valid even if a thread panicked while it held the lock.
    let mut throttles = THROTTLES.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(omitted) = throttles[trouble as usize].pass(Instant::now()) else { return };
    if !takes_a_line() {
        throttles[trouble as usize].omitted += omitted + 1;
        return;
    }
    let line = match omitted {
        0 => format!("fbptr: {what}\n"),
        _ => format!("fbptr: {what} ({omitted} more of this kind were left out)\n"),
    };
    // Nobody reads a standard error that is closed.
    let _ = io::stderr().write_all(line.as_bytes());
}

/// Returns whether standard error takes a line without blocking: a pipe that nobody reads must not
/// stop the server.
#[cfg(unix)]
fn takes_a_line() -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let stderr = io::stderr();
    let mut fds = [PollFd::new(&stderr, PollFlags::OUT)];
    let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
    // A line is shorter than what a pipe that is reported as writable takes (PIPE_BUF).
    poll(&mut fds, Some(&at_once)).is_ok_and(|n| n > 0)
}

#[cfg(not(unix))]
fn takes_a_line() -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_in_a_while_and_the_others_are_counted() {
        let (mut throttle, begun) = (Throttle::NEW, Instant::now());
        assert_eq!(throttle.pass(begun), Some(0));
        for i in 1..100 {
            assert_eq!(throttle.pass(begun + EVERY * i / 100), None);
        }
        assert_eq!(throttle.pass(begun + EVERY), Some(99));
        assert_eq!(throttle.pass(begun + 2 * EVERY), Some(0));
    }
}

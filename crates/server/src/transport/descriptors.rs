//! File descriptors: the number that the process may open, and one in reserve for when none is
//! left.
//!
//! A connection takes one descriptor. In: the number of connections to allow. Out: the number that
//! fits after the soft limit (`RLIMIT_NOFILE`) was raised as far as needed and allowed. Promises:
//! [`KEPT_FOR_FILES`] more stay free for snapshots, loaded files and the window. Tested by the
//! process tests under `ulimit -n 64`.

use std::fs::File;
use std::io;

/// Descriptors that are left for everything else that opens files.
#[cfg(unix)]
const KEPT_FOR_FILES: usize = 16;
/// Number of open descriptors to assume if the system does not report it.
#[cfg(unix)]
const USUALLY_OPEN: usize = 32;

/// Number of connections for which there are descriptors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Room {
    /// Number of descriptors that can still be opened, without those left for files.
    pub more: usize,
    /// The limit of open files that this follows from.
    pub limit: u64,
}

/// Raises the process's limit of open files so that `connections` more fit, as far as the hard
/// limit allows. Returns the resulting room, or `None` if there is no limit.
#[cfg(unix)]
pub(crate) fn make_room(connections: usize) -> Option<Room> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let mut limit = getrlimit(Resource::Nofile);
    let open = count_open().unwrap_or(USUALLY_OPEN);
    let needed = (open.saturating_add(connections).saturating_add(KEPT_FOR_FILES)) as u64;
    if limit.current? < needed {
        let raised = limit.maximum.map_or(needed, |hard| hard.min(needed));
        let new = Rlimit { current: Some(raised), maximum: limit.maximum };
        // If the system refuses, the limit stays as it is.
        if limit.current < Some(raised) && setrlimit(Resource::Nofile, new).is_ok() {
            limit = new;
        }
    }
    let limit = limit.current?;
    let more = usize::try_from(limit).unwrap_or(usize::MAX).saturating_sub(open + KEPT_FOR_FILES);
    Some(Room { more, limit })
}

#[cfg(not(unix))]
pub(crate) fn make_room(_wanted: usize) -> Option<Room> {
    None
}

/// Returns the number of descriptors that this process has open.
#[cfg(unix)]
fn count_open() -> Option<usize> {
    let listed = std::fs::read_dir("/dev/fd").ok()?.count();
    // The directory itself was open while it was read.
    Some(listed.saturating_sub(1))
}

/// Returns whether an error means that no descriptor is left, in this process or in the system.
pub(super) fn are_exhausted(error: &io::Error) -> bool {
    #[cfg(unix)]
    {
        use rustix::io::Errno;
        let errno = error.raw_os_error().map(Errno::from_raw_os_error);
        matches!(errno, Some(Errno::MFILE | Errno::NFILE))
    }
    #[cfg(not(unix))]
    {
        let _ = error;
        false
    }
}

/// A descriptor in reserve. Closing it for a moment allows a client to be accepted and sent the
/// reason for the refusal.
pub(super) struct ReservedDescriptor(Option<File>);

impl ReservedDescriptor {
    pub fn new() -> Self {
        let mut reserved = ReservedDescriptor(None);
        reserved.take();
        reserved
    }

    /// Opens the descriptor again, if it is closed. If none is free, the next call tries again.
    pub fn take(&mut self) {
        if self.0.is_none() {
            self.0 = File::open(if cfg!(windows) { "NUL" } else { "/dev/null" }).ok();
        }
    }

    /// Closes it, so that another descriptor can be opened.
    pub fn give_up(&mut self) {
        self.0 = None;
    }
}

//! Descriptors: how many the process may have open, and one kept back for when there are no more.
//!
//! A connection takes one descriptor. In: the number of connections that are wanted. Out: the
//! number that fits after the soft limit (`RLIMIT_NOFILE`) was raised as far as needed and allowed.
//! Promises: [`KEPT_FOR_FILES`] more stay free for snapshots, loaded files and the window. One
//! knows by the process tests under `ulimit -n 64`.

use std::fs::File;
use std::io;

/// Descriptors that connections leave to everything else that opens files.
#[cfg(unix)]
const KEPT_FOR_FILES: usize = 16;
/// Descriptors taken to be open where the system does not tell.
#[cfg(unix)]
const USUALLY_OPEN: usize = 32;

/// The connections that descriptors can be had for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Room {
    /// That many more descriptors can be opened, those for files aside.
    pub more: usize,
    /// The limit of open files that this follows from.
    pub limit: u64,
}

/// Raises the process's limit of open files so that `connections` more fit, as far as the hard
/// limit goes. Returns the room that there is then, or `None` where there is no limit.
#[cfg(unix)]
pub(crate) fn make_room(connections: usize) -> Option<Room> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let mut limit = getrlimit(Resource::Nofile);
    let open = count_open().unwrap_or(USUALLY_OPEN);
    let needed = (open.saturating_add(connections).saturating_add(KEPT_FOR_FILES)) as u64;
    if limit.current? < needed {
        let raised = limit.maximum.map_or(needed, |hard| hard.min(needed));
        let new = Rlimit { current: Some(raised), maximum: limit.maximum };
        // A system that refuses leaves the limit as it is.
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

/// Returns how many descriptors this process has open.
#[cfg(unix)]
fn count_open() -> Option<usize> {
    let listed = std::fs::read_dir("/dev/fd").ok()?.count();
    // The folder itself was open while it was read.
    Some(listed.saturating_sub(1))
}

/// Returns whether an error means that no descriptor is left, here or in the whole system.
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

/// A descriptor held for nothing: given up for a moment, it lets a client be accepted and told why
/// it cannot stay.
pub(super) struct ReservedDescriptor(Option<File>);

impl ReservedDescriptor {
    pub fn new() -> Self {
        let mut reserved = ReservedDescriptor(None);
        reserved.take();
        reserved
    }

    /// Opens it again. Without a descriptor for it there is none until the next call.
    pub fn take(&mut self) {
        if self.0.is_none() {
            self.0 = File::open(if cfg!(windows) { "NUL" } else { "/dev/null" }).ok();
        }
    }

    /// Closes it, so that another descriptor can be had.
    pub fn give_up(&mut self) {
        self.0 = None;
    }
}

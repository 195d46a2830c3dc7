//! Race-free opening of files below a folder: component by component, without following links and
//! without blocking.

use super::SandboxError;
use std::fs::File;
use std::io;
use std::path::Path;

/// Reason why nothing was opened.
#[derive(Debug)]
pub(super) enum OpenError {
    /// A component is a symbolic link, or no folder.
    Link,
    /// Not a regular file.
    NotPlain,
    /// Another error of the operating system.
    Io(io::Error),
}

impl OpenError {
    /// Converts the error, for the file called `name`.
    pub fn named(self, name: &str) -> SandboxError {
        match self {
            OpenError::Link => SandboxError::Link { name: name.into() },
            OpenError::NotPlain => SandboxError::NotPlain { name: name.into() },
            OpenError::Io(e) => super::from_io(name, &e),
        }
    }
}

impl From<io::Error> for OpenError {
    fn from(e: io::Error) -> Self {
        OpenError::Io(e)
    }
}

#[cfg(unix)]
impl From<rustix::io::Errno> for OpenError {
    fn from(e: rustix::io::Errno) -> Self {
        use rustix::io::Errno;
        match e {
            Errno::LOOP | Errno::NOTDIR => OpenError::Link,
            // Reported for a socket, or for a pipe that would block.
            Errno::NXIO => OpenError::NotPlain,
            e => OpenError::Io(e.into()),
        }
    }
}

/// Opens the parent folder of `inside`, a path of plain components below `root`: each folder
/// relative to the one before, never by path.
#[cfg(unix)]
pub(super) fn folder_of(root: &Path, inside: &Path) -> Result<std::os::fd::OwnedFd, OpenError> {
    use rustix::fs::{Mode, OFlags, open, openat};
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    let mut folder = open(root, flags, Mode::empty())?;
    for step in inside.parent().into_iter().flat_map(Path::components) {
        folder = openat(&folder, step.as_os_str(), flags, Mode::empty())?;
    }
    Ok(folder)
}

/// Opens the regular file at `inside` for reading. Never blocks: a pipe, a device or a socket in
/// its place is refused.
#[cfg(unix)]
pub(super) fn plain_file(root: &Path, inside: &Path) -> Result<File, OpenError> {
    use rustix::fs::{Mode, OFlags, openat};
    let folder = folder_of(root, inside)?;
    let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
    let file = File::from(openat(&folder, inside.file_name().unwrap_or_default(), flags, Mode::empty())?);
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(OpenError::NotPlain),
    }
}

/// Opens the regular file at `inside` for reading. A path that leads out of `root` is refused.
#[cfg(not(unix))]
pub(super) fn plain_file(root: &Path, inside: &Path) -> Result<File, OpenError> {
    let path = root.join(inside);
    let file = File::open(&path)?;
    if !std::fs::canonicalize(&path)?.starts_with(root) {
        return Err(OpenError::Link);
    }
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(OpenError::NotPlain),
    }
}

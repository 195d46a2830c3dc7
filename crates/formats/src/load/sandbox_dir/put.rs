//! Atomic writing of a file below a folder, protected against links as far as the system allows.

use super::open::OpenError;
use std::io::{self, Write};
use std::path::Path;

/// Writes the file at `inside`, a path of plain components below `root`, or leaves it unchanged.
#[cfg(unix)]
pub(super) fn put(
    root: &Path,
    inside: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OpenError> {
    use crate::save::{hold, temporary_name};
    use rustix::fs::{AtFlags, Mode, OFlags, openat, renameat, unlinkat};
    use rustix::io::Errno;
    let folder = super::open::folder_of(root, inside)?;
    let target = inside.file_name().unwrap_or_default();
    let new = OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    let (temporary, file) = loop {
        let temporary = temporary_name();
        match openat(&folder, &*temporary, new, Mode::from_raw_mode(0o666)).map(std::fs::File::from) {
            Err(Errno::EXIST) => {}
            Err(e) => return Err(e.into()),
            Ok(file) if hold(&file) => break (temporary, file),
            Ok(_) => {}
        }
    };
    let mut out = io::BufWriter::with_capacity(1 << 16, file);
    // Stays open until it is renamed: a closed temporary file could be taken for a leftover.
    let written = fill(&mut out)
        .and_then(|()| out.into_inner().map_err(io::IntoInnerError::into_error))
        .and_then(|file| Ok(renameat(&folder, &*temporary, &folder, target).map(|()| drop(file))?));
    written.map_err(|e| {
        // The first error is reported; the leftover is removed if possible.
        let _ = unlinkat(&folder, &*temporary, AtFlags::empty());
        OpenError::Io(e)
    })
}

/// Writes the file at `inside`, a path of plain components below `root`, or leaves it unchanged.
#[cfg(not(unix))]
pub(super) fn put(
    root: &Path,
    inside: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OpenError> {
    crate::save::atomically(&root.join(inside), fill)
        .map_err(|e| OpenError::Io(io::Error::other(e.to_string())))
}

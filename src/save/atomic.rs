//! Files that are there whole or not at all.

use super::SaveError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Lets `write` fill the file at `path`, which changes only when all of it is written: a temporary file in the same folder
/// is renamed over it, so that a program that ends half-way leaves the old one.
///
/// What is no plain file (a pipe, `/dev/stdout`) is written as it stands; a link is followed.
pub fn atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), SaveError> {
    let fail = |e: io::Error| SaveError::io(path, &e);
    if fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        let file = OpenOptions::new().write(true).open(path).map_err(fail)?;
        return fill(file, write).map(drop).map_err(fail);
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let (temporary, file) = create_beside(&target).map_err(fail)?;
    let written = fill(file, write).and_then(|file| {
        drop(file);
        fs::rename(&temporary, &target)
    });
    written.map_err(|e| {
        // The error that counts is the first one; the leftover is removed if it can be.
        let _ = fs::remove_file(&temporary);
        fail(e)
    })
}

fn fill(file: File, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<File> {
    let mut out = BufWriter::with_capacity(1 << 16, file);
    write(&mut out)?;
    out.into_inner().map_err(|e| e.into_error())
}

/// A new file in the folder of `target`, under a name that nothing else has.
pub(super) fn create_beside(target: &Path) -> io::Result<(PathBuf, File)> {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    loop {
        let mut hidden = std::ffi::OsString::from(".");
        // Short, so that a name near the system's limit still finds room.
        hidden.push(format!("fbptr-{}-{}.tmp", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed)));
        let temporary = target.with_file_name(hidden);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
            Ok(file) => return Ok((temporary, file)),
        }
    }
}

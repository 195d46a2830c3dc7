//! Atomic replacement of files.

use super::SaveError;
use super::temporary::create_beside;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Replaces the file at `path` by what `write` writes, atomically: a temporary file in the same
/// folder is renamed over it, so that a program that ends half-way leaves the old file.
///
/// Special files (a pipe, `/dev/stdout`) are opened and written directly; a link is followed.
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
    // Stays open until it is renamed: a closed temporary file could be taken for a leftover.
    let written = fill(file, write).and_then(|file| fs::rename(&temporary, &target).map(|()| drop(file)));
    written.map_err(|e| {
        // The first error is reported; the leftover is removed if possible.
        let _ = fs::remove_file(&temporary);
        fail(e)
    })
}

/// Lets `write` fill a file through a buffer, and returns the file, still open.
fn fill(file: File, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<File> {
    let mut out = BufWriter::with_capacity(1 << 16, file);
    write(&mut out)?;
    out.into_inner().map_err(|e| e.into_error())
}

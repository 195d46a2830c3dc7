//! Files that are there whole or not at all.

use super::SaveError;
use super::temporary::create_beside;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

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
    // Open until it has its name: a file that is closed before could be taken for a leftover.
    let written = fill(file, write).and_then(|file| fs::rename(&temporary, &target).map(|()| drop(file)));
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

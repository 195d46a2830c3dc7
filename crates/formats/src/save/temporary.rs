//! Temporary files for atomic replacement, and the removal of those that killed programs left.
//!
//! A temporary file is `.fbptr-PROCESS-NUMBER.tmp`, and its writer holds the system's file lock on
//! it, which ends with the process in every case. So a file of such a name that can be locked
//! belongs to no process. Promise: no file that a living process writes is removed, in whatever
//! container it runs; on a file system without locks none is.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Returns a name for a temporary file that this process has not used. It is short, so that it fits
/// even near the system's limit on path lengths.
pub(crate) fn temporary_name() -> String {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    format!(".fbptr-{}-{}.tmp", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed))
}

/// Locks a new temporary file until it is closed. Returns `false` if another process has taken it
/// for a leftover meanwhile: then it is removed, or about to be, and another must be created.
pub(crate) fn hold(file: &File) -> bool {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => false,
        // Without locks no process removes a file either.
        Err(TryLockError::Error(_)) => true,
        Ok(()) => is_linked(file),
    }
}

/// Returns whether the file still has a name.
#[cfg(unix)]
fn is_linked(file: &File) -> bool {
    use std::os::unix::fs::MetadataExt;
    file.metadata().is_ok_and(|m| m.nlink() > 0)
}

#[cfg(not(unix))]
fn is_linked(_: &File) -> bool {
    true
}

/// Creates a new file in the folder of `target`, under an unused name. It must stay open until it
/// is renamed.
pub(super) fn create_beside(target: &Path) -> io::Result<(PathBuf, File)> {
    loop {
        let temporary = target.with_file_name(temporary_name());
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
            Ok(file) if hold(&file) => return Ok((temporary, file)),
            Ok(_) => {}
        }
    }
}

/// Removes the unfinished files that killed programs left in the folder of `target`, and none of a
/// living program. Files that cannot be removed stay.
pub fn remove_leftovers_beside(target: &Path) {
    remove_leftovers_in(match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    });
}

/// Removes the unfinished files that killed programs left in a folder, as
/// [`remove_leftovers_beside`] does.
pub fn remove_leftovers_in(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && entry.file_name().to_str().is_some_and(is_temporary_name) {
            remove_if_left(&entry.path());
        }
    }
}

/// Removes a temporary file if no process holds its lock.
fn remove_if_left(path: &Path) {
    let mut options = OpenOptions::new();
    options.write(true);
    #[cfg(unix)]
    {
        // Opening a pipe in its place would block until there is a reader.
        let flags = rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOFOLLOW;
        std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, flags.bits() as i32);
    }
    let Ok(file) = options.open(path) else { return };
    // The lock is held until the name is removed, so a writer that has just created the file sees
    // either the lock or the removal.
    if file.try_lock().is_ok() && is_linked(&file) {
        let _ = fs::remove_file(path);
    }
}

/// Returns whether a name is of the form that [`temporary_name`] makes.
fn is_temporary_name(name: &str) -> bool {
    let numbers = name.strip_prefix(".fbptr-").and_then(|rest| rest.strip_suffix(".tmp"));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    numbers.and_then(|n| n.split_once('-')).is_some_and(|(id, n)| is_number(id) && is_number(n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leftovers_go_and_what_is_being_written_and_other_peoples_files_stay() {
        let folder = std::env::temp_dir().join(format!("fbptr-leftovers-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let others = [
            ".fbptr-1-2.tmp.png",
            ".fbptr-1.tmp",
            ".fbptr-a-1.tmp",
            "fbptr-1-2.tmp",
            ".fbptr-1-.tmp",
            "a.png",
        ];
        for name in others.iter().chain(&[".fbptr-1-2.tmp", ".fbptr-4194304-0.tmp"]) {
            fs::write(folder.join(name), "x").unwrap();
        }
        let target = folder.join("picture-0000.png");
        let (living, file) = create_beside(&target).unwrap();
        remove_leftovers_beside(&target);
        let mut found: Vec<_> = fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
        found.sort();
        let mut wanted: Vec<_> = others.iter().map(|n| folder.join(n)).chain([living.clone()]).collect();
        wanted.sort();
        assert_eq!(found, wanted);
        drop(file);
        remove_leftovers_beside(&target);
        assert!(!living.exists(), "what nobody holds any more is left over");
        remove_leftovers_beside(&folder.join("nowhere/picture.png"));
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_file_that_was_taken_for_a_leftover_is_given_up() {
        let path = std::env::temp_dir().join(format!("fbptr-taken-{}", std::process::id()));
        let file = File::create(&path).unwrap();
        let other = File::open(&path).unwrap();
        other.try_lock().unwrap();
        assert!(!hold(&file), "another holds it");
        fs::remove_file(&path).unwrap();
        drop(other);
        assert!(!cfg!(unix) || !hold(&file), "it has no name any more");
    }
}

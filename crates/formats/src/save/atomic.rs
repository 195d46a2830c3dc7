//! Files that are written: replaced atomically, or begun anew, and never by a link's other end.
//!
//! A file is made under a temporary name in the folder of its place and renamed over whatever entry
//! is there. So a symbolic link is replaced itself, whoever has put it there, and what it leads to
//! stays as it was. A pipe or a device is written directly where the user has named it.

use super::SaveError;
use super::temporary::create_beside;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Replaces the file at `path` by what `write` writes, atomically: a temporary file in the same
/// folder is renamed over it, so that a program that ends half-way leaves the old file.
///
/// For a path that the user has named: special files (a pipe, `/dev/stdout`) are opened and written
/// directly. A symbolic link is replaced, not followed.
pub fn atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), SaveError> {
    match open_special(path).map_err(|e| SaveError::io(path, &e))? {
        Some(file) => fill(file, write).map(drop).map_err(|e| SaveError::io(path, &e)),
        None => replace(path, write),
    }
}

/// Replaces the entry at `path`, as [`atomically`] does, whatever it is: for names that the program
/// makes itself, as those of numbered frames, where a pipe or a link is nobody's wish.
pub fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), SaveError> {
    let fail = |e: io::Error| SaveError::io(path, &e);
    let (temporary, file) = create_beside(path).map_err(fail)?;
    // Stays open until it is renamed: a closed temporary file could be taken for a leftover.
    let written = fill(file, write).and_then(|file| fs::rename(&temporary, path).map(|()| drop(file)));
    written.map_err(|e| {
        // The first error is reported; the leftover is removed if possible.
        let _ = fs::remove_file(&temporary);
        fail(e)
    })
}

/// Returns whether `path` is a symbolic link that leads to no open descriptor.
pub fn is_link(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|meta| meta.is_symlink()) && !is_descriptor(path)
}

/// Begins a new file at `path`, in the place of what was there, for bytes that follow one after the
/// other. Special files are opened as [`atomically`] does.
pub fn begin(path: &Path) -> io::Result<File> {
    if let Some(file) = open_special(path)? {
        return Ok(file);
    }
    let (temporary, file) = create_beside(path)?;
    fs::rename(&temporary, path).inspect_err(|_| _ = fs::remove_file(&temporary))?;
    Ok(file)
}

/// Opens a pipe, a device, or an open descriptor by its path, for writing; `None` for every other
/// path.
fn open_special(path: &Path) -> io::Result<Option<File>> {
    let is_special = fs::symlink_metadata(path).is_ok_and(|meta| {
        let kind = meta.file_type();
        !(kind.is_file() || kind.is_dir() || kind.is_symlink())
    });
    if !is_special && !is_descriptor(path) {
        return Ok(None);
    }
    // Nothing is created: the path is there.
    OpenOptions::new().write(true).truncate(true).open(path).map(Some)
}

/// Links that are followed on the way to a descriptor.
const LINKS: usize = 8;

/// Returns whether a path leads to an open descriptor, as `/dev/stdout` and `/proc/self/fd/1` do.
fn is_descriptor(path: &Path) -> bool {
    let mut path = path.to_owned();
    for _ in 0..LINKS {
        let Ok(target) = fs::read_link(&path) else { return false };
        let parent = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let Ok(folder) = fs::canonicalize(parent.unwrap_or(Path::new("."))) else { return false };
        if folder.starts_with("/proc") && folder.file_name() == Some("fd".as_ref()) {
            return true;
        }
        path = folder.join(target);
    }
    false
}

/// Lets `write` fill a file through a buffer, and returns the file, still open.
fn fill(file: File, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<File> {
    let mut out = BufWriter::with_capacity(1 << 16, file);
    write(&mut out)?;
    out.into_inner().map_err(|e| e.into_error())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::io::Read;
    use std::os::unix::fs::symlink;

    /// Returns a new folder with a file `theirs` and links to it, to nothing and to a device.
    fn folder(name: &str) -> std::path::PathBuf {
        let folder = std::env::temp_dir().join(format!("fbptr-atomic-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("theirs"), "theirs").unwrap();
        for (link, target) in [("link", "theirs"), ("dangling", "nothing"), ("device", "/dev/null")] {
            symlink(target, folder.join(link)).unwrap();
        }
        folder
    }

    #[test]
    fn a_link_is_replaced_and_what_it_leads_to_stays() {
        for is_named in [true, false] {
            let folder = folder(if is_named { "named" } else { "made" });
            for link in ["link", "dangling", "device"] {
                let path = folder.join(link);
                let put = |out: &mut dyn Write| out.write_all(b"ours");
                if is_named { atomically(&path, put) } else { replace(&path, put) }.unwrap();
                assert!(fs::symlink_metadata(&path).unwrap().is_file(), "{link}: still a link");
                assert_eq!(fs::read(&path).unwrap(), b"ours");
            }
            assert_eq!(fs::read(folder.join("theirs")).unwrap(), b"theirs");
            assert!(!folder.join("nothing").exists());
            fs::remove_dir_all(&folder).unwrap();
        }
        let folder = folder("begun");
        begin(&folder.join("link")).unwrap().write_all(b"ours").unwrap();
        assert_eq!(fs::read(folder.join("link")).unwrap(), b"ours");
        assert_eq!(fs::read(folder.join("theirs")).unwrap(), b"theirs");
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_descriptor_and_a_device_are_written_where_they_are_named() {
        use std::os::fd::AsRawFd;
        let (mut reader, writer) = io::pipe().unwrap();
        let path = format!("/proc/self/fd/{}", writer.as_raw_fd());
        atomically(path.as_ref(), |out| out.write_all(b"ours")).unwrap();
        begin(path.as_ref()).unwrap().write_all(b"more").unwrap();
        drop(writer);
        let mut read = String::new();
        reader.read_to_string(&mut read).unwrap();
        assert_eq!(read, "oursmore");
        atomically("/dev/null".as_ref(), |out| out.write_all(b"ours")).unwrap();
        assert!(!fs::symlink_metadata("/dev/null").unwrap().is_file());
        assert!(is_descriptor("/dev/stdout".as_ref()) && !is_descriptor("/proc/self/exe".as_ref()));
    }

    #[test]
    fn a_name_that_the_program_makes_replaces_a_pipe() {
        let folder = folder("pipe");
        let path = folder.join("frame-0001.png");
        rustix::fs::mkfifoat(rustix::fs::CWD, &path, rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR)
            .unwrap();
        replace(&path, |out| out.write_all(b"ours")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"ours");
        fs::remove_dir_all(&folder).unwrap();
    }
}

//! Reading of files: what is no regular file is refused, unless the user has named it.
//!
//! Files of a folder that others may write to are opened without following a link and without
//! waiting for a pipe. A path that the user gives as an input is opened as it is, so that a pipe or
//! `/dev/stdin` serves; the bytes that are read from it are bounded either way.

use std::fs::OpenOptions;
use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::Path;

/// Opens the regular file at `path`, for `options`.
///
/// # Errors
/// If there is something else, which is named, or the system reports an error.
pub fn open_regular(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt;
        let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::NOCTTY;
        options.custom_flags(flags.bits() as i32);
    }
    // What cannot be opened, as a socket, is named by what it is, too.
    if let Some(error) = std::fs::symlink_metadata(path).ok().and_then(|meta| not_regular(&meta)) {
        return Err(error);
    }
    let file = options.open(path)?;
    match not_regular(&file.metadata()?) {
        Some(error) => Err(error),
        None => Ok(file),
    }
}

fn not_regular(meta: &Metadata) -> Option<io::Error> {
    let message = || format!("expected a regular file, found {}", kind_of(meta));
    (!meta.is_file()).then(|| io::Error::new(io::ErrorKind::InvalidInput, message()))
}

/// Returns what an entry of a folder is.
fn kind_of(meta: &Metadata) -> &'static str {
    let kind = meta.file_type();
    if kind.is_symlink() {
        return "a symbolic link";
    }
    if kind.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    "a device"
}

/// Reads the regular file at `path`.
///
/// # Errors
/// As [`open_regular`], or if it has more than `limit` bytes.
pub fn read_regular(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    read_all(open_regular(path, OpenOptions::new().read(true))?, limit)
}

/// Reads a file, a pipe or a device that the user has named.
///
/// # Errors
/// If it has more than `limit` bytes, or the system reports an error.
pub fn read_input(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    read_all(File::open(path)?, limit)
}

/// Reads an open file to its end.
fn read_all(file: File, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // A regular file that is too long is refused before it is read.
    let length = file.metadata().ok().filter(Metadata::is_file).map_or(0, |meta| meta.len());
    if length <= limit {
        bytes.try_reserve(length as usize).map_err(io::Error::other)?;
        file.take(limit + 1).read_to_end(&mut bytes)?;
    }
    match length.max(bytes.len() as u64) > limit {
        true => Err(io::Error::new(io::ErrorKind::InvalidInput, format!("over the limit of {limit} bytes"))),
        false => Ok(bytes),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn what_is_no_regular_file_is_named_and_not_read() {
        let folder = std::env::temp_dir().join(format!("fbptr-regular-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("folder")).unwrap();
        std::fs::write(folder.join("file"), "abc").unwrap();
        symlink("file", folder.join("link")).unwrap();
        let rights = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
        rustix::fs::mkfifoat(rustix::fs::CWD, folder.join("pipe"), rights).unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(folder.join("socket")).unwrap();
        assert_eq!(read_regular(&folder.join("file"), 3).unwrap(), b"abc");
        let said = |path: &Path, limit| read_regular(path, limit).unwrap_err().to_string();
        assert_eq!(said(&folder.join("file"), 2), "over the limit of 2 bytes");
        for (name, kind) in
            [("link", "a symbolic link"), ("folder", "a folder"), ("pipe", "a pipe"), ("socket", "a socket")]
        {
            assert_eq!(said(&folder.join(name), 9), format!("expected a regular file, found {kind}"));
        }
        assert_eq!(said("/dev/zero".as_ref(), 9), "expected a regular file, found a device");
        assert!(!said(&folder.join("none"), 9).contains("found"));
        // A device that the user names ends at the limit.
        assert_eq!(read_input("/dev/zero".as_ref(), 9).unwrap_err().to_string(), "over the limit of 9 bytes");
        assert_eq!(read_input(&folder.join("link"), 9).unwrap(), b"abc");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

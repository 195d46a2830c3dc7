//! Unix socket files: created with mode 0600 before any client can connect, replaced only if dead,
//! removed at the end.
//!
//! In: a path. Out: a non-blocking listening socket and its file.

use super::listen::{ListenAddress, ListenError};
use rustix::fs::{Mode, fchmod};
use rustix::io::{Errno, FdFlags, fcntl_setfd, ioctl_fionbio};
use rustix::net::{AddressFamily, SocketAddrUnix, SocketType, bind, connect, listen, socket};
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};

/// Connections that may wait to be accepted; the system may allow fewer.
const BACKLOG: i32 = 4096;
/// Readable and writable by the owner alone.
const MODE: u32 = 0o600;

/// A socket file, identified by device and inode: at the end only our own file is removed.
#[derive(Debug)]
pub(super) struct SocketFile {
    path: PathBuf,
    identity: (u64, u64),
}

impl Drop for SocketFile {
    fn drop(&mut self) {
        if identity_of(&self.path).is_ok_and(|i| i == self.identity) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

fn identity_of(path: &Path) -> io::Result<(u64, u64)> {
    std::fs::symlink_metadata(path).map(|m| (m.dev(), m.ino()))
}

/// Creates a socket file and listens on it; its `accept` does not block.
///
/// # Errors
/// See [`ListenError`].
pub(super) fn open(path: &Path) -> Result<(UnixListener, SocketFile), ListenError> {
    let place = || ListenAddress::Unix(path.into());
    let refused = |source: io::Error| ListenError::Refused { place: place(), source };
    let occupied = |found| ListenError::Occupied { place: place(), found };
    match std::fs::symlink_metadata(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {}
        Err(e) => return Err(refused(e)),
        Ok(meta) if !meta.file_type().is_socket() => return Err(occupied("a file of another kind is there")),
        Ok(_) if answers(path).map_err(|e| refused(e.into()))? => {
            return Err(occupied("another server answers there"));
        }
        Ok(_) => std::fs::remove_file(path).map_err(refused)?,
    }
    let (bound, file) = bind_file(path).map_err(refused)?;
    ioctl_fionbio(&bound, true).and_then(|()| listen(&bound, BACKLOG)).map_err(|e| refused(e.into()))?;
    Ok((UnixListener::from(bound), file))
}

/// Creates the socket file without listening yet: the system refuses a client that connects too
/// early.
fn bind_file(path: &Path) -> io::Result<(OwnedFd, SocketFile)> {
    let bound = unix_socket()?;
    // Linux gives the file the mode of the socket. Other systems refuse this call, and the file's
    // mode is set below.
    let _ = fchmod(&bound, Mode::from_raw_mode(MODE as _));
    bind(&bound, &SocketAddrUnix::new(path)?)?;
    let file = SocketFile { path: path.into(), identity: identity_of(path)? };
    if std::fs::symlink_metadata(path)?.permissions().mode() & 0o777 != MODE {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(MODE))?;
    }
    Ok((bound, file))
}

fn unix_socket() -> io::Result<OwnedFd> {
    let made = socket(AddressFamily::UNIX, SocketType::STREAM, None)?;
    fcntl_setfd(&made, FdFlags::CLOEXEC)?;
    Ok(made)
}

/// Returns whether a server listens on a socket file. Does not block: a server whose backlog is
/// full counts, too.
fn answers(path: &Path) -> Result<bool, Errno> {
    let probe = unix_socket().map_err(|e| Errno::from_io_error(&e).unwrap_or(Errno::IO))?;
    ioctl_fionbio(&probe, true)?;
    match connect(&probe, &SocketAddrUnix::new(path)?) {
        Ok(()) | Err(Errno::AGAIN | Errno::INPROGRESS) => Ok(true),
        Err(Errno::CONNREFUSED) => Ok(false),
        Err(e) => Err(e),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::net::UnixStream;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("fbptr-unix-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn the_file_has_its_mode_before_anybody_can_connect() {
        let folder = folder("mode");
        let path = folder.join("s");
        let (bound, file) = bind_file(&path).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, MODE);
        assert_eq!(UnixStream::connect(&path).unwrap_err().kind(), io::ErrorKind::ConnectionRefused);
        listen(&bound, BACKLOG).unwrap();
        assert!(UnixStream::connect(&path).is_ok());
        drop(file);
        assert!(!path.exists());
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_server_with_a_full_backlog_answers_and_a_dead_one_does_not() {
        let folder = folder("backlog");
        let path = folder.join("s");
        let (bound, file) = bind_file(&path).unwrap();
        listen(&bound, 1).unwrap();
        let clients: Vec<_> = (0..8)
            .map(|_| {
                let client = unix_socket().unwrap();
                ioctl_fionbio(&client, true).unwrap();
                let is_full = connect(&client, &SocketAddrUnix::new(&path).unwrap()) == Err(Errno::AGAIN);
                (client, is_full)
            })
            .collect();
        // On systems that do not report a full backlog by AGAIN, it cannot be told from a dead
        // server here.
        if cfg!(target_os = "linux") {
            assert!(clients.iter().any(|(_, is_full)| *is_full));
            assert_eq!(answers(&path), Ok(true));
        }
        drop((clients, bound));
        assert_eq!(answers(&path), Ok(false));
        drop(file);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

//! Listening: addresses and socket files that clients connect to.
//!
//! One thread a listener blocks in `accept`; ending it connects to itself once. A Unix socket file that no server
//! answers on is replaced, any other file is left alone; the socket file is made with mode 0600 and goes at the end.

use super::{Conversation, Input, Slot, Socket, converse};
use crate::command::EndOfInput;
use crate::server::Audience;
use crate::server::thread::Link;
use std::fmt;
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, Ipv6Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
#[cfg(unix)]
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

/// Where to listen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A TCP address.
    Tcp(SocketAddr),
    /// A Unix socket file.
    Unix(PathBuf),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Tcp(address) => write!(f, "tcp {address}"),
            Place::Unix(path) => write!(f, "unix {}", path.display()),
        }
    }
}

/// Why a place cannot be listened on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ListenError {
    /// The system refused.
    #[error("cannot listen on {place}: {source}")]
    Refused {
        /// Where.
        place: Place,
        /// Why.
        source: io::Error,
    },
    /// A file is there that is no dead socket.
    #[error("cannot listen on {place}: {found}, and only a dead socket is replaced")]
    Occupied {
        /// Where.
        place: Place,
        /// What is there.
        found: &'static str,
    },
    /// This system has no Unix sockets.
    #[error("cannot listen on {place}: this system has no unix sockets")]
    NoUnix {
        /// Where.
        place: Place,
    },
}

enum Door {
    Tcp(TcpListener),
    #[cfg(unix)]
    Unix {
        listener: UnixListener,
        _file: SocketFile,
    },
}

/// A socket file, known by device and inode: at the end only our own is removed.
#[cfg(unix)]
#[derive(Debug)]
struct SocketFile {
    path: PathBuf,
    identity: (u64, u64),
}

#[cfg(unix)]
impl Drop for SocketFile {
    fn drop(&mut self) {
        if identity_of(&self.path).is_ok_and(|i| i == self.identity) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

#[cfg(unix)]
fn identity_of(path: &std::path::Path) -> io::Result<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    std::fs::symlink_metadata(path).map(|m| (m.dev(), m.ino()))
}

/// A place that is listened on. Dropping it ends the listening, not the connections.
#[derive(Debug)]
pub struct Listener {
    place: Place,
    is_ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Listener {
    /// Listens on `place` and hands connections to the render thread, `limit` at a time among all listeners that share
    /// `count`; one more is told `ERR 0 0 EQUOTA CONNECT` and closed.
    ///
    /// # Errors
    /// See [`ListenError`].
    pub(crate) fn start(
        place: Place,
        link: Link,
        count: Arc<AtomicUsize>,
        limit: usize,
    ) -> Result<Listener, ListenError> {
        let refused = |source| ListenError::Refused { place: place.clone(), source };
        let (door, place) = match &place {
            Place::Tcp(address) => {
                let listener = TcpListener::bind(address).map_err(refused)?;
                let address = listener.local_addr().map_err(refused)?;
                (Door::Tcp(listener), Place::Tcp(address))
            }
            #[cfg(unix)]
            Place::Unix(path) => (bind_unix(path, &place)?, place.clone()),
            #[cfg(not(unix))]
            Place::Unix(_) => return Err(ListenError::NoUnix { place }),
        };
        let is_ending = Arc::new(AtomicBool::new(false));
        let is_over = is_ending.clone();
        let thread = Builder::new()
            .name(format!("listen {place}"))
            .spawn(move || accept_all(door, &link, &count, limit, &is_over))
            .map_err(|source| ListenError::Refused { place: place.clone(), source })?;
        Ok(Listener { place, is_ending, thread: Some(thread) })
    }

    /// Where it listens; a port of 0 has become the one that the system gave.
    pub fn place(&self) -> &Place {
        &self.place
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.is_ending.store(true, Ordering::Release);
        // Wakes the thread up. Where that fails it sleeps on, and ends with the process.
        let is_woken = match &self.place {
            Place::Tcp(address) => {
                let mut address = *address;
                match address {
                    SocketAddr::V4(a) if a.ip().is_unspecified() => {
                        address.set_ip(Ipv4Addr::LOCALHOST.into())
                    }
                    SocketAddr::V6(a) if a.ip().is_unspecified() => {
                        address.set_ip(Ipv6Addr::LOCALHOST.into())
                    }
                    _ => {}
                }
                TcpStream::connect_timeout(&address, Duration::from_millis(300)).is_ok()
            }
            #[cfg(unix)]
            Place::Unix(path) => UnixStream::connect(path).is_ok(),
            #[cfg(not(unix))]
            Place::Unix(_) => false,
        };
        if is_woken && let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(unix)]
fn bind_unix(path: &std::path::Path, place: &Place) -> Result<Door, ListenError> {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt};
    let refused = |source| ListenError::Refused { place: place.clone(), source };
    let occupied = |found| ListenError::Occupied { place: place.clone(), found };
    match std::fs::symlink_metadata(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {}
        Err(e) => return Err(refused(e)),
        Ok(meta) if !meta.file_type().is_socket() => return Err(occupied("a file of another kind is there")),
        Ok(_) => match UnixStream::connect(path) {
            Ok(_) => return Err(occupied("another server answers there")),
            Err(e) if e.kind() == io::ErrorKind::ConnectionRefused => {
                std::fs::remove_file(path).map_err(refused)?;
            }
            Err(e) => return Err(refused(e)),
        },
    }
    let listener = UnixListener::bind(path).map_err(refused)?;
    let file = SocketFile { path: path.into(), identity: identity_of(path).map_err(refused)? };
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600)).map_err(refused)?;
    Ok(Door::Unix { listener, _file: file })
}

fn accept_all(door: Door, link: &Link, count: &Arc<AtomicUsize>, limit: usize, is_ending: &AtomicBool) {
    loop {
        let accepted = match &door {
            Door::Tcp(listener) => listener.accept().map(|(s, _)| {
                // Replies are short, and waited for.
                let _ = s.set_nodelay(true);
                Socket::Tcp(s)
            }),
            #[cfg(unix)]
            Door::Unix { listener, .. } => listener.accept().map(|(s, _)| Socket::Unix(s)),
        };
        if is_ending.load(Ordering::Acquire) {
            return;
        }
        match accepted {
            Ok(socket) => welcome(socket, link, count, limit),
            // Out of descriptors or memory: what is there goes on, and others may end in a moment.
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}

fn welcome(socket: Socket, link: &Link, count: &Arc<AtomicUsize>, limit: usize) {
    let slot = Arc::new(Slot(count.clone()));
    if count.fetch_add(1, Ordering::AcqRel) >= limit {
        return turn_away(socket, slot, limit);
    }
    let handles = socket.try_clone().and_then(|input| Ok((input, socket.try_clone()?)));
    // Without descriptors there is no conversation: the socket closes.
    let Ok((input, output)) = handles else { return };
    let conversation = Conversation {
        input: Input::Socket(input),
        output: Box::new(output),
        control: Arc::new(socket),
        end: EndOfInput::Stream,
        audience: Audience::Connection,
        may_replay: false,
        on_notice: None,
        on_end: None,
        slot: Some(slot),
    };
    let _ = converse(link, conversation);
}

/// Those turned away at one time that are still listened to, so that they get to read why.
const MAX_TURNED_AWAY: usize = 64;

fn turn_away(socket: Socket, slot: Arc<Slot>, limit: usize) {
    static LINGERING: AtomicUsize = AtomicUsize::new(0);
    // It takes no place among the connections.
    drop(slot);
    let line = format!("ERR 0 0 EQUOTA CONNECT: no more than {limit} connections at one time\n");
    let goodbye = move |mut socket: Socket| {
        let told =
            socket.set_timeout(Duration::from_secs(1)).and_then(|()| socket.write_all(line.as_bytes()));
        socket.shutdown(Shutdown::Write);
        // A socket closed with bytes unread would take the line along.
        let mut rest = [0; 1024];
        let mut rounds = 0;
        while told.is_ok() && rounds < 1000 && matches!(socket.read(&mut rest), Ok(n) if n > 0) {
            rounds += 1;
        }
    };
    if LINGERING.fetch_add(1, Ordering::AcqRel) < MAX_TURNED_AWAY {
        let linger = move || {
            goodbye(socket);
            LINGERING.fetch_sub(1, Ordering::AcqRel);
        };
        if Builder::new().stack_size(64 << 10).spawn(linger).is_err() {
            LINGERING.fetch_sub(1, Ordering::AcqRel);
        }
    } else {
        LINGERING.fetch_sub(1, Ordering::AcqRel);
    }
}

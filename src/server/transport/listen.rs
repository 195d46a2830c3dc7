//! Listening: addresses and socket files that clients connect to.
//!
//! One thread a listener blocks in `accept`; ending it connects to itself once. A connection that there is no place, no
//! descriptor or no thread for is told so (`refuse.rs`), and so is standard error. Promises: whatever fails, the thread goes
//! on accepting, and serves again when it passes.

use super::descriptors::{self, Spare};
use super::refuse::{refuse, refuse_now};
use super::report::{Trouble, report};
#[cfg(unix)]
use super::unix::{self, SocketFile};
use super::{Admission, Conversation, Input, Medium, Refusal, SharedSocket, Socket, Stream, converse};
use crate::command::EndOfInput;
use crate::server::Audience;
use crate::server::thread::Link;
use std::fmt;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, TcpStream};
#[cfg(unix)]
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
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

impl Door {
    fn open(place: &Place) -> Result<(Door, Place), ListenError> {
        match place {
            Place::Tcp(address) => {
                let refused = |source| ListenError::Refused { place: place.clone(), source };
                let listener = TcpListener::bind(address).map_err(refused)?;
                let address = listener.local_addr().map_err(refused)?;
                Ok((Door::Tcp(listener), Place::Tcp(address)))
            }
            #[cfg(unix)]
            Place::Unix(path) => {
                let (listener, file) = unix::open(path)?;
                Ok((Door::Unix { listener, _file: file }, place.clone()))
            }
            #[cfg(not(unix))]
            Place::Unix(_) => Err(ListenError::NoUnix { place: place.clone() }),
        }
    }

    /// The next client, and its address where it has one.
    fn accept(&self) -> io::Result<(Stream, Option<IpAddr>)> {
        match self {
            Door::Tcp(listener) => {
                let (stream, peer) = listener.accept()?;
                // Replies are short, and waited for.
                let _ = stream.set_nodelay(true);
                Ok((Stream::Tcp(stream), Some(peer.ip())))
            }
            #[cfg(unix)]
            Door::Unix { listener, .. } => listener.accept().map(|(stream, _)| (Stream::Unix(stream), None)),
        }
    }

    /// Makes `accept` wait for a connection, or not.
    fn set_waiting(&self, waits: bool) -> io::Result<()> {
        match self {
            Door::Tcp(listener) => listener.set_nonblocking(!waits),
            #[cfg(unix)]
            Door::Unix { listener, .. } => listener.set_nonblocking(!waits),
        }
    }
}

/// A place that is listened on. Dropping it ends the listening, not the connections.
#[derive(Debug)]
pub struct Listener {
    place: Place,
    is_ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Listener {
    /// Listens on `place` and hands connections to the render thread, as many as `admission` lets in; others are told
    /// `ERR 0 0 EQUOTA CONNECT` and closed.
    ///
    /// # Errors
    /// See [`ListenError`].
    pub(crate) fn start(
        place: Place,
        link: Link,
        admission: Arc<Admission>,
    ) -> Result<Listener, ListenError> {
        let (door, place) = Door::open(&place)?;
        let is_ending = Arc::new(AtomicBool::new(false));
        let (is_over, name) = (is_ending.clone(), place.clone());
        let reception = Reception { link, admission };
        let thread = Builder::new()
            .name(format!("listen {place}"))
            .spawn(move || accept_all(&door, &name, &reception, &is_over))
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

/// Where connections that were accepted go.
struct Reception {
    link: Link,
    admission: Arc<Admission>,
}

/// The pause after an accept that failed: what is missing may come back.
const PAUSE: Duration = Duration::from_millis(20);

fn accept_all(door: &Door, place: &Place, reception: &Reception, is_ending: &AtomicBool) {
    let mut spare = Spare::new();
    loop {
        let accepted = door.accept();
        if is_ending.load(Ordering::Acquire) {
            return;
        }
        match accepted {
            Ok((stream, peer)) => reception.welcome(stream, peer),
            // Its client has gone in the meantime.
            Err(e) if matches!(e.kind(), io::ErrorKind::ConnectionAborted | io::ErrorKind::Interrupted) => {}
            Err(e) if descriptors::are_exhausted(&e) => {
                turn_away_with(&mut spare, door, place, reception, &e);
            }
            Err(e) => {
                report(Trouble::Accept, format_args!("cannot accept a connection on {place}: {e}"));
                std::thread::sleep(PAUSE);
            }
        }
    }
}

/// Gives the spare descriptor up to accept one connection, which would wait without a word otherwise, and refuse it.
fn turn_away_with(spare: &mut Spare, door: &Door, place: &Place, reception: &Reception, why: &io::Error) {
    spare.give_up();
    // The system asks for a descriptor before it looks whether anybody is there: `accept` must not wait here.
    let accepted = door.set_waiting(false).and_then(|()| door.accept());
    let is_waiting = door.set_waiting(true);
    match accepted {
        Ok((stream, _)) => {
            reception.admission.note_no_resources();
            report(Trouble::Descriptors, format_args!("refused a connection on {place}: {why}"));
            refuse_now(Socket::new(stream, None), "the server has no descriptor left for it");
        }
        Err(e) => {
            if e.kind() != io::ErrorKind::WouldBlock {
                report(Trouble::Descriptors, format_args!("cannot accept a connection on {place}: {e}"));
            }
            std::thread::sleep(PAUSE);
        }
    }
    spare.take();
    if let Err(e) = is_waiting {
        report(Trouble::Accept, format_args!("cannot wait for connections on {place}: {e}"));
    }
}

impl Reception {
    /// Begins a conversation with a client, or tells it why there is none.
    fn welcome(&self, stream: Stream, peer: Option<IpAddr>) {
        let slot = match self.admission.admit(peer) {
            Ok(slot) => slot,
            Err(refusal) => {
                match refusal {
                    Refusal::Full { limit } => {
                        let what =
                            format_args!("refused a connection: {limit} are there, which is the limit");
                        report(Trouble::Full, what);
                    }
                    Refusal::AddressFull { network, limit } => report(
                        Trouble::AddressFull,
                        format_args!(
                            "refused a connection from {network}: it has {limit}, which is the limit"
                        ),
                    ),
                }
                return refuse(Socket::new(stream, None), &refusal.to_string());
            }
        };
        let socket = Arc::new(Socket::new(stream, Some(slot)));
        let conversation = Conversation {
            input: Input::Socket(socket.clone()),
            output: Box::new(SharedSocket(socket.clone())),
            control: socket.clone(),
            end: EndOfInput::Stream,
            audience: Audience::Connection,
            medium: if peer.is_some() { Medium::TcpSocket } else { Medium::UnixSocket },
            may_replay: false,
            on_notice: None,
            on_end: None,
        };
        if let Err(e) = converse(&self.link, conversation) {
            self.admission.note_no_resources();
            report(Trouble::Threads, format_args!("refused a connection: it cannot be read: {e}"));
            // Nobody else has it: it did not begin.
            if let Some(socket) = Arc::into_inner(socket) {
                refuse(socket, "the server has no means left to read it");
            }
        }
    }
}

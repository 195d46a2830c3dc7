//! Listening: addresses and socket files that clients connect to.
//!
//! One thread a listener accepts, and sleeps in a selector of its own when nobody comes. A
//! connection that there is no place, no descriptor or no thread for is told so (`refuse.rs`), and
//! so is standard error. Promises: whatever fails, the thread goes on accepting, and serves again
//! when it passes.

use super::descriptors::{self, ReservedDescriptor};
use super::refuse::{refuse, refuse_now};
use super::report::{Trouble, report};
use super::selector::Selector;
#[cfg(unix)]
use super::unix::{self, SocketFile};
use super::{Admission, ByteSource, Endpoint, Medium, Refusal, Replies, Stream, serve_connection};
use crate::command::EndOfInput;
use crate::server::Audience;
use crate::server::thread::Link;
use mio::net::TcpListener;
#[cfg(unix)]
use mio::net::UnixListener;
use std::fmt;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

/// Where to listen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ListenAddress {
    /// A TCP address.
    Tcp(SocketAddr),
    /// A Unix socket file.
    Unix(PathBuf),
}

impl fmt::Display for ListenAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ListenAddress::Tcp(address) => write!(f, "tcp {address}"),
            ListenAddress::Unix(path) => write!(f, "unix {}", path.display()),
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
        place: ListenAddress,
        /// Why.
        source: io::Error,
    },
    /// A file is there that is no dead socket.
    #[error("cannot listen on {place}: {found}, and only a dead socket is replaced")]
    Occupied {
        /// Where.
        place: ListenAddress,
        /// What is there.
        found: &'static str,
    },
    /// This system has no Unix sockets.
    #[error("cannot listen on {place}: this system has no unix sockets")]
    NoUnix {
        /// Where.
        place: ListenAddress,
    },
}

enum ListenSocket {
    Tcp(TcpListener),
    #[cfg(unix)]
    Unix {
        listener: UnixListener,
        _file: SocketFile,
    },
}

impl ListenSocket {
    fn open(place: &ListenAddress) -> Result<(ListenSocket, ListenAddress), ListenError> {
        match place {
            ListenAddress::Tcp(address) => {
                let refused = |source| ListenError::Refused { place: place.clone(), source };
                let listener = std::net::TcpListener::bind(address).map_err(refused)?;
                let address = listener.local_addr().map_err(refused)?;
                listener.set_nonblocking(true).map_err(refused)?;
                Ok((ListenSocket::Tcp(TcpListener::from_std(listener)), ListenAddress::Tcp(address)))
            }
            #[cfg(unix)]
            ListenAddress::Unix(path) => {
                let (listener, file) = unix::open(path)?;
                Ok((
                    ListenSocket::Unix { listener: UnixListener::from_std(listener), _file: file },
                    place.clone(),
                ))
            }
            #[cfg(not(unix))]
            ListenAddress::Unix(_) => Err(ListenError::NoUnix { place: place.clone() }),
        }
    }

    /// The next client, and its address where it has one.
    fn accept(&self) -> io::Result<(Stream, Option<IpAddr>)> {
        match self {
            ListenSocket::Tcp(listener) => {
                let (stream, peer) = listener.accept()?;
                // Replies are short, and waited for.
                let _ = stream.set_nodelay(true);
                Ok((Stream::Tcp(stream), Some(peer.ip())))
            }
            #[cfg(unix)]
            ListenSocket::Unix { listener, .. } => {
                listener.accept().map(|(stream, _)| (Stream::Unix(stream), None))
            }
        }
    }

    fn register(&mut self, selector: &Selector) -> io::Result<()> {
        match self {
            ListenSocket::Tcp(listener) => selector.register(listener, 0),
            #[cfg(unix)]
            ListenSocket::Unix { listener, .. } => selector.register(listener, 0),
        }
    }
}

/// A place that is listened on. Dropping it ends the listening, not the connections.
#[derive(Debug)]
pub struct Listener {
    place: ListenAddress,
    is_ending: Arc<AtomicBool>,
    selector: Arc<Selector>,
    thread: Option<JoinHandle<()>>,
}

impl Listener {
    /// Listens on `place` and hands connections to the render thread, as many as `admission` lets
    /// in; others are told `ERR 0 0 EQUOTA CONNECT` and closed.
    ///
    /// # Errors
    /// See [`ListenError`].
    pub(crate) fn start(
        place: ListenAddress,
        link: Link,
        admission: Arc<Admission>,
    ) -> Result<Listener, ListenError> {
        let (mut socket, place) = ListenSocket::open(&place)?;
        let refused = |source| ListenError::Refused { place: place.clone(), source };
        let selector = Arc::new(Selector::new().map_err(refused)?);
        socket.register(&selector).map_err(refused)?;
        let is_ending = Arc::new(AtomicBool::new(false));
        let acceptor = Acceptor {
            socket,
            place: place.clone(),
            selector: selector.clone(),
            is_ending: is_ending.clone(),
            link,
            admission,
        };
        let thread = Builder::new()
            .name(format!("listen {place}"))
            .spawn(move || acceptor.accept_all())
            .map_err(refused)?;
        Ok(Listener { place, is_ending, selector, thread: Some(thread) })
    }

    /// Where it listens; a port of 0 has become the one that the system gave.
    pub fn place(&self) -> &ListenAddress {
        &self.place
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.is_ending.store(true, Ordering::Release);
        self.selector.wake();
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has ended, too.
            let _ = thread.join();
        }
    }
}

/// The pause after an accept that failed: what is missing may come back.
const PAUSE: Duration = Duration::from_millis(20);

/// What the thread of a listener has.
struct Acceptor {
    socket: ListenSocket,
    place: ListenAddress,
    selector: Arc<Selector>,
    is_ending: Arc<AtomicBool>,
    link: Link,
    admission: Arc<Admission>,
}

impl Acceptor {
    fn accept_all(&self) {
        let mut reserved = ReservedDescriptor::new();
        while !self.is_ending.load(Ordering::Acquire) {
            match self.socket.accept() {
                Ok((stream, peer)) => self.serve_client(stream, peer),
                Err(e) => self.after(&e, &mut reserved),
            }
        }
    }

    /// Does what an accept without a connection calls for.
    fn after(&self, error: &io::Error, reserved: &mut ReservedDescriptor) {
        match error.kind() {
            io::ErrorKind::WouldBlock => self.wait(),
            // Its client has gone in the meantime.
            io::ErrorKind::ConnectionAborted | io::ErrorKind::Interrupted => {}
            _ if descriptors::are_exhausted(error) => self.refuse_with(reserved, error),
            _ => self.pause(Trouble::Accept, "cannot accept a connection", error),
        }
    }

    /// Waits until somebody comes, or the listening is to end.
    fn wait(&self) {
        if let Err(e) = self.selector.wait(|_| ()) {
            self.pause(Trouble::Accept, "cannot wait for connections", &e);
        }
    }

    fn pause(&self, trouble: Trouble, what: &str, why: &io::Error) {
        report(trouble, format_args!("{what} on {}: {why}", self.place));
        std::thread::sleep(PAUSE);
    }

    /// Gives the spare descriptor up to accept one connection, which would wait without a word
    /// otherwise, and refuse it.
    fn refuse_with(&self, reserved: &mut ReservedDescriptor, why: &io::Error) {
        reserved.give_up();
        let accepted = self.socket.accept();
        match accepted {
            Ok((stream, _)) => {
                self.admission.note_no_resources();
                report(Trouble::Descriptors, format_args!("refused a connection on {}: {why}", self.place));
                refuse_now(stream, "the server has no descriptor left for it");
                reserved.take();
            }
            // The system asks for a descriptor before it looks whether anybody is there.
            Err(e) if e.kind() == io::ErrorKind::WouldBlock => {
                reserved.take();
                self.wait();
            }
            Err(e) => {
                self.pause(Trouble::Descriptors, "cannot accept a connection", &e);
                reserved.take();
            }
        }
    }

    /// Serves a client, or sends it the reason why not.
    fn serve_client(&self, stream: Stream, peer: Option<IpAddr>) {
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
                return refuse(stream, &refusal.to_string());
            }
        };
        let socket = match self.link.poller.adopt(stream, self.link.new_id(), slot) {
            Ok(socket) => socket,
            Err((stream, e)) => {
                self.admission.note_no_resources();
                report(Trouble::Threads, format_args!("refused a connection: it cannot be read: {e}"));
                return refuse(stream, "the server has no means left to read it");
            }
        };
        let endpoint = Endpoint {
            input: ByteSource::Socket(socket.clone()),
            output: Box::new(Replies(socket.clone())),
            control: socket,
            end: EndOfInput::Stream,
            audience: Audience::Connection,
            medium: if peer.is_some() { Medium::TcpSocket } else { Medium::UnixSocket },
            may_replay: false,
            on_notice: None,
            on_end: None,
        };
        // A socket needs no more than it was given by now.
        if let Err(e) = serve_connection(&self.link, endpoint) {
            report(Trouble::Threads, format_args!("ended a connection: {e}"));
        }
    }
}

//! Listeners: accept clients on TCP addresses and Unix socket files.
//!
//! In: connections of clients. Out: their sockets, served by the poller and the render thread. Each
//! listener has one thread, which accepts, and sleeps in a selector of its own. If no place, no
//! descriptor or no thread is left for a connection, its client is sent an error (`refuse.rs`), and
//! standard error gets a line. Promises: whatever fails, the thread goes on accepting, and serves
//! clients again when the cause is gone.

use super::descriptors::{self, ReservedDescriptor};
use super::refuse::{refuse, refuse_now};
use super::report::{Trouble, report};
use super::selector::Selector;
#[cfg(unix)]
use super::unix::{self, SocketFile};
use super::{ByteSource, Endpoint, Link, Replies, Stream, serve_connection};
use crate::admission::{Admission, Refusal};
use crate::message::Medium;
use fbptr_command::EndOfInput;
use fbptr_engine::session::Audience;
use mio::net::TcpListener;
#[cfg(unix)]
use mio::net::UnixListener;
use std::error::Error;
use std::fmt;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

/// Address of a listener.
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

/// Reason why an address cannot be listened on.
#[derive(Debug)]
#[non_exhaustive]
pub enum ListenError {
    /// The system refused.
    Refused {
        /// The address.
        place: ListenAddress,
        /// The system's error.
        source: io::Error,
    },
    /// A file is there that is not a dead socket.
    Occupied {
        /// The address.
        place: ListenAddress,
        /// Description of the file.
        found: &'static str,
    },
    /// This system has no Unix sockets.
    NoUnix {
        /// The address.
        place: ListenAddress,
    },
}

impl fmt::Display for ListenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ListenError::Refused { place, source } => write!(f, "cannot listen on {place}: {source}"),
            ListenError::Occupied { place, found } => {
                write!(f, "cannot listen on {place}: {found}, and only a dead socket is replaced")
            }
            ListenError::NoUnix { place } => {
                write!(f, "cannot listen on {place}: this system has no unix sockets")
            }
        }
    }
}

impl Error for ListenError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            ListenError::Refused { source, .. } => Some(source),
            _ => None,
        }
    }
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

    /// Accepts the next client. Returns its socket, and its IP address if it has one.
    fn accept(&self) -> io::Result<(Stream, Option<IpAddr>)> {
        match self {
            ListenSocket::Tcp(listener) => {
                let (stream, peer) = listener.accept()?;
                // Replies are short, and clients wait for them.
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

/// A listener. Dropping it ends the listening, not the connections.
#[derive(Debug)]
pub struct Listener {
    place: ListenAddress,
    is_ending: Arc<AtomicBool>,
    selector: Arc<Selector>,
    thread: Option<JoinHandle<()>>,
}

impl Listener {
    /// Listens on `place` and serves as many connections as `admission` allows; others are sent
    /// `ERR 0 0 EQUOTA CONNECT` and closed.
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

    /// Returns the address; a port of 0 is replaced by the one that the system chose.
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

/// Pause after a failed accept, in which resources may become free.
const PAUSE: Duration = Duration::from_millis(20);

/// State of a listener's thread.
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

    /// Handles an error of `accept`.
    fn after(&self, error: &io::Error, reserved: &mut ReservedDescriptor) {
        match error.kind() {
            io::ErrorKind::WouldBlock => self.wait(),
            // The client has gone in the meantime.
            io::ErrorKind::ConnectionAborted | io::ErrorKind::Interrupted => {}
            _ if descriptors::are_exhausted(error) => self.refuse_with(reserved, error),
            _ => self.pause(Trouble::Accept, "cannot accept a connection", error),
        }
    }

    /// Waits until a client connects, or the listener is to end.
    fn wait(&self) {
        if let Err(e) = self.selector.wait(None, |_| ()) {
            self.pause(Trouble::Accept, "cannot wait for connections", &e);
        }
    }

    fn pause(&self, trouble: Trouble, what: &str, why: &io::Error) {
        report(trouble, format_args!("{what} on {}: {why}", self.place));
        std::thread::sleep(PAUSE);
    }

    /// Closes the reserved descriptor to accept one connection and refuse it; otherwise its client
    /// would wait without an answer.
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
            // The system allocates a descriptor before it checks whether a client is waiting.
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

    /// Serves a client, or sends it the reason for the refusal.
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
        // A socket needs no resources beyond those it has already.
        if let Err(e) = serve_connection(&self.link, endpoint) {
            report(Trouble::Threads, format_args!("ended a connection: {e}"));
        }
    }
}

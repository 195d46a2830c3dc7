//! The web thread: accepts connections, and serves all of them without blocking.
//!
//! In: sockets that can be read or written; frames on the feed; answers of the render thread. Out:
//! responses, frames and replies. Promises: at most [`MAX_CONNECTIONS`] connections; one that is no
//! viewer yet gives way to a new one, so idle or slow requests lock nobody out; each connection has
//! a bounded turn; compressed tiles that slow viewers hold beside the newest frame have at most
//! [`HELD_BYTES`].

use super::connection::{HttpConnection, PATIENCE, Step};
use super::socket::Viewer;
use super::tiles::TileFrame;
use super::{MAX_CONNECTIONS, MAX_VIEWERS, WebFeed, WebOptions, WebTarget};
use crate::message::Message;
use crossbeam_channel::{Receiver, Sender, bounded};
use mio::net::{TcpListener, TcpStream};
use mio::{Events, Interest, Poll, Token, Waker};
use std::collections::HashMap;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

mod requests;

use requests::Depth;

const LISTENER: Token = Token(0);
const WAKER: Token = Token(1);
/// Longest sleep: times are looked at this often.
const TICK: Duration = Duration::from_millis(250);
/// Time between two messages with the values of the metrics.
const STATS_EVERY: Duration = Duration::from_secs(1);
/// Pause after a failed accept, in which resources may become free.
const PAUSE: Duration = Duration::from_millis(20);
/// Bytes of compressed tiles that viewers may hold beyond four whole frames.
const HELD_BYTES: u64 = 32 << 20;
/// Connections accepted in one turn.
const ACCEPTS_A_TURN: usize = 64;

/// A connection of any kind.
enum Connection {
    Http(HttpConnection, IpAddr),
    Viewer(Box<Viewer>),
}

struct Member {
    connection: Connection,
    since: Instant,
}

impl Member {
    fn has_joined(&self) -> bool {
        matches!(&self.connection, Connection::Viewer(viewer) if viewer.rights.is_some())
    }
}

/// State of the web thread.
pub(super) struct EventLoop {
    poll: Poll,
    listener: TcpListener,
    address: SocketAddr,
    feed: Arc<WebFeed>,
    options: WebOptions,
    target: WebTarget,
    is_ending: Arc<AtomicBool>,
    members: HashMap<usize, Member>,
    next_token: usize,
    /// Set if connections may be waiting to be accepted.
    may_accept: bool,
    frame: TileFrame,
    depths: (Sender<Depth>, Receiver<Depth>),
    listeners: bool,
    title: Option<String>,
    stats: Option<String>,
    stats_at: Instant,
    ticked_at: Instant,
}

impl EventLoop {
    pub fn new(
        feed: Arc<WebFeed>,
        options: WebOptions,
        target: WebTarget,
        is_ending: Arc<AtomicBool>,
    ) -> io::Result<EventLoop> {
        let mut listener = TcpListener::bind(options.address)?;
        let address = listener.local_addr()?;
        let poll = Poll::new()?;
        poll.registry().register(&mut listener, LISTENER, Interest::READABLE)?;
        feed.set_waker(Arc::new(Waker::new(poll.registry(), WAKER)?));
        let now = Instant::now();
        Ok(EventLoop {
            poll,
            listener,
            address,
            frame: TileFrame::new(feed.display()),
            feed,
            options,
            target,
            is_ending,
            members: HashMap::new(),
            next_token: 2,
            may_accept: true,
            depths: bounded(MAX_VIEWERS),
            listeners: false,
            title: None,
            stats: None,
            stats_at: now,
            ticked_at: now,
        })
    }

    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Serves until the server ends.
    pub fn run(mut self) {
        lower_priority();
        let mut events = Events::with_capacity(256);
        while !self.is_ending.load(Ordering::Acquire) {
            let timeout = if self.has_work() { Duration::ZERO } else { TICK };
            if let Err(e) = self.poll.poll(&mut events, Some(timeout))
                && e.kind() != io::ErrorKind::Interrupted
            {
                std::thread::sleep(PAUSE);
            }
            let mut http = Vec::new();
            for event in &events {
                match event.token() {
                    LISTENER => self.may_accept = true,
                    WAKER => {}
                    Token(token) => match self.members.get_mut(&token).map(|m| &mut m.connection) {
                        Some(Connection::Viewer(viewer)) => {
                            viewer.is_readable |= event.is_readable();
                            viewer.is_writable |= event.is_writable();
                        }
                        Some(Connection::Http(..)) => http.push(token),
                        None => {}
                    },
                }
            }
            let now = Instant::now();
            self.accept(now, &mut http);
            http.into_iter().for_each(|token| self.advance(token, now));
            self.take_updates();
            self.serve_viewers(now);
            if now >= self.ticked_at + TICK {
                self.ticked_at = now;
                self.tick(now);
            }
        }
    }

    /// Returns whether something can be done without waiting for a socket.
    fn has_work(&self) -> bool {
        self.may_accept
            || self.members.values().any(|member| match &member.connection {
                Connection::Viewer(viewer) => viewer.is_readable && viewer.stalled.is_none(),
                Connection::Http(..) => false,
            })
    }

    /// Accepts connections, and lists them to be looked at.
    fn accept(&mut self, now: Instant, http: &mut Vec<usize>) {
        for _ in 0..if self.may_accept { ACCEPTS_A_TURN } else { 0 } {
            match self.listener.accept() {
                Ok((stream, peer)) => http.extend(self.add(stream, peer.ip(), now)),
                Err(e) if e.kind() == io::ErrorKind::WouldBlock => self.may_accept = false,
                Err(e)
                    if matches!(e.kind(), io::ErrorKind::ConnectionAborted | io::ErrorKind::Interrupted) => {}
                // No descriptor or memory is left: other connections may end soon. The viewers are
                // served in between.
                Err(_) => return std::thread::sleep(PAUSE),
            }
            if !self.may_accept {
                return;
            }
        }
    }

    /// Adds a connection, in the place of the oldest one that is no viewer if there is no other.
    fn add(&mut self, mut stream: TcpStream, peer: IpAddr, now: Instant) -> Option<usize> {
        if self.members.len() >= MAX_CONNECTIONS {
            let oldest = self
                .members
                .iter()
                .filter(|(_, m)| !m.has_joined())
                .min_by_key(|(_, m)| m.since)
                .map(|(t, _)| *t);
            self.remove(oldest?);
        }
        let _ = stream.set_nodelay(true);
        let token = self.next_token;
        self.next_token += 1;
        let interest = Interest::READABLE | Interest::WRITABLE;
        self.poll.registry().register(&mut stream, Token(token), interest).ok()?;
        let connection = Connection::Http(HttpConnection::new(stream), peer);
        self.members.insert(token, Member { connection, since: now });
        Some(token)
    }

    fn remove(&mut self, token: usize) {
        if let Some(Member { connection: Connection::Viewer(mut viewer), .. }) = self.members.remove(&token) {
            // A socket that is closed is deregistered by the system, too.
            let _ = self.poll.registry().deregister(viewer.stream());
        }
    }

    /// Lets a connection that is no WebSocket go on.
    fn advance(&mut self, token: usize, now: Instant) {
        let Some(member) = self.members.remove(&token) else { return };
        let since = member.since;
        let connection = match member.connection {
            Connection::Http(http, peer) => match http.advance(self.options.name.as_deref()) {
                Step::Waits(http) => Connection::Http(http, peer),
                Step::IsSocket(stream, part) => Connection::Viewer(Box::new(Viewer::new(stream, part, peer))),
                Step::Ended => return,
            },
            viewer => viewer,
        };
        let since = if matches!(connection, Connection::Viewer(_)) { now } else { since };
        self.members.insert(token, Member { connection, since });
    }

    /// Takes what the render thread has sent.
    fn take_updates(&mut self) {
        self.take_depths();
        let display = self.feed.display();
        let (listeners, title) = (display.has_listeners(), display.take_title());
        if let Some(title) = title {
            self.notify_all(&format!("title {title}"));
            self.title = Some(title);
        }
        if std::mem::replace(&mut self.listeners, listeners) != listeners {
            self.notify_all(&format!("listeners {}", u8::from(listeners)));
        }
    }

    fn viewers(&mut self) -> impl Iterator<Item = &mut Viewer> {
        self.members.values_mut().filter_map(|member| match &mut member.connection {
            Connection::Viewer(viewer) if viewer.rights.is_some() => Some(&mut **viewer),
            _ => None,
        })
    }

    fn notify_all(&mut self, text: &str) {
        self.viewers().for_each(|viewer| viewer.note(text.to_owned()));
    }

    /// Reads what viewers say, and sends them what is new.
    fn serve_viewers(&mut self, now: Instant) {
        let is_viewer =
            |(token, m): (&usize, &Member)| matches!(m.connection, Connection::Viewer(_)).then_some(*token);
        let tokens: Vec<usize> = self.members.iter().filter_map(is_viewer).collect();
        for token in &tokens {
            if self.read_requests(*token, now).is_err() {
                self.remove(*token);
            }
        }
        let feed = self.feed.clone();
        if self.viewers().any(|viewer| viewer.is_ready()) && self.frame.update(feed.display()) {
            self.release_tiles();
        }
        let mut is_ready = false;
        for token in tokens {
            let Some(Member { connection: Connection::Viewer(viewer), .. }) = self.members.get_mut(&token)
            else {
                continue;
            };
            if viewer.pump(now, &mut self.frame, self.stats.as_deref()).is_err() {
                self.remove(token);
                continue;
            }
            is_ready |= viewer.is_ready();
        }
        if is_ready && self.feed.request_frame() {
            self.wake_render_thread();
        }
    }

    /// Makes the render thread look at what it held back. A channel that is full wakes it as well.
    fn wake_render_thread(&self) {
        if let WebTarget::Thread { link, .. } = &self.target {
            let _ = link.messages.try_send(Message::Do(Box::new(|_| ())));
        }
    }

    /// Lets viewers give up old frames while these hold too many bytes.
    fn release_tiles(&mut self) {
        let most = HELD_BYTES
            + 4 * u64::from(self.feed.display().width()) * u64::from(self.feed.display().height()) * 4;
        while self.frame.live_bytes() > most {
            let newest = self.frame.version();
            let oldest = self
                .viewers()
                .filter(|v| v.sending().is_some_and(|s| s < newest))
                .min_by_key(|v| v.sending());
            match oldest {
                Some(viewer) => viewer.abandon(),
                None => return,
            }
        }
    }

    /// Ends what takes too long, and sends new values of the metrics.
    fn tick(&mut self, now: Instant) {
        let is_late = |member: &Member| !member.has_joined() && now > member.since + PATIENCE;
        let late: Vec<usize> =
            self.members.iter().filter(|(_, m)| is_late(m)).map(|(token, _)| *token).collect();
        late.into_iter().for_each(|token| self.remove(token));
        let mut silent = Vec::new();
        for (token, member) in &mut self.members {
            if let Connection::Viewer(viewer) = &mut member.connection
                && viewer.tick(now).is_err()
            {
                silent.push(*token);
            }
        }
        silent.into_iter().for_each(|token| self.remove(token));
        if now >= self.stats_at + STATS_EVERY
            && let Some(board) = &self.options.board
        {
            self.stats_at = now;
            if self.members.values().any(Member::has_joined) {
                self.stats = Some(board.json());
                self.viewers().for_each(|viewer| viewer.wants_stats = true);
            }
        }
    }
}

/// Lets the render thread go first where both want the processor.
fn lower_priority() {
    #[cfg(target_os = "linux")]
    {
        // The calling thread alone, on Linux. Without it the page takes its full share.
        let _ = rustix::process::setpriority_process(None, 10);
    }
}

//! A viewer: a WebSocket, what it has been sent and what it may do.
//!
//! In: messages of the page; the newest frame. Out: parts of frames, replies and other messages,
//! each when the one before it has left. Promises: a viewer has at most [`FRAMES_AHEAD`] frames that
//! its page has not acknowledged, then skips to the newest one; beside tiles, which are shared, it
//! holds a few messages of bounded size.

use super::commands::CommandLine;
use super::rights::Rights;
use super::tiles::{EncodedTile, TileFrame};
use super::turn::TurnStream;
use super::wire::{self, Request};
use mio::net::TcpStream;
use std::collections::VecDeque;
use std::io::ErrorKind;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

/// Most bytes of a message of the page: a block of commands that was pasted.
pub(super) const MAX_MESSAGE_BYTES: usize = 64 << 10;
/// Frames that the page has not acknowledged, at most.
const FRAMES_AHEAD: usize = 2;
/// Messages of a viewer that are read before others have their turn.
const MESSAGES_A_TURN: usize = 32;
/// Messages of a page in one second, at most; a pointer moves a few hundred times.
const MESSAGES_A_SECOND: u32 = 4000;
/// Bytes of a page in one second, at most: those of frames without a message count, too.
const BYTES_A_SECOND: usize = 8 << 20;
/// Small messages to a page that may be queued.
const MAX_NOTES: usize = 16;
/// Time without an acknowledgement, after which a viewer gives way to a new one where all places are
/// taken.
const BEHIND_AFTER: Duration = Duration::from_secs(5);
/// Time without any message, after which a page is asked for one, and after which it has gone.
const PING_AFTER: Duration = Duration::from_secs(20);
const GONE_AFTER: Duration = Duration::from_secs(60);
/// Time in which a message to the page must have left.
const SEND_WITHIN: Duration = Duration::from_secs(30);

/// A frame on its way.
#[derive(Debug)]
struct Sending {
    sequence: u64,
    frame: u64,
    tiles: Vec<(u32, Arc<EncodedTile>)>,
    next: usize,
}

/// A viewer's socket and its state.
pub(super) struct Viewer {
    socket: WebSocket<TurnStream>,
    pub peer: IpAddr,
    /// `None` until the page has sent its first message.
    pub rights: Option<Rights>,
    /// Version of the last frame that was sent whole.
    seen: u64,
    sending: Option<Sending>,
    /// Sequence numbers of frames that were sent and not acknowledged.
    unacknowledged: VecDeque<u64>,
    /// The time since which the first of them is waited for.
    waits_since: Instant,
    notes: VecDeque<Message>,
    pub commands: Option<CommandLine>,
    /// Bytes for the commands' connection that it has no room for; nothing is read meanwhile.
    pub stalled: Option<Vec<u8>>,
    /// The pixel whose depth the page asks for, and whether an answer is on its way.
    pub probe: Option<(u32, u32)>,
    pub is_probing: bool,
    /// Set once a second if there are new values of the metrics.
    pub wants_stats: bool,
    pub is_readable: bool,
    pub is_writable: bool,
    is_flushed: bool,
    flushed_at: Instant,
    heard_at: Instant,
    pinged_at: Instant,
    /// The running second, and the numbers of messages and bytes in it.
    second: (Instant, u32, usize),
}

/// The viewer has gone, or must go.
#[derive(Debug)]
pub(super) struct Disconnected;

impl Viewer {
    /// Begins the WebSocket on a stream whose handshake is done; `part` came behind it.
    pub fn new(stream: TcpStream, part: Vec<u8>, peer: IpAddr) -> Viewer {
        let config = WebSocketConfig::default()
            .read_buffer_size(4 << 10)
            .write_buffer_size(0)
            .max_write_buffer_size(4 << 20)
            .max_message_size(Some(MAX_MESSAGE_BYTES))
            .max_frame_size(Some(MAX_MESSAGE_BYTES));
        let now = Instant::now();
        Viewer {
            socket: WebSocket::from_partially_read(TurnStream::new(stream), part, Role::Server, Some(config)),
            peer,
            rights: None,
            seen: 0,
            sending: None,
            unacknowledged: VecDeque::new(),
            waits_since: now,
            notes: VecDeque::new(),
            commands: None,
            stalled: None,
            probe: None,
            is_probing: false,
            wants_stats: true,
            is_readable: true,
            is_writable: true,
            is_flushed: true,
            flushed_at: now,
            heard_at: now,
            pinged_at: now,
            second: (now, 0, 0),
        }
    }

    /// Reads the messages that have arrived, a limited number of them.
    ///
    /// # Errors
    /// If the page has gone, or sent what no page sends.
    pub fn read(&mut self, now: Instant) -> Result<Vec<Request>, Disconnected> {
        let mut requests = Vec::new();
        if now >= self.second.0 + Duration::from_secs(1) {
            self.second = (now, 0, 0);
        }
        self.socket.get_mut().begin_turn();
        while requests.len() < MESSAGES_A_TURN && self.is_readable && self.stalled.is_none() {
            let message = match self.socket.read() {
                Ok(message) => message,
                Err(Error::Io(e)) if e.kind() == ErrorKind::WouldBlock => {
                    // More is there if the turn's bytes are all that ended.
                    self.is_readable = self.socket.get_ref().is_spent();
                    break;
                }
                Err(Error::Io(e)) if e.kind() == ErrorKind::Interrupted => continue,
                Err(_) => return Err(Disconnected),
            };
            self.heard_at = now;
            self.second.1 += 1;
            if self.second.1 > MESSAGES_A_SECOND {
                return Err(Disconnected);
            }
            match message {
                Message::Text(text) => {
                    let request = wire::parse(&text).ok_or(Disconnected)?;
                    // What stalls must be the last.
                    let is_line = matches!(request, Request::Line(_));
                    requests.push(request);
                    if is_line {
                        break;
                    }
                }
                // Answers to pings are queued by the library.
                Message::Ping(_) => self.is_flushed = false,
                Message::Pong(_) => {}
                Message::Binary(_) | Message::Close(_) | Message::Frame(_) => return Err(Disconnected),
            }
        }
        self.second.2 += self.socket.get_ref().bytes_read();
        if self.second.2 > BYTES_A_SECOND { Err(Disconnected) } else { Ok(requests) }
    }

    /// Queues a small message. Drops it if the page does not read.
    pub fn note(&mut self, text: String) {
        if self.notes.len() < MAX_NOTES {
            self.notes.push_back(Message::text(text));
        }
    }

    /// Notes that the page shows a frame.
    pub fn acknowledge(&mut self, sequence: u64, now: Instant) {
        while self.unacknowledged.front().is_some_and(|first| *first <= sequence) {
            self.unacknowledged.pop_front();
            self.waits_since = now;
        }
    }

    /// Returns whether it can be sent another frame than that of `version`.
    pub fn is_ready(&self) -> bool {
        self.rights.is_some() && self.sending.is_none() && self.unacknowledged.len() < FRAMES_AHEAD
    }

    /// Returns whether its page has shown nothing new for long, though there is something.
    pub fn is_behind(&self, now: Instant) -> bool {
        !self.unacknowledged.is_empty() && now > self.waits_since + BEHIND_AFTER
    }

    /// Returns the sequence number of the frame that is on its way, if any.
    pub fn sending(&self) -> Option<u64> {
        self.sending.as_ref().map(|sending| sending.sequence)
    }

    /// Gives up the frame that is on its way: its tiles are not held any longer, and the page gets
    /// the newest frame instead.
    pub fn abandon(&mut self) {
        if let Some(sending) = self.sending.take() {
            // Tiles that have left are not on the canvas: the page drops those of an unfinished frame,
            // and `seen` is still the frame before it.
            self.unacknowledged.retain(|sequence| *sequence != sending.sequence);
        }
    }

    /// Sends as much as the socket takes.
    ///
    /// # Errors
    /// If the page has gone.
    pub fn pump(
        &mut self,
        now: Instant,
        frame: &mut TileFrame,
        stats: Option<&str>,
    ) -> Result<(), Disconnected> {
        while self.is_writable {
            if !self.is_flushed {
                match self.socket.flush() {
                    Ok(()) => (self.is_flushed, self.flushed_at) = (true, now),
                    Err(Error::Io(e)) if e.kind() == ErrorKind::WouldBlock => {
                        self.is_writable = false;
                        return Ok(());
                    }
                    Err(_) => return Err(Disconnected),
                }
            }
            let Some(message) = self.next_message(now, frame, stats) else { return Ok(()) };
            (self.is_flushed, self.flushed_at) = (false, now);
            match self.socket.write(message) {
                Ok(()) => {}
                Err(Error::Io(e)) if e.kind() == ErrorKind::WouldBlock => self.is_writable = false,
                Err(_) => return Err(Disconnected),
            }
        }
        Ok(())
    }

    fn next_message(&mut self, now: Instant, frame: &mut TileFrame, stats: Option<&str>) -> Option<Message> {
        if let Some(note) = self.notes.pop_front() {
            return Some(note);
        }
        if let Some(commands) = &self.commands {
            match commands.reply() {
                Ok(Some(chunk)) => {
                    let mut message = vec![2];
                    message.extend(chunk);
                    return Some(Message::binary(message));
                }
                Ok(None) => {}
                Err(()) => {
                    (self.commands, self.stalled) = (None, None);
                    return Some(Message::text("ended"));
                }
            }
        }
        if let Some(stats) = stats.filter(|_| self.rights.is_some() && self.wants_stats) {
            self.wants_stats = false;
            return Some(Message::text(format!("stats {stats}")));
        }
        if self.is_ready() && self.seen < frame.version() {
            let tiles = frame.since(self.seen);
            let sequence = frame.version();
            self.sending = Some(Sending { sequence, frame: frame.frame(), tiles, next: 0 });
            if self.unacknowledged.is_empty() {
                self.waits_since = now;
            }
            self.unacknowledged.push_back(sequence);
        }
        let sending = self.sending.as_mut()?;
        let message = wire::tiles_message(sending.sequence, sending.frame, &sending.tiles, &mut sending.next);
        if sending.next == sending.tiles.len() {
            self.seen = sending.sequence;
            self.sending = None;
        }
        Some(Message::binary(message))
    }

    /// Does what is due: asks a silent page for a sign of life.
    ///
    /// # Errors
    /// If the page has been silent, or has not read, for too long.
    pub fn tick(&mut self, now: Instant) -> Result<(), Disconnected> {
        if now > self.heard_at + GONE_AFTER || (!self.is_flushed && now > self.flushed_at + SEND_WITHIN) {
            return Err(Disconnected);
        }
        if now > self.heard_at + PING_AFTER && now > self.pinged_at + PING_AFTER {
            self.pinged_at = now;
            self.notes.push_back(Message::Ping(Vec::new().into()));
        }
        Ok(())
    }

    /// Says goodbye with a reason, as far as the socket takes it at once.
    pub fn close(&mut self, reason: &'static str) {
        use tungstenite::protocol::{CloseFrame, frame::coding::CloseCode};
        let _ = self.socket.close(Some(CloseFrame { code: CloseCode::Policy, reason: reason.into() }));
        let _ = self.socket.flush();
    }

    /// Returns the socket, to be registered and deregistered.
    pub fn stream(&mut self) -> &mut TcpStream {
        self.socket.get_mut().stream()
    }
}

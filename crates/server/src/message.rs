//! Messages to the render thread, and the inbox of in-process clients.
//!
//! In: connections, bytes, typed commands and finished jobs, from any thread. Out: what the
//! scheduler receives. Promises: an in-process client is at most 16,384 commands ahead; its errors
//! and events are stored up to a limit.

use super::buffer_pool::PooledBuffer;
use super::reply_queue::ReplyQueue;
use crossbeam_channel::Sender;
use fbptr_command::{Command, EndOfInput, LentPayload};
use fbptr_core::error::Fault;
use fbptr_core::input::InputEvent;
use fbptr_engine::engine::{Engine, JobResult};
use fbptr_engine::session::Audience;
use fbptr_engine::stream::{CommandError, Notice};
use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Number of a connection.
pub(crate) type Id = u64;

/// Bytes of a connection: the first `filled` bytes of the pooled buffer if there is one, otherwise
/// of `buffer`.
#[derive(Debug)]
pub(crate) struct Batch {
    pub buffer: Vec<u8>,
    pub pooled: Option<PooledBuffer>,
    pub filled: usize,
}

impl Batch {
    /// Returns the bytes that were read.
    pub fn bytes(&self) -> &[u8] {
        &self.pooled.as_ref().map_or(&self.buffer, |l| &l.buffer)[..self.filled]
    }

    /// Returns the pooled buffer to its pool; the bytes from offset `at` on are copied to `buffer`.
    pub fn unpool_from(&mut self, at: usize) {
        if let Some(pooled) = self.pooled.take() {
            self.buffer = pooled.buffer[at..self.filled].to_vec();
            self.filled -= at;
        }
    }
}

/// Condition on which the render thread ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finish {
    /// When every connection has ended and all its commands have run.
    WhenAllEnded,
    /// When everything received has run and its replies are sent, and at this time at the latest; a
    /// command that is still running then is abandoned.
    By(Instant),
    /// At once; a running command is abandoned.
    Now,
}

/// Kind of a connection's transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Medium {
    /// A client in this process.
    InProcess,
    /// A file, or a pair of pipes.
    Pipe,
    /// A Unix socket.
    UnixSocket,
    /// A TCP socket.
    TcpSocket,
}

impl Medium {
    /// Returns whether the client is another program on a socket.
    pub fn is_socket(self) -> bool {
        matches!(self, Medium::UnixSocket | Medium::TcpSocket)
    }
}

/// A message to the render thread. Those of one connection keep their order; those of different
/// connections are in order of sending.
pub(crate) enum Message {
    /// A connection was opened.
    Open(Id, Box<OpenConnection>),
    /// Bytes of a connection.
    Bytes(Id, Batch),
    /// A payload that was lent, with all bytes that its input has.
    Payload(Id, LentPayload),
    /// The end of a connection's input.
    End(Id, EndOfInput),
    /// The connection's inbox has typed commands.
    Mail(Id),
    /// The connection's client has read replies: there is room for more.
    Room(Id),
    /// A worker has finished a connection's job: the ticket's number and the result.
    JobDone(Id, u64, Box<JobResult>),
    /// An event of a user in a browser, for the clients that listen.
    #[cfg(feature = "web")]
    Event(InputEvent),
    /// A function to run between two slices.
    Do(Box<dyn FnOnce(&mut Engine) + Send>),
    /// The window could not be opened: the server runs without it.
    NoDisplay,
    /// The render thread is to end.
    Finish(Finish),
}

impl fmt::Debug for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Message::Open(id, _) => write!(f, "Open({id})"),
            Message::Bytes(id, batch) => write!(f, "Bytes({id}, {})", batch.filled),
            Message::Payload(id, payload) => write!(f, "Payload({id}, {} missing)", payload.missing()),
            Message::End(id, end) => write!(f, "End({id}, {end:?})"),
            Message::Mail(id) => write!(f, "Mail({id})"),
            Message::Room(id) => write!(f, "Room({id})"),
            Message::JobDone(id, number, result) => write!(f, "JobDone({id}, {number}, {result:?})"),
            #[cfg(feature = "web")]
            Message::Event(event) => write!(f, "Event({event})"),
            Message::Do(_) => write!(f, "Do"),
            Message::NoDisplay => write!(f, "NoDisplay"),
            Message::Finish(how) => write!(f, "Finish({how:?})"),
        }
    }
}

/// A new connection: its source, its audience and its callbacks.
pub(crate) struct OpenConnection {
    pub audience: Audience,
    pub medium: Medium,
    /// Set if its bytes may be a recording.
    pub may_replay: bool,
    pub source: ConnectionSource,
    /// Called with each refusal and warning, if the audience is the owner.
    pub on_notice: Option<Box<dyn FnMut(Notice) + Send>>,
    /// Called when the connection's last command has run.
    pub on_end: Option<Box<dyn FnOnce() + Send>>,
}

/// Source of a connection's commands, and destination of its replies.
pub(crate) enum ConnectionSource {
    /// A stream of bytes.
    Stream { recycle: Box<dyn Release>, reply_queue: Arc<ReplyQueue>, port: Box<dyn Port> },
    /// An in-process client.
    Inbox(Arc<Inbox>),
}

/// Receiver of a connection's finished batches. Dropping it ends the connection.
pub(crate) trait Release: Send {
    /// Returns a batch, or what was read into a payload if it is `None`. `payload_left` is the number of
    /// bytes that the connection's current payload still lacks; if the transport reads large payloads
    /// itself, and nothing of this one is on its way, it asks `lend` for it.
    fn put(&self, batch: Option<Batch>, payload_left: usize, lend: &mut dyn FnMut() -> Option<LentPayload>);
}

/// The render thread's handle on a transport.
pub(crate) trait Port: Send {
    /// Starts the writer's thread over `reply_queue`; called once, with the first reply that cannot
    /// be sent at once.
    fn start_writer(&mut self, reply_queue: Arc<ReplyQueue>, limit: usize, on_room: Box<dyn Fn() + Send>);
    /// Sends as much of a short reply as can be sent without blocking, while no writer has work.
    /// Returns the number of bytes.
    fn send_now(&mut self, bytes: &[u8]) -> usize;
    /// Ends the sending side if no writer was started: no reply is queued, and none will be.
    fn end_without_writer(&mut self, reply_queue: &ReplyQueue);
    /// Stops reading after the bytes that have arrived. Returns whether the transport can do that.
    fn stop_reading(&mut self) -> bool;
    /// Ends the transport at once.
    fn abort(&mut self);
    /// Returns whether the transport's threads have ended.
    fn is_gone(&self) -> bool;
}

/// An item of an in-process client's inbox.
pub(crate) enum Item {
    /// A command to run.
    Command(Command),
    /// A command whose reply, or fault, is sent back.
    Ask(Command, Sender<Result<Vec<u8>, Fault>>),
    /// A function that reads the engine after all earlier items have run.
    Look(Box<dyn FnOnce(&Engine) + Send>),
}

impl Item {
    /// Returns whether the item changes nothing, so that it may run while other commands wait.
    pub fn only_asks(&self) -> bool {
        match self {
            Item::Command(command) | Item::Ask(command, _) => command.only_asks(),
            Item::Look(_) => true,
        }
    }
}

/// Queue of an in-process client's items that the render thread has not taken, and the errors and
/// events for the client.
#[derive(Default)]
pub(crate) struct Inbox {
    state: Mutex<Mail>,
    taken: Condvar,
}

#[derive(Default)]
struct Mail {
    items: Vec<Item>,
    is_closed: bool,
    errors: Vec<CommandError>,
    events: Vec<InputEvent>,
}

/// Number of queued commands at which a client blocks.
const MAX_AHEAD: usize = 1 << 14;

/// Number of stored events; later ones are dropped until the client takes them.
const MAX_EVENTS: usize = 4096;

/// Number of stored errors; later ones are only counted in STATS.
const MAX_ERRORS: usize = 1000;

impl Inbox {
    fn lock(&self) -> MutexGuard<'_, Mail> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an item, and blocks while the queue is full. Returns whether the queue was empty
    /// before, or `None` if the inbox is closed.
    pub fn put(&self, item: Item) -> Option<bool> {
        let mut mail = self.lock();
        while mail.items.len() >= MAX_AHEAD && !mail.is_closed {
            mail = self.taken.wait(mail).unwrap_or_else(PoisonError::into_inner);
        }
        if mail.is_closed {
            return None;
        }
        mail.items.push(item);
        Some(mail.items.len() == 1)
    }

    /// Swaps the queued items with `into`, which is empty.
    pub fn take(&self, into: &mut Vec<Item>) {
        let mut mail = self.lock();
        std::mem::swap(&mut mail.items, into);
        drop(mail);
        self.taken.notify_all();
    }

    /// Closes the inbox: drops the queued items and unblocks all callers of [`Inbox::put`].
    pub fn close(&self) {
        let mut mail = self.lock();
        mail.is_closed = true;
        // A client that waits for an answer sees its channel disconnected.
        mail.items.clear();
        drop(mail);
        self.taken.notify_all();
    }

    /// Stores an error for the client.
    pub fn push_error(&self, refused: CommandError) {
        let mut mail = self.lock();
        if mail.errors.len() < MAX_ERRORS {
            mail.errors.push(refused);
        }
    }

    /// Stores an event of the window for the client.
    pub fn push_event(&self, event: &InputEvent) {
        let mut mail = self.lock();
        if mail.events.len() < MAX_EVENTS {
            mail.events.push(event.clone());
        }
    }

    /// Takes the events since the last call.
    pub fn events(&self) -> Vec<InputEvent> {
        std::mem::take(&mut self.lock().events)
    }

    /// Takes the errors since the last call.
    pub fn errors(&self) -> Vec<CommandError> {
        std::mem::take(&mut self.lock().errors)
    }
}

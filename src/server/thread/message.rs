//! What travels to the render thread.

use super::super::jobs::JobResult;
use super::super::reply_queue::ReplyQueue;
use super::super::transport::{Medium, PooledBuffer, Recycle};
use super::super::{Audience, CommandError, InputEvent, Notice};
use crate::command::{Command, EndOfInput};
use crate::error::Fault;
use crate::server::Engine;
use crossbeam_channel::Sender;
use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// A connection's number.
pub(crate) type Id = u64;

/// Bytes of a connection: the first `filled` of the pooled buffer, or of its own, which goes back
/// to its reader.
#[derive(Debug)]
pub(crate) struct Batch {
    pub buffer: Vec<u8>,
    pub pooled: Option<PooledBuffer>,
    pub filled: usize,
}

impl Batch {
    /// What was read.
    pub fn bytes(&self) -> &[u8] {
        &self.pooled.as_ref().map_or(&self.buffer, |l| &l.buffer)[..self.filled]
    }

    /// Gives the pooled buffer back; what stands from `at` on is kept in the own buffer.
    pub fn unpool_from(&mut self, at: usize) {
        if let Some(pooled) = self.pooled.take() {
            self.buffer = pooled.buffer[at..self.filled].to_vec();
            self.filled -= at;
        }
    }
}

/// One message. Bytes of a connection come in order; messages of different connections in the order of sending.
pub(crate) enum Message {
    /// A connection begins.
    Open(Id, Box<OpenConnection>),
    /// Bytes that it sent.
    Bytes(Id, Batch),
    /// It sends no more.
    End(Id, EndOfInput),
    /// Its typed commands wait in its inbox.
    Mail(Id),
    /// Its client has read: there is room for replies.
    Room(Id),
    /// A worker has done a job of a connection: its ticket's number, and what came of it.
    JobDone(Id, u64, Box<JobResult>),
    /// Something to do between two slices of work.
    Do(Box<dyn FnOnce(&mut Engine) + Send>),
    /// The window could not be had: go on without.
    NoDisplay,
    /// Finish what was received, then end.
    Finish(super::Finish),
}

impl fmt::Debug for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Message::Open(id, _) => write!(f, "Open({id})"),
            Message::Bytes(id, batch) => write!(f, "Bytes({id}, {})", batch.filled),
            Message::End(id, end) => write!(f, "End({id}, {end:?})"),
            Message::Mail(id) => write!(f, "Mail({id})"),
            Message::Room(id) => write!(f, "Room({id})"),
            Message::JobDone(id, number, result) => write!(f, "JobDone({id}, {number}, {result:?})"),
            Message::Do(_) => write!(f, "Do"),
            Message::NoDisplay => write!(f, "NoDisplay"),
            Message::Finish(how) => write!(f, "Finish({how:?})"),
        }
    }
}

/// What a new connection brings.
pub(crate) struct OpenConnection {
    pub audience: Audience,
    pub medium: Medium,
    /// Whether its bytes may be a recording.
    pub may_replay: bool,
    pub source: ConnectionSource,
    /// Called with each refusal and warning, where the audience is the owner.
    pub on_notice: Option<Box<dyn FnMut(Notice) + Send>>,
    /// Called when the connection's last command has run.
    pub on_end: Option<Box<dyn FnOnce() + Send>>,
}

/// Where a connection's commands come from, and where its replies go.
pub(crate) enum ConnectionSource {
    /// A stream of bytes.
    Stream { recycle: Recycle, reply_queue: Arc<ReplyQueue>, port: Box<dyn Port> },
    /// An in-process client.
    Inbox(Arc<Inbox>),
}

/// The render thread's hold on a transport.
pub(crate) trait Port: Send {
    /// Starts the writer's thread over `reply_queue`; called once, with the first reply that cannot
    /// be sent at once.
    fn start_writer(&mut self, reply_queue: Arc<ReplyQueue>, limit: usize, on_room: Box<dyn Fn() + Send>);
    /// Sends as much of a short reply as can be sent without waiting, before any writer has work; how much that was.
    fn send_now(&mut self, bytes: &[u8]) -> usize;
    /// No reply waits for a writer, and none will.
    fn end_without_writer(&mut self, reply_queue: &ReplyQueue);
    /// Ends the transport's reading: what has arrived is still read. Whether that can be done.
    fn stop_reading(&mut self) -> bool;
    /// Ends the transport at once.
    fn abort(&mut self);
    /// Whether the transport's threads have ended.
    fn is_gone(&self) -> bool;
}

/// One thing that an in-process client asks for.
pub(crate) enum Item {
    /// Run it.
    Command(Command),
    /// Run it and answer with its reply.
    Ask(Command, Sender<Result<Vec<u8>, Fault>>),
    /// Look at the engine, after everything before.
    Look(Box<dyn FnOnce(&Engine) + Send>),
}

impl Item {
    /// Whether it changes nothing: it is run while others wait.
    pub fn only_asks(&self) -> bool {
        match self {
            Item::Command(command) | Item::Ask(command, _) => command.only_asks(),
            Item::Look(_) => true,
        }
    }
}

/// What in-process clients have sent and the render thread has not taken.
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

/// A client that is further ahead than this many commands waits.
const MAX_AHEAD: usize = 1 << 14;

/// Events that a client does not take beyond this many are missed.
const MAX_EVENTS: usize = 4096;

/// Errors beyond this many are counted in STATS alone.
const MAX_ERRORS: usize = 1000;

impl Inbox {
    fn lock(&self) -> MutexGuard<'_, Mail> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an item; whether it is the first that waits. `None` when nobody will take it.
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

    /// Takes all items, in exchange for an empty list.
    pub fn take(&self, into: &mut Vec<Item>) {
        let mut mail = self.lock();
        std::mem::swap(&mut mail.items, into);
        drop(mail);
        self.taken.notify_all();
    }

    /// Nobody takes items any more.
    pub fn close(&self) {
        let mut mail = self.lock();
        mail.is_closed = true;
        // Those who wait for an answer see their channel end.
        mail.items.clear();
        drop(mail);
        self.taken.notify_all();
    }

    /// Keeps an error for the client.
    pub fn push_error(&self, refused: CommandError) {
        let mut mail = self.lock();
        if mail.errors.len() < MAX_ERRORS {
            mail.errors.push(refused);
        }
    }

    /// Keeps an event of the window for the client.
    pub fn push_event(&self, event: &InputEvent) {
        let mut mail = self.lock();
        if mail.events.len() < MAX_EVENTS {
            mail.events.push(event.clone());
        }
    }

    /// The events since the last call.
    pub fn events(&self) -> Vec<InputEvent> {
        std::mem::take(&mut self.lock().events)
    }

    /// The errors since the last call.
    pub fn errors(&self) -> Vec<CommandError> {
        std::mem::take(&mut self.lock().errors)
    }
}

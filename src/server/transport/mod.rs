//! TRANSPORTS: bytes from files, pipes and sockets to the render thread, and replies back.
//!
//! All sockets are read by one thread or by the render thread itself (`poll.rs`), files, pipes and, where there is no epoll,
//! sockets by a thread each that blocks in `read`; each connection has one writer thread that is started with the first
//! reply. A reader of one owns [`BUFFERS`] buffers that travel to the render thread and back: when it has none left it waits,
//! the system's socket buffer fills, and the sender is held back. Nothing here looks at the bytes.

mod admission;
mod descriptors;
#[cfg(target_os = "linux")]
mod flow;
#[cfg_attr(not(target_os = "linux"), path = "no_hand.rs")]
mod hand;
mod lease;
mod listen;
#[cfg(target_os = "linux")]
mod poll;
#[cfg(target_os = "linux")]
mod ready;
mod refuse;
mod report;
mod socket;
#[cfg(unix)]
mod unix;

pub use admission::RefusedConnections;
pub(crate) use admission::{Admission, Refusal, Slot};
pub(crate) use descriptors::make_room;
pub(crate) use hand::{Hand, Next};
pub(crate) use lease::{Buffers, LEASE_BYTES, Lease};
pub use listen::{ListenError, Listener, Place as ListenPlace};
#[cfg(target_os = "linux")]
pub(crate) use poll::Poller;
pub(crate) use refuse::LINGERING;
pub(crate) use socket::{SharedSocket, Socket, Stream};

use super::outbox::Outbox;
use super::thread::Link;
use super::thread::message::{Batch, Message, Opening, Port, Source};
use super::{Audience, Notice};
use crate::command::EndOfInput;
use crossbeam_channel::bounded;
use report::{Trouble, report};
use std::io::{self, ErrorKind, Read, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;

/// Buffers of one reader.
const BUFFERS: usize = 3;
/// The size that a reader's buffers begin with, and the one they may grow to when reads fill them.
const SMALL_BYTES: usize = 4 << 10;
const LARGE_BYTES: usize = 256 << 10;
/// Readers and writers call little.
const STACK_BYTES: usize = 128 << 10;

/// The ends of a transport that can be closed from outside. Files and pipes cannot.
pub(crate) trait Control: Send + Sync {
    /// Sends as much as can be sent without waiting; how much that was. Nothing else is being written.
    fn send_now(&self, _bytes: &[u8]) -> usize {
        0
    }
    /// No more is read than has arrived; whether that can be done.
    fn stop_reading(&self) -> bool {
        false
    }
    /// All replies are written.
    fn finish_writing(&self) {}
    /// Everything ends now.
    fn abort(&self) {}
}

/// A transport that nobody can close.
pub(crate) struct Uncontrolled;

impl Control for Uncontrolled {}

/// How a connection's client reaches the server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Medium {
    /// It is part of this process.
    InProcess,
    /// A file, or a pair of pipes.
    Pipe,
    /// A Unix socket.
    UnixSocket,
    /// A TCP socket.
    TcpSocket,
}

impl Medium {
    /// Whether the other side is another program at a socket.
    pub fn is_socket(self) -> bool {
        matches!(self, Medium::UnixSocket | Medium::TcpSocket)
    }
}

/// What is read.
pub(crate) enum Input {
    /// A file or a pipe, by a thread of its own.
    Alone(Box<dyn Read + Send>),
    /// A socket; all of them are read by one thread, where the system has the means.
    Socket(Arc<Socket>),
}

/// One end of a conversation: what to read, where to write, and who hears of what.
pub(crate) struct Conversation {
    pub input: Input,
    pub output: Box<dyn Write + Send>,
    pub control: Arc<dyn Control>,
    /// What the end of the input means for a last line without LF.
    pub end: EndOfInput,
    pub audience: Audience,
    pub medium: Medium,
    /// Whether the bytes may be a recording. The first read must give enough of them to tell.
    pub may_replay: bool,
    pub on_notice: Option<Box<dyn FnMut(Notice) + Send>>,
    pub on_end: Option<Box<dyn FnOnce() + Send>>,
}

/// Held by those who read and write: when only the render thread has it left, both have ended.
pub(crate) type Life = Arc<()>;

/// Begins a conversation with the render thread.
///
/// # Errors
/// When the system has no thread to give; nothing has begun then.
pub(crate) fn converse(link: &Link, conversation: Conversation) -> io::Result<()> {
    let Conversation { input, output, control, end, audience, medium, may_replay, on_notice, on_end } =
        conversation;
    let id = link.new_id();
    let life = Life::default();
    let port = StreamPort { writer: Some(output), control, life: life.clone(), id };
    let messages = link.messages.clone();
    let open = |recycle| {
        let source = Source::Stream { recycle, outbox: Arc::new(Outbox::default()), port: Box::new(port) };
        Message::Open(id, Box::new(Opening { audience, medium, may_replay, source, on_notice, on_end }))
    };
    let input = match input {
        Input::Alone(input) => input,
        #[cfg(target_os = "linux")]
        Input::Socket(socket) => {
            let back = link.poller.prepare(id, socket, end, messages.clone())?;
            // A render thread that is gone opens no more.
            if messages.send(open(Recycle::Polled(back.share()))).is_ok() {
                back.begin(life);
            }
            return Ok(());
        }
        #[cfg(not(target_os = "linux"))]
        Input::Socket(socket) => Box::new(SharedSocket(socket)),
    };
    let buffers = Arc::new(Pool::new());
    let opening = open(Recycle::Own(buffers.clone()));
    let (begin, begins) = bounded(1);
    let reader_messages = messages.clone();
    let read = move || {
        let _life = life;
        if begins.recv().is_ok() {
            read_all(input, &buffers, end, |message| reader_messages.send(message(id)).is_ok());
        }
    };
    Builder::new().name(format!("read {id}")).stack_size(STACK_BYTES).spawn(read)?;
    // By the caller: a render thread that is told to end after this knows of the connection.
    if messages.send(opening).is_ok() {
        let _ = begin.send(());
    }
    Ok(())
}

/// The buffers of one reader that are not on their way. Waiting is left to the system at once: where many readers wait,
/// each look whether there is one now takes the processor from those who could make one free.
pub(crate) struct Pool {
    /// `None` when the connection is over.
    free: Mutex<Option<Vec<Vec<u8>>>>,
    changed: Condvar,
}

impl Pool {
    fn new() -> Self {
        Pool { free: Mutex::new(Some(vec![Vec::new(); BUFFERS])), changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, Option<Vec<Vec<u8>>>> {
        // Buffers are as good after a panic as before.
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a buffer; `None` when the connection is over.
    fn take(&self) -> Option<Vec<u8>> {
        let mut free = self.lock();
        loop {
            match free.as_mut()?.pop() {
                Some(buffer) => return Some(buffer),
                None => free = self.changed.wait(free).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }
}

/// Where a connection's buffers are given back. Its reading ends when this is dropped.
pub(crate) enum Recycle {
    /// To a reader of its own.
    Own(Arc<Pool>),
    /// To the thread that reads all sockets.
    #[cfg(target_os = "linux")]
    Polled(poll::Return),
}

impl Recycle {
    /// Gives a batch back, after which the connection's payload waits for so many bytes.
    pub fn put(&self, batch: Batch, wanted: usize) {
        match self {
            Recycle::Own(pool) => {
                // Each has a reader of its own: none goes first.
                let _ = wanted;
                if let Some(free) = pool.lock().as_mut() {
                    free.push(batch.buffer);
                }
                pool.changed.notify_one();
            }
            #[cfg(target_os = "linux")]
            Recycle::Polled(back) => {
                drop(batch);
                back.put(wanted);
            }
        }
    }
}

impl Drop for Recycle {
    fn drop(&mut self) {
        match self {
            Recycle::Own(pool) => {
                *pool.lock() = None;
                pool.changed.notify_one();
            }
            #[cfg(target_os = "linux")]
            Recycle::Polled(back) => back.is_over(),
        }
    }
}

/// A message, once it is known whose.
type Unaddressed = Box<dyn FnOnce(u64) -> Message>;

/// Reads to the end, in buffers that grow where reads fill them.
fn read_all(
    mut input: Box<dyn Read + Send>,
    buffers: &Pool,
    end: EndOfInput,
    send: impl Fn(Unaddressed) -> bool,
) {
    let mut size = SMALL_BYTES;
    // Ends when the render thread wants no more.
    while let Some(mut buffer) = buffers.take() {
        if buffer.capacity() > 2 * size {
            buffer = Vec::new();
        }
        buffer.resize(size, 0);
        let filled = match read_some(&mut *input, &mut buffer) {
            // A connection that died says no more than one that was closed: what came before still counts.
            Ok(0) | Err(_) => {
                send(Box::new(move |id| Message::End(id, end)));
                return;
            }
            Ok(filled) => filled,
        };
        size = match () {
            () if filled == size => (size * 8).min(LARGE_BYTES),
            () if filled < size / 32 => (size / 8).max(SMALL_BYTES),
            () => size,
        };
        if !send(Box::new(move |id| Message::Bytes(id, Batch { buffer, lease: None, filled }))) {
            return;
        }
    }
    // It is over, and its last replies are on their way: a socket that is closed with bytes unread would take them along.
    let mut rest = [0; 1024];
    while matches!(read_some(&mut *input, &mut rest), Ok(n) if n > 0) {}
}

fn read_some(input: &mut dyn Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match input.read(buffer) {
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            result => return result,
        }
    }
}

/// The render thread's hold on a conversation.
struct StreamPort {
    writer: Option<Box<dyn Write + Send>>,
    control: Arc<dyn Control>,
    /// Held by the reader and the writer too.
    life: Life,
    id: u64,
}

impl Port for StreamPort {
    fn start_writer(&mut self, outbox: Arc<Outbox>, limit: usize, on_room: Box<dyn Fn() + Send>) {
        let Some(mut writer) = self.writer.take() else { return };
        let (control, life, for_writer) = (self.control.clone(), self.life.clone(), outbox.clone());
        let write = move || {
            let _life = life;
            // A client that reads no more has heard enough.
            let _ = for_writer.write_all_to(&mut *writer, limit, on_room);
            drop(writer);
            control.finish_writing();
            for_writer.set_done();
        };
        let name = format!("write {}", self.id);
        if let Err(e) = Builder::new().name(name).stack_size(STACK_BYTES).spawn(write) {
            report(Trouble::Threads, format_args!("ended a connection: no thread to send replies: {e}"));
            // It cannot be answered.
            outbox.set_done();
            self.control.abort();
        }
    }

    fn send_now(&mut self, bytes: &[u8]) -> usize {
        self.control.send_now(bytes)
    }

    fn end_without_writer(&mut self, outbox: &Outbox) {
        self.writer = None;
        self.control.finish_writing();
        outbox.set_done();
    }

    fn stop_reading(&mut self) -> bool {
        self.control.stop_reading()
    }

    fn abort(&mut self) {
        self.control.abort();
    }

    fn is_gone(&self) -> bool {
        Arc::strong_count(&self.life) == 1
    }
}

//! Transports: carry bytes from files, pipes and sockets to the render thread, and replies back.
//!
//! All sockets are read by one thread or by the render thread itself (`poll.rs`), files and pipes
//! by a thread each that blocks in `read` (`pipe.rs`); both fill the same small pool of buffers
//! (`buffer_pool.rs`) within the same limits (`backpressure.rs`): a connection that has enough
//! batches in flight is not read, the system's buffer fills, and the sender is slowed down. Each
//! connection has one writer thread, which is started with the first reply that cannot be sent at
//! once. The transports do not look at the bytes.

mod backpressure;
mod descriptors;
mod inline_reader;
mod large_payloads;
mod listen;
mod pipe;
mod poll;
mod ready_queue;
mod refuse;
mod report;
mod selector;
mod socket;
#[cfg(unix)]
mod unix;

pub(crate) use descriptors::make_room;
pub(crate) use inline_reader::{InlineReader, Next};
pub use listen::{ListenAddress, ListenError, Listener};
pub(crate) use poll::Poller;
pub(crate) use refuse::LINGERING;
pub(crate) use socket::{Replies, Socket, Stream};

use super::message::{Batch, ConnectionSource, Id, Medium, Message, OpenConnection, Port, Release};
use super::reply_queue::ReplyQueue;
use crossbeam_channel::{Sender, bounded};
use fbptr_command::{EndOfInput, LentPayload};
use fbptr_engine::session::Audience;
use fbptr_engine::stream::Notice;
use report::{Trouble, report};
use std::io::{self, Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::Builder;

/// Stack size of readers and writers, which need little.
const STACK_BYTES: usize = 128 << 10;

/// Operations on a transport from another thread than the one that reads it. Files and pipes have
/// none.
pub(crate) trait Control: Send + Sync {
    /// Sends as much as can be sent without waiting, and returns the number of bytes. Called only
    /// while no other write is going on.
    fn send_now(&self, _bytes: &[u8]) -> usize {
        0
    }
    /// Ends reading after the bytes that have arrived. Returns whether the transport can do that.
    fn stop_reading(&self) -> bool {
        false
    }
    /// Ends writing, after all replies are written.
    fn finish_writing(&self) {}
    /// Closes both directions at once.
    fn abort(&self) {}
}

/// The control of a file or pipe, which cannot be closed by another thread.
pub(crate) struct Uncontrolled;

impl Control for Uncontrolled {}

/// The transports' access to the render thread: its channel and the counter of connection numbers.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    pub messages: Sender<Message>,
    pub poller: Arc<Poller>,
    pub next_id: Arc<AtomicU64>,
}

impl Link {
    /// Returns a number that no other connection has.
    pub fn new_id(&self) -> Id {
        self.next_id.fetch_add(1, Ordering::Relaxed)
    }
}

/// Source of a connection's bytes.
pub(crate) enum ByteSource {
    /// A file or a pipe, which has a thread of its own.
    Alone(Box<dyn Read + Send>),
    /// A socket that the poller has adopted.
    Socket(Arc<Socket>),
}

/// The ends of a connection: the source of bytes, the sink of replies, and callbacks.
pub(crate) struct Endpoint {
    pub input: ByteSource,
    pub output: Box<dyn Write + Send>,
    pub control: Arc<dyn Control>,
    /// The meaning of the input's end for a last line without LF.
    pub end: EndOfInput,
    pub audience: Audience,
    pub medium: Medium,
    /// True if the bytes may be a recording. The first read must then return enough of them to
    /// decide.
    pub may_replay: bool,
    pub on_notice: Option<Box<dyn FnMut(Notice) + Send>>,
    pub on_end: Option<Box<dyn FnOnce() + Send>>,
}

/// Reference count of a transport's threads: when only the render thread holds it, they have ended.
pub(crate) type Life = Arc<()>;

/// Begins to serve a connection: announces it to the render thread and starts reading.
///
/// # Errors
/// If the system has no thread to give; nothing has begun then.
pub(crate) fn serve_connection(link: &Link, endpoint: Endpoint) -> io::Result<()> {
    let Endpoint { input, output, control, end, audience, medium, may_replay, on_notice, on_end } = endpoint;
    let (id, socket, pipe) = match input {
        ByteSource::Socket(socket) => (socket.id, Some(socket), None),
        ByteSource::Alone(pipe) => (link.new_id(), None, Some(pipe)),
    };
    let life = Life::default();
    let port = StreamPort { writer: Some(output), control, life: life.clone(), id };
    let messages = link.messages.clone();
    let back = link.poller.prepare(id, socket, end, messages.clone());
    let recycle = Box::new(Recycle(back.clone()));
    let source = ConnectionSource::Stream {
        recycle,
        reply_queue: Arc::new(ReplyQueue::default()),
        port: Box::new(port),
    };
    let opening = Message::Open(
        id,
        Box::new(OpenConnection { audience, medium, may_replay, source, on_notice, on_end }),
    );
    let Some(pipe) = pipe else {
        // A render thread that has ended opens no connections.
        if messages.send(opening).is_ok() {
            back.begin(life);
        }
        return Ok(());
    };
    let (begin, begins) = bounded(1);
    let read = move || {
        let _life = life;
        if begins.recv().is_ok() {
            pipe::read_all(pipe, &back);
        }
    };
    Builder::new().name(format!("read {id}")).stack_size(STACK_BYTES).spawn(read)?;
    // Sent by the calling thread, so that the render thread knows the connection before any later
    // request to end.
    if messages.send(opening).is_ok() {
        let _ = begin.send(());
    }
    Ok(())
}

/// Receiver of a connection's finished batches. Dropping it ends the connection.
struct Recycle(poll::Return);

impl Release for Recycle {
    fn put(&self, batch: Option<Batch>, payload_left: usize, lend: &mut dyn FnMut() -> Option<LentPayload>) {
        drop(batch);
        self.0.put(payload_left, lend);
    }
}

impl Drop for Recycle {
    fn drop(&mut self) {
        self.0.is_over();
    }
}

/// The render thread's handle on a connection's transport.
struct StreamPort {
    writer: Option<Box<dyn Write + Send>>,
    control: Arc<dyn Control>,
    /// Also held by the reader and the writer.
    life: Life,
    id: u64,
}

impl Port for StreamPort {
    fn start_writer(&mut self, reply_queue: Arc<ReplyQueue>, limit: usize, on_room: Box<dyn Fn() + Send>) {
        let Some(mut writer) = self.writer.take() else { return };
        let (control, life, for_writer) = (self.control.clone(), self.life.clone(), reply_queue.clone());
        let write = move || {
            let _life = life;
            // An error means that the client no longer reads; the rest is dropped.
            let _ = for_writer.write_all_to(&mut *writer, limit, on_room);
            drop(writer);
            control.finish_writing();
            for_writer.set_done();
        };
        let name = format!("write {}", self.id);
        if let Err(e) = Builder::new().name(name).stack_size(STACK_BYTES).spawn(write) {
            report(Trouble::Threads, format_args!("ended a connection: no thread to send replies: {e}"));
            // The client cannot be answered.
            reply_queue.set_done();
            self.control.abort();
        }
    }

    fn send_now(&mut self, bytes: &[u8]) -> usize {
        self.control.send_now(bytes)
    }

    fn end_without_writer(&mut self, reply_queue: &ReplyQueue) {
        self.writer = None;
        self.control.finish_writing();
        reply_queue.set_done();
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

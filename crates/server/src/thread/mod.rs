//! The render thread: owns the engine, and with it the video memory, and runs the commands of all
//! connections in slices.
//!
//! In: batches of bytes and typed commands over one bounded channel; input from the display. Out:
//! replies in each connection's reply queue, frames on the display. Promises: each connection's
//! commands run in order and its replies keep that order; a connection runs until it has used
//! [`SLICE_BYTES`] or [`SLICE_TIME`], whichever comes first (plus at most one command; less time
//! where many connections run); the thread never blocks on a client, a window or a reader. A reader
//! has few buffers and waits for a free one, so the bytes that are received and not yet run are
//! bounded, and the socket's own flow control slows a fast sender down.

pub(crate) mod connection;
mod scheduler;
mod work;

use super::buffer_pool::{BufferPool, POOLED_BUFFER_BYTES};
use super::client::Client;
use super::message::{ConnectionSource, Finish, Inbox, Medium, Message, OpenConnection};
use super::transport::{Link, Poller};
#[cfg(feature = "web")]
use super::web::{WebFeed, WebOptions, WebServer, WebTarget};
#[cfg(feature = "web")]
use super::{Limits, admission::Admission};
use super::{record, shared_file};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use fbptr_core::cancel::CancelToken;
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::VideoMemory;
use fbptr_engine::engine::{Engine, OutputState};
use fbptr_engine::session::Audience;
use fbptr_engine::workers::DRAW_STACK_BYTES;
use scheduler::Scheduler;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::thread::JoinHandle;
use std::time::Duration;

/// Stream bytes that one slice may run before the next connection does.
pub const SLICE_BYTES: usize = POOLED_BUFFER_BYTES;
/// Longest time of one slice. With many connections a slice is shorter, down to a tenth of this, so
/// that all of them run within 24 ms.
pub const SLICE_TIME: Duration = Duration::from_millis(2);
const ROUND_TIME: Duration = Duration::from_millis(24);
/// Messages that the channel can hold. Each connection has few in flight, so this limit is not
/// reached by any single one.
const CHANNEL_ROOM: usize = 8192;
/// Time between two scans for idle connections.
const IDLE_SCAN_EVERY: Duration = Duration::from_secs(1);
/// Time that a closing connection may spend without its client reading a byte.
const CLOSE_WITHIN: Duration = Duration::from_secs(20);
/// Time that a client may keep its side open after everything was sent.
const HANG_UP_WITHIN: Duration = Duration::from_secs(3);

/// Handle of the render thread.
#[derive(Debug)]
pub struct RenderThread {
    messages: Sender<Message>,
    thread: JoinHandle<Engine>,
    next_id: Arc<AtomicU64>,
    /// Cancels the running command.
    cancel: CancelToken,
    /// Disconnected when the thread has ended.
    ended: Receiver<()>,
    poller: Arc<Poller>,
}

impl RenderThread {
    /// Starts the thread with a frame of `width` x `height` pixels, opaque black, and the usual
    /// limits.
    ///
    /// # Errors
    /// If the frame cannot be made, or the thread cannot be started.
    pub fn new(width: u32, height: u32) -> Result<RenderThread, Fault> {
        let started = RenderThread::start(Engine::new(width, height)?);
        started.map_err(|e| Fault::new(Code::Quota, format!("the render thread cannot be started: {e}")))
    }

    /// Starts the thread.
    ///
    /// # Errors
    /// If the system has no thread to give, or the poller cannot be created.
    #[doc(hidden)]
    pub fn start(mut engine: Engine) -> std::io::Result<RenderThread> {
        let cancel = CancelToken::new();
        engine.set_cancel(cancel.clone());
        let shared_file = shared_file::output(OutputState::Off, engine.memory());
        engine.offer_output(shared_file);
        engine.offer_output(record::output(OutputState::Off, 0, 0));
        let (ends, ended) = bounded(0);
        let (sender, messages) = bounded(CHANNEL_ROOM);
        let own_sender = sender.clone();
        let buffers = Arc::new(BufferPool::new());
        let poller = Arc::new(Poller::new(buffers.clone())?);
        let inline_reader = poller.inline_reader();
        let thread = std::thread::Builder::new().name("render".into()).stack_size(DRAW_STACK_BYTES).spawn(
            move || {
                let _ends: Sender<()> = ends;
                Scheduler::new(engine, messages, own_sender, buffers, inline_reader).run()
            },
        )?;
        Ok(RenderThread {
            messages: sender,
            thread,
            next_id: Arc::new(AtomicU64::new(1)),
            cancel,
            ended,
            poller,
        })
    }

    /// Creates an in-process client with a connection of its own.
    pub fn client(&self) -> Client {
        let (link, inbox) = (self.link(), Arc::new(Inbox::default()));
        let id = link.new_id();
        let opening = OpenConnection {
            audience: Audience::Owner,
            medium: Medium::InProcess,
            may_replay: false,
            source: ConnectionSource::Inbox(inbox.clone()),
            on_notice: None,
            on_end: None,
        };
        if link.messages.send(Message::Open(id, Box::new(opening))).is_err() {
            inbox.close();
        }
        Client::new(id, link.messages, inbox)
    }

    /// Serves the page in the browser, as [`Server::serve_web`](super::Server::serve_web) does, for
    /// a thread without listeners.
    ///
    /// # Errors
    /// If the address cannot be bound, or the system has no thread to give.
    #[cfg(feature = "web")]
    pub fn serve_web(&self, feed: Arc<WebFeed>, options: WebOptions) -> std::io::Result<WebServer> {
        let limits = Limits::default();
        let admission = Admission::new(limits.connections, limits.connections_per_address);
        WebServer::start(feed, options, WebTarget::Thread { link: self.link(), admission })
    }

    pub(crate) fn link(&self) -> Link {
        Link { messages: self.messages.clone(), poller: self.poller.clone(), next_id: self.next_id.clone() }
    }

    /// Tells the thread that the window could not be opened. From then on `PRESENT wait` counts
    /// each frame as shown at once.
    #[doc(hidden)]
    pub fn drop_display(&self) {
        let _ = self.messages.send(Message::NoDisplay);
    }

    /// Runs `task` on the render thread between two slices of work.
    #[doc(hidden)]
    pub fn run_between(&self, task: impl FnOnce(&mut Engine) + Send + 'static) {
        let _ = self.messages.send(Message::Do(Box::new(task)));
    }

    /// Asks the thread to end and returns at once. [`Finish::Now`] also cancels the running
    /// command.
    pub fn begin_finish(&self, how: Finish) {
        if how == Finish::Now {
            self.cancel.cancel();
        }
        let _ = self.messages.send(Message::Finish(how));
    }

    /// Returns a function that ends the thread at once. It can be called from any thread, for
    /// instance one that handles signals.
    pub fn stopper(&self) -> impl Fn() + Send + 'static {
        let (messages, cancel) = (self.messages.clone(), self.cancel.clone());
        move || {
            cancel.cancel();
            drop(messages.send(Message::Finish(Finish::Now)));
        }
    }

    /// Returns whether the thread has ended.
    pub fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }

    /// Ends the thread and returns its video memory.
    ///
    /// # Panics
    /// If the render thread panicked, which is a defect.
    pub fn finish(self, how: Finish) -> VideoMemory {
        self.finish_engine(how).into_memory()
    }

    /// Ends the thread and returns its engine.
    ///
    /// # Panics
    /// As [`RenderThread::finish`].
    #[doc(hidden)]
    pub fn finish_engine(self, how: Finish) -> Engine {
        self.begin_finish(how);
        let RenderThread { messages, thread, cancel, ended, .. } = self;
        drop(messages);
        if let Finish::By(time) = how
            && ended.recv_deadline(time) == Err(RecvTimeoutError::Timeout)
        {
            // Still busy with a single command.
            cancel.cancel();
        }
        match thread.join() {
            Ok(engine) => engine,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

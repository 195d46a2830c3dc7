//! THE RENDER THREAD: owns the engine, and with it the video memory; runs what all connections
//! send, in slices.
//!
//! In: batches of bytes and typed commands over one bounded channel; input from the display. Out:
//! replies in each connection's reply queue, frames on the display. Promises: each connection's
//! commands run in order and its replies keep that order; connections run by slices of
//! [`SLICE_BYTES`] or [`SLICE_TIME`], whichever is used up first (one command more at most; where
//! many run, less time); the thread waits for no client, no window and no reader. A reader has few
//! buffers and waits for the next one, so what is received and not run is bounded, and the socket
//! itself holds a fast sender back.

pub(crate) mod connection;
pub(crate) mod message;
mod scheduler;

use super::client::Client;
use super::transport::{BufferPool, Medium, POOLED_BUFFER_BYTES, Poller};
use super::workers::DRAW_STACK_BYTES;
use super::{Audience, Engine};
use crate::cancel::CancelToken;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use message::{ConnectionSource, Id, Inbox, Message, OpenConnection};
use scheduler::Scheduler;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Stream bytes of one slice, after which the next connection runs.
pub const SLICE_BYTES: usize = POOLED_BUFFER_BYTES;
/// The time of one slice, and the time in which every connection has one, where that leaves each no
/// less than a tenth of it.
pub const SLICE_TIME: Duration = Duration::from_millis(2);
const ROUND_TIME: Duration = Duration::from_millis(24);
/// Messages that may wait. Each connection has few, so that this is never what limits one of them.
const CHANNEL_ROOM: usize = 8192;
/// The display is not given a new picture more often than this, but for PRESENT.
const SHOW_EVERY: Duration = Duration::from_millis(15);
/// Between two looks for idle connections.
const IDLE_SCAN_EVERY: Duration = Duration::from_secs(1);
/// How long a connection that is over may go without its client taking a byte.
const CLOSE_WITHIN: Duration = Duration::from_secs(20);
/// How long a client may keep its side open after it was sent everything.
const HANG_UP_WITHIN: Duration = Duration::from_secs(3);

/// How the render thread is to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finish {
    /// When all that was and will be sent has run and every connection is over.
    WhenAllEnded,
    /// When what has been received has run and its replies are out, and at this time in any case: what is being drawn
    /// then is abandoned.
    By(Instant),
    /// At once: what is being drawn is abandoned.
    Now,
}

/// A handle on the render thread.
#[derive(Debug)]
pub struct RenderThread {
    messages: Sender<Message>,
    thread: JoinHandle<Engine>,
    next_id: Arc<AtomicU64>,
    /// Ends what is being drawn.
    cancel: CancelToken,
    /// Has nobody at its other end when the thread has ended.
    ended: Receiver<()>,
    poller: Arc<Poller>,
}

/// What transports need of the render thread: a way to send, and numbers for connections.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    pub messages: Sender<Message>,
    pub poller: Arc<Poller>,
    next_id: Arc<AtomicU64>,
}

impl Link {
    /// A number that no other connection has.
    pub fn new_id(&self) -> Id {
        self.next_id.fetch_add(1, Ordering::Relaxed)
    }
}

impl RenderThread {
    /// Starts the thread.
    ///
    /// # Errors
    /// When the system has no thread to give, or nothing to wait with.
    pub fn start(mut engine: Engine) -> std::io::Result<RenderThread> {
        let cancel = CancelToken::new();
        engine.set_cancel(cancel.clone());
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

    /// A client in this process, with a connection of its own.
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

    pub(crate) fn link(&self) -> Link {
        Link { messages: self.messages.clone(), poller: self.poller.clone(), next_id: self.next_id.clone() }
    }

    /// Goes on without the display: the window could not be had. `PRESENT wait` counts as shown from now on.
    pub fn drop_display(&self) {
        let _ = self.messages.send(Message::NoDisplay);
    }

    /// Runs `task` on the render thread between two slices of work.
    pub fn run_between(&self, task: impl FnOnce(&mut Engine) + Send + 'static) {
        let _ = self.messages.send(Message::Do(Box::new(task)));
    }

    /// Asks the thread to end; it does so on its own time, but for [`Finish::Now`].
    pub fn begin_finish(&self, how: Finish) {
        if how == Finish::Now {
            self.cancel.cancel();
        }
        let _ = self.messages.send(Message::Finish(how));
    }

    /// Something that asks the thread to end at once, and can be called from anywhere, a signal's handler for instance.
    pub fn stopper(&self) -> impl Fn() + Send + 'static {
        let (messages, cancel) = (self.messages.clone(), self.cancel.clone());
        move || {
            cancel.cancel();
            drop(messages.send(Message::Finish(Finish::Now)));
        }
    }

    /// Whether the thread has ended.
    pub fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }

    /// Ends the thread and gives back its engine.
    ///
    /// # Panics
    /// When the render thread did, which is a defect.
    pub fn finish(self, how: Finish) -> Engine {
        self.begin_finish(how);
        let RenderThread { messages, thread, cancel, ended, .. } = self;
        drop(messages);
        if let Finish::By(time) = how
            && ended.recv_deadline(time) == Err(RecvTimeoutError::Timeout)
        {
            // Still busy with one command.
            cancel.cancel();
        }
        match thread.join() {
            Ok(engine) => engine,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

//! THE POLLER: one thread that reads all sockets, in turns, and the render thread where it has nothing else to do.
//!
//! The system says which sockets have something, each once until it is watched again; each of them is read once, into a
//! [`Lease`], before any is read again (but for large payloads, below). A thread for each socket would read as well, but where many of them wake up they push
//! the render thread aside, which is the one that all wait for, and each wake-up costs a change of threads. For the same
//! reason the render thread reads by itself ([`Hand`]) when it would have to sleep otherwise.
//!
//! Sockets that said little last are watched apart from those that say much, and asked for between any two reads and any two
//! turns of the render thread: a short request waits for one turn of another client, however many of them send all they can.
//!
//! Connections in the midst of large payloads give their turns to the one whose payload began first (`ready.rs`).
//!
//! Bytes of a connection come in order: a socket is watched again only when what was read from it is in the channel, and the
//! render thread empties the channel before it reads. A connection has few batches on their way (`flow.rs`): then it is not watched until one came back, the system's socket buffer fills, and the sender is held back.

use super::flow::{Flow, Place};
use super::hand::Hand;
use super::lease::{Buffers, Lease};
use super::ready::{Member, Ready};
use super::report::{Trouble, report};
use super::{Life, Socket};
use crate::command::EndOfInput;
use crate::server::thread::message::{Batch, Message};
use crossbeam_channel::Sender;
use rustix::event::{EventfdFlags, Timespec, epoll, eventfd};
use rustix::io::Errno;
use rustix::net::{RecvFlags, recv};
use std::collections::HashMap;
use std::fmt;
use std::io;
use std::mem::MaybeUninit;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

/// Reads of so few bytes are copied, and the lease goes on.
pub(super) const FEW_BYTES: usize = 8 << 10;
/// Sockets that the reader is told of at once.
const EVENTS: usize = 64;
/// The pause after the system could not say which sockets can be read.
const PAUSE: Duration = Duration::from_millis(20);
/// The name under which the poller itself is called.
const WAKE: u64 = u64::MAX;

/// All sockets that are read.
pub(super) struct Shared {
    /// Where sockets are watched that send much, the wake-up, and `brief` as a whole.
    bulk: OwnedFd,
    /// Where those are watched that said little last: they are asked for between any two reads.
    brief: OwnedFd,
    wake: OwnedFd,
    watched: Mutex<HashMap<u64, (Arc<Watched>, Life)>>,
    /// Those of `bulk` that can be read and are not watched until they are.
    ready: Mutex<Ready<Arc<Watched>>>,
    /// The thread found none of them and sleeps, or is about to. Set under the lock of `ready`.
    is_asleep: AtomicBool,
    /// The number of the next large payload, from 1 on.
    payloads: AtomicU64,
    pub(super) buffers: Arc<Buffers>,
    is_ending: AtomicBool,
}

/// A socket that is read.
pub(crate) struct Watched {
    pub(super) id: u64,
    socket: Arc<Socket>,
    messages: Sender<Message>,
    end: EndOfInput,
    flow: Mutex<Flow>,
    /// The last read gave little.
    is_brief: AtomicBool,
    /// The number of the large payload that it is in the midst of, or 0.
    payload_since: AtomicU64,
}

impl Member for Arc<Watched> {
    fn payload_since(&self) -> u64 {
        self.payload_since.load(Ordering::Relaxed)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Counts and flags are whole at any time.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The hold on the thread, which is started with the first socket, and ends when this is gone and the last socket closed.
pub(crate) struct Poller {
    shared: Arc<Shared>,
    is_started: Mutex<bool>,
}

impl Poller {
    /// # Errors
    /// When the system has nothing to wait with.
    pub fn new(buffers: Arc<Buffers>) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            bulk: epoll::create(epoll::CreateFlags::CLOEXEC)?,
            brief: epoll::create(epoll::CreateFlags::CLOEXEC)?,
            wake: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
            watched: Mutex::default(),
            ready: Mutex::new(Ready::new()),
            is_asleep: AtomicBool::new(false),
            payloads: AtomicU64::new(1),
            buffers,
            is_ending: AtomicBool::new(false),
        });
        for waked in [&shared.wake, &shared.brief] {
            epoll::add(&shared.bulk, waked, epoll::EventData::new_u64(WAKE), epoll::EventFlags::IN)?;
        }
        Ok(Poller { shared, is_started: Mutex::new(false) })
    }

    /// The render thread's means to read by itself.
    pub fn hand(&self) -> Hand {
        Hand::new(self.shared.clone())
    }

    /// Gets ready to read a socket. Answers what the render thread gives its batches back to.
    ///
    /// # Errors
    /// When the system has no room for it; nothing has begun then.
    pub fn prepare(
        &self,
        id: u64,
        socket: Arc<Socket>,
        end: EndOfInput,
        messages: Sender<Message>,
    ) -> io::Result<Return> {
        let mut is_started = lock(&self.is_started);
        if !*is_started {
            let shared = self.shared.clone();
            let read = move || shared.run();
            Builder::new().name("read".into()).stack_size(super::STACK_BYTES).spawn(read)?;
            *is_started = true;
        }
        let (flow, is_brief, payload_since) = (Mutex::default(), AtomicBool::new(true), AtomicU64::new(0));
        let watched = Arc::new(Watched { id, socket, messages, end, flow, is_brief, payload_since });
        Ok(Return { watched, shared: self.shared.clone() })
    }
}

impl Drop for Poller {
    fn drop(&mut self) {
        self.shared.is_ending.store(true, Ordering::Release);
        self.shared.wake();
    }
}

impl fmt::Debug for Poller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Poller({:?})", self.shared.buffers)
    }
}

/// Where the batches of a connection are given back. When it is dropped the connection is over.
pub(crate) struct Return {
    watched: Arc<Watched>,
    shared: Arc<Shared>,
}

impl Return {
    /// Begins to read; `life` is dropped when nothing more comes.
    pub fn begin(&self, life: Life) {
        lock(&self.shared.watched).insert(self.watched.id, (self.watched.clone(), life));
        self.shared.go_on(&self.watched, &mut lock(&self.watched.flow));
    }

    /// Takes a batch back, after which a payload waits for so many bytes.
    pub fn put(&self, wanted: usize) {
        let mut flow = lock(&self.watched.flow);
        flow.went(wanted);
        self.shared.note_payload(&self.watched, &flow);
        if flow.may_come() {
            self.shared.go_on(&self.watched, &mut flow);
        }
    }

    /// Another hold on the same, for whoever begins.
    pub fn share(&self) -> Return {
        Return { watched: self.watched.clone(), shared: self.shared.clone() }
    }

    /// The render thread wants no more.
    pub fn is_over(&self) {
        let mut flow = lock(&self.watched.flow);
        flow.is_over = true;
        self.shared.go_on(&self.watched, &mut flow);
    }
}

/// How many bytes a message brings.
pub(super) fn bytes_of(message: &Option<Message>) -> usize {
    match message {
        Some(Message::Bytes(_, batch)) => batch.filled,
        _ => 0,
    }
}

impl Shared {
    /// Has the reader look around.
    fn wake(&self) {
        // It is full only where it was written to already.
        let _ = rustix::io::write(&self.wake, &1u64.to_ne_bytes());
    }

    fn arm(&self, watched: &Watched, flow: &mut Flow) -> io::Result<()> {
        let (name, flags) =
            (epoll::EventData::new_u64(watched.id), epoll::EventFlags::IN | epoll::EventFlags::ONESHOT);
        let place = if watched.is_brief.load(Ordering::Relaxed) { Place::Brief } else { Place::Bulk };
        if flow.place == Some(place) {
            epoll::modify(self.set(place), &*watched.socket, name, flags)?;
        } else {
            if let Some(other) = flow.place.take() {
                epoll::delete(self.set(other), &*watched.socket)?;
            }
            epoll::add(self.set(place), &*watched.socket, name, flags)?;
        }
        (flow.place, flow.is_armed) = (Some(place), true);
        Ok(())
    }

    fn set(&self, place: Place) -> &OwnedFd {
        match place {
            Place::Bulk => &self.bulk,
            Place::Brief => &self.brief,
        }
    }

    /// Watches a socket again that was not, where something may come.
    fn go_on(&self, watched: &Watched, flow: &mut Flow) {
        if !flow.is_armed
            && !flow.is_at_end
            && let Err(e) = self.arm(watched, flow)
        {
            // The connection ends, as one that died.
            report(Trouble::Watching, format_args!("ended a connection: it cannot be watched: {e}"));
            flow.is_at_end = true;
            let ended = lock(&self.watched).remove(&watched.id);
            drop(ended);
            // The render thread may be the one who does this: it must not wait for room in its own channel.
            let _ = watched.messages.try_send(Message::End(watched.id, watched.end));
        }
    }

    /// Gives the payload that a connection is in the midst of a number, or takes it away.
    fn note_payload(&self, watched: &Watched, flow: &Flow) {
        let since = watched.payload_since.load(Ordering::Relaxed);
        if flow.is_within_payload() != (since > 0) {
            let number = if since > 0 { 0 } else { self.payloads.fetch_add(1, Ordering::Relaxed) };
            watched.payload_since.store(number, Ordering::Relaxed);
        }
    }

    /// What was read, so many bytes, is where it comes in its turn: the socket may be read again.
    pub(super) fn done(&self, watched: &Arc<Watched>, bytes: usize) {
        let mut flow = lock(&watched.flow);
        let may_stay = !flow.is_over && !flow.is_at_end && flow.may_come();
        if may_stay && lock(&self.ready).keep(watched, bytes) {
            // It is about to be read again.
            return;
        }
        flow.is_armed = false;
        if flow.may_come() {
            self.go_on(watched, &mut flow);
        }
    }

    /// Nothing more comes of this one. What the render thread is to hear.
    fn at_end(&self, watched: &Watched) -> Option<Message> {
        let mut flow = lock(&watched.flow);
        if let Some(place) = flow.place.take() {
            // It is known there, so this can be done.
            let _ = epoll::delete(self.set(place), &*watched.socket);
        }
        let is_wanted = !std::mem::replace(&mut flow.is_at_end, true) && !flow.is_over;
        drop(flow);
        // Its life ends outside of the lock.
        let ended = lock(&self.watched).remove(&watched.id);
        drop(ended);
        self.buffers.trim();
        if self.is_ending.load(Ordering::Acquire) {
            self.wake();
        }
        is_wanted.then_some(Message::End(watched.id, watched.end))
    }

    /// The next that can be read; `waits` for one, or not. Asks the system for so many at once.
    pub(super) fn next<const EVENTS: usize>(&self, waits: bool) -> io::Result<Option<Arc<Watched>>> {
        if let Some(watched) = self.next_brief()? {
            return Ok(Some(watched));
        }
        let is_empty = {
            let mut ready = lock(&self.ready);
            if !ready.is_stale() {
                return Ok(ready.next());
            }
            ready.refresh();
            if waits {
                self.is_asleep.store(ready.is_empty(), Ordering::Relaxed);
            }
            ready.is_empty()
        };
        let mut events = [MaybeUninit::<epoll::Event>::uninit(); EVENTS];
        let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
        let timeout = if waits && is_empty { None } else { Some(&at_once) };
        let events = match epoll::wait(&self.bulk, &mut events, timeout) {
            Ok((events, _)) => events,
            Err(Errno::INTR) => return Ok(None),
            Err(e) => return Err(e.into()),
        };
        let known = lock(&self.watched);
        let mut ready = lock(&self.ready);
        if waits {
            self.is_asleep.store(false, Ordering::Relaxed);
        }
        for (watched, _) in events.iter().filter_map(|event| known.get(&event.data.u64())) {
            ready.push(watched.clone());
        }
        if EVENTS > 1 {
            self.buffers.set_ready(ready.len());
        }
        Ok(ready.next())
    }

    /// Has the thread read what was left in `ready` by another one, but for what this connection has.
    pub(super) fn pass_on(&self, but_for: Option<u64>) {
        let ready = lock(&self.ready);
        if ready.holds(|watched| Some(watched.id) != but_for) && self.is_asleep.swap(false, Ordering::Relaxed)
        {
            self.wake();
        }
    }

    /// The next of those that said little last, if one can be read now.
    pub(super) fn next_brief(&self) -> io::Result<Option<Arc<Watched>>> {
        let mut events = [MaybeUninit::<epoll::Event>::uninit(); 1];
        let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
        match epoll::wait(&self.brief, &mut events, Some(&at_once)) {
            Ok((events, _)) => {
                let known = lock(&self.watched);
                Ok(events.first().and_then(|event| known.get(&event.data.u64())).map(|(w, _)| w.clone()))
            }
            Err(Errno::INTR) => Ok(None),
            Err(e) => Err(e.into()),
        }
    }

    fn run(&self) {
        let mut left = None;
        loop {
            match self.next::<EVENTS>(true) {
                Ok(Some(watched)) => {
                    let own = left.take().unwrap_or_else(|| self.buffers.lease());
                    let message = self.read(&watched, own, &mut left);
                    let bytes = bytes_of(&message);
                    // A render thread that is gone reads no more.
                    if message.is_some_and(|m| watched.messages.send(m).is_err()) {
                        lock(&watched.flow).is_over = true;
                    }
                    self.done(&watched, bytes);
                }
                Ok(None) => {
                    // Said once is enough.
                    let _ = rustix::io::read(&self.wake, &mut [0; 8]);
                    if self.is_ending.load(Ordering::Acquire) && lock(&self.watched).is_empty() {
                        return;
                    }
                }
                Err(e) => {
                    report(Trouble::Watching, format_args!("cannot wait for connections' bytes: {e}"));
                    std::thread::sleep(PAUSE);
                }
            }
        }
    }

    /// Reads once into `buffer`. Answers how much came, for which a batch must be handed on, or else what the render thread
    /// is to hear.
    pub(super) fn fill(&self, watched: &Watched, buffer: &mut [u8]) -> Result<usize, Option<Message>> {
        let filled = match recv(&*watched.socket, buffer, RecvFlags::DONTWAIT) {
            Err(Errno::INTR | Errno::AGAIN) => return Err(None),
            // A connection that died says no more than one that was closed: what came before still counts.
            Ok((0, _)) | Err(_) => return Err(self.at_end(watched)),
            Ok((filled, _)) => filled,
        };
        watched.is_brief.store(filled < FEW_BYTES, Ordering::Relaxed);
        let mut flow = lock(&watched.flow);
        if flow.is_over {
            // Its last replies are on their way: a socket that is closed with bytes unread would take them along.
            return Err(None);
        }
        flow.came(filled);
        self.note_payload(watched, &flow);
        Ok(filled)
    }

    /// Reads once, into a lease that goes along or is left over. What the render thread is to hear.
    pub(super) fn read(
        &self,
        watched: &Watched,
        mut own: Lease,
        left: &mut Option<Lease>,
    ) -> Option<Message> {
        let batch = match self.fill(watched, &mut own.buffer) {
            Err(message) => {
                *left = Some(own);
                return message;
            }
            Ok(filled) if filled <= FEW_BYTES => {
                let buffer = own.buffer[..filled].to_vec();
                *left = Some(own);
                Batch { buffer, lease: None, filled }
            }
            Ok(filled) => Batch { buffer: Vec::new(), lease: Some(own), filled },
        };
        Some(Message::Bytes(watched.id, batch))
    }
}

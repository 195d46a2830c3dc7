//! THE POLLER: reads all sockets, in turns, by one thread of its own and by the render thread where
//! that would sleep.
//!
//! In: sockets and pipes, and buffers that come back from the render thread. Out: batches of bytes,
//! each connection's in order. The selector says which sockets have something; each of those is
//! read once, into a [`Lease`], before any is read again (but for large payloads, `ready.rs`). A
//! thread for each socket would read as well, but where many of them wake up they push the render
//! thread aside, which is the one that all wait for, and each wake-up costs a change of threads.
//! For the same reason the render thread reads by itself ([`Hand`]) when it would have to sleep
//! otherwise: from the same list, by the same functions. Pipes and files, of which the system does
//! not say when they can be read, have a thread each (`pipe.rs`), with the same buffers and limits.
//!
//! Sockets that said little last have their turns before those that say much, and are looked for
//! between any two reads and any two turns of the render thread: a short request waits for one turn
//! of another client, however many of them send all they can.
//!
//! Promises: bytes of a connection come in order, because one thread at a time has its socket,
//! until what it read is in the channel, and the render thread empties the channel before it reads.
//! A connection has few batches on their way (`flow.rs`): then it is not read until one came back,
//! the system's socket buffer fills, and the sender is held back. An error of the selector is told
//! on standard error, and asked again.

use super::flow::Flow;
use super::lease::{Buffers, Lease};
use super::ready::{Member, Ready};
use super::report::{Trouble, report};
use super::selector::Selector;
use super::{Life, Slot, Socket, Stream};
use crate::command::EndOfInput;
use crate::server::thread::message::{Batch, Message};
use crossbeam_channel::Sender;
use std::collections::HashMap;
use std::fmt;
use std::io::{self, ErrorKind};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

/// Reads of so few bytes are copied, and the lease goes on.
pub(super) const FEW_BYTES: usize = 8 << 10;
/// A read within a large payload that gave so much is followed by another one of the same thread.
const MUCH_BYTES: usize = 64 << 10;
/// The pause after the system could not say which sockets can be read.
const PAUSE: Duration = Duration::from_millis(20);

/// Everything that is read.
pub(super) struct Shared {
    selector: Arc<Selector>,
    watched: Mutex<HashMap<u64, (Arc<Watched>, Life)>>,
    /// Readable sockets that no thread is reading.
    ready: Mutex<Ready<Arc<Watched>>>,
    /// Whether the thread sleeps, or is about to, because `ready` was empty. Set under its lock.
    is_asleep: AtomicBool,
    /// The number of the next large payload, from 1 on.
    payloads: AtomicU64,
    pub(super) buffers: Arc<Buffers>,
    is_ending: AtomicBool,
}

/// A connection that is read.
pub(crate) struct Watched {
    pub(super) id: u64,
    /// `None` for one that a thread of its own reads.
    socket: Option<Arc<Socket>>,
    pub(super) messages: Sender<Message>,
    end: EndOfInput,
    flow: Mutex<Flow>,
    /// A thread of its own may read again.
    may_come: Condvar,
    /// Number of reports by the selector. A socket that was found empty before the last report may
    /// have bytes again.
    changes: AtomicU32,
    /// Whether the last read was short.
    is_brief: AtomicBool,
    /// The number of the large payload that is being read, or 0.
    payload_since: AtomicU64,
}

impl Member for Arc<Watched> {
    fn payload_since(&self) -> u64 {
        self.payload_since.load(Ordering::Relaxed)
    }

    fn is_brief(&self) -> bool {
        self.is_brief.load(Ordering::Relaxed)
    }
}

impl Watched {
    /// Waits until a batch may be read.
    pub(super) fn wait_for_room(&self) {
        let mut flow = lock(&self.flow);
        while !flow.may_come() {
            flow = self.may_come.wait(flow).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Sends a message of what was read. A render thread that is gone wants no more.
    pub(super) fn send(&self, message: Message) {
        if self.messages.send(message).is_err() {
            lock(&self.flow).is_over = true;
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Counts and flags are whole at any time.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The hold on the thread, which is started with the first socket, and ends when this is gone and
/// the last socket closed.
pub(crate) struct Poller {
    shared: Arc<Shared>,
    is_started: Mutex<bool>,
}

impl Poller {
    /// # Errors
    /// When the system has nothing to wait with.
    pub fn new(buffers: Arc<Buffers>) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            selector: Arc::new(Selector::new()?),
            watched: Mutex::default(),
            ready: Mutex::new(Ready::new()),
            is_asleep: AtomicBool::new(false),
            payloads: AtomicU64::new(1),
            buffers,
            is_ending: AtomicBool::new(false),
        });
        Ok(Poller { shared, is_started: Mutex::new(false) })
    }

    /// The render thread's means to read by itself.
    pub fn hand(&self) -> Hand {
        Hand(self.shared.clone())
    }

    /// Takes a socket in under a number, with its place among the connections; nothing is read yet.
    ///
    /// # Errors
    /// When the system has no thread or no room to watch it. The stream comes back.
    pub fn adopt(&self, mut stream: Stream, id: u64, slot: Slot) -> Result<Arc<Socket>, (Stream, io::Error)> {
        let is_watched = self.start().and_then(|()| stream.register(&self.shared.selector, id));
        match is_watched {
            Ok(()) => Ok(Arc::new(Socket::new(stream, id, self.shared.selector.clone(), slot))),
            Err(e) => Err((stream, e)),
        }
    }

    fn start(&self) -> io::Result<()> {
        let mut is_started = lock(&self.is_started);
        if !*is_started {
            let shared = self.shared.clone();
            let read = move || shared.run();
            Builder::new().name("read".into()).stack_size(super::STACK_BYTES).spawn(read)?;
            *is_started = true;
        }
        Ok(())
    }

    /// Gets ready to read a connection: a socket that was adopted, or what a thread of its own will
    /// read. Answers what the render thread gives its batches back to.
    pub fn prepare(
        &self,
        id: u64,
        socket: Option<Arc<Socket>>,
        end: EndOfInput,
        messages: Sender<Message>,
    ) -> Return {
        let watched = Watched {
            id,
            socket,
            messages,
            end,
            flow: Mutex::default(),
            may_come: Condvar::new(),
            changes: AtomicU32::new(0),
            is_brief: AtomicBool::new(true),
            payload_since: AtomicU64::new(0),
        };
        Return { watched: Arc::new(watched), shared: self.shared.clone() }
    }
}

impl Drop for Poller {
    fn drop(&mut self) {
        self.shared.is_ending.store(true, Ordering::Release);
        self.shared.selector.wake();
    }
}

impl fmt::Debug for Poller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Poller({:?})", self.shared.buffers)
    }
}

/// Takes back the batches of one connection.
#[derive(Clone)]
pub(crate) struct Return {
    pub(super) watched: Arc<Watched>,
    pub(super) shared: Arc<Shared>,
}

impl Return {
    /// Begins to read a socket; `life` is dropped when nothing more comes.
    pub fn begin(&self, life: Life) {
        lock(&self.shared.watched).insert(self.watched.id, (self.watched.clone(), life));
        // What came before was told to nobody.
        self.shared.note_change(&self.watched);
        self.shared.wake();
    }

    /// Takes a batch back, after which a payload waits for so many bytes.
    pub fn put(&self, wanted: usize) {
        let mut flow = lock(&self.watched.flow);
        flow.went(wanted);
        self.shared.note_payload(&self.watched, &flow);
        self.go_on(flow);
    }

    /// The render thread wants no more.
    pub fn is_over(&self) {
        let mut flow = lock(&self.watched.flow);
        flow.is_over = true;
        self.go_on(flow);
    }

    fn go_on(&self, mut flow: MutexGuard<'_, Flow>) {
        if self.watched.socket.is_none() {
            self.watched.may_come.notify_one();
        } else if self.shared.offer(&self.watched, &mut flow) {
            self.shared.wake();
        }
    }
}

impl Shared {
    /// Wakes the thread up, if it sleeps.
    fn wake(&self) {
        if self.is_asleep.swap(false, Ordering::Relaxed) {
            self.selector.wake();
        }
    }

    /// Puts a socket in line, if it can and may be read and nobody does. Returns whether it was put
    /// there.
    fn offer(&self, watched: &Arc<Watched>, flow: &mut Flow) -> bool {
        let is_offered = flow.is_ready && !flow.is_taken && !flow.is_at_end && flow.may_come();
        if is_offered {
            flow.is_taken = true;
            lock(&self.ready).push(watched.clone());
        }
        is_offered
    }

    /// The selector named a socket: there is something to read, or there may be.
    fn note_change(&self, watched: &Arc<Watched>) {
        let mut flow = lock(&watched.flow);
        flow.is_ready = true;
        watched.changes.fetch_add(1, Ordering::Release);
        self.offer(watched, &mut flow);
    }

    /// Gives the payload that a connection is in the midst of a number, or takes it away.
    fn note_payload(&self, watched: &Watched, flow: &Flow) {
        let since = watched.payload_since.load(Ordering::Relaxed);
        if flow.is_within_payload() != (since > 0) {
            let number = if since > 0 { 0 } else { self.payloads.fetch_add(1, Ordering::Relaxed) };
            watched.payload_since.store(number, Ordering::Relaxed);
        }
    }

    /// Allows the socket to be read again after a batch of `bytes` was queued for the render thread.
    fn done(&self, watched: &Arc<Watched>, bytes: usize) {
        let mut flow = lock(&watched.flow);
        flow.is_taken = false;
        let goes_on = bytes >= MUCH_BYTES && watched.payload_since() > 0;
        if self.offer(watched, &mut flow) && !goes_on {
            self.wake();
        }
    }

    /// Ends a socket. Returns the message for the render thread.
    pub(super) fn at_end(&self, watched: &Watched) -> Option<Message> {
        let mut flow = lock(&watched.flow);
        let is_wanted = !std::mem::replace(&mut flow.is_at_end, true) && !flow.is_over;
        drop(flow);
        // Its life ends outside of the lock.
        let ended = lock(&self.watched).remove(&watched.id);
        drop(ended);
        self.buffers.trim();
        if self.is_ending.load(Ordering::Acquire) {
            self.selector.wake();
        }
        is_wanted.then_some(Message::End(watched.id, watched.end))
    }

    /// Asks the selector for readable sockets, with or without waiting for one.
    fn ask(&self, waits: bool) -> io::Result<()> {
        // Not locked while it waits.
        let mut known = None;
        let tell = |id| {
            if let Some((watched, _)) = known.get_or_insert_with(|| lock(&self.watched)).get(&id) {
                self.note_change(watched);
            }
        };
        match waits {
            true => self.selector.wait(tell),
            false => self.selector.look(tell),
        }
    }

    /// Waits for the next readable socket. `None` when the thread is to end.
    fn wait_next(&self) -> io::Result<Option<Arc<Watched>>> {
        if !lock(&self.ready).is_empty() {
            self.ask(false)?;
        }
        loop {
            {
                let mut ready = lock(&self.ready);
                self.buffers.set_ready(ready.len());
                if let Some(next) = ready.next() {
                    return Ok(Some(next));
                }
                self.is_asleep.store(true, Ordering::Relaxed);
            }
            let asked = self.ask(true);
            self.is_asleep.store(false, Ordering::Relaxed);
            asked?;
            if self.is_ending.load(Ordering::Acquire) && lock(&self.watched).is_empty() {
                return Ok(None);
            }
        }
    }

    fn run(&self) {
        let mut left = None;
        loop {
            match self.wait_next() {
                Ok(Some(watched)) => {
                    let own = left.take().unwrap_or_else(|| self.buffers.lease());
                    let message = self.read(&watched, own, &mut left);
                    let bytes = bytes_of(&message);
                    message.into_iter().for_each(|message| watched.send(message));
                    self.done(&watched, bytes);
                }
                Ok(None) => return,
                Err(e) => {
                    report(Trouble::Watching, format_args!("cannot wait for connections' bytes: {e}"));
                    std::thread::sleep(PAUSE);
                }
            }
        }
    }

    /// Counts a batch of `bytes`. Returns whether it must be handed on.
    pub(super) fn note_batch(&self, watched: &Watched, filled: usize) -> bool {
        let mut flow = lock(&watched.flow);
        if flow.is_over {
            // Its last replies are on their way: a socket that is closed with bytes unread would
            // take them along.
            return false;
        }
        flow.came(filled);
        self.note_payload(watched, &flow);
        true
    }

    /// Reads once into `buffer`. Returns the number of bytes, for which a batch must be handed on,
    /// or else the message for the render thread.
    fn fill(&self, watched: &Watched, buffer: &mut [u8]) -> Result<usize, Option<Message>> {
        let Some(socket) = &watched.socket else { return Err(None) };
        let changes = watched.changes.load(Ordering::Acquire);
        let (filled, state) = receive(socket, buffer);
        if (filled, state) == (0, State::AtEnd) {
            return Err(self.at_end(watched));
        }
        if state == State::Empty {
            let mut flow = lock(&watched.flow);
            flow.is_ready = watched.changes.load(Ordering::Acquire) != changes;
        }
        if filled == 0 {
            return Err(None);
        }
        watched.is_brief.store(filled < FEW_BYTES, Ordering::Relaxed);
        self.note_batch(watched, filled).then_some(filled).ok_or(None)
    }

    /// Reads once into `lease`. Returns the message for the render thread, with or without the lease.
    fn read(&self, watched: &Watched, mut own: Lease, left: &mut Option<Lease>) -> Option<Message> {
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

/// Returns the number of bytes of a message.
fn bytes_of(message: &Option<Message>) -> usize {
    match message {
        Some(Message::Bytes(_, batch)) => batch.filled,
        _ => 0,
    }
}

/// The state of a socket after a read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    /// Empty: the selector reports when there is more.
    Empty,
    /// Perhaps not empty.
    Unknown,
    /// Closed or broken; both end the connection in the same way.
    AtEnd,
}

/// Receives into `buffer`, and once more where little came: the selector tells again only of a
/// socket that was found empty. Answers how much came, which counts whatever follows, and how the
/// socket was left. One that brought much stays in line in place of being asked again: its sender
/// would be woken up for a second, short piece of the same.
fn receive(socket: &Socket, buffer: &mut [u8]) -> (usize, State) {
    let mut filled = 0;
    for _ in 0..2 {
        match socket.receive(&mut buffer[filled..]) {
            Ok(0) => return (filled, State::AtEnd),
            Ok(n) => filled += n,
            Err(e) if e.kind() == ErrorKind::WouldBlock => return (filled, State::Empty),
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(_) => return (filled, State::AtEnd),
        }
        if filled >= FEW_BYTES {
            break;
        }
    }
    (filled, State::Unknown)
}

/// The render thread's means to read sockets by itself: those in line, one at a time and without
/// waiting.
pub(crate) struct Hand(Arc<Shared>);

/// A socket that the render thread is about to read, into a lease or, where it said little last,
/// into a small buffer. What came of it before must be out of the channel first.
pub(crate) struct Next(Arc<Watched>, Option<Lease>);

impl Hand {
    /// A socket that can be read now, if there is one and a buffer for it.
    pub fn next(&mut self) -> Option<Next> {
        let lease = self.0.buffers.try_lease()?;
        self.ask();
        let watched = lock(&self.0.ready).next()?;
        Some(Next(watched, Some(lease)))
    }

    /// A socket that said little last and can be read now, if there is one.
    pub fn next_brief(&mut self) -> Option<Next> {
        let next = || lock(&self.0.ready).next_brief();
        let watched = next().or_else(|| {
            self.ask();
            next()
        });
        Some(Next(watched?, None))
    }

    fn ask(&self) {
        if let Err(e) = self.0.ask(false) {
            report(Trouble::Watching, format_args!("cannot ask for connections' bytes: {e}"));
        }
    }

    /// The render thread will not ask for the next one for a while: the poller reads those that
    /// were left to it, but for the connection that it is going to run.
    pub fn pass_on(&self, but_for: Option<u64>) {
        let ready = lock(&self.0.ready);
        if ready.holds(|watched| Some(watched.id) != but_for) {
            self.0.wake();
        }
    }

    /// Reads it.
    pub fn read(&mut self, Next(watched, lease): Next) -> Option<Message> {
        let message = match lease {
            Some(lease) => self.0.read(&watched, lease, &mut None),
            None => {
                let mut buffer = vec![0; FEW_BYTES];
                match self.0.fill(&watched, &mut buffer) {
                    Err(message) => message,
                    Ok(filled) => {
                        buffer.truncate(filled);
                        Some(Message::Bytes(watched.id, Batch { buffer, lease: None, filled }))
                    }
                }
            }
        };
        self.0.done(&watched, bytes_of(&message));
        message
    }
}

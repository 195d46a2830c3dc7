//! The poller: reads all sockets in rotation, on a thread of its own, and on the render thread when
//! that would sleep otherwise.
//!
//! In: sockets and pipes, and buffers that the render thread releases. Out: batches of bytes, each
//! connection's in order. The selector reports which sockets are readable; each of them is read
//! once, into a [`PooledBuffer`], before any is read again (except large payloads, see
//! `ready_queue.rs`). A thread per socket would read as well, but many of them waking up would
//! displace the render thread, for which all of them wait, and each wake-up costs a thread switch.
//! For the same reason the render thread reads sockets itself ([`InlineReader`]) when it would have
//! to sleep otherwise: from the same queue, with the same functions. Pipes and files, for which the
//! system does not report readiness, have a thread each (`pipe.rs`), with the same buffers and
//! limits.
//!
//! Interactive sockets, whose last read was short, are read before those that send much, and are
//! polled between any two reads and any two slices of the render thread: a short request waits for
//! at most one slice of another client, however many of them send at full speed.
//!
//! Promises: bytes of a connection arrive in order, because one thread at a time has its socket,
//! until the bytes it read are in the channel, and the render thread empties the channel before it
//! reads. A connection has few batches in flight (`backpressure.rs`): beyond that it is not read
//! until one is released, the system's socket buffer fills, and the sender is slowed down. An error
//! of the selector is reported on standard error, and the selector is polled again.

use super::backpressure::Backpressure;
use super::inline_reader::InlineReader;
use super::ready_queue::{Member, ReadyQueue};
use super::report::{Trouble, report};
use super::selector::Selector;
use super::{Life, Socket, Stream};
use crate::admission::Slot;
use crate::buffer_pool::{BufferPool, PooledBuffer};
use crate::message::{Batch, Message};
use crossbeam_channel::Sender;
use fbptr_command::{EndOfInput, LentPayload};
use std::collections::HashMap;
use std::fmt;
use std::io::{self, ErrorKind};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::{Duration, Instant};

/// Longest read in bytes that is copied, so that the pooled buffer is used again.
pub(super) const FEW_BYTES: usize = 8 << 10;
/// Shortest read in bytes, within a large payload, after which the same thread reads again.
const MUCH_BYTES: usize = 64 << 10;
/// Pause after an error of the selector.
const PAUSE: Duration = Duration::from_millis(20);
/// Shortest sleep that has a timeout.
const SHORTEST: Duration = Duration::from_millis(1);

/// State that the poller's thread and the render thread share.
pub(super) struct Shared {
    pub(super) selector: Arc<Selector>,
    registered: Mutex<HashMap<u64, (Arc<Registered>, Life)>>,
    /// Readable sockets that no thread is reading.
    pub(super) ready: Mutex<ReadyQueue<Arc<Registered>>>,
    /// Set while the thread sleeps, or is about to, because no socket in `ready` may be read. Set
    /// under the lock of `ready`.
    is_asleep: AtomicBool,
    pub(super) buffers: Arc<BufferPool>,
    is_ending: AtomicBool,
}

/// A sleep of the thread until a socket is readable, and until the given time at most.
pub(super) struct Sleep {
    until: Option<Instant>,
}

/// A connection that is read.
pub(crate) struct Registered {
    pub(super) id: u64,
    /// `None` for a connection that has a thread of its own.
    socket: Option<Arc<Socket>>,
    pub(super) messages: Sender<Message>,
    end: EndOfInput,
    backpressure: Mutex<Backpressure>,
    /// Signals the connection's own thread that it may read again.
    may_read: Condvar,
    /// Number of reports by the selector. A socket that was found empty before the last report may
    /// have bytes again.
    changes: AtomicU32,
    /// Set if the last read was short.
    is_interactive: AtomicBool,
    /// Number of the large payload that is being read, or 0.
    payload_since: AtomicU64,
}

impl Member for Arc<Registered> {
    fn payload_since(&self) -> u64 {
        self.payload_since.load(Ordering::Relaxed)
    }

    fn is_interactive(&self) -> bool {
        self.is_interactive.load(Ordering::Relaxed)
    }
}

impl Registered {
    /// Blocks until another batch may be read, and returns `None`, or until a payload was lent, which is
    /// to be read next. For a connection with a thread of its own.
    pub(super) fn wait_for_room(&self) -> Option<LentPayload> {
        let mut backpressure = lock(&self.backpressure);
        loop {
            if let Some(payload) = backpressure.take_lent() {
                return Some(payload);
            }
            if backpressure.may_begin_read() {
                return None;
            }
            backpressure = self.may_read.wait(backpressure).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Sends a message to the render thread. If that has ended, later bytes are discarded.
    pub(super) fn send(&self, message: Message) {
        if self.messages.send(message).is_err() {
            lock(&self.backpressure).is_over = true;
        }
    }
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // The counts and flags are consistent even if a thread panicked while it held the lock.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Handle of the reader thread. The thread is started with the first socket, and ends when this is
/// dropped and the last socket is closed.
pub(crate) struct Poller {
    shared: Arc<Shared>,
    is_started: Mutex<bool>,
}

impl Poller {
    /// Creates a poller; the thread is not started yet.
    ///
    /// # Errors
    /// If the system has no selector to give.
    pub fn new(buffers: Arc<BufferPool>) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            selector: Arc::new(Selector::new()?),
            registered: Mutex::default(),
            ready: Mutex::new(ReadyQueue::new()),
            is_asleep: AtomicBool::new(false),
            buffers,
            is_ending: AtomicBool::new(false),
        });
        Ok(Poller { shared, is_started: Mutex::new(false) })
    }

    /// Returns the reader of the render thread.
    pub fn inline_reader(&self) -> InlineReader {
        InlineReader(self.shared.clone())
    }

    /// Registers a socket under the number `id`; nothing is read yet.
    ///
    /// # Errors
    /// If the system cannot start the thread or watch one more socket. The stream is returned.
    pub fn adopt(&self, mut stream: Stream, id: u64, slot: Slot) -> Result<Arc<Socket>, (Stream, io::Error)> {
        let is_registered = self.start().and_then(|()| stream.register(&self.shared.selector, id));
        match is_registered {
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

    /// Prepares to read a connection: an adopted socket, or one that a thread of its own will read.
    /// Returns the handle to which the render thread releases the connection's batches.
    pub fn prepare(
        &self,
        id: u64,
        socket: Option<Arc<Socket>>,
        end: EndOfInput,
        messages: Sender<Message>,
    ) -> Return {
        let registered = Registered {
            id,
            socket,
            messages,
            end,
            backpressure: Mutex::default(),
            may_read: Condvar::new(),
            changes: AtomicU32::new(0),
            is_interactive: AtomicBool::new(true),
            payload_since: AtomicU64::new(0),
        };
        Return { registered: Arc::new(registered), shared: self.shared.clone() }
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

/// Handle to which the batches of one connection are released.
#[derive(Clone)]
pub(crate) struct Return {
    pub(super) registered: Arc<Registered>,
    pub(super) shared: Arc<Shared>,
}

impl Return {
    /// Starts reading a socket; `life` is dropped at the end of its input.
    pub fn begin(&self, life: Life) {
        lock(&self.shared.registered).insert(self.registered.id, (self.registered.clone(), life));
        // Earlier reports of the selector found no registered connection.
        self.shared.note_change(&self.registered);
        self.shared.wake();
    }

    /// Releases a batch; `payload_left` is the number of bytes that the current payload still
    /// lacks. Asks `lend` for a large one if the connection has a thread of its own.
    pub fn put(&self, payload_left: usize, lend: &mut dyn FnMut() -> Option<LentPayload>) {
        let mut backpressure = lock(&self.registered.backpressure);
        backpressure.on_release(payload_left);
        if self.registered.socket.is_none() {
            backpressure.borrow(lend);
        }
        self.shared.note_payload(&self.registered, &backpressure);
        self.go_on(backpressure);
    }

    /// Notes that the connection has ended: bytes that still arrive are discarded.
    pub fn is_over(&self) {
        let mut backpressure = lock(&self.registered.backpressure);
        backpressure.is_over = true;
        self.shared.note_payload(&self.registered, &backpressure);
        self.go_on(backpressure);
    }

    fn go_on(&self, mut backpressure: MutexGuard<'_, Backpressure>) {
        if self.registered.socket.is_none() {
            self.registered.may_read.notify_one();
            return;
        }
        let may_be_read = self.shared.offer(&self.registered, &mut backpressure);
        // Released first: the thread that wakes up takes this lock.
        drop(backpressure);
        if may_be_read {
            self.shared.wake();
        }
    }
}

impl Shared {
    /// Returns whether the thread sleeps. If not, it looks into the queue before it does.
    pub(super) fn is_asleep(&self) -> bool {
        self.is_asleep.load(Ordering::Relaxed)
    }

    /// Wakes the thread if it sleeps.
    pub(super) fn wake(&self) {
        if self.is_asleep.swap(false, Ordering::Relaxed) {
            self.selector.wake();
        }
    }

    /// Puts a socket into the ready queue, if it is readable, may be read, and no thread has it.
    /// Returns whether it was put there and does not wait for the payloads of others.
    fn offer(&self, registered: &Arc<Registered>, backpressure: &mut Backpressure) -> bool {
        backpressure.is_free() && put_into(&mut lock(&self.ready), registered, backpressure)
    }

    /// Notes that the selector has reported a socket: it is readable, or may be.
    fn note_change(&self, registered: &Arc<Registered>) {
        let mut backpressure = lock(&registered.backpressure);
        let mut ready = lock(&self.ready);
        ready.large.count(Instant::now);
        backpressure.has_bytes.store(true, Ordering::Relaxed);
        registered.changes.fetch_add(1, Ordering::Release);
        if backpressure.is_free() {
            put_into(&mut ready, registered, &mut backpressure);
        }
    }

    /// Numbers the large payload that a connection has begun, or clears the number at its end.
    fn note_payload(&self, registered: &Registered, backpressure: &Backpressure) {
        let is_ended = backpressure.is_over || backpressure.is_at_end;
        let is_within = backpressure.is_within_payload() && !is_ended;
        let since = registered.payload_since.load(Ordering::Relaxed);
        // A pipe has a thread of its own, and waits for nobody.
        if is_within == (since > 0) || registered.socket.is_none() {
            return;
        }
        let mut ready = lock(&self.ready);
        let now = Instant::now();
        let had_queued = ready.large.is_any_queued();
        let has_bytes = || backpressure.has_bytes.clone();
        let number = if is_within { ready.large.begin(now, has_bytes()) } else { 0 };
        registered.payload_since.store(number, Ordering::Relaxed);
        if !is_within {
            ready.large.end(since, now);
        }
        let is_due = match is_within {
            // The thread may sleep without the timeout that it needs from now on.
            true => !had_queued && ready.large.is_any_queued(),
            // Others that waited for this one may be read.
            false => had_queued,
        };
        if is_due {
            self.wake();
        }
    }

    /// Allows the socket to be read again after a batch of `bytes` was queued for the render
    /// thread.
    pub(super) fn done(&self, registered: &Arc<Registered>, bytes: usize) {
        let mut backpressure = lock(&registered.backpressure);
        backpressure.is_taken = false;
        let goes_on = bytes >= MUCH_BYTES && registered.payload_since() > 0;
        let may_be_read = self.offer(registered, &mut backpressure);
        drop(backpressure);
        if may_be_read && !goes_on {
            self.wake();
        }
    }

    /// Ends the reading of a connection. Returns the message for the render thread, the first time.
    pub(super) fn at_end(&self, registered: &Registered) -> Option<Message> {
        let mut backpressure = lock(&registered.backpressure);
        let is_expected = !std::mem::replace(&mut backpressure.is_at_end, true) && !backpressure.is_over;
        self.note_payload(registered, &backpressure);
        drop(backpressure);
        // The connection's `Life` is dropped after the lock is released.
        let ended = lock(&self.registered).remove(&registered.id);
        drop(ended);
        self.buffers.trim();
        if self.is_ending.load(Ordering::Acquire) {
            self.selector.wake();
        }
        is_expected.then_some(Message::End(registered.id, registered.end))
    }

    /// Polls the selector for readable sockets, without blocking if `sleep` is `None`. Returns
    /// whether the thread was to be woken up.
    pub(super) fn ask(&self, sleep: Option<Sleep>) -> io::Result<bool> {
        // Not locked while the selector blocks.
        let mut locked = None;
        let notify = |id| {
            if let Some((registered, _)) = locked.get_or_insert_with(|| lock(&self.registered)).get(&id) {
                self.note_change(registered);
            }
        };
        match sleep {
            None => self.selector.look(notify),
            Some(Sleep { until }) => {
                // A sleep of no time would be none.
                let left = |until: Instant| until.saturating_duration_since(Instant::now()).max(SHORTEST);
                self.selector.wait(until.map(left), notify)
            }
        }
    }

    /// Waits for the next readable socket. Returns `None` when the thread is to end.
    fn wait_next(&self) -> io::Result<Option<Arc<Registered>>> {
        if !lock(&self.ready).is_empty() {
            self.ask(None)?;
        }
        loop {
            let sleep = {
                let mut ready = lock(&self.ready);
                ready.large.watch(Instant::now, false);
                self.buffers.set_ready(ready.readable());
                if let Some(next) = ready.next() {
                    return Ok(Some(next));
                }
                self.is_asleep.store(true, Ordering::Relaxed);
                ready.large.watch(Instant::now, true);
                Sleep { until: ready.large.deadline() }
            };
            let asked = self.ask(Some(sleep));
            self.is_asleep.store(false, Ordering::Relaxed);
            asked?;
            if self.is_ending.load(Ordering::Acquire) && lock(&self.registered).is_empty() {
                return Ok(None);
            }
        }
    }

    fn run(&self) {
        let mut left = None;
        loop {
            match self.wait_next() {
                Ok(Some(registered)) => {
                    let own = left.take().unwrap_or_else(|| self.buffers.acquire());
                    let message = self.read(&registered, own, &mut left);
                    let bytes = bytes_of(&message);
                    message.into_iter().for_each(|message| registered.send(message));
                    self.done(&registered, bytes);
                }
                Ok(None) => return,
                Err(e) => {
                    report(Trouble::Watching, format_args!("cannot wait for connections' bytes: {e}"));
                    std::thread::sleep(PAUSE);
                }
            }
        }
    }

    /// Counts a batch of `filled` bytes. Returns whether it must be sent to the render thread.
    pub(super) fn note_batch(&self, registered: &Registered, filled: usize) -> bool {
        let mut backpressure = lock(&registered.backpressure);
        if backpressure.is_over {
            // Its last replies are being sent: a socket that is closed with unread bytes is reset,
            // and the replies would be lost. So the bytes are read and discarded.
            return false;
        }
        backpressure.on_read(filled);
        self.note_payload(registered, &backpressure);
        true
    }

    /// Reads once into `buffer`. Returns the number of bytes, which must be sent as a batch, or
    /// otherwise the message for the render thread, if there is one.
    pub(super) fn fill(&self, registered: &Registered, buffer: &mut [u8]) -> Result<usize, Option<Message>> {
        let Some(socket) = &registered.socket else { return Err(None) };
        let changes = registered.changes.load(Ordering::Acquire);
        let (filled, state) = receive(socket, buffer);
        if (filled, state) == (0, SocketState::AtEnd) {
            return Err(self.at_end(registered));
        }
        if state == SocketState::Empty {
            let backpressure = lock(&registered.backpressure);
            if registered.payload_since.load(Ordering::Relaxed) > 0 {
                lock(&self.ready).large.count(Instant::now);
            }
            let has_changed = registered.changes.load(Ordering::Acquire) != changes;
            backpressure.has_bytes.store(has_changed, Ordering::Relaxed);
        }
        if filled == 0 {
            return Err(None);
        }
        registered.is_interactive.store(filled < FEW_BYTES, Ordering::Relaxed);
        self.note_batch(registered, filled).then_some(filled).ok_or(None)
    }

    /// Reads once into `own`. Returns the message for the render thread; the buffer is in it, or in
    /// `left` if it was not needed.
    pub(super) fn read(
        &self,
        registered: &Registered,
        mut own: PooledBuffer,
        left: &mut Option<PooledBuffer>,
    ) -> Option<Message> {
        let batch = match self.fill(registered, &mut own.buffer) {
            Err(message) => {
                *left = Some(own);
                return message;
            }
            Ok(filled) if filled <= FEW_BYTES => {
                let buffer = own.buffer[..filled].to_vec();
                *left = Some(own);
                Batch { buffer, pooled: None, filled }
            }
            Ok(filled) => Batch { buffer: Vec::new(), pooled: Some(own), filled },
        };
        Some(Message::Bytes(registered.id, batch))
    }
}

/// Puts a free socket into the ready queue, if it may be read. Returns whether it was put there and
/// does not wait for the payloads of others.
fn put_into(
    ready: &mut ReadyQueue<Arc<Registered>>,
    registered: &Arc<Registered>,
    backpressure: &mut Backpressure,
) -> bool {
    if !backpressure.may_read(ready.large.is_any_active()) {
        return false;
    }
    backpressure.is_taken = true;
    ready.push(registered.clone());
    ready.may_read(registered)
}

/// Returns the number of bytes of a message.
pub(super) fn bytes_of(message: &Option<Message>) -> usize {
    match message {
        Some(Message::Bytes(_, batch)) => batch.filled,
        _ => 0,
    }
}

/// State of a socket after a read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SocketState {
    /// Empty: the selector will report new bytes.
    Empty,
    /// Possibly not empty.
    Unknown,
    /// Closed or broken; both end the connection in the same way.
    AtEnd,
}

/// Receives into `buffer`, and once more after a short read, because the selector reports a socket
/// again only if it was found empty. Returns the number of bytes, which counts even at the end of
/// the input, and the state of the socket. After a long read the socket stays in the ready queue
/// instead: a second read would wake its sender for a short piece of the same data.
fn receive(socket: &Socket, buffer: &mut [u8]) -> (usize, SocketState) {
    let mut filled = 0;
    for _ in 0..2 {
        match socket.receive(&mut buffer[filled..]) {
            Ok(0) => return (filled, SocketState::AtEnd),
            Ok(n) => filled += n,
            Err(e) if e.kind() == ErrorKind::WouldBlock => return (filled, SocketState::Empty),
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(_) => return (filled, SocketState::AtEnd),
        }
        if filled >= FEW_BYTES {
            break;
        }
    }
    (filled, SocketState::Unknown)
}

//! The thread that writes a recording: the render thread hands over blocks and does not wait for the disk.
//!
//! In: blocks of bytes, in order. Out: the same bytes, to a file or pipe. At most [`MAX_QUEUED_BYTES`] and one block wait;
//! beyond that the render thread waits, for as long as [`Patience`] says. Then, or on the first write error, the
//! recording ends: `on_failure` is called once, at once, and later blocks are dropped. Blocks queued before a pipe's
//! timeout are still written should its reader go on, so what arrives is a prefix of the recording in every case.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Bytes that may wait for the disk before the render thread waits for it.
const MAX_QUEUED_BYTES: u64 = 32 << 20;
/// Written blocks that are kept for the next ones, and the largest one kept.
const MAX_FREE_BLOCKS: usize = 8;
const MAX_FREE_BYTES: usize = 1 << 20;
/// The longest time without progress at the end of a recording, if the patience is shorter.
const FINISH_STALL: Duration = Duration::from_millis(500);

/// How long the render thread waits for a full queue, and how much is written at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patience {
    /// The longest time in which nothing is written.
    pub stall: Duration,
    /// The longest time for room to be made.
    pub total: Duration,
    /// Bytes of one write: what counts as progress.
    pub piece_bytes: usize,
}

impl Patience {
    /// For files: a disk may stall while it writes back.
    pub const FILE: Patience =
        Patience { stall: Duration::from_secs(5), total: Duration::from_secs(10), piece_bytes: 1 << 18 };
    /// For pipes and devices: clients do not wait for a program that does not read.
    pub const PIPE: Patience =
        Patience { stall: Duration::from_millis(100), total: Duration::from_secs(1), piece_bytes: 4096 };
}

/// The function that is told why a recording ends early.
pub(super) type OnFailure = Box<dyn FnOnce(&io::Error) + Send>;

/// The state of a recording, for `STATS`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::server) struct RecordStats {
    /// Bytes written.
    pub written_bytes: u64,
    /// Bytes that wait to be written.
    pub queued_bytes: u64,
}

/// A recording that ended early. Its figures change as long as the thread still writes queued blocks.
pub(in crate::server) struct FailedRecording {
    /// Why it ended.
    pub reason: String,
    shared: Arc<Shared>,
}

impl std::fmt::Debug for FailedRecording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "FailedRecording({})", self.reason)
    }
}

impl FailedRecording {
    /// Counts bytes.
    pub fn stats(&self) -> RecordStats {
        self.shared.lock().stats
    }
}

#[derive(Default)]
struct WriterState {
    blocks: VecDeque<Vec<u8>>,
    stats: RecordStats,
    /// Empty blocks for reuse: a fresh one costs page faults.
    free_blocks: Vec<Vec<u8>>,
    failure: Option<String>,
    on_failure: Option<OnFailure>,
    /// No more blocks come.
    is_closed: bool,
    /// The thread has ended.
    is_done: bool,
}

#[derive(Default)]
struct Shared {
    state: Mutex<WriterState>,
    /// A block was queued, or the queue was closed.
    queued: Condvar,
    /// Bytes were written, or the thread has ended.
    written: Condvar,
    has_failed: AtomicBool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, WriterState> {
        // Each change of the state is complete in itself, so it is sound after a panic too.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends the recording; the first reason counts.
    fn fail(&self, mut state: MutexGuard<'_, WriterState>, error: &io::Error) {
        state.is_closed = true;
        if state.failure.is_none() {
            state.failure = Some(error.to_string());
        }
        let on_failure = state.on_failure.take();
        self.has_failed.store(true, Ordering::Release);
        drop(state);
        self.queued.notify_all();
        if let Some(notify) = on_failure {
            notify(error);
        }
    }
}

/// The render thread's handle. Dropping it ends the recording without waiting; what is queued may still be written.
pub(super) struct Writer {
    shared: Arc<Shared>,
    patience: Patience,
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.shared.lock().is_closed = true;
        self.shared.queued.notify_all();
    }
}

impl Writer {
    /// Starts the thread.
    ///
    /// # Errors
    /// When the system has no thread to give.
    pub fn start(
        out: Box<dyn Write + Send>,
        patience: Patience,
        on_failure: Option<OnFailure>,
    ) -> io::Result<Writer> {
        let state = WriterState { on_failure, ..WriterState::default() };
        let shared = Arc::new(Shared { state: Mutex::new(state), ..Shared::default() });
        let (theirs, piece_bytes) = (shared.clone(), patience.piece_bytes);
        std::thread::Builder::new().name("record".into()).spawn(move || run(&theirs, out, piece_bytes))?;
        Ok(Writer { shared, patience })
    }

    /// Queues a block, and returns an empty one for the next bytes. Waits while the queue is full.
    pub fn push(&self, block: Vec<u8>) -> Vec<u8> {
        let mut state = self.wait_for_room();
        if !state.is_closed && !block.is_empty() {
            state.stats.queued_bytes += block.len() as u64;
            state.blocks.push_back(block);
            self.shared.queued.notify_one();
        }
        state.free_blocks.pop().unwrap_or_default()
    }

    fn wait_for_room(&self) -> MutexGuard<'_, WriterState> {
        let begun = Instant::now();
        let mut state = self.shared.lock();
        let mut progress = (state.stats.written_bytes, begun);
        while state.stats.queued_bytes >= MAX_QUEUED_BYTES && !state.is_closed {
            let now = Instant::now();
            if state.stats.written_bytes != progress.0 {
                progress = (state.stats.written_bytes, now);
            }
            let until = (progress.1 + self.patience.stall).min(begun + self.patience.total);
            if now >= until {
                let (queued, waited) = (state.stats.queued_bytes, now - begun);
                let message = format!("{queued} bytes wait, and no room was made for {waited:.1?}");
                self.shared.fail(state, &io::Error::new(io::ErrorKind::TimedOut, message));
                return self.shared.lock();
            }
            state = self.wait_written(state, until - now);
        }
        state
    }

    fn wait_written<'a>(
        &self,
        state: MutexGuard<'a, WriterState>,
        time: Duration,
    ) -> MutexGuard<'a, WriterState> {
        self.shared.written.wait_timeout(state, time).unwrap_or_else(PoisonError::into_inner).0
    }

    /// Ends the recording; what is queued is still written.
    pub fn fail(&self, reason: &'static str) {
        self.shared.fail(self.shared.lock(), &io::Error::other(reason));
    }

    /// Whether the recording has ended early.
    pub fn has_failed(&self) -> bool {
        self.shared.has_failed.load(Ordering::Acquire)
    }

    /// The reason and the figures of a recording that has ended early.
    pub fn failure(&self) -> Option<FailedRecording> {
        let reason = self.shared.lock().failure.clone()?;
        Some(FailedRecording { reason, shared: self.shared.clone() })
    }

    /// Counts bytes.
    pub fn stats(&self) -> RecordStats {
        self.shared.lock().stats
    }

    /// Ends the recording and waits for the last byte, as long as there is progress.
    pub fn finish(&self) {
        let stall = self.patience.stall.max(FINISH_STALL);
        let mut state = self.shared.lock();
        state.is_closed = true;
        self.shared.queued.notify_all();
        let mut progress = (state.stats.written_bytes, Instant::now());
        while !state.is_done && state.failure.is_none() {
            let now = Instant::now();
            if state.stats.written_bytes != progress.0 {
                progress = (state.stats.written_bytes, now);
            }
            let until = progress.1 + stall;
            if now >= until {
                let message = format!("its last {} bytes could not be written", state.stats.queued_bytes);
                return self.shared.fail(state, &io::Error::new(io::ErrorKind::TimedOut, message));
            }
            state = self.wait_written(state, until - now);
        }
    }
}

/// The thread: writes blocks until the queue is closed and empty, or a write fails.
fn run(shared: &Shared, mut out: Box<dyn Write + Send>, piece_bytes: usize) {
    let mut result = Ok(());
    while result.is_ok() {
        let mut state = shared.lock();
        while state.blocks.is_empty() && !state.is_closed {
            state = shared.queued.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        let Some(block) = state.blocks.pop_front() else { break };
        drop(state);
        result = write_block(shared, &mut *out, block, piece_bytes);
    }
    let result = result.and_then(|()| out.flush());
    let mut state = shared.lock();
    state.is_done = true;
    (state.blocks, state.free_blocks) = (VecDeque::new(), Vec::new());
    // Nothing waits any more, written or not.
    state.stats.queued_bytes = 0;
    match result {
        Ok(()) => drop(state),
        Err(e) => shared.fail(state, &e),
    }
    shared.written.notify_all();
}

fn write_block(
    shared: &Shared,
    out: &mut dyn Write,
    mut block: Vec<u8>,
    piece_bytes: usize,
) -> io::Result<()> {
    let mut rest = &block[..];
    while !rest.is_empty() {
        match out.write(&rest[..rest.len().min(piece_bytes)]) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(written) => {
                rest = &rest[written..];
                let mut state = shared.lock();
                state.stats.written_bytes += written as u64;
                state.stats.queued_bytes -= written as u64;
                drop(state);
                shared.written.notify_all();
            }
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    block.clear();
    let mut state = shared.lock();
    if block.capacity() <= MAX_FREE_BYTES && state.free_blocks.len() < MAX_FREE_BLOCKS {
        state.free_blocks.push(block);
    }
    Ok(())
}

//! The thread that writes a recording, so that the render thread does not wait for the disk.
//!
//! In: blocks of bytes, in order. Out: the same bytes, in a file or pipe. At most
//! [`MAX_QUEUED_BYTES`] and one block are queued; beyond that the render thread waits, for as long
//! as [`Patience`] allows. Then, or at the first write error, the recording ends: `on_failure` is
//! called once, immediately, and later blocks are dropped. Blocks queued before a pipe's timeout
//! are still written if its reader continues, so the output is a prefix of the recording in every
//! case.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Queued bytes at which the render thread waits for the disk.
const MAX_QUEUED_BYTES: u64 = 32 << 20;
/// Number of written blocks that are kept for reuse, and the largest size of one in bytes.
const MAX_FREE_BLOCKS: usize = 8;
const MAX_FREE_BYTES: usize = 1 << 20;
/// Longest time without progress at the end of a recording, if that of [`Patience`] is shorter.
const FINISH_STALL: Duration = Duration::from_millis(500);

/// Time that the render thread waits while the queue is full, and size of one write.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patience {
    /// Longest time in which nothing is written.
    pub stall: Duration,
    /// Longest time until the queue has room.
    pub total: Duration,
    /// Most bytes of one write, which is the unit of progress.
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

/// Function that is called with the reason if a recording ends early.
pub(super) type OnFailure = Box<dyn FnOnce(&io::Error) + Send>;

/// Byte counts of a recording, for `STATS`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct RecordStats {
    /// Bytes that have been written.
    pub written_bytes: u64,
    /// Bytes that are queued.
    pub queued_bytes: u64,
}

#[derive(Default)]
struct WriterState {
    blocks: VecDeque<Vec<u8>>,
    stats: RecordStats,
    /// Empty blocks for reuse: a new allocation costs page faults.
    free_blocks: Vec<Vec<u8>>,
    failure: Option<String>,
    on_failure: Option<OnFailure>,
    /// Set when no more blocks will be queued.
    is_closed: bool,
    /// Set when the thread has ended.
    is_done: bool,
}

#[derive(Default)]
struct Shared {
    state: Mutex<WriterState>,
    /// Signals that a block was queued, or the queue was closed.
    queued: Condvar,
    /// Signals that bytes were written, or the thread has ended.
    written: Condvar,
    has_failed: AtomicBool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, WriterState> {
        // Each change of the state is complete in itself, so it is valid after a panic, too.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends the recording early; the first reason is kept.
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

/// The render thread's handle. Dropping it ends the recording without waiting; queued blocks may
/// still be written.
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
    /// If the system has no thread to give.
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

    /// Queues a block, and returns an empty one for the next bytes. Blocks while the queue is full.
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

    /// Ends the recording early; queued blocks are still written.
    pub fn fail(&self, reason: &'static str) {
        self.shared.fail(self.shared.lock(), &io::Error::other(reason));
    }

    /// Returns whether the recording has ended early.
    pub fn has_failed(&self) -> bool {
        self.shared.has_failed.load(Ordering::Acquire)
    }

    /// Returns the reason for which the recording has ended early, if it has.
    pub fn failure(&self) -> Option<String> {
        self.shared.lock().failure.clone()
    }

    /// Returns the numbers of written and queued bytes.
    pub fn stats(&self) -> RecordStats {
        self.shared.lock().stats
    }

    /// Ends the recording and waits for its last byte, as long as writing makes progress.
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

/// Runs the thread: writes blocks until the queue is closed and empty, or a write fails.
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
    // Nothing is queued from here on, whether it was written or not.
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

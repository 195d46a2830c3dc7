//! The replies of one connection: queued by the render thread, which never blocks, and sent by a
//! writer at its client's speed.
//!
//! In: complete replies, from the render thread. Out: bytes in order, through a writer on a thread
//! of its own, which is started with the first reply that cannot be sent at once. A client that
//! does not read fills only its own queue; the render thread then suspends that client's commands
//! ([`ReplyQueue::is_full`]) until the writer has made room. A failure to send is told at once: the
//! render thread then drops what only that client would receive.

use fbptr_core::memory::{MemoryBudget, MemoryUse, Reservation};
use std::io::{self, Write};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

#[derive(Debug, Default)]
struct QueueState {
    ready: Vec<u8>,
    /// Bytes that the writer has taken and not sent yet.
    in_flight: usize,
    /// Set when nothing more will be queued.
    is_closed: bool,
    /// Set when the writer has ended: all bytes are sent, or the client does not read any more.
    is_done: bool,
    has_failed: bool,
    /// Set while the render thread waits for room.
    is_awaited: bool,
    /// The memory budget's reservation for the bytes and for the writer's buffer.
    held: Option<Reservation>,
    /// Capacity of the writer's buffer in bytes.
    batch_room: usize,
}

impl QueueState {
    /// Updates the reservation.
    fn count(&mut self) {
        let bytes = (self.ready.capacity() + self.batch_room) as u64;
        if let Some(held) = &mut self.held {
            held.set(bytes);
        }
    }
}

/// Replies of one connection that have not been sent to its client.
#[derive(Debug, Default)]
pub(crate) struct ReplyQueue {
    state: Mutex<QueueState>,
    changed: Condvar,
}

/// Largest capacity in bytes that a buffer keeps after use.
const KEPT_BYTES: usize = 1 << 20;

impl ReplyQueue {
    fn lock(&self) -> MutexGuard<'_, QueueState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts the queued bytes as a part of `budget`.
    pub fn set_budget(&self, budget: &MemoryBudget) {
        let mut state = self.lock();
        state.held = Some(budget.empty(MemoryUse::Replies));
        state.count();
    }

    /// Queues `bytes`, and empties them. They are dropped if nobody will read them.
    pub fn put(&self, bytes: &mut Vec<u8>) {
        let mut state = self.lock();
        if !state.has_failed && !state.is_closed {
            match state.ready.is_empty() {
                true => std::mem::swap(&mut state.ready, bytes),
                false => state.ready.extend_from_slice(bytes),
            }
            state.count();
        }
        bytes.clear();
        drop(state);
        self.changed.notify_all();
    }

    /// Returns the number of bytes that have not been sent.
    pub fn pending(&self) -> usize {
        let state = self.lock();
        state.ready.len() + state.in_flight
    }

    /// Returns whether `limit` bytes or more are queued. If so, the writer will call `on_room` once
    /// half of the limit is free.
    pub fn is_full(&self, limit: usize) -> bool {
        let mut state = self.lock();
        let is_full = state.ready.len() + state.in_flight >= limit;
        state.is_awaited = is_full;
        is_full
    }

    /// Returns whether sending has failed: the client is gone, and nobody reads what is queued.
    pub fn has_failed(&self) -> bool {
        self.lock().has_failed
    }

    /// Notes that nothing more will be queued.
    pub fn close(&self) {
        self.lock().is_closed = true;
        self.changed.notify_all();
    }

    /// Notes that the writer has ended, or that none was started.
    pub fn set_done(&self) {
        self.lock().is_done = true;
        self.changed.notify_all();
    }

    /// Returns whether the writer has ended.
    pub fn is_done(&self) -> bool {
        self.lock().is_done
    }

    /// Waits until the writer has ended, or the time `until`. Returns whether it has ended.
    pub fn wait_done(&self, until: Instant) -> bool {
        let mut state = self.lock();
        while !state.is_done {
            let left = until.saturating_duration_since(Instant::now());
            if left == Duration::ZERO {
                return false;
            }
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }

    /// Sends what is queued until the queue is closed and empty, or sending fails. Runs on the
    /// writer's thread.
    pub fn write_all_to(&self, out: &mut dyn Write, limit: usize, on_room: impl Fn()) -> io::Result<()> {
        let mut batch = Vec::new();
        loop {
            let mut state = self.lock();
            while state.ready.is_empty() && !state.is_closed {
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
            if state.ready.is_empty() {
                break;
            }
            std::mem::swap(&mut state.ready, &mut batch);
            (state.in_flight, state.batch_room) = (batch.len(), batch.capacity());
            state.count();
            drop(state);
            let mut result = Ok(());
            for piece in batch.chunks(1 << 16) {
                result = out.write_all(piece);
                let mut state = self.lock();
                state.in_flight -= piece.len();
                if result.is_err() {
                    (state.has_failed, state.in_flight) = (true, 0);
                    state.ready = Vec::new();
                    state.count();
                }
                let has_room = state.ready.len() + state.in_flight <= limit / 2;
                // A failure is told in any case: the connection may wait for something else.
                if result.is_err() || (state.is_awaited && has_room) {
                    state.is_awaited = false;
                    drop(state);
                    on_room();
                }
                if result.is_err() {
                    break;
                }
            }
            result.and_then(|()| out.flush())?;
            batch.clear();
            let mut state = self.lock();
            let is_tight = state.held.as_ref().is_some_and(|held| held.budget().is_tight());
            batch.shrink_to(if is_tight { 0 } else { KEPT_BYTES });
            state.batch_room = batch.capacity();
            state.count();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn all_of_it_arrives_in_order_and_room_is_told_once() {
        let reply_queue = Arc::new(ReplyQueue::default());
        let mut whole = Vec::new();
        for i in 0..1000u32 {
            let mut piece = i.to_le_bytes().repeat(i as usize % 7);
            whole.extend_from_slice(&piece);
            reply_queue.put(&mut piece);
        }
        assert!(reply_queue.is_full(10));
        reply_queue.close();
        let (mut written, calls) = (Vec::new(), AtomicUsize::new(0));
        reply_queue.write_all_to(&mut written, 10, || _ = calls.fetch_add(1, Ordering::Relaxed)).unwrap();
        assert_eq!(written, whole);
        assert_eq!((calls.into_inner(), reply_queue.pending()), (1, 0));
    }

    struct Broken;

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::BrokenPipe.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_failure_is_told_though_nobody_waits_for_room() {
        let (reply_queue, calls) = (ReplyQueue::default(), AtomicUsize::new(0));
        reply_queue.put(&mut vec![1; 100]);
        let on_room = || _ = calls.fetch_add(1, Ordering::Relaxed);
        assert!(reply_queue.write_all_to(&mut Broken, 1000, on_room).is_err());
        assert_eq!((calls.into_inner(), reply_queue.has_failed()), (1, true));
    }

    #[test]
    fn a_writer_that_fails_leaves_nothing_waiting() {
        let reply_queue = ReplyQueue::default();
        reply_queue.put(&mut vec![1; 100]);
        assert!(reply_queue.is_full(50));
        assert!(reply_queue.write_all_to(&mut Broken, 50, || ()).is_err());
        reply_queue.put(&mut vec![1; 100]);
        assert!(!reply_queue.is_full(50) && reply_queue.has_failed());
        assert!(!reply_queue.wait_done(Instant::now()));
    }
}

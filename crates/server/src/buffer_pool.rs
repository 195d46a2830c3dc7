//! The pool of read buffers: a few for all sockets, so that the bytes in flight stay in the
//! processor's caches.
//!
//! Bytes are read into the buffer that was released last and are sent to the render thread in it.
//! If each connection had its own buffer, many connections would read into memory that was last
//! used a round ago. A buffer is held only for a short time: the render thread keeps it until the
//! connection's next slice. It copies out the bytes that are left then, those of a client that
//! waits for something, and all bytes while some connection has slow work. A stalled connection
//! holds no buffer.

use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Number of buffers: one that is run, one that each reader fills, and some for threads that wake
/// up late.
const POOLED_BUFFERS: usize = 6;
/// Size of a buffer in bytes. With smaller ones the thread switches cost more than the caches gain.
pub(crate) const POOLED_BUFFER_BYTES: usize = 256 << 10;

/// Buffers that stay allocated when a socket has ended: one to be filled, one to be run.
const KEPT: usize = 2;

/// A pool of read buffers.
pub(crate) struct BufferPool {
    state: Mutex<State>,
    is_back: Condvar,
    /// Number of readable sockets.
    ready: AtomicUsize,
}

struct State {
    /// Free buffers. The one released last, which is likeliest to be cached, is taken first.
    free: Vec<Vec<u8>>,
    /// Number of threads that wait for a buffer. Without it each release would be a system call.
    waiting: usize,
}

impl BufferPool {
    pub fn new() -> Self {
        BufferPool {
            state: Mutex::new(State { free: vec![Vec::new(); POOLED_BUFFERS], waiting: 0 }),
            is_back: Condvar::new(),
            ready: AtomicUsize::new(0),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Buffers are valid after a panic, too.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a buffer; blocks until one is free.
    pub fn acquire(self: &Arc<Self>) -> PooledBuffer {
        let mut state = self.lock();
        let buffer = loop {
            match state.free.pop() {
                Some(buffer) => break buffer,
                None => {
                    state.waiting += 1;
                    state = self.is_back.wait(state).unwrap_or_else(PoisonError::into_inner);
                    state.waiting -= 1;
                }
            }
        };
        drop(state);
        self.made(buffer)
    }

    /// Takes a buffer if one is free.
    pub fn try_acquire(self: &Arc<Self>) -> Option<PooledBuffer> {
        let buffer = self.lock().free.pop();
        buffer.map(|buffer| self.made(buffer))
    }

    fn made(self: &Arc<Self>, mut buffer: Vec<u8>) -> PooledBuffer {
        // Allocated when it is first used.
        buffer.resize(POOLED_BUFFER_BYTES, 0);
        PooledBuffer { buffers: self.clone(), buffer }
    }

    /// Frees the memory of buffers that only many sockets at once need. Called when a socket has
    /// ended, which is rare.
    pub fn trim(&self) {
        let free = &mut self.lock().free;
        let warm = free.len().saturating_sub(KEPT);
        for buffer in &mut free[..warm] {
            *buffer = Vec::new();
        }
    }

    /// Returns the number of sockets that were readable at the last poll.
    pub fn ready(&self) -> usize {
        self.ready.load(Ordering::Relaxed)
    }

    pub fn set_ready(&self, sockets: usize) {
        self.ready.store(sockets, Ordering::Relaxed);
    }
}

impl fmt::Debug for BufferPool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "BufferPool({} free)", self.lock().free.len())
    }
}

/// A buffer that returns to its pool when dropped.
pub(crate) struct PooledBuffer {
    buffers: Arc<BufferPool>,
    pub buffer: Vec<u8>,
}

impl Drop for PooledBuffer {
    fn drop(&mut self) {
        let mut state = self.buffers.lock();
        state.free.push(std::mem::take(&mut self.buffer));
        let is_awaited = state.waiting > 0;
        drop(state);
        if is_awaited {
            self.buffers.is_back.notify_one();
        }
    }
}

impl fmt::Debug for PooledBuffer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PooledBuffer({})", self.buffer.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn the_last_one_back_is_the_next_to_go_and_there_are_no_more_than_there_are() {
        let buffers = Arc::new(BufferPool::new());
        let mut held: Vec<_> = (0..POOLED_BUFFERS).map(|_| buffers.acquire()).collect();
        let (sender, order) = crossbeam_channel::unbounded();
        let too = buffers.clone();
        let thread = std::thread::spawn(move || sender.send(too.acquire()).unwrap());
        assert!(order.recv_timeout(Duration::from_millis(20)).is_err(), "all buffers are held");
        let last = held.pop().unwrap();
        let place = last.buffer.as_ptr();
        drop(last);
        assert_eq!(order.recv().unwrap().buffer.as_ptr(), place);
        thread.join().unwrap();
        let [a, b] = [held.pop().unwrap(), held.pop().unwrap()];
        let (_, second) = (drop(a), b.buffer.as_ptr());
        drop(b);
        assert_eq!(buffers.acquire().buffer.as_ptr(), second);
        drop(held);
        buffers.trim();
        let state = buffers.lock();
        assert_eq!(state.waiting, 0);
        assert_eq!(state.free.iter().map(Vec::capacity).collect::<Vec<_>>(), {
            [vec![0; POOLED_BUFFERS - KEPT], vec![POOLED_BUFFER_BYTES; KEPT]].concat()
        });
    }
}

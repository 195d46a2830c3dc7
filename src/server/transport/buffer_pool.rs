//! The pool of read buffers: few for all sockets, so that what is on its way stays in the
//! processor's caches.
//!
//! Bytes are read into the buffer that came back last and go to the render thread in it. With
//! buffers of their own many connections would read into memory that was last seen a round ago. A
//! buffer is held for a short time: the render thread keeps it until the connection's next slice
//! and copies out what is left then, what comes from a client that waits for something, and
//! everything while there is slow work about. A stalled connection holds no buffer.

use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Buffers on their way at a time: one that is run, one that each reader fills, and some for
/// threads that wake up late.
const POOLED_BUFFERS: usize = 6;
/// The size of one. Smaller ones cost more changes of threads than the caches give back.
pub(crate) const POOLED_BUFFER_BYTES: usize = 256 << 10;

/// Free buffers that are kept when a socket has ended: one to be filled, one to be run.
const KEPT: usize = 2;

/// Buffers to be had one by one.
pub(crate) struct BufferPool {
    /// The last one given back, the warmest, is the next to go.
    free: Mutex<Vec<Vec<u8>>>,
    is_back: Condvar,
    /// Sockets that could be read.
    ready: AtomicUsize,
}

impl BufferPool {
    pub fn new() -> Self {
        BufferPool {
            free: Mutex::new(vec![Vec::new(); POOLED_BUFFERS]),
            is_back: Condvar::new(),
            ready: AtomicUsize::new(0),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Vec<u8>>> {
        // Buffers are as good after a panic as before.
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a buffer.
    pub fn acquire(self: &Arc<Self>) -> PooledBuffer {
        let mut free = self.lock();
        let buffer = loop {
            match free.pop() {
                Some(buffer) => break buffer,
                None => free = self.is_back.wait(free).unwrap_or_else(PoisonError::into_inner),
            }
        };
        drop(free);
        self.made(buffer)
    }

    /// A buffer, if there is one.
    pub fn try_acquire(self: &Arc<Self>) -> Option<PooledBuffer> {
        let buffer = self.lock().pop();
        buffer.map(|buffer| self.made(buffer))
    }

    fn made(self: &Arc<Self>, mut buffer: Vec<u8>) -> PooledBuffer {
        // Made when it is first used.
        buffer.resize(POOLED_BUFFER_BYTES, 0);
        PooledBuffer { buffers: self.clone(), buffer }
    }

    /// Gives the system what only many sockets at once had use for. To be called where one has
    /// ended: seldom.
    pub fn trim(&self) {
        let mut free = self.lock();
        let warm = free.len().saturating_sub(KEPT);
        for buffer in &mut free[..warm] {
            *buffer = Vec::new();
        }
    }

    /// How many sockets could be read when it was last looked.
    pub fn ready(&self) -> usize {
        self.ready.load(Ordering::Relaxed)
    }

    pub fn set_ready(&self, sockets: usize) {
        self.ready.store(sockets, Ordering::Relaxed);
    }
}

impl fmt::Debug for BufferPool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "BufferPool({} free)", self.lock().len())
    }
}

/// A buffer, which goes back when this is dropped.
pub(crate) struct PooledBuffer {
    buffers: Arc<BufferPool>,
    pub buffer: Vec<u8>,
}

impl Drop for PooledBuffer {
    fn drop(&mut self) {
        self.buffers.lock().push(std::mem::take(&mut self.buffer));
        self.buffers.is_back.notify_one();
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
        let free = buffers.lock();
        assert_eq!(free.iter().map(Vec::capacity).collect::<Vec<_>>(), {
            [vec![0; POOLED_BUFFERS - KEPT], vec![POOLED_BUFFER_BYTES; KEPT]].concat()
        });
    }
}

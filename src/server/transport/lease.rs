//! LEASES: few read buffers for all sockets, so that what is on its way stays in the processor's
//! caches.
//!
//! Bytes are read into the buffer that came back last and go to the render thread in it. With
//! buffers of their own many connections would read into memory that was last seen a round ago. A
//! lease is short: the render thread keeps one until the connection's next turn and copies out what
//! is left then, what comes from a client that waits for something, and everything while there is
//! slow work about. So nobody who stalls or computes keeps a buffer from the others.

use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Buffers on their way at a time: one that is run, one that each reader fills, and some for
/// threads that wake up late.
const LEASES: usize = 6;
/// The size of one. Smaller ones cost more changes of threads than the caches give back.
pub(crate) const LEASE_BYTES: usize = 256 << 10;

/// Free buffers that are kept when a socket has ended: one to be filled, one to be run.
const KEPT: usize = 2;

/// Buffers to be had one by one.
pub(crate) struct Buffers {
    /// The last one given back, the warmest, is the next to go.
    free: Mutex<Vec<Vec<u8>>>,
    is_back: Condvar,
    /// Sockets that could be read.
    ready: AtomicUsize,
}

impl Buffers {
    pub fn new() -> Self {
        Buffers {
            free: Mutex::new(vec![Vec::new(); LEASES]),
            is_back: Condvar::new(),
            ready: AtomicUsize::new(0),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Vec<u8>>> {
        // Buffers are as good after a panic as before.
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a buffer.
    pub fn lease(self: &Arc<Self>) -> Lease {
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
    pub fn try_lease(self: &Arc<Self>) -> Option<Lease> {
        let buffer = self.lock().pop();
        buffer.map(|buffer| self.made(buffer))
    }

    fn made(self: &Arc<Self>, mut buffer: Vec<u8>) -> Lease {
        // Made when it is first used.
        buffer.resize(LEASE_BYTES, 0);
        Lease { buffers: self.clone(), buffer }
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

impl fmt::Debug for Buffers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Buffers({} free)", self.lock().len())
    }
}

/// A buffer, which goes back when this is dropped.
pub(crate) struct Lease {
    buffers: Arc<Buffers>,
    pub buffer: Vec<u8>,
}

impl Drop for Lease {
    fn drop(&mut self) {
        self.buffers.lock().push(std::mem::take(&mut self.buffer));
        self.buffers.is_back.notify_one();
    }
}

impl fmt::Debug for Lease {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Lease({})", self.buffer.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn the_last_one_back_is_the_next_to_go_and_there_are_no_more_than_there_are() {
        let buffers = Arc::new(Buffers::new());
        let mut held: Vec<_> = (0..LEASES).map(|_| buffers.lease()).collect();
        let (sender, order) = crossbeam_channel::unbounded();
        let too = buffers.clone();
        let thread = std::thread::spawn(move || sender.send(too.lease()).unwrap());
        assert!(order.recv_timeout(Duration::from_millis(20)).is_err(), "all leases are held");
        let last = held.pop().unwrap();
        let place = last.buffer.as_ptr();
        drop(last);
        assert_eq!(order.recv().unwrap().buffer.as_ptr(), place);
        thread.join().unwrap();
        let [a, b] = [held.pop().unwrap(), held.pop().unwrap()];
        let (_, second) = (drop(a), b.buffer.as_ptr());
        drop(b);
        assert_eq!(buffers.lease().buffer.as_ptr(), second);
        drop(held);
        buffers.trim();
        let free = buffers.lock();
        assert_eq!(free.iter().map(Vec::capacity).collect::<Vec<_>>(), {
            [vec![0; LEASES - KEPT], vec![LEASE_BYTES; KEPT]].concat()
        });
    }
}

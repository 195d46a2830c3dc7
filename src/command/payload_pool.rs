//! The buffers of large payloads, passed on from one command to the next: what clients that send whole frames would
//! otherwise ask of the system again for each of them, page by page.

use crate::memory::{MemoryBudget, MemoryUse, Reservation};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Buffers that are kept at most, and their bytes together, but for one that is larger by itself.
const KEPT: usize = 4;
const KEPT_BYTES: usize = 64 << 20;
/// How many times as large as needed one may be that is passed on.
const MOST_TIMES: usize = 4;

/// Few buffers, shared by the decoders that were made with it. Clones share.
#[derive(Clone, Debug)]
pub struct PayloadPool {
    held: Arc<Mutex<Held>>,
    budget: MemoryBudget,
}

#[derive(Debug)]
struct Held {
    /// Empty ones, the one given last at the end: it is the warmest.
    buffers: Vec<Vec<u8>>,
    /// Whether one was used since the last sweep.
    used: bool,
    /// What they hold of the budget.
    reserved: Reservation,
}

impl Default for PayloadPool {
    fn default() -> Self {
        PayloadPool::within(&MemoryBudget::unlimited())
    }
}

impl Held {
    fn bytes(&self) -> usize {
        self.buffers.iter().map(Vec::capacity).sum()
    }

    fn count(&mut self) {
        let bytes = self.bytes() as u64;
        self.reserved.set(bytes);
    }
}

impl PayloadPool {
    /// No buffer yet. Payloads of the decoders that are made with it, and buffers that are kept, are of `budget`.
    pub fn within(budget: &MemoryBudget) -> Self {
        let reserved = budget.empty(MemoryUse::Payloads);
        let held = Held { buffers: Vec::new(), used: false, reserved };
        PayloadPool { held: Arc::new(Mutex::new(held)), budget: budget.clone() }
    }

    /// What payloads are of.
    pub fn budget(&self) -> &MemoryBudget {
        &self.budget
    }

    /// Gives all buffers back.
    pub fn clear(&self) {
        let mut held = self.held();
        held.buffers = Vec::new();
        held.count();
    }

    /// Bytes held for large payloads to come.
    pub fn held_bytes(&self) -> usize {
        self.held().bytes()
    }

    /// Gives back what is held, if nobody used it since the last sweep. To be called from time to time.
    pub fn sweep(&self) {
        let mut held = self.held();
        if !std::mem::take(&mut held.used) {
            held.buffers = Vec::new();
            held.count();
        }
    }

    /// An empty buffer with room for `length` bytes, if one is held that is not far too large: it may wait long for its bytes.
    pub(super) fn take(&self, length: usize) -> Option<Vec<u8>> {
        let mut held = self.held();
        held.used = true;
        let fits = length..=length.saturating_mul(MOST_TIMES);
        let place = held.buffers.iter().rposition(|b| fits.contains(&b.capacity()))?;
        let buffer = held.buffers.remove(place);
        held.count();
        Some(buffer)
    }

    /// Takes back an empty buffer. Where they are too many the smallest goes.
    pub(super) fn give(&self, buffer: Vec<u8>) {
        if self.budget.is_tight() || self.budget.available() < buffer.capacity() as u64 {
            return;
        }
        let mut held = self.held();
        held.used = true;
        held.buffers.push(buffer);
        while held.buffers.len() > KEPT || (held.buffers.len() > 1 && held.bytes() > KEPT_BYTES) {
            let smallest = (0..held.buffers.len()).min_by_key(|&i| held.buffers[i].capacity()).unwrap_or(0);
            held.buffers.remove(smallest);
        }
        held.count();
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        // A buffer is as good after a panic as before.
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_stay_until_nobody_used_them() {
        let pool = PayloadPool::default();
        pool.give(Vec::with_capacity(1000));
        pool.give(Vec::with_capacity(10));
        assert!(pool.held_bytes() >= 1010);
        pool.sweep();
        assert!(pool.held_bytes() >= 1010, "they were used before the first sweep");
        assert!(pool.take(2000).is_none());
        assert!(pool.take(200).is_none(), "it would hold five times as much as is needed");
        let buffer = pool.take(500).unwrap();
        assert!(buffer.capacity() >= 1000 && pool.held_bytes() < 1000);
        pool.clone().give(buffer);
        pool.sweep();
        pool.sweep();
        assert_eq!(pool.held_bytes(), 0);
    }

    #[test]
    fn where_they_are_too_many_the_largest_stay() {
        let pool = PayloadPool::default();
        for capacity in [100, 7, 300, 200, 400, 50] {
            pool.give(Vec::with_capacity(capacity));
        }
        assert!((1000..1050).contains(&pool.held_bytes()), "{}", pool.held_bytes());
        pool.give(Vec::with_capacity(KEPT_BYTES + 1));
        assert_eq!(pool.held_bytes(), KEPT_BYTES + 1);
    }
}

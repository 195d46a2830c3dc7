//! Pool of buffers for large payloads, reused from one command to the next. Clients that send whole
//! frames would otherwise make the system map fresh pages for each of them.

use fbptr_core::memory::{MemoryBudget, MemoryUse, Reservation};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most buffers kept, and most bytes of them in total; a single buffer may be larger.
const KEPT: usize = 4;
const KEPT_BYTES: usize = 64 << 20;
/// Largest ratio of a reused buffer's capacity to the length needed.
const MOST_TIMES: usize = 4;

/// A few buffers shared by the decoders that were created with the pool. Clones share the same
/// buffers.
#[derive(Clone, Debug)]
pub struct PayloadPool {
    held: Arc<Mutex<Held>>,
    budget: MemoryBudget,
}

/// Buffers of a pool and their reservation.
#[derive(Debug)]
struct Held {
    /// Empty buffers, the last one returned at the end: it is most likely in the caches.
    buffers: Vec<Vec<u8>>,
    /// Set when a buffer was taken or returned since the last sweep.
    used: bool,
    /// Reservation of the budget for all buffers here.
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

    /// Sets the reservation to the capacity of all buffers.
    fn count(&mut self) {
        let bytes = self.bytes() as u64;
        self.reserved.set(bytes);
    }
}

impl PayloadPool {
    /// Creates an empty pool. Payloads of the decoders that use it, and the buffers kept here, are
    /// counted in `budget`.
    pub fn within(budget: &MemoryBudget) -> Self {
        let reserved = budget.empty(MemoryUse::Payloads);
        let held = Held { buffers: Vec::new(), used: false, reserved };
        PayloadPool { held: Arc::new(Mutex::new(held)), budget: budget.clone() }
    }

    /// Returns the memory budget that payloads are counted in.
    pub fn budget(&self) -> &MemoryBudget {
        &self.budget
    }

    /// Frees all buffers.
    pub fn clear(&self) {
        let mut held = self.held();
        held.buffers = Vec::new();
        held.count();
    }

    /// Returns the total capacity of the kept buffers in bytes.
    pub fn held_bytes(&self) -> usize {
        self.held().bytes()
    }

    /// Frees all buffers if the pool was not used since the last sweep. To be called periodically.
    pub fn sweep(&self) {
        let mut held = self.held();
        if !std::mem::take(&mut held.used) {
            held.buffers = Vec::new();
            held.count();
        }
    }

    /// Takes an empty buffer of at least `length` bytes, if one is kept that is not much too large:
    /// its payload may be slow to arrive.
    pub(super) fn take(&self, length: usize) -> Option<Vec<u8>> {
        let mut held = self.held();
        held.used = true;
        let fits = length..=length.saturating_mul(MOST_TIMES);
        let place = held.buffers.iter().rposition(|b| fits.contains(&b.capacity()))?;
        let buffer = held.buffers.remove(place);
        held.count();
        Some(buffer)
    }

    /// Returns an empty buffer to the pool, or frees it if memory is short. If there are too many,
    /// the smallest are freed.
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
        // Empty buffers stay valid after a panic, so a poisoned lock is harmless.
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

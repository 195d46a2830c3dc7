//! A large payload's buffer, passed on from one command to the next: what a client that sends whole frames would
//! otherwise ask of the system again for each of them, page by page.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// One buffer at most, shared by the decoders that were made with it. Clones share.
#[derive(Clone, Debug, Default)]
pub struct SparePayload(Arc<Mutex<Held>>);

#[derive(Debug, Default)]
struct Held {
    buffer: Vec<u8>,
    /// Whether it was used since the last sweep.
    used: bool,
}

impl SparePayload {
    /// Bytes held for the next large payload.
    pub fn held_bytes(&self) -> usize {
        self.held().buffer.capacity()
    }

    /// Gives back what is held, if nobody used it since the last sweep. To be called from time to time.
    pub fn sweep(&self) {
        let mut held = self.held();
        if !std::mem::take(&mut held.used) {
            held.buffer = Vec::new();
        }
    }

    /// Exchanges `buffer`, which is empty, for the one held if that is larger.
    pub(super) fn swap_for_larger(&self, buffer: &mut Vec<u8>) {
        let mut held = self.held();
        held.used = true;
        if held.buffer.capacity() > buffer.capacity() {
            std::mem::swap(&mut held.buffer, buffer);
        }
    }

    /// Takes back an empty buffer; the larger one is kept.
    pub(super) fn give(&self, buffer: Vec<u8>) {
        let mut held = self.held();
        held.used = true;
        if held.buffer.capacity() < buffer.capacity() {
            held.buffer = buffer;
        }
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        // A buffer is as good after a panic as before.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_stays_until_nobody_used_it() {
        let spare = SparePayload::default();
        spare.give(Vec::with_capacity(1000));
        spare.give(Vec::with_capacity(10));
        assert!(spare.held_bytes() >= 1000);
        spare.sweep();
        assert!(spare.held_bytes() >= 1000, "it was used before the first sweep");
        let mut buffer = Vec::new();
        spare.swap_for_larger(&mut buffer);
        assert!(buffer.capacity() >= 1000 && spare.held_bytes() == 0);
        spare.clone().give(buffer);
        spare.sweep();
        spare.sweep();
        assert_eq!(spare.held_bytes(), 0);
    }
}

//! The limits of an engine: quotas, the memory budget, and what the engine holds of it for replies
//! and received bytes.
//!
//! In: sizes of what connections want to hold. Out: room, or refusals with figures.

use crate::Limits;
use crate::clock::Instant;
use fbptr_command::PayloadPool;
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::{MemoryBudget, MemoryUse, Reservation};
use std::time::Duration;

/// Reply bytes that are always allowed for a connection that reads its replies.
const REPLY_BYTES: usize = 16 << 10;
/// Smallest change of the queued bytes that is reserved, in bytes.
const QUEUE_STEP: u64 = 64 << 10;
/// Time for which an unused payload buffer is kept for the next large payload.
const HOLD_PAYLOADS: Duration = Duration::from_secs(1);

/// Quotas, and the memory that they are taken from.
#[derive(Debug)]
pub struct Quotas {
    pub(super) limits: Limits,
    pub(super) budget: MemoryBudget,
    /// Reservation for the reply of the running command.
    pub(super) reply: Reservation,
    /// Reservation for received bytes that have not run.
    queue: Reservation,
    /// Pool of large payloads' buffers, which the decoders of all connections share.
    pub(super) payload_pool: PayloadPool,
    payload_pool_swept: Instant,
}

impl Quotas {
    pub(super) fn new(limits: Limits) -> Self {
        let budget = MemoryBudget::new(limits.memory_bytes);
        Quotas {
            limits,
            reply: budget.empty(MemoryUse::Replies),
            queue: budget.empty(MemoryUse::Payloads),
            payload_pool: PayloadPool::within(&budget),
            payload_pool_swept: Instant::now(),
            budget,
        }
    }

    /// Returns the pool of payload buffers, which all decoders share.
    pub fn payload_pool(&self) -> &PayloadPool {
        &self.payload_pool
    }

    /// Frees payload buffers that have not been used for a second. Returns the time of the next
    /// sweep, if one is needed.
    pub fn sweep_payload_pool(&mut self, now: Instant) -> Option<Instant> {
        if now >= self.payload_pool_swept + HOLD_PAYLOADS {
            self.payload_pool.sweep();
            self.payload_pool_swept = now;
        }
        (self.payload_pool.held_bytes() > 0).then(|| self.payload_pool_swept + HOLD_PAYLOADS)
    }

    /// Returns the number of reply bytes that a connection with `unread` unread bytes may be given.
    /// If memory is short, only connections wait whose clients do not read.
    pub fn reply_room(&self, unread: usize) -> usize {
        let part = usize::try_from(self.budget.available() / 4).unwrap_or(usize::MAX);
        match unread {
            0 => part.max(REPLY_BYTES),
            _ => part,
        }
    }

    /// Reserves memory for the `bytes` of received commands that have not run.
    pub fn count_queue(&mut self, bytes: u64) {
        // Changes of less than [`QUEUE_STEP`] are not worth a reservation.
        if self.queue.bytes().abs_diff(bytes) >= QUEUE_STEP || bytes == 0 {
            self.queue.set(bytes);
        }
    }

    /// Refuses a reply that is too long.
    #[inline]
    pub(super) fn check_reply_length(&self, bytes: u64) -> Result<(), Fault> {
        let limit = self.limits.reply_bytes;
        match bytes <= limit as u64 {
            true => Ok(()),
            false => {
                let message = format!("a reply has at most {limit} bytes here, and this one has {bytes}");
                Err(Fault::new(Code::Quota, message))
            }
        }
    }
}

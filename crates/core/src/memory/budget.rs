//! Memory budget: one limit on all memory that clients can make the process hold.
//!
//! In: reservations for one use each, made before the memory is allocated. Out: a [`Reservation`]
//! that returns its bytes when it is dropped, or [`OverBudget`] with the figures. Runs on any
//! thread: the counters are atomic, and a reservation is one compare-and-exchange on their sum.
//!
//! Promise: [`MemoryBudget::try_reserve`] never grants bytes beyond the limit. [`Reservation::set`]
//! counts bytes that exist already, which may exceed the limit and makes later requests fail.
//! Checked by `STATS`, which prints every counter, and by tests that count the allocator's bytes.

use crate::error::{Code, Fault};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// A purpose of memory with a counter of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MemoryUse {
    /// The frame, its depth and pick buffers, and the copies that a display shows.
    Frame,
    /// Named meshes, textures and scenes, and the tables that the renderer caches for them.
    Resources,
    /// Decoders' tables and buffers, while a file is read.
    Decoders,
    /// Working memory of draws, some of it kept between draws.
    Draws,
    /// Replies that clients have not read.
    Replies,
    /// Recorded commands that have not been written to their file.
    Records,
    /// Payloads that have not arrived in full, and received bytes that have not been run.
    Payloads,
}

impl MemoryUse {
    /// All uses, in the order of `STATS`.
    pub const ALL: [MemoryUse; 7] = [
        MemoryUse::Frame,
        MemoryUse::Resources,
        MemoryUse::Decoders,
        MemoryUse::Draws,
        MemoryUse::Replies,
        MemoryUse::Records,
        MemoryUse::Payloads,
    ];

    /// Returns the use's name in `STATS` and in messages.
    pub const fn as_str(self) -> &'static str {
        match self {
            MemoryUse::Frame => "frame",
            MemoryUse::Resources => "resources",
            MemoryUse::Decoders => "decoders",
            MemoryUse::Draws => "draws",
            MemoryUse::Replies => "replies",
            MemoryUse::Records => "records",
            MemoryUse::Payloads => "payloads",
        }
    }
}

/// Error of a refused reservation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OverBudget {
    /// Use of the refused request.
    pub purpose: MemoryUse,
    /// Size of the refused request in bytes.
    pub needed: u64,
    /// Bytes in use by all purposes.
    pub used: u64,
    /// Limit on the sum of all uses, in bytes.
    pub limit: u64,
}

impl fmt::Display for OverBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let OverBudget { purpose, needed, used, limit } = self;
        write!(f, "{needed} bytes more of memory for {} are needed, ", purpose.as_str())?;
        write!(f, "and {used} of the {limit} bytes that there may be are in use")
    }
}

impl std::error::Error for OverBudget {}

impl OverBudget {
    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        Code::Quota
    }
}

impl From<OverBudget> for Fault {
    fn from(e: OverBudget) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

#[derive(Debug)]
struct Counters {
    limit: u64,
    total: AtomicU64,
    uses: [AtomicU64; MemoryUse::ALL.len()],
}

/// Limit on memory with counters of its use. Clones share the counters.
#[derive(Clone)]
pub struct MemoryBudget(Arc<Counters>);

impl MemoryBudget {
    /// Creates a budget of `limit` bytes, all of them free.
    pub fn new(limit: u64) -> Self {
        MemoryBudget(Arc::new(Counters { limit, total: AtomicU64::new(0), uses: Default::default() }))
    }

    /// Creates a budget that counts and never refuses.
    pub fn unlimited() -> Self {
        MemoryBudget::new(u64::MAX)
    }

    /// Returns the limit in bytes.
    pub fn limit(&self) -> u64 {
        self.0.limit
    }

    /// Returns the bytes in use for `purpose`.
    pub fn used_for(&self, purpose: MemoryUse) -> u64 {
        self.0.uses[purpose as usize].load(Relaxed)
    }

    /// Returns the bytes in use by all purposes.
    pub fn used(&self) -> u64 {
        self.0.total.load(Relaxed)
    }

    /// Returns the free bytes; zero if the use exceeds the limit.
    pub fn available(&self) -> u64 {
        self.0.limit.saturating_sub(self.used())
    }

    /// Returns whether less than a quarter of the limit is free. Memory that only saves time should
    /// then be released.
    pub fn is_tight(&self) -> bool {
        self.available() < self.limit() / 4
    }

    /// Creates a reservation of zero bytes that can grow.
    pub fn empty(&self, purpose: MemoryUse) -> Reservation {
        Reservation { budget: self.clone(), purpose, bytes: 0 }
    }

    /// Reserves `bytes`.
    ///
    /// # Errors
    /// If fewer bytes are free.
    pub fn try_reserve(&self, purpose: MemoryUse, bytes: u64) -> Result<Reservation, OverBudget> {
        let mut reservation = self.empty(purpose);
        reservation.try_grow(bytes)?;
        Ok(reservation)
    }

    /// Reserves `bytes`, or all free bytes if they are fewer.
    pub fn reserve_up_to(&self, purpose: MemoryUse, bytes: u64) -> Reservation {
        let mut reservation = self.empty(purpose);
        // The free bytes may shrink between the query and the attempt.
        while reservation.try_grow(bytes.min(self.available())).is_err() {}
        reservation
    }

    fn add(&self, purpose: MemoryUse, bytes: u64) -> Result<(), OverBudget> {
        let Counters { limit, total, uses } = &*self.0;
        let fits = |used: u64| used.checked_add(bytes).filter(|sum| bytes == 0 || sum <= limit);
        match total.fetch_update(Relaxed, Relaxed, fits) {
            Ok(_) => {
                uses[purpose as usize].fetch_add(bytes, Relaxed);
                Ok(())
            }
            Err(used) => Err(OverBudget { purpose, needed: bytes, used, limit: *limit }),
        }
    }

    fn remove(&self, purpose: MemoryUse, bytes: u64) {
        self.0.total.fetch_sub(bytes, Relaxed);
        self.0.uses[purpose as usize].fetch_sub(bytes, Relaxed);
    }
}

impl Default for MemoryBudget {
    fn default() -> Self {
        MemoryBudget::unlimited()
    }
}

impl fmt::Debug for MemoryBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MemoryBudget({} of {} bytes)", self.used(), self.limit())
    }
}

/// Reserved bytes of a budget, returned on drop.
#[derive(Debug)]
pub struct Reservation {
    budget: MemoryBudget,
    purpose: MemoryUse,
    bytes: u64,
}

impl Reservation {
    /// Returns the number of reserved bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Returns the budget of this reservation.
    pub fn budget(&self) -> &MemoryBudget {
        &self.budget
    }

    /// Reserves `more` bytes in addition.
    ///
    /// # Errors
    /// If fewer bytes are free; the reservation is then unchanged.
    pub fn try_grow(&mut self, more: u64) -> Result<(), OverBudget> {
        self.budget.add(self.purpose, more)?;
        self.bytes += more;
        Ok(())
    }

    /// Grows the reservation to at least `bytes` bytes; never shrinks it.
    ///
    /// # Errors
    /// If fewer bytes are free than it lacks; the reservation is then unchanged.
    #[inline]
    pub fn try_cover(&mut self, bytes: u64) -> Result<(), OverBudget> {
        match bytes.checked_sub(self.bytes) {
            None | Some(0) => Ok(()),
            Some(more) => self.try_grow(more),
        }
    }

    /// Returns all but `bytes` bytes to the budget.
    pub fn shrink_to(&mut self, bytes: u64) {
        if let Some(fewer @ 1..) = self.bytes.checked_sub(bytes) {
            self.budget.remove(self.purpose, fewer);
            self.bytes = bytes;
        }
    }

    /// Sets the reservation to `bytes` bytes that are already allocated, even beyond the limit.
    /// While the limit is exceeded, other requests are refused.
    pub fn set(&mut self, bytes: u64) {
        if let Some(more @ 1..) = bytes.checked_sub(self.bytes) {
            let Counters { total, uses, .. } = &*self.budget.0;
            total.fetch_add(more, Relaxed);
            uses[self.purpose as usize].fetch_add(more, Relaxed);
            self.bytes = bytes;
        } else {
            self.shrink_to(bytes);
        }
    }

    /// Moves the bytes to the counter of `purpose`.
    pub fn change_use(&mut self, purpose: MemoryUse) {
        let uses = &self.budget.0.uses;
        uses[purpose as usize].fetch_add(self.bytes, Relaxed);
        uses[self.purpose as usize].fetch_sub(self.bytes, Relaxed);
        self.purpose = purpose;
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        self.shrink_to(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_tight_when_less_than_a_quarter_is_free() {
        let budget = MemoryBudget::new(100);
        assert!(!budget.is_tight());
        let held = budget.try_reserve(MemoryUse::Draws, 75).unwrap();
        assert!(!budget.is_tight());
        let more = budget.try_reserve(MemoryUse::Decoders, 1).unwrap();
        assert!(budget.is_tight());
        drop(more);
        assert!(!budget.is_tight());
        drop(held);
    }

    #[test]
    fn a_budget_grants_what_is_free_and_names_the_figures_when_it_refuses() {
        let budget = MemoryBudget::new(100);
        let mut a = budget.try_reserve(MemoryUse::Draws, 60).unwrap();
        let refused = budget.try_reserve(MemoryUse::Decoders, 41).unwrap_err();
        assert_eq!(refused, OverBudget { purpose: MemoryUse::Decoders, needed: 41, used: 60, limit: 100 });
        assert_eq!(
            Fault::from(refused).to_string(),
            "EQUOTA 41 bytes more of memory for decoders are needed, and 60 of the 100 bytes that there may be \
             are in use"
        );
        let mut b = budget.try_reserve(MemoryUse::Decoders, 40).unwrap();
        assert_eq!((budget.used(), budget.available()), (100, 0));
        assert!(a.try_cover(60).is_ok() && a.try_cover(61).is_err() && a.bytes() == 60);
        b.shrink_to(10);
        b.change_use(MemoryUse::Resources);
        assert_eq!((budget.used_for(MemoryUse::Decoders), budget.used_for(MemoryUse::Resources)), (0, 10));
        assert_eq!(budget.reserve_up_to(MemoryUse::Payloads, 1000).bytes(), 30);
        drop((a, b));
        assert_eq!(budget.used(), 0);
        assert!(budget.try_reserve(MemoryUse::Draws, u64::MAX).is_err());
    }

    #[test]
    fn what_exists_is_counted_even_over_the_limit_and_refuses_others() {
        let budget = MemoryBudget::new(100);
        let mut replies = budget.empty(MemoryUse::Replies);
        replies.set(150);
        assert_eq!((budget.used(), budget.available()), (150, 0));
        assert!(budget.try_reserve(MemoryUse::Draws, 1).is_err());
        assert!(budget.try_reserve(MemoryUse::Draws, 0).is_ok(), "nothing always fits");
        replies.set(20);
        assert_eq!(budget.used(), 20);
    }

    #[test]
    fn many_threads_together_never_hold_more_than_the_limit() {
        let budget = MemoryBudget::new(1000);
        let granted = std::thread::scope(|scope| {
            let ask = || {
                let one = |i: u64| budget.try_reserve(MemoryUse::Decoders, i % 37).ok();
                let held: Vec<_> = (0..200).filter_map(one).collect();
                assert!(budget.used() <= 1000);
                held
            };
            let threads: Vec<_> = (0..8).map(|_| scope.spawn(ask)).collect();
            threads.into_iter().flat_map(|t| t.join().unwrap()).collect::<Vec<_>>()
        });
        let sum: u64 = granted.iter().map(Reservation::bytes).sum();
        assert!(sum <= 1000 && sum == budget.used() && sum > 900, "{sum}");
        drop(granted);
        assert_eq!(budget.used(), 0);
    }
}

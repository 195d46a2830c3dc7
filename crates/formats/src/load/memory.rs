//! Limits of one load: working memory from a budget, the size of the result, and a token that
//! cancels the load.
//!
//! In: estimates, made before memory is allocated: of a text by counts of its words, of a picture
//! by its header. Out: an error with figures, or reservations. Working memory is released when a
//! parser ends; the reservation of the result lives as long as the result. May be used on any
//! thread. Wrong estimates are found by tests/allocations/decoder_memory.rs, which counts allocated
//! bytes.

use super::LoadErrorKind;
use fbptr_core::cancel::CancelToken;
use fbptr_core::memory::{MemoryBudget, MemoryUse, Reservation};

/// Memory limits for loading one file and the files it refers to.
#[derive(Debug)]
pub struct LoadMemory {
    kept: Reservation,
    most_kept: u64,
    cancel: CancelToken,
}

impl LoadMemory {
    /// Creates limits: working memory from `budget`, and a result of at most `most_kept` bytes,
    /// which are counted in the budget as well.
    pub fn new(budget: &MemoryBudget, most_kept: u64) -> Self {
        LoadMemory { kept: budget.empty(MemoryUse::Resources), most_kept, cancel: CancelToken::default() }
    }

    /// Creates limits that no load reaches; the parsers' own limits apply.
    pub fn unlimited() -> Self {
        LoadMemory::new(&MemoryBudget::unlimited(), u64::MAX)
    }

    /// Returns these limits with `cancel` as the token: once it is cancelled, reading ends soon
    /// with [`LoadErrorKind::Cancelled`]. The token is checked wherever memory is reserved, and
    /// within long texts and pictures.
    pub fn until(self, cancel: CancelToken) -> Self {
        LoadMemory { cancel, ..self }
    }

    /// Returns the token that cancels the load.
    pub(super) fn cancel(&self) -> &CancelToken {
        &self.cancel
    }

    /// Returns an error if the load was cancelled.
    ///
    /// # Errors
    /// [`LoadErrorKind::Cancelled`].
    pub fn check_cancelled(&self) -> Result<(), LoadErrorKind> {
        match self.cancel.is_cancelled() {
            true => Err(LoadErrorKind::Cancelled),
            false => Ok(()),
        }
    }

    /// Reserves `bytes` of working memory until the reservation is dropped.
    ///
    /// # Errors
    /// If the budget has no room, or reading was cancelled.
    pub fn work(&self, bytes: u64) -> Result<Reservation, LoadErrorKind> {
        self.check_cancelled()?;
        self.kept.budget().try_reserve(MemoryUse::Decoders, bytes).map_err(LoadErrorKind::OverBudget)
    }

    /// Reserves `bytes` more for the result.
    ///
    /// # Errors
    /// If the result would be over its limit, the budget has no room, or reading was cancelled;
    /// nothing is reserved then.
    pub fn reserve_result(&mut self, bytes: u64) -> Result<(), LoadErrorKind> {
        self.check_cancelled()?;
        let found = self.kept.bytes().saturating_add(bytes);
        if found > self.most_kept {
            return Err(LoadErrorKind::OverQuota { found, limit: self.most_kept });
        }
        self.kept.try_grow(bytes).map_err(LoadErrorKind::OverBudget)
    }

    /// Returns the bytes reserved for the result so far.
    pub fn kept_bytes(&self) -> u64 {
        self.kept.bytes()
    }

    /// Returns the memory budget.
    pub fn budget(&self) -> &MemoryBudget {
        self.kept.budget()
    }

    /// Returns the reservation of the result, to be held as long as the result.
    pub fn into_kept(self) -> Reservation {
        self.kept
    }
}

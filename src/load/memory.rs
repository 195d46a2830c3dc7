//! Limits of reading a file: working memory of a budget, the size of the result, and a token that
//! cancels the reading.
//!
//! In: estimates, made before the memory is taken: of a text by what is counted in it, of a picture by its header. Out: a
//! refusal with figures, or reservations. The working part goes when a parser ends; the kept part lives as long as what was read.
//! May be used on any thread. One would know a wrong estimate by tests/allocations/decoder_memory.rs, which counts what is allocated.

use super::LoadErrorKind;
use crate::cancel::CancelToken;
use crate::memory::{MemoryBudget, MemoryUse, Reservation};

/// The memory that reading one file, with the files that it refers to, may take.
#[derive(Debug)]
pub struct LoadMemory {
    kept: Reservation,
    most_kept: u64,
    cancel: CancelToken,
}

impl LoadMemory {
    /// Working memory of `budget`, and a result of at most `most_kept` bytes, which are of the budget as well.
    pub fn new(budget: &MemoryBudget, most_kept: u64) -> Self {
        LoadMemory { kept: budget.empty(MemoryUse::Resources), most_kept, cancel: CancelToken::default() }
    }

    /// As much as the parsers' own limits allow.
    pub fn unlimited() -> Self {
        LoadMemory::new(&MemoryBudget::unlimited(), u64::MAX)
    }

    /// Returns these limits with `cancel` as the token: once it is cancelled, reading ends soon
    /// with [`LoadErrorKind::Cancelled`]. The token is checked wherever memory is reserved, and
    /// within long texts and pictures.
    pub fn until(self, cancel: CancelToken) -> Self {
        LoadMemory { cancel, ..self }
    }

    /// The token by which reading is ended.
    pub(super) fn cancel(&self) -> &CancelToken {
        &self.cancel
    }

    /// Refuses to go on when reading was cancelled.
    ///
    /// # Errors
    /// [`LoadErrorKind::Cancelled`].
    pub fn check_cancelled(&self) -> Result<(), LoadErrorKind> {
        match self.cancel.is_cancelled() {
            true => Err(LoadErrorKind::Cancelled),
            false => Ok(()),
        }
    }

    /// Reserves `bytes` that are in use until the reservation is dropped.
    ///
    /// # Errors
    /// When the budget has no room, or reading was cancelled.
    pub fn work(&self, bytes: u64) -> Result<Reservation, LoadErrorKind> {
        self.check_cancelled()?;
        self.kept.budget().try_reserve(MemoryUse::Decoders, bytes).map_err(LoadErrorKind::OverBudget)
    }

    /// Reserves `bytes` more for the result.
    ///
    /// # Errors
    /// When the result would be over its limit, the budget has no room, or reading was cancelled;
    /// nothing is reserved then.
    pub fn reserve_result(&mut self, bytes: u64) -> Result<(), LoadErrorKind> {
        self.check_cancelled()?;
        let found = self.kept.bytes().saturating_add(bytes);
        if found > self.most_kept {
            return Err(LoadErrorKind::OverQuota { found, limit: self.most_kept });
        }
        self.kept.try_grow(bytes).map_err(LoadErrorKind::OverBudget)
    }

    /// Bytes of the result so far.
    pub fn kept_bytes(&self) -> u64 {
        self.kept.bytes()
    }

    /// The budget.
    pub fn budget(&self) -> &MemoryBudget {
        self.kept.budget()
    }

    /// What is reserved for the result, to be held as long as the result is.
    pub fn into_kept(self) -> Reservation {
        self.kept
    }
}

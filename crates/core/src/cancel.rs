//! Cooperative cancellation: a flag that long work polls, so that another thread can end it.
//!
//! In: [`CancelToken::cancel`], from any thread. Out: [`CancelToken::is_cancelled`], a relaxed
//! load, which is called once per chunk of work (some microseconds) and never once per pixel.
//! Cancelled work returns early and its partial result is not used; the caller that cancels reports
//! it. A token is never reset: new work gets a new one.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A cancellation flag shared by its clones. [`CancelToken::default`] can never be cancelled.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Option<Arc<AtomicBool>>);

/// A token that is never cancelled.
pub static NEVER: CancelToken = CancelToken(None);

impl CancelToken {
    /// Creates a token that can be cancelled.
    pub fn new() -> Self {
        CancelToken(Some(Arc::default()))
    }

    /// Asks all work that holds this token, or a clone of it, to end. Does nothing on the default
    /// token.
    pub fn cancel(&self) {
        if let Some(flag) = &self.0 {
            flag.store(true, Ordering::Relaxed);
        }
    }

    /// Returns whether the work has been asked to end.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.0.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_are_cancelled_together_and_the_default_never() {
        let (token, never) = (CancelToken::new(), CancelToken::default());
        let clone = token.clone();
        assert!(!token.is_cancelled());
        clone.cancel();
        never.cancel();
        assert_eq!([token, clone, never].map(|t| t.is_cancelled()), [true, true, false]);
    }
}

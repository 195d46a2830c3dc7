//! CANCELLATION: a flag that long work looks at, so that somebody else can end it.
//!
//! In: [`CancelToken::cancel`], from any thread. Out: [`CancelToken::is_cancelled`], a relaxed load, asked once a chunk of
//! work (some microseconds) and never once a pixel. Cancelled work returns early; what it has made by then is of no
//! further use, and whoever cancelled says so. A token is never reset: new work gets a new one.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag shared by those who work and those who may end the work; [`CancelToken::default`] is one that nobody can set.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Option<Arc<AtomicBool>>);

/// The token that nobody can set.
pub static NEVER: CancelToken = CancelToken(None);

impl CancelToken {
    /// A token that can be cancelled.
    pub fn new() -> Self {
        CancelToken(Some(Arc::default()))
    }

    /// Asks all work that holds this token, or a clone of it, to end. Nothing happens for the default token.
    pub fn cancel(&self) {
        if let Some(flag) = &self.0 {
            flag.store(true, Ordering::Relaxed);
        }
    }

    /// Whether the work is to end.
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

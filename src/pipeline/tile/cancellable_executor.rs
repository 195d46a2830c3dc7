//! Executor of a renderer: a pool or the calling thread, with a token that cancels the work.
//!
//! Work is split into pieces. Once the token is cancelled no piece starts: the output is then
//! incomplete, and the caller checks [`CancellableExecutor::is_cancelled`] before reading it.

use crate::cancel::CancelToken;
use rayon::prelude::*;
use std::sync::Arc;

/// Runs pieces of work, each once, in any order, possibly in parallel, until it is cancelled.
#[derive(Clone, Debug, Default)]
pub struct CancellableExecutor {
    /// Threads shared between renderers; `None` for the calling thread.
    pool: Option<Arc<rayon::ThreadPool>>,
    cancel: CancelToken,
}

impl CancellableExecutor {
    /// Creates an executor on the threads of `pool`, or on the calling thread.
    pub fn new(pool: Option<Arc<rayon::ThreadPool>>, cancel: CancelToken) -> Self {
        CancellableExecutor { pool, cancel }
    }

    /// Returns an executor on the calling thread, with this one's token.
    pub fn serial(&self) -> Self {
        CancellableExecutor { pool: None, cancel: self.cancel.clone() }
    }

    /// Returns the pool; `None` if the calling thread does the work.
    pub fn pool(&self) -> Option<&Arc<rayon::ThreadPool>> {
        self.pool.as_ref()
    }

    /// Returns the token that cancels the work.
    pub fn cancel(&self) -> &CancelToken {
        &self.cancel
    }

    /// Returns whether the work is cancelled: pieces may have been skipped.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    /// Runs `work` on a thread of the pool, so that submitting its pieces does not have to wake it.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            None => work(),
            Some(pool) => pool.install(work),
        }
    }

    /// Calls `work` with the index and the items of each run of `size` items (the last may be
    /// shorter).
    ///
    /// Must be called inside [`CancellableExecutor::run`].
    pub fn chunks<T: Send>(&self, items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
        let work = |(i, run): (usize, &mut [T])| {
            if !self.is_cancelled() {
                work(i, run);
            }
        };
        match self.pool {
            Some(_) if items.len() > size => {
                items.par_chunks_mut(size).with_max_len(1).enumerate().for_each(work);
            }
            _ => items.chunks_mut(size).enumerate().for_each(work),
        }
    }

    /// Like [`chunks`](Self::chunks), with runs of two slices of equal length.
    pub fn pairs<T: Send>(
        &self,
        a: &mut [T],
        b: &mut [T],
        size: usize,
        work: impl Fn(usize, &mut [T], &mut [T]) + Sync,
    ) {
        let work = |(i, (a, b)): (usize, (&mut [T], &mut [T]))| {
            if !self.is_cancelled() {
                work(i, a, b);
            }
        };
        match self.pool {
            Some(_) if a.len() > size => {
                let pairs = a.par_chunks_mut(size).zip(b.par_chunks_mut(size)).with_max_len(1);
                pairs.enumerate().for_each(work);
            }
            _ => a.chunks_mut(size).zip(b.chunks_mut(size)).enumerate().for_each(work),
        }
    }
}

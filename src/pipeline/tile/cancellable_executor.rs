//! The executor of a renderer: a pool, or the calling thread, and a token that ends the work.
//!
//! Work is handed out in pieces. When its token is cancelled no piece begins any more: what the pieces were to make
//! then has no meaning, and whoever handed them out asks [`CancellableExecutor::is_cancelled`] before it reads that.

use crate::cancel::CancelToken;
use rayon::prelude::*;
use std::sync::Arc;

/// Who draws: pieces of work are done each once, in any order, perhaps at the same time.
#[derive(Clone, Debug, Default)]
pub struct CancellableExecutor {
    /// Threads shared by whoever draws; the calling thread without them.
    pool: Option<Arc<rayon::ThreadPool>>,
    cancel: CancelToken,
}

impl CancellableExecutor {
    /// Makes an executor of this pool's threads, or of the calling thread.
    pub fn new(pool: Option<Arc<rayon::ThreadPool>>, cancel: CancelToken) -> Self {
        CancellableExecutor { pool, cancel }
    }

    /// The calling thread, with the same token.
    pub fn serial(&self) -> Self {
        CancellableExecutor { pool: None, cancel: self.cancel.clone() }
    }

    /// The threads, where there are others than the calling one.
    pub fn pool(&self) -> Option<&Arc<rayon::ThreadPool>> {
        self.pool.as_ref()
    }

    /// What ends its work early.
    pub fn cancel(&self) -> &CancelToken {
        &self.cancel
    }

    /// Whether work is to end early: pieces may have been left out.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    /// Does `work` where the executor's threads are: its pieces then cost no waking up.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            None => work(),
            Some(pool) => pool.install(work),
        }
    }

    /// Calls `work` with the number and the items of each run of `size` items (the last may be shorter).
    ///
    /// To be called inside [`CancellableExecutor::run`].
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

    /// The same with runs of two lists of one length.
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

//! The crew of a renderer: decided once, and what its pieces of work need.

use rayon::prelude::*;
use std::sync::Arc;

/// Who draws: pieces of work are done each once, in any order, perhaps at the same time.
#[derive(Clone, Debug, Default)]
pub enum Workers {
    /// The calling thread.
    #[default]
    Alone,
    /// Threads shared by whoever draws.
    Pool(Arc<rayon::ThreadPool>),
}

impl Workers {
    /// A crew of this pool's threads, or of the calling thread.
    pub fn new(pool: Option<Arc<rayon::ThreadPool>>) -> Self {
        pool.map_or(Workers::Alone, Workers::Pool)
    }

    /// Does `work` where the crew's threads are: its pieces then cost no waking up.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match self {
            Workers::Alone => work(),
            Workers::Pool(pool) => pool.install(work),
        }
    }

    /// Calls `work` with the number and the items of each run of `size` items (the last may be shorter).
    ///
    /// To be called inside [`Workers::run`].
    pub fn chunks<T: Send>(&self, items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
        match self {
            Workers::Pool(_) if items.len() > size => {
                items.par_chunks_mut(size).with_max_len(1).enumerate().for_each(|(i, run)| work(i, run));
            }
            _ => items.chunks_mut(size).enumerate().for_each(|(i, run)| work(i, run)),
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
        match self {
            Workers::Pool(_) if a.len() > size => {
                let pairs = a.par_chunks_mut(size).zip(b.par_chunks_mut(size)).with_max_len(1);
                pairs.enumerate().for_each(|(i, (a, b))| work(i, a, b));
            }
            _ => {
                let pairs = a.chunks_mut(size).zip(b.chunks_mut(size));
                pairs.enumerate().for_each(|(i, (a, b))| work(i, a, b));
            }
        }
    }
}

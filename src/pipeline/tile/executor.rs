//! Executors: the calling thread alone, or a pool of threads supplied by the caller.
//!
//! Work is split into pieces whose bounds do not depend on the thread that runs them, so the result
//! does not either.

use rayon::prelude::*;
use std::sync::Arc;

/// Runs pieces of work, each once, in any order, possibly in parallel.
pub trait Executor: Sync {
    /// Returns the number of threads, at least 1.
    fn threads(&self) -> usize;

    /// Calls `work` with the index and the items of each run of `size` items (the last may be
    /// shorter).
    fn chunks<T: Send>(&self, items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync);
}

/// Runs all work on the calling thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Executor for Serial {
    fn threads(&self) -> usize {
        1
    }

    fn chunks<T: Send>(&self, items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
        items.chunks_mut(size).enumerate().for_each(|(i, run)| work(i, run));
    }
}

/// Runs work on a pool of threads, which may be shared between renderers.
#[derive(Clone, Debug)]
pub struct Pool(pub Arc<rayon::ThreadPool>);

impl Executor for Pool {
    fn threads(&self) -> usize {
        self.0.current_num_threads().max(1)
    }

    fn chunks<T: Send>(&self, items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
        self.0.install(|| {
            items.par_chunks_mut(size).with_max_len(1).enumerate().for_each(|(i, run)| work(i, run));
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_executor_tells_its_threads_and_hands_out_every_item_once() {
        let pool =
            |threads| Pool(Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()));
        assert_eq!((Serial.threads(), pool(1).threads(), pool(3).threads()), (1, 1, 3));
        let mark = |run: usize, items: &mut [usize]| items.iter_mut().for_each(|i| *i += 100 * (run + 1));
        let (mut one, mut many) = ([0; 11], [0; 11]);
        Serial.chunks(&mut one, 4, mark);
        pool(3).chunks(&mut many, 4, mark);
        assert_eq!(one, [100, 100, 100, 100, 200, 200, 200, 200, 300, 300, 300]);
        assert_eq!(many, one);
    }
}

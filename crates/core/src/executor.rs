//! The executor of drawings: the calling thread or a pool of threads supplied by the caller, with a
//! token that cancels the work.
//!
//! In: work that is split into pieces whose bounds do not depend on the thread that runs them. Out:
//! each piece has run once, in any order, possibly in parallel; so the result does not depend on
//! the threads. Once the token is cancelled no piece starts: the output is then incomplete, and the
//! caller checks [`Executor::is_cancelled`] before reading it. No thread is started here.
//!
//! The pool is rayon's. Without the feature `threads` there is none, and the same calls run on the
//! calling thread (`serial`).

#[cfg(not(feature = "threads"))]
mod serial;

#[cfg(feature = "threads")]
pub use rayon::{ThreadPool, join, prelude};
#[cfg(not(feature = "threads"))]
pub use serial::{ThreadPool, join, prelude};

use crate::cancel::CancelToken;
use prelude::*;
use std::sync::Arc;

/// A piece of work that may run on any thread.
pub type Task<'a> = Box<dyn FnOnce() + Send + 'a>;

/// Runs pieces of work, each once, in any order, possibly in parallel, until it is cancelled.
#[derive(Clone, Debug, Default)]
pub struct Executor {
    /// Threads shared between renderers; `None` for the calling thread.
    pool: Option<Arc<ThreadPool>>,
    cancel: CancelToken,
}

impl Executor {
    /// Creates an executor on the threads of `pool`, or on the calling thread.
    pub fn new(pool: Option<Arc<ThreadPool>>, cancel: CancelToken) -> Self {
        Executor { pool, cancel }
    }

    /// Creates an executor that is never cancelled, on the threads of `pool` or on the calling
    /// thread.
    pub fn of_pool(pool: Option<Arc<ThreadPool>>) -> Self {
        Executor { pool, cancel: CancelToken::default() }
    }

    /// Returns an executor on the calling thread, with this one's token.
    pub fn serial(&self) -> Self {
        Executor { pool: None, cancel: self.cancel.clone() }
    }

    /// Returns the pool; `None` if the calling thread does the work.
    pub fn pool(&self) -> Option<&Arc<ThreadPool>> {
        self.pool.as_ref()
    }

    /// Returns the number of threads, at least 1.
    pub fn threads(&self) -> usize {
        self.pool.as_ref().map_or(1, |pool| pool.current_num_threads().max(1))
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
    pub fn chunks<T: Send>(&self, items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
        let work = |(i, run): (usize, &mut [T])| {
            if !self.is_cancelled() {
                work(i, run);
            }
        };
        match &self.pool {
            Some(pool) if items.len() > size => pool.install(|| {
                items.par_chunks_mut(size).with_max_len(1).enumerate().for_each(work);
            }),
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
        match &self.pool {
            Some(pool) if a.len() > size => pool.install(|| {
                let pairs = a.par_chunks_mut(size).zip(b.par_chunks_mut(size)).with_max_len(1);
                pairs.enumerate().for_each(work);
            }),
            _ => a.chunks_mut(size).zip(b.chunks_mut(size)).enumerate().for_each(work),
        }
    }

    /// Runs the tasks and returns when all have finished.
    pub fn tasks(&self, tasks: Vec<Task<'_>>) {
        let work = &|task: Task<'_>| {
            if !self.is_cancelled() {
                task();
            }
        };
        match &self.pool {
            Some(pool) => pool.scope(|scope| {
                tasks.into_iter().for_each(|task| scope.spawn(move |_| work(task)));
            }),
            None => tasks.into_iter().for_each(work),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn pool(threads: usize) -> Option<Arc<ThreadPool>> {
        Some(Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()))
    }

    #[test]
    fn an_executor_tells_its_threads_and_hands_out_every_item_once() {
        let on = |threads| Executor::of_pool(pool(threads));
        let serial = Executor::default();
        assert_eq!((serial.threads(), on(1).threads(), on(3).threads()), (1, 1, 3));
        assert_eq!(on(3).serial().threads(), 1);
        let mark = |run: usize, items: &mut [usize]| items.iter_mut().for_each(|i| *i += 100 * (run + 1));
        let (mut one, mut many) = ([0; 11], [0; 11]);
        serial.chunks(&mut one, 4, mark);
        on(3).chunks(&mut many, 4, mark);
        assert_eq!(one, [100, 100, 100, 100, 200, 200, 200, 200, 300, 300, 300]);
        assert_eq!(many, one);
        let both = |run: usize, a: &mut [usize], b: &mut [usize]| {
            mark(run, a);
            b.copy_from_slice(a);
        };
        for executor in [serial, on(3)] {
            let (mut a, mut b) = ([0; 11], [0; 11]);
            executor.pairs(&mut a, &mut b, 4, both);
            assert_eq!((a, b), (one, one));
        }
    }

    #[test]
    fn every_task_runs_once_and_none_after_it_is_cancelled() {
        for pool in [None, pool(1), pool(3)] {
            let cancel = CancelToken::new();
            let executor = Executor::new(pool, cancel.clone());
            let count = AtomicUsize::new(0);
            let add = |n: usize| {
                count.fetch_add(n, Ordering::Relaxed);
            };
            let tasks = || (0..7).map(|i| Box::new(move || add(1 << (4 * i))) as Task).collect();
            executor.tasks(tasks());
            assert_eq!(count.load(Ordering::Relaxed), 0x111_1111);
            cancel.cancel();
            executor.tasks(tasks());
            executor.chunks(&mut [0; 5], 2, |_, _| add(1));
            assert_eq!(count.load(Ordering::Relaxed), 0x111_1111);
            assert!(executor.is_cancelled() && executor.serial().is_cancelled());
        }
    }
}

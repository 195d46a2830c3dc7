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
use std::fmt;
use std::sync::Arc;

/// A piece of work that may run on any thread.
pub type Task<'a> = Box<dyn FnOnce() + Send + 'a>;

/// Beginning or end of work that an executor splits into pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceEvent {
    /// Pieces follow that may run in parallel; all of them end before the region does.
    RegionBegins,
    /// A piece begins on the thread that notes it.
    PieceBegins,
    /// The piece of this thread ends.
    PieceEnds,
    /// End of the region: later work runs on one thread.
    RegionEnds,
}

/// Observer of the pieces, for measurements: it is called from each thread that runs one. A pool of one
/// thread runs the pieces of a region in the order in which several threads divide them: by halves,
/// the first half first.
pub trait PieceObserver: fmt::Debug + Send + Sync {
    /// Notes an event.
    fn note(&self, event: PieceEvent);
}

/// Runs pieces of work, each once, in any order, possibly in parallel, until it is cancelled.
#[derive(Clone, Debug, Default)]
pub struct Executor {
    /// Threads shared between renderers; `None` for the calling thread.
    pool: Option<Arc<ThreadPool>>,
    cancel: CancelToken,
    observer: Option<Arc<dyn PieceObserver>>,
}

impl Executor {
    /// Creates an executor on the threads of `pool`, or on the calling thread.
    pub fn new(pool: Option<Arc<ThreadPool>>, cancel: CancelToken) -> Self {
        Executor { pool, cancel, observer: None }
    }

    /// Creates an executor that is never cancelled, on the threads of `pool` or on the calling
    /// thread.
    pub fn of_pool(pool: Option<Arc<ThreadPool>>) -> Self {
        Executor { pool, ..Executor::default() }
    }

    /// Returns this executor with an observer of its pieces.
    pub fn observed(self, observer: Option<Arc<dyn PieceObserver>>) -> Self {
        Executor { observer, ..self }
    }

    /// Returns an executor on the calling thread, with this one's token.
    pub fn serial(&self) -> Self {
        Executor { cancel: self.cancel.clone(), ..Executor::default() }
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

    /// Runs work that is split into pieces, each of which calls [`piece`](Self::piece).
    pub fn region<R>(&self, region: impl FnOnce() -> R) -> R {
        self.noted([PieceEvent::RegionBegins, PieceEvent::RegionEnds], region)
    }

    /// Runs a piece of a region, unless the work is cancelled.
    #[inline]
    pub fn piece(&self, piece: impl FnOnce()) {
        if !self.is_cancelled() {
            self.whole_piece(piece);
        }
    }

    /// Runs a piece of a region that is needed even if the work is cancelled.
    #[inline]
    pub fn whole_piece<R>(&self, piece: impl FnOnce() -> R) -> R {
        self.noted([PieceEvent::PieceBegins, PieceEvent::PieceEnds], piece)
    }

    fn noted<R>(&self, [begins, ends]: [PieceEvent; 2], work: impl FnOnce() -> R) -> R {
        let Some(observer) = &self.observer else { return work() };
        observer.note(begins);
        let result = work();
        observer.note(ends);
        result
    }

    /// Calls `work` with the index and the items of each run of `size` items (the last may be
    /// shorter).
    pub fn chunks<T: Send>(&self, items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
        let work = |(i, run): (usize, &mut [T])| self.piece(|| work(i, run));
        self.region(|| match &self.pool {
            Some(pool) if items.len() > size => pool.install(|| {
                items.par_chunks_mut(size).with_max_len(1).enumerate().for_each(work);
            }),
            _ => items.chunks_mut(size).enumerate().for_each(work),
        });
    }

    /// Like [`chunks`](Self::chunks), with runs of two slices of equal length.
    pub fn pairs<T: Send>(
        &self,
        a: &mut [T],
        b: &mut [T],
        size: usize,
        work: impl Fn(usize, &mut [T], &mut [T]) + Sync,
    ) {
        let work = |(i, (a, b)): (usize, (&mut [T], &mut [T]))| self.piece(|| work(i, a, b));
        self.region(|| match &self.pool {
            Some(pool) if a.len() > size => pool.install(|| {
                let pairs = a.par_chunks_mut(size).zip(b.par_chunks_mut(size)).with_max_len(1);
                pairs.enumerate().for_each(work);
            }),
            _ => a.chunks_mut(size).zip(b.chunks_mut(size)).enumerate().for_each(work),
        });
    }

    /// Runs the tasks and returns when all have finished.
    pub fn tasks(&self, tasks: Vec<Task<'_>>) {
        let work = &|task: Task<'_>| self.piece(task);
        self.region(|| match &self.pool {
            Some(pool) => pool.scope(|scope| {
                tasks.into_iter().for_each(|task| scope.spawn(move |_| work(task)));
            }),
            None => tasks.into_iter().for_each(work),
        });
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

    /// Counts events by their kind, and the pieces that are open.
    #[derive(Debug, Default)]
    struct Counts(std::sync::Mutex<[usize; 4]>);

    impl PieceObserver for Counts {
        fn note(&self, event: PieceEvent) {
            self.0.lock().unwrap()[event as usize] += 1;
        }
    }

    #[test]
    fn an_observer_is_told_of_each_region_and_each_piece() {
        for pool in [None, pool(1), pool(3)] {
            let counts = Arc::new(Counts::default());
            let executor = Executor::of_pool(pool).observed(Some(counts.clone()));
            executor.chunks(&mut [0; 11], 4, |_, _| {});
            executor.pairs(&mut [0; 3], &mut [0; 3], 4, |_, _, _| {});
            executor.tasks(vec![Box::new(|| {}), Box::new(|| {})]);
            executor.serial().chunks(&mut [0; 11], 4, |_, _| {});
            assert_eq!(*counts.0.lock().unwrap(), [3, 6, 6, 3]);
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

//! Threads that share the work of drawing: made here, because the rooms below start none of their own.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Arc;

/// A pool of `threads` sleeping threads (all cores for `None`); `None` where one thread is wanted or no more can be had:
/// the caller then works alone.
pub fn worker_pool(threads: Option<usize>) -> Option<Arc<ThreadPool>> {
    let count = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, |n| n.get()));
    let name = |i| format!("fbptr-draw-{i}");
    match count {
        0 | 1 => None,
        _ => ThreadPoolBuilder::new().num_threads(count).thread_name(name).build().ok().map(Arc::new),
    }
}

//! Threads that share the work of drawing: made here, because the rooms below start none of their own.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Arc;

/// The stack of every thread that draws or reads files. Without optimization a draw has more locals, and a
/// scene of 250 nodes in each other more frames, than the usual 2 MiB hold; 8 MiB were enough for both, and
/// this is four times that. It is address space alone: the system finds pages as they are written.
pub const DRAW_STACK_BYTES: usize = 32 << 20;

/// A pool of `threads` sleeping threads (all cores for `None`); `None` where one thread is wanted or no more can be had:
/// the caller then works alone.
pub fn worker_pool(threads: Option<usize>) -> Option<Arc<ThreadPool>> {
    let count = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, |n| n.get()));
    let name = |i| format!("fbptr-draw-{i}");
    match count {
        0 | 1 => None,
        _ => ThreadPoolBuilder::new()
            .num_threads(count)
            .thread_name(name)
            .stack_size(DRAW_STACK_BYTES)
            .build()
            .ok()
            .map(Arc::new),
    }
}

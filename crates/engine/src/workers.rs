//! Threads for drawing. They are created here, because the modules of lower layers start none.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Arc;

/// Stack size, in bytes, of every thread that draws or reads files. Without optimization a draw has
/// more locals, and a scene of 250 nested nodes more stack frames, than the usual 2 MiB hold; 8 MiB
/// were enough for both, and this is four times that. It costs address space only, because the
/// system allocates pages when they are written.
pub const DRAW_STACK_BYTES: usize = 32 << 20;

/// Creates a pool of `threads` threads, or as many as there are cores for `None`. Returns `None` if
/// one thread is asked for or no more can be started; the caller then works alone.
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

//! A counting allocator for a whole test program: allocator calls, and bytes held.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicIsize, AtomicUsize, Ordering::Relaxed};

struct Counting;

/// Number of allocator calls of the counted threads.
static CALLS: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// True if this thread's calls are counted. The thread of the test harness is not: it allocates
    /// when it reports a test that takes long.
    static IS_COUNTED: Cell<bool> = const { Cell::new(false) };
    /// Bytes that this thread holds (allocated less freed), and their maximum since
    /// [`most_held_here`] began.
    static HERE: Cell<[isize; 2]> = const { Cell::new([0; 2]) };
}

/// Adds to the bytes held by this thread. A thread that ends has no counter any more.
fn note_here(bytes: isize) {
    let _ = HERE.try_with(|here| {
        let [held, peak] = here.get();
        here.set([held + bytes, peak.max(held + bytes)]);
    });
}

/// Counts a call, and the bytes that it allocates.
fn count(layout: Layout) {
    if IS_COUNTED.try_with(Cell::get).unwrap_or(false) {
        CALLS.fetch_add(1, Relaxed);
    }
    let held = HELD.fetch_add(layout.size() as isize, Relaxed) + layout.size() as isize;
    PEAK.fetch_max(held, Relaxed);
    note_here(layout.size() as isize);
}

/// Bytes held by all threads.
pub static HELD: AtomicIsize = AtomicIsize::new(0);
/// Maximum of [`HELD`] since [`most_held`] began.
static PEAK: AtomicIsize = AtomicIsize::new(0);

#[allow(unsafe_code)]
// SAFETY: every call is passed unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout);
        // SAFETY: the caller's guarantees are those that the system allocator asks for.
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout);
        // SAFETY: the caller's guarantees are those that the system allocator asks for.
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size() as isize, Relaxed);
        note_here(-(layout.size() as isize));
        // SAFETY: the caller's guarantees are those that the system allocator asks for.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Returns a pool whose threads' calls are counted.
pub fn counted_pool(threads: usize) -> rayon::ThreadPool {
    let count = |_| IS_COUNTED.set(true);
    rayon::ThreadPoolBuilder::new().num_threads(threads).start_handler(count).build().unwrap()
}

/// Returns the number of allocator calls in `frames` frames, made by this thread and by threads of
/// [`counted_pool`]s. The `before` frames that precede them must allocate.
pub fn steady_calls(before: usize, frames: usize, mut frame: impl FnMut()) -> usize {
    IS_COUNTED.set(true);
    let first = CALLS.load(Relaxed);
    (0..before).for_each(|_| frame());
    let steady = CALLS.load(Relaxed);
    assert!(steady > first + 20, "the first frame makes what the others use: the counter counts");
    (0..frames).for_each(|_| frame());
    IS_COUNTED.set(false);
    CALLS.load(Relaxed) - steady
}

/// Runs `work`; returns its result and the peak of bytes held by all threads, less those held
/// before.
pub fn most_held<R>(work: impl FnOnce() -> R) -> (R, u64) {
    let before = HELD.load(Relaxed);
    PEAK.store(before, Relaxed);
    let answer = work();
    (answer, (PEAK.load(Relaxed) - before).max(0) as u64)
}

/// Like [`most_held`], for work on this thread alone; other threads are not counted.
pub fn most_held_here<R>(work: impl FnOnce() -> R) -> (R, u64) {
    let before = HERE.get()[0];
    HERE.set([before; 2]);
    let answer = work();
    (answer, (HERE.get()[1] - before).max(0) as u64)
}

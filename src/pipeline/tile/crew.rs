//! Who does the work: the calling thread alone, or a pool of threads that the caller gives.
//!
//! Work is handed out in pieces whose bounds do not depend on who does them, so the result does not either.

use rayon::prelude::*;
use std::sync::Arc;

/// Runs pieces of work, each once, in any order, perhaps at the same time.
pub trait Crew: Sync {
    /// How many threads there are, at least 1.
    fn threads(&self) -> usize;

    /// Calls `work` with the number and the items of each run of `size` items (the last may be shorter).
    fn chunks<T: Send>(&self, items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync);

    /// Calls `work` with each band of `size` pixels: its number, depths, ids and RGBA bytes.
    fn bands(
        &self,
        depth: &mut [i32],
        ids: &mut [i32],
        bytes: &mut [u8],
        size: usize,
        work: impl Fn(usize, &mut [i32], &mut [i32], &mut [u8]) + Sync,
    );
}

/// The calling thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Crew for Alone {
    fn threads(&self) -> usize {
        1
    }

    fn chunks<T: Send>(&self, items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
        items.chunks_mut(size).enumerate().for_each(|(i, run)| work(i, run));
    }

    fn bands(
        &self,
        depth: &mut [i32],
        ids: &mut [i32],
        bytes: &mut [u8],
        size: usize,
        work: impl Fn(usize, &mut [i32], &mut [i32], &mut [u8]) + Sync,
    ) {
        let bands = depth.chunks_mut(size).zip(ids.chunks_mut(size)).zip(bytes.chunks_mut(size * 4));
        bands.enumerate().for_each(|(i, ((depth, ids), bytes))| work(i, depth, ids, bytes));
    }
}

/// A pool of threads, shared by whoever draws.
#[derive(Clone, Debug)]
pub struct Pool(pub Arc<rayon::ThreadPool>);

impl Crew for Pool {
    fn threads(&self) -> usize {
        self.0.current_num_threads().max(1)
    }

    fn chunks<T: Send>(&self, items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
        self.0.install(|| {
            items.par_chunks_mut(size).with_max_len(1).enumerate().for_each(|(i, run)| work(i, run));
        });
    }

    fn bands(
        &self,
        depth: &mut [i32],
        ids: &mut [i32],
        bytes: &mut [u8],
        size: usize,
        work: impl Fn(usize, &mut [i32], &mut [i32], &mut [u8]) + Sync,
    ) {
        self.0.install(|| {
            let bands =
                depth.par_chunks_mut(size).zip(ids.par_chunks_mut(size)).zip(bytes.par_chunks_mut(size * 4));
            bands
                .with_max_len(1)
                .enumerate()
                .for_each(|(i, ((depth, ids), bytes))| work(i, depth, ids, bytes));
        });
    }
}

//! Stand-ins for rayon in a build without threads: the calls that this crate makes of it, run on the
//! calling thread, in order.

/// A pool of threads, of which there is none in this build.
#[derive(Debug)]
pub enum ThreadPool {}

/// Starts tasks within [`ThreadPool::scope`].
#[derive(Debug)]
pub enum Scope {}

impl ThreadPool {
    /// Returns the number of threads.
    pub fn current_num_threads(&self) -> usize {
        match *self {}
    }

    /// Runs `work` on a thread of the pool.
    pub fn install<R>(&self, _work: impl FnOnce() -> R) -> R {
        match *self {}
    }

    /// Runs `work`, and waits for the tasks that it starts.
    pub fn scope<R>(&self, _work: impl FnOnce(&Scope) -> R) -> R {
        match *self {}
    }
}

impl Scope {
    /// Starts a task.
    pub fn spawn(&self, _task: impl FnOnce(&Scope)) {
        match *self {}
    }
}

/// Runs both functions, one after the other.
pub fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}

/// Iterators with the names of rayon's.
pub mod prelude {
    use std::ops::RangeBounds;

    /// Settings and ends of a parallel iterator.
    pub trait SerialIterator: Iterator + Sized {
        /// Has no effect: nothing is split.
        fn with_min_len(self, _items: usize) -> Self {
            self
        }

        /// Has no effect: nothing is split.
        fn with_max_len(self, _items: usize) -> Self {
            self
        }

        /// Replaces the contents of `list` by the items.
        fn collect_into_vec(self, list: &mut Vec<Self::Item>) {
            list.clear();
            list.extend(self);
        }
    }

    impl<I: Iterator> SerialIterator for I {}

    /// Iterators over slices.
    pub trait SerialSlice<T> {
        /// Iterates over the items.
        fn par_iter(&self) -> std::slice::Iter<'_, T>;
        /// Iterates over the items for writing.
        fn par_iter_mut(&mut self) -> std::slice::IterMut<'_, T>;
        /// Iterates over runs of `size` items; the last may be shorter.
        fn par_chunks_mut(&mut self, size: usize) -> std::slice::ChunksMut<'_, T>;
    }

    impl<T> SerialSlice<T> for [T] {
        fn par_iter(&self) -> std::slice::Iter<'_, T> {
            self.iter()
        }

        fn par_iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
            self.iter_mut()
        }

        fn par_chunks_mut(&mut self, size: usize) -> std::slice::ChunksMut<'_, T> {
            self.chunks_mut(size)
        }
    }

    /// Iterators over vectors.
    pub trait SerialVec<T> {
        /// Removes the items of a range, and iterates over them.
        fn par_drain(&mut self, range: impl RangeBounds<usize>) -> std::vec::Drain<'_, T>;
        /// Appends items.
        fn par_extend(&mut self, items: impl IntoIterator<Item = T>);
    }

    impl<T> SerialVec<T> for Vec<T> {
        fn par_drain(&mut self, range: impl RangeBounds<usize>) -> std::vec::Drain<'_, T> {
            self.drain(range)
        }

        fn par_extend(&mut self, items: impl IntoIterator<Item = T>) {
            self.extend(items);
        }
    }
}

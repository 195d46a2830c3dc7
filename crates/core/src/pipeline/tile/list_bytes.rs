//! Counter of the bytes of a draw's face lists.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Shared counter of the capacity, in bytes, of the lists of all chunks of a draw. It is updated
/// when a list grows, which is rare, from any thread.
#[derive(Clone, Debug, Default)]
pub struct ListBytes(Arc<AtomicUsize>);

impl ListBytes {
    /// Returns the capacity in bytes.
    #[inline(always)]
    pub fn get(&self) -> usize {
        self.0.load(Relaxed)
    }

    /// Counts a list that has grown from a capacity of `before` items to `after`.
    pub fn grew<T>(&self, before: usize, after: usize) {
        self.0.fetch_add((after - before) * size_of::<T>(), Relaxed);
    }

    /// Resets the count, once all lists are freed.
    pub fn clear(&self) {
        self.0.store(0, Relaxed);
    }

    /// Extends `list` to `least` items with copies of `value`.
    #[cold]
    #[inline(never)]
    pub fn lengthen<T: Copy>(&self, list: &mut Vec<T>, least: usize, value: T) {
        let before = list.capacity();
        list.resize(least, value);
        self.grew::<T>(before, list.capacity());
    }

    /// Appends an item to `list`.
    #[inline(always)]
    pub fn push<T>(&self, list: &mut Vec<T>, item: T) {
        if list.len() == list.capacity() {
            self.make_room(list);
        }
        list.push(item);
    }

    /// Grows a full list, and counts its new capacity.
    #[cold]
    #[inline(never)]
    fn make_room<T>(&self, list: &mut Vec<T>) {
        let before = list.capacity();
        list.reserve(1);
        self.grew::<T>(before, list.capacity());
    }

    /// Returns whether both are one counter.
    pub fn is_same(&self, other: &ListBytes) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

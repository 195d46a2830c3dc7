//! Slices that begin at a cache line: a vector of 64 bytes that straddles two lines costs twice.

use crate::simd::allocator::{HUGE_PAGE_BYTES, ask_for_huge_pages};
use std::ops::{Deref, DerefMut};

/// Bytes of a cache line, and of the widest vector.
const LINE: usize = 64;
/// Slices of at least this many bytes get huge pages where the system grants them on request:
/// accesses to pixels at random places touch many pages.
const LARGE: usize = 2 * HUGE_PAGE_BYTES;

/// Fixed-length slice on the heap that begins at a cache line, or at a huge page if it is large.
#[derive(Debug, Default)]
pub(super) struct Aligned<T> {
    items: Vec<T>,
    /// Index of the first item of the slice; the items before it are padding.
    start: usize,
    len: usize,
}

impl<T: Copy> Aligned<T> {
    /// Allocates `len` items equal to `value`, or returns `None` if the system has no memory for
    /// them.
    pub fn new(len: usize, value: T) -> Option<Self> {
        let Room { line, slack, items: room } = Room::of::<T>(len)?;
        let mut items = Vec::new();
        items.try_reserve_exact(room).ok()?;
        if line == HUGE_PAGE_BYTES {
            // Must precede the first store: pages that are already mapped keep their size.
            ask_for_huge_pages(items.spare_capacity_mut());
        }
        items.resize(len + slack, value);
        let start = items.as_ptr().align_offset(line).min(slack);
        Some(Aligned { items, start, len })
    }

    /// Allocates `len` items that are zero, or returns `None` if the system has no memory for them.
    /// No item is touched, however many there are, where the system gives zeroed pages on first use.
    pub fn zeroed(len: usize) -> Option<Self>
    where
        T: Default,
    {
        let mut zeroed = Self::sparse(len)?;
        if zeroed.len * size_of::<T>() >= LARGE {
            ask_for_huge_pages(&mut zeroed.items);
        }
        Some(zeroed)
    }

    /// Does the same without huge pages, however large the slice is: the first use of an item takes no
    /// more than it takes the system to clear a small page.
    pub fn sparse(len: usize) -> Option<Self>
    where
        T: Default,
    {
        let Room { line, slack, items: room } = Room::of::<T>(len)?;
        // `vec!` ends the process if there is no room; so that is asked for first.
        Vec::<T>::new().try_reserve_exact(room).ok()?;
        let items = vec![T::default(); room];
        let start = items.as_ptr().align_offset(line).min(slack);
        Some(Aligned { items, start, len })
    }
}

/// The size of an allocation, in items, and of the blocks that it is rounded to.
struct Room {
    /// Bytes of a block.
    line: usize,
    /// Items of a block.
    slack: usize,
    items: usize,
}

impl Room {
    /// Returns the room for `len` items, or `None` if no memory has so many bytes.
    fn of<T>(len: usize) -> Option<Room> {
        let line = if len.checked_mul(size_of::<T>())? >= LARGE { HUGE_PAGE_BYTES } else { LINE };
        let slack = line / size_of::<T>();
        // The last huge page belongs to this allocation alone.
        let items = len.checked_next_multiple_of(slack)?.checked_add(slack)?;
        Some(Room { line, slack, items })
    }
}

impl<T: Copy> Clone for Aligned<T> {
    fn clone(&self) -> Self {
        // The copy has another address, so its first aligned item has another index.
        let value = self.items[0];
        let mut copy = Aligned::new(self.len, value).expect("as much room as the original has");
        copy.copy_from_slice(self);
        copy
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];
    #[inline]
    fn deref(&self) -> &[T] {
        &self.items[self.start..self.start + self.len]
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.items[self.start..self.start + self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_their_copies_begin_at_a_line_and_hold_what_was_asked() {
        for len in [0, 1, 7, 1000, 100_003] {
            let mut bytes = Aligned::new(len, 7u8).expect("room");
            let words = Aligned::new(len, -3i32).expect("room");
            assert_eq!((bytes.len(), words.len()), (len, len));
            assert!(bytes.iter().all(|&b| b == 7) && words.iter().all(|&w| w == -3));
            bytes.iter_mut().enumerate().for_each(|(i, b)| *b = i as u8);
            let zeros = Aligned::<[u32; 2]>::zeroed(len).expect("room");
            assert!(zeros.len() == len && zeros.iter().all(|&w| w == [0; 2]));
            assert_eq!(zeros.as_ptr().addr() % LINE, 0);
            let copy = bytes.clone();
            assert_eq!(*copy, *bytes);
            for at in [bytes.as_ptr().addr(), copy.as_ptr().addr(), words.as_ptr().addr()] {
                assert_eq!(at % LINE, 0);
            }
        }
        assert!(Aligned::<u8>::zeroed(usize::MAX).is_none() && Aligned::<i32>::zeroed(1 << 61).is_none());
        assert!(Aligned::new(usize::MAX, 0u8).is_none() && Aligned::new(usize::MAX / 2, 0i32).is_none());
    }
}

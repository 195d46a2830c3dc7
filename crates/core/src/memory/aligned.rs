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
        let line = if len.checked_mul(size_of::<T>())? >= LARGE { HUGE_PAGE_BYTES } else { LINE };
        let slack = line / size_of::<T>();
        let mut items = Vec::new();
        // The last huge page belongs to this allocation alone.
        let rounded = len.checked_next_multiple_of(line / size_of::<T>())?;
        items.try_reserve_exact(rounded.checked_add(slack)?).ok()?;
        if line == HUGE_PAGE_BYTES {
            // Must precede the first store: pages that are already mapped keep their size.
            ask_for_huge_pages(items.spare_capacity_mut());
        }
        items.resize(len + slack, value);
        let start = items.as_ptr().align_offset(line).min(slack);
        Some(Aligned { items, start, len })
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
            let copy = bytes.clone();
            assert_eq!(*copy, *bytes);
            for at in [bytes.as_ptr().addr(), copy.as_ptr().addr(), words.as_ptr().addr()] {
                assert_eq!(at % LINE, 0);
            }
        }
        assert!(Aligned::new(usize::MAX, 0u8).is_none() && Aligned::new(usize::MAX / 2, 0i32).is_none());
    }
}

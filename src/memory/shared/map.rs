//! The map of a shared file, which can change under us at any time: every access to it is an atomic load or store through
//! a raw pointer, never a reference to plain bytes. This is the one file outside `simd/` with unsafe code.
#![allow(unsafe_code)]

use memmap2::{MmapOptions, MmapRaw};
use std::fs::File;
use std::io;
use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64};

/// Bytes that other processes see and write. Whoever touches them has made sure that the file is still that long.
#[derive(Debug)]
pub(super) struct Map(MmapRaw);

impl Map {
    /// The first `bytes` bytes of a file that has them.
    pub fn new(file: &File, bytes: usize) -> io::Result<Self> {
        MmapOptions::new().len(bytes).map_raw(file).map(Map)
    }

    /// The four bytes at `at`.
    pub fn word_at(&self, at: usize) -> &AtomicU32 {
        assert!(at.is_multiple_of(4) && at + 4 <= self.0.len());
        // SAFETY: the map is page aligned and `at` is a multiple of 4 inside it; it lives as long as `self`, and this
        // process touches it through atomics only. The file's length was checked before (`restore_length`).
        unsafe { AtomicU32::from_ptr(self.0.as_mut_ptr().add(at).cast()) }
    }

    /// The byte at `at`.
    pub fn byte_at(&self, at: usize) -> &AtomicU8 {
        assert!(at < self.0.len());
        // SAFETY: as in `word_at`, with 1 in place of 4.
        unsafe { AtomicU8::from_ptr(self.0.as_mut_ptr().add(at)) }
    }

    /// The eight bytes at `at`.
    pub fn long(&self, at: usize) -> &AtomicU64 {
        assert!(at.is_multiple_of(8) && at + 8 <= self.0.len());
        // SAFETY: as in `word_at`, with 8 in place of 4. Words of all sizes are used by one thread only.
        unsafe { AtomicU64::from_ptr(self.0.as_mut_ptr().add(at).cast()) }
    }
}

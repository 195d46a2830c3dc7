//! Hints to the CPU's cache: what will be read soon.

/// Says that record `at` will be read soon. It changes nothing that can be read; outside `records` it does nothing.
#[inline(always)]
pub fn for_read<T>(records: &[T], at: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(record) = records.get(at) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: SSE is part of every x86-64, and a prefetch reads and writes nothing that a program can see.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(record).cast()) }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (records, at);
}

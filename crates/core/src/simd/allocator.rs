//! Settings of the allocator for large blocks. They are in this module because they need calls that
//! are `unsafe`.

/// Makes large blocks return to the system as soon as they are freed, for the rest of the process.
///
/// glibc starts that way, and stops once a large block was freed: what the buffers of many threads
/// leave behind is then never returned. A server lives longer than its clients. With other C
/// libraries this does nothing.
pub fn give_large_blocks_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        use std::ffi::c_int;
        // SAFETY: glibc's own signature.
        unsafe extern "C" {
            fn mallopt(parameter: c_int, value: c_int) -> c_int;
        }
        const M_MMAP_THRESHOLD: c_int = -3;
        // SAFETY: glibc's own function, and a parameter and value from its manual.
        unsafe { mallopt(M_MMAP_THRESHOLD, 128 << 10) };
    }
}

/// Size in bytes of a huge page of x86-64, and its alignment.
pub const HUGE_PAGE_BYTES: usize = 2 << 20;

/// Asks the system to back by huge pages those that lie entirely within `block`, which must not
/// have been written yet. The contents are unaffected; where the system does not support it this
/// does nothing.
pub fn ask_for_huge_pages<T>(block: &mut [T]) {
    #[cfg(target_os = "linux")]
    {
        use rustix::mm::{Advice, madvise};
        let bytes = size_of_val(block);
        let start = block.as_mut_ptr().cast::<u8>();
        let skipped = start.align_offset(HUGE_PAGE_BYTES);
        let len = bytes.saturating_sub(skipped) / HUGE_PAGE_BYTES * HUGE_PAGE_BYTES;
        if len > 0 {
            // SAFETY: the pages lie within the block, and this advice changes no byte of them.
            let _ = unsafe { madvise(start.wrapping_add(skipped).cast(), len, Advice::LinuxHugepage) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = block;
}

/// Puts a list's capacity into huge pages if it is long, so that gathers from all over it miss
/// fewer address translations. To be called before the memory is written for the first time.
pub fn prefer_huge_pages<T>(list: &mut Vec<T>) {
    if list.is_empty() && mapped_ahead(list.capacity().saturating_mul(size_of::<T>())) > 0 {
        ask_for_huge_pages(list.spare_capacity_mut());
    }
}

/// Returns the largest number of bytes that the system maps after the last one that was written, of a
/// block of `bytes` bytes that [`prefer_huge_pages`] has seen and that is written from its start on:
/// all of a huge page but one byte.
pub fn mapped_ahead(bytes: usize) -> usize {
    if bytes >= 2 * HUGE_PAGE_BYTES { HUGE_PAGE_BYTES } else { 0 }
}

/// Resizes `list` to `len` items, new ones being `value`. If its capacity is too small, it is
/// reallocated and filled anew, in huge pages if it is long.
pub fn resize_in_huge_pages<T: Copy>(list: &mut Vec<T>, len: usize, value: T) {
    if list.capacity() < len {
        // The old allocation is freed first.
        *list = Vec::new();
        *list = Vec::with_capacity(len);
        prefer_huge_pages(list);
    }
    list.resize(len, value);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_as_long_as_was_asked_whatever_pages_they_lie_in() {
        let mut list: Vec<u64> = Vec::new();
        for len in [3, 1000, 1 << 20, 3_000_001, 10, 0] {
            resize_in_huge_pages(&mut list, len, 7);
            assert!(list.len() == len && list.iter().all(|v| *v == 7));
        }
        for room in [0, 1, 2 * HUGE_PAGE_BYTES - 1, 2 * HUGE_PAGE_BYTES, 5 * HUGE_PAGE_BYTES + 5] {
            let mut bytes: Vec<u8> = Vec::with_capacity(room);
            prefer_huge_pages(&mut bytes);
            bytes.resize(room, 3);
            prefer_huge_pages(&mut bytes);
            assert!(bytes.len() == room && bytes.iter().all(|b| *b == 3));
        }
        let mut nothing: Vec<()> = Vec::new();
        prefer_huge_pages(&mut nothing);
        nothing.resize(1 << 24, ());
        assert_eq!(nothing.len(), 1 << 24);
    }
}

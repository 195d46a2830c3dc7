//! Prefetch hints to the CPU's cache.

/// Prefetches record `at` for reading. The contents are unaffected; out of bounds it does nothing.
#[inline(always)]
pub fn for_read<T>(records: &[T], at: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(record) = records.get(at) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: SSE is part of every x86-64, and a prefetch reads and writes nothing that a
        // program can see.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(record).cast()) }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (records, at);
}

/// Prefetch for writing, as this CPU supports it.
///
/// A store that misses the caches waits in a queue, in the order of the stores. Few of these are in
/// flight at once, while many prefetched lines can be.
#[derive(Clone, Copy, Debug)]
pub struct ForWrite {
    /// True if a line can be prefetched with the right to write it.
    #[cfg(target_arch = "x86_64")]
    has_prefetchw: bool,
}

impl ForWrite {
    /// Detects the CPU's support, once.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    pub fn new() -> Self {
        static HAS_PREFETCHW: std::sync::OnceLock<bool> = std::sync::OnceLock::new();
        Self { has_prefetchw: *HAS_PREFETCHW.get_or_init(has_prefetchw) }
    }

    /// Makes the prefetch of a CPU without such support.
    #[cfg(not(target_arch = "x86_64"))]
    pub fn new() -> Self {
        Self {}
    }

    /// Prefetches record `at` for writing. The contents are unaffected; out of bounds it does
    /// nothing.
    #[inline(always)]
    pub fn record<T>(self, records: &[T], at: usize) {
        #[cfg(target_arch = "x86_64")]
        if self.has_prefetchw {
            if let Some(record) = records.get(at) {
                let record = std::ptr::from_ref(record);
                // SAFETY: the CPU has the instruction, which reads and writes nothing that a
                // program can see.
                unsafe {
                    std::arch::asm!(
                        "prefetchw byte ptr [{}]", in(reg) record,
                        options(nostack, readonly, preserves_flags)
                    );
                }
            }
            return;
        }
        for_read(records, at);
    }
}

impl Default for ForWrite {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(target_arch = "x86_64")]
fn has_prefetchw() -> bool {
    use std::arch::x86_64::__cpuid;
    const EXTENDED: u32 = 0x8000_0000;
    #[allow(unused_unsafe, reason = "compilers before 1.94 ask for it")]
    // SAFETY: every x86-64 has the instruction; a leaf is queried only if it exists.
    unsafe {
        __cpuid(EXTENDED).eax > EXTENDED && __cpuid(EXTENDED + 1).ecx >> 8 & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hints_change_nothing_wherever_they_point() {
        let records: Vec<u32> = (0..100).collect();
        let before = records.clone();
        let hints = [
            ForWrite::new(),
            #[cfg(target_arch = "x86_64")]
            ForWrite { has_prefetchw: false },
        ];
        for at in [0, 1, 99, 100, usize::MAX / 3, usize::MAX] {
            for_read(&records, at);
            hints.iter().for_each(|hint| hint.record(&records, at));
        }
        assert_eq!(records, before);
    }
}

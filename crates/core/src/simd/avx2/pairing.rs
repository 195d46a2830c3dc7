//! Choice of pairs of vectors for long kernels, by the CPU's vendor: speed differs, bytes do not.
//!
//! Two interleaved chains of operations overlap their divisions and roots, but need twice the
//! registers. On AMD's Zen 3 resolving blocks takes 8 % less time in pairs; on one Intel Xeon frames
//! take up to 11 % more (docs/notes/fast-path.md). So pairs are used on processors of AMD, and of
//! Hygon, whose cores are AMD's.

use std::arch::x86_64::__cpuid;
use std::sync::OnceLock;

/// Vendors as the CPU names them: EBX, EDX and ECX of leaf 0.
const PAIRING_VENDORS: [&[u8; 12]; 2] = [b"AuthenticAMD", b"HygonGenuine"];

/// Returns whether long kernels are faster over pairs of vectors on this CPU.
#[inline]
pub fn pairs_are_faster() -> bool {
    #[cfg(test)]
    if let Some(forced) = FORCED.get() {
        return forced;
    }
    static FOUND: OnceLock<bool> = OnceLock::new();
    *FOUND.get_or_init(|| PAIRING_VENDORS.contains(&&vendor()))
}

/// Returns the CPU's vendor.
fn vendor() -> [u8; 12] {
    #[allow(unused_unsafe, reason = "compilers before 1.94 ask for it")]
    // SAFETY: every x86-64 has the instruction and leaf 0.
    let leaf = unsafe { __cpuid(0) };
    name_of([leaf.ebx, leaf.ecx, leaf.edx])
}

/// Returns the vendor's name in EBX, ECX and EDX of leaf 0: the last two are in the other order.
fn name_of([ebx, ecx, edx]: [u32; 3]) -> [u8; 12] {
    let mut name = [0; 12];
    for (part, register) in name.chunks_exact_mut(4).zip([ebx, edx, ecx]) {
        part.copy_from_slice(&register.to_le_bytes());
    }
    name
}

#[cfg(test)]
thread_local! {
    static FORCED: std::cell::Cell<Option<bool>> = const { std::cell::Cell::new(None) };
}

/// Calls `work` with or without pairs on this thread, whatever the CPU.
#[cfg(test)]
pub fn with_pairs<T>(pairs: bool, work: impl FnOnce() -> T) -> T {
    struct Reset;
    impl Drop for Reset {
        fn drop(&mut self) {
            FORCED.set(None);
        }
    }
    let _reset = Reset;
    FORCED.set(Some(pairs));
    work()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vendor_is_a_name_and_decides() {
        // Registers as AMD's and Intel's manuals print them.
        assert_eq!(&name_of([0x6874_7541, 0x444d_4163, 0x6974_6e65]), b"AuthenticAMD");
        assert_eq!(&name_of([0x756e_6547, 0x6c65_746e, 0x4965_6e69]), b"GenuineIntel");
        let name = vendor();
        assert!(name.iter().all(|byte| byte.is_ascii_graphic() || *byte == b' '), "{name:?}");
        assert_eq!(pairs_are_faster(), PAIRING_VENDORS.contains(&&name));
        assert!(with_pairs(true, pairs_are_faster) && !with_pairs(false, pairs_are_faster));
    }
}

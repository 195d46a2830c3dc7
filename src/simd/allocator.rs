//! How the allocator treats large blocks. Here because it takes a call that is `unsafe`.

/// Lets large blocks go back to the system as soon as they are freed, in this process from now on.
///
/// glibc begins so, and stops once a large block was freed: what many threads' buffers have left behind is then kept for
/// ever. A server lives longer than its clients. With other C libraries it does nothing.
pub fn give_large_blocks_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        use std::ffi::c_int;
        unsafe extern "C" {
            fn mallopt(parameter: c_int, value: c_int) -> c_int;
        }
        const M_MMAP_THRESHOLD: c_int = -3;
        // SAFETY: glibc's own function with glibc's own signature, and a parameter and value from its manual.
        unsafe { mallopt(M_MMAP_THRESHOLD, 128 << 10) };
    }
}

//! Maps of the device's memory: `mmap` and `mremap`.

use crate::abi::{self, fail, next, set_errno};
use crate::device::{Device, device};
use core::ffi::{c_int, c_void};

/// Result of a map that fails.
const FAILED: *mut c_void = usize::MAX as *mut c_void;

/// Defines `mmap` and its other name.
macro_rules! maps {
    ($($name:ident)*) => {$(
        /// Maps a file. The framebuffer has nothing behind its end: there the kernel answers
        /// EINVAL, where a file would give a map that cannot be read.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            address: *mut c_void, len: usize, access: c_int, flags: c_int, fd: c_int, offset: i64,
        ) -> *mut c_void {
            type Next = unsafe extern "C" fn(*mut c_void, usize, c_int, c_int, c_int, i64) -> *mut c_void;
            if fd >= 0 && is_beyond(fd, offset, len) {
                set_errno(abi::EINVAL);
                return FAILED;
            }
            match next!(stringify!($name), as Next) {
                // SAFETY: the arguments are the caller's.
                Some(next) => unsafe { next(address, len, access, flags, fd, offset) },
                None => {
                    set_errno(abi::ENOSYS);
                    FAILED
                }
            }
        }
    )*};
}

maps! { mmap mmap64 }

fn is_beyond(fd: c_int, offset: i64, len: usize) -> bool {
    let Some(device) = device().filter(|device| device.is_memory_fd(fd)) else { return false };
    let end = u64::try_from(offset).ok().and_then(|offset| offset.checked_add(len as u64));
    let size = u64::from(device.limits().smem_len).next_multiple_of(4096);
    end.is_none_or(|end| end > size)
}

/// Moves or resizes a map. That of a device cannot grow: the kernel marks it so (`VM_DONTEXPAND`).
///
/// # Safety
/// As for the C library's function. It is variadic there; the address is passed on as it came.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mremap(
    from: *mut c_void,
    len: usize,
    new_len: usize,
    flags: c_int,
    to: *mut c_void,
) -> *mut c_void {
    type Next = unsafe extern "C" fn(*mut c_void, usize, usize, c_int, *mut c_void) -> *mut c_void;
    if new_len > len && device().is_some_and(|device| is_mapped_at(&device, from as u64)) {
        fail(abi::EFAULT);
        return FAILED;
    }
    match next!("mremap", as Next) {
        // SAFETY: the arguments are the caller's.
        Some(next) => unsafe { next(from, len, new_len, flags, to) },
        None => {
            fail(abi::ENOSYS);
            FAILED
        }
    }
}

/// Returns whether the device's memory is mapped at an address, as `/proc/self/maps` has it.
fn is_mapped_at(device: &Device, address: u64) -> bool {
    let saved = abi::errno();
    // SAFETY: the path is a C string.
    let fd = unsafe { abi::next_openat(abi::AT_FDCWD, c"/proc/self/maps".as_ptr(), abi::O_CLOEXEC) };
    // The beginning of a line is enough: the path at its end does not count.
    let (mut line, mut len, mut is_found) = ([0u8; 128], 0, false);
    let mut bytes = [0u8; 1024];
    while fd >= 0 && !is_found {
        // SAFETY: the buffer has room for its length.
        let read = unsafe { abi::read(fd, bytes.as_mut_ptr().cast(), bytes.len()) };
        let Some(read) = usize::try_from(read).ok().filter(|read| *read > 0) else { break };
        for &byte in &bytes[..read] {
            if byte == b'\n' {
                is_found |= is_line_of(device, &line[..len], address);
                len = 0;
            } else if len < line.len() {
                line[len] = byte;
                len += 1;
            }
        }
    }
    if fd >= 0 {
        // SAFETY: the descriptor is ours.
        unsafe { abi::close(fd) };
    }
    set_errno(saved);
    is_found
}

/// Reads a line `START-END ACCESS OFFSET DEVICE INODE ...`.
fn is_line_of(device: &Device, line: &[u8], address: u64) -> bool {
    let mut words = line.split(|b| *b == b' ');
    let (Some(range), Some(inode)) = (words.next(), words.nth(3)) else { return false };
    let mut ends = range.split(|b| *b == b'-').map(|digits| {
        digits
            .iter()
            .fold(0u64, |value, digit| value << 4 | u64::from(char::from(*digit).to_digit(16).unwrap_or(0)))
    });
    let (Some(start), Some(end)) = (ends.next(), ends.next()) else { return false };
    let is_memory = crate::text::numbers::<1>(inode).is_some_and(|[inode]| inode == device.inode());
    is_memory && (start..end).contains(&address) && line.windows(8).any(|part| part == b" /memfd:")
}

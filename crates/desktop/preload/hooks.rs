//! The calls on descriptors: `ioctl`, `write` and its kin at the end of the memory, `lseek` from
//! it, `ftruncate`, and copies from descriptor to descriptor, which a device does not have.

use crate::abi::{self, fail, next, set_errno};
use crate::device::device;
use crate::{console, evdev, framebuffer, open, sysfs, terminal};
use core::ffi::{c_int, c_uint, c_ulong, c_void};

type Ioctl = unsafe extern "C" fn(c_int, c_ulong, *mut c_void) -> c_int;

/// Carries out a request of the device, or passes it on.
///
/// # Safety
/// As for the C library's function. It is variadic there; every request has one argument at most.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ioctl(fd: c_int, request: c_ulong, argument: *mut c_void) -> c_int {
    // SAFETY: the arguments are the caller's.
    let ours = unsafe { own_ioctl(fd, request as u32, argument) };
    if let Some(result) = ours {
        return result.unwrap_or_else(fail);
    }
    let Some(next) = next!("ioctl", as Ioctl) else { return fail(abi::ENOSYS) };
    // SAFETY: the arguments are the caller's.
    let result = unsafe { next(fd, request, argument) };
    // Of other kinds of requests the framebuffer refuses all but those that ask for a terminal.
    if result == -1 && abi::errno() == abi::ENOTTY && request >> 8 & 0xff != b'T'.into() {
        if let Some(device) = device().filter(|device| device.is_memory_fd(fd)) {
            device.log(0, request as u32);
            return fail(abi::EINVAL);
        }
        set_errno(abi::ENOTTY);
    }
    result
}

/// Carries out a request, if the descriptor is one of the device's.
unsafe fn own_ioctl(fd: c_int, request: u32, argument: *mut c_void) -> Option<Result<c_int, i32>> {
    let kind = (request >> 8) as u8;
    if !matches!(kind, b'F' | b'K' | b'V' | b'E') {
        return None;
    }
    let device = device()?;
    let done = |result: Result<(), i32>| Some(result.map(|()| 0));
    // SAFETY: the argument is what the request asks for, says the caller.
    unsafe {
        match kind {
            b'F' if device.is_memory_fd(fd) => done(framebuffer::request(&device, request, argument)),
            b'K' | b'V' if terminal::is_served(&device, fd) => {
                done(console::request(&device, request, argument))
            }
            b'E' => match open::input_of(&device, fd)? {
                index @ 0..=1 => Some(evdev::request(&device, fd, index, request, argument)),
                _ => Some(Err(abi::EINVAL)),
            },
            _ => None,
        }
    }
}

type Write = unsafe extern "C" fn(c_int, *const c_void, usize) -> isize;
type Pwrite = unsafe extern "C" fn(c_int, *const c_void, usize, i64) -> isize;

/// Writes bytes to the framebuffer or to a file.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn write(fd: c_int, bytes: *const c_void, len: usize) -> isize {
    let Some(next) = next!("write", as Write) else { return fail(abi::ENOSYS) as isize };
    // SAFETY: the bytes are the caller's.
    if let Some(result) = unsafe { write_attribute(fd, bytes, len) } {
        return result;
    }
    // SAFETY: the arguments are the caller's.
    let written = unsafe { next(fd, bytes, len) };
    if written != -1 || abi::errno() != abi::EPERM {
        return written;
    }
    let at = abi::next_lseek(fd, 0, abi::SEEK_CUR);
    // SAFETY: no more bytes than the caller has.
    at_end(fd, at, len, |rest| unsafe { next(fd, bytes, rest) })
}

/// Writes a text to a file of `/sys`, if that is what the descriptor is open for.
///
/// # Safety
/// `bytes` holds `len` bytes.
unsafe fn write_attribute(fd: c_int, bytes: *const c_void, len: usize) -> Option<isize> {
    if bytes.is_null() || len == 0 {
        return None;
    }
    // SAFETY: the caller's promise. No text that means anything is longer than a page.
    sysfs::write(fd, unsafe { core::slice::from_raw_parts(bytes.cast(), len.min(4096)) })
}

/// Writes the part that fits of bytes that the sealed memory has refused, as `fb_write` does.
fn at_end(fd: c_int, at: i64, len: usize, write: impl FnOnce(usize) -> isize) -> isize {
    let Some(device) = device().filter(|device| device.is_memory_fd(fd)) else {
        return fail(abi::EPERM) as isize;
    };
    let size = i64::from(device.limits().smem_len);
    match size - at {
        rest if rest < 0 => fail(abi::EFBIG) as isize,
        0 => fail(abi::ENOSPC) as isize,
        rest => write(len.min(rest as usize)),
    }
}

/// Defines `pwrite` and its other name.
macro_rules! pwrites {
    ($($name:ident)*) => {$(
        /// Writes bytes at an offset.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(fd: c_int, bytes: *const c_void, len: usize, offset: i64) -> isize {
            let Some(next) = next!(stringify!($name), as Pwrite) else { return fail(abi::ENOSYS) as isize };
            // SAFETY: the bytes are the caller's.
            if let Some(result) = unsafe { write_attribute(fd, bytes, len) } {
                return result;
            }
            // SAFETY: the arguments are the caller's.
            let written = unsafe { next(fd, bytes, len, offset) };
            if written != -1 || abi::errno() != abi::EPERM {
                return written;
            }
            // SAFETY: no more bytes than the caller has.
            at_end(fd, offset, len, |rest| unsafe { next(fd, bytes, rest, offset) })
        }
    )*};
}

pwrites! { pwrite pwrite64 }

/// Writes all of a short text.
pub fn write_all(fd: c_int, text: &[u8]) {
    if let Some(next) = next!("write", as Write) {
        // SAFETY: the bytes are valid for their length.
        unsafe { next(fd, text.as_ptr().cast(), text.len()) };
    }
}

/// Defines `ftruncate` and its other name.
macro_rules! truncates {
    ($($name:ident)*) => {$(
        /// Sets a file's length; a device has none.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(fd: c_int, len: i64) -> c_int {
            let Some(next) = next!(stringify!($name), as unsafe extern "C" fn(c_int, i64) -> c_int) else {
                return fail(abi::ENOSYS);
            };
            // SAFETY: the arguments are the caller's.
            let result = unsafe { next(fd, len) };
            if result == -1 && abi::errno() == abi::EPERM {
                let is_ours = device().is_some_and(|device| device.is_memory_fd(fd));
                return fail(if is_ours { abi::EINVAL } else { abi::EPERM });
            }
            result
        }
    )*};
}

truncates! { ftruncate ftruncate64 }

/// `struct iovec`.
#[repr(C)]
pub struct Vector {
    bytes: *const c_void,
    len: usize,
}

/// Writes several buffers, to the framebuffer one after the other.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn writev(fd: c_int, vectors: *const Vector, count: c_int) -> isize {
    type Next = unsafe extern "C" fn(c_int, *const Vector, c_int) -> isize;
    let Some(next) = next!("writev", as Next) else { return fail(abi::ENOSYS) as isize };
    // SAFETY: the arguments are the caller's.
    let written = unsafe { next(fd, vectors, count) };
    if written != -1 || abi::errno() != abi::EPERM {
        return written;
    }
    let mut total = 0;
    for at in 0..count.max(0) as usize {
        // SAFETY: the caller passes so many buffers, each with so many bytes.
        let (written, len) =
            unsafe { (write(fd, (*vectors.add(at)).bytes, (*vectors.add(at)).len), (*vectors.add(at)).len) };
        match written {
            -1 if total == 0 => return -1,
            -1 => return total,
            written => total += written,
        }
        if (written as usize) < len {
            break;
        }
    }
    total
}

/// Defines `lseek` and its other name.
macro_rules! seeks {
    ($($name:ident)*) => {$(
        /// Moves a descriptor's position. A device has no size: its end counts as 0.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(fd: c_int, offset: i64, whence: c_int) -> i64 {
            let is_end = whence == abi::SEEK_END && device().is_some_and(|device| device.is_memory_fd(fd));
            abi::next_lseek(fd, offset, if is_end { abi::SEEK_SET } else { whence })
        }
    )*};
}

seeks! { lseek lseek64 }

/// Defines functions that copy bytes from descriptor to descriptor inside the system: between
/// files, with the type of the C library's.
macro_rules! copies {
    ($($name:ident($($argument:ident: $kind:ty),*) of $from:ident and $to:ident;)*) => {$(
        /// Copies bytes between files; a device is none, and callers go on with `read` and `write`.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($($argument: $kind),*) -> isize {
            if device().is_some_and(|device| device.is_memory_fd($from) || device.is_memory_fd($to)) {
                return fail(abi::EINVAL) as isize;
            }
            match next!(stringify!($name), as unsafe extern "C" fn($($kind),*) -> isize) {
                // SAFETY: the arguments are the caller's.
                Some(next) => unsafe { next($($argument),*) },
                None => fail(abi::ENOSYS) as isize,
            }
        }
    )*};
}

copies! {
    copy_file_range(
        from: c_int, from_at: *mut i64, to: c_int, to_at: *mut i64, len: usize, flags: c_uint
    ) of from and to;
    sendfile(to: c_int, from: c_int, from_at: *mut i64, len: usize) of from and to;
    sendfile64(to: c_int, from: c_int, from_at: *mut i64, len: usize) of from and to;
    splice(
        from: c_int, from_at: *mut i64, to: c_int, to_at: *mut i64, len: usize, flags: c_uint
    ) of from and to;
}

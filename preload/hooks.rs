//! The calls on descriptors: `ioctl`, `mmap`, `write` and its kin at the end of the memory,
//! `ftruncate`, and `syscall` for programs that call the system by number.

use crate::abi::{self, fail, next, set_errno};
use crate::device::{Device, device};
use crate::{console, evdev, framebuffer, layout as at, open, paths};
use core::ffi::{c_char, c_int, c_long, c_uint, c_ulong, c_void};
use core::sync::atomic::Ordering;

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
            b'K' | b'V' if is_terminal(&device, fd) => done(console::request(&device, request, argument)),
            b'E' => match open::input_of(&device, fd)? {
                index @ 0..=1 => Some(evdev::request(&device, fd, index, request, argument)),
                _ => Some(Err(abi::EINVAL)),
            },
            _ => None,
        }
    }
}

/// Returns whether the descriptor is the pseudo terminal, also as `/dev/tty`.
fn is_terminal(device: &Device, fd: c_int) -> bool {
    const TIOCGDEV: c_ulong = 0x8004_5432;
    let Some(minor) = device.word(at::TERMINAL_AT).load(Ordering::Acquire).checked_sub(1) else {
        return false;
    };
    let (mut found, saved) = (0u32, abi::errno());
    let Some(next) = next!("ioctl", as Ioctl) else { return false };
    // SAFETY: the request writes the device number of a terminal, 32 bits, to its argument.
    let result = unsafe { next(fd, TIOCGDEV, core::ptr::from_mut(&mut found).cast()) };
    set_errno(saved);
    // 136 and the seven numbers after it are the majors of pseudo terminals.
    let number = abi::device_number(136 + u64::from(minor >> 8), u64::from(minor & 0xff));
    result == 0 && u64::from(found) == number
}

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
                return usize::MAX as *mut c_void;
            }
            match next!(stringify!($name), as Next) {
                // SAFETY: the arguments are the caller's.
                Some(next) => unsafe { next(address, len, access, flags, fd, offset) },
                None => {
                    set_errno(abi::ENOSYS);
                    usize::MAX as *mut c_void
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

type Write = unsafe extern "C" fn(c_int, *const c_void, usize) -> isize;
type Pwrite = unsafe extern "C" fn(c_int, *const c_void, usize, i64) -> isize;

/// Writes bytes to the framebuffer or to a file.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn write(fd: c_int, bytes: *const c_void, len: usize) -> isize {
    let Some(next) = next!("write", as Write) else { return fail(abi::ENOSYS) as isize };
    // SAFETY: the arguments are the caller's.
    let written = unsafe { next(fd, bytes, len) };
    if written != -1 || abi::errno() != abi::EPERM {
        return written;
    }
    // SAFETY: a call without pointers.
    let at = unsafe { abi::lseek(fd, 0, abi::SEEK_CUR) };
    // SAFETY: no more bytes than the caller has.
    at_end(fd, at, len, |rest| unsafe { next(fd, bytes, rest) })
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

type Syscall = unsafe extern "C" fn(c_long, usize, usize, usize, usize, usize, usize) -> c_long;

/// Calls the system by number: opening and requests as their functions above do.
///
/// # Safety
/// As for the C library's function, which takes six arguments at most.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn syscall(
    number: c_long,
    a: usize,
    b: usize,
    c: usize,
    d: usize,
    e: usize,
    f: usize,
) -> c_long {
    // SAFETY: the arguments are those of the call of this number.
    unsafe {
        match number {
            abi::SYS_OPEN if paths::place(a as *const c_char).is_some() => {
                return open::open(a as *const c_char, b as c_int, c as c_uint).into();
            }
            abi::SYS_OPENAT if paths::place(b as *const c_char).is_some() => {
                return open::openat(a as c_int, b as *const c_char, c as c_int, d as c_uint).into();
            }
            abi::SYS_IOCTL if matches!((b >> 8) as u8, b'F' | b'K' | b'V' | b'E') => {
                return ioctl(a as c_int, b as c_ulong, c as *mut c_void).into();
            }
            _ => {}
        }
    }
    match next!("syscall", as Syscall) {
        // SAFETY: the arguments are the caller's.
        Some(next) => unsafe { next(number, a, b, c, d, e, f) },
        None => fail(abi::ENOSYS).into(),
    }
}

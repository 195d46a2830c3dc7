//! Opening the device as a stream of the C library: `fopen`, `freopen` and their other names.

use crate::abi::{self, next};
use crate::open::open_place;
use core::ffi::{CStr, c_char, c_int, c_void};
use core::ptr;

type Fopen = unsafe extern "C" fn(*const c_char, *const c_char) -> *mut c_void;
type Freopen = unsafe extern "C" fn(*const c_char, *const c_char, *mut c_void) -> *mut c_void;

/// Opens the device for a stream: its descriptor, and the stream's mode. A device has no end to
/// write at, so appending to it is writing. `None` if the path is the system's.
///
/// # Safety
/// Both are null or C strings.
unsafe fn open_for(path: *const c_char, mode: *const c_char) -> Option<(c_int, &'static CStr)> {
    if mode.is_null() {
        return None;
    }
    // SAFETY: it is a C string, says the caller.
    let letters = unsafe { CStr::from_ptr(mode) }.to_bytes();
    let (access, mode) = match (letters.first()?, letters.contains(&b'+')) {
        (b'r' | b'w' | b'a', true) => (abi::O_RDWR, c"r+"),
        (b'r', false) => (0, c"r"),
        (b'w' | b'a', false) => (1, c"w"),
        _ => return None,
    };
    let close_on_exec = if letters.contains(&b'e') { abi::O_CLOEXEC } else { 0 };
    // SAFETY: the caller's promise.
    Some((unsafe { open_place(abi::AT_FDCWD, path, access | close_on_exec) }?, mode))
}

/// Defines functions that open a path as a stream.
macro_rules! fopens {
    ($($name:ident)*) => {$(
        /// Opens the device as a stream, or what the C library's function of this name opens.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(path: *const c_char, mode: *const c_char) -> *mut c_void {
            // SAFETY: the caller passes C strings.
            match unsafe { open_for(path, mode) } {
                Some((..0, _)) => return ptr::null_mut(),
                // SAFETY: the descriptor is open, and the stream takes it over.
                Some((fd, mode)) => return unsafe { abi::fdopen(fd, mode.as_ptr()) },
                None => {}
            }
            match next!(stringify!($name), as Fopen) {
                // SAFETY: the arguments are the caller's.
                Some(next) => unsafe { next(path, mode) },
                None => ptr::null_mut(),
            }
        }
    )*};
}

fopens! { fopen fopen64 }

/// Defines functions that open a path with a stream that there is.
macro_rules! freopens {
    ($($name:ident)*) => {$(
        /// Opens the device, or what the C library's function opens, with a stream that is open.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            path: *const c_char, mode: *const c_char, stream: *mut c_void,
        ) -> *mut c_void {
            let Some(next) = next!(stringify!($name), as Freopen) else { return ptr::null_mut() };
            // SAFETY: the caller passes C strings, or no path.
            let Some((fd, own_mode)) = (unsafe { open_for(path, mode) }) else {
                // SAFETY: the arguments are the caller's.
                return unsafe { next(path, mode, stream) };
            };
            // SAFETY: the stream is the caller's; the descriptor is ours and becomes the stream's.
            unsafe { put_in(stream, fd, own_mode, next) }
        }
    )*};
}

freopens! { freopen freopen64 }

/// Puts a descriptor in a stream, in which the C library has opened nothing of importance. A
/// descriptor of -1 closes the stream.
unsafe fn put_in(stream: *mut c_void, fd: c_int, mode: &CStr, next: Freopen) -> *mut c_void {
    let error = abi::errno();
    // SAFETY: the stream is open, and the texts are C strings.
    unsafe {
        let path = if fd < 0 { c"" } else { c"/dev/null" };
        let stream = next(path.as_ptr(), mode.as_ptr(), stream);
        if fd < 0 {
            abi::set_errno(error);
        } else {
            if !stream.is_null() {
                abi::dup3(fd, abi::fileno(stream), 0);
            }
            abi::close(fd);
        }
        stream
    }
}

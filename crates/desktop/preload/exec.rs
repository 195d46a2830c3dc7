//! Starting other programs: what an environment lacks of the device is added to it, so that
//! programs that clear it (`env -i`, `clearenv`) keep the device. A program into which no library
//! can be preloaded is told of.

use crate::abi::{self, fail, next};
use crate::device::{Device, device};
use crate::layout::ENVIRONMENT;
use crate::paths::ROOM as PATH_ROOM;
use crate::text::Text;
use crate::unserved::{self, Program};
use core::ffi::{CStr, c_char, c_int, c_void};
use core::ptr;

/// Words of an environment that is completed; longer ones are passed on as they are. Nothing is
/// allocated: the caller may be a child that shares its parent's memory.
const ROOM: usize = 1024;
/// Bytes of the loader's variable, as it is completed.
const PRELOAD_ROOM: usize = 1024;
/// Name of the loader's variable, with its equals sign.
const PRELOAD: &[u8] = b"LD_PRELOAD=";

/// A vector of C strings that ends with a null pointer.
pub type Words = *const *const c_char;

/// Calls `start` with an environment in which the device is found.
///
/// # Safety
/// `theirs` is null or a vector of C strings.
unsafe fn with_device<T>(theirs: Words, start: impl FnOnce(Words) -> T) -> T {
    let Some((device, library)) = device().and_then(|device| Some((device, device.library_path()?))) else {
        return start(theirs);
    };
    let own = device.variable();
    let mut words = [ptr::null(); ROOM];
    let (mut len, mut has_device, mut preload_at) = (0, false, None);
    // SAFETY: the caller's promise, up to the null pointer.
    while let Some(text) = unsafe { word(theirs, len) } {
        if len + 3 > ROOM {
            return start(theirs);
        }
        if text.starts_with(ENVIRONMENT.as_bytes()) && text.get(ENVIRONMENT.len()) == Some(&b'=') {
            // Another device than ours: that program has been started by another `fbptr`.
            if text != own.as_bytes() {
                return start(theirs);
            }
            has_device = true;
        } else if text.starts_with(PRELOAD) {
            preload_at = Some(len);
        }
        words[len] = text.as_ptr().cast();
        len += 1;
    }
    let mut preload = Text::<PRELOAD_ROOM>::new();
    preload.push(PRELOAD).push(library.as_bytes());
    // SAFETY: as above.
    let others = preload_at.and_then(|at| unsafe { word(theirs, at) }).map(|text| &text[PRELOAD.len()..]);
    if let Some(others) = others {
        if others.windows(library.as_bytes().len()).any(|part| part == library.as_bytes()) && has_device {
            return start(theirs);
        }
        // What would not fit is not cut off.
        if preload.as_bytes().len() + others.len() + 2 > PRELOAD_ROOM {
            return start(theirs);
        }
        preload.push(b":").push(others);
    }
    words[preload_at.unwrap_or(len)] = preload.as_ptr();
    len += usize::from(preload_at.is_none());
    if !has_device {
        words[len] = own.as_ptr();
    }
    start(words.as_ptr())
}

/// Returns a word of a vector, `None` at its end.
///
/// # Safety
/// The vector is null or has that many words before it.
unsafe fn word<'a>(words: Words, at: usize) -> Option<&'a [u8]> {
    if words.is_null() {
        return None;
    }
    // SAFETY: the caller's promise; the words are C strings.
    unsafe {
        let text = *words.add(at);
        if text.is_null() { None } else { Some(CStr::from_ptr(text).to_bytes()) }
    }
}

/// Defines functions that start a program with a given environment.
macro_rules! starts {
    ($(
        $name:ident($($before:ident: $kind:ty),*; environment $(, $after:ident: $after_kind:ty)?) of $program:expr;
    )*) => {$(
        /// Starts a program, with the device in its environment.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            $($before: $kind,)* environment: Words $(, $after: $after_kind)?
        ) -> c_int {
            type Next = unsafe extern "C" fn($($kind,)* Words $(, $after_kind)?) -> c_int;
            let Some(next) = next!(stringify!($name), as Next) else { return fail(abi::ENOSYS) };
            // SAFETY: the caller passes C strings.
            unsafe { unserved::tell($program) };
            // SAFETY: the arguments are the caller's; the environment is valid during the call.
            unsafe { with_device(environment, |environment| next($($before,)* environment $(, $after)?)) }
        }
    )*};
}

starts! {
    execve(path: *const c_char, words: Words; environment) of Program::Path(abi::AT_FDCWD, path);
    execvpe(path: *const c_char, words: Words; environment) of Program::Name(path);
    fexecve(fd: c_int, words: Words; environment) of Program::Descriptor(fd);
    execveat(folder: c_int, path: *const c_char, words: Words; environment, flags: c_int)
        of Program::Path(folder, path);
    posix_spawn(
        pid: *mut c_int, path: *const c_char, actions: *const c_void, attributes: *const c_void, words: Words;
        environment
    ) of Program::Path(abi::AT_FDCWD, path);
    posix_spawnp(
        pid: *mut c_int, path: *const c_char, actions: *const c_void, attributes: *const c_void, words: Words;
        environment
    ) of Program::Name(path);
}

/// Starts a program with the environment of this process.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn execv(path: *const c_char, words: Words) -> c_int {
    // SAFETY: the arguments are the caller's, and `environ` is the process's.
    unsafe { execve(path, words, abi::environ) }
}

/// Starts a program of `PATH` with the environment of this process.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn execvp(path: *const c_char, words: Words) -> c_int {
    // SAFETY: as in `execv`.
    unsafe { execvpe(path, words, abi::environ) }
}

/// Puts the device's variables back into the environment of this process.
fn restore() {
    if let Some((device, library)) =
        device().and_then(|device: Device| Some((device, device.library_path()?)))
    {
        let value = device.value();
        // SAFETY: names and values are C strings, which are copied. A system without memory for
        // them leaves the device out.
        unsafe {
            abi::setenv(c"FBPTR_RUN".as_ptr(), value.as_ptr(), 1);
            let preloaded = abi::getenv(c"LD_PRELOAD".as_ptr());
            let mut text = Text::<PATH_ROOM>::new();
            text.push(library.as_bytes());
            if !preloaded.is_null() {
                let others = CStr::from_ptr(preloaded).to_bytes();
                if others.windows(library.as_bytes().len()).any(|part| part == library.as_bytes()) {
                    return;
                }
                if !others.is_empty() && others.len() + text.as_bytes().len() + 2 < PATH_ROOM {
                    text.push(b":").push(others);
                }
            }
            abi::setenv(c"LD_PRELOAD".as_ptr(), text.as_ptr(), 1);
        }
    }
}

/// Clears the environment but for the device.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearenv() -> c_int {
    let Some(next) = next!("clearenv", as unsafe extern "C" fn() -> c_int) else { return fail(abi::ENOSYS) };
    // SAFETY: as the caller's.
    let result = unsafe { next() };
    restore();
    result
}

/// Runs a command of the shell, which the C library starts by a way of its own.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn system(command: *const c_char) -> c_int {
    restore();
    match next!("system", as unsafe extern "C" fn(*const c_char) -> c_int) {
        // SAFETY: the argument is the caller's.
        Some(next) => unsafe { next(command) },
        None => fail(abi::ENOSYS),
    }
}

/// Runs a command of the shell with a pipe, which the C library starts by a way of its own.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popen(command: *const c_char, mode: *const c_char) -> *mut c_void {
    type Next = unsafe extern "C" fn(*const c_char, *const c_char) -> *mut c_void;
    restore();
    match next!("popen", as Next) {
        // SAFETY: the arguments are the caller's.
        Some(next) => unsafe { next(command, mode) },
        None => ptr::null_mut(),
    }
}

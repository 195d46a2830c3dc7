//! The folders of the device: those that only it has, and those of the system that list it, too.
//!
//! A program may open a folder, go there, and name files from it, so each folder of the device's
//! own is a real one that stands in for it: one below `/proc/PID` of the program `fbptr`, which
//! nothing is left of. The library knows it by its path.

use crate::abi::{self, fail, next};
use crate::device::{Device, device};
use crate::paths::{self, INPUTS, PathText, Place, place};
use crate::sysfs;
use core::ffi::{c_char, c_int};
use core::ptr;

/// A folder that lists places of the device.
pub struct Folder {
    pub path: &'static [u8],
    /// Name of the folder below `/proc/PID` that stands in for it; empty if the system's own is
    /// listed, with the device's names beside those that it has.
    stand_in: &'static [u8],
}

/// The folders.
pub const FOLDERS: [Folder; 5] = [
    Folder { path: b"/sys/class/graphics/fb0", stand_in: b"task" },
    Folder { path: b"/sys/class/graphics", stand_in: b"attr" },
    Folder { path: b"/dev/input", stand_in: b"fdinfo" },
    Folder { path: b"/dev", stand_in: b"" },
    Folder { path: b"/sys/class", stand_in: b"" },
];

/// `DT_CHR`, `DT_DIR` and `DT_REG`.
const DEVICE: u8 = 2;
const DIRECTORY: u8 = 4;
const FILE: u8 = 8;

impl Folder {
    /// Returns whether it is the device's alone.
    pub fn is_own(&self) -> bool {
        !self.stand_in.is_empty()
    }

    /// Returns the name and the type of an entry; those of the device's own folders begin with `.`
    /// and `..`.
    pub fn entry(&self, at: usize) -> Option<(&'static [u8], u8)> {
        if self.is_own() && at < 2 {
            return Some((&b".."[..=at], DIRECTORY));
        }
        let at = if self.is_own() { at - 2 } else { at };
        let last = |path: &'static [u8]| path.rsplit(|b| *b == b'/').next().unwrap_or(path);
        match self.path {
            b"/sys/class/graphics/fb0" => sysfs::FILES.get(at).map(|file| (file.name, FILE)),
            b"/sys/class/graphics" => [(&b"fb0"[..], DIRECTORY)].get(at).copied(),
            b"/dev/input" => INPUTS.get(at).map(|(path, _)| (last(path), DEVICE)),
            b"/dev" => [(&b"fb0"[..], DEVICE), (b"input", DIRECTORY), (b"tty0", DEVICE)].get(at).copied(),
            _ => [(&b"graphics"[..], DIRECTORY)].get(at).copied(),
        }
    }

    fn stand_in(&self, device: &Device) -> PathText {
        let mut path = PathText::new();
        path.push(b"/proc/").number(device.pid).push(b"/").push(self.stand_in);
        path
    }
}

/// Returns the index of a folder that is the device's alone.
pub fn position(path: &[u8]) -> Option<usize> {
    FOLDERS.iter().position(|folder| folder.is_own() && folder.path == path)
}

/// Returns the index of the folder that a descriptor is open for, if it is one of these.
pub fn of_descriptor(fd: c_int) -> Option<usize> {
    device()?;
    let path = paths::path_of_descriptor(fd)?;
    FOLDERS.iter().position(|folder| folder.path == path.as_bytes())
}

/// Returns the path of the folder that this one stands in for.
pub fn seen_as(path: &[u8]) -> Option<PathText> {
    let device = device()?;
    let folder =
        FOLDERS.iter().find(|folder| folder.is_own() && folder.stand_in(&device).as_bytes() == path)?;
    let mut seen = PathText::new();
    seen.push(folder.path);
    Some(seen)
}

/// Opens a folder that is the device's alone.
pub fn open(device: &Device, index: usize, flags: c_int) -> c_int {
    let path = FOLDERS[index].stand_in(device);
    let flags = flags & !(abi::O_CREAT | abi::O_EXCL) | abi::O_DIRECTORY;
    // SAFETY: the path is a C string.
    unsafe { abi::next_openat(abi::AT_FDCWD, path.as_ptr(), flags) }
}

/// Changes the current folder.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chdir(path: *const c_char) -> c_int {
    let Some(next) = next!("chdir", as unsafe extern "C" fn(*const c_char) -> c_int) else {
        return fail(abi::ENOSYS);
    };
    // SAFETY: the caller passes a C string.
    match unsafe { place(abi::AT_FDCWD, path, true) }.zip(device()) {
        Some((Place::Folder(index), device)) => {
            let stand_in = FOLDERS[index].stand_in(&device);
            // SAFETY: the path is a C string.
            unsafe { next(stand_in.as_ptr()) }
        }
        Some(_) => fail(abi::ENOTDIR),
        // SAFETY: the argument is the caller's.
        None => unsafe { next(path) },
    }
}

/// Returns the path of the current folder.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn getcwd(buffer: *mut c_char, len: usize) -> *mut c_char {
    type Next = unsafe extern "C" fn(*mut c_char, usize) -> *mut c_char;
    let Some(next) = next!("getcwd", as Next) else { return ptr::null_mut() };
    // SAFETY: the arguments are the caller's.
    let found = unsafe { next(buffer, len) };
    if found.is_null() {
        return found;
    }
    // SAFETY: the call has returned a C string.
    let path = unsafe { core::ffi::CStr::from_ptr(found) }.to_bytes();
    if let Some(seen) = path.starts_with(b"/proc/").then(|| seen_as(path)).flatten() {
        if buffer.is_null() && len == 0 {
            // SAFETY: the C library has allocated the path for the caller.
            unsafe { abi::free(found.cast()) };
            // SAFETY: the path is a C string.
            return unsafe { abi::strdup(seen.as_ptr()) };
        }
        let bytes = seen.as_bytes();
        if bytes.len() >= len {
            abi::set_errno(abi::ERANGE);
            return ptr::null_mut();
        }
        // SAFETY: the caller's buffer, or the one made for it, has `len` bytes, more than these.
        unsafe { ptr::copy_nonoverlapping(seen.as_ptr(), found, bytes.len() + 1) };
    }
    found
}

/// Returns the path of a place.
pub fn path_of(place: Place) -> PathText {
    let mut path = PathText::new();
    match place {
        Place::Framebuffer => path.push(b"/dev/fb0"),
        Place::Console(5, _) => path.push(b"/dev/console"),
        Place::Console(_, number) => path.push(b"/dev/tty").number(number.into()),
        Place::Input(index) => path.push(INPUTS[index].0),
        Place::Attribute(index) => path.push(b"/sys/class/graphics/fb0/").push(sysfs::FILES[index].name),
        Place::Folder(index) => path.push(FOLDERS[index].path),
        Place::List => path.push(b"/proc/fb"),
    };
    path
}

/// Returns a path without links and detours.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn realpath(path: *const c_char, buffer: *mut c_char) -> *mut c_char {
    type Next = unsafe extern "C" fn(*const c_char, *mut c_char) -> *mut c_char;
    // SAFETY: the caller passes a C string.
    if let Some(place) = unsafe { place(abi::AT_FDCWD, path, true) } {
        let real = path_of(place);
        if buffer.is_null() {
            // SAFETY: the path is a C string.
            return unsafe { abi::strdup(real.as_ptr()) };
        }
        // SAFETY: the caller's buffer has PATH_MAX bytes, 4096.
        unsafe { ptr::copy_nonoverlapping(real.as_ptr(), buffer, real.as_bytes().len() + 1) };
        return buffer;
    }
    match next!("realpath", as Next) {
        // SAFETY: the arguments are the caller's.
        Some(next) => unsafe { next(path, buffer) },
        None => ptr::null_mut(),
    }
}

/// Returns a path without links and detours, in memory of its own.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canonicalize_file_name(path: *const c_char) -> *mut c_char {
    // SAFETY: the argument is the caller's.
    unsafe { realpath(path, ptr::null_mut()) }
}

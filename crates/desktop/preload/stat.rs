//! The status of the device's paths and descriptors: `stat`, `fstat`, `lstat`, `fstatat`, `statx`,
//! `access`, and the older names of the same.

use crate::abi::{self, Stat, Statx, device_number, fail, next};
use crate::device::{Device, device, status};
use crate::folders::{self, FOLDERS};
use crate::open::input_of;
use crate::paths::{FRAMEBUFFER_MAJOR, INPUT_MAJOR, INPUTS, Place, place, without_detours};
use crate::sysfs::FILES;
use crate::terminal;
use core::ffi::{c_char, c_int, c_uint};

/// Facts about a place: type and rights, the device's numbers, and the file's own: `cp` compares
/// them by path and by descriptor.
#[derive(Clone, Copy)]
struct Facts {
    mode: u32,
    major: u64,
    minor: u64,
    inode: u64,
}

fn facts(device: &Device, place: Place) -> Option<Facts> {
    let of_device = |major, minor, inode| Some(Facts { mode: abi::S_IFCHR | 0o660, major, minor, inode });
    let of_file = |mode, inode| Some(Facts { mode, major: 0, minor: 0, inode });
    match place {
        Place::Framebuffer => of_device(FRAMEBUFFER_MAJOR, 0, device.inode()),
        // Numbers that the memory does not have.
        Place::Input(index) => of_device(INPUT_MAJOR, INPUTS[index].1, u64::MAX - index as u64),
        Place::Console(major, minor) => {
            of_device(major.into(), minor.into(), u64::MAX / 2 - u64::from(major) * 256 - u64::from(minor))
        }
        Place::Attribute(index) => {
            let rights = if FILES[index].is_writable { 0o644 } else { 0o444 };
            of_file(abi::S_IFREG | rights, 16 + index as u64)
        }
        Place::List => of_file(abi::S_IFREG | 0o444, 1),
        Place::Folder(index) => of_file(abi::S_IFDIR | 0o755, 2 + index as u64),
    }
}

impl Facts {
    fn fill(&self, status: &mut Stat) {
        status.mode = self.mode;
        status.rdev = device_number(self.major, self.minor);
        // On file system 0 `ls` looks for no rights beyond these, which only real paths have.
        (status.dev, status.ino, status.nlink) = (0, self.inode, 1);
        (status.size, status.blocks) = (0, 0);
    }

    /// Returns the status of a place that the file system does not have.
    fn status(&self) -> Stat {
        // SAFETY: an all-zero `Stat` is valid.
        let mut status: Stat = unsafe { core::mem::zeroed() };
        // SAFETY: calls without arguments.
        (status.uid, status.gid) = unsafe { (abi::getuid(), abi::getgid()) };
        status.block_size = 4096;
        self.fill(&mut status);
        status
    }
}

/// Returns the facts of a path that the library stands for.
///
/// # Safety
/// `path` is null or a C string.
unsafe fn facts_of_path(folder: c_int, path: *const c_char, flags: c_int) -> Option<Facts> {
    // SAFETY: the caller's promise.
    let place = unsafe { place(folder, path, flags & NO_FOLLOW == 0) }?;
    facts(&device()?, place)
}

/// Returns the facts of a descriptor that the device gave, by its status.
fn facts_of(device: &Device, fd: c_int, status: &Stat) -> Option<Facts> {
    if device.is_memory(status.dev, status.ino) {
        return facts(device, Place::Framebuffer);
    }
    match status.mode & abi::S_IFMT {
        abi::S_IFSOCK => input_of(device, fd).and_then(|index| facts(device, Place::Input(index))),
        abi::S_IFDIR => {
            let index = folders::of_descriptor(fd).filter(|index| FOLDERS[*index].is_own())?;
            facts(device, Place::Folder(index))
        }
        // A pseudo terminal; `/dev/tty` has numbers of its own.
        abi::S_IFCHR if matches!(status.rdev >> 8 & 0xfff, 136..=143) => {
            terminal::place_of_descriptor(device, fd).and_then(|place| facts(device, place))
        }
        _ => None,
    }
}

/// Calls the C library's `fstat`, or its older name.
pub fn next_fstat(fd: c_int, status: &mut Stat) -> c_int {
    type Old = unsafe extern "C" fn(c_int, c_int, *mut Stat) -> c_int;
    if let Some(next) = next!("fstat", as unsafe extern "C" fn(c_int, *mut Stat) -> c_int) {
        // SAFETY: the status is valid for writing.
        return unsafe { next(fd, status) };
    }
    match next!("__fxstat", as Old) {
        // SAFETY: as above; 1 is the version of `struct stat` on x86-64, 0 elsewhere.
        Some(next) => unsafe { next(cfg!(target_arch = "x86_64").into(), fd, status) },
        None => fail(abi::ENOSYS),
    }
}

/// Calls the C library's `fstatat`, or its older name.
///
/// # Safety
/// As for the C library's function.
unsafe fn next_fstatat(folder: c_int, path: *const c_char, status: *mut Stat, flags: c_int) -> c_int {
    type New = unsafe extern "C" fn(c_int, *const c_char, *mut Stat, c_int) -> c_int;
    type Old = unsafe extern "C" fn(c_int, c_int, *const c_char, *mut Stat, c_int) -> c_int;
    if let Some(next) = next!("fstatat", as New) {
        // SAFETY: the arguments are the caller's.
        return unsafe { next(folder, path, status, flags) };
    }
    match next!("__fxstatat", as Old) {
        // SAFETY: the arguments are the caller's.
        Some(next) => unsafe { next(cfg!(target_arch = "x86_64").into(), folder, path, status, flags) },
        None => fail(abi::ENOSYS),
    }
}

unsafe fn status_of_path(folder: c_int, path: *const c_char, status: *mut Stat, flags: c_int) -> c_int {
    // SAFETY: the caller passes a C string.
    if let Some(facts) = unsafe { facts_of_path(folder, path, flags) } {
        // SAFETY: the caller passes a status to write to.
        unsafe { *status = facts.status() };
        return 0;
    }
    // SAFETY: the arguments are the caller's; a path that is not null is a C string.
    if flags & abi::AT_EMPTY_PATH != 0 && (path.is_null() || unsafe { *path } == 0) {
        // SAFETY: as above.
        return unsafe { status_of_fd(folder, status) };
    }
    // SAFETY: the arguments are the caller's; the other path is a C string.
    unsafe {
        match next_fstatat(folder, path, status, flags) {
            -1 if abi::errno() == abi::ENOENT => match without_detours(path) {
                Some(path) => next_fstatat(folder, path.as_ptr(), status, flags),
                None => fail(abi::ENOENT),
            },
            result => result,
        }
    }
}

unsafe fn status_of_fd(fd: c_int, status: *mut Stat) -> c_int {
    // SAFETY: the caller passes a status to write to.
    let status = unsafe { &mut *status };
    let result = next_fstat(fd, status);
    if result == 0
        && let Some(facts) = device().and_then(|device| facts_of(&device, fd, status))
    {
        facts.fill(status);
    }
    result
}

/// Defines the names of the functions that return a status.
macro_rules! stats {
    ($($name:ident($($argument:ident: $kind:ty),*) = $call:expr;)*) => {$(
        /// Returns the status of the device, or of what the C library's function of this name does.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($($argument: $kind),*) -> c_int {
            // SAFETY: the arguments are the caller's.
            unsafe { $call }
        }
    )*};
}

const NO_FOLLOW: c_int = 0x100;

stats! {
    stat(path: *const c_char, status: *mut Stat) = status_of_path(abi::AT_FDCWD, path, status, 0);
    stat64(path: *const c_char, status: *mut Stat) = status_of_path(abi::AT_FDCWD, path, status, 0);
    lstat(path: *const c_char, status: *mut Stat) = status_of_path(abi::AT_FDCWD, path, status, NO_FOLLOW);
    lstat64(path: *const c_char, status: *mut Stat) = status_of_path(abi::AT_FDCWD, path, status, NO_FOLLOW);
    fstat(fd: c_int, status: *mut Stat) = status_of_fd(fd, status);
    fstat64(fd: c_int, status: *mut Stat) = status_of_fd(fd, status);
    fstatat(folder: c_int, path: *const c_char, status: *mut Stat, flags: c_int)
        = status_of_path(folder, path, status, flags);
    fstatat64(folder: c_int, path: *const c_char, status: *mut Stat, flags: c_int)
        = status_of_path(folder, path, status, flags);
    __xstat(_version: c_int, path: *const c_char, status: *mut Stat)
        = status_of_path(abi::AT_FDCWD, path, status, 0);
    __xstat64(_version: c_int, path: *const c_char, status: *mut Stat)
        = status_of_path(abi::AT_FDCWD, path, status, 0);
    __lxstat(_version: c_int, path: *const c_char, status: *mut Stat)
        = status_of_path(abi::AT_FDCWD, path, status, NO_FOLLOW);
    __lxstat64(_version: c_int, path: *const c_char, status: *mut Stat)
        = status_of_path(abi::AT_FDCWD, path, status, NO_FOLLOW);
    __fxstat(_version: c_int, fd: c_int, status: *mut Stat) = status_of_fd(fd, status);
    __fxstat64(_version: c_int, fd: c_int, status: *mut Stat) = status_of_fd(fd, status);
    __fxstatat(_version: c_int, folder: c_int, path: *const c_char, status: *mut Stat, flags: c_int)
        = status_of_path(folder, path, status, flags);
    __fxstatat64(_version: c_int, folder: c_int, path: *const c_char, status: *mut Stat, flags: c_int)
        = status_of_path(folder, path, status, flags);
    access(path: *const c_char, mode: c_int) = access_of(abi::AT_FDCWD, path, mode, 0);
    euidaccess(path: *const c_char, mode: c_int) = access_of(abi::AT_FDCWD, path, mode, 0x200);
    eaccess(path: *const c_char, mode: c_int) = access_of(abi::AT_FDCWD, path, mode, 0x200);
    faccessat(folder: c_int, path: *const c_char, mode: c_int, flags: c_int)
        = access_of(folder, path, mode, flags);
}

unsafe fn access_of(folder: c_int, path: *const c_char, mode: c_int, flags: c_int) -> c_int {
    // SAFETY: the caller passes a C string.
    if let Some(facts) = unsafe { facts_of_path(folder, path, flags) } {
        // Rights of the owner: 4 read, 2 write, 1 execute.
        let has = (facts.mode >> 6 & 7) as c_int;
        return if mode & !has == 0 { 0 } else { fail(abi::EACCES) };
    }
    match next!("faccessat", as unsafe extern "C" fn(c_int, *const c_char, c_int, c_int) -> c_int) {
        // SAFETY: the arguments are the caller's.
        Some(next) => unsafe { next(folder, path, mode, flags) },
        None => fail(abi::ENOSYS),
    }
}

/// Returns the extended status of the device, or of what `statx` does.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn statx(
    folder: c_int,
    path: *const c_char,
    flags: c_int,
    mask: c_uint,
    extended: *mut Statx,
) -> c_int {
    type Next = unsafe extern "C" fn(c_int, *const c_char, c_int, c_uint, *mut Statx) -> c_int;
    // SAFETY: the caller passes a C string, or null.
    if let Some(facts) = unsafe { facts_of_path(folder, path, flags) } {
        // SAFETY: an all-zero `Statx` is valid, and the caller passes one to write to.
        unsafe {
            *extended = core::mem::zeroed();
            (*extended).mask = 0x7ff;
            facts.fill_extended(&mut *extended);
            ((*extended).uid, (*extended).gid) = (abi::getuid(), abi::getgid());
        }
        return 0;
    }
    let Some(next) = next!("statx", as Next) else { return fail(abi::ENOSYS) };
    // SAFETY: the arguments are the caller's; the other path is a C string.
    let result = unsafe {
        match next(folder, path, flags, mask, extended) {
            -1 if abi::errno() == abi::ENOENT => match without_detours(path) {
                Some(path) => next(folder, path.as_ptr(), flags, mask, extended),
                None => fail(abi::ENOENT),
            },
            result => result,
        }
    };
    // SAFETY: a path that is not null is a C string.
    let is_fd = flags & abi::AT_EMPTY_PATH != 0 && (path.is_null() || unsafe { *path } == 0);
    if result == 0
        && is_fd
        && let Some(facts) =
            device().and_then(|device| status(folder).and_then(|s| facts_of(&device, folder, &s)))
    {
        // SAFETY: the call has filled it.
        facts.fill_extended(unsafe { &mut *extended });
    }
    result
}

impl Facts {
    fn fill_extended(&self, extended: &mut Statx) {
        extended.mode = self.mode as u16;
        (extended.rdev_major, extended.rdev_minor) = (self.major as u32, self.minor as u32);
        (extended.size, extended.blocks, extended.nlink) = (0, 0, 1);
        extended.block_size = 4096;
        extended.ino = self.inode;
        (extended.dev_major, extended.dev_minor) = (0, 0);
    }
}

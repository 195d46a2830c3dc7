//! The C library's functions and constants that the library uses, declared by hand for Linux on 64
//! bits, where `struct stat` and `off_t` have one size only.

use core::ffi::{c_char, c_int, c_long, c_uint, c_void};

unsafe extern "C" {
    pub fn abort() -> !;
    pub fn dlsym(handle: *mut c_void, name: *const c_char) -> *mut c_void;
    pub fn getenv(name: *const c_char) -> *const c_char;
    pub fn setenv(name: *const c_char, value: *const c_char, overwrite: c_int) -> c_int;
    pub static environ: *const *const c_char;
    pub fn __errno_location() -> *mut c_int;
    pub fn close(fd: c_int) -> c_int;
    pub fn socket(domain: c_int, kind: c_int, protocol: c_int) -> c_int;
    pub fn connect(fd: c_int, address: *const c_void, len: c_uint) -> c_int;
    pub fn getpeername(fd: c_int, address: *mut c_void, len: *mut c_uint) -> c_int;
    pub fn send(fd: c_int, bytes: *const c_void, len: usize, flags: c_int) -> isize;
    pub fn memfd_create(name: *const c_char, flags: c_uint) -> c_int;
    pub fn flock(fd: c_int, operation: c_int) -> c_int;
    pub fn getuid() -> c_uint;
    pub fn getgid() -> c_uint;
    pub fn getpid() -> c_int;
    pub fn fdopen(fd: c_int, mode: *const c_char) -> *mut c_void;
    pub fn fileno(stream: *mut c_void) -> c_int;
    pub fn dirfd(stream: *mut c_void) -> c_int;
    pub fn fcntl(fd: c_int, command: c_int, ...) -> c_int;
    pub fn dup3(from: c_int, to: c_int, flags: c_int) -> c_int;
    pub fn read(fd: c_int, bytes: *mut c_void, len: usize) -> isize;
    pub fn pread(fd: c_int, bytes: *mut c_void, len: usize, offset: i64) -> isize;
    pub fn getxattr(path: *const c_char, name: *const c_char, value: *mut c_void, len: usize) -> isize;
    pub fn geteuid() -> c_uint;
    pub fn getegid() -> c_uint;
    pub fn clock_gettime(clock: c_int, time: *mut Timespec) -> c_int;
    pub fn malloc(len: usize) -> *mut c_void;
    pub fn realloc(memory: *mut c_void, len: usize) -> *mut c_void;
    pub fn free(memory: *mut c_void);
    pub fn strdup(text: *const c_char) -> *mut c_char;
    pub fn qsort(
        memory: *mut c_void,
        count: usize,
        size: usize,
        compare: unsafe extern "C" fn(*const c_void, *const c_void) -> c_int,
    );
}

/// Returns the next function of this name after this library's own, of the type that the caller
/// names; `None` if there is none.
macro_rules! next {
    ($name:expr, as $kind:ty) => {{
        static PLACE: core::sync::atomic::AtomicUsize = core::sync::atomic::AtomicUsize::new(0);
        let mut place = PLACE.load(core::sync::atomic::Ordering::Relaxed);
        if place == 0 {
            // SAFETY: the name ends with a zero byte, and the handle is RTLD_NEXT.
            place = unsafe { $crate::abi::dlsym(usize::MAX as *mut _, concat!($name, "\0").as_ptr().cast()) }
                as usize;
            PLACE.store(place, core::sync::atomic::Ordering::Relaxed);
        }
        // SAFETY: a symbol of this name is the C library's function, whose type is the one named; 0
        // is the `None` of an `Option` of a function.
        unsafe { core::mem::transmute::<usize, Option<$kind>>(place) }
    }};
}
pub(crate) use next;

/// Calls the C library's `openat`.
///
/// # Safety
/// As for the C library's function.
pub unsafe fn next_openat(folder: c_int, path: *const c_char, flags: c_int) -> c_int {
    type Next = unsafe extern "C" fn(c_int, *const c_char, c_int, c_int) -> c_int;
    match next!("openat", as Next) {
        // SAFETY: the arguments are the caller's.
        Some(next) => unsafe { next(folder, path, flags, 0) },
        None => fail(ENOSYS),
    }
}

/// Calls the C library's `readlinkat`.
///
/// # Safety
/// As for the C library's function.
pub unsafe fn next_readlinkat(folder: c_int, path: *const c_char, bytes: *mut c_char, len: usize) -> isize {
    type Next = unsafe extern "C" fn(c_int, *const c_char, *mut c_char, usize) -> isize;
    match next!("readlinkat", as Next) {
        // SAFETY: the arguments are the caller's.
        Some(next) => unsafe { next(folder, path, bytes, len) },
        None => fail(ENOSYS) as isize,
    }
}

/// Calls the C library's `lseek`.
pub fn next_lseek(fd: c_int, offset: i64, whence: c_int) -> i64 {
    match next!("lseek", as unsafe extern "C" fn(c_int, i64, c_int) -> i64) {
        // SAFETY: a call without pointers.
        Some(next) => unsafe { next(fd, offset, whence) },
        None => fail(ENOSYS).into(),
    }
}

pub const AT_FDCWD: c_int = -100;
pub const AT_EMPTY_PATH: c_int = 0x1000;

pub const O_ACCMODE: c_int = 3;
pub const O_RDWR: c_int = 2;
pub const O_CREAT: c_int = 0o100;
pub const O_EXCL: c_int = 0o200;
pub const O_NOCTTY: c_int = 0o400;
pub const O_NONBLOCK: c_int = 0o4000;
pub const O_DSYNC: c_int = 0o10000;
pub const O_SYNC: c_int = 0o4010000;
pub const O_CLOEXEC: c_int = 0o2000000;
pub const O_PATH: c_int = 0o10000000;
#[cfg(target_arch = "x86_64")]
pub const O_DIRECTORY: c_int = 0o200000;
#[cfg(not(target_arch = "x86_64"))]
pub const O_DIRECTORY: c_int = 0o40000;

pub const EPERM: c_int = 1;
pub const ENOENT: c_int = 2;
pub const EINTR: c_int = 4;
pub const E2BIG: c_int = 7;
pub const ENOMEM: c_int = 12;
pub const EACCES: c_int = 13;
pub const EFAULT: c_int = 14;
pub const EEXIST: c_int = 17;
pub const ENODEV: c_int = 19;
pub const ENOTDIR: c_int = 20;
pub const EISDIR: c_int = 21;
pub const EINVAL: c_int = 22;
pub const ENOTTY: c_int = 25;
pub const EFBIG: c_int = 27;
pub const ENOSPC: c_int = 28;
pub const ERANGE: c_int = 34;
pub const ENOSYS: c_int = 38;
pub const ETIMEDOUT: c_int = 110;

pub const S_IFCHR: u32 = 0o020000;
pub const S_IFDIR: u32 = 0o040000;
pub const S_IFREG: u32 = 0o100000;
pub const S_IFMT: u32 = 0o170000;
pub const S_IFSOCK: u32 = 0o140000;

pub const SEEK_SET: c_int = 0;
pub const SEEK_CUR: c_int = 1;
pub const SEEK_END: c_int = 2;
pub const CLOCK_MONOTONIC: c_int = 1;
pub const F_GETFL: c_int = 3;
pub const LOCK_EX: c_int = 2;
pub const MAP_SHARED: c_int = 1;
pub const PROT_READ_WRITE: c_int = 3;
pub const AF_UNIX: u16 = 1;
pub const SOCK_STREAM: c_int = 1;
pub const MSG_NOSIGNAL: c_int = 0x4000;
pub const MFD_CLOEXEC: c_uint = 1;
pub const FUTEX_WAIT: c_long = 0;

/// Numbers of system calls.
#[cfg(target_arch = "x86_64")]
mod numbers {
    use core::ffi::c_long;
    pub const SYS_WRITE: c_long = 1;
    pub const SYS_OPEN: c_long = 2;
    pub const SYS_STAT: c_long = 4;
    pub const SYS_FSTAT: c_long = 5;
    pub const SYS_LSTAT: c_long = 6;
    pub const SYS_LSEEK: c_long = 8;
    pub const SYS_MMAP: c_long = 9;
    pub const SYS_IOCTL: c_long = 16;
    pub const SYS_PWRITE: c_long = 18;
    pub const SYS_ACCESS: c_long = 21;
    pub const SYS_MREMAP: c_long = 25;
    pub const SYS_EXECVE: c_long = 59;
    pub const SYS_FTRUNCATE: c_long = 77;
    pub const SYS_CHDIR: c_long = 80;
    pub const SYS_CREAT: c_long = 85;
    pub const SYS_FUTEX: c_long = 202;
    pub const SYS_OPENAT: c_long = 257;
    pub const SYS_FSTATAT: c_long = 262;
    pub const SYS_FACCESSAT: c_long = 269;
}
/// Numbers of system calls; -1 for those that there are not.
#[cfg(not(target_arch = "x86_64"))]
mod numbers {
    use core::ffi::c_long;
    pub const SYS_OPEN: c_long = -1;
    pub const SYS_STAT: c_long = -2;
    pub const SYS_LSTAT: c_long = -3;
    pub const SYS_ACCESS: c_long = -4;
    pub const SYS_CREAT: c_long = -5;
    pub const SYS_IOCTL: c_long = 29;
    pub const SYS_FTRUNCATE: c_long = 46;
    pub const SYS_FACCESSAT: c_long = 48;
    pub const SYS_CHDIR: c_long = 49;
    pub const SYS_OPENAT: c_long = 56;
    pub const SYS_LSEEK: c_long = 62;
    pub const SYS_WRITE: c_long = 64;
    pub const SYS_PWRITE: c_long = 68;
    pub const SYS_FSTATAT: c_long = 79;
    pub const SYS_FSTAT: c_long = 80;
    pub const SYS_FUTEX: c_long = 98;
    pub const SYS_MREMAP: c_long = 216;
    pub const SYS_EXECVE: c_long = 221;
    pub const SYS_MMAP: c_long = 222;
}
/// Numbers that all machines share.
pub const SYS_STATX: c_long = if cfg!(target_arch = "x86_64") { 332 } else { 291 };
pub const SYS_OPENAT2: c_long = 437;
pub const SYS_FACCESSAT2: c_long = 439;
pub use numbers::*;

/// `struct stat`.
#[repr(C)]
#[derive(Clone, Copy)]
#[cfg(target_arch = "x86_64")]
pub struct Stat {
    pub dev: u64,
    pub ino: u64,
    pub nlink: u64,
    pub mode: u32,
    pub uid: u32,
    pub gid: u32,
    pub pad: u32,
    pub rdev: u64,
    pub size: i64,
    pub block_size: i64,
    pub blocks: i64,
    pub times: [i64; 6],
    pub reserved: [i64; 3],
}

/// `struct stat`.
#[repr(C)]
#[derive(Clone, Copy)]
#[cfg(not(target_arch = "x86_64"))]
pub struct Stat {
    pub dev: u64,
    pub ino: u64,
    pub mode: u32,
    pub nlink: u32,
    pub uid: u32,
    pub gid: u32,
    pub rdev: u64,
    pub pad: u64,
    pub size: i64,
    pub block_size: i32,
    pub pad2: i32,
    pub blocks: i64,
    pub times: [i64; 6],
    pub reserved: [i32; 2],
}

/// `struct statx`, up to the fields that are changed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Statx {
    pub mask: u32,
    pub block_size: u32,
    pub attributes: u64,
    pub nlink: u32,
    pub uid: u32,
    pub gid: u32,
    pub mode: u16,
    pub pad: u16,
    pub ino: u64,
    pub size: u64,
    pub blocks: u64,
    pub attributes_mask: u64,
    pub times: [u64; 8],
    pub rdev_major: u32,
    pub rdev_minor: u32,
    pub dev_major: u32,
    pub dev_minor: u32,
    pub rest: [u64; 14],
}

/// `struct timespec`.
#[repr(C)]
pub struct Timespec {
    pub seconds: i64,
    pub nanoseconds: i64,
}

/// Sets `errno` and returns -1, as a failing call does.
pub fn fail(error: c_int) -> c_int {
    set_errno(error);
    -1
}

/// Sets `errno`.
pub fn set_errno(error: c_int) {
    // SAFETY: the C library gives the address of the thread's own errno.
    unsafe { *__errno_location() = error };
}

/// Returns `errno`.
pub fn errno() -> c_int {
    // SAFETY: as in `set_errno`.
    unsafe { *__errno_location() }
}

/// Returns the device number of a major and a minor number.
pub const fn device_number(major: u64, minor: u64) -> u64 {
    (major & 0xfff) << 8 | minor & 0xff | (minor & !0xff) << 12 | (major & !0xfff) << 32
}

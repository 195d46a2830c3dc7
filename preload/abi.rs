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
    pub fn lseek(fd: c_int, offset: i64, whence: c_int) -> i64;
    pub fn flock(fd: c_int, operation: c_int) -> c_int;
    pub fn getuid() -> c_uint;
    pub fn getgid() -> c_uint;
    pub fn fdopen(fd: c_int, mode: *const c_char) -> *mut c_void;
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

pub const AT_FDCWD: c_int = -100;
pub const AT_EMPTY_PATH: c_int = 0x1000;

pub const O_ACCMODE: c_int = 3;
pub const O_RDWR: c_int = 2;
pub const O_CREAT: c_int = 0o100;
pub const O_EXCL: c_int = 0o200;
pub const O_NONBLOCK: c_int = 0o4000;
pub const O_CLOEXEC: c_int = 0o2000000;
#[cfg(target_arch = "x86_64")]
pub const O_DIRECTORY: c_int = 0o200000;
#[cfg(not(target_arch = "x86_64"))]
pub const O_DIRECTORY: c_int = 0o40000;

pub const EPERM: c_int = 1;
pub const ENOENT: c_int = 2;
pub const EACCES: c_int = 13;
pub const EFAULT: c_int = 14;
pub const EEXIST: c_int = 17;
pub const ENODEV: c_int = 19;
pub const ENOTDIR: c_int = 20;
pub const EINVAL: c_int = 22;
pub const ENOTTY: c_int = 25;
pub const EFBIG: c_int = 27;
pub const ENOSPC: c_int = 28;
pub const ENOSYS: c_int = 38;
pub const ETIMEDOUT: c_int = 110;

pub const S_IFCHR: u32 = 0o020000;
pub const S_IFDIR: u32 = 0o040000;
pub const S_IFREG: u32 = 0o100000;
pub const S_IFMT: u32 = 0o170000;
pub const S_IFSOCK: u32 = 0o140000;

pub const SEEK_SET: c_int = 0;
pub const SEEK_CUR: c_int = 1;
pub const LOCK_EX: c_int = 2;
pub const MAP_SHARED: c_int = 1;
pub const PROT_READ_WRITE: c_int = 3;
pub const AF_UNIX: u16 = 1;
pub const SOCK_STREAM: c_int = 1;
pub const MSG_NOSIGNAL: c_int = 0x4000;
pub const MFD_CLOEXEC: c_uint = 1;
pub const FUTEX_WAIT: c_long = 0;

#[cfg(target_arch = "x86_64")]
mod numbers {
    use core::ffi::c_long;
    pub const SYS_OPEN: c_long = 2;
    pub const SYS_IOCTL: c_long = 16;
    pub const SYS_FUTEX: c_long = 202;
    pub const SYS_OPENAT: c_long = 257;
}
#[cfg(not(target_arch = "x86_64"))]
mod numbers {
    use core::ffi::c_long;
    /// There is no such call.
    pub const SYS_OPEN: c_long = -1;
    pub const SYS_IOCTL: c_long = 29;
    pub const SYS_FUTEX: c_long = 98;
    pub const SYS_OPENAT: c_long = 56;
}
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

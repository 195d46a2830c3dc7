//! `syscall`, for programs that call the system by number through the C library.
//!
//! A system call that a program makes with an instruction of its own, or by `io_uring`, passes the
//! library by.

use crate::abi::{self, fail, next};
use crate::{exec, folders, hooks, memory, open, stat};
use core::ffi::{c_int, c_long};

type Syscall = unsafe extern "C" fn(c_long, usize, usize, usize, usize, usize, usize) -> c_long;

/// Calls the system by number: calls that the library stands for as its functions do.
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
    let here = abi::AT_FDCWD;
    // SAFETY: the arguments are those of the call of this number.
    unsafe {
        match number {
            abi::SYS_OPEN => open::open(a as _, b as _, c as _).into(),
            abi::SYS_OPENAT => open::openat(a as _, b as _, c as _, d as _).into(),
            // `struct open_how` begins with the flags.
            abi::SYS_OPENAT2 if c != 0 => match open::open_place(a as _, b as _, *(c as *const u64) as c_int)
            {
                Some(result) => result.into(),
                None => by_number(number, [a, b, c, d, e, f]),
            },
            abi::SYS_CREAT => open::creat(a as _, b as _).into(),
            abi::SYS_STAT => stat::stat(a as _, b as _).into(),
            abi::SYS_LSTAT => stat::lstat(a as _, b as _).into(),
            abi::SYS_FSTAT => stat::fstat(a as _, b as _).into(),
            abi::SYS_FSTATAT => stat::fstatat(a as _, b as _, c as _, d as _).into(),
            abi::SYS_STATX => stat::statx(a as _, b as _, c as _, d as _, e as _).into(),
            abi::SYS_ACCESS => stat::faccessat(here, a as _, b as _, 0).into(),
            abi::SYS_FACCESSAT => stat::faccessat(a as _, b as _, c as _, 0).into(),
            abi::SYS_FACCESSAT2 => stat::faccessat(a as _, b as _, c as _, d as _).into(),
            abi::SYS_WRITE => hooks::write(a as _, b as _, c) as c_long,
            abi::SYS_PWRITE => hooks::pwrite(a as _, b as _, c, d as _) as c_long,
            abi::SYS_LSEEK => hooks::lseek(a as _, b as _, c as _),
            abi::SYS_FTRUNCATE => hooks::ftruncate(a as _, b as _).into(),
            abi::SYS_IOCTL => hooks::ioctl(a as _, b as _, c as _).into(),
            abi::SYS_MMAP => memory::mmap(a as _, b, c as _, d as _, e as _, f as _) as c_long,
            abi::SYS_MREMAP => memory::mremap(a as _, b, c, d as _, e as _) as c_long,
            abi::SYS_CHDIR => folders::chdir(a as _).into(),
            abi::SYS_EXECVE => exec::execve(a as _, b as _, c as _).into(),
            _ => by_number(number, [a, b, c, d, e, f]),
        }
    }
}

unsafe fn by_number(number: c_long, [a, b, c, d, e, f]: [usize; 6]) -> c_long {
    match next!("syscall", as Syscall) {
        // SAFETY: the arguments are the caller's.
        Some(next) => unsafe { next(number, a, b, c, d, e, f) },
        None => fail(abi::ENOSYS).into(),
    }
}

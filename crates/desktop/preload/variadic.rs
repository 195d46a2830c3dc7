//! `execl`, `execlp` and `execle`, whose arguments have no fixed number: each begins in assembly,
//! which lays the registers of arguments beside each other in memory, and goes on in Rust.

use crate::abi::{self, fail};
use crate::exec::{Words, execve, execvpe};
use core::arch::naked_asm;
use core::ffi::{c_char, c_int};
use core::ptr;

/// Words that a program is started with at most; the system's own limit is higher.
const ROOM: usize = 2048;

/// Ways to start a program.
const BY_PATH: usize = 0;
const BY_NAME: usize = 1;
const WITH_ENVIRONMENT: usize = 2;

/// Arguments of a call after the first one: those in registers, and then those on the stack.
struct Arguments {
    registers: *const usize,
    count: usize,
    stack: *const usize,
}

impl Arguments {
    /// Returns an argument.
    ///
    /// # Safety
    /// The caller of the variadic function has passed it.
    unsafe fn get(&self, at: usize) -> usize {
        // SAFETY: the registers stand in memory; where they end, the stack's arguments go on.
        unsafe { if at < self.count { *self.registers.add(at) } else { *self.stack.add(at - self.count) } }
    }
}

/// Starts a program with words that end with a null pointer, which the environment may follow.
unsafe extern "C" fn start(
    path: *const c_char,
    registers: *const usize,
    stack: *const usize,
    way: usize,
) -> c_int {
    let arguments = Arguments { registers, count: REGISTERS, stack };
    let mut words = [ptr::null::<c_char>(); ROOM];
    let mut len = 0;
    // SAFETY: the words are the caller's, up to the null pointer.
    unsafe {
        loop {
            let word = arguments.get(len) as *const c_char;
            if word.is_null() {
                break;
            }
            if len + 1 >= ROOM {
                return fail(abi::E2BIG);
            }
            words[len] = word;
            len += 1;
        }
        let words = words.as_ptr();
        match way {
            BY_PATH => execve(path, words, abi::environ),
            BY_NAME => execvpe(path, words, abi::environ),
            _ => execve(path, words, arguments.get(len + 1) as Words),
        }
    }
}

/// Arguments in registers after the first one.
const REGISTERS: usize = if cfg!(target_arch = "x86_64") { 5 } else { 7 };

/// Defines functions that pass on what they are given.
#[cfg(target_arch = "x86_64")]
macro_rules! variadic {
    ($($name:ident = $way:expr;)*) => {$(
        /// Starts a program with the words that the arguments are, up to a null pointer.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        pub unsafe extern "C" fn $name() -> c_int {
            naked_asm!(
                "sub rsp, 40",
                "mov [rsp], rsi",
                "mov [rsp + 8], rdx",
                "mov [rsp + 16], rcx",
                "mov [rsp + 24], r8",
                "mov [rsp + 32], r9",
                "mov rsi, rsp",
                // Behind the return address.
                "lea rdx, [rsp + 48]",
                "mov ecx, {way}",
                "call {start}",
                "add rsp, 40",
                "ret",
                way = const $way,
                start = sym start,
            )
        }
    )*};
}

/// Defines functions that pass on what they are given.
#[cfg(target_arch = "aarch64")]
macro_rules! variadic {
    ($($name:ident = $way:expr;)*) => {$(
        /// Starts a program with the words that the arguments are, up to a null pointer.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        pub unsafe extern "C" fn $name() -> c_int {
            naked_asm!(
                "stp x29, x30, [sp, #-80]!",
                "stp x1, x2, [sp, #16]",
                "stp x3, x4, [sp, #32]",
                "stp x5, x6, [sp, #48]",
                "str x7, [sp, #64]",
                "add x1, sp, #16",
                "add x2, sp, #80",
                "mov x3, #{way}",
                "bl {start}",
                "ldp x29, x30, [sp], #80",
                "ret",
                way = const $way,
                start = sym start,
            )
        }
    )*};
}

/// Defines functions that pass on what they are given.
#[cfg(target_arch = "riscv64")]
macro_rules! variadic {
    ($($name:ident = $way:expr;)*) => {$(
        /// Starts a program with the words that the arguments are, up to a null pointer.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        pub unsafe extern "C" fn $name() -> c_int {
            naked_asm!(
                "addi sp, sp, -64",
                "sd ra, 56(sp)",
                "sd a1, 0(sp)",
                "sd a2, 8(sp)",
                "sd a3, 16(sp)",
                "sd a4, 24(sp)",
                "sd a5, 32(sp)",
                "sd a6, 40(sp)",
                "sd a7, 48(sp)",
                "mv a1, sp",
                "addi a2, sp, 64",
                "li a3, {way}",
                "call {start}",
                "ld ra, 56(sp)",
                "addi sp, sp, 64",
                "ret",
                way = const $way,
                start = sym start,
            )
        }
    )*};
}

variadic! {
    execl = BY_PATH;
    execlp = BY_NAME;
    execle = WITH_ENVIRONMENT;
}

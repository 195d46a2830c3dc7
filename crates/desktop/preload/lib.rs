//! The preload library of `fbptr run`: stands for `/dev/fb0` and its kin in a program that knows
//! nothing of it.
//!
//! In: the C library's calls of a program that was started with `LD_PRELOAD`, and the environment
//! variable `FBPTR_RUN`. Out: for the paths of `paths.rs` the emulated device, for everything else
//! the call as it was. Runs on the program's threads, in each of its processes, also in signal
//! handlers: it takes no lock, starts no thread, and allocates only what the caller is to free.
//!
//! The device's memory is a sealed memfd of the program `fbptr`, opened through `/proc`: the
//! descriptors that the program gets are real ones. So `mmap`, `read`, `lseek`, `dup`, `fcntl`,
//! `fork`, `exec` and even a program's own system calls work without help, and no table of
//! descriptors is kept: a descriptor is known by its inode. The input devices are sockets, known by
//! the name of their other end.
//!
//! Only the C library is linked. `build.rs` compiles this file twice, and `fbptr` carries both: the
//! second one (cfg `glut`) also stands for GLUT and OpenGL, for programs that show one picture.
#![no_std]
#![deny(unsafe_op_in_unsafe_fn)]

mod abi;
mod attributes;
mod console;
mod device;
#[allow(dead_code)]
mod elf;
mod evdev;
mod exec;
mod folders;
mod framebuffer;
#[cfg(glut)]
mod glut;
mod hooks;
#[allow(dead_code)]
mod keys;
#[allow(dead_code)]
mod layout;
mod listing;
mod memory;
#[allow(dead_code)]
mod mode;
mod open;
mod paths;
mod stat;
mod streams;
mod syscalls;
mod sysfs;
mod terminal;
mod text;
mod unserved;
mod variadic;

/// Ends the process: nothing in here panics but by a defect.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: `abort` has no requirements.
    unsafe { abi::abort() }
}

/// Attaches to the device when the library is loaded, before the program's `main`.
#[used]
#[unsafe(link_section = ".init_array")]
static ATTACH: extern "C" fn() = device::attach;

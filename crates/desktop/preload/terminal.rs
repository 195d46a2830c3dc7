//! Descriptors of the console: which virtual terminal one is open for, and its name.
//!
//! A pseudo terminal of its own stands for each virtual terminal, so a descriptor is known by the
//! terminal's number, whatever process it has come to. `/dev/tty0` and `/dev/console`
//! are the active terminal by another name: the descriptor notes the name by flags that mean
//! nothing to a terminal and stay with it over `dup`, `fork` and `exec`.

use crate::abi::{self, errno, fail, next, set_errno};
use crate::device::{Device, device, status};
use crate::folders;
use crate::layout as at;
use crate::paths::{self, Place};
use crate::text::Text;
use core::ffi::{c_char, c_int, c_uint, c_ulong, c_void};
use core::sync::atomic::{AtomicU8, Ordering};

/// Major number of virtual terminals.
pub const MAJOR: u8 = 4;
/// The device number of `/dev/null`.
const NULL: u64 = abi::device_number(1, 3);
/// Flag of a descriptor of `/dev/tty0`.
const AS_ACTIVE: c_int = abi::O_DSYNC;
/// Flags of a descriptor of `/dev/console`.
const AS_CONSOLE: c_int = abi::O_SYNC;

/// Opens the pseudo terminal that stands for a console.
pub fn open(device: &Device, (major, minor): (u8, u8), flags: c_int) -> c_int {
    let (number, marks) = match (major, minor) {
        (MAJOR, 0) => (active(device), AS_ACTIVE),
        (MAJOR, number) => (number.into(), 0),
        _ => (active(device), AS_CONSOLE),
    };
    let Some(number) = pseudo_terminal(device, number) else { return fail(abi::ENODEV) };
    let mut path = Text::<32>::new();
    path.push(b"/dev/pts/").number(number);
    let Some(open) = next!("open", as unsafe extern "C" fn(*const c_char, c_int, c_uint) -> c_int) else {
        return fail(abi::ENOSYS);
    };
    let flags = flags & !(abi::O_CREAT | abi::O_EXCL | abi::O_SYNC) | marks;
    // SAFETY: the path is a C string.
    unsafe { open(path.as_ptr(), flags, 0) }
}

fn active(device: &Device) -> u32 {
    device.word(at::ACTIVE_TERMINAL_AT).load(Ordering::Acquire)
}

/// Returns the number of the pseudo terminal that stands for a virtual terminal, from 1.
fn pseudo_terminal(device: &Device, number: u32) -> Option<u64> {
    let index = (number as usize).checked_sub(1).filter(|index| *index < at::TERMINALS)?;
    let number = device.word(at::TERMINALS_AT + index * 4).load(Ordering::Acquire);
    number.checked_sub(1).map(u64::from)
}

/// Returns the number of the virtual terminal that a descriptor is open for, also as `/dev/tty`.
pub fn number_of(device: &Device, fd: c_int) -> Option<u8> {
    const TIOCGDEV: c_ulong = 0x8004_5432;
    type Ioctl = unsafe extern "C" fn(c_int, c_ulong, *mut c_void) -> c_int;
    let (mut found, saved) = (0u32, errno());
    let next = next!("ioctl", as Ioctl)?;
    // SAFETY: the request writes the device number of a terminal, 32 bits, to its argument.
    let result = unsafe { next(fd, TIOCGDEV, core::ptr::from_mut(&mut found).cast()) };
    set_errno(saved);
    if result != 0 {
        return None;
    }
    let is_found = |number: &u8| {
        pseudo_terminal(device, (*number).into()).is_some_and(|minor| {
            // 136 and the seven numbers after it are the majors of pseudo terminals.
            u64::from(found) == abi::device_number(136 + (minor >> 8), minor & 0xff)
        })
    };
    (1..=at::TERMINALS as u8).find(is_found)
}

/// Returns the console that a descriptor is open for, by the name that it was opened by.
pub fn place_of_descriptor(device: &Device, fd: c_int) -> Option<Place> {
    let number = number_of(device, fd)?;
    // SAFETY: the request has no argument.
    let flags = unsafe { abi::fcntl(fd, abi::F_GETFL) };
    Some(match flags & abi::O_SYNC {
        AS_CONSOLE => Place::Console(5, 1),
        AS_ACTIVE => Place::Console(MAJOR, 0),
        _ => Place::Console(MAJOR, number),
    })
}

/// Returns whether requests of virtual terminals are carried out on a descriptor: on those of the
/// console, and on standard input, output and error whatever they are, because a program of the
/// console finds one there on a real machine.
pub fn is_served(device: &Device, fd: c_int) -> bool {
    claim(device, fd);
    number_of(device, fd).is_some() || ((0..=2).contains(&fd) && !device.is_memory_fd(fd))
}

/// Puts the console in the place of a standard input that is `/dev/null`, where the program asks it
/// for a virtual terminal. A program that only reads finds the end that was meant for it.
fn claim(device: &Device, fd: c_int) {
    let saved = errno();
    if fd == 0 && status(fd).is_some_and(|s| s.mode & abi::S_IFMT == abi::S_IFCHR && s.rdev == NULL) {
        let console = open(device, (MAJOR, active(device) as u8), abi::O_RDWR | abi::O_NOCTTY);
        if console > 0 {
            // SAFETY: calls without pointers; the descriptor is ours.
            unsafe {
                abi::dup3(console, fd, 0);
                abi::close(console);
            }
        }
    }
    set_errno(saved);
}

/// Returns the name of the console that a descriptor is open for.
fn name_of(fd: c_int) -> Option<Text<32>> {
    let device = device()?;
    claim(&device, fd);
    let mut name = Text::new();
    name.push(folders::path_of(place_of_descriptor(&device, fd)?).as_bytes());
    Some(name)
}

/// Returns the name of a terminal, in memory that the next call overwrites.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ttyname(fd: c_int) -> *const c_char {
    static NAME: [AtomicU8; 32] = [const { AtomicU8::new(0) }; 32];
    if let Some(name) = name_of(fd) {
        let bytes = name.as_bytes().iter().chain(&[0]);
        NAME.iter().zip(bytes).for_each(|(place, byte)| place.store(*byte, Ordering::Relaxed));
        return NAME.as_ptr().cast();
    }
    match next!("ttyname", as unsafe extern "C" fn(c_int) -> *const c_char) {
        // SAFETY: the argument is the caller's.
        Some(next) => unsafe { next(fd) },
        None => core::ptr::null(),
    }
}

/// Defines `ttyname_r` and its other name, which has the buffer's size as a last argument.
macro_rules! names {
    ($($name:ident($($size:ident)?);)*) => {$(
        /// Writes the name of a terminal. Returns 0 or the error's number.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            fd: c_int, buffer: *mut c_char, len: usize $(, $size: usize)?
        ) -> c_int {
            if let Some(name) = name_of(fd) {
                if name.as_bytes().len() >= len {
                    set_errno(abi::ERANGE);
                    return abi::ERANGE;
                }
                // SAFETY: the buffer has `len` bytes, more than the name and its end.
                unsafe { core::ptr::copy_nonoverlapping(name.as_ptr(), buffer, name.as_bytes().len() + 1) };
                return 0;
            }
            $(let _ = $size;)?
            match next!("ttyname_r", as unsafe extern "C" fn(c_int, *mut c_char, usize) -> c_int) {
                // SAFETY: the arguments are the caller's.
                Some(next) => unsafe { next(fd, buffer, len) },
                None => abi::ENOSYS,
            }
        }
    )*};
}

names! {
    ttyname_r();
    __ttyname_r_chk(size);
}

/// Defines functions that read the target of a symbolic link.
macro_rules! links {
    ($($name:ident($from:expr, [$($before:ident)?] $(, $size:ident)?);)*) => {$(
        /// Reads a symbolic link: that of a descriptor of the device names the device.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            $($before: c_int,)? path: *const c_char, buffer: *mut c_char, len: usize $(, $size: usize)?
        ) -> isize {
            // SAFETY: the caller passes a C string.
            if let Some(place) = unsafe { paths::place_of_descriptor_link(path) } {
                let target = folders::path_of(place);
                let len = target.as_bytes().len().min(len);
                // SAFETY: the buffer has room for `len` bytes; the link's target has no end.
                unsafe { core::ptr::copy_nonoverlapping(target.as_ptr(), buffer, len) };
                return len as isize;
            }
            $(let _ = $size;)?
            // SAFETY: the arguments are the caller's.
            unsafe { abi::next_readlinkat($from, path, buffer, len) }
        }
    )*};
}

links! {
    readlink(abi::AT_FDCWD, []);
    __readlink_chk(abi::AT_FDCWD, [], size);
    readlinkat(folder, [folder]);
    __readlinkat_chk(folder, [folder], size);
}

//! Opening the device: `open`, `openat`, `creat` and their variants.

use crate::abi::{self, fail, next, set_errno};
use crate::device::{Device, device};
use crate::paths::{INPUTS, Place, place};
use crate::text::Text;
use crate::{folders, sysfs, terminal};
use core::ffi::{c_char, c_int, c_uint};
use core::ptr;

/// `struct sockaddr_un`.
#[repr(C)]
pub struct SocketAddress {
    family: u16,
    path: [u8; 108],
}

const O_WRONLY: c_int = 1;
#[cfg(target_arch = "aarch64")]
const O_NOFOLLOW: c_int = 0o100000;
#[cfg(not(target_arch = "aarch64"))]
const O_NOFOLLOW: c_int = 0o400000;

/// Opens the place of a path. `None` if the path is the system's.
///
/// # Safety
/// `path` is null or a C string.
pub unsafe fn open_place(folder: c_int, path: *const c_char, flags: c_int) -> Option<c_int> {
    // SAFETY: the caller's promise.
    let place = unsafe { place(folder, path, flags & O_NOFOLLOW == 0) }?;
    let device = device()?;
    let is_writing = flags & abi::O_ACCMODE != 0;
    Some(match place {
        _ if flags & (abi::O_CREAT | abi::O_EXCL) == abi::O_CREAT | abi::O_EXCL => fail(abi::EEXIST),
        Place::Folder(_) if is_writing => fail(abi::EISDIR),
        Place::Folder(index) => folders::open(&device, index, flags),
        _ if flags & abi::O_DIRECTORY != 0 => fail(abi::ENOTDIR),
        Place::Framebuffer => device.open_memory(flags),
        Place::Console(major, minor) => terminal::open(&device, (major, minor), flags),
        Place::Input(index) => open_input(&device, index, flags),
        Place::List if is_writing => fail(abi::EACCES),
        Place::Attribute(index) => sysfs::open(&device, index, flags),
        Place::List => sysfs::open_list(flags),
    })
}

/// Returns the name of an input device's socket: in the abstract namespace, which no file is left
/// of.
pub fn socket_address(device: &Device, index: usize) -> (SocketAddress, c_uint) {
    let mut name = Text::<64>::new();
    name.push(b"\0fbptr-run-").number(device.pid).push(b"-").number(device.inode());
    name.push(b"/").push(INPUTS[index].0.rsplit(|b| *b == b'/').next().unwrap_or(b""));
    let mut address = SocketAddress { family: abi::AF_UNIX, path: [0; 108] };
    let name = name.as_bytes();
    address.path[..name.len()].copy_from_slice(name);
    (address, 2 + name.len() as c_uint)
}

/// Returns which input device's socket a descriptor is, if it is one.
pub fn input_of(device: &Device, fd: c_int) -> Option<usize> {
    let mut peer = SocketAddress { family: 0, path: [0; 108] };
    let mut len = size_of::<SocketAddress>() as c_uint;
    let saved = abi::errno();
    // SAFETY: the address has room for the length that is given.
    let result = unsafe { abi::getpeername(fd, ptr::from_mut(&mut peer).cast(), &mut len) };
    set_errno(saved);
    if result != 0 || peer.family != abi::AF_UNIX {
        return None;
    }
    let is_same = |index: &usize| {
        let (ours, our_len) = socket_address(device, *index);
        len == our_len && peer.path == ours.path
    };
    (0..INPUTS.len()).find(is_same)
}

/// Connects to an input device's socket.
fn open_input(device: &Device, index: usize, flags: c_int) -> c_int {
    let (address, len) = socket_address(device, index);
    let kind = abi::SOCK_STREAM | flags & (abi::O_NONBLOCK | abi::O_CLOEXEC);
    // SAFETY: a call without pointers.
    let fd = unsafe { abi::socket(abi::AF_UNIX.into(), kind, 0) };
    if fd < 0 {
        return fd;
    }
    // SAFETY: the address is valid for its length.
    if unsafe { abi::connect(fd, ptr::from_ref(&address).cast(), len) } != 0 {
        // SAFETY: the descriptor is ours.
        unsafe { abi::close(fd) };
        return fail(abi::ENODEV);
    }
    fd
}

/// Defines functions that open a path, each with the type of the C library's.
macro_rules! opens {
    ($($name:ident($from:expr, [$($before:ident: $before_kind:ty)?] path, flags $(, $after:ident: $after_kind:ty)?);)*) => {$(
        /// Opens the device, or what the C library's function of this name opens.
        ///
        /// # Safety
        /// As for the C library's function. It is variadic there; the mode is passed on as it came.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            $($before: $before_kind,)? path: *const c_char, flags: c_int $(, $after: $after_kind)?
        ) -> c_int {
            // SAFETY: the caller passes a C string.
            if let Some(fd) = unsafe { open_place($from, path, flags) } {
                return fd;
            }
            type Next = unsafe extern "C" fn($($before_kind,)? *const c_char, c_int $(, $after_kind)?) -> c_int;
            match next!(stringify!($name), as Next) {
                // SAFETY: the arguments are the caller's.
                Some(next) => unsafe { next($($before,)? path, flags $(, $after)?) },
                None => fail(abi::ENOSYS),
            }
        }
    )*};
}

opens! {
    open(abi::AT_FDCWD, [] path, flags, mode: c_uint);
    open64(abi::AT_FDCWD, [] path, flags, mode: c_uint);
    __open(abi::AT_FDCWD, [] path, flags, mode: c_uint);
    __open64(abi::AT_FDCWD, [] path, flags, mode: c_uint);
    __open_2(abi::AT_FDCWD, [] path, flags);
    __open64_2(abi::AT_FDCWD, [] path, flags);
    openat(folder, [folder: c_int] path, flags, mode: c_uint);
    openat64(folder, [folder: c_int] path, flags, mode: c_uint);
    __openat_2(folder, [folder: c_int] path, flags);
    __openat64_2(folder, [folder: c_int] path, flags);
}

/// Defines `creat` and its other name.
macro_rules! creating {
    ($($name:ident)*) => {$(
        /// Creates a file; the device exists.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(path: *const c_char, mode: c_uint) -> c_int {
            // SAFETY: the caller passes a C string.
            if let Some(fd) = unsafe { open_place(abi::AT_FDCWD, path, O_WRONLY) } {
                return fd;
            }
            match next!(stringify!($name), as unsafe extern "C" fn(*const c_char, c_uint) -> c_int) {
                // SAFETY: the arguments are the caller's.
                Some(next) => unsafe { next(path, mode) },
                None => fail(abi::ENOSYS),
            }
        }
    )*};
}

creating! { creat creat64 }

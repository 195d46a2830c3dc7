//! Opening the device: `open`, `openat`, `creat`, `fopen` and their variants.

use crate::abi::{self, fail, next, set_errno};
use crate::device::{Device, device};
use crate::layout::TERMINAL_AT;
use crate::paths::{INPUTS, Place, place};
use crate::sysfs;
use crate::text::Text;
use core::ffi::{c_char, c_int, c_uint, c_void};
use core::ptr;
use core::sync::atomic::Ordering;

/// `struct sockaddr_un`.
#[repr(C)]
pub struct SocketAddress {
    family: u16,
    path: [u8; 108],
}

/// Opens the place of a path. `None` if the path is the system's.
///
/// # Safety
/// `path` is null or a C string.
unsafe fn open_place(path: *const c_char, flags: c_int) -> Option<c_int> {
    // SAFETY: the caller's promise.
    let place = unsafe { place(path) }?;
    let device = device()?;
    Some(match place {
        _ if flags & (abi::O_CREAT | abi::O_EXCL) == abi::O_CREAT | abi::O_EXCL => fail(abi::EEXIST),
        _ if flags & abi::O_DIRECTORY != 0 && place != Place::Folder => fail(abi::ENOTDIR),
        Place::Framebuffer => device.open_memory(flags),
        Place::Console => open_terminal(&device, flags),
        Place::Input(index) => open_input(&device, index, flags),
        Place::Attribute(_) | Place::List if flags & abi::O_ACCMODE != 0 => fail(abi::EACCES),
        Place::Attribute(index) => sysfs::open(&device, Some(index), flags),
        Place::List => sysfs::open(&device, None, flags),
        // There is nothing to list where the system has no such folder.
        Place::Folder => return None,
    })
}

/// Opens the pseudo terminal that stands for the console.
fn open_terminal(device: &Device, flags: c_int) -> c_int {
    let Some(minor) = terminal_minor(device) else { return fail(abi::ENODEV) };
    let mut path = Text::<32>::new();
    path.push(b"/dev/pts/").number(minor);
    let Some(open) = next!("open", as unsafe extern "C" fn(*const c_char, c_int, c_uint) -> c_int) else {
        return fail(abi::ENOSYS);
    };
    // SAFETY: the path is a C string.
    unsafe { open(path.as_ptr(), flags & !(abi::O_CREAT | abi::O_EXCL), 0) }
}

/// Returns the minor number of the pseudo terminal, if there is one.
fn terminal_minor(device: &Device) -> Option<u64> {
    let number = device.word(TERMINAL_AT).load(Ordering::Acquire);
    number.checked_sub(1).map(u64::from)
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
    ($($name:ident([$($before:ident: $before_kind:ty)?] path, flags $(, $after:ident: $after_kind:ty)?);)*) => {$(
        /// Opens the device, or what the C library's function of this name opens.
        ///
        /// # Safety
        /// As for the C library's function. It is variadic there; the mode is passed on as it came.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            $($before: $before_kind,)? path: *const c_char, flags: c_int $(, $after: $after_kind)?
        ) -> c_int {
            // SAFETY: the caller passes a C string.
            if let Some(fd) = unsafe { open_place(path, flags) } {
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
    open([] path, flags, mode: c_uint);
    open64([] path, flags, mode: c_uint);
    __open([] path, flags, mode: c_uint);
    __open64([] path, flags, mode: c_uint);
    __open_2([] path, flags);
    __open64_2([] path, flags);
    openat([folder: c_int] path, flags, mode: c_uint);
    openat64([folder: c_int] path, flags, mode: c_uint);
    __openat_2([folder: c_int] path, flags);
    __openat64_2([folder: c_int] path, flags);
}

/// Creates a file, as `creat` does: the device exists.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn creat(path: *const c_char, mode: c_uint) -> c_int {
    // SAFETY: the caller passes a C string; 1 is O_WRONLY.
    if let Some(fd) = unsafe { open_place(path, 1) } {
        return fd;
    }
    match next!("creat", as unsafe extern "C" fn(*const c_char, c_uint) -> c_int) {
        // SAFETY: the arguments are the caller's.
        Some(next) => unsafe { next(path, mode) },
        None => fail(abi::ENOSYS),
    }
}

type Fopen = unsafe extern "C" fn(*const c_char, *const c_char) -> *mut c_void;

/// Opens the device as a stream. `None` if the path is the system's.
///
/// # Safety
/// Both are null or C strings.
unsafe fn fopen_place(path: *const c_char, mode: *const c_char) -> Option<*mut c_void> {
    if mode.is_null() {
        return None;
    }
    // SAFETY: it is a C string, says the caller.
    let letters = unsafe { core::ffi::CStr::from_ptr(mode) }.to_bytes();
    let access = match (letters.first()?, letters.contains(&b'+')) {
        (_, true) => abi::O_RDWR,
        (b'r', false) => 0,
        _ => 1,
    };
    let close_on_exec = if letters.contains(&b'e') { abi::O_CLOEXEC } else { 0 };
    // SAFETY: the caller's promise.
    let fd = unsafe { open_place(path, access | close_on_exec) }?;
    if fd < 0 {
        return Some(ptr::null_mut());
    }
    // SAFETY: the descriptor is open, and the stream takes it over.
    Some(unsafe { abi::fdopen(fd, mode) })
}

/// Defines functions that open a path as a stream.
macro_rules! fopens {
    ($($name:ident)*) => {$(
        /// Opens the device as a stream, or what the C library's function of this name opens.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(path: *const c_char, mode: *const c_char) -> *mut c_void {
            // SAFETY: the caller passes C strings.
            if let Some(stream) = unsafe { fopen_place(path, mode) } {
                return stream;
            }
            match next!(stringify!($name), as Fopen) {
                // SAFETY: the arguments are the caller's.
                Some(next) => unsafe { next(path, mode) },
                None => ptr::null_mut(),
            }
        }
    )*};
}

fopens! { fopen fopen64 }

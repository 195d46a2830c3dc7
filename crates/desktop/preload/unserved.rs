//! Programs that the running one starts, and into which no library can be preloaded: `fbptr` says
//! so, because without a word they would only find no device.

use crate::abi::{self, errno, set_errno};
use crate::device::{Device, device};
use crate::elf::{self, HEAD_BYTES, Unserved};
use crate::paths::PathText;
use crate::text::Text;
use core::ffi::{CStr, c_char, c_int};

/// A program that is started.
pub enum Program {
    /// At a path from a folder.
    Path(c_int, *const c_char),
    /// Of this name in `PATH`, or at this path.
    Name(*const c_char),
    /// That is open.
    Descriptor(c_int),
}

/// Interpreters of interpreters that are followed.
const DEPTH: u32 = 4;
/// Set-user-ID and set-group-ID.
const SET_UID: u32 = 0o4000;
const SET_GID: u32 = 0o2000;

/// Tells of the program if it cannot have the device.
///
/// # Safety
/// Its text is null or a C string.
pub unsafe fn tell(program: Program) {
    let Some(device) = device() else { return };
    let saved = errno();
    match program {
        Program::Descriptor(fd) => {
            let mut path = PathText::new();
            path.push(b"/proc/self/fd/").number(fd.max(0) as u64);
            look(&device, abi::AT_FDCWD, &path, DEPTH);
        }
        // SAFETY: it is a C string, says the caller.
        Program::Path(folder, path) => match unsafe { text_of(path) } {
            Some(path) if path.as_bytes().is_empty() => {
                // SAFETY: as above; an empty path is that of the descriptor.
                unsafe { tell(Program::Descriptor(folder)) };
            }
            Some(path) => _ = look(&device, folder, &path, DEPTH),
            None => {}
        },
        Program::Name(name) => {
            // SAFETY: as above.
            if let Some(name) = unsafe { text_of(name) } {
                look_for(&device, &name);
            }
        }
    }
    set_errno(saved);
}

unsafe fn text_of(text: *const c_char) -> Option<PathText> {
    if text.is_null() {
        return None;
    }
    let mut copy = PathText::new();
    // SAFETY: it is a C string, says the caller.
    copy.push(unsafe { CStr::from_ptr(text) }.to_bytes());
    Some(copy)
}

/// Looks at the first program of this name in `PATH`.
fn look_for(device: &Device, name: &PathText) {
    if name.as_bytes().contains(&b'/') {
        look(device, abi::AT_FDCWD, name, DEPTH);
        return;
    }
    // SAFETY: the name is a C string; a program that changes its environment meanwhile is not
    // sound.
    let folders = unsafe { text_of(abi::getenv(c"PATH".as_ptr())) };
    let Some(folders) = folders else { return };
    for folder in folders.as_bytes().split(|b| *b == b':') {
        let mut path = PathText::new();
        path.push(if folder.is_empty() { b"." } else { folder }).push(b"/").push(name.as_bytes());
        if look(device, abi::AT_FDCWD, &path, DEPTH) {
            return;
        }
    }
}

/// Looks at a program or its interpreter. Returns whether there is one.
fn look(device: &Device, folder: c_int, path: &PathText, depth: u32) -> bool {
    // SAFETY: the path is a C string.
    let fd = unsafe { abi::next_openat(folder, path.as_ptr(), abi::O_CLOEXEC | abi::O_NONBLOCK) };
    if fd < 0 {
        return false;
    }
    let mut head = [0u8; HEAD_BYTES];
    let read = |offset: u64, bytes: &mut [u8]| {
        // SAFETY: the buffer has room for its length.
        let len = unsafe { abi::pread(fd, bytes.as_mut_ptr().cast(), bytes.len(), offset as i64) };
        len == bytes.len() as isize
    };
    // SAFETY: the buffer has room for its length.
    let len = unsafe { abi::pread(fd, head.as_mut_ptr().cast(), HEAD_BYTES, 0) }.max(0) as usize;
    let mut why = has_other_rights(fd).then_some(Unserved::Rights);
    let mut interpreter = None;
    if why.is_none() && elf::is_elf(&head[..len]) {
        why = elf::check(&head, read).err();
    } else if let [b'#', b'!', line @ ..] = &head[..len] {
        interpreter = elf::interpreter(line);
    }
    // SAFETY: the descriptor is ours.
    unsafe { abi::close(fd) };
    if let Some(why) = why {
        device.tell(why, path.as_bytes());
    } else if let Some(interpreter) = interpreter.filter(|_| depth > 0) {
        let mut path = PathText::new();
        path.push(interpreter);
        look(device, abi::AT_FDCWD, &path, depth - 1);
    }
    true
}

/// Returns whether a program runs with other rights than ours.
fn has_other_rights(fd: c_int) -> bool {
    // SAFETY: calls without arguments.
    let (uid, gid) = unsafe { (abi::geteuid(), abi::getegid()) };
    let Some(status) = crate::device::status(fd) else { return false };
    let mut path = Text::<40>::new();
    path.push(b"/proc/self/fd/").number(fd as u64);
    let mut value = [0u8; 64];
    let name = c"security.capability";
    // SAFETY: the texts are C strings, and the buffer has room for its length.
    let mut has_capabilities =
        || unsafe { abi::getxattr(path.as_ptr(), name.as_ptr(), value.as_mut_ptr().cast(), value.len()) > 0 };
    (status.mode & SET_UID != 0 && status.uid != uid)
        || (status.mode & SET_GID != 0 && status.gid != gid)
        || (uid != 0 && has_capabilities())
}

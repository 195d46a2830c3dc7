//! The paths that the library stands for; every other path is the system's.
//!
//! A path is the device's if the system would come to a path of the device by it: with `..` and
//! double slashes, from a folder that is open or current, and over symbolic links. Most of these
//! places do not exist in the file system, so the system is asked for the folder and for links
//! only.

use crate::abi::{self, errno, set_errno};
use crate::device::{Device, device};
use crate::folders;
use crate::open::input_of;
use crate::text::Text;
use crate::{sysfs, terminal};
use core::ffi::{CStr, c_char, c_int};

/// A place that the device has in the file system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The framebuffer.
    Framebuffer,
    /// A console, by the major and minor number of its device: the pseudo terminal stands for it.
    Console(u8, u8),
    /// An input device, by its index in [`INPUTS`].
    Input(usize),
    /// A file of the framebuffer in `/sys`, by its index in [`sysfs::FILES`].
    Attribute(usize),
    /// A folder, by its index in [`folders::FOLDERS`].
    Folder(usize),
    /// The list of framebuffers, `/proc/fb`.
    List,
}

/// The input devices: path, and minor number. Their sockets' names end with the same word.
pub const INPUTS: [(&[u8], u64); 3] =
    [(b"/dev/input/event0", 64), (b"/dev/input/event1", 65), (b"/dev/input/mice", 63)];

/// Major number of framebuffers.
pub const FRAMEBUFFER_MAJOR: u64 = 29;
/// Major number of input devices.
pub const INPUT_MAJOR: u64 = 13;
/// Bytes of the longest path that is looked at; the device's own are much shorter.
pub const ROOM: usize = 1024;
/// A path.
pub type PathText = Text<ROOM>;
/// Links that are followed.
const LINKS: usize = 8;

/// Returns the place of a path, from a folder's descriptor or the current folder
/// ([`abi::AT_FDCWD`]); a symbolic link at its end counts if it is followed.
///
/// # Safety
/// `path` is null or a C string.
pub unsafe fn place(folder: c_int, path: *const c_char, is_followed: bool) -> Option<Place> {
    if path.is_null() {
        return None;
    }
    let device = device()?;
    // SAFETY: it is a C string, says the caller.
    let bytes = unsafe { CStr::from_ptr(path) }.to_bytes();
    if bytes.is_empty() || bytes.len() >= ROOM {
        return None;
    }
    let saved = errno();
    let mut text = PathText::new();
    text.push(bytes);
    let found = find(&device, folder, text, is_followed);
    set_errno(saved);
    found
}

fn find(device: &Device, folder: c_int, mut path: PathText, is_followed: bool) -> Option<Place> {
    for _ in 0..LINKS {
        let bytes = path.as_bytes();
        if bytes.first() == Some(&b'/') {
            let plain = normalized(bytes);
            if let found @ Some(_) =
                place_of(plain.as_bytes()).or_else(|| place_of_descriptor(device, plain.as_bytes()))
            {
                return found;
            }
        }
        if is_name_of_ours(last_name(bytes))
            && let found @ Some(_) = place_by_folder(folder, bytes)
        {
            return found;
        }
        if !is_followed {
            return None;
        }
        let target = link_of(folder, &path)?;
        path = match target.as_bytes().first()? {
            b'/' => target,
            _ => joined(parent(path.as_bytes()), target.as_bytes()),
        };
    }
    None
}

/// Returns the place that the system's own view of the path's folder gives.
fn place_by_folder(folder: c_int, path: &[u8]) -> Option<Place> {
    let from = |before: &[u8], rest: &[u8]| {
        let real = real_folder(folder, before)?;
        place_of(normalized(joined(real.as_bytes(), rest).as_bytes()).as_bytes())
    };
    from(parent(path), last_name(path)).or_else(|| if path[0] == b'/' { None } else { from(b".", path) })
}

/// Returns the path of a folder without links, as programs see it.
pub fn real_folder(folder: c_int, path: &[u8]) -> Option<PathText> {
    let mut text = PathText::new();
    text.push(if path.is_empty() { b"." } else { path });
    const ONLY_A_PLACE: c_int = abi::O_PATH | abi::O_DIRECTORY | abi::O_CLOEXEC;
    // SAFETY: the path is a C string.
    let fd = unsafe { abi::next_openat(folder, text.as_ptr(), ONLY_A_PLACE) };
    if fd < 0 {
        return None;
    }
    let found = path_of_descriptor(fd);
    // SAFETY: the descriptor is ours.
    unsafe { abi::close(fd) };
    found
}

/// Returns the path of what a descriptor is open for, as programs see it.
pub fn path_of_descriptor(fd: c_int) -> Option<PathText> {
    let mut link = PathText::new();
    link.push(b"/proc/self/fd/").number(u64::try_from(fd).ok()?);
    let path = link_of(abi::AT_FDCWD, &link)?;
    Some(folders::seen_as(path.as_bytes()).unwrap_or(path))
}

/// Returns the target of a symbolic link.
fn link_of(folder: c_int, path: &PathText) -> Option<PathText> {
    let mut bytes = [0u8; ROOM];
    // SAFETY: the path is a C string, and the buffer has room for the length that is given.
    let len = unsafe { abi::next_readlinkat(folder, path.as_ptr(), bytes.as_mut_ptr().cast(), ROOM) };
    let len = usize::try_from(len).ok().filter(|len| *len < ROOM)?;
    let mut target = PathText::new();
    target.push(&bytes[..len]);
    Some(target)
}

/// Returns an absolute path without `..`, if it has any: the system does not know the folders of
/// the device's own that it may lead through.
///
/// # Safety
/// `path` is null or a C string.
pub unsafe fn without_detours(path: *const c_char) -> Option<PathText> {
    if path.is_null() || device().is_none() {
        return None;
    }
    // SAFETY: it is a C string, says the caller.
    let bytes = unsafe { CStr::from_ptr(path) }.to_bytes();
    let is_detour = bytes.first() == Some(&b'/') && bytes.split(|b| *b == b'/').any(|name| name == b"..");
    (is_detour && bytes.len() < ROOM).then(|| normalized(bytes))
}

/// Returns the path without empty names, `.` and `..`. It begins with a slash.
fn normalized(path: &[u8]) -> PathText {
    let mut plain = PathText::new();
    for name in path.split(|b| *b == b'/') {
        match name {
            b"" | b"." => {}
            b".." => {
                let end = plain.as_bytes().iter().rposition(|b| *b == b'/').unwrap_or(0);
                plain.truncate(end);
            }
            name => _ = plain.push(b"/").push(name),
        }
    }
    if plain.as_bytes().is_empty() {
        plain.push(b"/");
    }
    plain
}

fn joined(folder: &[u8], name: &[u8]) -> PathText {
    let mut path = PathText::new();
    path.push(folder);
    if !folder.is_empty() {
        path.push(b"/");
    }
    path.push(name);
    path
}

/// Returns what stands before the last name of a path, with its slash.
fn parent(path: &[u8]) -> &[u8] {
    &path[..path.len() - last_name(path).len()]
}

fn last_name(path: &[u8]) -> &[u8] {
    path.rsplit(|b| *b == b'/').next().unwrap_or(path)
}

/// Returns whether a place of the device can have this name. Others need no look at their folder.
fn is_name_of_ours(name: &[u8]) -> bool {
    matches!(name, b"fb0" | b"0" | b"fb" | b"console" | b"graphics" | b"input" | b"." | b".." | b"")
        || name.starts_with(b"tty")
        || name.len() <= 2 && name.iter().all(u8::is_ascii_digit)
        || INPUTS.iter().any(|(path, _)| last_name(path) == name)
        || sysfs::FILES.iter().any(|file| file.name == name)
}

/// Returns the place of a path that begins with a slash and has no detours.
fn place_of(path: &[u8]) -> Option<Place> {
    match path {
        b"/dev/fb0" | b"/dev/fb/0" | b"/dev/graphics/fb0" => return Some(Place::Framebuffer),
        b"/dev/console" => return Some(Place::Console(5, 1)),
        b"/proc/fb" => return Some(Place::List),
        _ => {}
    }
    if let Some(name) = path.strip_prefix(b"/sys/class/graphics/fb0/") {
        return sysfs::FILES.iter().position(|file| file.name == name).map(Place::Attribute);
    }
    if let Some(index) = folders::position(path) {
        return Some(Place::Folder(index));
    }
    let terminal = path.strip_prefix(b"/dev/tty").or_else(|| path.strip_prefix(b"/dev/vc/"));
    if let Some(number) = terminal {
        // /dev/tty itself is the controlling terminal, and /dev/ttyS0 a serial line.
        let is_number = matches!(number.len(), 1 | 2) && number.iter().all(u8::is_ascii_digit);
        let number =
            number.iter().fold(0u8, |number, digit| number.wrapping_mul(10).wrapping_add(digit - b'0'));
        return (is_number && number < 64).then_some(Place::Console(terminal::MAJOR, number));
    }
    INPUTS.iter().position(|(name, _)| *name == path).map(Place::Input)
}

/// Returns the place of a path of an open descriptor, as `/proc/self/fd/3`, whose target has no
/// name.
fn place_of_descriptor(device: &Device, path: &[u8]) -> Option<Place> {
    let mut own = Text::<40>::new();
    // SAFETY: a call without arguments.
    own.push(b"/proc/").number(unsafe { abi::getpid() } as u64).push(b"/fd/");
    let prefixes = [b"/proc/self/fd/".as_slice(), b"/proc/thread-self/fd/", b"/dev/fd/", own.as_bytes()];
    let number = prefixes.iter().find_map(|prefix| path.strip_prefix(*prefix))?;
    let [number] = crate::text::numbers::<1>(number)?;
    let fd = c_int::try_from(number).ok()?;
    if device.is_memory_fd(fd) {
        return Some(Place::Framebuffer);
    }
    input_of(device, fd).map(Place::Input).or_else(|| terminal::place_of_descriptor(device, fd))
}

/// Returns the place that the path of an open descriptor leads to.
///
/// # Safety
/// `path` is null or a C string.
pub unsafe fn place_of_descriptor_link(path: *const c_char) -> Option<Place> {
    if path.is_null() {
        return None;
    }
    let device = device()?;
    // SAFETY: it is a C string, says the caller.
    let bytes = unsafe { CStr::from_ptr(path) }.to_bytes();
    if bytes.first() != Some(&b'/') || bytes.len() >= ROOM {
        return None;
    }
    place_of_descriptor(&device, normalized(bytes).as_bytes())
}

//! The paths that the library stands for; every other path is the system's.

use core::ffi::{CStr, c_char};

/// A place that the device has in the file system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The framebuffer.
    Framebuffer,
    /// A console: the pseudo terminal stands for it.
    Console,
    /// An input device, by its index in [`INPUTS`].
    Input(usize),
    /// A file of the framebuffer in `/sys`, by its index in [`crate::sysfs::FILES`].
    Attribute(usize),
    /// A folder of these files.
    Folder,
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

/// Returns the place of a path.
///
/// # Safety
/// `path` is null or a C string.
pub unsafe fn place(path: *const c_char) -> Option<Place> {
    if path.is_null() {
        return None;
    }
    // SAFETY: it is a C string, says the caller.
    place_of(unsafe { CStr::from_ptr(path) }.to_bytes())
}

fn place_of(path: &[u8]) -> Option<Place> {
    match path {
        b"/dev/fb0" | b"/dev/fb/0" | b"/dev/graphics/fb0" => return Some(Place::Framebuffer),
        b"/dev/console" | b"/dev/tty0" => return Some(Place::Console),
        b"/proc/fb" => return Some(Place::List),
        b"/sys/class/graphics"
        | b"/sys/class/graphics/"
        | b"/sys/class/graphics/fb0"
        | b"/sys/class/graphics/fb0/" => return Some(Place::Folder),
        _ => {}
    }
    if let Some(name) = path.strip_prefix(b"/sys/class/graphics/fb0/") {
        return crate::sysfs::FILES.iter().position(|f| *f == name).map(Place::Attribute);
    }
    let terminal = path.strip_prefix(b"/dev/tty").or_else(|| path.strip_prefix(b"/dev/vc/"));
    if let Some(number) = terminal {
        // /dev/tty itself is the controlling terminal, and /dev/ttyS0 a serial line.
        let is_number = matches!(number.len(), 1 | 2) && number.iter().all(u8::is_ascii_digit);
        return is_number.then_some(Place::Console);
    }
    INPUTS.iter().position(|(name, _)| *name == path).map(Place::Input)
}

//! The files of the framebuffer in `/sys/class/graphics/fb0`, and `/proc/fb`.
//!
//! To read, a file is a text as of the moment when it is opened. To write, it is a memory that the
//! program `fbptr` keeps and reads at each vertical blank, because streams and programs write by
//! ways that the library does not see; where it sees the call, the text takes effect at once.

use crate::abi::{self, fail};
use crate::attributes::{self, Change, WRITABLE};
use crate::device::{Device, device, status};
use crate::framebuffer;
use crate::layout as at;
use crate::text::Text;
use core::ffi::c_int;
use core::sync::atomic::{AtomicU32, Ordering};

/// A file.
pub struct File {
    pub name: &'static [u8],
    pub is_writable: bool,
}

const fn read_only(name: &'static [u8]) -> File {
    File { name, is_writable: false }
}

const fn writable(name: &'static [u8]) -> File {
    File { name, is_writable: true }
}

/// The files.
pub const FILES: [File; 14] = [
    read_only(b"name"),
    writable(b"bits_per_pixel"),
    writable(b"virtual_size"),
    read_only(b"stride"),
    writable(b"pan"),
    writable(b"mode"),
    read_only(b"modes"),
    writable(b"blank"),
    writable(b"rotate"),
    writable(b"state"),
    read_only(b"dev"),
    read_only(b"uevent"),
    writable(b"console"),
    writable(b"cursor"),
];

/// Opens a file.
pub fn open(device: &Device, file: usize, flags: c_int) -> c_int {
    let file = &FILES[file];
    if flags & abi::O_ACCMODE == 0 {
        settle(device);
        let mut text = Text::<512>::new();
        write_attribute(device, file.name, &mut text);
        return open_text(&text, flags);
    }
    let Some(index) = WRITABLE.iter().position(|name| name.as_bytes() == file.name) else {
        return fail(abi::EACCES);
    };
    device.word(at::WRITERS_AT).fetch_add(1, Ordering::AcqRel);
    let number = device.word(at::ATTRIBUTE_FDS_AT + index * 4).load(Ordering::Relaxed);
    device.open_number(number.into(), flags & (abi::O_ACCMODE | abi::O_CLOEXEC))
}

/// Opens the list of framebuffers.
pub fn open_list(flags: c_int) -> c_int {
    let mut text = Text::new();
    text.push(b"0 fbptr\n");
    open_text(&text, flags)
}

fn open_text(text: &Text<512>, flags: c_int) -> c_int {
    let close_on_exec = if flags & abi::O_CLOEXEC != 0 { abi::MFD_CLOEXEC } else { 0 };
    // SAFETY: the name is a C string.
    let fd = unsafe { abi::memfd_create(c"fb0".as_ptr(), close_on_exec) };
    if fd >= 0 {
        crate::hooks::write_all(fd, text.as_bytes());
        abi::next_lseek(fd, 0, abi::SEEK_SET);
    }
    fd
}

/// Waits until what was written to files that have been opened since the last call has taken
/// effect.
pub fn settle(device: &Device) {
    static SETTLED: AtomicU32 = AtomicU32::new(0);
    let writers = device.word(at::WRITERS_AT).load(Ordering::Acquire);
    if SETTLED.swap(writers, Ordering::Relaxed) != writers {
        // A text without a line's end is taken when it has been there for a whole frame.
        for _ in 0..3 {
            device.wait_for_vsync();
        }
    }
}

/// Writes a text to a file that is open for writing: its result, or `None` for another descriptor.
pub fn write(fd: c_int, text: &[u8]) -> Option<isize> {
    let device = device().filter(|device| device.word(at::WRITERS_AT).load(Ordering::Relaxed) > 0)?;
    let status = status(fd)?;
    let is_same = |index: &usize| {
        let inode = device.long(at::ATTRIBUTE_INODES_AT + index * 8).load(Ordering::Relaxed);
        device.is_memory(status.dev, device.inode()) && status.ino == inode
    };
    let index = (0..WRITABLE.len()).find(is_same)?;
    let change = attributes::change(WRITABLE[index], text, &device.mode(), &device.limits());
    let change = match change {
        Ok(change) => change,
        Err(error) => return Some(fail(error) as isize),
    };
    match change {
        Change::Mode(var) => framebuffer::set_mode(&device, &var),
        Change::Pan(xoffset, yoffset) => device.pan(xoffset, yoffset),
        Change::Blank(level) => device.word(at::BLANK_AT).store(level, Ordering::Release),
        Change::Nothing => {}
    }
    Some(text.len() as isize)
}

fn write_attribute(device: &Device, name: &[u8], text: &mut Text<512>) {
    let var = device.mode();
    let pair = |text: &mut Text<512>, a: u32, b: u32| {
        text.number(a.into()).push(b",").number(b.into()).push(b"\n");
    };
    match name {
        b"name" => _ = text.push(b"fbptr\n"),
        b"bits_per_pixel" => _ = text.number(var.bits_per_pixel.into()).push(b"\n"),
        b"virtual_size" => pair(text, var.xres_virtual, var.yres_virtual),
        b"stride" => _ = text.number(device.limits().line_length(&var).into()).push(b"\n"),
        b"pan" => pair(text, var.xoffset, var.yoffset),
        b"mode" | b"modes" => {
            text.push(b"U:").number(var.xres.into()).push(b"x").number(var.yres.into()).push(b"p-");
            text.number(device.limits().hz.into()).push(b"\n");
        }
        b"rotate" | b"state" => _ = text.push(b"0\n"),
        b"dev" => _ = text.push(b"29:0\n"),
        b"uevent" => _ = text.push(b"MAJOR=29\nMINOR=0\nDEVNAME=fb0\n"),
        // The kernel leaves these empty to read.
        _ => {}
    }
}

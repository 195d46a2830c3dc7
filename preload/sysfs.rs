//! The files of the framebuffer in `/sys/class/graphics/fb0`, and `/proc/fb`: texts as of the
//! moment when they are opened.

use crate::abi;
use crate::device::Device;
use crate::text::Text;
use core::ffi::c_int;

/// Names of the files.
pub const FILES: [&[u8]; 13] = [
    b"name",
    b"bits_per_pixel",
    b"virtual_size",
    b"stride",
    b"pan",
    b"mode",
    b"modes",
    b"blank",
    b"rotate",
    b"state",
    b"dev",
    b"uevent",
    b"console",
];

/// Opens a file, or the list of framebuffers.
pub fn open(device: &Device, file: Option<usize>, flags: c_int) -> c_int {
    let mut text = Text::<512>::new();
    match file {
        Some(file) => write_attribute(device, FILES[file], &mut text),
        None => {
            text.push(b"0 fbptr\n");
        }
    }
    let close_on_exec = if flags & abi::O_CLOEXEC != 0 { abi::MFD_CLOEXEC } else { 0 };
    // SAFETY: the name is a C string.
    let fd = unsafe { abi::memfd_create(c"fb0".as_ptr(), close_on_exec) };
    if fd >= 0 {
        crate::hooks::write_all(fd, text.as_bytes());
        // SAFETY: the descriptor is ours.
        unsafe { abi::lseek(fd, 0, abi::SEEK_SET) };
    }
    fd
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
        b"stride" => _ = text.number(var.line_length().into()).push(b"\n"),
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

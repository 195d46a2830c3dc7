//! The picture on the device: an allocation of the program in the place of the device's memory, or
//! a copy that is written when the program shows something.

use super::allocations::{PAGE, replace, restore};
use super::blit::Kind;
use super::state::state;
use crate::abi;
use crate::device::{Device, device};
use crate::framebuffer::set_mode;
use crate::layout as at;
use crate::memory::mmap;
use crate::mode::{self, FORMATS, Format, Var};
use core::ptr;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Start and bytes of the allocation that is the device's memory; 0 if none is.
static ATTACHED: AtomicUsize = AtomicUsize::new(0);
static ATTACHED_LEN: AtomicUsize = AtomicUsize::new(0);
/// The program has shown this allocation; before that its size was the only reason.
static IS_SHOWN: AtomicBool = AtomicBool::new(false);

/// Returns the allocation that is the device's memory.
pub fn attached() -> Option<usize> {
    Some(ATTACHED.load(Ordering::Acquire)).filter(|start| *start != 0)
}

/// Sets the mode of the window's size with a format, if the device has it.
fn set_format(device: &Device, name: &str) -> bool {
    let (width, height) = state().size.get();
    let Some(format) = FORMATS.iter().find(|format| format.name == name) else { return false };
    let [red, green, blue, transp] = format.channels;
    let wanted = Var {
        xres: width,
        yres: height,
        xres_virtual: width,
        yres_virtual: height,
        bits_per_pixel: format.bits,
        red,
        green,
        blue,
        transp,
        ..Var::default()
    };
    let checked = mode::check(&wanted, &device.limits());
    if let Ok(checked) = checked {
        set_mode(device, &checked);
    }
    checked.is_ok()
}

/// Returns the name of the device's format for pixels, with the fourth byte as alpha if the user
/// has asked for that.
fn format_name(device: &Device, kind: Kind) -> Option<&'static str> {
    let default = FORMATS.get(device.limits().format as usize).map_or("", |format: &Format| format.name);
    Some(match (kind.direct_order()?, default) {
        ([0, 1, 2], "rgba") if kind.bytes() == 4 => "rgba",
        ([2, 1, 0], "rgba") if kind.bytes() == 4 => "bgra",
        ([0, 1, 2], _) if kind.bytes() == 4 => "rgbx",
        ([2, 1, 0], _) if kind.bytes() == 4 => "bgrx",
        ([0, 1, 2], _) => "rgb24",
        _ => "bgr24",
    })
}

/// Makes an allocation the device's memory. Returns false if it cannot be.
fn attach(start: usize, kind: Kind) -> bool {
    let Some(device) = device() else { return false };
    let (width, height) = state().size.get();
    let line = width as usize * kind.bytes();
    let len = line * height as usize;
    let Some(name) = format_name(&device, kind).filter(|_| line.is_multiple_of(4)) else { return false };
    let fits = super::allocations::region_of(start).is_some_and(|(at, room)| at == start && room >= len);
    let limits = device.limits();
    if !fits || width > limits.width || height > limits.height {
        return false;
    }
    if attached() != Some(start) || ATTACHED_LEN.load(Ordering::Relaxed) != len {
        detach();
        let fd = device.open_memory(abi::O_RDWR | abi::O_CLOEXEC);
        if fd < 0 {
            return false;
        }
        let is_replaced = replace(start, len, fd);
        // SAFETY: the descriptor is ours.
        unsafe { abi::close(fd) };
        if !is_replaced {
            return false;
        }
        ATTACHED_LEN.store(len, Ordering::Relaxed);
        ATTACHED.store(start, Ordering::Release);
        device.long(at::DIRECT_BYTES_AT).store(len as u64, Ordering::Release);
    }
    set_format(&device, name)
}

/// Gives the program's allocation memory of its own again.
fn detach() {
    let start = ATTACHED.swap(0, Ordering::AcqRel);
    if start != 0 {
        if let Some(device) = device() {
            device.long(at::DIRECT_BYTES_AT).store(0, Ordering::Release);
        }
        restore(start, ATTACHED_LEN.load(Ordering::Relaxed));
    }
}

/// Makes an allocation of the right size the device's memory, until the program shows another one.
pub fn guess(start: usize, bytes: usize) {
    if !IS_SHOWN.load(Ordering::Relaxed) && !state().is_composed.get() {
        attach(start, Kind::rgb(bytes));
    }
}

/// Shows an allocation of the program as it is, with its first row at the bottom if `is_flipped`.
/// Returns false if that cannot be.
pub fn show(start: usize, kind: Kind, is_flipped: bool) -> bool {
    if state().is_composed.get() || !attach(start, kind) {
        return false;
    }
    IS_SHOWN.store(true, Ordering::Relaxed);
    if let Some(device) = device() {
        device.word(at::FLIPPED_AT).store(is_flipped.into(), Ordering::Release);
    }
    state().is_clear_due.set(false);
    true
}

/// Forgets an allocation that the program gives back: the picture stays.
pub fn forget(start: usize) {
    if ATTACHED.compare_exchange(start, 0, Ordering::AcqRel, Ordering::Relaxed).is_ok() {
        super::watch::end();
        IS_SHOWN.store(false, Ordering::Relaxed);
    }
}

/// Returns the rows of the picture for writing, R, G, B, A, from the top; null without a device.
pub fn canvas() -> *mut [u8; 4] {
    let here = state();
    if !here.canvas.get().is_null() {
        return here.canvas.get().cast();
    }
    let Some(device) = device() else { return ptr::null_mut() };
    let (width, height) = here.size.get();
    detach();
    here.is_composed.set(true);
    let fd = device.open_memory(abi::O_RDWR | abi::O_CLOEXEC);
    if fd < 0 || !set_format(&device, "rgbx") {
        return ptr::null_mut();
    }
    device.word(at::FLIPPED_AT).store(0, Ordering::Release);
    let len = (width as usize * height as usize * 4).next_multiple_of(PAGE);
    // SAFETY: a new map of the device's memory, which has room for a mode that was set.
    let memory = unsafe { mmap(ptr::null_mut(), len, abi::PROT_READ_WRITE, abi::MAP_SHARED, fd, 0) };
    // SAFETY: the descriptor is ours.
    unsafe { abi::close(fd) };
    if memory as usize == usize::MAX {
        return ptr::null_mut();
    }
    here.canvas.set(memory);
    memory.cast()
}

/// Carries out a `glClear` that nothing was drawn after, as before a part of the picture is.
pub fn clear_if_due() {
    let here = state();
    if !here.is_clear_due.replace(false) || (attached().is_some() && !here.is_composed.get()) {
        return;
    }
    let canvas = canvas();
    let (width, height) = here.size.get();
    for i in 0..width as usize * height as usize {
        if !canvas.is_null() {
            // SAFETY: the map has so many pixels.
            unsafe { canvas.add(i).write_volatile(here.clear_color.get()) };
        }
    }
}

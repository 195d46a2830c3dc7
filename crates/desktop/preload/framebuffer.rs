//! The requests of `linux/fb.h`, with the results of `drivers/video/fbdev/core/fbmem.c`.

use crate::abi;
use crate::device::Device;
use crate::layout as at;
use crate::mode::{self, Var};
use crate::sysfs;
use core::ffi::c_void;
use core::sync::atomic::Ordering;

const GET_VAR: u32 = 0x4600;
const PUT_VAR: u32 = 0x4601;
const GET_FIX: u32 = 0x4602;
const GET_PALETTE: u32 = 0x4604;
const PUT_PALETTE: u32 = 0x4605;
const PAN: u32 = 0x4606;
const GET_CONSOLE_MAP: u32 = 0x460f;
const PUT_CONSOLE_MAP: u32 = 0x4610;
const BLANK: u32 = 0x4611;
const GET_VBLANK: u32 = 0x8020_4612;
const WAIT_FOR_VSYNC: u32 = 0x4004_4620;

/// `struct fb_fix_screeninfo`.
#[repr(C)]
struct Fix {
    id: [u8; 16],
    smem_start: u64,
    smem_len: u32,
    kind: u32,
    type_aux: u32,
    visual: u32,
    xpanstep: u16,
    ypanstep: u16,
    ywrapstep: u16,
    line_length: u32,
    mmio_start: u64,
    mmio_len: u32,
    accel: u32,
    capabilities: u16,
    reserved: [u16; 2],
}

/// `struct fb_cmap`.
#[repr(C)]
#[derive(Clone, Copy)]
struct Palette {
    start: u32,
    len: u32,
    channels: [*mut u16; 4],
}

/// Carries out a request.
///
/// # Errors
/// `EINVAL` for a request that there is not, and what the kernel's own function answers.
///
/// # Safety
/// `argument` is what the request asks for.
pub unsafe fn request(device: &Device, request: u32, argument: *mut c_void) -> Result<(), i32> {
    // The level and the wait have no address. A request that there is not is refused below.
    let has_address = matches!(request, GET_VAR | PUT_VAR | GET_FIX | GET_PALETTE | PUT_PALETTE | PAN)
        || matches!(request, GET_CONSOLE_MAP | PUT_CONSOLE_MAP | GET_VBLANK);
    if argument.is_null() && has_address {
        return Err(abi::EFAULT);
    }
    if matches!(request, GET_VAR | PUT_VAR | GET_FIX | PAN) {
        sysfs::settle(device);
    }
    // SAFETY: the argument points to the structure that the request names, says the caller.
    unsafe {
        match request {
            GET_VAR => *argument.cast::<Var>() = device.mode(),
            PUT_VAR => put_var(device, &mut *argument.cast::<Var>())?,
            GET_FIX => *argument.cast::<Fix>() = fix(device),
            GET_PALETTE => get_palette(device, &*argument.cast::<Palette>())?,
            PUT_PALETTE => put_palette(device, &*argument.cast::<Palette>()),
            PAN => pan(device, &mut *argument.cast::<Var>())?,
            GET_CONSOLE_MAP | PUT_CONSOLE_MAP => console_map(request, &mut *argument.cast::<[u32; 2]>())?,
            BLANK => blank(device, argument as usize)?,
            GET_VBLANK => {
                // FB_VBLANK_HAVE_COUNT, and the count.
                let count = device.word(at::VSYNC_AT).load(Ordering::Acquire);
                *argument.cast::<[u32; 8]>() = [0x10, count, 0, 0, 0, 0, 0, 0];
            }
            WAIT_FOR_VSYNC => return device.wait_for_vsync().then_some(()).ok_or(abi::ETIMEDOUT),
            other => {
                device.log(0, other);
                return Err(abi::EINVAL);
            }
        }
    }
    Ok(())
}

fn put_var(device: &Device, var: &mut Var) -> Result<(), i32> {
    let checked = mode::check(var, &device.limits())?;
    let is_test = var.activate & mode::ACTIVATE_MASK == mode::ACTIVATE_TEST;
    *var = checked;
    if !is_test {
        set_mode(device, &checked);
    }
    Ok(())
}

/// Sets a mode that has been checked.
pub fn set_mode(device: &Device, checked: &Var) {
    let before = device.mode();
    if *checked != (Var { xoffset: checked.xoffset, yoffset: checked.yoffset, ..before }) {
        device.exclusively(|| device.set_mode(checked));
        set_default_palette(device, &before, checked);
    }
    if (before.xoffset, before.yoffset) != (checked.xoffset, checked.yoffset) {
        device.pan(checked.xoffset, checked.yoffset);
    }
}

/// Gives a depth that was not in use before its own palette.
fn set_default_palette(device: &Device, before: &Var, after: &Var) {
    let of = |var: &Var| (var.bits_per_pixel, var.grayscale);
    if after.bits_per_pixel <= 8 && of(before) != of(after) {
        for index in 0..1 << after.bits_per_pixel {
            let color = at::default_color(index, after.bits_per_pixel, after.grayscale != 0);
            device.long(at::PALETTE_AT + index as usize * 8).store(color, Ordering::Relaxed);
        }
        device.word(at::PALETTE_SETS_AT).fetch_add(1, Ordering::Release);
    }
}

fn fix(device: &Device) -> Fix {
    let var = device.mode();
    let mut id = [0; 16];
    id[..5].copy_from_slice(b"fbptr");
    Fix {
        id,
        smem_start: 0,
        smem_len: device.limits().smem_len,
        // FB_TYPE_PACKED_PIXELS
        kind: 0,
        type_aux: 0,
        // FB_VISUAL_MONO10, STATIC_PSEUDOCOLOR, PSEUDOCOLOR, TRUECOLOR
        visual: match (var.bits_per_pixel, var.grayscale) {
            (1, _) => 1,
            (2..=8, 1) => 5,
            (2..=8, _) => 3,
            _ => 2,
        },
        xpanstep: if var.bits_per_pixel >= 8 { 1 } else { (8 / var.bits_per_pixel.max(1)) as u16 },
        ypanstep: 1,
        ywrapstep: 0,
        line_length: device.limits().line_length(&var),
        mmio_start: 0,
        mmio_len: 0,
        // FB_ACCEL_NONE
        accel: 0,
        capabilities: 0,
        reserved: [0; 2],
    }
}

fn pan(device: &Device, wanted: &mut Var) -> Result<(), i32> {
    let var = device.mode();
    if !mode::can_pan(&var, wanted.xoffset, wanted.yoffset) || wanted.vmode & mode::VMODE_YWRAP != 0 {
        return Err(abi::EINVAL);
    }
    device.pan(wanted.xoffset, wanted.yoffset);
    *wanted = Var { xoffset: wanted.xoffset, yoffset: wanted.yoffset, ..var };
    Ok(())
}

/// Copies palette entries to the program, as `fb_cmap_to_user` does.
///
/// # Safety
/// The channels have room for the entries.
unsafe fn get_palette(device: &Device, to: &Palette) -> Result<(), i32> {
    let start = to.start as usize;
    if start >= at::PALETTE_ENTRIES || to.len == 0 {
        return Err(abi::EINVAL);
    }
    let count = (to.len as usize).min(at::PALETTE_ENTRIES - start);
    for i in 0..count {
        let entry = device.long(at::PALETTE_AT + (start + i) * 8).load(Ordering::Relaxed);
        for (channel, value) in to.channels.iter().zip(at::unpack_color(entry)) {
            if !channel.is_null() {
                // SAFETY: the channel has room for `to.len` entries, says the caller.
                unsafe { *channel.add(i) = value };
            }
        }
    }
    Ok(())
}

/// Sets palette entries; those beyond the last one are ignored, as in `fb_set_cmap`.
///
/// # Safety
/// The channels hold the entries.
unsafe fn put_palette(device: &Device, from: &Palette) {
    let start = from.start as usize;
    let count = (from.len as usize).min(at::PALETTE_ENTRIES.saturating_sub(start));
    for i in 0..count {
        let value = |channel: usize| {
            let values = from.channels[channel];
            // SAFETY: the channel holds `from.len` entries, says the caller.
            if values.is_null() { 0 } else { unsafe { *values.add(i) } }
        };
        let color = at::pack_color(value(0), value(1), value(2), value(3));
        device.long(at::PALETTE_AT + (start + i) * 8).store(color, Ordering::Relaxed);
    }
    device.word(at::PALETTE_SETS_AT).fetch_add(1, Ordering::Release);
}

/// `struct fb_con2fbmap`: the console, and the framebuffer that shows it.
fn console_map(request: u32, map: &mut [u32; 2]) -> Result<(), i32> {
    if !(1..=63).contains(&map[0]) || (request == PUT_CONSOLE_MAP && map[1] != 0) {
        return Err(abi::EINVAL);
    }
    map[1] = 0;
    Ok(())
}

fn blank(device: &Device, level: usize) -> Result<(), i32> {
    // FB_BLANK_POWERDOWN is the highest level, and stands for those above it.
    device.word(at::BLANK_AT).store(level.min(4) as u32, Ordering::Release);
    Ok(())
}

//! The requests of consoles and virtual terminals (`linux/kd.h`, `linux/vt.h`), on the pseudo
//! terminals that stand for them. All virtual terminals share one mode and one keyboard mode.

use crate::abi;
use crate::device::Device;
use crate::keys;
use crate::layout as at;
use core::ffi::c_void;
use core::sync::atomic::Ordering;

/// Carries out a request.
///
/// # Errors
/// `EINVAL` for a request that there is not.
///
/// # Safety
/// `argument` is what the request asks for.
pub unsafe fn request(device: &Device, request: u32, argument: *mut c_void) -> Result<(), i32> {
    let set = |offset: usize, value: u32| device.word(offset).store(value, Ordering::Release);
    let word = |offset: usize| device.word(offset).load(Ordering::Acquire);
    let number = argument as usize as u32;
    // Requests that write through their argument.
    let writes = matches!(request, 0x4b31 | 0x4b33 | 0x4b3b | 0x4b44 | 0x4b46 | 0x4b62 | 0x4b64)
        || matches!(request, 0x5600..=0x5603);
    if writes && argument.is_null() {
        return Err(abi::EFAULT);
    }
    // SAFETY: the argument points to what the request names, says the caller.
    unsafe {
        match request {
            // KDGETLED, KDSETLED, KDGKBLED, KDSKBLED
            0x4b31 | 0x4b64 => *argument.cast::<u8>() = word(at::LEDS_AT) as u8,
            0x4b32 | 0x4b65 => set(at::LEDS_AT, number & 7),
            // KDGKBTYPE: KB_101
            0x4b33 => *argument.cast::<u8>() = 2,
            // KDSETMODE, KDGETMODE
            0x4b3a if number <= 3 => set(at::CONSOLE_MODE_AT, number),
            0x4b3b => *argument.cast::<i32>() = word(at::CONSOLE_MODE_AT) as i32,
            // KDGKBMODE, KDSKBMODE
            0x4b44 => *argument.cast::<i32>() = word(at::KEYBOARD_MODE_AT) as i32,
            0x4b45 if number <= 4 => set(at::KEYBOARD_MODE_AT, number),
            // KDGKBENT
            0x4b46 => {
                let [table, index, ..] = *argument.cast::<[u8; 2]>();
                *argument.cast::<u16>().add(1) = keys::entry(table, index).ok_or(abi::EINVAL)?;
            }
            // KDSKBENT: a key map of its own does not change what the keys send.
            0x4b47 => {}
            // KDGKBMETA: K_ESCPREFIX
            0x4b62 => *argument.cast::<i32>() = 4,
            // KIOCSOUND, KDMKTONE, KDENABIO, KDDISABIO, KDSKBMETA, KDSIGACCEPT, KDKBDREP
            0x4b2f | 0x4b30 | 0x4b36 | 0x4b37 | 0x4b4e | 0x4b52 | 0x4b63 => {}
            // VT_OPENQRY: the first free terminal
            0x5600 => *argument.cast::<i32>() = 2,
            // VT_GETMODE, VT_SETMODE
            0x5601 => {
                *argument.cast::<[u32; 2]>() = [word(at::TERMINAL_MODE_AT), word(at::TERMINAL_MODE_AT + 4)]
            }
            0x5602 => {
                let [mode, signals] = *argument.cast::<[u32; 2]>();
                set(at::TERMINAL_MODE_AT, mode);
                set(at::TERMINAL_MODE_AT + 4, signals);
            }
            // VT_GETSTATE: the active one, no signal, those in use
            0x5603 => {
                let active = word(at::ACTIVE_TERMINAL_AT);
                *argument.cast::<[u16; 3]>() = [active as u16, 0, 1 | 1 << (active & 15)];
            }
            // VT_ACTIVATE
            0x5606 if (1..=63).contains(&number) => set(at::ACTIVE_TERMINAL_AT, number),
            // VT_RELDISP, VT_WAITACTIVE, VT_DISALLOCATE, VT_LOCKSWITCH, VT_UNLOCKSWITCH
            0x5605 | 0x5607 | 0x5608 | 0x560b | 0x560c => {}
            other => {
                device.log(1, other);
                return Err(abi::EINVAL);
            }
        }
    }
    Ok(())
}

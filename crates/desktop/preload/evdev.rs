//! The requests of `linux/input.h` on the event devices: event0 is a keyboard, event1 a pointer
//! with absolute coordinates, as the tablets of virtual machines are, and a wheel.

use crate::abi;
use crate::device::Device;
use crate::keys;
use crate::layout as at;
use core::ffi::{c_int, c_void};
use core::ptr;
use core::sync::atomic::Ordering;

/// Names of the devices.
const NAMES: [&[u8]; 2] = [b"fbptr keyboard\0", b"fbptr pointer\0"];
/// Places where the devices are plugged in.
const PLACES: [&[u8]; 2] = [b"fbptr/input0\0", b"fbptr/input1\0"];

const EV_SYN: u32 = 0;
const EV_KEY: u32 = 1;
const EV_REL: u32 = 2;
const EV_ABS: u32 = 3;
const EV_MSC: u32 = 4;
const EV_LED: u32 = 0x11;
const EV_REP: u32 = 0x14;
const REL_WHEELS: [u32; 2] = [6, 8];
const BUTTONS: [u32; 3] = [0x110, 0x111, 0x112];

/// Carries out a request on device `index`. Returns what the call returns.
///
/// # Errors
/// `EINVAL` for a request that there is not.
///
/// # Safety
/// `argument` is what the request asks for.
pub unsafe fn request(
    device: &Device,
    fd: c_int,
    index: usize,
    request: u32,
    argument: *mut c_void,
) -> Result<c_int, i32> {
    let len = (request >> 16 & 0x3fff) as usize;
    let number = request & 0xff;
    let is_read = request >> 30 == 2;
    if argument.is_null() && !matches!(number, 0x90 | 0x91) {
        return Err(abi::EFAULT);
    }
    // SAFETY: the argument points to `len` bytes, says the caller.
    unsafe {
        let give = |bytes: &[u8]| {
            let count = bytes.len().min(len);
            ptr::copy_nonoverlapping(bytes.as_ptr(), argument.cast(), count);
            Ok(count as c_int)
        };
        match number {
            // EVIOCGVERSION, EVIOCGID (a virtual bus), EVIOCGREP, EVIOCSREP
            0x01 if is_read => give(&0x0001_0001u32.to_ne_bytes()).map(|_| 0),
            0x02 if is_read => give(&[6, 0, 0xb0, 0xfb, index as u8 + 1, 0, 1, 0]).map(|_| 0),
            0x03 if is_read && index == 0 => {
                give(&[250u32, 33].map(u32::to_ne_bytes).concat_words()).map(|_| 0)
            }
            0x03 if index == 0 => Ok(0),
            // EVIOCGNAME, EVIOCGPHYS, EVIOCGUNIQ, EVIOCGPROP
            0x06 => give(NAMES[index]),
            0x07 => give(PLACES[index]),
            0x08 => give(b"\0"),
            0x09 => give(&[0; 8][..len.min(8)]),
            // EVIOCGKEY
            0x18 => give(&held(device, index)),
            // EVIOCGLED, EVIOCGSND, EVIOCGSW: none
            0x19..=0x1b => {
                ptr::write_bytes(argument.cast::<u8>(), 0, len);
                Ok(len as c_int)
            }
            0x20..=0x3f if is_read => give(&capabilities(index, number - 0x20)),
            0x40..=0x7f if is_read && index == 1 => {
                give(&axis(device, number - 0x40)?.map(u32::to_ne_bytes).concat_words()).map(|_| 0)
            }
            // EVIOCGRAB, EVIOCREVOKE
            0x90 => Ok(0),
            // EVIOCSCLOCKID: the sender stamps the events.
            0xa0 => {
                let clock = *argument.cast::<u32>();
                let known = matches!(clock, 0 | 1 | 7);
                let bytes = [b'c', clock as u8];
                if !known || abi::send(fd, bytes.as_ptr().cast(), 2, abi::MSG_NOSIGNAL) != 2 {
                    return Err(abi::EINVAL);
                }
                Ok(0)
            }
            _ => {
                device.log(2, request);
                Err(abi::EINVAL)
            }
        }
    }
}

/// Joins words of four bytes.
trait ConcatWords {
    fn concat_words(self) -> [u8; 24];
}

impl<const N: usize> ConcatWords for [[u8; 4]; N] {
    fn concat_words(self) -> [u8; 24] {
        let mut bytes = [0; 24];
        for (to, from) in bytes.iter_mut().zip(self.as_flattened()) {
            *to = *from;
        }
        bytes
    }
}

/// Returns the bits of the event types, or of one type's codes.
fn capabilities(index: usize, kind: u32) -> [u8; 96] {
    let mut bits = [0; 96];
    let mut set = |bit: u32| bits[bit as usize / 8] |= 1 << (bit % 8);
    match (index, kind) {
        (0, EV_SYN) => [EV_SYN, EV_KEY, EV_MSC, EV_LED, EV_REP].into_iter().for_each(set),
        (_, EV_SYN) => [EV_SYN, EV_KEY, EV_REL, EV_ABS].into_iter().for_each(set),
        (0, EV_KEY) => keys::KEYS.iter().for_each(|key| set(key.code.into())),
        (0, EV_MSC) => set(4),
        (0, EV_LED) => (0..3).for_each(set),
        (1, EV_KEY) => BUTTONS.into_iter().for_each(set),
        (1, EV_REL) => REL_WHEELS.into_iter().for_each(set),
        (1, EV_ABS) => (0..2).for_each(set),
        _ => {}
    }
    bits
}

/// Returns the bits of the keys or buttons that are held.
fn held(device: &Device, index: usize) -> [u8; at::HELD_BYTES] {
    let mut bits = capabilities(index, EV_KEY);
    for (i, bytes) in bits.chunks_mut(4).enumerate() {
        let word = device.word(at::HELD_AT + i * 4).load(Ordering::Relaxed);
        for (byte, held) in bytes.iter_mut().zip(word.to_le_bytes()) {
            *byte &= held;
        }
    }
    bits
}

/// Returns `struct input_absinfo` of an axis.
fn axis(device: &Device, axis: u32) -> Result<[u32; 6], i32> {
    let limits = device.limits();
    let size = match axis {
        0 => limits.width,
        1 => limits.height,
        _ => return Err(abi::EINVAL),
    };
    let value = device.word(at::POINTER_AT + axis as usize * 4).load(Ordering::Relaxed);
    Ok([value, 0, size - 1, 0, 0, 0])
}

//! Input of the window: events of the keyboard and the pointer, as GLUT's callbacks.

use super::state::state;
use crate::abi;
use crate::keys::{KEYS, Key};
use crate::open::open_place;
use core::ffi::{c_int, c_void};

/// `struct input_event`.
#[repr(C)]
#[derive(Clone, Copy)]
struct Event {
    time: [i64; 2],
    kind: u16,
    code: u16,
    value: i32,
}

const KEY: u16 = 1;
const RELATIVE: u16 = 2;
const ABSOLUTE: u16 = 3;
const WHEEL: u16 = 8;
/// Codes of the left, the middle and the right button, as GLUT numbers them.
const BUTTONS: [u16; 3] = [0x110, 0x112, 0x111];

/// Opens the devices.
pub fn open() {
    for (fd, path) in state().inputs.iter().zip([c"/dev/input/event0", c"/dev/input/event1"]) {
        let flags = abi::O_RDWR | abi::O_NONBLOCK | abi::O_CLOEXEC;
        // SAFETY: the path is a C string.
        fd.set(unsafe { open_place(abi::AT_FDCWD, path.as_ptr(), flags) }.unwrap_or(-1));
    }
}

/// Calls the callbacks of what has come.
pub fn pass_on() {
    for (index, fd) in state().inputs.iter().enumerate() {
        let mut is_moved = false;
        let mut event = Event { time: [0; 2], kind: 0, code: 0, value: 0 };
        let len = size_of::<Event>();
        // SAFETY: the event has room for its length. A device gives whole events.
        while fd.get() >= 0
            && unsafe { abi::read(fd.get(), (&raw mut event).cast::<c_void>(), len) } == len as isize
        {
            match (index, event.kind) {
                (0, KEY) => key(event.code, event.value != 0),
                (1, ABSOLUTE) => {
                    let (x, y) = state().pointer.get();
                    let place = if event.code == 0 { (event.value, y) } else { (x, event.value) };
                    is_moved |= place != (x, y);
                    state().pointer.set(place);
                }
                (1, KEY) => {
                    move_if(core::mem::take(&mut is_moved));
                    button(event.code, event.value != 0);
                }
                (1, RELATIVE) if event.code == WHEEL => wheel(event.value),
                _ => {}
            }
        }
        move_if(is_moved);
    }
}

fn move_if(is_moved: bool) {
    let here = state();
    let callbacks = &here.callbacks;
    let motion = if here.buttons.get() != 0 { &callbacks.motion } else { &callbacks.passive_motion };
    if let Some(motion) = motion.get().filter(|_| is_moved) {
        let (x, y) = here.pointer.get();
        motion(x, y);
    }
}

fn button(code: u16, is_down: bool) {
    let here = state();
    let Some(number) = BUTTONS.iter().position(|button| *button == code) else { return };
    let bit = 1 << number;
    here.buttons.set(if is_down { here.buttons.get() | bit } else { here.buttons.get() & !bit });
    if let Some(mouse) = here.callbacks.mouse.get() {
        let (x, y) = here.pointer.get();
        mouse(number as c_int, (!is_down).into(), x, y);
    }
}

/// A wheel turns: its own callback, or buttons 3 and 4 that are pressed and released.
fn wheel(steps: i32) {
    let here = state();
    let (x, y) = here.pointer.get();
    for _ in 0..steps.unsigned_abs().min(100) {
        if let Some(wheel) = here.callbacks.wheel.get() {
            wheel(0, steps.signum(), x, y);
        } else if let Some(mouse) = here.callbacks.mouse.get() {
            let number = if steps > 0 { 3 } else { 4 };
            mouse(number, 0, x, y);
            mouse(number, 1, x, y);
        }
    }
}

fn key(code: u16, is_down: bool) {
    let here = state();
    let modifier = match code {
        42 | 54 => 1,
        29 | 97 => 2,
        56 | 100 => 4,
        _ => 0,
    };
    if modifier != 0 {
        let held = here.modifiers.get();
        here.modifiers.set(if is_down { held | modifier } else { held & !modifier });
        return;
    }
    if code == 58 {
        here.is_caps.set(here.is_caps.get() != is_down);
        return;
    }
    let Some(key) = KEYS.iter().find(|key| u16::from(key.code) == code) else { return };
    let (x, y) = here.pointer.get();
    let callbacks = &here.callbacks;
    if let Some(number) = special(key.name) {
        let callback = if is_down { &callbacks.special } else { &callbacks.special_up };
        if let Some(callback) = callback.get() {
            callback(number, x, y);
        }
    } else if let Some(character) = character(key) {
        let callback = if is_down { &callbacks.keyboard } else { &callbacks.keyboard_up };
        if let Some(callback) = callback.get() {
            callback(character, x, y);
        }
    }
}

/// Returns the character of a key, as the modifiers make it.
fn character(key: &Key) -> Option<u8> {
    let [plain, shifted] = key.characters;
    let held = state().modifiers.get();
    let is_shifted = held & 1 != 0;
    let character = match plain {
        0 => match key.sequence.as_bytes() {
            b"\x7f" => 8,
            [byte] => *byte,
            _ if key.name == "delete" => 127,
            _ => return None,
        },
        b'a'..=b'z' if held & 2 != 0 => plain & 0x1f,
        b'a'..=b'z' if is_shifted != state().is_caps.get() => shifted,
        b'a'..=b'z' => plain,
        _ if is_shifted => shifted,
        _ => plain,
    };
    Some(character)
}

/// Returns the number of a key that is no character.
fn special(name: &str) -> Option<c_int> {
    const NAMES: [&str; 9] = ["left", "up", "right", "down", "pageup", "pagedown", "home", "end", "insert"];
    if let Some(at) = NAMES.iter().position(|other| *other == name) {
        return Some(100 + at as c_int);
    }
    match name.as_bytes() {
        [b'f', digit @ b'1'..=b'9'] => Some((digit - b'0').into()),
        [b'f', b'1', digit @ b'0'..=b'2'] => Some((10 + digit - b'0').into()),
        _ => None,
    }
}

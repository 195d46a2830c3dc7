//! The engine for a page: a stream of commands, run on the calling thread, as functions of a C ABI.
//!
//! In: the bytes of a stream, which the host writes into the module's memory
//! ([`fbptr_reserve`]), and what its user wants to see. Out: pixels, replies and errors, read from
//! the module's memory after each call. The module imports nothing: no clock, no file, no thread.
//!
//! Promise: the pixels are those of `fbptr play` with the same stream. No call traps, but where
//! memory or stack run out; the host then makes a new instance.

mod player;

pub use player::{LIMITS, Player, State, View};

use fbptr_engine::Pace;
use std::cell::RefCell;

/// One instance, as the host sees it.
#[derive(Default)]
struct Instance {
    /// Bytes that the host has written.
    input: Vec<u8>,
    view: View,
    player: Option<Player>,
    /// Text of the last call that has one.
    text: Vec<u8>,
}

thread_local! {
    static INSTANCE: RefCell<Instance> = RefCell::new(Instance::default());
}

fn with<T>(action: impl FnOnce(&mut Instance) -> T) -> T {
    INSTANCE.with_borrow_mut(action)
}

/// Makes room for `length` bytes of input, and returns where they are to be written; null if there
/// is no memory for them.
// SAFETY: no other function of a program that links this crate has this name; so with all below.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_reserve(length: usize) -> *mut u8 {
    with(|i| {
        i.input = Vec::new();
        match i.input.try_reserve_exact(length) {
            Ok(()) => {
                i.input.resize(length, 0);
                i.input.as_mut_ptr()
            }
            Err(_) => std::ptr::null_mut(),
        }
    })
}

/// Begins the stream that was written. Returns 0, or 1 if it has no frame, and the reason as text.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_load() -> u32 {
    with(|i| {
        // The memory of the last stream is free before that of the next one is taken.
        i.player = None;
        match Player::new(std::mem::take(&mut i.input), &i.view) {
            Ok(player) => {
                i.player = Some(player);
                0
            }
            Err(reason) => {
                i.text = reason.into_bytes();
                1
            }
        }
    })
}

/// Runs the stream: to its end (pace 0), for one command (1), or up to the next `PRESENT` (2).
/// Returns 0 if it can go on, 1 if it pauses for [`fbptr_pause_ms`], 2 at its end.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_run(pace: u32) -> u32 {
    let pace = match pace {
        1 => Pace::OneCommand,
        2 => Pace::OneFrame,
        _ => Pace::Free,
    };
    with(|i| match i.player.as_mut().map(|p| p.run(pace)) {
        Some(State::Ready) => 0,
        Some(State::Pauses) => 1,
        Some(State::Ended) | None => 2,
    })
}

/// Returns for how many milliseconds the stream pauses.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_pause_ms() -> f64 {
    with(|i| i.player.as_ref().map_or(0.0, |p| p.pause_ms()))
}

/// Sets the view of streams that begin later: angles in radians about the up axis and the viewer's
/// right, a factor on the distance, and steps to the right and up, in distances.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_view(yaw: f64, pitch: f64, zoom: f64, right: f64, up: f64) {
    with(|i| {
        let camera = i.player.as_ref().map(Player::camera);
        i.view.set_camera([yaw, pitch], zoom, [right, up], camera);
    });
}

/// Adds a turn of N-dimensional scenes in the plane of two axes, in degrees; with two equal axes
/// takes all turns back.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_turn(a: usize, b: usize, angle_deg: f64) {
    with(|i| i.view.turn(a, b, angle_deg));
}

/// Lets streams that begin later follow what is seen at a pixel; at a negative place nothing.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_trace(x: i32, y: i32) {
    with(|i| i.view.trace = (x >= 0 && y >= 0).then_some([x, y]));
}

/// Returns where the pixels are, row by row from the upper left corner, four bytes each: R G B A.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_pixels() -> *const u8 {
    with(|i| i.player.as_ref().map_or(std::ptr::null(), |p| p.memory().bytes().as_ptr()))
}

/// Returns the frame's width.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_width() -> u32 {
    with(|i| i.player.as_ref().map_or(0, |p| p.memory().width()))
}

/// Returns the frame's height.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_height() -> u32 {
    with(|i| i.player.as_ref().map_or(0, |p| p.memory().height()))
}

/// Returns the CRC-32 of the pixels.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_crc() -> u32 {
    with(|i| i.player.as_ref().map_or(0, Player::crc))
}

/// Writes what has happened since the last call as JSON, to be read as text.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_report() {
    with(|i| i.text = i.player.as_mut().map_or_else(Vec::new, |p| p.report().to_string().into_bytes()));
}

/// Writes what depth and name are at a pixel, as text.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_inspect(x: i32, y: i32) {
    with(|i| i.text = i.player.as_mut().map_or_else(Vec::new, |p| p.inspect(x, y).into_bytes()));
}

/// Writes the frame as a PNG file.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_png() {
    with(|i| i.text = i.player.as_ref().map_or_else(Vec::new, Player::png));
}

/// Writes the verbs as JSON: name, group, and the forms with their descriptions.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_verbs() {
    with(|i| i.text = player::verbs().to_string().into_bytes());
}

/// Returns where the text of the last call is that has one.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_text() -> *const u8 {
    with(|i| i.text.as_ptr())
}

/// Returns the bytes of that text.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn fbptr_text_bytes() -> usize {
    with(|i| i.text.len())
}

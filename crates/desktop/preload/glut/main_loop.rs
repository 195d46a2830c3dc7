//! GLUT's main loop: input, timers, the display, and idle time, at most once for each vertical
//! blank where the display goes on by itself.

use super::input;
use super::state::state;
use crate::abi;
use crate::device::device;
use crate::layout as at;
use core::ffi::{c_int, c_short, c_ulong};
use core::sync::atomic::Ordering;

/// `struct pollfd`.
#[repr(C)]
struct Poll {
    fd: c_int,
    events: c_short,
    found: c_short,
}

unsafe extern "C" {
    fn poll(fds: *mut Poll, count: c_ulong, milliseconds: c_int) -> c_int;
    fn exit(status: c_int) -> !;
}

/// Most milliseconds that the loop sleeps.
const SLEEP: i64 = 100;

/// Returns the time of the monotonic clock in nanoseconds.
pub fn nanoseconds() -> i64 {
    let mut time = abi::Timespec { seconds: 0, nanoseconds: 0 };
    // SAFETY: the time is valid for writing; this clock is always there.
    unsafe { abi::clock_gettime(abi::CLOCK_MONOTONIC, &mut time) };
    time.seconds * 1_000_000_000 + time.nanoseconds
}

/// Runs the program's callbacks until it ends, or leaves the loop.
#[unsafe(no_mangle)]
pub extern "C" fn glutMainLoop() {
    let here = state();
    begin();
    while !here.is_left.get() {
        turn(SLEEP);
    }
    // freeglut's default: the program ends with its window.
    // SAFETY: the C library's own end of a program.
    unsafe { exit(0) }
}

/// Runs the callbacks that are due now.
#[unsafe(no_mangle)]
pub extern "C" fn glutMainLoopEvent() {
    begin();
    turn(0);
}

/// Calls those callbacks that come with the window, once.
fn begin() {
    let here = state();
    if here.inputs[0].get() >= 0 || !here.is_created.get() {
        return;
    }
    input::open();
    let (width, height) = here.size.get();
    if let Some(reshape) = here.callbacks.reshape.get() {
        reshape(width as c_int, height as c_int);
    }
    if let Some(visibility) = here.callbacks.visibility.get() {
        // GLUT_VISIBLE
        visibility(1);
    }
}

/// One turn of the loop, which sleeps for so many milliseconds at most if there is nothing to do.
fn turn(sleep: i64) {
    let here = state();
    note_drawing(true);
    input::pass_on();
    for timer in &here.timers {
        if let Some(due) = timer.get().filter(|due| due.due <= nanoseconds()) {
            timer.set(None);
            (due.function)(due.value);
        }
    }
    let is_shown = here.is_redisplay_wanted.replace(false);
    if let Some(display) = here.callbacks.display.get().filter(|_| is_shown) {
        display();
    }
    let idle = here.callbacks.idle.get();
    if let Some(idle) = idle {
        idle();
    }
    let is_paused = note_drawing(false);
    if is_paused || (here.is_redisplay_wanted.get() && is_shown) {
        // The picture is not shown more often than the frame.
        if let Some(device) = device() {
            device.wait_for_vsync();
        }
    } else if idle.is_none() && !here.is_redisplay_wanted.get() {
        rest(sleep);
    }
}

/// Says whether callbacks run, and returns whether `fbptr` waits for a whole picture.
fn note_drawing(is_drawing: bool) -> bool {
    device().is_some_and(|device| {
        device.word(at::IS_DRAWING_AT).store(is_drawing.into(), Ordering::Release);
        device.word(at::IS_PAUSE_WANTED_AT).load(Ordering::Acquire) != 0
    })
}

/// Sleeps until there is input or a timer is due.
fn rest(sleep: i64) {
    let next = state().timers.iter().filter_map(|timer| timer.get()).map(|timer| timer.due).min();
    let until_next = next.map_or(sleep, |due| (due - nanoseconds() + 999_999).max(0) / 1_000_000);
    let mut fds = [0, 1].map(|i| Poll { fd: state().inputs[i].get(), events: 1, found: 0 });
    // SAFETY: the structures are valid for the call; descriptors below 0 are ignored.
    unsafe { poll(fds.as_mut_ptr(), 2, until_next.min(sleep) as c_int) };
}

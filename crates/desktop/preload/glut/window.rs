//! GLUT's window: its size, which becomes the frame of the run, and its callbacks.

use super::allocations::note_window;
use super::state::{Timer, state};
use crate::device::device;
use crate::layout as at;
use core::ffi::{c_char, c_int, c_uint, c_void};
use core::sync::atomic::Ordering;

/// Largest side of a window.
const SIDE: c_int = 4096;

/// Begins GLUT.
#[unsafe(no_mangle)]
pub extern "C" fn glutInit(_count: *mut c_int, _words: *mut *mut c_char) {
    if state().started.get() == 0 {
        state().started.set(super::main_loop::nanoseconds());
    }
}

/// Sets the size of the window that is made next.
#[unsafe(no_mangle)]
pub extern "C" fn glutInitWindowSize(width: c_int, height: c_int) {
    if !state().is_created.get() && width > 0 && height > 0 {
        let side = |n: c_int| n.min(SIDE) as u32;
        state().size.set((side(width), side(height)));
        note_window(side(width), side(height));
    }
}

/// Makes the window: tells `fbptr` its size, and waits until its frame is there.
#[unsafe(no_mangle)]
pub extern "C" fn glutCreateWindow(_title: *const c_char) -> c_int {
    let here = state();
    if here.is_created.replace(true) {
        super::ignored::tell(b"glutCreateWindow for a second window");
        return 1;
    }
    glutInit(core::ptr::null_mut(), core::ptr::null_mut());
    here.is_redisplay_wanted.set(true);
    let Some(device) = device() else { return 1 };
    let (width, height) = here.size.get();
    device.word(at::WINDOW_AT + 4).store(height, Ordering::Relaxed);
    device.word(at::WINDOW_AT).store(width, Ordering::Release);
    // A vertical blank comes when there is a frame; without `fbptr` none comes.
    while device.word(at::VSYNC_AT).load(Ordering::Acquire) == 0 && device.wait_for_vsync() {}
    note_window(width, height);
    1
}

/// Returns the number of the window: there is one.
#[unsafe(no_mangle)]
pub extern "C" fn glutGetWindow() -> c_int {
    state().is_created.get().into()
}

/// Ends the main loop with its window.
#[unsafe(no_mangle)]
pub extern "C" fn glutDestroyWindow(_: c_int) {
    state().is_left.set(true);
}

/// Ends the main loop.
#[unsafe(no_mangle)]
pub extern "C" fn glutLeaveMainLoop() {
    state().is_left.set(true);
}

/// Ends GLUT.
#[unsafe(no_mangle)]
pub extern "C" fn glutExit() {
    state().is_left.set(true);
}

/// Asks for the display callback.
#[unsafe(no_mangle)]
pub extern "C" fn glutPostRedisplay() {
    state().is_redisplay_wanted.set(true);
}

/// Asks for the display callback.
#[unsafe(no_mangle)]
pub extern "C" fn glutPostWindowRedisplay(_: c_int) {
    state().is_redisplay_wanted.set(true);
}

/// Shows what was drawn; it is there already.
#[unsafe(no_mangle)]
pub extern "C" fn glutSwapBuffers() {
    super::screen::clear_if_due();
}

/// Calls a function after so many milliseconds.
#[unsafe(no_mangle)]
pub extern "C" fn glutTimerFunc(milliseconds: c_uint, function: Option<extern "C" fn(c_int)>, value: c_int) {
    let Some(function) = function else { return };
    let due = super::main_loop::nanoseconds() + i64::from(milliseconds) * 1_000_000;
    match state().timers.iter().find(|timer| timer.get().is_none()) {
        Some(free) => free.set(Some(Timer { due, function, value })),
        None => super::ignored::tell(b"glutTimerFunc for more than 64 timers"),
    }
}

/// Returns a number about the window or the time; 0 for those that mean nothing here.
#[unsafe(no_mangle)]
pub extern "C" fn glutGet(what: c_uint) -> c_int {
    let (width, height) = state().size.get();
    match what {
        // GLUT_WINDOW_WIDTH, _HEIGHT, GLUT_WINDOW_DOUBLEBUFFER, _RGBA
        102 => width as c_int,
        103 => height as c_int,
        115 | 116 => 1,
        // GLUT_SCREEN_WIDTH, _HEIGHT
        200 => 1920,
        201 => 1080,
        // GLUT_INIT_WINDOW_WIDTH, _HEIGHT
        502 => width as c_int,
        503 => height as c_int,
        // GLUT_ELAPSED_TIME
        700 => {
            glutInit(core::ptr::null_mut(), core::ptr::null_mut());
            ((super::main_loop::nanoseconds() - state().started.get()) / 1_000_000) as c_int
        }
        _ => 0,
    }
}

/// Returns the keys that are held: shift 1, control 2, alt 4.
#[unsafe(no_mangle)]
pub extern "C" fn glutGetModifiers() -> c_int {
    state().modifiers.get()
}

/// Returns no function.
#[unsafe(no_mangle)]
pub extern "C" fn glutGetProcAddress(_: *const c_char) -> *mut c_void {
    core::ptr::null_mut()
}

/// Defines functions that set a callback.
macro_rules! callbacks {
    ($($name:ident: $field:ident($kind:ty);)*) => {$(
        /// Sets a callback.
        #[unsafe(no_mangle)]
        pub extern "C" fn $name(function: Option<$kind>) {
            state().callbacks.$field.set(function);
        }
    )*};
}

callbacks! {
    glutDisplayFunc: display(extern "C" fn());
    glutIdleFunc: idle(extern "C" fn());
    glutReshapeFunc: reshape(extern "C" fn(c_int, c_int));
    glutVisibilityFunc: visibility(extern "C" fn(c_int));
    glutKeyboardFunc: keyboard(extern "C" fn(u8, c_int, c_int));
    glutKeyboardUpFunc: keyboard_up(extern "C" fn(u8, c_int, c_int));
    glutSpecialFunc: special(extern "C" fn(c_int, c_int, c_int));
    glutSpecialUpFunc: special_up(extern "C" fn(c_int, c_int, c_int));
    glutMouseFunc: mouse(extern "C" fn(c_int, c_int, c_int, c_int));
    glutMouseWheelFunc: wheel(extern "C" fn(c_int, c_int, c_int, c_int));
    glutMotionFunc: motion(extern "C" fn(c_int, c_int));
    glutPassiveMotionFunc: passive_motion(extern "C" fn(c_int, c_int));
}

//! OpenGL's other calls that change what is shown, and those that ask.

use super::state::state;
use super::{matrix, screen};
use core::ffi::{c_char, c_int, c_uint};

const TEXTURE_2D: c_uint = 0x0de1;
const COLOR_BUFFER: c_uint = 0x4000;
const VIEWPORT: c_uint = 0x0ba2;
const MAX_TEXTURE_SIZE: c_uint = 0x0d33;

/// Switches a state on.
#[unsafe(no_mangle)]
pub extern "C" fn glEnable(what: c_uint) {
    if what == TEXTURE_2D {
        state().is_texturing.set(true);
    }
}

/// Switches a state off.
#[unsafe(no_mangle)]
pub extern "C" fn glDisable(what: c_uint) {
    if what == TEXTURE_2D {
        state().is_texturing.set(false);
    }
}

/// Returns whether a state is on.
#[unsafe(no_mangle)]
pub extern "C" fn glIsEnabled(what: c_uint) -> u8 {
    (what == TEXTURE_2D && state().is_texturing.get()).into()
}

/// Clears the picture before what is drawn next, unless that covers it.
#[unsafe(no_mangle)]
pub extern "C" fn glClear(mask: c_uint) {
    if mask & COLOR_BUFFER != 0 {
        state().is_clear_due.set(true);
    }
}

/// Sets the colour of `glClear`.
#[unsafe(no_mangle)]
pub extern "C" fn glClearColor(red: f32, green: f32, blue: f32, alpha: f32) {
    let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    state().clear_color.set([red, green, blue, alpha].map(byte));
}

/// Shows what was drawn; it is there already.
#[unsafe(no_mangle)]
pub extern "C" fn glFlush() {
    screen::clear_if_due();
}

/// Shows what was drawn; it is there already.
#[unsafe(no_mangle)]
pub extern "C" fn glFinish() {
    screen::clear_if_due();
}

/// Says how pixels lie in memory.
#[unsafe(no_mangle)]
pub extern "C" fn glPixelStorei(what: c_uint, value: c_int) {
    let (unpack, value) = (&state().unpack, usize::try_from(value).unwrap_or(0));
    match what {
        // GL_UNPACK_ROW_LENGTH, _SKIP_ROWS, _SKIP_PIXELS, _ALIGNMENT
        0x0cf2 => unpack.row_length.set(value),
        0x0cf3 => unpack.skip_rows.set(value),
        0x0cf4 => unpack.skip_pixels.set(value),
        0x0cf5 if matches!(value, 1 | 2 | 4 | 8) => unpack.alignment.set(value),
        _ => {}
    }
}

/// Sets the size of a pixel of `glDrawPixels` in the window.
#[unsafe(no_mangle)]
pub extern "C" fn glPixelZoom(x: f32, y: f32) {
    state().zoom.set((x, y));
}

/// Sets the place of `glDrawPixels` in pixels of the window.
#[unsafe(no_mangle)]
pub extern "C" fn glWindowPos2i(x: c_int, y: c_int) {
    state().raster.set((x as f32, y as f32));
}

/// Sets the place of `glDrawPixels`.
#[unsafe(no_mangle)]
pub extern "C" fn glRasterPos3f(x: f32, y: f32, z: f32) {
    let [x, y, _, w] = matrix::transformed([x, y, z]);
    let (width, height) = state().size.get();
    let at = |value: f32, len: u32| (value / w + 1.0) * 0.5 * len as f32;
    state().raster.set((at(x, width), at(y, height)));
}

/// Sets the place of `glDrawPixels`.
#[unsafe(no_mangle)]
pub extern "C" fn glRasterPos2f(x: f32, y: f32) {
    glRasterPos3f(x, y, 0.0);
}

/// Sets the place of `glDrawPixels`.
#[unsafe(no_mangle)]
pub extern "C" fn glRasterPos2d(x: f64, y: f64) {
    glRasterPos2f(x as f32, y as f32);
}

/// Sets the place of `glDrawPixels`.
#[unsafe(no_mangle)]
pub extern "C" fn glRasterPos2i(x: c_int, y: c_int) {
    glRasterPos2f(x as f32, y as f32);
}

/// Answers a question with numbers; those of the window and of textures are true, others 0.
///
/// # Safety
/// As for OpenGL's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn glGetIntegerv(what: c_uint, values: *mut c_int) {
    let (width, height) = state().size.get();
    // SAFETY: there is room for the values of the question, says the caller.
    unsafe {
        match what {
            VIEWPORT => *values.cast::<[c_int; 4]>() = [0, 0, width as c_int, height as c_int],
            MAX_TEXTURE_SIZE => *values = 8192,
            _ => *values = 0,
        }
    }
}

/// Returns a text about OpenGL: who makes it, its version, no extensions.
#[unsafe(no_mangle)]
pub extern "C" fn glGetString(what: c_uint) -> *const c_char {
    match what {
        // GL_VENDOR, GL_RENDERER, GL_VERSION
        0x1f00 | 0x1f01 => c"fbptr",
        0x1f02 => c"1.1 fbptr",
        _ => c"",
    }
    .as_ptr()
}

/// Returns the text of an error; there are none.
#[unsafe(no_mangle)]
pub extern "C" fn gluErrorString(_: c_uint) -> *const c_char {
    c"no error".as_ptr()
}

/// Reads the picture.
///
/// # Safety
/// As for OpenGL's function: `pixels` has room for the rectangle, in rows of whole words.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn glReadPixels(
    x: c_int,
    y: c_int,
    width: c_int,
    height: c_int,
    format: c_uint,
    component: c_uint,
    pixels: *mut u8,
) {
    // GL_RGB, GL_RGBA, GL_BGR, GL_BGRA in bytes.
    let (count, order) = match (format, component) {
        (0x1907, 0x1401) => (3, [0, 1, 2, 3]),
        (0x1908, 0x1401) => (4, [0, 1, 2, 3]),
        (0x80e0, 0x1401) => (3, [2, 1, 0, 3]),
        (0x80e1, 0x1401) => (4, [2, 1, 0, 3]),
        _ => return super::ignored::tell(b"glReadPixels of this format"),
    };
    let canvas = screen::canvas();
    let (columns, rows) = state().size.get();
    if canvas.is_null() || pixels.is_null() {
        return;
    }
    let line = (width.max(0) as usize * count).next_multiple_of(4);
    for row in 0..height.max(0) {
        for column in 0..width.max(0) {
            let (at_x, at_y) = (x.saturating_add(column), y.saturating_add(row));
            if !(0..columns as c_int).contains(&at_x) || !(0..rows as c_int).contains(&at_y) {
                continue;
            }
            // SAFETY: the pixel is inside, and there is room for it, says the caller.
            unsafe {
                let from = canvas.add((rows as usize - 1 - at_y as usize) * columns as usize + at_x as usize);
                let color = from.read_volatile();
                let to = pixels.add(row as usize * line + column as usize * count);
                order[..count].iter().enumerate().for_each(|(i, place)| *to.add(i) = color[*place]);
            }
        }
    }
}

//! The matrices that place a quad: columns of four, as OpenGL has them.

use super::state::{DEPTH, state};
use core::ffi::c_uint;

/// A matrix, column by column.
pub type Matrix = [f32; 16];

/// The matrix that changes nothing.
pub const IDENTITY: Matrix = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];

const MODELVIEW: c_uint = 0x1700;
const PROJECTION: c_uint = 0x1701;

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    core::array::from_fn(|at| (0..4).map(|k| a[k * 4 + at % 4] * b[at / 4 * 4 + k]).sum())
}

/// Returns a vertex in clip coordinates.
pub fn transformed([x, y, z]: [f32; 3]) -> [f32; 4] {
    let at = |which: usize, [x, y, z, w]: [f32; 4]| {
        let m = state().matrices[which][state().depths[which].get()].get();
        core::array::from_fn(|row| m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row] * w)
    };
    at(1, at(0, [x, y, z, 1.0]))
}

fn change(by: impl FnOnce(&Matrix) -> Matrix) {
    let which = state().matrix_mode.get();
    if let Some(depth) = state().depths.get(which) {
        let place = &state().matrices[which][depth.get()];
        place.set(by(&place.get()));
    }
}

fn multiply(matrix: &Matrix) {
    change(|current| product(current, matrix));
}

/// Chooses the matrix that the other calls change.
#[unsafe(no_mangle)]
pub extern "C" fn glMatrixMode(mode: c_uint) {
    state().matrix_mode.set(match mode {
        MODELVIEW => 0,
        PROJECTION => 1,
        _ => 2,
    });
}

/// Sets the matrix that changes nothing.
#[unsafe(no_mangle)]
pub extern "C" fn glLoadIdentity() {
    change(|_| IDENTITY);
}

/// Keeps the matrix for `glPopMatrix`.
#[unsafe(no_mangle)]
pub extern "C" fn glPushMatrix() {
    let which = state().matrix_mode.get();
    if let Some(depth) = state().depths.get(which).filter(|depth| depth.get() + 1 < DEPTH) {
        let stack = &state().matrices[which];
        stack[depth.get() + 1].set(stack[depth.get()].get());
        depth.set(depth.get() + 1);
    }
}

/// Returns to the matrix of the last `glPushMatrix`.
#[unsafe(no_mangle)]
pub extern "C" fn glPopMatrix() {
    if let Some(depth) = state().depths.get(state().matrix_mode.get()) {
        depth.set(depth.get().saturating_sub(1));
    }
}

/// Maps a box to the window.
#[unsafe(no_mangle)]
pub extern "C" fn glOrtho(left: f64, right: f64, bottom: f64, top: f64, near: f64, far: f64) {
    let mut m = IDENTITY;
    for (axis, (low, high, sign)) in
        [(left, right, 1.0), (bottom, top, 1.0), (near, far, -1.0)].into_iter().enumerate()
    {
        if low == high {
            return;
        }
        m[axis * 5] = (sign * 2.0 / (high - low)) as f32;
        m[12 + axis] = (-(high + low) / (high - low)) as f32;
    }
    multiply(&m);
}

/// Maps a rectangle to the window.
#[unsafe(no_mangle)]
pub extern "C" fn gluOrtho2D(left: f64, right: f64, bottom: f64, top: f64) {
    glOrtho(left, right, bottom, top, -1.0, 1.0);
}

/// Moves what is drawn.
#[unsafe(no_mangle)]
pub extern "C" fn glTranslatef(x: f32, y: f32, z: f32) {
    multiply(&[1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, y, z, 1.]);
}

/// Moves what is drawn.
#[unsafe(no_mangle)]
pub extern "C" fn glTranslated(x: f64, y: f64, z: f64) {
    glTranslatef(x as f32, y as f32, z as f32);
}

/// Scales what is drawn.
#[unsafe(no_mangle)]
pub extern "C" fn glScalef(x: f32, y: f32, z: f32) {
    multiply(&[x, 0., 0., 0., 0., y, 0., 0., 0., 0., z, 0., 0., 0., 0., 1.]);
}

/// Scales what is drawn.
#[unsafe(no_mangle)]
pub extern "C" fn glScaled(x: f64, y: f64, z: f64) {
    glScalef(x as f32, y as f32, z as f32);
}

/// Sets a matrix.
///
/// # Safety
/// `values` points to 16 values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn glLoadMatrixf(values: *const Matrix) {
    // SAFETY: the caller's promise.
    let matrix = unsafe { *values };
    change(|_| matrix);
}

/// Multiplies the matrix by another one.
///
/// # Safety
/// `values` points to 16 values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn glMultMatrixf(values: *const Matrix) {
    // SAFETY: the caller's promise.
    multiply(unsafe { &*values });
}

//! `glBegin` to `glEnd`: the rectangle that a texture is drawn on.
//!
//! In: vertices with their texture coordinates. Out: for a rectangle whose sides are those of the
//! window's, the place of the texture ([`blit::draw_texture`]); everything else is told.

use super::state::{VERTICES, state};
use super::{blit, ignored, matrix};
use core::ffi::{c_int, c_uint};

/// A vertex: its place in the window, in pixels from the left and from the bottom, and its texture
/// coordinates.
#[derive(Clone, Copy)]
pub struct Vertex {
    place: (f32, f32),
    coordinates: (f32, f32),
}

impl Vertex {
    pub const NONE: Vertex = Vertex { place: (0.0, 0.0), coordinates: (0.0, 0.0) };
}

const QUADS: c_uint = 7;

/// Begins a figure.
#[unsafe(no_mangle)]
pub extern "C" fn glBegin(primitive: c_uint) {
    state().primitive.set(primitive);
    state().vertex_count.set(0);
}

/// Ends a figure, and draws the texture if it is a rectangle with one.
#[unsafe(no_mangle)]
pub extern "C" fn glEnd() {
    let here = state();
    let count = here.vertex_count.replace(0);
    // GL_TRIANGLES and the figures behind it are areas.
    if !here.is_texturing.get() || here.primitive.get() < 4 {
        return ignored::tell(b"glBegin");
    }
    let step = if here.primitive.get() == QUADS { 4 } else { VERTICES };
    for corners in here.vertices[..count.min(VERTICES)].chunks(step) {
        if !draw(corners) {
            ignored::tell(b"glBegin of another figure than an upright rectangle");
        }
    }
}

/// Draws the texture on a rectangle; returns false if the vertices are none.
fn draw(corners: &[core::cell::Cell<Vertex>]) -> bool {
    let all = || corners.iter().map(core::cell::Cell::get);
    let far = (f32::INFINITY, f32::NEG_INFINITY);
    let range = |of: fn(Vertex) -> f32| {
        all().map(of).fold(far, |(low, high), value| (low.min(value), high.max(value)))
    };
    let (left, right) = range(|v| v.place.0);
    let (bottom, top) = range(|v| v.place.1);
    if corners.len() < 4 || !(right - left > 0.0 && top - bottom > 0.0) {
        return false;
    }
    let near = |a: f32, b: f32| (a - b).abs() < 0.01;
    let corner = |x: f32, y: f32| all().find(|v| near(v.place.0, x) && near(v.place.1, y));
    let four = [corner(left, bottom), corner(right, bottom), corner(left, top), corner(right, top)];
    let [Some(a), Some(b), Some(c), Some(d)] = four else { return false };
    let is_corner = |v: Vertex| {
        (near(v.place.0, left) || near(v.place.0, right)) && (near(v.place.1, bottom) || near(v.place.1, top))
    };
    // Columns of the texture stand upright.
    let same = |one: f32, other: f32| (one - other).abs() < 1e-4;
    let is_upright = same(a.coordinates.0, c.coordinates.0)
        && same(b.coordinates.0, d.coordinates.0)
        && same(a.coordinates.1, b.coordinates.1)
        && same(c.coordinates.1, d.coordinates.1);
    if !is_upright || !all().all(is_corner) {
        return false;
    }
    blit::draw_texture([left, right, bottom, top], a.coordinates, d.coordinates);
    true
}

/// Sets the texture coordinates of the vertices that follow.
#[unsafe(no_mangle)]
pub extern "C" fn glTexCoord2f(s: f32, t: f32) {
    state().coordinates.set((s, t));
}

/// Adds a vertex.
#[unsafe(no_mangle)]
pub extern "C" fn glVertex3f(x: f32, y: f32, z: f32) {
    let here = state();
    let [x, y, _, w] = matrix::transformed([x, y, z]);
    let (width, height) = here.size.get();
    let at = |value: f32, len: u32| (value / w + 1.0) * 0.5 * len as f32;
    let place = (at(x, width), at(y, height));
    let count = here.vertex_count.get();
    if let Some(vertex) = here.vertices.get(count) {
        vertex.set(Vertex { place, coordinates: here.coordinates.get() });
    }
    here.vertex_count.set(count + 1);
}

/// Defines the other names of a function with numbers of other types, or in memory.
macro_rules! kinds {
    ($($name:ident($($argument:ident),*: $kind:ty) => $to:ident($($value:expr),*);)*) => {$(
        /// Does the same with numbers of another type.
        #[unsafe(no_mangle)]
        pub extern "C" fn $name($($argument: $kind),*) {
            $to($($value as f32),*);
        }
    )*};
}

kinds! {
    glTexCoord2d(s, t: f64) => glTexCoord2f(s, t);
    glTexCoord2i(s, t: c_int) => glTexCoord2f(s, t);
    glTexCoord3f(s, t, _r: f32) => glTexCoord2f(s, t);
    glVertex2f(x, y: f32) => glVertex3f(x, y, 0.0);
    glVertex2d(x, y: f64) => glVertex3f(x, y, 0.0);
    glVertex2i(x, y: c_int) => glVertex3f(x, y, 0.0);
    glVertex2s(x, y: i16) => glVertex3f(x, y, 0.0);
    glVertex3d(x, y, z: f64) => glVertex3f(x, y, z);
    glVertex3i(x, y, z: c_int) => glVertex3f(x, y, z);
}

/// Defines the names of a function whose numbers are in memory.
macro_rules! vectors {
    ($($name:ident($kind:ty) => $to:ident($($at:literal),*);)*) => {$(
        /// Does the same with numbers in memory.
        ///
        /// # Safety
        /// As for OpenGL's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(values: *const $kind) {
            // SAFETY: there are so many values, says the caller.
            unsafe { $to($((*values.add($at)) as f32),*) };
        }
    )*};
}

vectors! {
    glTexCoord2fv(f32) => glTexCoord2f(0, 1);
    glTexCoord2dv(f64) => glTexCoord2f(0, 1);
    glVertex2fv(f32) => glVertex2f(0, 1);
    glVertex2dv(f64) => glVertex2f(0, 1);
    glVertex2iv(c_int) => glVertex2f(0, 1);
    glVertex3fv(f32) => glVertex3f(0, 1, 2);
    glVertex3dv(f64) => glVertex3f(0, 1, 2);
}

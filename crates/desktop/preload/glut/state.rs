//! The state of GLUT and OpenGL, in cells: callbacks and calls of the same thread take turns, so no
//! reference into it outlives a call.

use super::immediate::Vertex;
use super::matrix::{IDENTITY, Matrix};
use super::textures::Texture;
use core::cell::Cell;
use core::ffi::{c_int, c_uint, c_void};

/// Textures that a program may have.
pub const TEXTURES: usize = 64;
/// Vertices between `glBegin` and `glEnd` that are kept.
pub const VERTICES: usize = 64;
/// Timers that wait.
pub const TIMERS: usize = 64;
/// Matrices of a stack.
pub const DEPTH: usize = 8;

/// A callback of `glutTimerFunc`.
#[derive(Clone, Copy)]
pub struct Timer {
    pub due: i64,
    pub function: extern "C" fn(c_int),
    pub value: c_int,
}

type Xy = extern "C" fn(c_int, c_int);
type KeyXy = extern "C" fn(u8, c_int, c_int);
type CodeXy = extern "C" fn(c_int, c_int, c_int);
type ButtonXy = extern "C" fn(c_int, c_int, c_int, c_int);

/// The callbacks of the window.
pub struct Callbacks {
    pub display: Cell<Option<extern "C" fn()>>,
    pub idle: Cell<Option<extern "C" fn()>>,
    pub reshape: Cell<Option<Xy>>,
    pub visibility: Cell<Option<extern "C" fn(c_int)>>,
    pub keyboard: Cell<Option<KeyXy>>,
    pub keyboard_up: Cell<Option<KeyXy>>,
    pub special: Cell<Option<CodeXy>>,
    pub special_up: Cell<Option<CodeXy>>,
    pub mouse: Cell<Option<ButtonXy>>,
    pub wheel: Cell<Option<ButtonXy>>,
    pub motion: Cell<Option<Xy>>,
    pub passive_motion: Cell<Option<Xy>>,
}

/// All of the state.
pub struct State {
    pub callbacks: Callbacks,
    pub timers: [Cell<Option<Timer>>; TIMERS],
    /// Time of `glutInit` in nanoseconds; 0 before it.
    pub started: Cell<i64>,
    /// Size that `glutInitWindowSize` asked for, or that the window has.
    pub size: Cell<(u32, u32)>,
    pub is_created: Cell<bool>,
    pub is_redisplay_wanted: Cell<bool>,
    pub is_left: Cell<bool>,
    /// Descriptors of the keyboard and the pointer; -1 while they are not open.
    pub inputs: [Cell<c_int>; 2],
    pub pointer: Cell<(c_int, c_int)>,
    /// Buttons that are held, a bit each; and shift, control, alt as `glutGetModifiers` has them.
    pub buttons: Cell<u32>,
    pub modifiers: Cell<c_int>,
    pub is_caps: Cell<bool>,

    pub textures: [Texture; TEXTURES],
    pub next_texture: Cell<c_uint>,
    pub bound: Cell<c_uint>,
    pub is_texturing: Cell<bool>,
    pub unpack: Unpack,
    pub raster: Cell<(f32, f32)>,
    pub zoom: Cell<(f32, f32)>,
    pub clear_color: Cell<[u8; 4]>,
    /// `glClear` was called, and nothing has been drawn since.
    pub is_clear_due: Cell<bool>,

    pub matrices: [[Cell<Matrix>; DEPTH]; 2],
    pub depths: [Cell<usize>; 2],
    /// Projection (1) or model and view (0); other matrices count as neither (2).
    pub matrix_mode: Cell<usize>,

    pub primitive: Cell<c_uint>,
    pub coordinates: Cell<(f32, f32)>,
    pub vertices: [Cell<Vertex>; VERTICES],
    pub vertex_count: Cell<usize>,
    /// The map of the device's memory that copies are written to; null before the first one.
    pub canvas: Cell<*mut c_void>,
    /// An allocation of the program is no longer the device's memory, whatever it shows.
    pub is_composed: Cell<bool>,
}

/// `glPixelStorei` for pixels that come in.
pub struct Unpack {
    pub alignment: Cell<usize>,
    pub row_length: Cell<usize>,
    pub skip_rows: Cell<usize>,
    pub skip_pixels: Cell<usize>,
}

struct Global(State);

// SAFETY: GLUT and OpenGL are called by one thread, which their own documents require.
unsafe impl Sync for Global {}

static STATE: Global = Global(State {
    callbacks: Callbacks {
        display: Cell::new(None),
        idle: Cell::new(None),
        reshape: Cell::new(None),
        visibility: Cell::new(None),
        keyboard: Cell::new(None),
        keyboard_up: Cell::new(None),
        special: Cell::new(None),
        special_up: Cell::new(None),
        mouse: Cell::new(None),
        wheel: Cell::new(None),
        motion: Cell::new(None),
        passive_motion: Cell::new(None),
    },
    timers: [const { Cell::new(None) }; TIMERS],
    started: Cell::new(0),
    // The size of a window that nobody asked for one.
    size: Cell::new((300, 300)),
    is_created: Cell::new(false),
    is_redisplay_wanted: Cell::new(false),
    is_left: Cell::new(false),
    inputs: [const { Cell::new(-1) }; 2],
    pointer: Cell::new((0, 0)),
    buttons: Cell::new(0),
    modifiers: Cell::new(0),
    is_caps: Cell::new(false),
    textures: [const { Texture::NONE }; TEXTURES],
    next_texture: Cell::new(1),
    bound: Cell::new(0),
    is_texturing: Cell::new(false),
    unpack: Unpack {
        alignment: Cell::new(4),
        row_length: Cell::new(0),
        skip_rows: Cell::new(0),
        skip_pixels: Cell::new(0),
    },
    raster: Cell::new((0.0, 0.0)),
    zoom: Cell::new((1.0, 1.0)),
    clear_color: Cell::new([0, 0, 0, 0]),
    is_clear_due: Cell::new(false),
    matrices: [const { [const { Cell::new(IDENTITY) }; DEPTH] }; 2],
    depths: [const { Cell::new(0) }; 2],
    matrix_mode: Cell::new(0),
    primitive: Cell::new(0),
    coordinates: Cell::new((0.0, 0.0)),
    vertices: [const { Cell::new(Vertex::NONE) }; VERTICES],
    vertex_count: Cell::new(0),
    canvas: Cell::new(core::ptr::null_mut()),
    is_composed: Cell::new(false),
});

/// Returns the state, which belongs to the thread that calls GLUT.
pub fn state() -> &'static State {
    &STATE.0
}

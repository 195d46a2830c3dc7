//! A window of the interpreter's process: a function draws each frame, 60 a second.
//!
//! In: a framebuffer, and a function that is called with the input since the last frame. Out: the
//! framebuffer's memory in the window. The interpreter's lock is held while the function runs, and
//! released while the window waits for the next frame. The arguments `--headless`, `--frames N` and
//! `--snap FILE` of the process are those of every program that calls `fbptr::run`.

use crate::framebuffer::Framebuffer;
use fbptr::FrameInput;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

/// Keyboard, mouse and time of one frame.
#[pyclass(module = "fbptr", name = "Input")]
pub struct Input(FrameInput);

#[pymethods]
impl Input {
    /// Seconds since the last frame; 0 in the first one.
    #[getter]
    fn delta(&self) -> f64 {
        self.0.delta_s
    }

    /// Number of the frame, from 0.
    #[getter]
    fn frame(&self) -> u64 {
        self.0.frame
    }

    /// Column and row under the pointer, which may be off the frame.
    #[getter]
    fn mouse(&self) -> (i32, i32) {
        self.0.mouse.into()
    }

    /// Held buttons of the mouse: left, middle, right.
    #[getter]
    fn buttons(&self) -> (bool, bool, bool) {
        self.0.buttons.into()
    }

    /// Steps of the wheel since the last frame: to the right, and upwards.
    #[getter]
    fn wheel(&self) -> (i32, i32) {
        self.0.wheel.into()
    }

    /// Characters typed since the last frame.
    #[getter]
    fn text(&self) -> &str {
        &self.0.text
    }

    /// Ends the program after this frame when it is set.
    #[getter]
    fn close(&self) -> bool {
        self.0.close
    }

    #[setter]
    fn set_close(&mut self, close: bool) {
        self.0.close = close;
    }

    /// Shows the frame as a cathode ray tube does; K and F8 change it.
    #[getter]
    fn crt(&self) -> bool {
        self.0.crt
    }

    #[setter]
    fn set_crt(&mut self, crt: bool) {
        self.0.crt = crt;
    }

    /// Returns whether a key is held: "a", "7", "left", "space", "escape", "f5".
    fn is_down(&self, key: &str) -> bool {
        self.0.is_down(key)
    }

    /// Returns whether a key went down since the last frame; holding it counts once.
    fn was_pressed(&self, key: &str) -> bool {
        self.0.was_pressed(key)
    }
}

/// Calls the function for one frame, and takes over what it has set in the input.
fn call(py: Python<'_>, draw: &Py<PyAny>, input: &mut FrameInput) -> PyResult<()> {
    py.check_signals()?;
    let given = Py::new(py, Input(input.clone()))?;
    draw.call1(py, (given.clone_ref(py),))?;
    let given = given.borrow(py);
    (input.close, input.crt) = (given.0.close, given.0.crt);
    Ok(())
}

/// Shows a framebuffer in a window until it is closed, and calls `draw(input)` before each frame.
#[pyfunction]
pub fn run(py: Python<'_>, fb: Py<Framebuffer>, draw: Py<PyAny>) -> PyResult<()> {
    let (width, height) = fb.get().look(py, |memory| (memory.width(), memory.height()))?;
    let mut failure = None;
    let shown = py.detach(|| {
        fbptr::run(width, height, |shown, input| {
            let drawn = Python::attach(|py| {
                call(py, &draw, input)?;
                fb.get().look(py, |memory| shown.memory_mut().bytes_mut().copy_from_slice(memory.bytes()))
            });
            if let Err(error) = drawn {
                input.close = true;
                failure = Some(error);
            }
        })
        .map_err(|e| e.to_string())
    });
    match (failure, shown) {
        (Some(error), _) => Err(error),
        (None, Err(message)) => Err(PyOSError::new_err(message)),
        (None, Ok(())) => Ok(()),
    }
}

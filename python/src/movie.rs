//! Movies: frames into a GIF, APNG or y4m file.
//!
//! In: framebuffers. Out: a file that is whole after every frame.

use crate::errors::poisoned;
use crate::framebuffer::Framebuffer;
use crate::paths::FilePath;
use fbptr::save;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use std::sync::Mutex;

/// A movie that is being written.
#[pyclass(frozen, module = "fbptr._native")]
pub struct Movie {
    movie: Mutex<Option<save::Movie>>,
    size: [u32; 2],
}

#[pymethods]
impl Movie {
    #[new]
    fn new(path: FilePath, width: u32, height: u32, rate: f64) -> PyResult<Self> {
        let movie = save::Movie::create(&path, width, height, rate)
            .map_err(|e| PyValueError::new_err(e.to_string()))?;
        Ok(Movie { movie: Mutex::new(Some(movie)), size: [width, height] })
    }

    /// Adds a frame. Returns the CRC-32 of its bytes.
    fn push(&self, py: Python<'_>, frame: &Framebuffer) -> PyResult<u32> {
        let (pushed, crc) = frame.look(py, |memory| {
            if [memory.width(), memory.height()] != self.size {
                return (Err(None), 0);
            }
            let Ok(mut movie) = self.movie.lock() else { return (Err(None), 0) };
            let Some(movie) = movie.as_mut() else { return (Err(None), 0) };
            (movie.push(memory).map_err(|e| Some(e.to_string())), save::crc32(memory))
        })?;
        match pushed {
            Ok(()) => Ok(crc),
            Err(Some(message)) => Err(PyOSError::new_err(message)),
            Err(None) => Err(PyValueError::new_err(format!(
                "expected a frame of {}x{} for a movie that has not ended",
                self.size[0], self.size[1]
            ))),
        }
    }

    /// Ends the movie.
    fn finish(&self) -> PyResult<()> {
        drop(self.movie.lock().map_err(|_| poisoned())?.take());
        Ok(())
    }
}

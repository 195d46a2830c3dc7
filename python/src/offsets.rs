//! `fb[offset]`: bytes of the video memory by their offset, and slices of them.
//!
//! In: an index or a slice, as of a `bytearray`. Out: a byte, bytes, or written memory.

use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PySlice;

/// Bytes that an index stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// One byte.
    Byte(usize),
    /// `count` bytes from `start` on, each `step` after the last.
    Slice { start: isize, step: isize, count: usize },
}

/// Returns the bytes that an index of a memory of `size` bytes stands for.
pub fn place(at: &Bound<'_, PyAny>, size: usize) -> PyResult<Place> {
    if let Ok(slice) = at.cast::<PySlice>() {
        let indices = slice.indices(size as isize)?;
        return Ok(Place::Slice { start: indices.start, step: indices.step, count: indices.slicelength });
    }
    if !at.hasattr("__index__")? {
        let kind = at.get_type().name()?;
        return Err(PyTypeError::new_err(format!(
            "an offset is a whole number, (width * y + x) * 4 for pixel (x, y), or a slice, not {kind}"
        )));
    }
    let outside = || {
        let text = at.str().map(|text| text.to_string()).unwrap_or_default();
        PyIndexError::new_err(format!("byte {text} is outside the memory's 0..{size}"))
    };
    let index: isize = at.extract().map_err(|_| outside())?;
    let found = if index < 0 { index.checked_add(size as isize) } else { Some(index) };
    match found.and_then(|index| usize::try_from(index).ok()).filter(|index| *index < size) {
        Some(index) => Ok(Place::Byte(index)),
        None => Err(outside()),
    }
}

impl Place {
    /// Returns the offsets of the bytes.
    pub fn offsets(self) -> impl Iterator<Item = usize> {
        let (start, step, count) = match self {
            Place::Byte(at) => (at as isize, 1, 1),
            Place::Slice { start, step, count } => (start, step, count),
        };
        (0..count as isize).map(move |i| (start + i * step) as usize)
    }

    /// Returns the number of bytes.
    pub fn len(self) -> usize {
        match self {
            Place::Byte(_) => 1,
            Place::Slice { count, .. } => count,
        }
    }

    /// Returns the bytes to be written from a value.
    pub fn data(self, value: &Bound<'_, PyAny>) -> PyResult<Vec<u8>> {
        if let Place::Byte(_) = self {
            let byte: Option<u8> = value.extract().ok();
            let byte = byte.ok_or_else(|| {
                let text = value.repr().map(|text| text.to_string()).unwrap_or_default();
                PyValueError::new_err(format!("a byte is a whole number from 0 to 255, not {text}"))
            })?;
            return Ok(vec![byte]);
        }
        let data = crate::items::bytes(value).filter(|_| !crate::items::is_text(value)).ok_or_else(|| {
            PyTypeError::new_err("bytes, or numbers from 0 to 255, are written into a slice")
        })?;
        match data.len() == self.len() {
            true => Ok(data),
            false => Err(PyValueError::new_err(format!(
                "the slice has {} bytes, not {}: the memory does not change its size",
                self.len(),
                data.len()
            ))),
        }
    }
}

//! Views of the video memory: the buffer protocol, without a copy.
//!
//! In: a request for a buffer. Out: the frame's bytes as (height, width, 4) unsigned bytes, writable.
//!
//! Source: PEP 3118; `numpy.asarray` and `memoryview` ask for buffers.

use crate::access::Shared;
use pyo3::exceptions::PyBufferError;
use pyo3::ffi;
use pyo3::prelude::*;
use std::ffi::{c_char, c_int, c_void};
use std::ptr;

/// Shape and strides of a view, as long as it exists.
struct Layout {
    shape: [ffi::Py_ssize_t; 3],
    strides: [ffi::Py_ssize_t; 3],
}

/// One unsigned byte, in the notation of Python's `struct`.
const FORMAT: &[u8; 2] = b"B\0";

/// Fills `view` with the memory of the framebuffer, whose object is `owner`.
///
/// # Safety
/// `view` is null or points to a `Py_buffer` that may be written.
pub unsafe fn fill(
    owner: &Bound<'_, PyAny>,
    shared: &Shared,
    view: *mut ffi::Py_buffer,
    flags: c_int,
) -> PyResult<()> {
    if view.is_null() {
        return Err(PyBufferError::new_err("a view needs a place"));
    }
    let has = |flag: c_int| flags & flag == flag;
    if has(ffi::PyBUF_F_CONTIGUOUS) && !has(ffi::PyBUF_C_CONTIGUOUS) && !has(ffi::PyBUF_ANY_CONTIGUOUS) {
        return Err(PyBufferError::new_err("the memory is row by row, not column by column"));
    }
    let (address, width, height) = shared.add_view(owner.py(), |state| {
        let memory = state.engine.memory_mut();
        let [width, height] = [memory.width(), memory.height()].map(|side| side as ffi::Py_ssize_t);
        // Others have the address from now on, as they have that of memory from a C library.
        let address = memory.bytes_mut().as_mut_ptr();
        let _ = address.expose_provenance();
        (address, width, height)
    })?;
    let layout = Box::new(Layout { shape: [height, width, 4], strides: [width * 4, 4, 1] });
    let layout = Box::into_raw(layout);
    // SAFETY: the caller gives a place for a view. Its pointers stay valid until `release`: the frame
    // is neither freed nor moved as long as its object lives, of which the view holds a reference;
    // the layout is freed by `release` alone; the format is static.
    unsafe {
        (*view).buf = address.cast::<c_void>();
        (*view).len = width * height * 4;
        (*view).itemsize = 1;
        (*view).readonly = 0;
        (*view).ndim = if has(ffi::PyBUF_ND) { 3 } else { 1 };
        (*view).format = match has(ffi::PyBUF_FORMAT) {
            true => FORMAT.as_ptr().cast_mut().cast::<c_char>(),
            false => ptr::null_mut(),
        };
        (*view).shape = if has(ffi::PyBUF_ND) { (*layout).shape.as_mut_ptr() } else { ptr::null_mut() };
        (*view).strides =
            if has(ffi::PyBUF_STRIDES) { (*layout).strides.as_mut_ptr() } else { ptr::null_mut() };
        (*view).suboffsets = ptr::null_mut();
        (*view).internal = layout.cast::<c_void>();
        (*view).obj = owner.clone().into_ptr();
    }
    Ok(())
}

/// Ends a view that `fill` has filled.
///
/// # Safety
/// `view` was filled by [`fill`] for this framebuffer, and is released once.
pub unsafe fn release(shared: &Shared, view: *mut ffi::Py_buffer) {
    // SAFETY: `internal` is the box that `fill` has leaked, and this is its only end.
    unsafe { drop(Box::from_raw((*view).internal.cast::<Layout>())) };
    shared.drop_view();
}

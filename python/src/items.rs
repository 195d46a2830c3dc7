//! Python values as words of a command: numbers, colours, names, bytes.
//!
//! In: one value. Out: its word, or the values that it consists of.

use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyByteArray, PyBytes, PyFloat, PyInt, PyString};
use std::fmt::Write;

/// Returns whether a value is text.
pub fn is_text(item: &Bound<'_, PyAny>) -> bool {
    item.is_instance_of::<PyString>()
}

/// Returns whether a value is a number; those of numpy are.
pub fn is_number(item: &Bound<'_, PyAny>) -> bool {
    if item.is_exact_instance_of::<PyInt>() || item.is_exact_instance_of::<PyFloat>() {
        return true;
    }
    let is_sequence = is_text(item)
        || item.is_instance_of::<PyBytes>()
        || item.is_instance_of::<PyByteArray>()
        || item.len().is_ok();
    !is_sequence && item.extract::<f64>().is_ok()
}

/// Appends a number's word. A whole number is written without a point where `whole`, so that
/// `height / 2` serves as a row.
pub fn push_number(item: &Bound<'_, PyAny>, whole: bool, line: &mut String) -> PyResult<()> {
    // `write!` into a String does not fail.
    if item.is_instance_of::<PyBool>() {
        let _ = write!(line, " {}", u8::from(item.extract::<bool>()?));
        return Ok(());
    }
    if !item.is_exact_instance_of::<PyFloat>() && item.hasattr("__index__")? {
        match item.extract::<i64>() {
            Ok(n) => {
                let _ = write!(line, " {n}");
            }
            Err(_) => {
                let _ = write!(line, " {}", item.call_method0("__index__")?.str()?.to_str()?);
            }
        }
        return Ok(());
    }
    let x = item.extract::<f64>()?;
    let _ = match whole && x.fract() == 0.0 && x.abs() < 1e15 {
        true => write!(line, " {}", x as i64),
        false => write!(line, " {x}"),
    };
    Ok(())
}

/// Returns the items of a value that consists of others: a tuple, a list, an array, any iterable but
/// text and bytes.
pub fn parts<'py>(item: &Bound<'py, PyAny>) -> Option<PyResult<Vec<Bound<'py, PyAny>>>> {
    if is_text(item) || item.is_instance_of::<PyBytes>() || item.is_instance_of::<PyByteArray>() {
        return None;
    }
    item.try_iter().ok().map(|items| items.collect())
}

/// Colour of a value.
pub enum Colour<'py> {
    /// Its word.
    Word(String),
    /// The value is a list, whose items are colours.
    Several(Vec<Bound<'py, PyAny>>),
    /// The value is no colour.
    None,
}

/// Returns the colour of a value: a name or hex digits, also after `#`; 3 or 4 whole numbers from 0
/// to 255, or that many bytes; or a list of colours.
pub fn colour<'py>(item: &Bound<'py, PyAny>) -> PyResult<Colour<'py>> {
    if let Ok(text) = item.cast::<PyString>() {
        return Ok(Colour::Word(colour_word(text.to_str()?)));
    }
    let hex = |bytes: &[u8]| bytes.iter().map(|b| format!("{b:02x}")).collect::<String>();
    if item.is_instance_of::<PyBytes>() || item.is_instance_of::<PyByteArray>() {
        let bytes: Vec<u8> = item.extract()?;
        return Ok(if [3, 4].contains(&bytes.len()) { Colour::Word(hex(&bytes)) } else { Colour::None });
    }
    if is_number(item) {
        return Ok(Colour::None);
    }
    let Some(items) = parts(item) else { return Ok(Colour::None) };
    let items = items?;
    if items.first().is_some_and(|first| !is_number(first)) {
        return Ok(Colour::Several(items));
    }
    let bytes: Option<Vec<u8>> = items
        .iter()
        .map(|n| n.extract::<f64>().ok().filter(|x| x.fract() == 0.0 && (0.0..=255.0).contains(x)))
        .map(|x| x.map(|x| x as u8))
        .collect();
    Ok(match bytes {
        Some(bytes) if [3, 4].contains(&bytes.len()) => Colour::Word(hex(&bytes)),
        _ => Colour::None,
    })
}

/// Returns the word of a colour that is text: `#rgb`, `#rgba`, `#rrggbb`, `#rrggbbaa` without their
/// `#`, anything else unchanged.
pub fn colour_word(text: &str) -> String {
    match text.strip_prefix('#') {
        Some(digits) if [3, 4].contains(&digits.len()) && digits.is_ascii() => {
            digits.chars().flat_map(|digit| [digit, digit]).collect()
        }
        Some(digits) if [6, 8].contains(&digits.len()) => digits.to_owned(),
        _ => text.to_owned(),
    }
}

/// Returns the bytes of a payload: bytes or the memory of an array unchanged, text as UTF-8.
pub fn bytes(item: &Bound<'_, PyAny>) -> Option<Vec<u8>> {
    if let Ok(text) = item.cast::<PyString>() {
        return text.to_str().ok().map(|text| text.as_bytes().to_vec());
    }
    if let Ok(bytes) = item.cast::<PyBytes>() {
        return Some(bytes.as_bytes().to_vec());
    }
    if let Ok(buffer) = PyBuffer::<u8>::get(item) {
        return buffer.to_vec(item.py()).ok();
    }
    item.try_iter().ok()?.map(|n| n.ok()?.extract::<u8>().ok()).collect()
}

//! Exceptions: refused commands with code and place, made by `fbptr.errors`.

use fbptr::error::{Code, Fault};
use fbptr::server::{CommandError, Notice};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// A refused command: line and byte of its place, its verb, its code, its message.
pub type Refused = (u64, u64, String, &'static str, String);

/// Returns the message of a fault, with the token that was found.
fn message(fault: &Fault) -> String {
    match &fault.token {
        Some(token) if !token.is_empty() => format!("{}, got {token:?}", fault.message),
        _ => fault.message.clone(),
    }
}

/// Returns the refused command of an error of the stream.
pub fn of_notice(CommandError { place, verb, fault, .. }: &CommandError) -> Refused {
    (place.line, place.byte, verb.clone(), fault.code.as_str(), message(fault))
}

/// Creates the exception of refused commands; `replies` are those of the commands that ran.
pub fn refused(py: Python<'_>, all: Vec<Refused>, replies: &[u8]) -> PyErr {
    let made = py.import("fbptr.errors").and_then(|errors| errors.call_method1("refused", (all, replies)));
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// Creates the exception of one refused call.
pub fn of_fault(py: Python<'_>, line: u64, verb: &str, fault: &Fault) -> PyErr {
    refused(py, vec![(line, 0, verb.to_owned(), fault.code.as_str(), message(fault))], b"")
}

/// Creates the exception of wrong arguments.
pub fn wrong(py: Python<'_>, code: Code, verb: &str, message: String) -> PyErr {
    refused(py, vec![(0, 0, verb.to_owned(), code.as_str(), message)], b"")
}

/// Warns of what the notices say beside errors, and returns the errors; those of a text have their
/// place in it.
pub fn of_notices(py: Python<'_>, notices: &[Notice], is_text: bool) -> PyResult<Vec<Refused>> {
    let mut all = Vec::new();
    for notice in notices {
        let warning = match notice {
            Notice::Refused(error) => {
                let refused = of_notice(error);
                // The place of a method's call is in the traceback.
                all.push(if is_text { refused } else { (0, 0, refused.2, refused.3, refused.4) });
                continue;
            }
            Notice::Warning(text) => text.clone(),
            Notice::Remark { verb, text, .. } => format!("{verb}: {text}"),
        };
        py.import("fbptr.errors")?.call_method1("warn", (warning,))?;
    }
    Ok(all)
}

/// Creates the exception for a lock that a panic has left.
pub fn poisoned() -> PyErr {
    PyRuntimeError::new_err("an earlier call met a defect of the engine: this framebuffer is not usable")
}

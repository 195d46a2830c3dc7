//! Errors of scenes, located by their path in the JSON.

use crate::error::{Code, Fault};
use std::fmt;

/// Error of an N-dimensional scene. `path` is the position in the JSON: `facets[3].v[2]`.
#[derive(Clone, Debug, PartialEq)]
pub enum EyeError {
    /// Not JSON, or a number that f64 cannot represent.
    Json {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Message of the JSON parser.
        message: String,
    },
    /// A value of another type, or a word that is not one of those expected.
    Type {
        /// Path in the JSON.
        path: String,
        /// Description of the expected values.
        expected: String,
        /// Text of the value found.
        found: String,
    },
    /// A required field is missing.
    Missing {
        /// Path in the JSON.
        path: String,
    },
    /// An unknown field.
    Unknown {
        /// Path in the JSON.
        path: String,
        /// Names of the allowed fields.
        expected: String,
    },
    /// An array of the wrong length.
    Length {
        /// Path in the JSON.
        path: String,
        /// Expected number of entries.
        expected: String,
        /// Number of entries found.
        found: usize,
    },
    /// A number outside its range.
    Range {
        /// Path in the JSON.
        path: String,
        /// Description of the allowed range.
        expected: String,
        /// The number found.
        found: f64,
    },
    /// A size above one of the program's limits.
    TooBig {
        /// Path in the JSON.
        path: String,
        /// The limit.
        limit: u64,
        /// Requested size.
        found: u64,
    },
}

impl fmt::Display for EyeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EyeError::Json { line, column, message } => write!(f, "line {line} column {column}: {message}"),
            EyeError::Type { path, expected, found } => {
                write!(f, "{path}: expected {expected}, found {found}")
            }
            EyeError::Missing { path } => write!(f, "{path}: missing"),
            EyeError::Unknown { path, expected } => {
                write!(f, "{path}: unknown field, expected one of {expected}")
            }
            EyeError::Length { path, expected, found } => {
                write!(f, "{path}: expected {expected} entries, found {found}")
            }
            EyeError::Range { path, expected, found } => {
                write!(f, "{path}: expected {expected}, found {found}")
            }
            EyeError::TooBig { path, limit, found } => {
                write!(f, "{path}: {found} is over the limit of {limit}")
            }
        }
    }
}

impl std::error::Error for EyeError {}

impl EyeError {
    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            EyeError::TooBig { .. } => Code::TooBig,
            _ => Code::Format,
        }
    }
}

impl From<EyeError> for Fault {
    fn from(e: EyeError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

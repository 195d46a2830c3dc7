//! Why a scene was refused, with its place in the JSON.

use crate::error::Code;

/// What is wrong with an N-dimensional scene. `path` is the place in the JSON: `facets[3].v[2]`.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EyeError {
    /// Not JSON, or a number that f64 cannot hold.
    #[error("line {line} column {column}: {message}")]
    Json {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the reader said.
        message: String,
    },
    /// A value of another type, or a word that is not one of those expected.
    #[error("{path}: expected {expected}, found {found}")]
    Type {
        /// Place in the JSON.
        path: String,
        /// What belongs there.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A field that must be there and is not.
    #[error("{path}: missing")]
    Missing {
        /// Place in the JSON.
        path: String,
    },
    /// A field that does not belong there.
    #[error("{path}: unknown field, expected one of {expected}")]
    Unknown {
        /// Place in the JSON.
        path: String,
        /// The fields that are known there.
        expected: String,
    },
    /// An array of the wrong length.
    #[error("{path}: expected {expected} entries, found {found}")]
    Length {
        /// Place in the JSON.
        path: String,
        /// How many belong there.
        expected: String,
        /// How many are there.
        found: usize,
    },
    /// A number outside its range.
    #[error("{path}: expected {expected}, found {found}")]
    Range {
        /// Place in the JSON.
        path: String,
        /// The range.
        expected: String,
        /// The number.
        found: f64,
    },
    /// More than this program takes.
    #[error("{path}: {found} is over the limit of {limit}")]
    TooBig {
        /// Place in the JSON.
        path: String,
        /// The limit.
        limit: u64,
        /// What was asked for.
        found: u64,
    },
}

impl EyeError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            EyeError::TooBig { .. } => Code::TooBig,
            _ => Code::Format,
        }
    }
}

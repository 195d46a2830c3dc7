//! Errors and warnings of loading a file, with their positions.

use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::OverBudget;
use std::error::Error;
use std::fmt;

/// Position in a file that is being loaded.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct FilePosition {
    /// Name of the file, as the caller gave it.
    pub file: String,
    /// Line from 1; 0 stands for the whole file.
    pub line: u32,
    /// Column in characters, from 1; 0 stands for the whole line.
    pub column: u32,
    /// Part of a file that has no lines: a byte offset, or the JSON pointer of a value. Empty for
    /// the whole file.
    part: String,
}

impl FilePosition {
    /// Creates the position of a whole file.
    pub fn file(file: impl Into<String>) -> Self {
        FilePosition::column(file, 0, 0)
    }

    /// Creates the position of a whole line, from 1.
    pub fn line(file: impl Into<String>, line: u32) -> Self {
        FilePosition::column(file, line, 0)
    }

    /// Creates the position of a character: line and column, both from 1.
    pub fn column(file: impl Into<String>, line: u32, column: u32) -> Self {
        FilePosition { file: file.into(), line, column, part: String::new() }
    }

    /// Creates the position of a byte, from 0.
    pub fn byte(file: impl Into<String>, offset: u64) -> Self {
        FilePosition { part: format!(":byte {offset}"), ..FilePosition::file(file) }
    }

    /// Creates the position of a JSON value by its pointer (RFC 6901), as in `/meshes/0`.
    pub fn json(file: impl Into<String>, pointer: &str) -> Self {
        FilePosition { part: format!("#{pointer}"), ..FilePosition::file(file) }
    }
}

impl fmt::Display for FilePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        f.write_str(&self.part)?;
        match (self.line, self.column) {
            (0, _) => Ok(()),
            (line, 0) => write!(f, ":{line}"),
            (line, column) => write!(f, ":{line}:{column}"),
        }
    }
}

/// Kind of defect in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LoadErrorKind {
    /// The text violates the grammar of its format.
    Syntax {
        /// Text that the format requires.
        expected: String,
        /// Text found.
        found: String,
    },
    /// A word that must be a finite number is not.
    Number {
        /// Meaning of the number.
        what: &'static str,
        /// Text found.
        found: String,
    },
    /// A finite number outside the valid range.
    Range {
        /// Meaning of the number.
        what: &'static str,
        /// Description of the valid range.
        expected: &'static str,
        /// Number found.
        found: String,
    },
    /// An index out of range.
    Index {
        /// Kind of the indexed elements.
        what: &'static str,
        /// Index as written in the file.
        index: i64,
        /// Number of elements.
        count: u64,
    },
    /// A size over its limit.
    TooBig {
        /// Quantity that is limited.
        what: &'static str,
        /// Amount found.
        found: u64,
        /// Largest amount allowed.
        limit: u64,
    },
    /// A referenced file that does not exist, or may not be read.
    Missing {
        /// Kind of file or name.
        what: &'static str,
        /// Name as referenced.
        name: String,
    },
    /// The format's decoder failed; its own message is the reason.
    Undecodable {
        /// Name of the format.
        format: &'static str,
        /// Message of the decoder.
        reason: String,
    },
    /// The result would exceed the quota.
    OverQuota {
        /// Bytes of the result as far as it is known.
        found: u64,
        /// Bytes that the quota allows.
        limit: u64,
    },
    /// Loading would exceed the memory budget.
    OverBudget(OverBudget),
    /// The caller cancelled the load.
    Cancelled,
}

impl fmt::Display for LoadErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LoadErrorKind::Syntax { expected, found } => write!(f, "{expected}, found {found:?}"),
            LoadErrorKind::Number { what, found } => {
                write!(f, "{what} must be a finite number, found {found:?}")
            }
            LoadErrorKind::Range { what, expected, found } => {
                write!(f, "{what} must be {expected}, found {found}")
            }
            LoadErrorKind::Index { what, index, count } => {
                write!(f, "{what} index {index} names none of the {count} there are")
            }
            LoadErrorKind::TooBig { what, found, limit } => {
                write!(f, "{what}: {found} is over the limit of {limit}")
            }
            LoadErrorKind::Missing { what, name } => write!(f, "{what} {name:?} cannot be found"),
            LoadErrorKind::Undecodable { format, reason } => write!(f, "not a readable {format}: {reason}"),
            LoadErrorKind::OverQuota { found, limit } => {
                write!(f, "it takes {found} bytes, and the quota leaves {limit}")
            }
            LoadErrorKind::OverBudget(e) => write!(f, "{e}"),
            LoadErrorKind::Cancelled => f.write_str("reading it was given up before its end"),
        }
    }
}

impl Error for LoadErrorKind {}

/// Error of loading a file, with its position. The text is `FILE:LINE:COLUMN: reason`, without the
/// parts that are unknown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadError {
    /// Position of the error.
    pub place: FilePosition,
    /// Kind of the error.
    pub kind: LoadErrorKind,
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.kind)
    }
}

impl Error for LoadError {}

impl LoadError {
    /// Creates an error at a position.
    pub fn new(place: FilePosition, kind: LoadErrorKind) -> Self {
        LoadError { place, kind }
    }

    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        match self.kind {
            LoadErrorKind::TooBig { .. } => Code::TooBig,
            LoadErrorKind::Missing { .. } => Code::NoEnt,
            LoadErrorKind::OverQuota { .. } | LoadErrorKind::OverBudget(_) | LoadErrorKind::Cancelled => {
                Code::Quota
            }
            LoadErrorKind::Syntax { .. }
            | LoadErrorKind::Number { .. }
            | LoadErrorKind::Range { .. }
            | LoadErrorKind::Index { .. }
            | LoadErrorKind::Undecodable { .. } => Code::Format,
        }
    }
}

impl From<LoadError> for Fault {
    fn from(e: LoadError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

/// A defect that was skipped or repaired: the file still loads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadWarning {
    /// Position of the defect.
    pub place: FilePosition,
    /// Description of what was done, in lower case, one line.
    pub message: String,
}

impl fmt::Display for LoadWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: warning: {}", self.place, self.message)
    }
}

/// Returns the beginning of a text from a file or of a decoder's message, as one line.
pub(super) fn short(text: &str) -> String {
    const MOST: usize = 160;
    let line = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    line.take(MOST).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_reads_as_file_line_column_and_reason() {
        let kind = LoadErrorKind::Index { what: "position", index: -4, count: 3 };
        let error = LoadError::new(FilePosition::line("a.obj", 7), kind);
        assert_eq!(error.to_string(), "a.obj:7: position index -4 names none of the 3 there are");
        assert_eq!(error.code(), Code::Format);
        let kind = LoadErrorKind::Missing { what: "texture", name: "a b.png".into() };
        let error = LoadError::new(FilePosition::column("s.x3d", 2, 5), kind);
        assert_eq!(error.to_string(), "s.x3d:2:5: texture \"a b.png\" cannot be found");
        let kind = LoadErrorKind::TooBig { what: "facets", found: 2, limit: 1 };
        let error = LoadError::new(FilePosition::byte("a.stl", 80), kind);
        assert_eq!(error.to_string(), "a.stl:byte 80: facets: 2 is over the limit of 1");
        assert_eq!(FilePosition::json("a.gltf", "/meshes/0").to_string(), "a.gltf#/meshes/0");
        let warning = LoadWarning { place: FilePosition::file("m"), message: "empty".into() };
        assert_eq!(warning.to_string(), "m: warning: empty");
    }
}

//! Why a file was refused, and where in it.

use crate::error::Code;
use crate::memory::OverBudget;
use std::fmt;

/// A place in a file that is being loaded.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct FilePosition {
    /// The file's name, as the caller gave it.
    pub file: String,
    /// The line, from 1; 0 means the file as a whole.
    pub line: u32,
    /// The column in characters, from 1; 0 means the line as a whole.
    pub column: u32,
}

impl FilePosition {
    /// A file as a whole.
    pub fn file(file: impl Into<String>) -> Self {
        FilePosition { file: file.into(), line: 0, column: 0 }
    }

    /// A line of a file, from 1.
    pub fn line(file: impl Into<String>, line: u32) -> Self {
        FilePosition { file: file.into(), line, column: 0 }
    }

    /// A line and a column, both from 1.
    pub fn column(file: impl Into<String>, line: u32, column: u32) -> Self {
        FilePosition { file: file.into(), line, column }
    }
}

impl fmt::Display for FilePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        match (self.line, self.column) {
            (0, _) => Ok(()),
            (line, 0) => write!(f, ":{line}"),
            (line, column) => write!(f, ":{line}:{column}"),
        }
    }
}

/// What is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LoadErrorKind {
    /// The text does not say what its format asks for here.
    #[error("{expected}, found {found:?}")]
    Syntax {
        /// What the format asks for.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// Something that must be a finite number is not.
    #[error("{what} must be a finite number, found {found:?}")]
    Number {
        /// What the number is for.
        what: &'static str,
        /// What stands there.
        found: String,
    },
    /// A number that is finite, but cannot be used.
    #[error("{what} must be {expected}, found {found}")]
    Range {
        /// What the number is for.
        what: &'static str,
        /// Which numbers can be used.
        expected: &'static str,
        /// What stands there.
        found: String,
    },
    /// An index that names nothing.
    #[error("{what} index {index} names none of the {count} there are")]
    Index {
        /// What is counted.
        what: &'static str,
        /// The index as written.
        index: i64,
        /// How many there are.
        count: u64,
    },
    /// More than the limit.
    #[error("{what}: {found} is over the limit of {limit}")]
    TooBig {
        /// What is limited.
        what: &'static str,
        /// How much there is.
        found: u64,
        /// How much there may be.
        limit: u64,
    },
    /// A file that is referred to and cannot be found, or may not be read.
    #[error("{what} {name:?} cannot be found")]
    Missing {
        /// What kind of file or name.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// The decoder of the format gave up, for the reason in its own words.
    #[error("not a readable {format}: {reason}")]
    Undecodable {
        /// The format's name.
        format: &'static str,
        /// The decoder's reason.
        reason: String,
    },
    /// What is read would take more than the quota leaves.
    #[error("it takes {found} bytes, and the quota leaves {limit}")]
    OverQuota {
        /// Bytes that it would take, as far as it is known.
        found: u64,
        /// Bytes that it may take.
        limit: u64,
    },
    /// Reading it would take more memory than there may be.
    #[error(transparent)]
    OverBudget(OverBudget),
    /// Whoever asked for it has cancelled it.
    #[error("reading it was given up before its end")]
    Cancelled,
}

/// A file that was refused: where, and why. Its text is `FILE:LINE:COLUMN: reason`, as far as the place is known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {kind}")]
pub struct LoadError {
    /// Where.
    pub place: FilePosition,
    /// Why.
    pub kind: LoadErrorKind,
}

impl LoadError {
    /// A refusal at a place.
    pub fn new(place: FilePosition, kind: LoadErrorKind) -> Self {
        LoadError { place, kind }
    }

    /// The protocol's code for this error.
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

/// Something in a file that was skipped or put right: the file still loads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadWarning {
    /// Where.
    pub place: FilePosition,
    /// What was done, in lower case, one line.
    pub message: String,
}

impl fmt::Display for LoadWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: warning: {}", self.place, self.message)
    }
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
        let warning = LoadWarning { place: FilePosition::file("m"), message: "empty".into() };
        assert_eq!(warning.to_string(), "m: warning: empty");
    }
}

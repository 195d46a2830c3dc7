//! Error codes of the protocol, shared by all modules.
//!
//! In: an error of any module. Out: its [`Code`], alone or with a reason ([`Fault`]). Each module
//! has its own error type (kind, place, numbers), and each such type has a `code()`, because a
//! client sees only the code and one line of text. The list of codes is closed: it is part of the
//! protocol.

use std::fmt;

/// Reason for which a command is refused, as it is sent (`ERR line byte CODE ...`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Code {
    /// Unknown verb.
    Verb,
    /// Wrong number of arguments, a wrong keyword, a missing payload or one that the verb does not
    /// take.
    Args,
    /// Not a number in the form that the verb takes, or not finite.
    Num,
    /// Not a colour.
    Colour,
    /// A number outside the range that the verb accepts.
    Range,
    /// No object or file with this name.
    NoEnt,
    /// Larger than a limit.
    TooBig,
    /// A payload or file that does not parse.
    Format,
    /// A framing error: bytes that cannot be a command.
    Proto,
    /// Not allowed here.
    Perm,
    /// A quota is used up.
    Quota,
}

impl Code {
    /// Returns the code's spelling in the protocol, such as `ERANGE`.
    pub const fn as_str(self) -> &'static str {
        match self {
            Code::Verb => "EVERB",
            Code::Args => "EARGS",
            Code::Num => "ENUM",
            Code::Colour => "ECOLOUR",
            Code::Range => "ERANGE",
            Code::NoEnt => "ENOENT",
            Code::TooBig => "ETOOBIG",
            Code::Format => "EFORMAT",
            Code::Proto => "EPROTO",
            Code::Perm => "EPERM",
            Code::Quota => "EQUOTA",
        }
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A refused command's code and reason.
///
/// `message` is one lower-case line that says what was expected; `token` is what was found instead,
/// as it was received.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The code that is sent.
    pub code: Code,
    /// One line in lower case that says what was expected.
    pub message: String,
    /// The offending token, if a single one is to blame.
    pub token: Option<String>,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.code, self.message)?;
        match &self.token {
            Some(token) => write!(f, ", got {token:?}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Fault {}

impl Fault {
    /// Creates a fault without a token.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Fault { code, message: message.into(), token: None }
    }

    /// Adds the offending token.
    pub fn got(mut self, token: impl Into<String>) -> Self {
        self.token = Some(token.into());
        self
    }
}

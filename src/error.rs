//! The refusal codes that every room shares.
//!
//! Each room has its own error type (kind, place, numbers); what a stream's author sees of it is one of
//! these codes, so every such type answers `code()`. The list is closed: it is part of the protocol.

use std::fmt;

/// Why a command was refused, as it stands on the wire (`ERR line byte CODE ...`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Code {
    /// Unknown verb.
    Verb,
    /// Wrong number of arguments, a wrong keyword, a payload missing or not wanted.
    Args,
    /// Not a number of the form the verb takes, or not finite.
    Num,
    /// Not a colour.
    Colour,
    /// A number outside the range that the verb can act on.
    Range,
    /// No such name, no such file.
    NoEnt,
    /// Larger than a limit.
    TooBig,
    /// A payload or file that does not parse.
    Format,
    /// Framing: what cannot be a command.
    Proto,
    /// Not allowed here.
    Perm,
    /// A quota is used up.
    Quota,
}

impl Code {
    /// The code's spelling on the wire.
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

/// A refusal with its reason: what a room answers when it cannot do what a command asks.
///
/// `message` is one lower-case line that says what was expected; `token` is what was found instead, as it came.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{code} {message}{}", .token.as_ref().map(|t| format!(", got {t:?}")).unwrap_or_default())]
pub struct Fault {
    /// The code on the wire.
    pub code: Code,
    /// What was expected, in lower case, one line.
    pub message: String,
    /// What was found instead, if one token is to blame.
    pub token: Option<String>,
}

impl Fault {
    /// A refusal without a token.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Fault { code, message: message.into(), token: None }
    }

    /// The same refusal, blaming `token`.
    pub fn got(mut self, token: impl Into<String>) -> Self {
        self.token = Some(token.into());
        self
    }
}

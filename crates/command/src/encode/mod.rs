//! Encoder: the bytes of a command, which the decoder reads back as the same command.
//!
//! Numbers are printed in the shortest form that reads back bit by bit, colours as `rrggbbaa` or
//! `rrggbb`. Some arguments are left out where they have their defaults.

mod line;

use super::codec::Codec;
use super::commands::Command;
use fbptr_core::error::{Code, Fault};
use std::error::Error;
use std::fmt;

pub(super) use line::LineWriter;

/// Longest line in bytes, without its LF and one CR before it.
pub const MAX_LINE_BYTES: usize = 4096;

/// Reason why a command cannot be encoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EncodeError {
    /// The command is invalid by itself: [`Command::validate`] refuses it, or a pixel run is too
    /// long for its header.
    Refused(Fault),
    /// The line would be over the limit: a long POLY, FILLPOLY or POKE, or a long name.
    LineTooLong {
        /// The verb.
        verb: &'static str,
        /// Bytes of the line without LF.
        bytes: usize,
    },
    /// The text form cannot express it: a texture called OFF or wrapped differently along its axes,
    /// a material with a file's texture.
    NoText {
        /// The verb.
        verb: &'static str,
        /// Part that cannot be expressed.
        what: &'static str,
    },
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EncodeError::Refused(e) => write!(f, "{e}"),
            EncodeError::LineTooLong { verb, bytes } => {
                write!(f, "{verb} would take a line of {bytes} bytes, a line has at most {MAX_LINE_BYTES}")
            }
            EncodeError::NoText { verb, what } => write!(f, "{verb} has no text for {what}"),
        }
    }
}

impl Error for EncodeError {}

impl From<Fault> for EncodeError {
    fn from(e: Fault) -> Self {
        EncodeError::Refused(e)
    }
}

impl EncodeError {
    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            EncodeError::Refused(fault) => fault.code,
            EncodeError::LineTooLong { .. } => Code::TooBig,
            EncodeError::NoText { .. } => Code::Args,
        }
    }
}

/// Appends a command's bytes to `out`; on an error nothing is appended.
///
/// ```
/// use fbptr_command::{Command, Figure, encode};
/// let mut bytes = Vec::new();
/// encode(&Command::Pixel { x: 1, y: -2, color: [255, 128, 0, 255] }, &mut bytes)?;
/// let text = Figure::Text { x: 0, y: 0, color: [9, 9, 9, 0], utf8: b"hi".to_vec() };
/// encode(&Command::Figure(text), &mut bytes)?;
/// assert_eq!(bytes, b"PX 1 -2 ff8000\nTEXT 0 0 09090900 :2\nhi");
/// # Ok::<(), fbptr_command::EncodeError>(())
/// ```
pub fn encode(command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
    command.validate()?;
    let start = out.len();
    let result = write(command, out);
    if result.is_err() {
        out.truncate(start);
    }
    result
}

fn write(command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
    let (verb, payload) = (command.verb(), command.payload());
    let start = out.len();
    out.extend_from_slice(verb.as_bytes());
    let mut line = LineWriter::new(verb, out);
    Codec::write(command, &mut line)?;
    if !line.is_binary() {
        if let Some(payload) = payload {
            line.word(format_args!(":{}", payload.len()));
        }
        let bytes = out.len() - start;
        if bytes > MAX_LINE_BYTES {
            return Err(EncodeError::LineTooLong { verb, bytes });
        }
        out.push(b'\n');
    }
    out.extend_from_slice(payload.unwrap_or(b""));
    Ok(())
}

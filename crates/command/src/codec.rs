//! The passes over the arguments of a command: checks and encoding.
//!
//! In: a typed command. Out: its verb, its payload, a fault, its words. The verb table's macros
//! implement them, so that no pass can forget an argument.

use super::args::{Args, ParseError};
use super::encode::{EncodeError, LineWriter};
use fbptr_core::error::Fault;

/// Parser of a text verb's arguments, for lines with a number of words that the table allows.
pub(super) type Parse<C> = fn(&mut Args<'_>) -> Result<C, ParseError>;

/// Checks and encodes a command or a part of one. Made from the table by `codec!`: each method
/// calls the method of this name of every [`Argument`](super::arguments::Argument) in order.
pub(super) trait Codec {
    /// Returns the verb's name in the table.
    fn verb(&self) -> &'static str;

    /// Returns the bytes that follow the line or header, or `None` without payload.
    fn payload(&self) -> Option<&[u8]>;

    /// Returns the payload for writing; `None` as in [`Codec::payload`].
    fn payload_mut(&mut self) -> Option<&mut Vec<u8>>;

    /// Refuses numbers that are not finite.
    fn check_numbers(&self) -> Result<(), Fault>;

    /// Refuses negative sizes.
    fn check_sizes(&self) -> Result<(), Fault>;

    /// Refuses names that cannot stand in a line.
    fn check_names(&self) -> Result<(), Fault>;

    /// Refuses a payload length that the other arguments contradict.
    fn check_length(&self, length: u64) -> Result<(), Fault>;

    /// Refuses contents that no line can express: no byte to write, no point, text that is not
    /// UTF-8.
    fn check_content(&self) -> Result<(), Fault>;

    /// Appends the arguments, without the payload.
    fn write(&self, line: &mut LineWriter<'_>) -> Result<(), EncodeError>;
}

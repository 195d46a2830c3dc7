//! Validation of single commands, independent of the state of memory and session.
//!
//! The decoder validates every command that it reads, the engine those that arrive as typed values,
//! so that both paths refuse the same commands with the same codes:
//! - ENUM: a number that is not finite;
//! - ERANGE: a negative width, height, radius, size, byte count, light index, level or error
//!   budget;
//! - EFORMAT: a payload whose length contradicts the words before it, or text that is not UTF-8;
//! - EARGS: a name that cannot stand in a line; no byte to write, no point to join.
//!
//! The rules are those of the arguments' kinds ([`super::arguments`]); this file says when they are
//! applied.

use super::codec::Codec;
use super::commands::Command;
use fbptr_core::error::Fault;

impl Command {
    /// Checks the command by itself.
    ///
    /// # Errors
    ///
    /// Those listed in the module's documentation.
    pub fn validate(&self) -> Result<(), Fault> {
        self.check_numbers()?;
        self.check_sizes()?;
        self.check_names()?;
        if let Some(payload) = self.payload() {
            self.check_length(payload.len() as u64)?;
        }
        self.check_content()
    }

    /// Checks a command whose arguments have been read and whose payload is still to come.
    pub(super) fn validate_head(&self, payload_length: u64) -> Result<(), Fault> {
        self.check_sizes()?;
        self.check_length(payload_length)
    }

    /// Checks the payload of a command that has been read.
    pub(super) fn validate_payload(&self) -> Result<(), Fault> {
        self.check_content()
    }
}

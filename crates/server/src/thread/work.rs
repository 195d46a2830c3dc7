//! Work of a connection that was received and has not run yet.

use crate::message::{Batch, Item};
use fbptr_command::{EndOfInput, LentPayload};
use fbptr_engine::stream::Resume;

/// A unit of queued work.
pub(super) enum Work {
    /// A batch of bytes, from this one on.
    Bytes { batch: Batch, at: usize },
    /// A payload that was lent, with what was read of it.
    Payload(LentPayload),
    /// Typed commands and questions.
    Item(Item),
    /// The rest of the command that was suspended; runs before everything else.
    Resume(Resume),
    /// The end of the input.
    End(EndOfInput),
}

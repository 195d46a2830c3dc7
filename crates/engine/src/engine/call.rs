//! A call of a verb's function: what the functions of all verbs are given, and what they may
//! return.
//!
//! In: a session, the buffer of its replies. Out: one form of progress, for whatever a function
//! returns.

use super::{Effect, Progress};
use crate::Session;
use fbptr_core::error::Fault;
use std::ops::{Deref, DerefMut};

/// A command's session, as which it can be used, and the buffer of its replies.
#[derive(Debug)]
pub(super) struct Call<'a> {
    pub session: &'a mut Session,
    pub replies: &'a mut Vec<u8>,
}

impl Call<'_> {
    /// Appends a line to the replies.
    pub fn answer(&mut self, line: std::fmt::Arguments<'_>) {
        self.replies.extend_from_slice(format!("{line}\n").as_bytes());
    }
}

impl Deref for Call<'_> {
    type Target = Session;

    fn deref(&self) -> &Session {
        self.session
    }
}

impl DerefMut for Call<'_> {
    fn deref_mut(&mut self) -> &mut Session {
        self.session
    }
}

/// A return type of a verb's function.
pub(super) trait Outcome {
    /// Returns it as progress.
    fn outcome(self) -> Result<Progress, Fault>;
}

impl Outcome for () {
    fn outcome(self) -> Result<Progress, Fault> {
        Ok(Progress::Done(Effect::Done))
    }
}

impl Outcome for Effect {
    fn outcome(self) -> Result<Progress, Fault> {
        Ok(Progress::Done(self))
    }
}

impl Outcome for Progress {
    fn outcome(self) -> Result<Progress, Fault> {
        Ok(self)
    }
}

impl<T: Outcome, E: Into<Fault>> Outcome for Result<T, E> {
    fn outcome(self) -> Result<Progress, Fault> {
        self.map_err(E::into).and_then(T::outcome)
    }
}

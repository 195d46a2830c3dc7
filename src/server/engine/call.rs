//! A call of a verb's function: what the functions of all verbs are given, and what they may
//! return.
//!
//! In: a session, the buffer of its replies. Out: one form of progress, for whatever a function
//! returns.

use super::{Effect, Progress};
use crate::draw2d::{AreaColors, RampColor, RealRect, Rect};
use crate::error::Fault;
use crate::server::Session;
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

/// What a verb's function may return.
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

/// An argument of a figure, lent to the function that draws it: a list by reference, all else by
/// value. A figure that is drawn in bands is kept.
pub(super) trait Lend {
    /// Its type as a parameter.
    type Lent<'a>
    where
        Self: 'a;

    /// Lends it.
    fn lend(&self) -> Self::Lent<'_>;
}

impl<T> Lend for Vec<T> {
    type Lent<'a>
        = &'a [T]
    where
        T: 'a;

    fn lend(&self) -> &[T] {
        self
    }
}

impl Lend for String {
    type Lent<'a> = &'a str;

    fn lend(&self) -> &str {
        self
    }
}

macro_rules! lend_by_value {
    ($($type:ty),*) => {
        $(impl Lend for $type {
            type Lent<'a> = $type;

            fn lend(&self) -> $type {
                *self
            }
        })*
    };
}

lend_by_value!(bool, i32, f64, [i32; 2], [f64; 2], [[i32; 2]; 3], [[f64; 2]; 3], [[f64; 2]; 4]);
lend_by_value!([u8; 4], Rect, RealRect, RampColor, AreaColors);

//! From words to commands, one function a verb. The word counts of the table hold when these run; what a line means
//! beyond its own words (does the name exist, does the offset) is the engine's to say.

pub(super) mod control;
pub(super) mod memory;
pub(super) mod plane;
pub(super) mod space;

use super::args::{Args, Refusal};
use super::model::Command;
use crate::error::Code;

type Parsed = Result<Command, Refusal>;

/// The words left, which must be one of `counts` as the subject before them says.
fn expect_left(args: &Args<'_>, counts: &[usize], what: &str) -> Result<(), Refusal> {
    if counts.contains(&args.left()) {
        return Ok(());
    }
    let most = counts.last().copied().unwrap_or(0);
    // The first word too many, or the last one before those that are missing.
    let blamed = match args.left() {
        0 => args.last(),
        left => args.nth_left(most.min(left - 1)),
    };
    let wanted = counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" or ");
    Err(Refusal::new(
        Code::Args,
        format!("{what} takes {wanted} more arguments, not {}", args.left()),
        blamed,
    ))
}

/// `on` or `off`.
fn switch(args: &mut Args<'_>) -> Result<bool, Refusal> {
    args.keyword("on or off", |word| match () {
        () if word.eq_ignore_ascii_case("on") => Some(true),
        () if word.eq_ignore_ascii_case("off") => Some(false),
        () => None,
    })
}

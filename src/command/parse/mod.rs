//! Parsers from words to commands, one function per verb. They run after the table's word counts
//! have been checked; the engine checks what depends on its state (whether a name exists, whether
//! an offset is in range).

pub(super) mod control;
pub(super) mod memory;
pub(super) mod three_d;
pub(super) mod two_d;

use super::args::{Args, LightForm, ParseError};
use super::commands::Command;
use crate::error::Code;

type Parsed = Result<Command, ParseError>;

/// Checks that the number of remaining words is in `arity` (ascending), as the subject before them
/// requires; `what` is the subject, or the syntax of the whole line.
fn expect_left(args: &Args<'_>, arity: &[usize], what: &str) -> Result<(), ParseError> {
    if arity.contains(&args.left()) {
        return Ok(());
    }
    let most = arity.last().copied().unwrap_or(0);
    // The first word too many, or the last one before those that are missing.
    let blamed = match args.left() {
        0 => args.last(),
        left => args.nth_left(most.min(left - 1)),
    };
    let expected = arity.iter().map(usize::to_string).collect::<Vec<_>>().join(" or ");
    let message = match args.left() {
        left if left == args.count() => format!("takes {expected} arguments, not {left} ({what})"),
        left => format!("{what} takes {expected} more arguments, not {left}"),
    };
    Err(ParseError::new(Code::Args, message, blamed))
}

/// Returns the notation of the colours of light in the remaining words, whose number is in `arity`
/// when the one word of a colour is counted as the three reals that it stands for.
fn light_form(args: &Args<'_>, arity: &[usize], what: &str) -> Result<LightForm, ParseError> {
    let colors = args.color_words_left();
    let fits_words = colors > 0 && arity.contains(&(args.left() + 2 * colors));
    // If the count also fits plain numbers, words that are no colours are taken as misspelled
    // numbers.
    if fits_words && (!arity.contains(&args.left()) || args.color_words_are_colors()) {
        return Ok(LightForm::Words);
    }
    // Then the error names the word that is no number, not the count.
    expect_left(args, arity, what).map(|()| LightForm::Reals)
}

/// `on` or `off`.
fn switch(args: &mut Args<'_>) -> Result<bool, ParseError> {
    args.keyword("on or off", |word| match () {
        () if word.eq_ignore_ascii_case("on") => Some(true),
        () if word.eq_ignore_ascii_case("off") => Some(false),
        () => None,
    })
}

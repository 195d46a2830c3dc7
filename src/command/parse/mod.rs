//! From words to commands, one function a verb. The word counts of the table hold when these run; what a line means
//! beyond its own words (does the name exist, does the offset) is the engine's to say.

pub(super) mod control;
pub(super) mod memory;
pub(super) mod plane;
pub(super) mod space;

use super::args::{Args, LightForm, Refusal};
use super::model::Command;
use crate::error::Code;

type Parsed = Result<Command, Refusal>;

/// The words left, which must be one of `counts` as the subject before them says; `what` is the subject, or the whole line.
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
    let message = match args.left() {
        left if left == args.count() => format!("takes {wanted} arguments, not {left} ({what})"),
        left => format!("{what} takes {wanted} more arguments, not {left}"),
    };
    Err(Refusal::new(Code::Args, message, blamed))
}

/// How the colours of light are written in the words left, which are `counts` many when a colour's one word is counted as
/// the three reals that it stands for.
fn light_form(args: &Args<'_>, counts: &[usize], what: &str) -> Result<LightForm, Refusal> {
    let colors = args.color_words_left();
    let fits_words = colors > 0 && counts.contains(&(args.left() + 2 * colors));
    // Where there are as many words as numbers could be, words that are no colours are numbers gone wrong.
    if fits_words && (!counts.contains(&args.left()) || args.color_words_are_colors()) {
        return Ok(LightForm::Words);
    }
    // A word that is no number then gets the blame, not the count.
    expect_left(args, counts, what).map(|()| LightForm::Reals)
}

/// `on` or `off`.
fn switch(args: &mut Args<'_>) -> Result<bool, Refusal> {
    args.keyword("on or off", |word| match () {
        () if word.eq_ignore_ascii_case("on") => Some(true),
        () if word.eq_ignore_ascii_case("off") => Some(false),
        () => None,
    })
}

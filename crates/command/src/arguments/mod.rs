//! The kinds of arguments: how a field of a command is read from a line, checked and written.
//!
//! A field's type is its kind where that says everything (`i32`, `Rgba`, `Rect`, keywords); the
//! table names another one where it does not ([`numbers::Radius`] is an `i32` that must not be
//! negative). A new kind is one type here with [`Argument`] and [`TextArgument`].

mod colors;
mod keywords;
mod names;
mod numbers;
mod payloads;
mod rest_of_line;
mod shapes;
mod subjects;

pub(super) use colors::{ClearColor, LightColor, RawColor};
pub(super) use keywords::{BlendOver, FovMin, OnOff, ViewportKind, Wait};
pub(super) use names::{CanvasName, LoadName, TargetName, TextureName, load_names, write_load};
pub(super) use numbers::{
    Angle, Angles, ByteCount, ClipRect, LightIndex, LineWidth, Radii, Radius, RealRadius, Seconds, Side,
    TextScale,
};
pub(super) use payloads::{Bytes, HexBytes, Records, Run, Utf8, X3dFile, blit_length};
pub(super) use rest_of_line::RestOfLine;
pub(super) use subjects::{SceneTime, Sorted};

use super::args::{Args, LightForm, ParseError};
use super::encode::{EncodeError, LineWriter};
use super::plain_line::PlainWords;
use super::verb::{Arity, Parameter, ParameterKind, Payload};
use fbptr_core::error::{Code, Fault};

/// Checks and encodes one argument.
///
/// The checks are those of single values; each does nothing unless the kind says otherwise.
pub(super) trait Argument {
    /// Type of the field.
    type Value;
    /// Kind for programs that write commands.
    const KIND: ParameterKind;
    /// Numbers of words in a line.
    const WORDS: Arity = Arity::ZERO;
    /// Payload rule.
    const PAYLOAD: Payload = Payload::Never;

    /// Refuses numbers that are not finite.
    fn check_numbers(_: &Self::Value) -> Result<(), Fault> {
        Ok(())
    }

    /// Refuses negative sizes.
    fn check_sizes(_: &Self::Value) -> Result<(), Fault> {
        Ok(())
    }

    /// Refuses names that cannot stand in a line.
    fn check_names(_: &Self::Value) -> Result<(), Fault> {
        Ok(())
    }

    /// Refuses a payload of `length` bytes.
    fn check_length(_: &Self::Value, _length: u64) -> Result<(), Fault> {
        Ok(())
    }

    /// Refuses contents that no line can express.
    fn check_content(_: &Self::Value) -> Result<(), Fault> {
        Ok(())
    }

    /// Returns the payload.
    fn payload(_: &Self::Value) -> Option<&[u8]> {
        None
    }

    /// Returns the payload for writing.
    fn payload_mut(_: &mut Self::Value) -> Option<&mut Vec<u8>> {
        None
    }

    /// Appends the words, or the bytes of a binary command.
    fn write(value: &Self::Value, line: &mut LineWriter<'_>) -> Result<(), EncodeError>;
}

/// Reads an argument of a text command. The line's number of words has been checked.
pub(super) trait TextArgument: Argument {
    /// Checks the line's words before any of them is taken.
    fn expect(_: &Args<'_>) -> Result<(), ParseError> {
        Ok(())
    }

    /// Takes the argument's words. Returns an empty payload, whose bytes follow later.
    fn read(args: &mut Args<'_>) -> Result<Self::Value, ParseError>;

    /// Takes the argument's words of a plain line; `None` leaves the line to [`TextArgument::read`].
    fn read_plain(_: &mut PlainWords<'_>) -> Option<Self::Value> {
        None
    }
}

/// Creates the table's description of an argument.
pub(super) const fn parameter<A: Argument>(name: &'static str, syntax: &'static str) -> Parameter {
    Parameter { name, syntax, arity: A::WORDS, kind: A::KIND }
}

impl<A: Argument> Argument for Box<A>
where
    A: Argument<Value = A>,
{
    type Value = Box<A>;
    const KIND: ParameterKind = A::KIND;
    const WORDS: Arity = A::WORDS;
    const PAYLOAD: Payload = A::PAYLOAD;

    fn check_numbers(value: &Box<A>) -> Result<(), Fault> {
        A::check_numbers(value)
    }

    fn check_sizes(value: &Box<A>) -> Result<(), Fault> {
        A::check_sizes(value)
    }

    fn check_names(value: &Box<A>) -> Result<(), Fault> {
        A::check_names(value)
    }

    fn check_length(value: &Box<A>, length: u64) -> Result<(), Fault> {
        A::check_length(value, length)
    }

    fn check_content(value: &Box<A>) -> Result<(), Fault> {
        A::check_content(value)
    }

    fn payload(value: &Box<A>) -> Option<&[u8]> {
        A::payload(value)
    }

    fn payload_mut(value: &mut Box<A>) -> Option<&mut Vec<u8>> {
        A::payload_mut(value)
    }

    fn write(value: &Box<A>, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        A::write(value, line)
    }
}

impl<A> TextArgument for Box<A>
where
    A: TextArgument + Argument<Value = A>,
{
    fn expect(args: &Args<'_>) -> Result<(), ParseError> {
        A::expect(args)
    }

    fn read(args: &mut Args<'_>) -> Result<Box<A>, ParseError> {
        A::read(args).map(Box::new)
    }
}

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

/// Checks that numbers are finite, which those of typed commands may not be.
fn finite(numbers: &[f64]) -> Result<(), Fault> {
    match numbers.iter().find(|n| !n.is_finite()) {
        Some(n) => Err(Fault::new(Code::Num, "numbers must be finite").got(n.to_string())),
        None => Ok(()),
    }
}

/// Checks that a value is not negative.
fn from_zero<T: Into<f64> + Copy + std::fmt::Display>(what: &str, value: T) -> Result<(), Fault> {
    match value.into() < 0.0 {
        false => Ok(()),
        true => Err(Fault::new(Code::Range, format!("the {what} must be 0 or more")).got(value.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_count_is_that_of_the_line_or_of_what_follows_its_subject() {
        let refusal = |line: &[u8], taken: usize, arity: &[usize]| {
            let mut args = Args::new(line);
            for _ in 0..taken {
                args.word();
            }
            let error = expect_left(&args, arity, "sun").unwrap_err();
            format!("{} <{}>", error.message, String::from_utf8(error.token).unwrap())
        };
        assert_eq!(refusal(b" a b", 0, &[3, 5]), "takes 3 or 5 arguments, not 2 (sun) <b>");
        assert_eq!(refusal(b" a b", 1, &[3, 5]), "sun takes 3 or 5 more arguments, not 1 <b>");
        assert_eq!(refusal(b" a b c", 1, &[1]), "sun takes 1 more arguments, not 2 <c>");
        assert_eq!(refusal(b" a", 1, &[2]), "sun takes 2 more arguments, not 0 <a>");
    }
}

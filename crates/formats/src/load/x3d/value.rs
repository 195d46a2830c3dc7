//! Field values: attribute text to typed values.
//!
//! In: the text of an XML attribute. Out: a [`Value`], or an error with the byte offset in the
//! text. Lists are separated by white space and commas; every number must be finite.
//!
//! Source: ISO/IEC 19775-1 clause 5, ISO/IEC 19776-1 clause 5.

use fbptr_core::cancel::{CancelToken, NEVER};
use std::sync::Arc;

/// Numbers of a list between two checks of the token.
const NUMBERS_AT_ONCE: usize = 1 << 12;

/// X3D field type, as far as it determines the parsing. `Mf` is a list of any number of tuples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    /// SFBool.
    Bool,
    /// SFInt32.
    Int,
    /// MFInt32.
    Ints,
    /// SFImage: width, height, components, then one number per pixel.
    Image,
    /// SFFloat, SFDouble, SFTime (1), SFVec2f (2), SFVec3f and SFColor (3), SFVec4f, SFColorRGBA
    /// and SFRotation (4).
    Sf(u8),
    /// The MF types of these: any number of tuples of the given width.
    Mf(u8),
    /// SFString: the attribute's text unchanged.
    Text,
    /// MFString: quoted strings.
    Texts,
}

impl Kind {
    /// Returns a description of the type for messages.
    pub(super) fn describe(self) -> String {
        match self {
            Kind::Bool => "true or false".into(),
            Kind::Int => "one whole number".into(),
            Kind::Ints => "whole numbers".into(),
            Kind::Image => "width, height, components and one number a pixel".into(),
            Kind::Sf(1) => "one number".into(),
            Kind::Sf(n) => format!("{n} numbers"),
            Kind::Mf(1) => "numbers".into(),
            Kind::Mf(n) => format!("numbers in groups of {n}"),
            Kind::Text => "a string".into(),
            Kind::Texts => "quoted strings".into(),
        }
    }
}

/// Value of a field. Clones share the lists.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// SFBool.
    Bool(bool),
    /// SFInt32, MFInt32, SFImage.
    Ints(Arc<[i64]>),
    /// All types made of reals, tuples one after the other.
    Reals(Arc<[f64]>),
    /// SFString.
    Text(Arc<str>),
    /// MFString.
    Texts(Arc<[String]>),
}

/// Error in an attribute's text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ValueError {
    /// Byte offset of the error in the text.
    pub(super) at: usize,
    /// Kind of the error.
    pub(super) fault: ValueFault,
}

/// Kinds of [`ValueError`].
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ValueFault {
    /// A token that is not a finite number.
    NotANumber(String),
    /// A token that is not a 32-bit integer.
    NotAnInt(String),
    /// A token that is neither true nor false.
    NotABool(String),
    /// The wrong count of numbers; contains the count found.
    Count(usize),
    /// A quoted string that does not end.
    OpenQuote,
}

/// Parses an attribute's text as `kind`.
pub(super) fn read(kind: Kind, text: &str) -> Result<Value, ValueError> {
    read_until(kind, text, &NEVER)
}

/// Parses an attribute's text as `kind`, checking `cancel` within lists. After cancellation the
/// list ends early and the value must not be used.
pub(super) fn read_until(kind: Kind, text: &str, cancel: &CancelToken) -> Result<Value, ValueError> {
    let ints = |range: std::ops::RangeInclusive<i64>| {
        let all = until_cancelled(tokens(text), cancel).map(|(at, t)| int(at, t, range.clone()));
        Ok(Value::Ints(all.collect::<Result<Vec<_>, _>>()?.into()))
    };
    match kind {
        Kind::Bool => {
            let (at, token) = single(text)?;
            match () {
                _ if token.eq_ignore_ascii_case("true") => Ok(Value::Bool(true)),
                _ if token.eq_ignore_ascii_case("false") => Ok(Value::Bool(false)),
                _ => Err(ValueError { at, fault: ValueFault::NotABool(token.into()) }),
            }
        }
        Kind::Int => {
            let (at, token) = single(text)?;
            Ok(Value::Ints([int(at, token, i32::MIN as i64..=i32::MAX as i64)?].into()))
        }
        Kind::Ints => ints(i32::MIN.into()..=i32::MAX.into()),
        Kind::Image => ints(0..=u32::MAX.into()),
        Kind::Sf(n) => {
            let reals = reals(text, cancel)?;
            match reals.len() == n as usize {
                true => Ok(Value::Reals(reals.into())),
                false => Err(ValueError { at: 0, fault: ValueFault::Count(reals.len()) }),
            }
        }
        Kind::Mf(n) => {
            let reals = reals(text, cancel)?;
            match reals.len().is_multiple_of(n as usize) {
                true => Ok(Value::Reals(reals.into())),
                false => Err(ValueError { at: 0, fault: ValueFault::Count(reals.len()) }),
            }
        }
        Kind::Text => Ok(Value::Text(text.into())),
        Kind::Texts => strings(text).map(|s| Value::Texts(s.into())),
    }
}

/// Iterates over the tokens of a list with their byte offsets; white space and commas separate.
fn tokens(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split(|c: char| c.is_ascii_whitespace() || c == ',')
        .filter(|t| !t.is_empty())
        .map(|t| (t.as_ptr() as usize - text.as_ptr() as usize, t))
}

/// Ends an iterator when `cancel` is cancelled, which is checked every [`NUMBERS_AT_ONCE`] items.
fn until_cancelled<T>(items: impl Iterator<Item = T>, cancel: &CancelToken) -> impl Iterator<Item = T> {
    let goes_on = |(i, _): &(usize, T)| i % NUMBERS_AT_ONCE != 0 || !cancel.is_cancelled();
    items.enumerate().take_while(goes_on).map(|(_, item)| item)
}

/// Returns the only token of a text, or an error with the count.
fn single(text: &str) -> Result<(usize, &str), ValueError> {
    let mut all = tokens(text);
    match (all.next(), all.next()) {
        (Some(token), None) => Ok(token),
        (first, _) => {
            Err(ValueError { at: 0, fault: ValueFault::Count(all.count() + 2 * first.is_some() as usize) })
        }
    }
}

fn reals(text: &str, cancel: &CancelToken) -> Result<Vec<f64>, ValueError> {
    let real = |(at, token): (usize, &str)| match token.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(ValueError { at, fault: ValueFault::NotANumber(token.into()) }),
    };
    until_cancelled(tokens(text), cancel).map(real).collect()
}

/// Parses an integer, decimal or 0x hexadecimal, within `range`.
fn int(at: usize, token: &str, range: std::ops::RangeInclusive<i64>) -> Result<i64, ValueError> {
    let unsigned = token.trim_start_matches(['+', '-']);
    let parsed = match unsigned.strip_prefix("0x").or_else(|| unsigned.strip_prefix("0X")) {
        Some(digits) if token.len() == unsigned.len() && digits.bytes().all(|b| b.is_ascii_hexdigit()) => {
            i64::from_str_radix(digits, 16).ok()
        }
        Some(_) => None,
        None => token.parse().ok(),
    };
    match parsed {
        Some(number) if range.contains(&number) => Ok(number),
        _ => Err(ValueError { at, fault: ValueFault::NotAnInt(token.into()) }),
    }
}

/// Parses an MFString: `"a" "b"`, with `\"` and `\\` as escapes. A text that does not begin with a
/// quote is one string, as in many files.
fn strings(text: &str) -> Result<Vec<String>, ValueError> {
    let trimmed = text.trim();
    if trimmed.is_empty() {
        return Ok(Vec::new());
    }
    if !trimmed.starts_with('"') {
        return Ok(vec![trimmed.to_string()]);
    }
    let mut found = Vec::new();
    let mut open: Option<(usize, String)> = None;
    let mut characters = text.char_indices();
    while let Some((at, c)) = characters.next() {
        match (&mut open, c) {
            (None, '"') => open = Some((at, String::new())),
            (None, _) => {}
            (Some((_, string)), '\\') => match characters.next() {
                Some((_, escaped @ ('"' | '\\'))) => string.push(escaped),
                Some((_, other)) => string.extend(['\\', other]),
                None => string.push('\\'),
            },
            (Some((_, string)), '"') => {
                found.push(std::mem::take(string));
                open = None;
            }
            (Some((_, string)), other) => string.push(other),
        }
    }
    match open {
        Some((at, _)) => Err(ValueError { at, fault: ValueFault::OpenQuote }),
        None => Ok(found),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(kind: Kind, text: &str) -> (usize, ValueFault) {
        let error = read(kind, text).unwrap_err();
        (error.at, error.fault)
    }

    #[test]
    fn long_lists_end_when_they_are_cancelled() {
        let (text, token) = ("7 ".repeat(3 * NUMBERS_AT_ONCE), CancelToken::new());
        let count = |kind| match read_until(kind, &text, &token).unwrap() {
            Value::Ints(ints) => ints.len(),
            Value::Reals(reals) => reals.len(),
            other => panic!("{other:?}"),
        };
        for kind in [Kind::Ints, Kind::Image, Kind::Mf(1)] {
            assert_eq!(count(kind), 3 * NUMBERS_AT_ONCE, "{kind:?}");
        }
        // Somebody cancels while a number of the second part is read.
        let items = (0..3 * NUMBERS_AT_ONCE).inspect(|i| {
            if *i == NUMBERS_AT_ONCE + 9 {
                token.cancel()
            }
        });
        assert_eq!(until_cancelled(items, &token).count(), 2 * NUMBERS_AT_ONCE);
        for kind in [Kind::Ints, Kind::Image, Kind::Mf(1)] {
            assert_eq!(count(kind), 0, "{kind:?}");
        }
    }

    #[test]
    fn lists_are_split_by_blanks_and_commas_alike() {
        let expected = Value::Reals([1.0, -0.5, 3e-7, 0.5].into());
        for text in ["1 -.5 3e-7 .5", "1,-.5,3e-7,.5", " 1 , -.5,\t3E-7 ,,\n.5,", "+1. -5e-1 .0000003 00.5"] {
            assert_eq!(read(Kind::Sf(4), text).unwrap(), expected, "{text:?}");
        }
        assert_eq!(read(Kind::Ints, "0, 1 -1,0xff").unwrap(), Value::Ints([0, 1, -1, 255].into()));
        assert_eq!(
            read(Kind::Image, "1 1 4 0xFFFFFFFF").unwrap(),
            Value::Ints([1, 1, 4, 0xffff_ffff].into())
        );
        assert_eq!(read(Kind::Mf(3), "").unwrap(), Value::Reals([].into()));
        assert_eq!(read(Kind::Bool, " TRUE ").unwrap(), Value::Bool(true));
    }

    #[test]
    fn what_is_no_finite_number_is_refused_at_its_byte() {
        for word in ["nan", "inf", "-Infinity", "1e999", "0x10", "1,2x", "--1"] {
            let (at, fault) = fault(Kind::Mf(1), &format!("1 {word}"));
            assert!(matches!(fault, ValueFault::NotANumber(_)), "{word}: {fault:?}");
            assert!(at >= 2, "{word}");
        }
        assert_eq!(fault(Kind::Ints, "0 1.5"), (2, ValueFault::NotAnInt("1.5".into())));
        assert_eq!(fault(Kind::Ints, "0x-1").1, ValueFault::NotAnInt("0x-1".into()));
        assert_eq!(fault(Kind::Ints, "2147483648").1, ValueFault::NotAnInt("2147483648".into()));
        assert_eq!(fault(Kind::Image, "-1").1, ValueFault::NotAnInt("-1".into()));
        assert_eq!(fault(Kind::Sf(3), "1 2"), (0, ValueFault::Count(2)));
        assert_eq!(fault(Kind::Mf(3), "1 2 3 4"), (0, ValueFault::Count(4)));
        assert_eq!(fault(Kind::Int, ""), (0, ValueFault::Count(0)));
        assert_eq!(fault(Kind::Int, "1 2 3"), (0, ValueFault::Count(3)));
        assert_eq!(fault(Kind::Bool, "yes").1, ValueFault::NotABool("yes".into()));
    }

    #[test]
    fn strings_are_quoted_or_one() {
        let read = |text| match read(Kind::Texts, text).unwrap() {
            Value::Texts(texts) => texts.to_vec(),
            other => panic!("{other:?}"),
        };
        assert_eq!(read(r#" "a b.png" , "c\"d\\e\n" "#), ["a b.png", "c\"d\\e\\n"]);
        assert_eq!(read("child file.x3d"), ["child file.x3d"]);
        assert_eq!(read(r#""""#), [""]);
        assert!(read("  ").is_empty());
        assert_eq!(fault(Kind::Texts, r#""a" "b"#), (4, ValueFault::OpenQuote));
    }
}

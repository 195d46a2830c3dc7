//! The words of one text line: numbers, colours, keywords and names, each refused with the word that is to blame.
//!
//! In: a line without its LF, CR and `:N`. Words are split by blanks and tabs. Whole numbers are `[+-]?digits` in i32,
//! reals are decimal with an optional exponent and finite once parsed; nothing else is a number.

use super::scan::find_blank;
use crate::error::Code;
use crate::memory::{Rgba, parse_color, parse_light_color};
use glam::DVec3;
use std::borrow::Cow;

/// Why a command is refused: the decoder's form of [`crate::error::Fault`], with the word as the bytes that came.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ParseError {
    pub code: Code,
    pub message: Cow<'static, str>,
    pub token: Vec<u8>,
}

impl ParseError {
    pub fn new(code: Code, message: impl Into<Cow<'static, str>>, token: &[u8]) -> Self {
        ParseError { code, message: message.into(), token: token.to_vec() }
    }
}

/// Blanks and tabs part words; everything else is part of one.
pub(super) const fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}

/// The words of `line`.
pub(super) fn words(line: &[u8]) -> impl DoubleEndedIterator<Item = &[u8]> {
    line.split(|&b| is_blank(b)).filter(|w| !w.is_empty())
}

/// How many words there are: how often a word's byte follows a blank. Short sums in bytes, without a branch, for the
/// compiler to make vectors of.
fn count_words(line: &[u8]) -> usize {
    let first = line.first().is_some_and(|&b| !is_blank(b));
    let Some(rest) = line.get(1..) else { return 0 };
    let begins = |(&a, &b): (&u8, &u8)| u8::from(is_blank(a) & !is_blank(b));
    let chunks = line.chunks(192).zip(rest.chunks(192));
    usize::from(first)
        + chunks.map(|(a, b)| usize::from(a.iter().zip(b).map(begins).sum::<u8>())).sum::<usize>()
}

/// The words after the verb, taken one by one.
pub(super) struct Args<'a> {
    rest: &'a [u8],
    taken: usize,
    count: usize,
    last: &'a [u8],
}

impl<'a> Args<'a> {
    /// The arguments in `rest`, which begins after the verb.
    pub fn new(rest: &'a [u8]) -> Self {
        Args { rest, taken: 0, count: count_words(rest), last: b"" }
    }

    /// How many words the line has after its verb.
    pub fn count(&self) -> usize {
        self.count
    }

    /// How many words have not been taken yet.
    pub fn left(&self) -> usize {
        self.count - self.taken
    }

    /// The next word without taking it; empty when there is none.
    pub fn peek(&self) -> &'a [u8] {
        words(self.rest).next().unwrap_or(b"")
    }

    /// Word number `n` after the verb, counted from 0 before any was taken; empty when there is none.
    pub fn nth_left(&self, n: usize) -> &'a [u8] {
        words(self.rest).nth(n).unwrap_or(b"")
    }

    /// The word taken last.
    pub fn last(&self) -> &'a [u8] {
        self.last
    }

    /// The next word; empty when there is none, which is no number, colour, keyword or name.
    pub fn word(&mut self) -> &'a [u8] {
        // One blank before the word and eight bytes at most are what nearly every word comes with.
        let start = match self.rest {
            [first, second, ..] if is_blank(*first) && !is_blank(*second) => 1,
            rest => rest.iter().position(|&b| !is_blank(b)).unwrap_or(rest.len()),
        };
        let word = &self.rest[start..];
        let end = find_blank(word).unwrap_or(word.len());
        self.rest = &word[end..];
        self.taken += usize::from(end > 0);
        self.last = &word[..end];
        self.last
    }

    fn refuse<T>(&self, code: Code, what: &str, word: &[u8]) -> Result<T, ParseError> {
        Err(ParseError::new(code, format!("argument {} must be {what}", self.taken), word))
    }

    /// A whole number in i32.
    pub fn int(&mut self) -> Result<i32, ParseError> {
        let word = self.word();
        match parse_int(word) {
            Some(n) => Ok(n),
            None => self.refuse(Code::Num, "a whole number from -2147483648 to 2147483647", word),
        }
    }

    /// `N` whole numbers.
    pub fn ints<const N: usize>(&mut self) -> Result<[i32; N], ParseError> {
        let mut numbers = [0; N];
        for n in &mut numbers {
            *n = self.int()?;
        }
        Ok(numbers)
    }

    /// A whole number from 0 on.
    pub fn count_number(&mut self) -> Result<u32, ParseError> {
        let word = self.peek();
        match u32::try_from(self.int()?) {
            Ok(n) => Ok(n),
            Err(_) => self.refuse(Code::Range, "0 or more", word),
        }
    }

    /// A finite real.
    pub fn real(&mut self) -> Result<f64, ParseError> {
        let word = self.word();
        match parse_real(word) {
            Some(n) => Ok(n),
            None => self.refuse(Code::Num, "a finite decimal number", word),
        }
    }

    /// `N` finite reals.
    pub fn reals<const N: usize>(&mut self) -> Result<[f64; N], ParseError> {
        let mut numbers = [0.0; N];
        for n in &mut numbers {
            *n = self.real()?;
        }
        Ok(numbers)
    }

    /// Three finite reals.
    pub fn vector(&mut self) -> Result<DVec3, ParseError> {
        Ok(DVec3::from_array(self.reals()?))
    }

    /// A colour.
    pub fn color(&mut self) -> Result<Rgba, ParseError> {
        let word = self.word();
        match parse_color(word) {
            Some(color) => Ok(color),
            None => self.refuse(
                Code::Colour,
                "a colour: gg, rrggbb or rrggbbaa in hex, or a CSS colour name",
                word,
            ),
        }
    }

    /// A colour of light: three finite reals, or one word where `form` says that words may stand for them.
    pub fn light_color(&mut self, form: LightForm) -> Result<DVec3, ParseError> {
        if form == LightForm::Reals || !may_be_color(self.peek()) {
            return self.vector();
        }
        let word = self.word();
        match parse_light_color(word) {
            Some(color) => Ok(DVec3::from_array(color)),
            None => self.refuse(
                Code::Colour,
                "a colour of light: three reals, a CSS colour name, or gg or rrggbb in hex after #",
                word,
            ),
        }
    }

    /// How many of the words left stand where a number cannot: those of colours.
    pub fn color_words_left(&self) -> usize {
        words(self.rest).filter(|word| may_be_color(word)).count()
    }

    /// Whether all of them are colours of light.
    pub fn color_words_are_colors(&self) -> bool {
        words(self.rest).filter(|word| may_be_color(word)).all(|word| parse_light_color(word).is_some())
    }

    /// A keyword that `find` knows, in either case. `expected` lists the keywords.
    pub fn keyword<T>(&mut self, expected: &str, find: impl Fn(&str) -> Option<T>) -> Result<T, ParseError> {
        let word = self.word();
        match std::str::from_utf8(word).ok().and_then(find) {
            Some(value) => Ok(value),
            None => self.refuse(Code::Args, expected, word),
        }
    }

    /// Whether the next word is `keyword`, in either case; takes it then.
    pub fn take_keyword(&mut self, keyword: &str) -> bool {
        let found = self.peek().eq_ignore_ascii_case(keyword.as_bytes());
        if found {
            self.word();
        }
        found
    }

    /// A name: UTF-8 without control characters, and not one that would read as a payload length.
    pub fn name(&mut self) -> Result<String, ParseError> {
        let word = self.word();
        match std::str::from_utf8(word) {
            Ok(name) if is_name(name) => Ok(name.to_owned()),
            _ => self.refuse(Code::Args, "a name of printable UTF-8 that does not begin with a colon", word),
        }
    }
}

/// How the colours of light in a line are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LightForm {
    /// Each as three reals.
    Reals,
    /// Some as one word.
    Words,
}

/// Whether a word is meant as a colour where a real could stand: no real begins like this.
fn may_be_color(word: &[u8]) -> bool {
    word.first().is_some_and(|&b| b == b'#' || b.is_ascii_alphabetic())
}

/// Whether a text can stand as a name in a line: one word, no control characters, no `:` before more.
pub(super) fn is_name(name: &str) -> bool {
    !name.is_empty()
        && (name == ":" || !name.starts_with(':'))
        && !name.bytes().any(|b| b <= b' ' || b == 0x7f)
}

/// `[+-]?digits` in i32.
pub(super) fn parse_int(word: &[u8]) -> Option<i32> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() {
        return None;
    }
    if digits.len() <= 9 {
        let mut value = 0;
        let mut all = true;
        for d in digits.iter().map(|d| d.wrapping_sub(b'0')) {
            all &= d <= 9;
            value = value * 10 + i32::from(d & 15);
        }
        return all.then_some(if negative { -value } else { value });
    }
    let mut value: i32 = 0;
    for &d in digits {
        let d = d.wrapping_sub(b'0');
        if d > 9 {
            return None;
        }
        // Down from zero where the sign says so: i32::MIN has no positive twin.
        let d = i32::from(d);
        value = value.checked_mul(10)?.checked_add(if negative { -d } else { d })?;
    }
    Some(value)
}

/// `[+-]?digits[.digits][e[+-]digits]`, finite once rounded to f64. `inf`, `nan`, hex and `_` are no numbers.
pub(super) fn parse_real(word: &[u8]) -> Option<f64> {
    let unsigned = match word {
        [b'+' | b'-', rest @ ..] => rest,
        rest => rest,
    };
    // What is left of the standard grammar without its words.
    if !matches!(unsigned.first(), Some(b'0'..=b'9' | b'.')) {
        return None;
    }
    std::str::from_utf8(word).ok()?.parse().ok().filter(|n: &f64| n.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_signed_digits_in_i32_and_nothing_else() {
        for (word, n) in [
            ("0", 0),
            ("-0", 0),
            ("+7", 7),
            ("007", 7),
            ("2147483647", i32::MAX),
            ("-2147483648", i32::MIN),
            ("00000000000000000002147483647", i32::MAX),
        ] {
            assert_eq!(parse_int(word.as_bytes()), Some(n), "{word}");
        }
        for word in
            ["", "+", "-", "--1", "+-1", "1-", "1.0", "1e3", "0x1", "2147483648", "-2147483649", "٣", " 1"]
        {
            assert_eq!(parse_int(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn reals_are_decimal_and_finite() {
        for (word, n) in [
            ("1", 1.0),
            ("-1.5", -1.5),
            ("+.5", 0.5),
            ("5.", 5.0),
            ("1e3", 1000.0),
            ("1E-3", 0.001),
            ("-2.5e+2", -250.0),
            ("1e-999", 0.0),
            ("179769313486231570814527423731704356798070e267", f64::MAX),
        ] {
            assert_eq!(parse_real(word.as_bytes()), Some(n), "{word}");
        }
        assert!(parse_real(b"-0").is_some_and(|n| n.is_sign_negative()));
        for word in [
            "",
            "+",
            "-",
            ".",
            "e5",
            "1e",
            "1e+",
            "inf",
            "-inf",
            "nan",
            "NaN",
            "+infinity",
            "1e999",
            "-1e999",
            "0x10",
            "1_0",
            "1,5",
            "1f",
            "..5",
            "1.5.2",
            "--1",
            "é",
        ] {
            assert_eq!(parse_real(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn words_are_counted_and_taken_one_by_one() {
        let mut args = Args::new(b"\t 1  two\t3 ");
        assert_eq!((args.count(), args.left(), args.peek()), (3, 3, &b"1"[..]));
        assert_eq!(args.int().unwrap(), 1);
        assert_eq!((args.left(), args.nth_left(1)), (2, &b"3"[..]));
        let parse_error = args.int().unwrap_err();
        assert_eq!((parse_error.code, parse_error.token.as_slice()), (Code::Num, &b"two"[..]));
        assert!(parse_error.message.starts_with("argument 2 "), "{}", parse_error.message);
        assert_eq!(args.word(), b"3");
        assert_eq!((args.word(), args.left()), (&b""[..], 0));
    }

    #[test]
    fn names_are_one_printable_word() {
        for good in ["a", "@shared", "é", "a:b", ":", "OFF", "\"q\""] {
            assert!(is_name(good), "{good}");
        }
        for bad in ["", ":5", ":x", "a b", "a\tb", "a\r", "\u{7f}"] {
            assert!(!is_name(bad), "{bad:?}");
        }
    }
}

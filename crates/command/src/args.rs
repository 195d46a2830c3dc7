//! Parser for the words of one text line: numbers, colours, keywords and names. Each error carries
//! the offending word.
//!
//! In: a line without its LF, CR and `:N`. Words are separated by blanks and tabs. Integers are
//! `[+-]?digits` in i32; reals are decimal with an optional exponent and finite once parsed;
//! nothing else is a number.

use super::scan::{find_blank, letters};
use fbptr_core::error::Code;
use fbptr_core::memory::{Rgba, parse_color, parse_light_color};
use glam::DVec3;
use std::borrow::Cow;

/// Reason why a command is refused: the decoder's form of [`fbptr_core::error::Fault`], with the
/// word as raw bytes.
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

/// Returns whether a byte separates words: a blank or a tab.
pub(super) const fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}

/// Iterates over the words of `line`.
pub(super) fn words(line: &[u8]) -> impl DoubleEndedIterator<Item = &[u8]> {
    line.split(|&b| is_blank(b)).filter(|w| !w.is_empty())
}

/// Counts the words of a line: the positions where a byte of a word follows a blank. The sums are
/// short, in bytes and without a branch, so that the compiler vectorizes them.
fn count_words(line: &[u8]) -> usize {
    let first = line.first().is_some_and(|&b| !is_blank(b));
    let Some(rest) = line.get(1..) else { return 0 };
    let begins = |(&a, &b): (&u8, &u8)| u8::from(is_blank(a) & !is_blank(b));
    let chunks = line.chunks(192).zip(rest.chunks(192));
    usize::from(first)
        + chunks.map(|(a, b)| usize::from(a.iter().zip(b).map(begins).sum::<u8>())).sum::<usize>()
}

/// Bytes of a line whose words are known as bits at a time.
const WINDOW: usize = 64;

/// Cursor over the words after the verb.
pub(super) struct Args<'a> {
    rest: &'a [u8],
    /// Bytes of words at the beginning of `rest`, the first as the lowest bit, and how many bytes that
    /// tells about; no bit is set beyond.
    letters: u64,
    known: usize,
    taken: usize,
    count: usize,
    last: &'a [u8],
}

impl<'a> Args<'a> {
    /// Creates a cursor over `rest`, the line after its verb.
    pub fn new(rest: &'a [u8]) -> Self {
        let mut args = Args { rest, letters: 0, known: 0, taken: 0, count: 0, last: b"" };
        args.look_ahead();
        args.count = match rest.len() <= WINDOW {
            true => (args.letters & !(args.letters << 1)).count_ones() as usize,
            false => count_words(rest),
        };
        args
    }

    /// Creates a cursor over the words behind a line's verb. Returns the verb, too: an empty word if
    /// the line has none.
    pub fn of_line(line: &'a [u8]) -> (&'a [u8], Self) {
        let mut args = Args::new(line);
        let verb = args.word();
        (args.count, args.taken, args.last) = (args.left(), 0, b"");
        (verb, args)
    }

    /// Finds the words of the bytes to come.
    fn look_ahead(&mut self) {
        self.known = self.rest.len().min(WINDOW);
        self.letters = letters(&self.rest[..self.known]);
    }

    /// Returns what is not taken yet, blanks included.
    pub fn unread(&self) -> &'a [u8] {
        self.rest
    }

    /// Returns where the last word begins in what is not taken yet, and where it ends.
    fn bounds_of_final(&self) -> (usize, usize) {
        if self.known == self.rest.len() && self.letters != 0 {
            let beyond = self.letters.leading_zeros();
            let length = (!(self.letters << beyond)).leading_zeros();
            return ((64 - beyond - length) as usize, (64 - beyond) as usize);
        }
        let end = self.rest.iter().rposition(|&b| !is_blank(b)).map_or(0, |n| n + 1);
        (self.rest[..end].iter().rposition(|&b| is_blank(b)).map_or(0, |n| n + 1), end)
    }

    /// Returns the last word without taking it, or an empty slice if none is left.
    pub fn final_word(&self) -> &'a [u8] {
        let (start, end) = self.bounds_of_final();
        &self.rest[start..end]
    }

    /// Drops the last word, if one is left.
    pub fn drop_final(&mut self) {
        if self.left() > 0 {
            let (start, _) = self.bounds_of_final();
            self.rest = &self.rest[..start];
            self.count -= 1;
            self.look_ahead();
        }
    }

    /// Returns the number of words after the verb.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the number of words not taken yet.
    pub fn left(&self) -> usize {
        self.count - self.taken
    }

    /// Returns the next word without taking it, or an empty slice at the end.
    pub fn peek(&self) -> &'a [u8] {
        let (start, end) = self.bounds_of_next();
        &self.rest[start..end]
    }

    /// Returns the word `n` places after the next one without taking it, or an empty slice past the
    /// end.
    pub fn nth_left(&self, n: usize) -> &'a [u8] {
        words(self.rest).nth(n).unwrap_or(b"")
    }

    /// Returns the word taken last.
    pub fn last(&self) -> &'a [u8] {
        self.last
    }

    /// Returns where the next word begins and ends, both at the end of the line if there is none.
    #[inline]
    fn bounds_of_next(&self) -> (usize, usize) {
        let start = self.letters.trailing_zeros();
        let end = start + (!self.letters.unbounded_shr(start)).trailing_zeros().min(64 - start);
        match self.known == self.rest.len() || (end as usize) < self.known {
            true => ((start as usize).min(self.known), (end as usize).min(self.known)),
            false => self.bounds_beyond(),
        }
    }

    /// [`Args::bounds_of_next`] where the word reaches beyond the known bytes.
    #[cold]
    fn bounds_beyond(&self) -> (usize, usize) {
        let start = self.rest.iter().position(|&b| !is_blank(b)).unwrap_or(self.rest.len());
        (start, find_blank(&self.rest[start..]).map_or(self.rest.len(), |length| start + length))
    }

    /// Takes the next word. Returns an empty slice at the end, which parses as no number, colour,
    /// keyword or name.
    #[inline]
    pub fn word(&mut self) -> &'a [u8] {
        let (start, end) = self.bounds_of_next();
        self.last = &self.rest[start..end];
        self.rest = &self.rest[end..];
        self.taken += usize::from(end > start);
        match end < self.known {
            true => {
                self.letters >>= end;
                self.known -= end;
            }
            false => self.look_ahead(),
        }
        self.last
    }

    /// Takes all of the line after the blank that follows the word taken last, blanks included.
    pub fn rest(&mut self) -> &'a [u8] {
        let rest = match self.rest {
            [first, rest @ ..] if is_blank(*first) => rest,
            rest => rest,
        };
        (self.rest, self.taken, self.last) = (b"", self.count, rest);
        self.look_ahead();
        rest
    }

    /// Returns the error for the word taken last, which must be `what`.
    pub fn refuse<T>(&self, code: Code, what: &str, word: &[u8]) -> Result<T, ParseError> {
        Err(ParseError::new(code, format!("argument {} must be {what}", self.taken), word))
    }

    /// Takes an integer in i32.
    pub fn int(&mut self) -> Result<i32, ParseError> {
        let word = self.word();
        match parse_int(word) {
            Some(n) => Ok(n),
            None => self.refuse(Code::Num, "a whole number from -2147483648 to 2147483647", word),
        }
    }

    /// Takes `N` integers in i32.
    pub fn ints<const N: usize>(&mut self) -> Result<[i32; N], ParseError> {
        let mut numbers = [0; N];
        for n in &mut numbers {
            *n = self.int()?;
        }
        Ok(numbers)
    }

    /// Takes an integer that is not negative.
    pub fn count_number(&mut self) -> Result<u32, ParseError> {
        let word = self.peek();
        match u32::try_from(self.int()?) {
            Ok(n) => Ok(n),
            Err(_) => self.refuse(Code::Range, "0 or more", word),
        }
    }

    /// Takes a finite real.
    pub fn real(&mut self) -> Result<f64, ParseError> {
        let word = self.word();
        match parse_real(word) {
            Some(n) => Ok(n),
            None => self.refuse(Code::Num, "a finite decimal number", word),
        }
    }

    /// Takes an angle: a finite real in radians, or in degrees before `deg`. Returns radians.
    pub fn angle(&mut self) -> Result<f64, ParseError> {
        let word = self.word();
        let radians = match word {
            [digits @ .., b'd' | b'D', b'e' | b'E', b'g' | b'G'] => parse_real(digits).map(f64::to_radians),
            digits => parse_real(digits),
        };
        match radians {
            Some(n) => Ok(n),
            None => {
                self.refuse(Code::Num, "an angle: a finite decimal number, in radians or before deg", word)
            }
        }
    }

    /// Takes `N` finite reals.
    pub fn reals<const N: usize>(&mut self) -> Result<[f64; N], ParseError> {
        let mut numbers = [0.0; N];
        for n in &mut numbers {
            *n = self.real()?;
        }
        Ok(numbers)
    }

    /// Takes three finite reals.
    pub fn vector(&mut self) -> Result<DVec3, ParseError> {
        Ok(DVec3::from_array(self.reals()?))
    }

    /// Takes a colour: hex digits or a CSS colour name.
    pub fn color(&mut self) -> Result<Rgba, ParseError> {
        let word = self.word();
        match parse_color(word) {
            Some(color) => Ok(color),
            None => self.refuse(
                Code::Colour,
                "a colour: gg, rrggbb or rrggbbaa in hex, #rgb or a CSS colour name",
                word,
            ),
        }
    }

    /// Takes a colour of light: three finite reals, or one word where `form` allows words.
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

    /// Returns how many of the remaining words begin as a colour does and a number cannot.
    pub fn color_words_left(&self) -> usize {
        words(self.rest).filter(|word| may_be_color(word)).count()
    }

    /// Returns whether all of these words are valid colours of light.
    pub fn color_words_are_colors(&self) -> bool {
        words(self.rest).filter(|word| may_be_color(word)).all(|word| parse_light_color(word).is_some())
    }

    /// Takes the next word if it is `keyword`, in either case, and returns whether it was.
    pub fn take_keyword(&mut self, keyword: &str) -> bool {
        let found = self.peek().eq_ignore_ascii_case(keyword.as_bytes());
        if found {
            self.word();
        }
        found
    }

    /// Takes a name: UTF-8 without control characters that does not read as a payload length.
    pub fn name(&mut self) -> Result<String, ParseError> {
        let word = self.word();
        match std::str::from_utf8(word) {
            Ok(name) if is_name(name) => Ok(name.to_owned()),
            _ => self.refuse(Code::Args, "a name of printable UTF-8 that does not begin with a colon", word),
        }
    }
}

/// Notation of the colours of light in a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LightForm {
    /// Each colour as three reals.
    Reals,
    /// Some colours as one word.
    Words,
}

/// Returns whether a word in the place of a real is meant as a colour: no real begins with `#` or a
/// letter.
fn may_be_color(word: &[u8]) -> bool {
    word.first().is_some_and(|&b| b == b'#' || b.is_ascii_alphabetic())
}

/// Returns whether a text can be a name in a line: one word without control characters, `:` alone
/// or not beginning with `:`.
pub(super) fn is_name(name: &str) -> bool {
    !name.is_empty()
        && (name == ":" || !name.starts_with(':'))
        && !name.bytes().any(|b| b <= b' ' || b == 0x7f)
}

/// Parses `[+-]?digits` in i32.
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
        // Negative numbers are summed downwards: i32::MIN has no positive counterpart.
        let d = i32::from(d);
        value = value.checked_mul(10)?.checked_add(if negative { -d } else { d })?;
    }
    Some(value)
}

/// Parses `[+-]?digits[.digits][e[+-]digits]`, finite once rounded to f64. `inf`, `nan`, hex and
/// `_` are refused.
pub(super) fn parse_real(word: &[u8]) -> Option<f64> {
    let (is_negative, unsigned) = match word {
        [sign @ (b'+' | b'-'), rest @ ..] => (*sign == b'-', rest),
        rest => (false, rest),
    };
    if let Some(n) = short_decimal(unsigned) {
        return Some(if is_negative { -n } else { n });
    }
    // Rules out the `inf` and `nan` that Rust's own grammar accepts.
    if !matches!(unsigned.first(), Some(b'0'..=b'9' | b'.')) {
        return None;
    }
    std::str::from_utf8(word).ok()?.parse().ok().filter(|n: &f64| n.is_finite())
}

/// Parses `digits[.digits]` of up to 15 digits; `None` for every other word. Exact: the digits and the
/// power of ten are both f64 numbers, so that one division rounds correctly (Clinger, "How to Read
/// Floating Point Numbers Accurately", 1990).
fn short_decimal(word: &[u8]) -> Option<f64> {
    if word.is_empty() || word.len() > 16 {
        return None;
    }
    let (mut digits, mut count, mut point) = (0_u64, 0_usize, None);
    for (i, byte) in word.iter().enumerate() {
        match byte.wrapping_sub(b'0') {
            digit @ 0..=9 => {
                digits = digits * 10 + u64::from(digit);
                count += 1;
            }
            _ if *byte == b'.' && point.is_none() => point = Some(i),
            _ => return None,
        }
    }
    match point {
        _ if count == 0 || count > 15 => None,
        None => Some(digits as f64),
        Some(point) => Some(digits as f64 / POWERS_OF_TEN[word.len() - 1 - point]),
    }
}

/// 10^0 to 10^15.
const POWERS_OF_TEN: [f64; 16] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_decimals_are_the_numbers_of_the_standard_library() {
        let mut seed = 7_u64;
        let mut next = |below: u64| {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) % below
        };
        for _ in 0..20_000 {
            let count = 1 + next(18) as usize;
            let mut word: String = (0..count).map(|_| char::from(b'0' + next(10) as u8)).collect();
            if next(3) > 0 {
                word.insert(next(count as u64 + 1) as usize, '.');
            }
            let expected: f64 = word.parse().unwrap();
            assert_eq!(parse_real(word.as_bytes()).map(f64::to_bits), Some(expected.to_bits()), "{word}");
            let short = short_decimal(word.as_bytes());
            assert!(short.is_none_or(|n| n.to_bits() == expected.to_bits()), "{word}");
            assert_eq!(short.is_some(), count <= 15, "{word}");
        }
    }

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
    fn angles_are_radians_or_degrees() {
        let angle = |word: &str| Args::new(word.as_bytes()).angle().ok();
        for (word, radians) in [
            ("1.5", 1.5),
            ("180deg", std::f64::consts::PI),
            ("-90DEG", -std::f64::consts::FRAC_PI_2),
            ("4.5e1deg", std::f64::consts::FRAC_PI_4),
            ("0deg", 0.0),
        ] {
            assert_eq!(angle(word), Some(radians), "{word}");
        }
        for word in ["deg", "45 deg", "45degdeg", "45de", "infdeg", "1e999deg", "45rad", "45°"] {
            let whole = word.split(' ').count() == 1;
            assert!(angle(word).is_none() || !whole, "{word}");
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
    fn lines_of_every_length_have_the_words_of_a_plain_split() {
        let mut seed = 5_u64;
        let mut next = |below: u64| {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) % below
        };
        for length in 0..300 {
            for share in [2, 5, 40, 400] {
                let line: Vec<u8> = (0..length)
                    .map(|_| if next(share) == 0 { b" \t"[next(2) as usize] } else { 33 + next(200) as u8 })
                    .collect();
                let expected: Vec<&[u8]> = words(&line).collect();
                let mut args = Args::new(&line);
                assert_eq!(
                    (args.count(), args.final_word()),
                    (expected.len(), words(&line).next_back().unwrap_or(b""))
                );
                for (at, word) in expected.iter().enumerate() {
                    assert_eq!((args.left(), args.peek(), args.word()), (expected.len() - at, *word, *word));
                    assert_eq!(
                        args.final_word(),
                        if at + 1 < expected.len() { expected[expected.len() - 1] } else { b"" }
                    );
                }
                assert_eq!((args.word(), args.left()), (&b""[..], 0));
                let (verb, mut args) = Args::of_line(&line);
                args.drop_final();
                let inner = expected.get(1..expected.len().max(2) - 1).unwrap_or(&[]);
                assert_eq!((verb, args.count()), (*expected.first().unwrap_or(&&b""[..]), inner.len()));
                assert_eq!(words(args.unread()).collect::<Vec<_>>(), inner);
                inner.iter().for_each(|word| assert_eq!(args.word(), *word));
            }
        }
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

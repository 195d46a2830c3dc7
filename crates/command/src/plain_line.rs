//! Reader of plainly written figures: one pass over the bytes of a line, without a search for its end.
//!
//! In: a stream from a command boundary on. Accepted here: a figure's verb, its words with one blank
//! before each, LF or CR LF; the kinds of arguments say how their words are read
//! ([`TextArgument::read_plain`](super::arguments::TextArgument::read_plain)). Whole numbers of up to
//! seven digits and colours `rrggbb` are read as words of eight bytes; other reals and colours go
//! through the parsers of single words. Out: the figure, and the length of its line. Anything else
//! (other verbs, two blanks, tabs, a wrong number of words, what a check refuses, an incomplete line)
//! is left to the general reader, which alone makes errors. So both must agree on what is accepted
//! here: `tests/decoder` hears each stream whole and byte by byte, which never comes here.

use super::args::parse_real;
use super::commands::Figure;
use super::encode::MAX_LINE_BYTES;
use super::pixel_lexer::portable::color as hex_color;
use super::scan::find_lf;
use super::verb::{KEY_BYTES, Verb};
use fbptr_core::memory::{Rgba, parse_color};
use std::num::NonZero;

/// Reads the words after a verb.
pub(super) type ReadPlain<F> = fn(&mut PlainWords<'_>) -> Option<F>;

/// Bytes below which a stream's rest is read from a padded copy: words are read eight bytes at a time.
const WINDOW: usize = 64;

/// Reads the figure at the beginning of `bytes`. Returns the length of its line, too.
#[inline]
pub(super) fn figure(bytes: &[u8]) -> Option<(Figure, usize)> {
    if bytes.len() < WINDOW {
        return last_figure(bytes);
    }
    figure_in(bytes)
}

/// [`figure`] near the end of what has arrived. The zeros after it end no word and no line.
#[cold]
fn last_figure(bytes: &[u8]) -> Option<(Figure, usize)> {
    let mut padded = [0; 2 * WINDOW];
    padded[..bytes.len()].copy_from_slice(bytes);
    figure_in(&padded)
}

#[inline(always)]
fn figure_in(bytes: &[u8]) -> Option<(Figure, usize)> {
    let (read, length) = Verb::find_plain(bytes.first_chunk::<KEY_BYTES>()?)?;
    let mut words = PlainWords::new(bytes.get(length + 1..)?);
    let figure = read(&mut words)?;
    let used = bytes.len() - words.after_line()?.len();
    (used <= MAX_LINE_BYTES).then_some((figure, used))
}

/// The words of a plain line that are not taken yet.
pub(super) struct PlainWords<'a> {
    /// The bytes from the next word on.
    rest: &'a [u8],
    /// The byte before them, which ended the word taken last.
    end: u8,
}

/// The lowest bit of every byte, and the highest.
const LOW: u64 = 0x0101_0101_0101_0101;
const HIGH: u64 = 0x8080_8080_8080_8080;

impl<'a> PlainWords<'a> {
    /// Creates the words of a stream after a verb and its blank.
    pub fn new(rest: &'a [u8]) -> Self {
        PlainWords { rest, end: b' ' }
    }

    /// Returns whether a word follows in the line.
    #[inline(always)]
    pub fn has_more(&self) -> bool {
        self.end == b' '
    }

    /// Returns the stream after the line, if all of its words have been taken.
    #[inline(always)]
    fn after_line(self) -> Option<&'a [u8]> {
        match self.end {
            b'\n' => Some(self.rest),
            b'\r' => self.rest.strip_prefix(b"\n"),
            _ => None,
        }
    }

    /// Takes one to seven digits, and the byte after them.
    #[inline(always)]
    fn digits(&mut self) -> Option<u32> {
        let word = u64::from_le_bytes(*self.rest.first_chunk()?);
        // Digits become 0 to 9, which stay below 0x80 when 0x76 is added; other bytes do not, or have
        // that bit already.
        let values = word ^ (LOW * b'0' as u64);
        let others = NonZero::new((values.wrapping_add(LOW * 0x76) | values) & HIGH)?;
        // The first other byte has its flag at bit 8 n + 7 after n digits.
        let flag = others.trailing_zeros();
        if flag < 15 {
            return None;
        }
        self.end = (word >> (flag - 7)) as u8;
        self.rest = &self.rest[flag as usize / 8 + 1..];
        // The last digit moves to the highest byte, zeros before the first.
        let digits = values << (71 - flag);
        // Of the digits abcdefgh: 10 a + b in every other byte, then 100 ab + cd in 16 bits of 32.
        let pairs = (digits.wrapping_mul(10) + (digits >> 8)) & 0x00ff_00ff_00ff_00ff;
        let fours = (pairs.wrapping_mul(100) + (pairs >> 16)) & 0x0000_ffff_0000_ffff;
        Some((fours.wrapping_mul(10_000) + (fours >> 32)) as u32)
    }

    /// Returns whether a minus sign follows, and takes it.
    #[inline(always)]
    fn minus(&mut self) -> bool {
        match self.rest {
            [b'-', rest @ ..] => {
                self.rest = rest;
                true
            }
            _ => false,
        }
    }

    /// Takes a whole number.
    #[inline]
    pub fn int(&mut self) -> Option<i32> {
        if !self.has_more() {
            return None;
        }
        let is_negative = self.minus();
        let number = self.digits()? as i32;
        Some(if is_negative { -number } else { number })
    }

    /// Takes a real.
    #[inline]
    pub fn real(&mut self) -> Option<f64> {
        if !self.has_more() {
            return None;
        }
        let start = self.rest;
        let is_negative = self.minus();
        match self.digits() {
            Some(number) if ends_word(self.end) => {
                let number = f64::from(number);
                Some(if is_negative { -number } else { number })
            }
            _ => {
                self.rest = start;
                parse_real(self.word()?)
            }
        }
    }

    /// Takes a colour.
    #[inline]
    pub fn color(&mut self) -> Option<Rgba> {
        if !self.has_more() {
            return None;
        }
        let start = self.rest;
        let digits = if let [b'#', digits @ ..] = start { digits } else { start };
        let word = u64::from_le_bytes(*digits.first_chunk()?);
        let end = (word >> 48) as u8;
        match hex_color::<6>(word << 16) {
            Some(color) if ends_word(end) => {
                (self.rest, self.end) = (&digits[7..], end);
                Some(color)
            }
            _ => parse_color(self.word()?),
        }
    }

    /// Takes the rest of the line, which does not begin with a blank.
    pub fn rest(&mut self) -> Option<&'a [u8]> {
        let lf = find_lf(self.rest)?;
        let (text, rest) = (&self.rest[..lf], &self.rest[lf + 1..]);
        let text = text.strip_suffix(b"\r").unwrap_or(text);
        let begins = self.has_more() && !matches!(text, [] | [b' ' | b'\t', ..]);
        (self.rest, self.end) = (rest, b'\n');
        begins.then_some(text)
    }

    /// Takes the next word, and the byte after it.
    fn word(&mut self) -> Option<&'a [u8]> {
        let length = self.rest.iter().position(|&byte| ends_word(byte))?;
        let word = &self.rest[..length];
        self.end = self.rest[length];
        self.rest = &self.rest[length + 1..];
        Some(word)
    }
}

/// Returns whether a byte may end a word. After a tab nothing is plain.
#[inline(always)]
fn ends_word(byte: u8) -> bool {
    matches!(byte, b' ' | b'\n' | b'\r' | b'\t')
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the length of the line that is read plainly at the beginning of a stream.
    fn length_of(stream: &str) -> Option<usize> {
        let long = format!("{stream}{}", "x".repeat(2 * WINDOW));
        let found = figure(stream.as_bytes());
        assert_eq!(found, figure(long.as_bytes()), "{stream:?}");
        found.map(|(_, length)| length)
    }

    #[test]
    fn plain_lines_are_read_to_their_end() {
        for line in [
            "LINE 0 0 63 47 #ff0000\n",
            "line -1 1234567 63 47 ff0000 #0000ff\r\n",
            "FILL 1 2 3 4 5.5 6 red lime #00f\n",
            "FILLRECT 8 6 40 30.25 #ffffff80\n",
            "FILLELLIPSE 32 24 30 18.5 008080\n",
            "POLY white 8 6 40 10 20 40\n",
            "PRINT 2 2 #ffffff hello, world :5\n",
        ] {
            assert_eq!(length_of(line), Some(line.len()), "{line:?}");
            assert_eq!(length_of(&format!("{line}PX 1 2 ff0000\n")), Some(line.len()), "{line:?}");
            for cut in 0..line.len() {
                assert_eq!(figure(&line.as_bytes()[..cut]), None, "{line:?} {cut}");
            }
        }
    }

    #[test]
    fn all_other_lines_are_left_to_the_general_reader() {
        for line in [
            " LINE 0 0 63 47 #ff0000\n",
            "LINE  0 0 63 47 #ff0000\n",
            "LINE\t0 0 63 47 #ff0000\n",
            "LINE 0 0 63 47 #ff0000 \n",
            "LINE 0 0 63 47\n",
            "LINE 0 0 63 47 #ff0000 #ff0000 1\n",
            "LINE 0 +0 63 47 #ff0000\n",
            "LINE 0 00000000 63 47 #ff0000\n",
            "LINE 0 0 63 47 #ff000g\n",
            "CIRCLE 1 1 -1 #ff0000\n",
            "FILLRECT 8 6 40 -30 #ffffff\n",
            "POLY white 8 6 40\n",
            "PRINT 2 2 #ffffff  hello\n",
            "PRINT 2 2 #ffffff he\u{1}llo\n",
            "PX 1 2 ff0000 and more\n",
            "TEXT 2 2 white :5\nhello",
            "#INE 0 0 63 47 #ff0000\n",
        ] {
            assert_eq!(length_of(line), None, "{line:?}");
        }
    }
}

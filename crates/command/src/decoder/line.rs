//! Decoding of one complete text line: its payload length, its verb, its arguments.

use super::{Decoder, DecoderState};
use crate::args::{Args, ParseError, is_blank};
use crate::codec::Parse;
use crate::commands::Command;
use crate::sink::Sink;
use crate::stream_error::{StreamError, Subject};
use crate::verb::{Payload, Verb};
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::{Rgba, parse_color};

/// UTF-8's byte order mark, which some editors put before a file's text: skipped there.
#[doc(hidden)]
pub const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

impl Decoder {
    /// Reads one complete line without its end; `rest` is the input after it. Returns the number of
    /// payload bytes read from `rest`.
    pub(super) fn line(&mut self, line: &[u8], rest: &[u8], sink: &mut impl Sink) -> usize {
        let line = match self.start.byte {
            0 => line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line),
            _ => line,
        };
        let (word, mut args) = Args::of_line(line);
        // A line of one word may be a second CR.
        if line.first() == Some(&b'#') || args.count() == 0 && is_idle(line) {
            return 0;
        }
        let found = Verb::find_parser(word);
        let is_text = found.is_some_and(|(verb, _)| verb.takes_rest_of_line());
        let last = if args.count() == 0 { word } else { args.final_word() };
        let payload_length = match last {
            [b':', digits @ ..] if !digits.is_empty() && !is_text => match payload_length(digits) {
                PayloadLength::Length(n) => Some(n),
                PayloadLength::Beyond => {
                    let message = "a payload's length must be below 2^64";
                    let parse_error = ParseError::new(Code::Proto, message, last);
                    let mut error = StreamError::new(self.start, Subject::of(word), parse_error);
                    error.closes = true;
                    self.state = DecoderState::Closed;
                    // The sink's answer does not matter: no later command of this stream can be
                    // found.
                    let _ = sink.error(error);
                    return 0;
                }
                PayloadLength::Junk => {
                    let message = "the last word after a colon must be a payload's length";
                    self.error(Subject::of(word), ParseError::new(Code::Proto, message, last), sink);
                    return 0;
                }
            },
            _ => None,
        };
        if payload_length.is_some() {
            args.drop_final();
        }
        let arguments = args.unread();
        let length = payload_length.unwrap_or(0);
        if length > self.limits.payload_bytes {
            return self.refuse_payload(Subject::of(word), length, rest, sink);
        }
        let Some((verb, parse)) = found else {
            let parse_error = ParseError::new(Code::Verb, "unknown verb", word);
            return self.refuse(Subject::of(word), parse_error, length, rest, sink);
        };
        match read_command(verb, parse, args, payload_length, word) {
            Ok(Command::Pixel { x, y, color }) => {
                sink.pixel(x, y, color);
                0
            }
            Ok(command) => self.payload(command, length, rest, sink),
            Err(parse_error) => match self.grey_pixel(verb, arguments, &parse_error) {
                Some((x, y, color)) => {
                    sink.pixel(x, y, color);
                    0
                }
                None => self.refuse(Subject::Known(verb), parse_error, length, rest, sink),
            },
        }
    }

    /// Returns a `PX` whose colour is one hex digit, if those are accepted. It runs after the
    /// normal parser has refused the line, so that no other line pays for the check.
    fn grey_pixel(
        &self,
        verb: &Verb,
        arguments: &[u8],
        parse_error: &ParseError,
    ) -> Option<(i32, i32, Rgba)> {
        let [digit] = parse_error.token[..] else { return None };
        if !self.takes_grey_digits || verb.name != "PX" || parse_error.code != Code::Colour {
            return None;
        }
        let color = parse_color(&[digit, digit])?;
        let [x, y] = Args::new(arguments).ints().ok()?;
        Some((x, y, color))
    }
}

/// Returns a line without its final CR, if it has one.
pub(super) fn without_cr(line: &[u8]) -> &[u8] {
    line.strip_suffix(b"\r").unwrap_or(line)
}

/// Returns whether a line does nothing: a comment, or blanks alone.
pub(super) fn is_idle(line: &[u8]) -> bool {
    line.first() == Some(&b'#') || without_cr(line).iter().all(|&b| is_blank(b))
}

/// Payload length of a line, from the bytes after the colon of its last word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PayloadLength {
    Length(u64),
    /// Digits, but 2^64 or more.
    Beyond,
    /// Not a number.
    Junk,
}

fn payload_length(digits: &[u8]) -> PayloadLength {
    let mut length = PayloadLength::Length(0);
    for digit in digits {
        length = length.with(*digit);
    }
    length
}

impl PayloadLength {
    /// Appends one more byte after the colon.
    pub(crate) fn with(self, byte: u8) -> Self {
        let digit = u64::from(byte.wrapping_sub(b'0'));
        match self {
            _ if digit > 9 => PayloadLength::Junk,
            PayloadLength::Length(n) => match n.checked_mul(10).and_then(|n| n.checked_add(digit)) {
                Some(n) => PayloadLength::Length(n),
                None => PayloadLength::Beyond,
            },
            other => other,
        }
    }
}

/// Parses a text command's arguments, after a check of their number against the table.
pub(super) fn read_command(
    verb: &'static Verb,
    parse: Parse<Command>,
    mut args: Args<'_>,
    payload: Option<u64>,
    word: &[u8],
) -> Result<Command, ParseError> {
    let rest = args.unread();
    if !verb.arity.allows(args.count()) {
        return Err(wrong_count(verb, &args, word));
    }
    match (verb.payload, payload) {
        (Payload::Never, Some(length)) => return Err(unwanted(length)),
        (Payload::Always, None) => return Err(missing(&args, word)),
        _ => {}
    }
    // Checked in place: moving the command out of its Result and back would copy it twice.
    let parsed = parse(&mut args);
    if let Ok(command) = &parsed {
        if verb.payload == Payload::BySubject {
            match (command.payload().is_some(), payload) {
                (false, Some(length)) => return Err(unwanted(length)),
                (true, None) => return Err(missing(&Args::new(rest), word)),
                _ => {}
            }
        }
        command.validate_head(payload.unwrap_or(0)).map_err(parse_error)?;
    }
    parsed
}

/// Converts an error of [`Command::validate`] or its parts to the decoder's form.
pub(super) fn parse_error(fault: Fault) -> ParseError {
    ParseError {
        code: fault.code,
        message: fault.message.into(),
        token: fault.token.unwrap_or_default().into(),
    }
}

/// Returns the error for a wrong number of words.
fn wrong_count(verb: &Verb, args: &Args<'_>, word: &[u8]) -> ParseError {
    let found = args.count();
    let most = verb.arity.most().unwrap_or(usize::MAX);
    // The first word too many, or the last one before those that are missing.
    let blamed = match found.min(most) {
        0 if found == 0 => word,
        n if found > most => args.nth_left(n),
        n => args.nth_left(n - 1),
    };
    let syntax = verb.forms.first().map_or("", |f| f.syntax);
    ParseError::new(Code::Args, format!("takes {}, not {found} ({syntax})", verb.arity.in_words()), blamed)
}

/// Returns the error for a payload that the verb does not take.
fn unwanted(length: u64) -> ParseError {
    ParseError::new(Code::Args, "takes no payload", format!(":{length}").as_bytes())
}

/// Returns the error for a line that announces no payload where one is required.
fn missing(args: &Args<'_>, word: &[u8]) -> ParseError {
    let last = if args.count() == 0 { word } else { args.nth_left(args.count() - 1) };
    ParseError::new(Code::Args, "the line must end with a payload's length :N", last)
}

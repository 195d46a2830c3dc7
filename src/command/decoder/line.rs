//! One whole line: the length that it announces, its verb, its words.

use super::{Decoder, State};
use crate::command::args::{Args, Refusal, is_blank};
use crate::command::model::Command;
use crate::command::sink::Sink;
use crate::command::stream_error::{StreamError, Subject};
use crate::command::verb::{Counts, Payload, Reading, Verb};
use crate::error::{Code, Fault};
use crate::memory::{Rgba, parse_color};

impl Decoder {
    /// Reads one whole line without its end; `rest` is what follows it in the same piece.
    /// Answers how many bytes of `rest` the payload took.
    pub(super) fn line(&mut self, line: &[u8], rest: &[u8], sink: &mut impl Sink) -> usize {
        if is_idle(line) {
            return 0;
        }
        let verb_start = line.iter().position(|&b| !is_blank(b)).unwrap_or(0);
        let verb_end =
            line[verb_start..].iter().position(|&b| is_blank(b)).map_or(line.len(), |n| verb_start + n);
        let word = &line[verb_start..verb_end];
        let last_end = line.iter().rposition(|&b| !is_blank(b)).map_or(0, |n| n + 1);
        let last_start = line[..last_end].iter().rposition(|&b| is_blank(b)).map_or(0, |n| n + 1);
        let announced = match &line[last_start..last_end] {
            [b':', digits @ ..] if !digits.is_empty() => match announced(digits) {
                Announced::Length(n) => Some(n),
                Announced::Beyond => {
                    let refusal = Refusal::new(
                        Code::Proto,
                        "a payload's length must be below 2^64",
                        &line[last_start..last_end],
                    );
                    let mut error = StreamError::new(self.start, Subject::of(word), refusal);
                    error.closes = true;
                    self.state = State::Closed;
                    // Whatever it answers: no later command of this stream can be found.
                    let _ = sink.error(error);
                    return 0;
                }
                Announced::Junk => {
                    let message = "the last word after a colon must be a payload's length";
                    let refusal = Refusal::new(Code::Proto, message, &line[last_start..last_end]);
                    self.error(Subject::of(word), refusal, sink);
                    return 0;
                }
            },
            _ => None,
        };
        let arguments = match announced {
            Some(_) => &line[verb_end.min(last_start)..last_start],
            None => &line[verb_end..],
        };
        let length = announced.unwrap_or(0);
        if length > self.limits.payload_bytes {
            return self.refuse_payload(Subject::of(word), length, rest, sink);
        }
        let Some(verb) = Verb::find(word) else {
            let refusal = Refusal::new(Code::Verb, "unknown verb", word);
            return self.refuse(Subject::of(word), refusal, length, rest, sink);
        };
        match read_command(verb, arguments, announced, word) {
            Ok(Command::Pixel { x, y, color }) => {
                sink.pixel(x, y, color);
                0
            }
            Ok(command) => self.payload(command, length, rest, sink),
            Err(refusal) => match self.grey_pixel(verb, arguments, &refusal) {
                Some((x, y, color)) => {
                    sink.pixel(x, y, color);
                    0
                }
                None => self.refuse(Subject::Known(verb), refusal, length, rest, sink),
            },
        }
    }

    /// A `PX` whose colour is one hex digit, where those are taken: refused as any other word first, so that nothing else
    /// pays for it.
    fn grey_pixel(&self, verb: &Verb, arguments: &[u8], refusal: &Refusal) -> Option<(i32, i32, Rgba)> {
        let [digit] = refusal.token[..] else { return None };
        if !self.takes_grey_digits || verb.name != "PX" || refusal.code != Code::Colour {
            return None;
        }
        let color = parse_color(&[digit, digit])?;
        let [x, y] = Args::new(arguments).ints().ok()?;
        Some((x, y, color))
    }
}

/// A line without the CR before its LF, if it has one.
pub(super) fn without_cr(line: &[u8]) -> &[u8] {
    line.strip_suffix(b"\r").unwrap_or(line)
}

/// Whether a line does nothing: a comment, or blanks alone.
pub(super) fn is_idle(line: &[u8]) -> bool {
    line.first() == Some(&b'#') || without_cr(line).iter().all(|&b| is_blank(b))
}

/// What a last word after its colon announces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::command) enum Announced {
    Length(u64),
    /// Digits, and too many.
    Beyond,
    /// No length.
    Junk,
}

fn announced(digits: &[u8]) -> Announced {
    let mut length = Announced::Length(0);
    for digit in digits {
        length = length.with(*digit);
    }
    length
}

impl Announced {
    /// One more byte after the colon and what came before.
    pub(in crate::command) fn with(self, byte: u8) -> Self {
        let digit = u64::from(byte.wrapping_sub(b'0'));
        match self {
            _ if digit > 9 => Announced::Junk,
            Announced::Length(n) => match n.checked_mul(10).and_then(|n| n.checked_add(digit)) {
                Some(n) => Announced::Length(n),
                None => Announced::Beyond,
            },
            other => other,
        }
    }
}

/// Reads a text command's words, the table's counts first.
fn read_command(
    verb: &'static Verb,
    rest: &[u8],
    payload: Option<u64>,
    word: &[u8],
) -> Result<Command, Refusal> {
    let mut args = Args::new(rest);
    if !verb.counts.allows(args.count()) {
        return Err(wrong_count(verb, &args, word));
    }
    match (verb.payload, payload) {
        (Payload::Never, Some(length)) => return Err(unwanted(length)),
        (Payload::Always, None) => return Err(missing(&args, word)),
        _ => {}
    }
    let Reading::Text(parse) = verb.reading else {
        return Err(Refusal::new(Code::Verb, "unknown verb", word));
    };
    // Looked at where it is: taking it out of its Result and putting it back would copy it twice.
    let parsed = parse(&mut args);
    if let Ok(command) = &parsed {
        if verb.payload == Payload::BySubject {
            match (command.payload().is_some(), payload) {
                (false, Some(length)) => return Err(unwanted(length)),
                (true, None) => return Err(missing(&Args::new(rest), word)),
                _ => {}
            }
        }
        let checked = command.check_sizes().and_then(|()| command.check_payload_length(payload.unwrap_or(0)));
        checked.map_err(refusal)?;
    }
    parsed
}

pub(super) fn refusal(fault: Fault) -> Refusal {
    Refusal { code: fault.code, message: fault.message.into(), token: fault.token.unwrap_or_default().into() }
}

fn wrong_count(verb: &Verb, args: &Args<'_>, word: &[u8]) -> Refusal {
    let found = args.count();
    let most = match verb.counts {
        Counts::Of(counts) => counts.last().copied().unwrap_or(0),
        Counts::From(_) => usize::MAX,
    };
    // The first word too many, or the last one before those that are missing.
    let blamed = match found.min(most) {
        0 if found == 0 => word,
        n if found > most => args.nth_left(n),
        n => args.nth_left(n - 1),
    };
    let syntax = verb.forms.first().map_or("", |f| f.syntax);
    Refusal::new(Code::Args, format!("takes {}, not {found} ({syntax})", verb.counts.in_words()), blamed)
}

fn unwanted(length: u64) -> Refusal {
    Refusal::new(Code::Args, "takes no payload", format!(":{length}").as_bytes())
}

fn missing(args: &Args<'_>, word: &[u8]) -> Refusal {
    let last = if args.count() == 0 { word } else { args.nth_left(args.count() - 1) };
    Refusal::new(Code::Args, "the line must end with a payload's length :N", last)
}

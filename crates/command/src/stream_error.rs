//! Decoding errors, and their text on the wire and on `play`'s stderr.
//!
//! `ERR <line> <byte> <CODE> <VERB>: message, got "token"`, one ASCII line under 1,000 bytes. A
//! token is cut at `TOKEN_BYTES` bytes; its bytes beyond printable ASCII, `"` and `\` are written
//! as `\xNN`.

use super::args::ParseError;
use super::suggest::nearest_verb;
use super::verb::Verb;
use fbptr_core::error::{Code, Fault};
use std::borrow::Cow;
use std::fmt::{self, Write};

/// Longest part of a token that an error line shows, in bytes.
pub const TOKEN_BYTES: usize = 40;

/// Exclusive limit of an error line's length in bytes, LF not counted.
pub const LINE_BYTES: usize = 1000;

/// Position of a command in its stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StreamPosition {
    /// Line number from 1: LF bytes before the position plus one, those in payloads and binary
    /// commands included.
    pub line: u64,
    /// Number of bytes before the position.
    pub byte: u64,
}

impl StreamPosition {
    /// Beginning of every stream.
    pub const START: StreamPosition = StreamPosition { line: 1, byte: 0 };
}

/// Verb of a refused command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A verb of the table.
    Known(&'static Verb),
    /// A word that is no verb: its first `TOKEN_BYTES` bytes, unchanged.
    Unknown(Vec<u8>),
}

impl Subject {
    /// Returns the subject of a line that begins with `word`.
    pub(super) fn of(word: &[u8]) -> Self {
        match Verb::find(word) {
            Some(verb) => Subject::Known(verb),
            None => Subject::Unknown(word[..word.len().min(TOKEN_BYTES)].to_vec()),
        }
    }

    /// Returns the name for an error line: one ASCII word.
    pub fn name(&self) -> Cow<'static, str> {
        match self {
            Subject::Known(verb) => Cow::Borrowed(verb.name),
            Subject::Unknown(word) if word.is_empty() => Cow::Borrowed("-"),
            Subject::Unknown(word) => Cow::Owned(escape(word)),
        }
    }
}

/// Error about a command that the decoder refuses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamError {
    /// Position where the command begins.
    pub place: StreamPosition,
    /// Verb of the command.
    pub subject: Subject,
    /// Error code.
    pub code: Code,
    /// Expected input: lower case, one line.
    pub message: Cow<'static, str>,
    /// Offending input: its first `TOKEN_BYTES` bytes, unchanged.
    pub token: Vec<u8>,
    /// True if the stream cannot be decoded any further: the connection is to be closed.
    pub closes: bool,
}

impl fmt::Display for StreamError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.play_line("-"))
    }
}

impl std::error::Error for StreamError {}

impl StreamError {
    pub(super) fn new(place: StreamPosition, subject: Subject, parse_error: ParseError) -> Self {
        let ParseError { code, message, mut token } = parse_error;
        token.truncate(TOKEN_BYTES);
        StreamError { place, subject, code, message, token, closes: false }
    }

    /// Returns whether no verb of the table has this name.
    pub fn is_unknown_verb(&self) -> bool {
        matches!(self.subject, Subject::Unknown(_))
    }

    /// Returns whether a connection that used only Pixelflut verbs before still counts as such: an
    /// unknown verb does not count as used.
    pub fn is_pixelflut(&self) -> bool {
        match &self.subject {
            Subject::Known(verb) => verb.is_pixelflut(),
            Subject::Unknown(_) => true,
        }
    }

    /// Returns the error line for a connection, without LF.
    pub fn wire_line(&self) -> String {
        format_error(self.place, &self.subject.name(), self.code, &self.message, Some(&self.token))
    }

    /// Returns the error line for `play`, without LF.
    pub fn play_line(&self, file: &str) -> String {
        format_play_error(file, self.place, &self.subject.name(), self.code, &self.message, Some(&self.token))
    }
}

impl From<&StreamError> for Fault {
    fn from(error: &StreamError) -> Self {
        Fault {
            code: error.code,
            message: error.message.clone().into_owned(),
            token: Some(String::from_utf8_lossy(&error.token).into_owned()),
        }
    }
}

/// Formats `ERR <line> <byte> <CODE> <VERB>: message, got "token"`, without LF: one ASCII line
/// under `LINE_BYTES`.
pub fn format_error(
    place: StreamPosition,
    verb: &str,
    code: Code,
    message: &str,
    token: Option<&[u8]>,
) -> String {
    let head = format!("ERR {} {} {code} {}", place.line, place.byte, one_word(verb));
    with_reason(head, &with_suggestion(code, verb, message), token)
}

/// Formats the wire line for an error of the engine.
pub fn format_fault(place: StreamPosition, verb: &str, fault: &Fault) -> String {
    format_error(place, verb, fault.code, &fault.message, fault.token.as_ref().map(String::as_bytes))
}

/// Formats `FILE:LINE: CODE VERB: message, got "token"`, without LF: what `play` writes to
/// stderr after the program's name. The file's name is not escaped.
pub fn format_play_error(
    file: &str,
    place: StreamPosition,
    verb: &str,
    code: Code,
    message: &str,
    token: Option<&[u8]>,
) -> String {
    let message = with_suggestion(code, verb, message);
    format!("{file}:{}: {}", place.line, with_reason(format!("{code} {}", one_word(verb)), &message, token))
}

/// Formats `play`'s line for an error of the engine.
pub fn format_play_fault(file: &str, place: StreamPosition, verb: &str, fault: &Fault) -> String {
    format_play_error(
        file,
        place,
        verb,
        fault.code,
        &fault.message,
        fault.token.as_ref().map(String::as_bytes),
    )
}

/// Appends a suggestion to the message about an unknown verb, if one verb is near.
fn with_suggestion<'a>(code: Code, verb: &str, message: &'a str) -> Cow<'a, str> {
    // A known verb may refuse a name of a verb, as `HELP` does.
    let near = if code == Code::Verb { nearest_verb(verb) } else { None }.filter(|near| *near != verb);
    near.map_or(Cow::Borrowed(message), |near| Cow::Owned(format!("{message} (did you mean {near}?)")))
}

/// Formats `head: message, got "token"`; the message is cut so that the line stays under
/// `LINE_BYTES`.
fn with_reason(head: String, message: &str, token: Option<&[u8]>) -> String {
    let got =
        token.map_or(String::new(), |t| format!(", got \"{}\"", escape(&t[..t.len().min(TOKEN_BYTES)])));
    let mut line = head;
    line.push_str(": ");
    let room = LINE_BYTES - 1 - line.len() - got.len();
    let mut message: Cow<'_, str> = match message.bytes().all(|b| (b' '..=b'~').contains(&b)) {
        true => Cow::Borrowed(message),
        false => Cow::Owned(printable(message.as_bytes())),
    };
    if message.len() > room {
        message.to_mut().truncate(room - 3);
        message.to_mut().push_str("...");
    }
    line.push_str(&message);
    line.push_str(&got);
    line
}

/// Returns a verb's name as one printable word of bounded length.
fn one_word(verb: &str) -> String {
    let word: Vec<u8> =
        verb.bytes().map(|b| if b == b' ' { b'_' } else { b }).take(4 * TOKEN_BYTES).collect();
    printable(&word)
}

/// Returns printable ASCII unchanged and other bytes as `\xNN`.
fn printable(bytes: &[u8]) -> String {
    written(bytes, |b| (b' '..=b'~').contains(&b))
}

/// Returns printable ASCII except `"` and `\` unchanged, other bytes as `\xNN`.
fn escape(bytes: &[u8]) -> String {
    written(bytes, |b| (b' '..=b'~').contains(&b) && b != b'"' && b != b'\\')
}

/// Returns the bytes for which `plain` holds unchanged and other bytes as `\xNN`.
fn written(bytes: &[u8], plain: impl Fn(u8) -> bool) -> String {
    let mut text = String::with_capacity(bytes.len());
    for &b in bytes {
        match plain(b) {
            true => text.push(b as char),
            false => write!(text, "\\x{b:02x}").expect("a String takes all text"),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: StreamPosition = StreamPosition { line: 3, byte: 41 };

    #[test]
    fn the_line_has_the_form_of_the_specification() {
        let line = format_error(HERE, "LINE", Code::Num, "argument 1 must be a whole number", Some(b"1.5"));
        assert_eq!(line, "ERR 3 41 ENUM LINE: argument 1 must be a whole number, got \"1.5\"");
        let line = format_play_error("a b.fbs", HERE, "PX", Code::Colour, "not a colour", Some(b"zz"));
        assert_eq!(line, "a b.fbs:3: ECOLOUR PX: not a colour, got \"zz\"");
        let fault = Fault::new(Code::NoEnt, "no such mesh");
        assert_eq!(format_fault(HERE, "DRAW", &fault), "ERR 3 41 ENOENT DRAW: no such mesh");
        assert_eq!(format_play_fault("-", HERE, "DRAW", &fault), "-:3: ENOENT DRAW: no such mesh");
    }

    #[test]
    fn an_unknown_verb_comes_with_the_nearest_one() {
        let line = format_error(HERE, "LIEN", Code::Verb, "unknown verb", Some(b"LIEN"));
        assert_eq!(line, "ERR 3 41 EVERB LIEN: unknown verb (did you mean LINE?), got \"LIEN\"");
        let line = format_error(HERE, "FOO", Code::Verb, "unknown verb", Some(b"FOO"));
        assert_eq!(line, "ERR 3 41 EVERB FOO: unknown verb, got \"FOO\"");
    }

    #[test]
    fn a_token_is_cut_at_40_bytes_and_escaped() {
        let token = "\"\\\t\u{e9}~".repeat(20);
        let line = format_error(HERE, "X", Code::Verb, "m", Some(token.as_bytes()));
        let shown = r#"\x22\x5c\x09\xc3\xa9~"#.repeat(6) + r"\x22\x5c\x09\xc3";
        assert_eq!(line, format!("ERR 3 41 EVERB X: m, got \"{shown}\""));
    }

    #[test]
    fn the_longest_line_is_ascii_and_under_1000_bytes() {
        let far = StreamPosition { line: u64::MAX, byte: u64::MAX };
        let long = "é\n".repeat(4000);
        for token in [None, Some(long.as_bytes())] {
            let line = format_error(far, &long, Code::Colour, &long, token);
            assert!(line.len() < LINE_BYTES && line.len() > 900, "{}", line.len());
            assert!(line.bytes().all(|b| (b' '..=b'~').contains(&b)));
        }
    }
}

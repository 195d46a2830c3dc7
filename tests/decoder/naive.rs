//! A second, plain implementation of the framing for a stream that is complete in memory: the
//! reference for streams that are cut.
//!
//! It shares nothing with the decoder but the parser of one command's words, which `verbs.rs` tests
//! by tables. Text pixels of three words it parses itself, since the decoder has a fast path for
//! them.

use crate::recorder::{Event, hear_pieces};
use fbptr::command::{Command, EndOfInput, Limits};

/// Splits a line into its words.
fn text(text: &str) -> Vec<&str> {
    text.split([' ', '\t']).filter(|w| !w.is_empty()).collect()
}

fn number(word: &str) -> Option<i32> {
    let digits = word.strip_prefix(['+', '-']).unwrap_or(word);
    (!digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit())).then(|| word.parse().ok())?
}

fn hex_color(word: &str) -> Option<[u8; 4]> {
    if !word.chars().all(|c| c.is_ascii_hexdigit()) {
        return None;
    }
    let byte = |i: usize| u8::from_str_radix(&word[i..i + 2], 16).ok();
    match word.len() {
        2 => Some([byte(0)?, byte(0)?, byte(0)?, 255]),
        6 => Some([byte(0)?, byte(2)?, byte(4)?, 255]),
        8 => Some([byte(0)?, byte(2)?, byte(4)?, byte(6)?]),
        _ => None,
    }
}

/// Returns the events of a complete stream, with their positions.
pub fn hear_naively(bytes: &[u8], limits: Limits, end: EndOfInput) -> Vec<Event> {
    let mut events = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let rest = &bytes[at..];
        // Length of the command in bytes, and whether its length could be read from the stream.
        let (length, known) = if rest.starts_with(b"PB") {
            (10, rest.len() >= 10)
        } else if rest.starts_with(b"PXMULTI") {
            match rest.get(11..15) {
                Some(n) => (15 + 4 * u32::from_le_bytes(n.try_into().unwrap()) as usize, true),
                None => (15, false),
            }
        } else {
            match rest.iter().position(|&b| b == b'\n') {
                None => (rest.len(), true),
                Some(lf) => {
                    let line = &rest[..lf];
                    let line = line.strip_suffix(b"\r").unwrap_or(line);
                    let last = line.split(|b| b" \t".contains(b)).rfind(|w| !w.is_empty()).unwrap_or(b"");
                    let digits = last.strip_prefix(b":").unwrap_or(b"x");
                    let verb = line.split(|b| b" \t".contains(b)).find(|w| !w.is_empty()).unwrap_or(b"");
                    // Their text is the rest of the line.
                    let is_text = ["PRINT", "TITLE"].iter().any(|v| verb.eq_ignore_ascii_case(v.as_bytes()));
                    let announces = !is_text && !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
                    match std::str::from_utf8(digits).unwrap_or("x").parse::<u128>() {
                        Ok(n) if announces && !line.starts_with(b"#") => {
                            if n > u64::MAX as u128 {
                                events.extend(alone(&bytes[at..at + lf + 1], at, bytes, limits, end));
                                return events;
                            }
                            (lf + 1 + usize::try_from(n).unwrap_or(usize::MAX / 2).min(usize::MAX / 2), true)
                        }
                        Err(_) if announces && !line.starts_with(b"#") => {
                            // More digits than u128 holds.
                            events.extend(alone(&bytes[at..at + lf + 1], at, bytes, limits, end));
                            return events;
                        }
                        _ => (lf + 1, true),
                    }
                }
            }
        };
        let whole = if known { length.min(rest.len()) } else { rest.len() };
        let command = &rest[..whole];
        match plain_pixel(command) {
            Some(pixel) => events.push(pixel),
            None => events.extend(alone(command, at, bytes, limits, end)),
        }
        at += whole;
    }
    events
}

/// Parses a text pixel in plain hex, by other means than the decoder's.
fn plain_pixel(command: &[u8]) -> Option<Event> {
    let line = command.strip_suffix(b"\n")?;
    let line = std::str::from_utf8(line.strip_suffix(b"\r").unwrap_or(line)).ok()?;
    if line.len() > 4096 {
        return None;
    }
    match text(line)[..] {
        [verb, x, y, color] if verb.eq_ignore_ascii_case("PX") => {
            Some(Event::Pixel(number(x)?, number(y)?, hex_color(color)?))
        }
        _ => None,
    }
}

/// Returns the events of one command decoded as a stream of its own, with positions in the full
/// stream.
fn alone(command: &[u8], at: usize, bytes: &[u8], limits: Limits, end: EndOfInput) -> Vec<Event> {
    let lines = bytes[..at].iter().filter(|&&b| b == b'\n').count() as u64;
    let mut events = hear_pieces([command], limits, end);
    for event in &mut events {
        if let Event::Command(_, place) | Event::Error(fbptr::command::StreamError { place, .. }) = event {
            place.line += lines;
            place.byte += at as u64;
        }
        assert!(!matches!(event, Event::Command(Command::Pixel { .. } | Command::BinaryPixel { .. }, _)));
    }
    events
}

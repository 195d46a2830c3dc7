//! Replies of a server as they arrive: lines, and the bytes that some of them announce.
//!
//! In: bytes of a connection, cut anywhere. Out: the same bytes behind the server's greeting, with
//! the places of errors and warnings counted from the stream's own first byte instead of the
//! connection's; nothing of what answers without a greeting. Promise: bytes that a line announces
//! are no lines. Tested below and by `tests/serving/process.rs`.

use crate::command::{Reply, Verb};

/// Line that is sent before a stream so that each of its errors is reported.
pub(super) const REPORT_ERRORS: &[u8] = b"ERRORS report\n";

/// Lines that `send` sends before a stream: the server is asked what it is, and to report each error.
pub(super) const PREFACE: &[u8] = b"HELLO\nERRORS report\n";
/// Number of lines in [`PREFACE`].
const PREFACE_LINES: u64 = 2;
/// Beginning of the answer to `HELLO`.
const GREETING: &[u8] = b"HELLO fbptr ";

/// Longest line that is looked at; longer ones pass as they are.
const LONGEST_LINE: usize = 1 << 16;

/// Returns the number of bytes that follow a line of a reply.
pub(super) fn announced_bytes(line: &str) -> u64 {
    let word = line.split(' ').next().unwrap_or_default();
    let has_bytes =
        Verb::find(word.as_bytes()).is_some_and(|v| matches!(v.reply, Reply::Bytes | Reply::ByForm));
    let announced = line.rsplit(' ').next().and_then(|last| last.strip_prefix(':'));
    announced.filter(|_| has_bytes).and_then(|digits| digits.parse().ok()).unwrap_or(0)
}

/// Replies to a stream that followed [`PREFACE`].
#[derive(Debug, Default)]
pub(super) struct Replies {
    /// Beginning of a line whose end has not arrived.
    line: Vec<u8>,
    /// Number of announced bytes that have not arrived.
    bytes_left: u64,
    /// True once a line was an error.
    pub has_errors: bool,
    /// True once the greeting, or an error in its place, has arrived.
    is_greeted: bool,
    /// First line of something that is no server of this program.
    foreign: Option<String>,
}

impl Replies {
    /// Takes the next bytes, and appends what can be printed of them and of those before.
    pub fn take(&mut self, mut bytes: &[u8], out: &mut Vec<u8>) {
        while !bytes.is_empty() {
            let announced = usize::try_from(self.bytes_left).unwrap_or(usize::MAX).min(bytes.len());
            let (copied, rest) = bytes.split_at(announced);
            out.extend_from_slice(copied);
            self.bytes_left -= announced as u64;
            let end = rest.iter().position(|&byte| byte == b'\n');
            let (piece, rest) = rest.split_at(end.map_or(rest.len(), |end| end + 1));
            self.line.extend_from_slice(piece);
            if end.is_some() || self.line.len() > LONGEST_LINE {
                self.end_line(out);
            }
            bytes = rest;
        }
    }

    /// Appends the last line, which has no end. Returns the first line of what is no server of this
    /// program, if it is none: empty if nothing was answered.
    pub fn finish(&mut self, out: &mut Vec<u8>) -> Option<String> {
        self.end_line(out);
        self.foreign.take()
    }

    fn end_line(&mut self, out: &mut Vec<u8>) {
        let line = std::mem::take(&mut self.line);
        self.has_errors |= line.starts_with(b"ERR ");
        if self.foreign.is_some() {
            return;
        }
        if !std::mem::replace(&mut self.is_greeted, true) && !line.starts_with(b"ERR ") {
            let is_server = line.starts_with(GREETING);
            self.foreign = (!is_server).then(|| String::from_utf8_lossy(line.trim_ascii_end()).into_owned());
            return;
        }
        if let Some(line) = std::str::from_utf8(&line).ok().and_then(shifted) {
            out.extend_from_slice(line.as_bytes());
            return;
        }
        self.bytes_left = announced_bytes(&String::from_utf8_lossy(line.trim_ascii_end()));
        out.extend_from_slice(&line);
    }
}

/// Returns an error or warning with the place that it has in the stream itself; `None` for other
/// lines.
fn shifted(line: &str) -> Option<String> {
    let [word @ ("ERR" | "WARN"), number, byte, rest] = line.splitn(4, ' ').collect::<Vec<_>>()[..] else {
        return None;
    };
    let number = number.parse::<u64>().ok()?.checked_sub(PREFACE_LINES).filter(|&number| number > 0)?;
    let byte = byte.parse::<u64>().ok()?.checked_sub(PREFACE.len() as u64)?;
    Some(format!("{word} {number} {byte} {rest}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_the_stream_however_the_bytes_are_cut() {
        let sent =
            b"HELLO fbptr 1 4 4\nERR 4 37 ENUM LINE: a number\nREAD 0 0 1 2 :8\nERR 9 9\nWARN 3 20 DRAW: black\nERR odd\nPX 1";
        let want =
            b"ERR 2 17 ENUM LINE: a number\nREAD 0 0 1 2 :8\nERR 9 9\nWARN 1 0 DRAW: black\nERR odd\nPX 1";
        for size in [1, 2, 7, sent.len()] {
            let (mut replies, mut out) = (Replies::default(), Vec::new());
            for piece in sent.chunks(size) {
                replies.take(piece, &mut out);
            }
            assert_eq!(replies.finish(&mut out), None);
            assert_eq!(String::from_utf8_lossy(&out), String::from_utf8_lossy(want), "{size}");
            assert!(replies.has_errors);
        }
        let (mut replies, mut out) = (Replies::default(), Vec::new());
        replies.take(b"HELLO fbptr 1 4 4\nREAD 0 0 1 2 :8\nERR 1 2\n", &mut out);
        assert!(!replies.has_errors, "announced bytes are no lines");
    }

    #[test]
    fn what_answers_without_a_greeting_is_no_server() {
        for (answer, first) in [
            (&b"HTTP/1.0 400 Bad Request\r\n\r\n<html>\n"[..], Some("HTTP/1.0 400 Bad Request")),
            (b"", Some("")),
            (b"HELLO fbptr 1 640 480 tcp\n", None),
            (b"ERR 0 0 EQUOTA CONNECT: too many\n", None),
        ] {
            let (mut replies, mut out) = (Replies::default(), Vec::new());
            replies.take(answer, &mut out);
            assert_eq!(replies.finish(&mut out).as_deref(), first);
            assert_eq!(out, if replies.has_errors { answer } else { b"" });
        }
    }
}

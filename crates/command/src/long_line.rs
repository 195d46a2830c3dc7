//! Scanner for the rest of a line over the length limit. Stores nothing of it except the payload
//! length of a final `:N`.

use super::args::{is_blank, words};
use super::decoder::PayloadLength;
use super::verb::Verb;

/// State of the last word so far.
#[derive(Clone, Copy)]
enum Word {
    /// No word yet, or one that is no payload length.
    Plain,
    /// A colon alone.
    Colon,
    /// A colon and what follows it.
    After(PayloadLength),
}

/// Scanner that reads an overlong line to its LF to find the payload length in its last word.
pub(super) struct LongLine {
    last: Word,
    /// Set when the previous byte was not part of a word.
    between: bool,
    /// Set after a CR that is not counted yet: directly before LF it is not part of the line.
    held_cr: bool,
    /// Set for a comment, or a verb whose text is the rest of the line: it announces no payload.
    is_text: bool,
    ended: bool,
}

impl LongLine {
    /// Starts with `head`, the beginning of the line, which may end with its LF.
    pub fn new(head: &[u8]) -> Self {
        let verb = words(head).next().and_then(Verb::find);
        let is_text = head.first() == Some(&b'#') || verb.is_some_and(Verb::takes_rest_of_line);
        let mut line = LongLine { last: Word::Plain, between: true, held_cr: false, is_text, ended: false };
        line.read(head);
        line
    }

    /// Reads up to and including the LF. Returns the number of bytes read.
    pub fn read(&mut self, bytes: &[u8]) -> usize {
        for (at, &byte) in bytes.iter().enumerate() {
            if byte == b'\n' {
                self.ended = true;
                return at + 1;
            }
            if std::mem::take(&mut self.held_cr) {
                self.step(b'\r');
            }
            match byte {
                b'\r' => self.held_cr = true,
                byte => self.step(byte),
            }
        }
        bytes.len()
    }

    fn step(&mut self, byte: u8) {
        if is_blank(byte) {
            self.between = true;
            return;
        }
        let begins = std::mem::replace(&mut self.between, false);
        self.last = match (begins, self.last) {
            (true, _) if byte == b':' => Word::Colon,
            (true, _) | (false, Word::Plain) => Word::Plain,
            (false, Word::Colon) => Word::After(PayloadLength::Length(0).with(byte)),
            (false, Word::After(payload_length)) => Word::After(payload_length.with(byte)),
        };
    }

    /// Returns the announced payload length once the line has ended (`Length(0)` if there is none),
    /// `None` before.
    pub fn payload(&self) -> Option<PayloadLength> {
        self.ended.then_some(match self.last {
            Word::After(payload_length) if !self.is_text => payload_length,
            _ => PayloadLength::Length(0),
        })
    }
}

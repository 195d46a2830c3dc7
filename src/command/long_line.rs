//! The rest of a line over the limit: nothing of it is kept but whether it ends in `:N`.

use super::args::is_blank;
use super::decoder::PayloadLength;

/// The last word so far.
#[derive(Clone, Copy)]
enum Word {
    /// None yet, or one that announces nothing.
    Plain,
    /// A colon alone.
    Colon,
    /// A colon and more.
    After(PayloadLength),
}

/// A line that is read to its LF for the sake of its last word.
pub(super) struct LongLine {
    last: Word,
    /// The byte before is not part of a word.
    between: bool,
    /// A CR whose place is not known yet: before LF it is none of the line's.
    held_cr: bool,
    /// Comments announce nothing.
    comment: bool,
    ended: bool,
}

impl LongLine {
    /// A line that begins with `head`, which may hold its LF as the last byte.
    pub fn new(head: &[u8]) -> Self {
        let comment = head.first() == Some(&b'#');
        let mut line = LongLine { last: Word::Plain, between: true, held_cr: false, comment, ended: false };
        line.read(head);
        line
    }

    /// Reads up to and including the LF. Answers how many bytes it took.
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

    /// What the line announces, once it has ended.
    pub fn payload(&self) -> Option<PayloadLength> {
        self.ended.then_some(match self.last {
            Word::After(payload_length) if !self.comment => payload_length,
            _ => PayloadLength::Length(0),
        })
    }
}

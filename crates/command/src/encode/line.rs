//! Writer of a command's words, or of a binary command's bytes.

use super::EncodeError;
use fbptr_core::memory::Rgba;
use glam::DVec3;
use std::io::Write;

/// Writer that appends the arguments of one command to a buffer.
pub(crate) struct LineWriter<'a> {
    verb: &'static str,
    out: &'a mut Vec<u8>,
    is_binary: bool,
}

impl<'a> LineWriter<'a> {
    pub fn new(verb: &'static str, out: &'a mut Vec<u8>) -> Self {
        LineWriter { verb, out, is_binary: false }
    }

    /// Appends a blank and a word.
    pub fn word(&mut self, word: impl std::fmt::Display) {
        write!(self.out, " {word}").expect("a Vec takes all bytes");
    }

    pub fn ints(&mut self, numbers: &[i32]) {
        numbers.iter().for_each(|n| self.word(n));
    }

    /// Appends reals in the shortest form that reads back.
    pub fn reals(&mut self, numbers: &[f64]) {
        for n in numbers {
            // Debug prints 1e300 in short form where Display writes 300 zeros; both are the
            // shortest that read back.
            self.word(format_args!("{n:?}"));
        }
    }

    pub fn vectors(&mut self, vectors: &[DVec3]) {
        vectors.iter().for_each(|v| self.reals(&v.to_array()));
    }

    /// Appends a colour: `rrggbb` if it is opaque, otherwise `rrggbbaa`.
    pub fn color(&mut self, [r, g, b, a]: Rgba) {
        match a {
            255 => self.word(format_args!("{r:02x}{g:02x}{b:02x}")),
            a => self.word(format_args!("{r:02x}{g:02x}{b:02x}{a:02x}")),
        }
    }

    /// Appends bytes in hex, as one word.
    pub fn hex(&mut self, bytes: &[u8]) {
        self.out.push(b' ');
        for b in bytes {
            write!(self.out, "{b:02x}").expect("a Vec takes all bytes");
        }
    }

    /// Appends bytes unchanged. The command is then a binary one: no blank, no `:N`, no LF.
    pub fn binary(&mut self, bytes: &[u8]) {
        self.is_binary = true;
        self.out.extend_from_slice(bytes);
    }

    /// Returns whether the command is a binary one.
    pub fn is_binary(&self) -> bool {
        self.is_binary
    }

    /// Returns the error for a part that has no text form.
    pub fn no_text<T>(&self, what: &'static str) -> Result<T, EncodeError> {
        Err(EncodeError::NoText { verb: self.verb, what })
    }
}

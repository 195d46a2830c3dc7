//! Tokens of the classic encoding: brackets, strings and words. Commas are white space, and `#`
//! begins a comment outside strings.

use crate::load::x3d::xml::XmlSource;
use crate::load::{LoadError, LoadErrorKind};
use fbptr_core::cancel::CancelToken;

/// Kind of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    OpenNode,
    CloseNode,
    OpenList,
    CloseList,
    /// A string with its quotes.
    String,
    /// A name, a number or a keyword.
    Word,
    /// The end of the file, after the last token.
    End,
}

/// A token: its text and its byte offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'s> {
    pub(super) kind: Kind,
    pub(super) text: &'s str,
    pub(super) at: usize,
}

impl Token<'_> {
    /// Returns whether a word is a number or a truth value, and no name.
    pub(super) fn is_value(self) -> bool {
        let begins = |b: &u8| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.');
        let is_truth = || ["true", "false"].iter().any(|word| self.text.eq_ignore_ascii_case(word));
        self.kind == Kind::Word && (self.text.as_bytes().first().is_some_and(begins) || is_truth())
    }
}

/// Reader of tokens, one ahead.
pub(super) struct Lexer<'s> {
    pub(super) source: &'s XmlSource,
    /// The next token.
    pub(super) next: Token<'s>,
    cancel: &'s CancelToken,
}

/// Returns the length of the white space, commas and comments at the start of a text.
fn blank(text: &str) -> usize {
    let (bytes, mut at) = (text.as_bytes(), 0);
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'#' => {
                at += bytes[at..].iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(bytes.len() - at)
            }
            b' ' | b'\t' | b'\n' | b'\r' | b',' => at += 1,
            _ => break,
        }
    }
    at
}

impl<'s> Lexer<'s> {
    /// Begins at the start of a file.
    pub(super) fn new(source: &'s XmlSource, cancel: &'s CancelToken) -> Result<Self, LoadError> {
        let mut lexer = Lexer { source, next: Token { kind: Kind::End, text: "", at: 0 }, cancel };
        lexer.next = lexer.token(0)?;
        Ok(lexer)
    }

    /// Returns the next token and reads the one after it.
    pub(super) fn take(&mut self) -> Result<Token<'s>, LoadError> {
        let taken = self.next;
        if self.cancel.is_cancelled() {
            return Err(LoadError::new(self.source.place(taken.at), LoadErrorKind::Cancelled));
        }
        self.next = self.token(taken.at + taken.text.len())?;
        Ok(taken)
    }

    /// Takes a token of a kind; `expected` says which in the error.
    pub(super) fn take_a(&mut self, kind: Kind, expected: &str) -> Result<Token<'s>, LoadError> {
        match self.next.kind == kind {
            true => self.take(),
            false => Err(self.refuse(expected)),
        }
    }

    /// Returns the error at the next token.
    pub(super) fn refuse(&self, expected: impl Into<String>) -> LoadError {
        self.source.refuse(self.next.at, expected)
    }

    /// Reads the token from a byte offset on.
    fn token(&self, from: usize) -> Result<Token<'s>, LoadError> {
        let text = &self.source.text;
        let at = from + blank(&text[from..]);
        let rest = &text[at..];
        let (kind, length) = match rest.as_bytes().first() {
            None => (Kind::End, 0),
            Some(b'{') => (Kind::OpenNode, 1),
            Some(b'}') => (Kind::CloseNode, 1),
            Some(b'[') => (Kind::OpenList, 1),
            Some(b']') => (Kind::CloseList, 1),
            Some(b'"') => match string_length(rest) {
                Some(length) => (Kind::String, length),
                None => return Err(self.source.refuse(at, "a string to end with \"")),
            },
            Some(_) => {
                let ends = |b: &u8| {
                    matches!(b, b' ' | b'\t' | b'\n' | b'\r' | b',' | b'#' | b'"' | b'{' | b'}' | b'[' | b']')
                };
                (Kind::Word, rest.bytes().position(|b| ends(&b)).unwrap_or(rest.len()))
            }
        };
        Ok(Token { kind, text: &rest[..length], at })
    }
}

/// Returns the length of the string at the start of a text, with its quotes; `None` if it has no end.
fn string_length(text: &str) -> Option<usize> {
    let (bytes, mut at) = (text.as_bytes(), 1);
    loop {
        match bytes.get(at)? {
            b'"' => return Some(at + 1),
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
}

//! Statements of OBJ and MTL files: numbered lines with any line ends, joined at `\`.

use crate::load::{FilePosition, LoadError, LoadErrorKind};
use std::borrow::Cow;

/// Iterator over a file's statements, with line numbers from 1. A BOM is skipped. A line ends at
/// LF, with CRs before it dropped; in a file without any LF, at CR. `\` at the end of a line joins
/// the next one to it, except in a comment.
#[derive(Clone)]
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    line: u32,
    end: u8,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let end = if rest.contains(&b'\n') { b'\n' } else { b'\r' };
        Lines { rest, line: 0, end }
    }

    /// Returns the next physical line without surrounding blanks.
    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|b| *b == self.end);
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        self.line = self.line.saturating_add(1);
        Some(line.trim_ascii())
    }
}

impl<'a> Iterator for Lines<'a> {
    /// Number of the statement's first line, and its bytes without surrounding blanks.
    type Item = (u32, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let first = self.physical()?;
        let number = self.line;
        let Some(mut part) = first.strip_suffix(b"\\").filter(|_| !first.starts_with(b"#")) else {
            return Some((number, Cow::Borrowed(first)));
        };
        let mut joined = Vec::new();
        loop {
            joined.extend_from_slice(part);
            joined.push(b' ');
            let Some(next) = self.physical() else { break };
            match next.strip_suffix(b"\\") {
                Some(more) => part = more,
                None => {
                    joined.extend_from_slice(next);
                    break;
                }
            }
        }
        Some((number, Cow::Owned(joined.trim_ascii().to_vec())))
    }
}

/// Splits a statement into its first word and the rest.
pub(super) fn keyword(statement: &[u8]) -> (&[u8], &[u8]) {
    let end = statement.iter().position(u8::is_ascii_whitespace).unwrap_or(statement.len());
    (&statement[..end], statement[end..].trim_ascii_start())
}

/// Iterates over the words of a numeric statement, up to a comment. Not for names, which may
/// contain blanks and `#`.
pub(super) fn words(arguments: &[u8]) -> impl Iterator<Item = &[u8]> {
    let end = arguments.iter().position(|b| *b == b'#').unwrap_or(arguments.len());
    arguments[..end].split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// Returns the bytes as text: UTF-8, or Latin-1 if they are not valid UTF-8.
pub(super) fn text(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|b| char::from(*b)).collect()),
    }
}

/// Returns text of the file for a message, cut to 40 characters.
pub(super) fn shown(bytes: &[u8]) -> String {
    let text = text(bytes);
    match text.char_indices().nth(40) {
        Some((cut, _)) => format!("{}...", &text[..cut]),
        None => text.into_owned(),
    }
}

/// Parses a finite number; the error shows the word.
pub(super) fn number(
    word: &[u8],
    what: &'static str,
    place: impl FnOnce() -> FilePosition,
) -> Result<f64, LoadError> {
    let parsed = std::str::from_utf8(word).ok().and_then(|text| text.parse::<f64>().ok());
    parsed
        .filter(|x| x.is_finite())
        .ok_or_else(|| LoadError::new(place(), LoadErrorKind::Number { what, found: shown(word) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<(u32, String)> {
        Lines::new(text.as_bytes()).map(|(n, l)| (n, String::from_utf8(l.into_owned()).unwrap())).collect()
    }

    #[test]
    fn lines_are_numbered_and_joined() {
        let of = |pairs: &[(u32, &str)]| pairs.iter().map(|(n, l)| (*n, l.to_string())).collect::<Vec<_>>();
        assert_eq!(lines("\u{feff}a b\r\r\n\n  c"), of(&[(1, "a b"), (2, ""), (3, "c")]));
        assert_eq!(lines("a\rb\r"), of(&[(1, "a"), (2, "b")]));
        assert_eq!(lines("f 1 \\\r\n 2\\\n3\nx"), of(&[(1, "f 1  2 3"), (4, "x")]));
        assert_eq!(lines("# c:\\\nv"), of(&[(1, "# c:\\"), (2, "v")]));
        assert_eq!(lines("a\\"), of(&[(1, "a")]));
        assert_eq!(lines(""), []);
        assert_eq!(text(b"caf\xe9"), "caf\u{e9}");
        assert_eq!(words(b" 1\t2  #3 4").collect::<Vec<_>>(), [b"1", b"2"]);
        assert_eq!(shown(&[b'x'; 99]).len(), 43);
    }
}

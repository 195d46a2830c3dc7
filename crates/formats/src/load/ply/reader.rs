//! Numbers of the rows of a PLY file, as text or binary.
//!
//! A text has one row a line, as a rule. Files that have more values in a line than their header
//! says, and files with rows that go on in the next line or share one, are told apart by their
//! number of lines: with a line for each row or more, what is left of a row's line is passed over;
//! with fewer, rows are read wherever lines end. With exactly one a row, a row is no longer than its
//! line. Comments among the rows are passed over. A word that is no number is one that is not finite.

use super::header::{Element, Encoding, Scalar};
use crate::load::{FilePosition, LoadErrorKind};

/// Relation of rows and lines of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// Each row is a line.
    LineEach,
    /// Each row begins a line.
    LineOrMore,
    /// Rows are anywhere.
    Free,
}

/// Position in the rows of a file.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Number of the line, from 1.
    line: u32,
    encoding: Encoding,
    layout: Layout,
    file_name: &'a str,
}

/// Returns the length of the line end at the beginning of these bytes.
fn line_end(bytes: &[u8]) -> usize {
    match bytes {
        [b'\r', b'\n', ..] => 2,
        [b'\r' | b'\n', ..] => 1,
        _ => 0,
    }
}

/// Returns whether a line is a comment.
fn is_comment(line: &[u8]) -> bool {
    line.starts_with(b"#") || line.get(..7).is_some_and(|word| word.eq_ignore_ascii_case(b"comment"))
}

impl<'a> Reader<'a> {
    /// Creates a reader of the rows from byte `at`, in line `line`, on.
    pub(super) fn new(
        bytes: &'a [u8],
        (at, line): (usize, u32),
        encoding: Encoding,
        elements: &[Element],
        file_name: &'a str,
    ) -> Self {
        let mut reader = Reader { bytes, at, line, encoding, layout: Layout::Free, file_name };
        if encoding == Encoding::Text {
            let rows = elements.iter().fold(0, |sum: u64, e| sum.saturating_add(e.count));
            let lines = bytes[at.min(bytes.len())..].split(|b| matches!(b, b'\n' | b'\r'));
            let lines = lines.map(<[u8]>::trim_ascii).filter(|l| !l.is_empty() && !is_comment(l)).count();
            reader.layout = match (lines as u64).cmp(&rows) {
                std::cmp::Ordering::Less => Layout::Free,
                std::cmp::Ordering::Equal => Layout::LineEach,
                std::cmp::Ordering::Greater => Layout::LineOrMore,
            };
        }
        reader
    }

    /// Returns the bytes that are left.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or(&[])
    }

    pub(super) fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Returns the present place, to be turned into a position by [`Reader::position`].
    pub(super) fn place(&self) -> u64 {
        match self.encoding {
            Encoding::Text => u64::from(self.line),
            _ => self.at as u64,
        }
    }

    pub(super) fn position(&self, place: u64) -> FilePosition {
        match self.encoding {
            Encoding::Text => FilePosition::line(self.file_name, place as u32),
            _ => FilePosition::byte(self.file_name, place),
        }
    }

    /// Passes empty lines and comments before a row.
    pub(super) fn begin_row(&mut self) {
        if self.encoding != Encoding::Text {
            return;
        }
        loop {
            let rest = self.rest();
            let blanks = rest.len() - rest.trim_ascii_start().len();
            self.pass(blanks);
            if !is_comment(self.rest()) {
                return;
            }
            self.pass_line();
        }
    }

    /// Passes bytes of a text, and counts their line ends.
    fn pass(&mut self, count: usize) {
        let end = self.at + count;
        while self.at < end {
            let rest = &self.bytes[self.at..];
            let line = line_end(rest);
            self.line = self.line.saturating_add(u32::from(line > 0));
            self.at += line.max(1);
        }
    }

    /// Passes the rest of the line, without its end. Returns whether there were words in it.
    fn pass_line(&mut self) -> bool {
        let rest = self.rest();
        let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        self.at += end;
        !rest[..end].trim_ascii().is_empty()
    }

    /// Ends a row. Returns whether its line had more values, which are passed over.
    pub(super) fn end_row(&mut self) -> bool {
        self.encoding == Encoding::Text && self.layout != Layout::Free && self.pass_line()
    }

    /// Returns the next word of a row; `None` if the row or the file ends.
    fn word(&mut self) -> Option<&'a [u8]> {
        loop {
            let rest = self.rest();
            match rest.first()? {
                b'\n' | b'\r' if self.layout == Layout::LineEach => return None,
                b'\n' | b'\r' => self.pass(1),
                b if b.is_ascii_whitespace() => self.at += 1,
                _ => {
                    let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
                    self.at += end;
                    return Some(&rest[..end]);
                }
            }
        }
    }

    /// Reads a number; `None` if the row or the file ends before it.
    pub(super) fn number(&mut self, scalar: Scalar) -> Option<f64> {
        if self.encoding == Encoding::Text {
            let word = self.word()?;
            return Some(std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()).unwrap_or(f64::NAN));
        }
        let bytes = self.rest().get(..scalar.size())?;
        self.at += scalar.size();
        Some(binary(bytes, scalar, self.encoding == Encoding::Big))
    }

    /// Reads the length of a list; `None` if the row ends, or it cannot be one.
    ///
    /// # Errors
    /// If the file has fewer bytes than the list needs.
    pub(super) fn length(&mut self, length: Scalar, item: Scalar) -> Result<Option<u64>, LoadErrorKind> {
        let Some(found) = self.number(length) else { return Ok(None) };
        let is_length = found >= 0.0 && found.fract() == 0.0;
        let size = if self.encoding == Encoding::Text { 2.0 } else { item.size() as f64 };
        let left = self.rest().len() as f64 + 1.0;
        match is_length && found * size <= left {
            true => Ok(Some(found as u64)),
            // Nothing after it can be found.
            false if self.layout != Layout::LineEach => {
                let reason = format!("a list of {found} numbers, and {} bytes are left", left - 1.0);
                Err(LoadErrorKind::Undecodable { format: "PLY", reason })
            }
            false => Ok(None),
        }
    }

    /// Returns whether each row is a line, so that one with too few values does not end the file.
    pub(super) fn has_row_each(&self) -> bool {
        self.layout == Layout::LineEach
    }
}

/// Decodes a number.
fn binary(bytes: &[u8], scalar: Scalar, is_big: bool) -> f64 {
    macro_rules! decode {
        ($type:ty) => {{
            let mut all = [0; size_of::<$type>()];
            all.copy_from_slice(bytes);
            if is_big { <$type>::from_be_bytes(all) } else { <$type>::from_le_bytes(all) }
        }};
    }
    match scalar {
        Scalar::I8 => f64::from(decode!(i8)),
        Scalar::U8 => f64::from(decode!(u8)),
        Scalar::I16 => f64::from(decode!(i16)),
        Scalar::U16 => f64::from(decode!(u16)),
        Scalar::I32 => f64::from(decode!(i32)),
        Scalar::U32 => f64::from(decode!(u32)),
        Scalar::I64 => decode!(i64) as f64,
        Scalar::U64 => decode!(u64) as f64,
        Scalar::F32 => f64::from(decode!(f32)),
        Scalar::F64 => decode!(f64),
    }
}

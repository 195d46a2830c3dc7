//! Header of a PLY file: encoding, elements with their properties, and named textures.
//!
//! Lines end at LF, CR or both, by the end of the first one, so that the first byte of binary rows
//! is never taken for a line end. Keywords may be in any case.

use crate::load::error::short;
use crate::load::{FilePosition, LoadError, LoadErrorKind};

/// Most elements of a header, and most properties of an element.
const MAX_ELEMENTS: usize = 256;

/// Encoding of the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn of(name: &str) -> Option<Scalar> {
        Some(match name.to_ascii_lowercase().as_str() {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "long" | "int64" => Scalar::I64,
            "ulong" | "uint64" => Scalar::U64,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Returns the bytes of a number in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }

    /// Returns the largest number of a type of whole numbers, else 1.
    pub(super) fn full(self) -> f64 {
        match self {
            Scalar::I8 => f64::from(i8::MAX),
            Scalar::U8 => f64::from(u8::MAX),
            Scalar::I16 => f64::from(i16::MAX),
            Scalar::U16 => f64::from(u16::MAX),
            Scalar::I32 => f64::from(i32::MAX),
            Scalar::U32 => f64::from(u32::MAX),
            Scalar::I64 => i64::MAX as f64,
            Scalar::U64 => u64::MAX as f64,
            Scalar::F32 | Scalar::F64 => 1.0,
        }
    }
}

/// A property: one number, or a list of them after its length.
#[derive(Clone, Debug)]
pub(super) struct Property {
    /// Name in lower case.
    pub(super) name: String,
    pub(super) scalar: Scalar,
    /// Type of the list's length.
    pub(super) length: Option<Scalar>,
}

/// An element: rows of properties.
#[derive(Clone, Debug)]
pub(super) struct Element {
    /// Name in lower case.
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

/// A header.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Names of `comment TextureFile`, each with its line.
    pub(super) textures: Vec<(String, u32)>,
    /// Lines that are none of the format's: the first, and their number.
    pub(super) unknown: Option<(u32, String, u32)>,
    /// Offset of the first row, and the number of its line.
    pub(super) end: usize,
    pub(super) line: u32,
}

/// Lines of a header; see the module's documentation.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u32,
    /// Byte that ends a line; a CR before it belongs to the end.
    end: u8,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let first = bytes.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let is_bare = first.is_some_and(|i| bytes[i] == b'\r' && bytes.get(i + 1) != Some(&b'\n'));
        Lines { bytes, at: 0, line: 0, end: if is_bare { b'\r' } else { b'\n' } }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let end = rest.iter().position(|b| *b == self.end);
        let line = &rest[..end.unwrap_or(rest.len())];
        self.at += line.len() + usize::from(end.is_some());
        self.line += 1;
        Some(line.trim_ascii())
    }
}

/// Reads the header of a file without byte order mark.
///
/// # Errors
/// If a line cannot be read, or the header does not end.
pub(super) fn read(bytes: &[u8], file_name: &str) -> Result<Header, LoadError> {
    let mut lines = Lines::new(bytes);
    let mut header = Header {
        encoding: Encoding::Text,
        elements: Vec::new(),
        textures: Vec::new(),
        unknown: None,
        end: 0,
        line: 0,
    };
    let mut has_encoding = false;
    while let Some(bytes) = lines.next() {
        let line = lines.line;
        let refuse = |kind| LoadError::new(FilePosition::line(file_name, line), kind);
        let wrong = |expected: &str| {
            let found = short(&String::from_utf8_lossy(bytes));
            refuse(LoadErrorKind::Syntax { expected: expected.into(), found })
        };
        let text = String::from_utf8_lossy(bytes);
        let words: Vec<&str> = text.split_ascii_whitespace().take(6).collect();
        let keyword = words.first().map_or(String::new(), |word| word.to_ascii_lowercase());
        match (keyword.as_str(), &words[words.len().min(1)..]) {
            ("" | "ply" | "obj_info", _) => {}
            ("comment", [word, ..]) if word.trim_end_matches(':').eq_ignore_ascii_case("texturefile") => {
                let name = text.split_once(word).map_or("", |(_, name)| name.trim());
                header.textures.push((name.to_owned(), line));
            }
            ("comment", _) => {}
            ("format", [encoding, ..]) => {
                has_encoding = true;
                header.encoding = match encoding.to_ascii_lowercase().as_str() {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(wrong("expected ascii, binary_little_endian or binary_big_endian")),
                };
            }
            ("element", [name, count, ..]) => {
                let count = count.parse().map_err(|_| wrong("expected a number of rows"))?;
                header.elements.push(Element {
                    name: name.to_ascii_lowercase(),
                    count,
                    properties: Vec::new(),
                });
            }
            ("property", rest) => {
                let element = header.elements.last_mut();
                let element = element.ok_or_else(|| wrong("expected an element before its properties"))?;
                let property = property(rest)
                    .ok_or_else(|| wrong("expected property TYPE NAME or property list TYPE TYPE NAME"))?;
                element.properties.push(property);
            }
            ("end_header", _) if has_encoding => {
                (header.end, header.line) = (lines.at, line + 1);
                return Ok(header);
            }
            ("end_header", _) => return Err(wrong("expected a format before the end of the header")),
            _ => match &mut header.unknown {
                Some((.., count)) => *count += 1,
                None => header.unknown = Some((line, short(&text), 1)),
            },
        }
        let most = header.elements.iter().map(|e| e.properties.len()).max().unwrap_or(0);
        let most = most.max(header.elements.len()).max(header.textures.len());
        if most > MAX_ELEMENTS {
            let what = "elements, or properties of one";
            let (found, limit) = (most as u64, MAX_ELEMENTS as u64);
            return Err(refuse(LoadErrorKind::TooBig { what, found, limit }));
        }
    }
    let reason = "the header has no end_header".to_owned();
    let place = FilePosition::line(file_name, lines.line);
    Err(LoadError::new(place, LoadErrorKind::Undecodable { format: "PLY", reason }))
}

/// Reads the words after `property`.
fn property(words: &[&str]) -> Option<Property> {
    let (length, scalar, name) = match words {
        [list, length, scalar, name, ..] if list.eq_ignore_ascii_case("list") => {
            (Some(Scalar::of(length)?), scalar, name)
        }
        [scalar, name, ..] => (None, scalar, name),
        _ => return None,
    };
    Some(Property { name: name.to_ascii_lowercase(), scalar: Scalar::of(scalar)?, length })
}

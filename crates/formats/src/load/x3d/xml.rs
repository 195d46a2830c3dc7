//! XML input: bytes to a checked text, and readable error messages. The places of a file in the
//! classic encoding, which becomes XML (`classic`), are those of its own text.
//!
//! Only this file, `build` and `external_refs` use the XML reader (roxmltree). Before that reader
//! sees the text, [`check`] scans its tags once: it reports an unclosed tag with its line, and
//! refuses what would take unbounded time or memory (nesting, attributes of one element,
//! namespaces, entities that expand).

use crate::load::{FilePosition, LoadError, LoadErrorKind};
use fbptr_core::cancel::CancelToken;

/// Deepest nesting of elements, Inline files included.
pub(super) const MAX_DEPTH: usize = 256;
/// Most attributes of one element: the reader compares all pairs.
const MAX_ATTRIBUTES: usize = 256;
/// Most namespace declarations: the reader copies them.
const MAX_NAMESPACES: usize = 256;
/// Most entity declarations: the reader searches them linearly.
const MAX_ENTITIES: usize = 1_000;
/// Most bytes that entities may expand to.
const MAX_EXPANSION: u64 = 64 << 20;
/// Most XML nodes, runs of white space between elements included.
const MAX_NODES: u32 = 8_000_000;

/// A part of the XML made of a text in the classic encoding, and where it was in that text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    /// Byte offset of the part in the XML text.
    pub(super) xml: usize,
    /// Byte offset of its origin.
    pub(super) classic: usize,
    /// Number of bytes for which offsets in both advance alike.
    pub(super) same: usize,
}

/// A file's text with its name and line table.
#[derive(Debug)]
pub(super) struct XmlSource {
    /// Name of the file, for messages.
    pub(super) name: String,
    /// Text without byte order mark.
    pub(super) text: String,
    /// Byte offset of each line's beginning in the file's own text.
    lines: Vec<usize>,
    /// Of a file in the classic encoding: its own text, and where the parts of the XML come from.
    classic: Option<(String, Vec<Part>)>,
    /// Remark on the file's encoding.
    pub(super) remark: Option<&'static str>,
}

impl XmlSource {
    /// Decodes a file: UTF-8, UTF-16 with byte order mark, or Latin-1 if the XML declaration says
    /// so, and in the classic encoding, with a remark, if it is no UTF-8.
    pub(super) fn decode(bytes: &[u8], name: &str, is_classic: bool) -> Result<XmlSource, LoadError> {
        let utf16 = |unit: fn([u8; 2]) -> u16, rest: &[u8]| {
            let units = rest.as_chunks::<2>().0.iter().map(|b| unit(*b));
            char::decode_utf16(units).collect::<Result<String, _>>().ok()
        };
        let text = match bytes {
            [0xef, 0xbb, 0xbf, rest @ ..] => std::str::from_utf8(rest).ok().map(str::to_string),
            [0xff, 0xfe, rest @ ..] => utf16(u16::from_le_bytes, rest),
            [0xfe, 0xff, rest @ ..] => utf16(u16::from_be_bytes, rest),
            _ => match std::str::from_utf8(bytes) {
                Ok(text) => Some(text.to_string()),
                Err(_) if is_classic || is_latin1(bytes) => Some(bytes.iter().map(|b| *b as char).collect()),
                Err(_) => None,
            },
        };
        let Some(text) = text else {
            let good = std::str::from_utf8(bytes).err().map_or(0, |e| e.valid_up_to());
            let before = XmlSource::new(name, String::from_utf8_lossy(&bytes[..good]).into_owned());
            let reason = "the bytes are not text in the encoding of the file".to_string();
            let kind = LoadErrorKind::Undecodable { format: "X3D file", reason };
            return Err(LoadError::new(before.place(before.text.len()), kind));
        };
        let remark = (is_classic && std::str::from_utf8(bytes).is_err())
            .then_some("the file is no UTF-8: Latin-1 is taken");
        Ok(XmlSource { remark, ..XmlSource::new(name, text) })
    }

    /// Replaces the text of a file in the classic encoding by its XML.
    pub(super) fn translated(self, xml: String, parts: Vec<Part>) -> XmlSource {
        XmlSource { classic: Some((self.text, parts)), text: xml, ..self }
    }

    fn new(name: &str, text: String) -> XmlSource {
        let starts = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(at, _)| at + 1);
        let lines = std::iter::once(0).chain(starts).collect();
        XmlSource { name: name.to_string(), text, lines, classic: None, remark: None }
    }

    /// Returns the file's own text, and the byte offset in it of one in the XML.
    fn own(&self, byte: usize) -> (&str, usize) {
        let Some((text, parts)) = &self.classic else { return (&self.text, byte) };
        let Some(part) = parts[..parts.partition_point(|part| part.xml <= byte)].last() else {
            return (text, 0);
        };
        (text, part.classic + (byte - part.xml).min(part.same))
    }

    /// Returns the line of a byte offset, from 1.
    pub(super) fn line(&self, byte: usize) -> u32 {
        let (_, byte) = self.own(byte);
        self.lines.partition_point(|start| *start <= byte) as u32
    }

    /// Returns the line and column of a byte offset.
    pub(super) fn place(&self, byte: usize) -> FilePosition {
        let line = self.line(byte);
        let start = self.lines[line as usize - 1];
        let (text, byte) = self.own(byte);
        let column = text.get(start..byte).map_or(0, |s| s.chars().count()) as u32 + 1;
        FilePosition::column(&self.name, line, column)
    }

    /// Returns the text at a byte offset for "found ...": up to the end of the line, at most 24
    /// characters.
    fn snippet(&self, byte: usize) -> String {
        let (text, byte) = self.own(byte);
        let rest = text.get(byte..).unwrap_or("");
        match rest.lines().next().unwrap_or("") {
            "" if rest.is_empty() => "the end of the file".into(),
            "" => "the end of the line".into(),
            line => line.chars().take(24).collect(),
        }
    }

    /// Returns a syntax error at a byte offset.
    pub(super) fn refuse(&self, byte: usize, expected: impl Into<String>) -> LoadError {
        let expected = format!("expected {}", expected.into());
        LoadError::new(self.place(byte), LoadErrorKind::Syntax { expected, found: self.snippet(byte) })
    }

    /// Returns the error for an exceeded limit at a byte offset.
    pub(super) fn too_big(&self, byte: usize, what: &'static str, found: u64, limit: u64) -> LoadError {
        LoadError::new(self.place(byte), LoadErrorKind::TooBig { what, found, limit })
    }
}

/// Returns the position of byte `at` of an attribute's value.
pub(super) fn place_in(source: &XmlSource, attribute: &roxmltree::Attribute, at: usize) -> FilePosition {
    let range = attribute.range_value();
    // Only a value without references and tabs has the same bytes in the file.
    let is_verbatim = source.text.get(range.clone()).is_some_and(|t| t.len() == attribute.value().len());
    source.place(range.start + if is_verbatim { at } else { 0 })
}

/// Returns whether the XML declaration names Latin-1 or its Windows variant.
fn is_latin1(bytes: &[u8]) -> bool {
    let head = bytes[..bytes.len().min(200)].to_ascii_lowercase();
    let head = String::from_utf8_lossy(&head);
    let declaration = head.split("?>").next().unwrap_or("");
    declaration.starts_with("<?xml")
        && ["iso-8859-1", "latin1", "windows-1252"].iter().any(|e| declaration.contains(e))
}

/// Checks and parses a text. `cancel` ends the check between any two tags, but not the parser after
/// it.
pub(super) fn parse<'s>(
    source: &'s XmlSource,
    cancel: &CancelToken,
) -> Result<roxmltree::Document<'s>, LoadError> {
    check(source, cancel)?;
    let options = roxmltree::ParsingOptions { allow_dtd: true, nodes_limit: MAX_NODES, ..Default::default() };
    roxmltree::Document::parse_with_options(&source.text, options).map_err(|e| explain(source, &e))
}

/// Checks that tags are closed in order and that the limits hold.
fn check(source: &XmlSource, cancel: &CancelToken) -> Result<(), LoadError> {
    let text = source.text.as_str();
    let namespaces = text.match_indices("xmlns").count();
    if namespaces > MAX_NAMESPACES {
        return Err(source.too_big(0, "namespaces", namespaces as u64, MAX_NAMESPACES as u64));
    }
    let mut open: Vec<(usize, &str)> = Vec::new();
    let mut at = 0;
    while let Some(lt) = text[at..].find('<').map(|i| at + i) {
        if cancel.is_cancelled() {
            return Err(LoadError::new(source.place(lt), LoadErrorKind::Cancelled));
        }
        let rest = &text[lt..];
        let skip_to = |end: &str, what: &str| match rest.find(end) {
            Some(i) => Ok(lt + i + end.len()),
            None => Err(source.refuse(lt, format!("{what} to end with {end}"))),
        };
        at = if rest.starts_with("<!--") {
            skip_to("-->", "a comment")?
        } else if rest.starts_with("<![CDATA[") {
            skip_to("]]>", "a CDATA section")?
        } else if rest.starts_with("<?") {
            skip_to("?>", "a processing instruction")?
        } else if rest.starts_with("<!DOCTYPE") {
            let Some(end) = doctype_end(rest) else {
                return Err(source.refuse(lt, "the document type declaration to end with >"));
            };
            entities(source, lt, lt + end)?;
            lt + end
        } else if let Some(name) = rest.strip_prefix("</") {
            let name = tag_name(name);
            match open.pop() {
                Some((_, opened)) if opened == name => {}
                Some((byte, opened)) => {
                    let line = source.line(byte);
                    let expected = format!("</{opened}> first, which closes <{opened}> of line {line}");
                    return Err(source.refuse(lt, expected));
                }
                None => return Err(source.refuse(lt, "no closing tag where nothing is open")),
            }
            lt + 2 + name.len()
        } else {
            let name = tag_name(&rest[1..]);
            let Some(tag) = tag_end(rest) else { return Ok(()) };
            if tag.attributes > MAX_ATTRIBUTES {
                let limit = MAX_ATTRIBUTES as u64;
                return Err(source.too_big(lt, "attributes of one element", tag.attributes as u64, limit));
            }
            if !tag.is_empty {
                open.push((lt, name));
            }
            if open.len() > MAX_DEPTH {
                let limit = MAX_DEPTH as u64;
                return Err(source.too_big(lt, "nesting of elements", open.len() as u64, limit));
            }
            lt + tag.end
        };
    }
    match open.pop() {
        Some((byte, name)) => {
            let expected = format!("expected <{name}> to be closed by </{name}>");
            let kind = LoadErrorKind::Syntax { expected, found: "the end of the file".into() };
            Err(LoadError::new(source.place(byte), kind))
        }
        None => Ok(()),
    }
}

/// Returns the name at the start of a text, up to white space, `/`, `>` or `<`.
fn tag_name(text: &str) -> &str {
    text.split(|c: char| c.is_ascii_whitespace() || matches!(c, '/' | '>' | '<')).next().unwrap_or("")
}

/// A start tag.
struct Tag {
    /// Offset after the `>`.
    end: usize,
    is_empty: bool,
    attributes: usize,
}

/// Returns the end of a start tag; `None` if there is none, or if the tag is malformed (the reader
/// will report it).
fn tag_end(text: &str) -> Option<Tag> {
    let bytes = text.as_bytes();
    let (mut at, mut attributes) = (1, 0);
    loop {
        match bytes.get(at)? {
            b'>' => return Some(Tag { end: at + 1, is_empty: bytes[at - 1] == b'/', attributes }),
            quote @ (b'"' | b'\'') => {
                at += 2 + bytes[at + 1..].iter().position(|b| b == quote)?;
                attributes += 1;
            }
            b'<' => return None,
            _ => at += 1,
        }
    }
}

/// Returns the offset after a document type declaration, internal subset included.
fn doctype_end(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut at, mut in_subset) = ("<!DOCTYPE".len(), false);
    loop {
        match bytes.get(at)? {
            b'>' if !in_subset => return Some(at + 1),
            b'[' => in_subset = true,
            b']' => in_subset = false,
            quote @ (b'"' | b'\'') => at += 1 + bytes[at + 1..].iter().position(|b| b == quote)?,
            b'<' if text[at..].starts_with("<!--") => at += text[at..].find("-->")? + 2,
            b'<' if text[at..].starts_with("<?") => at += text[at..].find("?>")? + 1,
            _ => {}
        }
        at += 1;
    }
}

/// Refuses entities that contain markup or could expand beyond [`MAX_EXPANSION`].
fn entities(source: &XmlSource, from: usize, to: usize) -> Result<(), LoadError> {
    let (mut count, mut longest, mut nested) = (0_usize, 0_u64, false);
    for (at, _) in source.text[from..to].match_indices("<!ENTITY") {
        count += 1;
        let declaration = &source.text[from + at..to];
        let Some(open) = declaration.find(['"', '\'']) else { continue };
        let quote = declaration.as_bytes()[open] as char;
        let value = declaration[open + 1..].split(quote).next().unwrap_or("");
        if value.contains('<') || value.contains("&#") {
            return Err(source.refuse(from + at, "an entity without markup or character references"));
        }
        longest = longest.max(value.len() as u64);
        nested |= value.contains('&');
    }
    if count > MAX_ENTITIES {
        return Err(source.too_big(from, "entities", count as u64, MAX_ENTITIES as u64));
    }
    if longest > 0 {
        // The reader follows at most 255 references inside one reference.
        let references = source.text[to..].matches('&').count() as u64;
        let most = references.saturating_mul(longest).saturating_mul(if nested { 256 } else { 1 });
        if most > MAX_EXPANSION {
            return Err(source.too_big(from, "bytes that entities may expand to", most, MAX_EXPANSION));
        }
    }
    Ok(())
}

/// Converts the reader's error to a readable message with its position.
fn explain(source: &XmlSource, error: &roxmltree::Error) -> LoadError {
    use roxmltree::Error as E;
    let expected = match error {
        E::UnexpectedCloseTag(expected, _, _) => format!("</{expected}>"),
        E::UnknownNamespace(prefix, _) => format!("a declaration of the namespace prefix {prefix:?}"),
        E::DuplicatedNamespace(name, _) => format!("the namespace {name:?} to be declared once"),
        E::DuplicatedAttribute(name, _) => format!("the attribute {name:?} once in this element"),
        E::UnknownEntityReference(name, _) => format!("an entity that is declared, not {name:?}"),
        E::MalformedEntityReference(_) => "a reference such as &amp; after &".into(),
        E::EntityReferenceLoop(_) => "entities that do not refer to each other without end".into(),
        E::InvalidAttributeValue(_) => "no < inside an attribute".into(),
        E::NoRootNode => "an element <X3D>".into(),
        E::UnclosedRootNode | E::UnexpectedEndOfStream => "the rest of the file".into(),
        E::UnexpectedDeclaration(_) => "<?xml ...?> only at the very start of the file".into(),
        E::InvalidName(_) => "a name".into(),
        E::NonXmlChar(c, _) => format!("no character U+{:04X}, which XML forbids", *c as u32),
        E::InvalidChar(c, _, _) => format!("{:?}", *c as char),
        E::InvalidChar2(what, _, _) => (*what).into(),
        E::InvalidString(what, _) => format!("{what:?}"),
        E::InvalidComment(_) => "no -- inside a comment".into(),
        E::InvalidCharacterData(_) => "no ]]> in the text".into(),
        E::NodesLimitReached => {
            let limit = MAX_NODES as u64;
            let kind = LoadErrorKind::TooBig { what: "XML nodes", found: limit + 1, limit };
            return LoadError::new(FilePosition::file(&source.name), kind);
        }
        other => format!("well-formed XML ({other})"),
    };
    if matches!(error, E::NoRootNode | E::UnclosedRootNode | E::UnexpectedEndOfStream) {
        return source.refuse(source.text.len(), expected);
    }
    let pos = error.pos();
    let start = source.lines.get(pos.row as usize - 1).copied().unwrap_or(source.text.len());
    let column = source.text[start..].char_indices().nth(pos.col as usize - 1).map_or(0, |(i, _)| i);
    source.refuse(start + column, expected)
}

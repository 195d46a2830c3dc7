//! Rows of the verb table: a verb's name, words, payload, reply and HELP lines.
//!
//! Everything that describes the language to others is derived from these rows: HELP, the protocol
//! page, the Python client's methods, the fuzzer's dictionary.

pub use super::arity::Arity;
use super::codec::Parse;
use super::commands::{Command, Figure};
use super::plain_line::ReadPlain;
use super::scan::find_blank_of_16;
use super::table::{PARSERS, PLAIN, TABLE};

/// Payload rule of a verb: a payload is announced by `:N` at the end of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Payload {
    /// No payload.
    Never,
    /// A payload is required.
    Always,
    /// The verb's parser decides by the words before.
    BySubject,
}

impl Payload {
    /// Returns the rule of a verb that has an argument of each rule.
    pub(super) const fn and(self, other: Payload) -> Payload {
        match (self, other) {
            (Payload::Never, rule) | (rule, Payload::Never) => rule,
            (Payload::Always, _) | (_, Payload::Always) => Payload::Always,
            (Payload::BySubject, Payload::BySubject) => Payload::BySubject,
        }
    }
}

/// Wire encoding of a verb's arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// A line of text.
    Text,
    /// Bytes of a length that the verb knows, without a line.
    Binary,
}

/// Reply to a verb.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply {
    /// None.
    Never,
    /// A line that begins with the verb.
    Line,
    /// A line that begins with the verb and ends with `:N`, and N bytes.
    Bytes,
    /// Lines of text.
    Lines,
    /// A reply to some of its forms, as these say.
    ByForm,
}

/// The memory that a verb reads or writes, and the states of its connection that bound it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Nothing that `TARGET` or `CLIP` concern.
    Connection,
    /// The target of the connection, the frame or a canvas, whatever `CLIP` is.
    Target,
    /// The target, within the clip rectangle.
    Clip,
}

/// Kind of a parameter, for programs that write commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterKind {
    /// Integers.
    Integer,
    /// Reals.
    Real,
    /// An angle in radians, or in degrees before `deg`.
    Angle,
    /// Colours.
    Color,
    /// One name.
    Name,
    /// One of these keywords.
    Keyword(&'static [&'static str]),
    /// This keyword or nothing.
    Flag(&'static str),
    /// Bytes in hex, as one word.
    Hex,
    /// Text up to the end of the line, with its blanks.
    RestOfLine,
    /// The bytes that follow the line or the header.
    Payload,
    /// Words that depend on each other, as the forms of the verb say.
    Words,
}

/// Argument of a verb: a field of its command.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// The field's name.
    pub name: &'static str,
    /// Words of the syntax that stand for it.
    pub syntax: &'static str,
    /// Numbers of words that it takes.
    pub arity: Arity,
    /// Kind of its words.
    pub kind: ParameterKind,
}

/// Category of a verb; HELP and the protocol page follow this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Group {
    /// Pixelflut's own verbs.
    Pixelflut,
    /// Bytes and rectangles of the video memory.
    Memory,
    /// Lines and areas.
    TwoD,
    /// Meshes, cameras, lights, materials.
    ThreeD,
    /// Queries, frames, settings.
    Control,
}

impl Group {
    /// All groups in order.
    pub const ALL: [Group; 5] = [Group::Pixelflut, Group::Memory, Group::TwoD, Group::ThreeD, Group::Control];

    /// Returns the heading of the group in HELP.
    pub const fn title(self) -> &'static str {
        match self {
            Group::Pixelflut => "Pixelflut",
            Group::Memory => "Memory",
            Group::TwoD => "2-D",
            Group::ThreeD => "3-D",
            Group::Control => "Queries and control",
        }
    }
}

/// One syntax of a verb.
#[derive(Clone, Copy, Debug)]
pub struct Form {
    /// The whole command as a template: words in lower case stand for arguments, `[...]` is
    /// optional, `a|b` is a choice.
    pub syntax: &'static str,
    /// One-line description for HELP.
    pub about: &'static str,
}

/// One verb of the command language: a row of the verb table.
pub struct Verb {
    /// Name in upper case.
    pub name: &'static str,
    /// Category under which HELP lists it.
    pub group: Group,
    /// Number of words that it takes.
    pub arity: Arity,
    /// Payload rule.
    pub payload: Payload,
    /// Reply.
    pub reply: Reply,
    /// The memory that it reads or writes.
    pub reach: Reach,
    /// Accepted syntaxes, for HELP and error messages.
    pub forms: &'static [Form],
    /// A valid command, with its payload: what a client would send.
    pub example: &'static str,
    /// Arguments in order.
    pub parameters: &'static [Parameter],
    /// Encoding of the arguments.
    pub encoding: Encoding,
}

impl std::fmt::Debug for Verb {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for Verb {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Verb {}

impl Verb {
    /// Returns all verbs, in the order of HELP.
    pub fn all() -> &'static [Verb] {
        TABLE
    }

    /// Returns the verb of a text line that begins with `word`, in either case. Binary verbs are
    /// not found.
    #[inline]
    pub fn find(word: &[u8]) -> Option<&'static Verb> {
        Verb::find_parser(word).map(|(verb, _)| verb)
    }

    /// Returns the verb as [`Verb::find`] does, and the parser of its arguments.
    #[inline]
    pub(super) fn find_parser(word: &[u8]) -> Option<(&'static Verb, Parse<Command>)> {
        let row = row_of(key(word)?)?;
        PARSERS[row].map(|parse| (&TABLE[row], parse))
    }

    /// Returns the reader of plain lines of the verb at the beginning of a line, and the length of the
    /// word. `None` for other verbs, and if no blank follows.
    #[inline]
    pub(super) fn find_plain(line: &[u8; KEY_BYTES]) -> Option<(ReadPlain<Figure>, usize)> {
        let (key, length) = key_before_blank(line)?;
        PLAIN[row_of(key)?].map(|read| (read, length))
    }

    /// Returns the index in [`Verb::all`] of the verb with this exact name, binary ones included.
    #[inline]
    pub fn index_of(name: &str) -> Option<usize> {
        row_of(key(name.as_bytes())?).filter(|row| TABLE[*row].name == name)
    }

    /// Returns the verb with this exact name, binary ones included.
    pub fn named(name: &str) -> Option<&'static Verb> {
        Verb::index_of(name).map(|row| &TABLE[row])
    }

    /// Returns whether the last argument is the rest of the line: no `:N` is read in it.
    pub fn takes_rest_of_line(&self) -> bool {
        matches!(self.parameters, [.., last] if last.kind == ParameterKind::RestOfLine)
    }

    /// Returns whether the verb belongs to the original Pixelflut protocol. A connection that uses
    /// only such verbs gets no text unasked.
    pub fn is_pixelflut(&self) -> bool {
        self.group == Group::Pixelflut
    }
}

/// Bytes of a key: the letters of a word in upper case, the first in the lowest byte, and the word's
/// length in the highest. No name of a verb is longer than 15 bytes.
pub(super) const KEY_BYTES: usize = 16;

/// Number of slots of the hash index.
const SLOTS: usize = 512;

/// Keys of the verbs, by their place in the table.
static KEYS: [u128; TABLE.len()] = {
    let (mut keys, mut row) = ([0; TABLE.len()], 0);
    while row < TABLE.len() {
        keys[row] = key(TABLE[row].name.as_bytes()).expect("no name has 16 letters");
        row += 1;
    }
    keys
};

/// Hash index of the table: the row plus one, or 0 for an empty slot. Collisions go to the next
/// slot (linear probing).
static INDEX: [u8; SLOTS] = {
    let (mut index, mut row) = ([0; SLOTS], 0);
    while row < TABLE.len() {
        let mut slot = match key(TABLE[row].name.as_bytes()) {
            Some(key) => slot_of(key),
            None => 0,
        };
        while index[slot] != 0 {
            slot = (slot + 1) % SLOTS;
        }
        index[slot] = row as u8 + 1;
        row += 1;
    }
    index
};

/// Returns the key of a word in either case: bit 5 of each byte is masked out, which makes no letter of
/// another byte. `None` if no verb is that long.
const fn key(word: &[u8]) -> Option<u128> {
    if word.len() >= KEY_BYTES {
        return None;
    }
    let (mut bytes, mut i) = ([0; KEY_BYTES], 0);
    while i < word.len() {
        bytes[i] = word[i] & 0xdf;
        i += 1;
    }
    bytes[KEY_BYTES - 1] = word.len() as u8;
    Some(u128::from_le_bytes(bytes))
}

/// Returns the key of the word before the first blank, and its length.
#[inline]
fn key_before_blank(line: &[u8; KEY_BYTES]) -> Option<(u128, usize)> {
    let length = find_blank_of_16(line)?;
    let letters = u128::from_le_bytes(*line) & ((1 << (8 * length)) - 1) & (u128::MAX / 255 * 0xdf);
    (length < KEY_BYTES).then_some((letters | (length as u128) << 120, length))
}

/// Returns the slot at which the search for a key begins.
const fn slot_of(key: u128) -> usize {
    let mixed = (key as u64) ^ ((key >> 64) as u64).wrapping_mul(0xff51_afd7_ed55_8ccd);
    (mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 55) as usize
}

/// Returns the row of the verb with a key.
#[inline]
fn row_of(key: u128) -> Option<usize> {
    let mut slot = slot_of(key);
    loop {
        let row = INDEX[slot].checked_sub(1)? as usize;
        if KEYS[row] == key {
            return Some(row);
        }
        slot = (slot + 1) % SLOTS;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_text_verb_is_found_in_either_case_and_no_binary_one() {
        for verb in Verb::all() {
            let expected = (verb.encoding == Encoding::Text).then_some(verb);
            assert_eq!(Verb::find(verb.name.as_bytes()), expected, "{}", verb.name);
            assert_eq!(Verb::find(verb.name.to_lowercase().as_bytes()), expected, "{}", verb.name);
            assert_eq!(Verb::named(verb.name), Some(verb));
            assert_eq!(Verb::index_of(verb.name).map(|i| &Verb::all()[i]), Some(verb));
        }
        for word in [
            "",
            "P",
            "PXX",
            "LIN",
            "LINEE",
            "@INE",
            "LINE\0",
            "pb",
            "pxmulti",
            "\u{fffd}",
            "HELPHELPHELPHELP",
            "HELPHELPHELPHELPHELP",
        ] {
            assert_eq!(Verb::find(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn no_text_verb_begins_with_the_reserved_letters() {
        for verb in Verb::all() {
            let text = verb.encoding == Encoding::Text;
            assert!(!text || !verb.name.starts_with("PB"), "{}", verb.name);
            assert!(verb.name.bytes().all(|b| b.is_ascii_uppercase()), "{}", verb.name);
        }
    }

    #[test]
    fn the_pixelflut_verbs_are_those_of_the_specification() {
        let mut names: Vec<_> = Verb::all().iter().filter(|v| v.is_pixelflut()).map(|v| v.name).collect();
        names.sort_unstable();
        assert_eq!(names, ["HELP", "OFFSET", "PB", "PX", "PXMULTI", "QUIT", "SIZE", "STATS"]);
    }

    /// Returns the least number of words that a template allows, and the most, `None` if it ends in
    /// `...`.
    fn arity_of(syntax: &str) -> (usize, Option<usize>) {
        let (mut least, mut most, mut endless, mut depth) = (0, 0, false, 0i32);
        for word in syntax.split(' ').skip(1) {
            if word == "|" {
                return arity_of(&syntax[..syntax.find(" | ").unwrap()]);
            }
            depth += word.matches('[').count() as i32;
            match word.trim_matches(['[', ']']) {
                "..." => endless = true,
                ":N" => {}
                word => {
                    // `ka(3)` and `m00..m33` stand for several words.
                    let n = match word.split_once('(') {
                        Some((_, n)) => n.trim_end_matches([')', ']']).parse().unwrap(),
                        None if word == "m00..m33" => 16,
                        None => 1,
                    };
                    most += n;
                    least += if depth == 0 { n } else { 0 };
                }
            }
            depth -= word.matches(']').count() as i32;
        }
        (least, (!endless).then_some(most))
    }

    #[test]
    fn the_counts_are_those_of_the_templates() {
        for verb in Verb::all().iter().filter(|v| v.encoding == Encoding::Text) {
            for form in verb.forms {
                assert_eq!(form.syntax.split(' ').next(), Some(verb.name));
                assert!(!form.about.is_empty() && form.about.is_ascii() && form.syntax.is_ascii());
                let (least, most) = arity_of(form.syntax);
                assert!(verb.arity.allows(least), "{}: {least}", form.syntax);
                assert!(most.is_none_or(|m| verb.arity.allows(m)), "{}: {most:?}", form.syntax);
                match verb.payload {
                    Payload::Never => assert!(!form.syntax.ends_with(":N"), "{}", form.syntax),
                    Payload::Always => assert!(form.syntax.ends_with(":N"), "{}", form.syntax),
                    Payload::BySubject => {}
                }
            }
            let all: Vec<_> = verb.forms.iter().map(|f| arity_of(f.syntax)).collect();
            let (least, most) = (verb.arity.least(), verb.arity.most());
            assert_eq!(all.iter().map(|c| c.0).min(), Some(least), "{}", verb.name);
            // Words after a name that chooses the form are counted by the form's own parser.
            if most.is_some() || all.len() == 1 {
                let found = all.iter().map(|c| c.1).reduce(|a, b| Some(a?.max(b?))).flatten();
                assert_eq!(found, most, "{}", verb.name);
            }
        }
    }
}

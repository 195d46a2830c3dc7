//! Arguments of a method as a command: positional and keyword arguments, spread over the slots of
//! the verb.
//!
//! In: what a Python program has given. Out: the line and the payload of the command. Tuples, lists
//! and arrays are spread where numbers are expected, so points may be given as pairs; a colour is a
//! name, hex digits or bytes, and a list of colours is spread where several may stand. The ranges of
//! numbers and the meanings of words are checked by the command language itself.

use crate::errors;
use crate::items::{self, Colour};
use crate::slots::{Form, Slot, SlotKind};
use fbptr::command::{Command, Encoding, Rect, parse_color};
use fbptr::error::Code;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBool, PyBytes, PyDict, PyString, PyTuple};
use std::collections::VecDeque;

/// Further names of slots, by which keyword arguments may give them.
const ALIASES: &[(&str, &[&str])] = &[
    ("center", &["cx", "cy"]),
    ("centre", &["cx", "cy"]),
    ("radius", &["r"]),
    ("at", &["x", "y"]),
    ("pos", &["x", "y"]),
    ("size", &["w", "h"]),
    ("width", &["w"]),
    ("height", &["h"]),
    ("text", &["utf8"]),
    ("data", &["hexbytes", "rgba", "packed", "file", "x3d", "json", "utf8"]),
    ("path", &["file"]),
    ("at", &["reference"]),
    ("rect", &["x", "y", "w", "h"]),
];
/// Most lists within lists that are spread to find one value: a list that contains itself ends here.
const MOST_NESTED: usize = 32;
/// Spellings of the parameter of colours.
const COLOUR_NAMES: &[&str] = &["color", "colour", "colors", "colours"];

/// A command's line without its payload's length, and its payload.
pub struct Words {
    pub line: String,
    pub payload: Option<Payload>,
}

/// Bytes of a payload.
pub enum Payload {
    /// Those of an object that cannot change, not copied.
    Shared(PyBackedBytes),
    /// A copy.
    Own(Vec<u8>),
}

impl Words {
    /// Returns the rectangle and the bytes of a `BLIT` of bytes that cannot change, which need not be
    /// copied to be drawn; `None` for anything else, and for arguments that are refused.
    pub fn shared_picture(&self, form: &Form) -> Option<(Rect, &[u8])> {
        let Some(Payload::Shared(bytes)) = &self.payload else { return None };
        let rect = self.line.strip_prefix("BLIT ").filter(|_| form.verb.name == "BLIT")?;
        match Command::parse(format!("READ {rect}").as_bytes(), None) {
            Ok(Command::Read { rect }) if rect.w >= 0 && rect.h >= 0 => {
                (bytes.len() as u64 == rect.w as u64 * rect.h as u64 * 4).then_some((rect, bytes))
            }
            _ => None,
        }
    }
}

/// Arguments of one call.
struct Given<'py> {
    py: Python<'py>,
    form: &'static Form,
    positional: VecDeque<Bound<'py, PyAny>>,
    keywords: Vec<(String, Bound<'py, PyAny>)>,
    words: Words,
}

/// Returns the words of a call.
pub fn words<'py>(
    py: Python<'py>,
    form: &'static Form,
    positional: &Bound<'py, PyTuple>,
    keywords: Option<&Bound<'py, PyDict>>,
) -> PyResult<Words> {
    let keywords = match keywords {
        Some(given) => {
            given.iter().map(|(key, value)| Ok((key.extract()?, value))).collect::<PyResult<_>>()?
        }
        None => Vec::new(),
    };
    let line = String::with_capacity(64) + form.verb.name;
    let mut given = Given {
        py,
        form,
        positional: positional.iter().collect(),
        keywords,
        words: Words { line, payload: None },
    };
    given.rotate_colour();
    given.fill()?;
    Ok(given.words)
}

/// Returns the command of a call.
pub fn command(py: Python<'_>, form: &Form, words: Words) -> PyResult<Command> {
    let verb = form.verb.name;
    let payload = words.payload.map(|payload| match payload {
        Payload::Shared(bytes) => bytes.to_vec(),
        Payload::Own(bytes) => bytes,
    });
    if form.verb.encoding == Encoding::Text {
        return Command::parse(words.line.as_bytes(), payload)
            .map_err(|error| errors::of_fault(py, 0, verb, &(&error).into()));
    }
    let mut found = words.line.split(' ').skip(1);
    let mut short = |name: &str| {
        let word = found.next().unwrap_or("");
        let expected = || {
            errors::wrong(
                py,
                Code::Num,
                verb,
                format!("{name} must be a whole number from 0 to 65535, got {word:?}"),
            )
        };
        word.parse::<u16>().map_err(|_| expected())
    };
    let (x, y) = (short("x")?, short("y")?);
    match payload {
        Some(rgba) => Ok(Command::PixelRun { x, y, rgba }),
        None => {
            let word = found.next().unwrap_or("");
            let color = parse_color(word.as_bytes()).ok_or_else(|| {
                errors::wrong(py, Code::Colour, verb, format!("not a colour, got {word:?}"))
            })?;
            Ok(Command::BinaryPixel { x, y, color })
        }
    }
}

impl<'py> Given<'py> {
    fn wrong(&self, code: Code, message: impl std::fmt::Display) -> PyErr {
        let syntax = self.form.verb.forms.first().map_or("", |form| form.syntax);
        errors::wrong(self.py, code, self.form.verb.name, format!("{message} ({syntax})"))
    }

    /// Moves a colour that was given last to the front, for figures whose form begins with it: a
    /// program may give the points first, as for all other figures.
    fn rotate_colour(&mut self) {
        let begins = self.form.slots.first().is_some_and(|slot| slot.kind == SlotKind::Color);
        if !begins || self.positional.len() < 2 {
            return;
        }
        let is_colour = |item: Option<&Bound<'py, PyAny>>| {
            item.is_some_and(|item| matches!(items::colour(item), Ok(Colour::Word(_))))
        };
        if !is_colour(self.positional.front()) && is_colour(self.positional.back()) {
            self.positional.rotate_right(1);
        }
    }

    /// Takes a keyword argument by one of its names.
    fn keyword(&mut self, name: &str) -> Option<Bound<'py, PyAny>> {
        let at = self.keywords.iter().position(|(key, _)| key == name)?;
        Some(self.keywords.remove(at).1)
    }

    /// Takes the keyword argument that gives all slots from `at` on that it stands for. Returns it
    /// with the number of slots.
    fn keyword_from(&mut self, at: usize) -> Option<(Bound<'py, PyAny>, usize)> {
        if self.keywords.is_empty() {
            return None;
        }
        let slots = &self.form.slots[at..];
        let first = slots[0];
        let of_field = slots.iter().take_while(|slot| slot.field == first.field).count();
        let of_word = slots.iter().take_while(|slot| slot.word == first.word).count();
        let is_start = at == 0 || self.form.slots[at - 1].field != first.field;
        if of_field > of_word
            && is_start
            && let Some(item) = self.keyword(first.field)
        {
            return Some((item, of_field));
        }
        if let Some(item) = self.keyword(first.word) {
            return Some((item, of_word));
        }
        if is_start && let Some(item) = self.keyword(first.field) {
            return Some((item, of_field));
        }
        if first.kind == SlotKind::Color && is_start {
            let found = COLOUR_NAMES.iter().find_map(|name| self.keyword(name));
            if let Some(item) = found {
                return Some((item, of_field));
            }
        }
        for (alias, words) in ALIASES {
            let stands = words.len() <= slots.len()
                && (slots.iter().zip(*words).all(|(slot, word)| slot.word == *word)
                    || words.len() == 1 && is_start && words[0] == first.field
                    || *alias == "data" && words.contains(&first.word));
            if stands && let Some(item) = self.keyword(alias) {
                let count = if words.len() == 1 && words[0] == first.field { of_field } else { words.len() };
                return Some((item, if *alias == "data" { 1 } else { count }));
            }
        }
        None
    }

    /// Fills all slots.
    fn fill(&mut self) -> PyResult<()> {
        let mut at = 0;
        while at < self.form.slots.len() {
            let slot = self.form.slots[at];
            if let SlotKind::Literal(word) = slot.kind {
                self.words.line.push(' ');
                self.words.line.push_str(word);
                let same = |item: &Bound<'py, PyAny>| {
                    item.extract::<String>().is_ok_and(|text| text.eq_ignore_ascii_case(word))
                };
                if self.positional.front().is_some_and(same) {
                    self.positional.pop_front();
                }
                at += 1;
                continue;
            }
            if let Some((item, count)) = self.keyword_from(at) {
                let mut queue = VecDeque::from([item]);
                for slot in &self.form.slots[at..at + count] {
                    self.fill_slot(slot, &mut queue)?;
                }
                if let Some(left) = queue.front() {
                    let message = format!("{} has one value too many, {}", slot.field, shown(left));
                    return Err(self.wrong(Code::Args, message));
                }
                at += count;
                continue;
            }
            let mut queue = std::mem::take(&mut self.positional);
            let filled = self.fill_slot(&slot, &mut queue);
            self.positional = queue;
            filled?;
            at += 1;
        }
        if let Some(payload) = self.keyword("payload").filter(|payload| !payload.is_none()) {
            self.words.payload = Some(self.payload(&payload)?);
        }
        if let Some(item) = self.positional.front() {
            let message = format!("one argument too many, {}", shown(item));
            return Err(self.wrong(Code::Args, message));
        }
        if let Some((key, _)) = self.keywords.first() {
            let message = format!("no argument {key:?} is known, or it was given twice");
            return Err(self.wrong(Code::Args, message));
        }
        Ok(())
    }

    /// Fills one slot from the front of the queue.
    fn fill_slot(&mut self, slot: &Slot, queue: &mut VecDeque<Bound<'py, PyAny>>) -> PyResult<()> {
        let mut spread = 0;
        loop {
            let Some(item) = queue.pop_front() else {
                return match slot.is_optional {
                    true => Ok(()),
                    false => Err(self.wrong(Code::Args, format!("{} is missing", slot.word))),
                };
            };
            let absent = match slot.kind {
                SlotKind::Word(_, word) => word,
                _ => None,
            };
            if item.is_none() {
                match (absent, slot.is_optional) {
                    (Some(word), _) => self.push(word),
                    (None, true) => {}
                    (None, false) => return Err(self.wrong(Code::Args, format!("{} is None", slot.word))),
                }
                if slot.kind != SlotKind::Many {
                    return Ok(());
                }
                continue;
            }
            match slot.kind {
                SlotKind::Integer | SlotKind::Real | SlotKind::Many => {
                    if items::is_number(&item) {
                        items::push_number(&item, slot.kind == SlotKind::Integer, &mut self.words.line)?;
                    } else if items::is_text(&item) {
                        self.push_word(&item, slot)?;
                    } else if let Some(parts) = items::parts(&item) {
                        spread += 1;
                        if spread > MOST_NESTED {
                            return Err(self.wrong(Code::Args, format!("{} is nested too deeply", slot.word)));
                        }
                        parts?.into_iter().rev().for_each(|part| queue.push_front(part));
                        continue;
                    } else {
                        let message = format!("{} must be a number, got {}", slot.word, shown(&item));
                        return Err(self.wrong(Code::Num, message));
                    }
                    if slot.kind == SlotKind::Many {
                        spread = 0;
                        continue;
                    }
                    return Ok(());
                }
                SlotKind::Color => match items::colour(&item)? {
                    Colour::Word(word) => return self.push_checked(&word, slot),
                    Colour::Several(_) if spread == MOST_NESTED => {
                        return Err(self.wrong(Code::Args, format!("{} is nested too deeply", slot.word)));
                    }
                    Colour::Several(parts) => {
                        spread += 1;
                        parts.into_iter().rev().for_each(|part| queue.push_front(part));
                    }
                    Colour::None => {
                        let message = format!(
                            "{} must be a colour: a name, \"#rrggbb\", or 3 or 4 numbers from 0 to 255, got {}",
                            slot.word,
                            shown(&item)
                        );
                        return Err(self.wrong(Code::Colour, message));
                    }
                },
                SlotKind::Payload => {
                    self.words.payload = Some(self.payload(&item)?);
                    return Ok(());
                }
                _ => return self.fill_word(slot, &item),
            }
        }
    }

    /// Fills a slot of one word or text.
    fn fill_word(&mut self, slot: &Slot, item: &Bound<'py, PyAny>) -> PyResult<()> {
        match slot.kind {
            SlotKind::Flag(word) => {
                let is_word = items::is_text(item) && item.extract::<String>()?.eq_ignore_ascii_case(word);
                if is_word || !items::is_text(item) && item.is_truthy()? {
                    self.push(word);
                } else if items::is_text(item) {
                    let message = format!("{} must be True or False, got {}", slot.word, shown(item));
                    return Err(self.wrong(Code::Args, message));
                }
                Ok(())
            }
            SlotKind::Hex => match item.cast::<PyString>() {
                Ok(text) => self.push_checked(text.to_str()?, slot),
                Err(_) => {
                    let bytes = self.bytes(item)?;
                    let digits: String = bytes.iter().map(|b| format!("{b:02x}")).collect();
                    self.push(&digits);
                    Ok(())
                }
            },
            SlotKind::Text => {
                let text = item.str()?;
                let text = text.to_str()?;
                if text.contains(['\n', '\r']) {
                    return Err(self.wrong(Code::Args, format!("{} must be one line", slot.word)));
                }
                self.push(text);
                Ok(())
            }
            SlotKind::Word(list, _) if item.is_instance_of::<PyBool>() && list.contains(&"on") => {
                self.push(if item.is_truthy()? { "on" } else { "off" });
                Ok(())
            }
            SlotKind::Word(..) if items::is_number(item) => {
                items::push_number(item, true, &mut self.words.line)
            }
            _ if items::is_text(item) => self.push_word(item, slot),
            _ => Err(self.wrong(Code::Args, format!("{} must be a word, got {}", slot.word, shown(item)))),
        }
    }

    fn payload(&self, item: &Bound<'py, PyAny>) -> PyResult<Payload> {
        match item.cast::<PyBytes>() {
            Ok(bytes) => Ok(Payload::Shared(bytes.clone().into())),
            Err(_) => self.bytes(item).map(Payload::Own),
        }
    }

    fn bytes(&self, item: &Bound<'py, PyAny>) -> PyResult<Vec<u8>> {
        let message = || format!("expected bytes, text or an array of bytes, got {}", shown(item));
        items::bytes(item).ok_or_else(|| self.wrong(Code::Args, message()))
    }

    fn push(&mut self, word: &str) {
        self.words.line.push(' ');
        self.words.line.push_str(word);
    }

    fn push_word(&mut self, item: &Bound<'py, PyAny>, slot: &Slot) -> PyResult<()> {
        let text = item.cast::<PyString>().map_err(PyErr::from)?;
        self.push_checked(text.to_str()?, slot)
    }

    /// Appends a word, which must be one.
    fn push_checked(&mut self, word: &str, slot: &Slot) -> PyResult<()> {
        if word.is_empty() || word.contains(|c: char| c.is_whitespace() || c.is_control()) {
            let message = format!("{} must be one word without blanks, got {word:?}", slot.word);
            return Err(self.wrong(Code::Args, message));
        }
        self.push(word);
        Ok(())
    }
}

/// Returns a value as messages show it.
fn shown(item: &Bound<'_, PyAny>) -> String {
    let text = item.repr().map(|text| text.to_string()).unwrap_or_else(|_| "?".into());
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

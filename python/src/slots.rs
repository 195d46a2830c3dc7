//! Slots: the words of each verb's forms, as the places that Python arguments go to.
//!
//! In: rows of the verb table. Out: for each verb a list of slots, made once. A slot has the names
//! by which a keyword argument may give it: the word of the form, and the name of its parameter.

use fbptr::command::{Encoding, Parameter, ParameterKind, Verb};
use std::sync::OnceLock;

/// Kind of a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotKind {
    /// A number that must be whole.
    Integer,
    /// A number.
    Real,
    /// A colour.
    Color,
    /// One of these keywords, or a name, or another single word. The second is the word for `None`.
    Word(&'static [&'static str], Option<&'static str>),
    /// This keyword or nothing.
    Flag(&'static str),
    /// A word that is always the same.
    Literal(&'static str),
    /// Bytes in hex.
    Hex,
    /// The rest of the line.
    Text,
    /// The payload.
    Payload,
    /// Numbers and words as many as there are.
    Many,
}

/// A place of an argument.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// Name of the parameter in the table.
    pub field: &'static str,
    /// Word of the form.
    pub word: &'static str,
    pub kind: SlotKind,
    pub is_optional: bool,
}

/// A verb with its slots.
pub struct Form {
    pub verb: &'static Verb,
    pub slots: Vec<Slot>,
}

/// Returns the verbs of the table with their slots.
pub fn forms() -> &'static [Form] {
    static FORMS: OnceLock<Vec<Form>> = OnceLock::new();
    FORMS.get_or_init(|| Verb::all().iter().map(form).collect())
}

/// Returns whether a parameter stands for words that its syntax does not name one by one.
fn is_several(parameter: &Parameter) -> bool {
    match parameter.kind {
        ParameterKind::Words => true,
        ParameterKind::RestOfLine => false,
        _ => parameter.syntax.contains(".."),
    }
}

fn form(verb: &'static Verb) -> Form {
    let mut slots = Vec::new();
    for parameter in verb.parameters {
        if is_several(parameter) {
            let (field, word) = (parameter.name, parameter.name);
            slots.push(Slot { field, word, kind: SlotKind::Many, is_optional: true });
            if parameter.kind == ParameterKind::Words {
                break;
            }
            continue;
        }
        add(parameter, verb.encoding, &mut slots);
    }
    // Further forms of a verb have fewer words than its first one, or more.
    let is_word =
        |slot: &Slot| !matches!(slot.kind, SlotKind::Payload | SlotKind::Literal(_) | SlotKind::Many);
    let words = slots.iter().filter(|slot| is_word(slot)).count();
    let has_many = slots.iter().any(|slot| slot.kind == SlotKind::Many);
    if !has_many && verb.encoding == Encoding::Text && verb.arity.most().is_some_and(|most| most > words) {
        let literals = slots.iter().filter(|slot| matches!(slot.kind, SlotKind::Literal(_))).count();
        if verb.arity.most().is_some_and(|most| most > words + literals) {
            slots.push(Slot { field: "args", word: "args", kind: SlotKind::Many, is_optional: true });
        }
    }
    if !has_many && verb.encoding == Encoding::Text {
        let least = verb.arity.least();
        let mut seen = 0;
        for slot in slots.iter_mut().filter(|slot| slot.kind != SlotKind::Payload) {
            seen += 1;
            slot.is_optional |= seen > least;
        }
    }
    Form { verb, slots }
}

/// Adds the slots of a parameter.
fn add(parameter: &Parameter, encoding: Encoding, slots: &mut Vec<Slot>) {
    let mut push = |word: &'static str, kind, is_optional| {
        slots.push(Slot { field: parameter.name, word, kind, is_optional });
    };
    match parameter.kind {
        ParameterKind::Flag(word) => return push(parameter.name, SlotKind::Flag(word), true),
        ParameterKind::RestOfLine => return push("text", SlotKind::Text, false),
        ParameterKind::Payload => {
            if let Some((literal, _)) = parameter.syntax.split_once(' ') {
                push(literal, SlotKind::Literal(literal), false);
            }
            return push(parameter.name, SlotKind::Payload, false);
        }
        _ if encoding == Encoding::Binary => {
            return push(parameter.name, kind_of(parameter, parameter.syntax), false);
        }
        _ => {}
    }
    let mut depth = 0;
    for word in parameter.syntax.split(' ') {
        depth += word.matches('[').count();
        let is_optional = depth > 0;
        depth -= word.matches(']').count();
        let word = word.trim_matches(['[', ']']);
        let kind = kind_of(parameter, word);
        if let ParameterKind::Keyword(list) = parameter.kind {
            // A field such as `over` of `replace|over` is no name for the word.
            push(if list.contains(&parameter.name) { "mode" } else { parameter.name }, kind, is_optional);
            continue;
        }
        // `vrp(3)` stands for three words.
        let (name, count) = match word.split_once('(') {
            Some((name, count)) => (name, count.trim_end_matches(')').parse().unwrap_or(1)),
            None => (word, 1),
        };
        let is_name = name.bytes().all(|b| b.is_ascii_alphanumeric());
        for _ in 0..count {
            push(if is_name { name } else { parameter.name }, kind, is_optional);
        }
    }
}

fn kind_of(parameter: &Parameter, word: &'static str) -> SlotKind {
    match parameter.kind {
        ParameterKind::Integer => SlotKind::Integer,
        ParameterKind::Real | ParameterKind::Angle => SlotKind::Real,
        ParameterKind::Color => SlotKind::Color,
        ParameterKind::Keyword(list) => SlotKind::Word(list, None),
        ParameterKind::Hex => SlotKind::Hex,
        _ => SlotKind::Word(&[], word.split('|').find(|w| w.bytes().all(|b| b.is_ascii_uppercase()))),
    }
}

//! Verifies that the Python client has the methods of the verb table, one a verb.

use crate::generated::{check_block, check_copy};
use fbptr::command::{Encoding, Parameter, ParameterKind, Payload, Reply, Verb};
use std::fmt::Write;

const CLIENT: &str = "clients/python/fbptr.py";
/// Copy of the client in the Python package; a link would not survive every checkout.
const IN_PACKAGE: &str = "python/fbptr/client.py";
const MARKS: [&str; 2] = [
    "    # Made from the verb table: BLESS=1 cargo test --test decoder python\n",
    "    # The end of what is made from the verb table\n",
];

/// Longest line of a docstring, in columns.
const COLUMNS: usize = 100;

/// Signature and words of a method, in the order of the table's parameters.
#[derive(Default)]
struct Method {
    parameters: Vec<String>,
    /// Expressions of the words in the line, or of the bytes of a binary command.
    words: Vec<String>,
    payload: Option<String>,
}

impl Method {
    fn of(verb: &Verb) -> Method {
        let mut method = Method::default();
        for (i, parameter) in verb.parameters.iter().enumerate() {
            if is_several(parameter) {
                // The rest of the line, as it is.
                let rest = verb.parameters[i..].iter().map(|p| p.name).collect::<Vec<_>>().join("_and_");
                method.words.push(format!("*{rest}"));
                method.parameters.push(format!("*{rest}"));
                break;
            }
            method.add(parameter, verb.encoding);
        }
        if verb.payload == Payload::BySubject {
            method.parameters.push("payload=None".into());
            method.payload = Some("payload".into());
        }
        method
    }

    /// Adds a parameter of the table: each of its words is one of the method's.
    fn add(&mut self, parameter: &Parameter, encoding: Encoding) {
        if let ParameterKind::Flag(word) = parameter.kind {
            self.parameters.push(format!("{}=False", parameter.name));
            self.words.push(format!("\"{word}\" if {} else None", parameter.name));
            return;
        }
        if parameter.kind == ParameterKind::RestOfLine {
            self.parameters.push(parameter.name.into());
            self.words.push(parameter.name.into());
            return;
        }
        if encoding == Encoding::Binary {
            self.parameters.push(parameter.name.into());
            self.words.push(match parameter.kind {
                ParameterKind::Color => format!("_rgba({})", parameter.name),
                ParameterKind::Payload => format!("_run({})", parameter.name),
                _ => parameter.name.into(),
            });
            return;
        }
        let mut depth = 0;
        for word in parameter.syntax.split(' ') {
            depth += word.matches('[').count();
            let word = word.trim_matches(['[', ']']);
            if word == ":N" {
                self.parameters.push(parameter.name.into());
                self.payload = Some(parameter.name.into());
            } else if word.bytes().all(|b| b.is_ascii_uppercase() || b.is_ascii_digit()) {
                self.words.push(format!("\"{word}\""));
            } else {
                self.add_word(parameter, word, depth > 0);
            }
        }
    }

    fn add_word(&mut self, parameter: &Parameter, word: &str, is_optional: bool) {
        let name = match parameter.kind {
            // A field such as `over` of `replace|over` is no name for the word.
            ParameterKind::Keyword(list) if list.contains(&parameter.name) => "mode",
            ParameterKind::Keyword(_) => parameter.name,
            _ => word.split(['(', '|']).next().unwrap_or(word),
        };
        let name = if name.bytes().all(|b| b.is_ascii_alphanumeric()) { name } else { parameter.name };
        self.parameters.push(format!("{name}{}", if is_optional { "=None" } else { "" }));
        self.words.push(match parameter.kind {
            ParameterKind::Color => format!("_colour({name})"),
            ParameterKind::Hex => format!("_hex({name})"),
            _ => name.to_owned(),
        });
    }

    /// Writes the method as Python.
    fn write(&self, verb: &Verb, out: &mut String) {
        let parameters: String = self.parameters.iter().map(|p| format!(", {p}")).collect();
        let words: String = self.words.iter().map(|w| format!(", {w}")).collect();
        // Words that may be left out are `None` to a query, which takes words alone.
        let query = match self.parameters.iter().any(|p| p.contains('=')) {
            true => format!(", *_words({})", self.words.join(", ")),
            false => words.clone(),
        };
        let name = verb.name;
        let body = match (verb.encoding, verb.reply) {
            (Encoding::Binary, _) => format!("self._binary(\"{name}\"{words})"),
            (_, Reply::Line) => format!("return self.ask(\"{name}\"{query})"),
            (_, Reply::Bytes) => format!("return self._ask_bytes(\"{name}\"{query})"),
            _ => match &self.payload {
                Some(payload) => format!("self._send_verb(\"{name}\"{words}, payload={payload})"),
                None => format!("self._send_verb(\"{name}\"{words})"),
            },
        };
        let docs = docstring(verb);
        writeln!(out, "\n    def {}(self{parameters}):", name.to_lowercase()).expect("a String takes all");
        writeln!(out, "{docs}        {body}").expect("a String takes all");
    }
}

/// Returns whether a parameter stands for a number of words that its syntax does not name one by
/// one.
fn is_several(parameter: &Parameter) -> bool {
    match parameter.kind {
        ParameterKind::Words => true,
        ParameterKind::RestOfLine => false,
        _ => parameter.syntax.contains(".."),
    }
}

/// Returns the forms of a verb as a docstring, with its indent and LF.
fn docstring(verb: &Verb) -> String {
    let indent = " ".repeat(8);
    let paragraphs = verb.forms.iter().map(|form| {
        let (mut text, mut column) = (String::new(), 3);
        for word in format!("`{}`: {}.", form.syntax, form.about).split(' ') {
            // The quotes may follow the last word.
            if column + word.len() + indent.len() + 3 > COLUMNS {
                text = format!("{}\n{indent}", text.trim_end());
                column = 0;
            }
            column += word.len() + 1;
            text += word;
            text.push(' ');
        }
        text.trim_end().to_owned()
    });
    let paragraphs: Vec<String> = paragraphs.collect();
    let text = paragraphs.join(&format!("\n\n{indent}"));
    match text.contains('\n') {
        true => format!("{indent}\"\"\"{text}\n{indent}\"\"\"\n"),
        false => format!("{indent}\"\"\"{text}\"\"\"\n"),
    }
}

/// Returns the methods of all verbs but those whose reply depends on their form, or has no end by
/// itself: they are written by hand.
fn methods() -> String {
    let mut text = String::new();
    for verb in Verb::all().iter().filter(|v| !matches!(v.reply, Reply::ByForm | Reply::Lines)) {
        Method::of(verb).write(verb, &mut text);
    }
    text.push('\n');
    text
}

#[test]
fn the_clients_methods_are_those_of_the_table() {
    check_block(CLIENT, MARKS, &methods());
}

#[test]
fn the_packages_client_is_the_single_file() {
    check_copy(CLIENT, IN_PACKAGE);
}

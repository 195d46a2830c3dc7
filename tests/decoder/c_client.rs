//! Verifies that the client in C has the functions of the verb table, one a verb.

use crate::generated::check_block;
use fbptr::command::{Encoding, Parameter, ParameterKind, Payload, Reply, Verb};
use std::fmt::Write;

const CLIENT: &str = "clients/c/fbptr.h";
const MARKS: [&str; 2] = [
    "/* Made from the verb table: BLESS=1 cargo test --test decoder c_client */\n",
    "/* The end of what is made from the verb table */\n",
];

/// Parameters and statements of a function.
#[derive(Default)]
struct Function {
    parameters: Vec<String>,
    statements: Vec<String>,
    payload: Option<String>,
}

impl Function {
    fn of(verb: &Verb) -> Function {
        let mut function = Function::default();
        for parameter in verb.parameters {
            if function.add(parameter) {
                break;
            }
        }
        if verb.payload == Payload::BySubject {
            function.payload = Some("payload".into());
        }
        if let Some(payload) = &function.payload {
            function.parameters.push(format!("const void *{payload}, size_t bytes"));
        }
        function
    }

    /// Adds a parameter of the table. Returns whether the rest of the words is one text.
    fn add(&mut self, parameter: &Parameter) -> bool {
        match parameter.kind {
            ParameterKind::Flag(word) => {
                self.parameters.push(format!("int {}", parameter.name));
                self.statements.push(format!("fbptr_put_word(fb, {} ? \"{word}\" : NULL)", parameter.name));
                return false;
            }
            ParameterKind::RestOfLine => {
                self.word("const char *", parameter.name, "word");
                return false;
            }
            ParameterKind::Words => return self.rest(),
            _ if parameter.syntax.contains("..") => return self.rest(),
            _ => {}
        }
        let mut depth = 0;
        for word in parameter.syntax.split(' ') {
            depth += word.matches('[').count();
            let name = word.trim_matches(['[', ']']);
            if name == ":N" {
                self.payload = Some(parameter.name.into());
                continue;
            }
            if name.bytes().all(|b| b.is_ascii_uppercase() || b.is_ascii_digit()) {
                self.statements.push(format!("fbptr_put_word(fb, \"{name}\")"));
                continue;
            }
            let name = name.split(['(', '|']).next().unwrap_or(name);
            let is_name = name.bytes().all(|b| b.is_ascii_alphanumeric()) && !name.is_empty();
            let name =
                if is_name && name.bytes().any(|b| b.is_ascii_lowercase()) { name } else { parameter.name };
            match parameter.kind {
                ParameterKind::Color => self.word("const char *", name, "word"),
                _ if depth > 0 => return self.rest(),
                ParameterKind::Integer => self.word("int ", name, "int"),
                ParameterKind::Real | ParameterKind::Angle => self.word("double ", name, "real"),
                ParameterKind::Keyword(list) if list.contains(&name) => {
                    self.word("const char *", "mode", "word")
                }
                _ => self.word("const char *", name, "word"),
            }
        }
        false
    }

    fn word(&mut self, kind: &str, name: &str, put: &str) {
        self.parameters.push(format!("{kind}{name}"));
        self.statements.push(format!("fbptr_put_{put}(fb, {name})"));
    }

    fn rest(&mut self) -> bool {
        self.word("const char *", "rest", "word");
        true
    }

    fn write(&self, verb: &Verb, out: &mut String) {
        let (mut parameters, end) = (
            self.parameters.clone(),
            match &self.payload {
                Some(payload) => format!("fbptr_end(fb, {payload}, bytes)"),
                None => "fbptr_end(fb, NULL, 0)".to_owned(),
            },
        );
        let (kind, end) = match verb.reply {
            Reply::Line => {
                parameters.push("char *reply, size_t room".into());
                ("int", vec![end, format!("return fbptr_answer(fb, \"{}\", reply, room)", verb.name)])
            }
            Reply::Bytes => {
                parameters.push("void *to, size_t room".into());
                ("long", vec![end, format!("return fbptr_answer_bytes(fb, \"{}\", to, room)", verb.name)])
            }
            _ => ("int", vec![format!("return {end}")]),
        };
        let forms: Vec<String> =
            verb.forms.iter().map(|form| format!("{}: {}", form.syntax, form.about)).collect();
        let parameters: String = parameters.iter().map(|p| format!(", {p}")).collect();
        let name = verb.name.to_lowercase();
        let about = comment(&forms.join("; "));
        let begin = format!("fbptr_put(fb, \"{}\", {})", verb.name, verb.name.len());
        let statements: String = std::iter::once(&begin)
            .chain(&self.statements)
            .chain(&end)
            .map(|s| format!("    {s};\n"))
            .collect();
        write!(
            out,
            "\n/* {about} */\nstatic inline {kind} fbptr_{name}(fbptr *fb{parameters})\n{{\n{statements}}}\n"
        )
        .expect("a String takes all");
    }
}

/// Longest line of a comment, in columns.
const COLUMNS: usize = 120;

/// Returns a text in lines of a comment.
fn comment(text: &str) -> String {
    let (mut out, mut column) = (String::new(), 2);
    for word in text.split(' ') {
        if column + word.len() + 4 > COLUMNS {
            out += "\n  ";
            column = 2;
        }
        column += word.len() + 1;
        if !out.is_empty() {
            out.push(' ');
        }
        out += word;
    }
    out
}

#[test]
fn the_clients_functions_are_those_of_the_table() {
    let mut text = String::new();
    let is_written = |verb: &&Verb| {
        !matches!(verb.reply, Reply::ByForm | Reply::Lines) && verb.encoding != Encoding::Binary
    };
    for verb in Verb::all().iter().filter(is_written) {
        Function::of(verb).write(verb, &mut text);
    }
    text.push('\n');
    check_block(CLIENT, MARKS, &text);
}

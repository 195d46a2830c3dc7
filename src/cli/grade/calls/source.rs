//! Declarations in C and C++ sources: functions with their parameters, and records with their fields.
//!
//! In: bytes of a source in any encoding of the ASCII kind. Out: [`Declared`], with the places of the
//! functions' bodies in those bytes. Read is as much of the two languages as programs of a first
//! course have: no templates of their own, no macros in declarations. Right is: what is not
//! understood is left out, and nothing is read beyond the end, whatever the bytes are.

use super::text::{Token, tokens};

/// A parameter, or a field of a record.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parameter {
    /// The type without `const`, `&`, `*` and `[]`.
    pub kind: String,
    pub name: String,
    /// Number of `*`.
    pub pointers: usize,
    /// Number of `[]`.
    pub arrays: usize,
    /// Elements of an array of one dimension, if they are given as a number.
    pub len: Option<usize>,
    /// True if it may be left out of a call.
    pub has_default: bool,
}

/// A function at the scope of a file or a namespace.
#[derive(Clone, Debug)]
pub struct Function {
    pub name: String,
    pub parameters: Vec<Parameter>,
    /// Place behind the body's opening brace; `None` for a declaration.
    pub body: Option<usize>,
    /// Its namespace, empty at the scope of the file.
    pub scope: String,
    /// True if other files cannot call it.
    pub is_static: bool,
}

/// A struct or class, with its public members.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Its tag, and names that a `typedef` gives it.
    pub names: Vec<String>,
    pub fields: Vec<Parameter>,
    pub constructors: Vec<Vec<Parameter>>,
    /// Names of its functions.
    pub methods: Vec<String>,
    /// True if a variable may be made of no values.
    pub is_made_of_nothing: bool,
}

/// Declarations of a source.
#[derive(Debug, Default)]
pub struct Declared {
    pub functions: Vec<Function>,
    pub records: Vec<Record>,
    /// Other names of types.
    pub aliases: Vec<(String, String)>,
    /// True if something is multiplied by 255, as colours from 0 to 1 are before they are stored.
    pub is_scaled: bool,
}

impl Declared {
    /// Reads a source.
    pub fn read(source: &[u8]) -> Declared {
        let mut parser =
            Parser { tokens: tokens(source), at: 0, scopes: Vec::new(), declared: Declared::default() };
        parser.file();
        parser.declared.is_scaled = parser.is_scaled();
        parser.declared
    }
}

struct Parser {
    tokens: Vec<Token>,
    at: usize,
    /// Namespaces around the place, and where each ends.
    scopes: Vec<(String, usize)>,
    declared: Declared,
}

impl Parser {
    fn text(&self, at: usize) -> &str {
        self.tokens.get(at).map_or("", |token| token.text.as_str())
    }

    fn is_word(&self, at: usize) -> bool {
        self.tokens.get(at).is_some_and(Token::is_word)
    }

    /// Returns the place behind the bracket that closes the one at `at`.
    fn behind(&self, at: usize) -> usize {
        let open = self.text(at).to_owned();
        let close = match open.as_str() {
            "(" => ")",
            "[" => "]",
            _ => "}",
        };
        let mut depth = 0_usize;
        for place in at..self.tokens.len() {
            if self.text(place) == open {
                depth += 1;
            } else if self.text(place) == close {
                depth -= 1;
                if depth == 0 {
                    return place + 1;
                }
            }
        }
        self.tokens.len()
    }

    /// Reads what is at the scope of the file, and of its namespaces.
    fn file(&mut self) {
        while self.at < self.tokens.len() {
            self.scopes.retain(|(_, end)| *end > self.at);
            let opens = self.opens_record(self.at);
            match self.text(self.at) {
                "struct" | "class" if opens.is_some() => self.record(),
                "typedef" if self.opens_record(self.at + 1).is_none() => self.alias(),
                "using" if self.text(self.at + 2) == "=" => self.using(),
                "extern" if self.text(self.at + 1) == "{" => self.at += 2,
                "namespace" => self.namespace(),
                "{" => self.at = self.behind(self.at),
                "(" if self.at > 0 && self.is_word(self.at - 1) => self.function(),
                _ => self.at += 1,
            }
        }
    }

    fn namespace(&mut self) {
        let mut open = self.at + 1;
        while self.is_word(open) || self.text(open) == "::" {
            open += 1;
        }
        if self.text(open) == "{" {
            let name: Vec<&str> = (self.at + 1..open).map(|at| self.text(at)).collect();
            self.scopes.push((name.concat(), self.behind(open)));
            open += 1;
        }
        self.at = open;
    }

    /// Returns the place of the brace of the record, enumeration or union that begins at a place.
    fn opens_record(&self, from: usize) -> Option<usize> {
        if !matches!(self.text(from), "struct" | "class" | "enum" | "union") {
            return None;
        }
        let mut at = from + 1;
        while at < from + 12 && !matches!(self.text(at), "" | ";" | "(" | ")" | "=" | "*" | "&") {
            if self.text(at) == "{" {
                return Some(at);
            }
            at += 1;
        }
        None
    }

    fn record(&mut self) {
        let Some(open) = self.opens_record(self.at) else { return };
        let mut names: Vec<String> = Vec::new();
        if self.is_word(self.at + 1) {
            names.push(self.text(self.at + 1).to_owned());
        }
        let end = self.behind(open);
        let is_class = self.text(self.at) == "class";
        let record = self.members(open + 1, end - 1, names.first().map_or("", |name| name), is_class);
        self.at = end;
        while self.is_word(self.at) || self.text(self.at) == "," {
            if self.is_word(self.at) {
                names.push(self.text(self.at).to_owned());
            }
            self.at += 1;
        }
        self.declared.records.push(Record { names, ..record });
    }

    /// Returns the public members between two places.
    fn members(&self, from: usize, to: usize, name: &str, is_class: bool) -> Record {
        let mut record = Record::default();
        let (mut is_public, mut is_plain, mut at) = (!is_class, true, from);
        while at < to {
            let start = at;
            if matches!(self.text(at), "public" | "private" | "protected") && self.text(at + 1) == ":" {
                is_public = self.text(at) == "public";
                at += 2;
                continue;
            }
            if let Some(open) = self.opens_record(at) {
                at = self.behind_statement(self.behind(open), to);
                continue;
            }
            while at < to && !matches!(self.text(at), ";" | "(" | "{" | "=") {
                at += 1;
            }
            if self.text(at) != "(" || at >= to {
                // A field; what follows its name is its first value.
                let end = self.behind_statement(at, to);
                let is_kept = is_public && self.tokens[start..at].iter().all(|token| token.text != "static");
                if is_kept {
                    record.fields.extend(declarators(&self.tokens[start..(end - 1).max(start)]));
                }
                at = end.max(start + 1);
                continue;
            }
            let end = self.behind(at);
            let own = at.checked_sub(1).filter(|own| *own >= start).map_or("", |own| self.text(own));
            if own == name && (at - 1 == start || self.text(at - 2) != "~") {
                is_plain = false;
                if is_public {
                    let inside = &self.tokens[at + 1..(end - 1).min(to).max(at + 1)];
                    record.constructors.push(parameters(inside));
                }
            } else if is_public && own != name {
                record.methods.push(own.to_owned());
            }
            at = self.behind_body(end, to);
        }
        let needs_none = |values: &Vec<Parameter>| values.iter().all(|value| value.has_default);
        record.is_made_of_nothing = is_plain || record.constructors.iter().any(needs_none);
        record
    }

    /// Returns the place behind the semicolon of a statement.
    fn behind_statement(&self, from: usize, to: usize) -> usize {
        let mut at = from;
        while at < to && self.text(at) != ";" {
            at = if matches!(self.text(at), "(" | "[" | "{") { self.behind(at) } else { at + 1 };
        }
        (at + 1).min(to + 1)
    }

    /// Returns the place behind the body or the semicolon of a member function.
    fn behind_body(&self, from: usize, to: usize) -> usize {
        let mut at = from;
        while at < to {
            match self.text(at) {
                ";" => return at + 1,
                // A member's first value, as in `: x{1}`.
                "{" if self.is_word(at - 1)
                    && !matches!(self.text(at - 1), "const" | "override" | "noexcept") =>
                {
                    at = self.behind(at);
                }
                "{" => return self.behind(at),
                "(" => at = self.behind(at),
                _ => at += 1,
            }
        }
        to
    }

    /// Reads `using A = B;`.
    fn using(&mut self) {
        let end = (self.at..self.tokens.len()).find(|at| self.text(*at) == ";").unwrap_or(self.tokens.len());
        if let (Some(name), Some(kind)) = (self.tokens.get(self.at + 1), self.tokens.get(self.at + 3..end))
            && !kind.is_empty()
            && kind.iter().all(|token| token.is_word() || token.text == "::")
        {
            let name = name.text.clone();
            self.declared.aliases.push((name, joined(kind.iter().map(|token| token.text.as_str()))));
        }
        self.at = end;
    }

    /// Returns whether something is multiplied by 255.
    fn is_scaled(&self) -> bool {
        (0..self.tokens.len()).any(|at| {
            let is_decimal = self.text(at + 1) == ".";
            let before = at.checked_sub(1).map_or("", |before| self.text(before));
            let next = self.text(if is_decimal { at + 3 } else { at + 1 });
            let next = if is_decimal && self.text(at + 2) == "*" { "*" } else { next };
            matches!(self.text(at), "255" | "255f" | "256") && (before == "*" || next == "*")
        })
    }

    fn alias(&mut self) {
        let end = (self.at..self.tokens.len()).find(|at| self.text(*at) == ";").unwrap_or(self.tokens.len());
        let words = &self.tokens[self.at + 1..end];
        if words.len() >= 2 && words.iter().all(Token::is_word) {
            let kind: Vec<&str> = words[..words.len() - 1].iter().map(|token| token.text.as_str()).collect();
            self.declared.aliases.push((words[words.len() - 1].text.clone(), kind.join(" ")));
        }
        self.at = end;
    }

    /// Reads a function; `at` is the bracket behind its name.
    fn function(&mut self) {
        let open = self.at;
        let end = self.behind(open);
        self.at = end;
        // Methods, initial values and calls are none.
        let before = if open >= 2 { self.text(open - 2) } else { "" };
        let start = (0..open.saturating_sub(1)).rev().take(12);
        let mut modifiers =
            start.map(|at| self.text(at)).take_while(|text| !matches!(*text, ";" | "}" | "{"));
        let is_hidden = modifiers.any(|text| text == "static");
        let is_typed = before.chars().all(|c| c.is_ascii_alphanumeric() || "_*&>".contains(c));
        if before.is_empty() || !is_typed || !matches!(self.text(end), "{" | ";") {
            return;
        }
        let body = (self.text(end) == "{").then(|| self.tokens[end].end);
        let parameters = parameters(&self.tokens[open + 1..(end - 1).max(open + 1)]);
        // Such is a variable with its first values.
        if parameters.iter().any(|p| p.kind.is_empty() || p.kind.starts_with(|c: char| c.is_ascii_digit())) {
            return;
        }
        let name = self.text(open - 1).to_owned();
        let names: Vec<&str> =
            self.scopes.iter().map(|(name, _)| name.as_str()).filter(|name| !name.is_empty()).collect();
        let (scope, is_static) = (names.join("::"), is_hidden || names.len() < self.scopes.len());
        self.declared.functions.push(Function { name, parameters, body, scope, is_static });
    }
}

/// Splits tokens at commas that no bracket holds.
fn split(tokens: &[Token]) -> Vec<&[Token]> {
    let (mut parts, mut depth, mut start) = (Vec::new(), 0_i32, 0);
    for (at, token) in tokens.iter().enumerate() {
        match token.text.as_str() {
            "(" | "[" | "<" | "{" => depth += 1,
            ")" | "]" | ">" | "}" => depth -= 1,
            "," if depth == 0 => {
                parts.push(&tokens[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&tokens[start..]);
    parts
}

fn parameters(tokens: &[Token]) -> Vec<Parameter> {
    split(tokens).into_iter().filter_map(parameter).filter(|p| p.kind != "void" || p.pointers > 0).collect()
}

/// Returns the fields of a statement as `unsigned char r, g = 0, b[2]`.
fn declarators(tokens: &[Token]) -> Vec<Parameter> {
    let parts = split(tokens);
    let Some(first) = parts.first().and_then(|part| parameter(part)) else { return Vec::new() };
    let others = parts[1..].iter().filter_map(|part| {
        let name = part.iter().find(|token| token.is_word())?.text.clone();
        Some(Parameter { kind: first.kind.clone(), name, ..shape(part) })
    });
    std::iter::once(first.clone()).chain(others).collect()
}

/// Returns a parameter with pointers, arrays and defaults alone.
fn shape(tokens: &[Token]) -> Parameter {
    let end = tokens.iter().position(|token| matches!(&*token.text, "=" | "{")).unwrap_or(tokens.len());
    let count = |text: &str| tokens[..end].iter().filter(|token| token.text == text).count();
    let arrays = count("[");
    let open = tokens[..end].iter().position(|token| token.text == "[");
    let len = open.filter(|_| arrays == 1).and_then(|open| tokens.get(open + 1)?.text.parse().ok());
    Parameter { pointers: count("*"), arrays, len, has_default: end < tokens.len(), ..Parameter::default() }
}

/// Reads a type and a name, which may be missing.
fn parameter(tokens: &[Token]) -> Option<Parameter> {
    let end = tokens.iter().position(|token| matches!(&*token.text, "=" | "{")).unwrap_or(tokens.len());
    let array = tokens[..end].iter().position(|token| token.text == "[").unwrap_or(end);
    let dropped = ["const", "volatile", "register", "static", "mutable", "constexpr", "*", "&"];
    let mut words: Vec<&str> = tokens[..array].iter().map(|token| token.text.as_str()).collect();
    words.retain(|word| !dropped.contains(word));
    let is_name = |word: &str| word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    let last = *words.last()?;
    let is_tag = words.len() == 2 && matches!(words[0], "struct" | "class");
    let before = words.len().checked_sub(2).map_or("", |at| words[at]);
    let is_named = words.len() > 1 && is_name(last) && !is_scalar_word(last) && !is_tag && before != "::";
    let name = if is_named { words.pop().unwrap_or("").to_owned() } else { String::new() };
    Some(Parameter { kind: joined(words.into_iter()), name, ..shape(tokens) })
}

/// Joins the words of a type, with a space between two names.
fn joined<'a>(words: impl Iterator<Item = &'a str>) -> String {
    let mut kind = String::new();
    for word in words {
        let is_name = word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if kind.ends_with(|c: char| c.is_ascii_alphanumeric() || c == '_') && is_name {
            kind.push(' ');
        }
        kind.push_str(word);
    }
    kind
}

/// Returns whether a word is, or is part of, a type of numbers.
pub fn is_scalar_word(word: &str) -> bool {
    const WORDS: [&str; 30] = [
        "int", "unsigned", "signed", "short", "long", "char", "float", "double", "bool", "uint", "uchar",
        "size_t", "GLint", "GLuint", "GLubyte", "GLbyte", "GLshort", "GLushort", "GLfloat", "GLdouble",
        "GLclampf", "uint8_t", "uint16_t", "uint32_t", "int8_t", "int16_t", "int32_t", "BYTE", "_Bool",
        "GLsizei",
    ];
    WORDS.contains(&word)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = r#"
#define TWO int two(int a) { \
    return 0; }
// int three(int a) {
typedef unsigned char octet;
typedef struct { octet r, g = 0, b; float a[2]; } Tint;
typedef struct Tint Shade;
#if 0
int five(int a) {}
#if 1
#endif
#else
using Hue = Tint;
#endif
namespace far::off { namespace { int six(int a[3], Tint t = {0}); } struct Cell { int i{3}, j = f(2); }; }
class Dot { int x; public: Dot() {} Dot(int px, int py = 0) : x(px) { y = py; } int y; int getX() { return x; } };
const char *text = "void four(int a) {";
Dot origin(1, 2);
static void line(const Dot &from, Dot *to, struct Tint c[], std::vector<int>& v);
void Dot::method(int a) {}
extern "C" {
int dot(int, unsigned char shade) { if (dot(1, 2)) { return 1; } return line(a); }
}
"#;

    #[test]
    fn functions_and_records_are_read_and_the_rest_is_skipped() {
        let declared = Declared::read(SOURCE.as_bytes());
        let names: Vec<&str> = declared.functions.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(names, ["six", "line", "dot"]);
        let kinds: Vec<String> = declared.functions[1]
            .parameters
            .iter()
            .map(|p| format!("{} {} {} {}", p.kind, p.name, p.pointers, p.arrays))
            .collect();
        assert_eq!(kinds, ["Dot from 0 0", "Dot to 1 0", "struct Tint c 0 1", "std::vector<int> v 0 0"]);
        let dot = &declared.functions[2];
        assert_eq!((dot.parameters[0].name.as_str(), dot.parameters[1].kind.as_str()), ("", "unsigned char"));
        assert!(SOURCE[dot.body.unwrap()..].starts_with(" if (dot"));
        let aliases: Vec<(&str, &str)> = declared.aliases.iter().map(|(a, b)| (&**a, &**b)).collect();
        assert_eq!(aliases, [("octet", "unsigned char"), ("Shade", "struct Tint"), ("Hue", "Tint")]);
        let six = &declared.functions[0];
        assert_eq!((six.scope.as_str(), six.is_static, six.parameters[0].len), ("far::off", true, Some(3)));
        assert!(six.parameters[1].has_default && !declared.functions[2].is_static);
        let [tint, cell, point] = &declared.records[..] else { panic!("{:?}", declared.records) };
        assert_eq!(tint.names, ["Tint"]);
        assert_eq!(tint.fields.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["r", "g", "b", "a"]);
        assert_eq!(cell.fields.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["i", "j"]);
        assert_eq!(point.methods, ["getX"]);
        assert_eq!(point.constructors.iter().map(Vec::len).collect::<Vec<_>>(), [0, 2]);
        assert_eq!(point.fields.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["y"]);
    }

    #[test]
    fn what_is_no_source_does_no_harm() {
        for len in 0..SOURCE.len() {
            let _ = Declared::read(&SOURCE.as_bytes()[..len]);
            let _ = Declared::read(&SOURCE.as_bytes()[len..]);
        }
        for text in
            ["struct", "struct{", "f(", "int f)(", "typedef", "\"", "'\\", "#\\", "class a { a(", "}}}", "/*"]
        {
            let _ = Declared::read(text.as_bytes());
        }
    }
}

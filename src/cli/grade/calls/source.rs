//! Declarations in C and C++ sources: functions with their parameters, and records with their fields.
//!
//! In: bytes of a source in any encoding of the ASCII kind. Out: [`Declared`], with the places of the
//! functions' bodies in those bytes. Read is as much of the two languages as programs of a first
//! course have: no templates of their own, no macros in declarations. Right is: what is not
//! understood is left out, and nothing is read beyond the end, whatever the bytes are.

/// A parameter, or a field of a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// The type without `const`, `&`, `*` and `[]`.
    pub kind: String,
    pub name: String,
    pub is_pointer: bool,
    pub is_array: bool,
}

/// A function at the scope of the file.
#[derive(Clone, Debug)]
pub struct Function {
    pub name: String,
    pub parameters: Vec<Parameter>,
    /// Place behind the body's opening brace; `None` for a declaration.
    pub body: Option<usize>,
}

/// A struct or class.
#[derive(Clone, Debug)]
pub struct Record {
    /// Its tag, and names that a `typedef` gives it.
    pub names: Vec<String>,
    pub fields: Vec<Parameter>,
    pub constructors: Vec<Vec<Parameter>>,
}

/// Declarations of a source.
#[derive(Debug, Default)]
pub struct Declared {
    pub functions: Vec<Function>,
    pub records: Vec<Record>,
    /// Other names of types.
    pub aliases: Vec<(String, String)>,
}

impl Declared {
    /// Reads a source.
    pub fn read(source: &[u8]) -> Declared {
        let mut parser = Parser { tokens: tokens(&blank(source)), at: 0, declared: Declared::default() };
        parser.file();
        parser.declared
    }
}

/// A token and the place behind it.
#[derive(Clone, Debug)]
struct Token {
    text: String,
    end: usize,
}

impl Token {
    fn is_word(&self) -> bool {
        self.text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
    }
}

/// Returns a source with spaces in place of comments, texts and lines of the preprocessor.
fn blank(source: &[u8]) -> Vec<u8> {
    let mut out = source.to_vec();
    let (mut at, mut is_line_start) = (0, true);
    while at < source.len() {
        let rest = &source[at..];
        let len = if rest.starts_with(b"//") {
            line_end(rest)
        } else if rest.starts_with(b"/*") {
            rest[2..].windows(2).position(|two| two == b"*/").map_or(rest.len(), |end| end + 4)
        } else if rest[0] == b'"' || rest[0] == b'\'' {
            text_end(rest)
        } else if rest[0] == b'#' && is_line_start {
            line_end(rest)
        } else {
            is_line_start = rest[0] == b'\n' || (is_line_start && rest[0].is_ascii_whitespace());
            at += 1;
            continue;
        };
        let end = (at + len.max(1)).min(source.len());
        out[at..end].fill(b' ');
        at = end;
    }
    out
}

/// Returns the length of a line, with the lines that a backslash joins to it.
fn line_end(rest: &[u8]) -> usize {
    let is_end = |at: &usize| {
        let before = rest[..*at].strip_suffix(b"\r").unwrap_or(&rest[..*at]);
        rest[*at] == b'\n' && !before.ends_with(b"\\")
    };
    (0..rest.len()).find(is_end).unwrap_or(rest.len())
}

/// Returns the length of a text in quotes, which ends with its line at the latest.
fn text_end(rest: &[u8]) -> usize {
    let mut at = 1;
    while at < rest.len() && rest[at] != rest[0] && rest[at] != b'\n' {
        at += 1 + usize::from(rest[at] == b'\\');
    }
    at + 1
}

fn tokens(text: &[u8]) -> Vec<Token> {
    let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let (mut tokens, mut at) = (Vec::new(), 0);
    while at < text.len() {
        let len = match text[at] {
            byte if byte.is_ascii_whitespace() || !byte.is_ascii() => {
                at += 1;
                continue;
            }
            byte if is_part(&byte) => text[at..].iter().take_while(|byte| is_part(byte)).count(),
            b':' if text[at..].starts_with(b"::") => 2,
            _ => 1,
        };
        let word = String::from_utf8_lossy(&text[at..at + len]).into_owned();
        at += len;
        tokens.push(Token { text: word, end: at });
    }
    tokens
}

struct Parser {
    tokens: Vec<Token>,
    at: usize,
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

    /// Reads what is at the scope of the file.
    fn file(&mut self) {
        while self.at < self.tokens.len() {
            match self.text(self.at) {
                "struct" | "class" if self.opens_record().is_some() => self.record(),
                "typedef" if !matches!(self.text(self.at + 1), "struct" | "class" | "enum" | "union") => {
                    self.alias();
                }
                "extern" if self.text(self.at + 1) == "{" => self.at += 2,
                "namespace" if self.text(self.at + 2) == "{" => self.at += 3,
                "{" => self.at = self.behind(self.at),
                "(" if self.at > 0 && self.is_word(self.at - 1) => self.function(),
                _ => self.at += 1,
            }
        }
    }

    /// Returns the place of the brace of the record that begins here.
    fn opens_record(&self) -> Option<usize> {
        let mut at = self.at + 1;
        while at < self.at + 8 && !matches!(self.text(at), "" | ";" | "(" | ")" | "=" | "*" | "&") {
            if self.text(at) == "{" {
                return Some(at);
            }
            at += 1;
        }
        None
    }

    fn record(&mut self) {
        let Some(open) = self.opens_record() else { return };
        let mut names: Vec<String> = Vec::new();
        if self.is_word(self.at + 1) {
            names.push(self.text(self.at + 1).to_owned());
        }
        let end = self.behind(open);
        let (fields, constructors) = self.members(open + 1, end - 1, names.first().map_or("", |name| name));
        self.at = end;
        while self.is_word(self.at) || self.text(self.at) == "," {
            if self.is_word(self.at) {
                names.push(self.text(self.at).to_owned());
            }
            self.at += 1;
        }
        self.declared.records.push(Record { names, fields, constructors });
    }

    /// Returns the fields and constructors between two places.
    fn members(&self, from: usize, to: usize, name: &str) -> (Vec<Parameter>, Vec<Vec<Parameter>>) {
        let (mut fields, mut constructors, mut at) = (Vec::new(), Vec::new(), from);
        while at < to {
            let start = at;
            if matches!(self.text(at), "public" | "private" | "protected") && self.text(at + 1) == ":" {
                at += 2;
                continue;
            }
            while at < to && !matches!(self.text(at), ";" | "(" | "{") {
                at += 1;
            }
            match self.text(at) {
                ";" => {
                    fields.extend(declarators(&self.tokens[start..at]));
                    at += 1;
                }
                "(" => {
                    let end = self.behind(at);
                    let is_own = at > start && self.text(at - 1) == name;
                    if is_own && (at - 1 == start || self.text(at - 2) != "~") {
                        constructors.push(parameters(&self.tokens[at + 1..(end - 1).min(to).max(at + 1)]));
                    }
                    at = end;
                    while at < to && !matches!(self.text(at), ";" | "{") {
                        at += 1;
                    }
                    at = if self.text(at) == "{" { self.behind(at) } else { at + 1 };
                }
                // A record in a record, or a first value in braces.
                "{" => at = self.behind(at),
                _ => at = to,
            }
        }
        (fields, constructors)
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
        self.declared.functions.push(Function { name, parameters, body });
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
    split(tokens).into_iter().filter_map(parameter).filter(|p| p.kind != "void" || p.is_pointer).collect()
}

/// Returns the fields of a statement as `unsigned char r, g = 0, b[2]`.
fn declarators(tokens: &[Token]) -> Vec<Parameter> {
    let parts = split(tokens);
    let Some(first) = parts.first().and_then(|part| parameter(part)) else { return Vec::new() };
    let others = parts[1..].iter().filter_map(|part| {
        let name = part.iter().find(|token| token.is_word())?.text.clone();
        let has = |text: &str| part.iter().any(|token| token.text == text);
        Some(Parameter { kind: first.kind.clone(), name, is_pointer: has("*"), is_array: has("[") })
    });
    std::iter::once(first.clone()).chain(others).collect()
}

/// Reads a type and a name, which may be missing.
fn parameter(tokens: &[Token]) -> Option<Parameter> {
    let end = tokens.iter().position(|token| token.text == "=").unwrap_or(tokens.len());
    let has = |text: &str| tokens[..end].iter().any(|token| token.text == text);
    let array = tokens[..end].iter().position(|token| token.text == "[").unwrap_or(end);
    let dropped = ["const", "volatile", "register", "static", "mutable", "*", "&"];
    let mut words: Vec<&str> = tokens[..array].iter().map(|token| token.text.as_str()).collect();
    words.retain(|word| !dropped.contains(word));
    let is_name = |word: &str| word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    let last = *words.last()?;
    let is_tag = words.len() == 2 && matches!(words[0], "struct" | "class");
    let before = words.len().checked_sub(2).map_or("", |at| words[at]);
    let is_named = words.len() > 1 && is_name(last) && !is_scalar_word(last) && !is_tag && before != "::";
    let name = if is_named { words.pop().unwrap_or("").to_owned() } else { String::new() };
    let mut kind = String::new();
    for word in words {
        if kind.ends_with(|c: char| c.is_ascii_alphanumeric() || c == '_') && is_name(word) {
            kind.push(' ');
        }
        kind.push_str(word);
    }
    Some(Parameter { kind, name, is_pointer: has("*"), is_array: has("[") })
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
        assert_eq!(names, ["line", "dot"]);
        let kinds: Vec<String> = declared.functions[0]
            .parameters
            .iter()
            .map(|p| format!("{} {} {} {}", p.kind, p.name, p.is_pointer, p.is_array))
            .collect();
        assert_eq!(
            kinds,
            [
                "Dot from false false",
                "Dot to true false",
                "struct Tint c false true",
                "std::vector<int> v false false"
            ]
        );
        let dot = &declared.functions[1];
        assert_eq!((dot.parameters[0].name.as_str(), dot.parameters[1].kind.as_str()), ("", "unsigned char"));
        assert!(SOURCE[dot.body.unwrap()..].starts_with(" if (dot"));
        assert_eq!(declared.aliases, [("octet".to_owned(), "unsigned char".to_owned())]);
        let [tint, point] = &declared.records[..] else { panic!("{:?}", declared.records) };
        assert_eq!(tint.names, ["Tint"]);
        assert_eq!(tint.fields.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["r", "g", "b", "a"]);
        assert_eq!(point.constructors.iter().map(Vec::len).collect::<Vec<_>>(), [0, 2]);
        assert_eq!(point.fields.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["x", "y"]);
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

//! Functions fit a screen or two, and files an afternoon: the length of every function, macro and
//! file of the project is bounded.
//!
//! The reader knows comments, literals and braces, no more of the language: a function begins at
//! `fn` and a name, and ends with the brace that closes its body.

use std::fs;
use std::path::{Path, PathBuf};

/// Largest number of lines of a function or macro, from `fn` or `macro_rules!` to its last brace.
const FUNCTION_LINES: usize = 80;
/// The verb table, a macro that holds rows and no code.
const TABLE: (&str, &str) = ("crates/command/src/table.rs", "verbs");
/// Largest number of lines of a source file.
const FILE_LINES: usize = 600;
/// Folders that hold Rust.
const FOLDERS: [&str; 6] = ["src", "crates", "tests", "benches", "demos", "fuzz/targets"];

/// Item with a body of its own.
#[derive(Debug, PartialEq)]
struct Item {
    name: String,
    /// Line of `fn` or `macro_rules!`, from 1.
    line: usize,
    lines: usize,
}

fn rust_files(dir: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(dir).expect("a folder").map(|e| e.expect("entry").path()) {
        match entry.is_dir() {
            true if entry.ends_with("target") => {}
            true => rust_files(&entry, found),
            false if entry.extension().is_some_and(|e| e == "rs") => found.push(entry),
            false => {}
        }
    }
}

/// Returns the length of the comment or literal at the start of `rest`, 0 for other text; `before`
/// is the byte before it.
fn skipped(rest: &str, before: u8) -> usize {
    let to_end = |at: Option<usize>, len: usize| at.map_or(rest.len(), |at| at + len);
    if rest.starts_with("//") {
        return to_end(rest.find('\n'), 0);
    }
    if rest.starts_with("/*") {
        return to_end(rest.find("*/"), 2);
    }
    let is_word = before.is_ascii_alphanumeric() || before == b'_';
    let raw = ["r", "br", "cr"].iter().find_map(|p| rest.strip_prefix(p)).filter(|_| !is_word);
    if let Some(raw) = raw {
        let hashes = raw.bytes().take_while(|b| *b == b'#').count();
        if raw[hashes..].starts_with('"') {
            let (prefix, end) = (rest.len() - raw.len() + hashes + 1, format!("\"{}", "#".repeat(hashes)));
            return to_end(rest[prefix..].find(&end).map(|at| at + prefix), end.len());
        }
    }
    match rest.as_bytes() {
        [b'"', ..] => closing(rest, b'"'),
        [b'\'', b'\\', ..] => closing(rest, b'\''),
        // A character, and no lifetime.
        [b'\'', ..] => {
            let mut chars = rest.char_indices().skip(2);
            chars.next().filter(|(_, c)| *c == '\'').map_or(0, |(at, _)| at + 1)
        }
        _ => 0,
    }
}

/// Returns the length of a literal with escapes up to its closing quote.
fn closing(literal: &str, quote: u8) -> usize {
    let bytes = literal.as_bytes();
    let mut at = 1;
    while at < bytes.len() && bytes[at] != quote {
        at += if bytes[at] == b'\\' { 2 } else { 1 };
    }
    (at + 1).min(bytes.len())
}

/// Returns the text with comments and literals blanked out, line by line as it was.
fn code_of(text: &str) -> Vec<u8> {
    let mut code = text.as_bytes().to_vec();
    let (mut at, mut before) = (0, b'\n');
    while at < text.len() {
        let len = if text.is_char_boundary(at) { skipped(&text[at..], before) } else { 0 };
        for byte in &mut code[at..at + len] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
        before = code[at];
        at += len.max(1);
    }
    code
}

/// Returns the place behind the brace that closes the body that begins behind `from`, or `None` for
/// a declaration without body.
fn end_of_body(code: &[u8], from: usize) -> Option<usize> {
    let (mut brackets, mut braces) = (0, 0);
    for (at, byte) in code.iter().enumerate().skip(from) {
        match byte {
            b'(' | b'[' if braces == 0 => brackets += 1,
            b')' | b']' if braces == 0 => brackets -= 1,
            b';' if braces == 0 && brackets == 0 => return None,
            b'{' if braces > 0 || brackets == 0 => braces += 1,
            b'}' if braces == 1 => return Some(at + 1),
            b'}' if braces > 1 => braces -= 1,
            _ => {}
        }
    }
    None
}

/// Returns the functions and macros of a source text, nested ones too.
fn items(text: &str) -> Vec<Item> {
    let code = code_of(text);
    let word_at = |at: usize| {
        let is_word = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_' || *b == b'$';
        let len = code[at..].iter().take_while(|b| is_word(b)).count();
        String::from_utf8_lossy(&code[at..at + len]).into_owned()
    };
    let line_of = |at: usize| code[..at].iter().filter(|b| **b == b'\n').count() + 1;
    let mut found = Vec::new();
    for keyword in ["fn ", "macro_rules! "] {
        let starts = code.windows(keyword.len()).enumerate().filter(|(_, w)| *w == keyword.as_bytes());
        for (start, _) in starts {
            let is_alone =
                start == 0 || !(code[start - 1].is_ascii_alphanumeric() || b"_$".contains(&code[start - 1]));
            let name = word_at(start + keyword.len());
            // `fn $name:ident` is a pattern of a macro.
            let is_pattern = code.get(start + keyword.len() + name.len()) == Some(&b':');
            if let Some(end) = end_of_body(&code, start + keyword.len())
                && is_alone
                && !is_pattern
                && !name.is_empty()
            {
                let line = line_of(start);
                found.push(Item { name, line, lines: line_of(end) - line + 1 });
            }
        }
    }
    found
}

#[test]
fn functions_and_files_have_bounded_lengths() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    FOLDERS.iter().for_each(|folder| rust_files(&root.join(folder), &mut files));
    let (mut seen, mut long) = (0, Vec::new());
    for file in &files {
        let text = fs::read_to_string(file).expect("readable");
        let name = file.strip_prefix(root).expect("inside").display();
        let lines = text.lines().count();
        if lines > FILE_LINES {
            long.push(format!("{name}:{FILE_LINES}: the file has {lines} lines"));
        }
        let items = items(&text);
        seen += items.len();
        let is_table = |item: &Item| TABLE == (&*name.to_string(), &item.name);
        let is_long = |item: &Item| item.lines > FUNCTION_LINES && !is_table(item);
        for Item { name: item, line, lines } in items.into_iter().filter(is_long) {
            long.push(format!("{name}:{line}: {item} has {lines} lines"));
        }
    }
    assert!(seen > 3000, "the test found only {seen} functions: it no longer reads them");
    assert!(long.is_empty(), "over {FUNCTION_LINES} or {FILE_LINES} lines:\n{}", long.join("\n"));
}

#[test]
fn the_reader_of_functions_sees_bodies_and_nothing_else() {
    let text = "// fn no() {\nfn a<'a>(x: &'a [u8; { 2 }]) -> char {\n    \"}\\\"\"; '}'; r#\"}\"\n}\"#;\n}\n\
        trait T { fn declared(&self); /* fn b() { */ fn c() { fn d() {\n } } }\n\
        type P = fn(u8);\nmacro_rules! m { () => { fn $e() {\n}\n } }\n\
        macro_rules! p { (fn $e:ident {}) => {} }";
    let found: Vec<(String, usize, usize)> =
        items(text).into_iter().map(|i| (i.name, i.line, i.lines)).collect();
    let expected = [("a", 2, 4), ("c", 6, 2), ("d", 6, 2), ("$e", 9, 2), ("m", 9, 3), ("p", 12, 1)];
    assert_eq!(found, expected.map(|(name, line, lines)| (name.to_owned(), line, lines)));
}

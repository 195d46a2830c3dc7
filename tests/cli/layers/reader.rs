//! Reads the imports of a source: every `crate::`, `super::` and `self::` path of its code, test
//! code left out.

use std::collections::BTreeSet;

/// A path that a source names, from the crate's root on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Import {
    /// Line of the source, from 1.
    pub line: usize,
    /// The path's segments, its crate first; the last may be an item.
    pub path: Vec<String>,
}

/// Returns the imports of the source text of `module`.
pub fn imports(text: &str, module: &[String]) -> Vec<Import> {
    let code = without_tests(code_of(text));
    let mut found = Vec::new();
    for head in ["crate", "super", "self"] {
        for (at, _) in code.match_indices(head) {
            let (before, rest) = (&code[..at], &code[at + head.len()..]);
            let is_inside = before.ends_with(|c: char| c.is_alphanumeric() || "_:.$".contains(c));
            if is_inside || before.ends_with("(in ") || !rest.starts_with("::") {
                continue;
            }
            let mut paths = Vec::new();
            read_tree(rest, &mut Vec::new(), &mut paths);
            let line = before.matches('\n').count() + 1;
            found.extend(paths.into_iter().map(|path| Import { line, path: resolved(head, module, path) }));
        }
    }
    found
}

/// Returns the names that a room's root re-exports, each with its part.
pub fn reexports(text: &str, parts: &BTreeSet<String>) -> Vec<(String, String)> {
    let code = without_tests(code_of(text));
    let mut found = Vec::new();
    for (at, _) in code.match_indices("use ") {
        let rest = &code[at + "use ".len()..];
        let part = identifier(rest);
        if parts.contains(part) {
            let mut paths = Vec::new();
            read_tree(&rest[part.len()..], &mut Vec::new(), &mut paths);
            found.extend(paths.into_iter().filter_map(|p| Some((p.last()?.clone(), part.to_owned()))));
        }
    }
    found
}

/// Returns a path that begins with the crate.
fn resolved(head: &str, module: &[String], path: Vec<String>) -> Vec<String> {
    let mut full = if head == "crate" { module[..1].to_vec() } else { module.to_vec() };
    for segment in std::iter::once(head.to_owned()).chain(path) {
        match segment.as_str() {
            "crate" | "self" => {}
            "super" => drop(full.pop()),
            _ => full.push(segment),
        }
    }
    full
}

fn identifier(text: &str) -> &str {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
    &text[..end]
}

/// Adds the paths that begin with `path` and go on in `rest`, groups expanded. Returns the text
/// behind them.
fn read_tree<'t>(rest: &'t str, path: &mut Vec<String>, found: &mut Vec<Vec<String>>) -> &'t str {
    let Some(after) = rest.strip_prefix("::") else {
        found.push(path.clone());
        return rest;
    };
    if let Some(mut inside) = after.strip_prefix('{') {
        loop {
            inside = inside.trim_start_matches(|c: char| c.is_whitespace() || c == ',' || c == '*');
            let name = identifier(inside);
            if name.is_empty() {
                return inside.strip_prefix('}').unwrap_or(inside);
            }
            path.push(name.to_owned());
            inside = read_tree(&inside[name.len()..], path, found);
            path.pop();
            if let Some(alias) = inside.strip_prefix(" as ") {
                inside = &alias[identifier(alias).len()..];
            }
        }
    }
    let name = identifier(after);
    if name.is_empty() {
        // A glob, or generic arguments.
        found.push(path.clone());
        return after;
    }
    path.push(name.to_owned());
    let end = read_tree(&after[name.len()..], path, found);
    path.pop();
    end
}

/// Returns the text with blanks in place of comments and literals; lines stay where they are.
fn code_of(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut code = String::with_capacity(text.len());
    let mut at = 0;
    while at < chars.len() {
        let end = literal_end(&chars, at);
        if end == at {
            code.push(chars[at]);
            at += 1;
        } else {
            code.extend(chars[at..end].iter().map(|&c| if c == '\n' { '\n' } else { ' ' }));
            at = end;
        }
    }
    code
}

/// Returns the end of the comment or literal that begins at `at`; `at` if none does.
fn literal_end(chars: &[char], at: usize) -> usize {
    let rest = &chars[at..];
    let until = |from: usize, end: &[char]| {
        let found = rest[from.min(rest.len())..].windows(end.len()).position(|w| w == end);
        found.map_or(chars.len(), |n| at + from + n + end.len())
    };
    match rest {
        ['/', '/', ..] => at + rest.iter().position(|&c| c == '\n').unwrap_or(rest.len()),
        ['/', '*', ..] => until(2, &['*', '/']),
        ['\'', '\\', ..] => until(3, &['\'']),
        ['\'', _, '\'', ..] => at + 3,
        ['"', ..] => {
            let mut end = 1;
            while end < rest.len() && rest[end] != '"' {
                end += if rest[end] == '\\' { 2 } else { 1 };
            }
            chars.len().min(at + end + 1)
        }
        ['r', '"' | '#', ..] if at == 0 || !(chars[at - 1].is_alphanumeric() || chars[at - 1] == '_') => {
            let hashes = rest[1..].iter().take_while(|&&c| c == '#').count();
            if rest.get(1 + hashes) != Some(&'"') {
                return at;
            }
            let end: Vec<char> = std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
            until(2 + hashes, &end)
        }
        _ => at,
    }
}

/// Returns the code with blanks in place of every item under `#[cfg(test)]`.
fn without_tests(mut code: String) -> String {
    const MARK: &str = "#[cfg(test)]";
    while let Some(start) = code.find(MARK) {
        let (mut depth, mut end) = (0, code.len());
        for (at, c) in code[start + MARK.len()..].char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 && (c == '}' || c == ';') {
                end = start + MARK.len() + at + 1;
                break;
            }
        }
        let blank: String = code[start..end].chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect();
        code.replace_range(start..end, &blank);
    }
    code
}

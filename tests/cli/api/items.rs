//! Reads the public items of a source: what begins at column 0 is an item of the module, what is
//! indented once a member of it.

use std::collections::BTreeSet;

/// A public item of a module.
#[derive(Debug)]
pub struct Item {
    /// The keyword: `fn`, `struct`, `mod` and so on; `macro` for a type that a macro defines.
    pub kind: String,
    pub name: String,
    /// Set if the item is `#[doc(hidden)]`.
    pub is_hidden: bool,
    /// Its declaration on one line, with what it derives.
    pub signature: String,
    /// Public fields, variants, or the functions of a trait.
    pub members: Vec<String>,
}

impl Item {
    /// Returns whether the item can have methods and traits.
    pub fn has_impls(&self) -> bool {
        ["struct", "enum", "union", "macro"].contains(&self.kind.as_str())
    }
}

/// Returns the lines before the module's own tests.
fn lines_of(text: &str) -> Vec<&str> {
    text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or(text).lines().collect()
}

/// Returns the public items of a module.
pub fn items_of(text: &str) -> Vec<Item> {
    let lines = lines_of(text);
    let starts =
        lines.iter().enumerate().filter(|(_, line)| line.starts_with("pub ") && kind_of(line) != "use");
    starts.map(|(at, _)| read_item(&lines, at)).collect()
}

/// Returns the item of this name that a module defines, be it public or not; also one that a macro
/// with a list of values defines.
pub fn item_at(text: &str, name: &str) -> Option<Item> {
    let lines = lines_of(text);
    let is_it = |line: &&str| {
        let kind = kind_of(line);
        line.starts_with("pub ") && !["use", "mod"].contains(&kind) && name_of(line, kind) == name
    };
    match lines.iter().position(is_it) {
        Some(at) => Some(read_item(&lines, at)),
        None => from_macro(&lines, name),
    }
}

/// Returns the types that a module defines, be they public or not.
pub fn defined(text: &str) -> BTreeSet<&str> {
    let defined = |line| {
        let line: &str = line;
        let line = line.strip_prefix("pub ").or(line.strip_prefix("pub(crate) ")).unwrap_or(line);
        let name = ["struct ", "enum ", "union ", "type "].iter().find_map(|kind| line.strip_prefix(kind))?;
        Some(&name[..end_of_name(name)])
    };
    text.lines().filter_map(defined).collect()
}

/// Returns where the name ends that a text begins with.
fn end_of_name(text: &str) -> usize {
    text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len())
}

/// Returns the name of the trait that a line declares for its crate alone.
pub fn crate_trait(line: &str) -> Option<&str> {
    line.strip_prefix("pub(crate) trait ")?.split_once(' ').map(|(name, _)| name)
}

/// Returns the keyword of a declaration.
fn kind_of(line: &str) -> &str {
    let words = line.split(['(', ' ']).skip(1);
    let mut words = words.filter(|word| !["unsafe", "async", "extern", "\"C\""].contains(word));
    match words.next() {
        // `const fn`, but not `const MAX`.
        Some("const") if words.next() == Some("fn") => "fn",
        Some(kind) => kind,
        None => "",
    }
}

/// Returns the name behind the keyword of a declaration.
fn name_of<'l>(line: &'l str, kind: &str) -> &'l str {
    let behind = line.split_once(kind).map_or("", |(_, rest)| rest.trim_start());
    &behind[..end_of_name(behind)]
}

fn read_item(lines: &[&str], at: usize) -> Item {
    let kind = kind_of(lines[at]).to_owned();
    let name = name_of(lines[at], &kind).to_owned();
    let attributes: Vec<&str> = lines[..at]
        .iter()
        .rev()
        .take_while(|line| line.starts_with("#[") || line.starts_with("///"))
        .copied()
        .collect();
    // A module at another path has its file outside of the crate's sources.
    let is_hidden = attributes.iter().any(|line| *line == "#[doc(hidden)]" || line.starts_with("#[path = "));
    let derives = attributes.iter().find(|line| line.starts_with("#[derive("));
    let mut signature = derives.map_or_else(String::new, |line| format!("{line} "));
    signature += &declaration(&lines[at..]);
    let members = match kind.as_str() {
        "struct" => members(&lines[at..], |line| line.starts_with("pub ")),
        "enum" | "trait" => members(&lines[at..], |_| true),
        _ => Vec::new(),
    };
    Item { kind, name, is_hidden, signature, members }
}

/// Returns a declaration on one line, without its body.
fn declaration(lines: &[&str]) -> String {
    let mut found = String::new();
    for line in lines {
        let line = line.trim();
        let needs_blank = !(found.is_empty() || found.ends_with('(') || line.starts_with(')'));
        found += if needs_blank { " " } else { "" };
        found += line;
        if line.ends_with('{') || line.ends_with(';') || line.ends_with('}') {
            break;
        }
    }
    let is_value = found.contains(" const ") && found.contains(" = ") || found.starts_with("pub const ");
    let found = match found.find(" {") {
        Some(body) if !is_value => &found[..body],
        _ => &found,
    };
    found.replace(",)", ")").trim_end_matches([';', '{', ' ', ',']).to_owned()
}

/// Returns the members of a body whose lines, indented once, are wanted.
fn members(lines: &[&str], is_wanted: impl Fn(&str) -> bool) -> Vec<String> {
    if !lines[0].ends_with('{') {
        return Vec::new();
    }
    let body: Vec<&str> = lines[1..].iter().take_while(|line| !line.starts_with('}')).copied().collect();
    let mut found = Vec::new();
    for (at, line) in body.iter().enumerate() {
        let Some(line) =
            line.strip_prefix("    ").filter(|line| !line.starts_with([' ', '/', '#', '}', ')']))
        else {
            continue;
        };
        let attributes = body[..at].iter().rev().map(|line| line.trim());
        let mut attributes = attributes.take_while(|line| line.starts_with("#[") || line.starts_with("///"));
        if is_wanted(line) && !attributes.any(|line| line == "#[doc(hidden)]") {
            // A variant with fields is listed with them.
            let fields: Vec<&str> = match line.ends_with(" {") && !line.contains("fn ") {
                true => {
                    body[at + 1..].iter().take_while(|l| !l.starts_with("    }")).map(|l| l.trim()).collect()
                }
                false => Vec::new(),
            };
            let fields: Vec<&str> = fields.into_iter().filter(|l| !l.starts_with(['/', '#'])).collect();
            let member = match fields.is_empty() {
                true => declaration_of_member(&body[at..]),
                false => format!("{line} {} }}", fields.join(" ").trim_end_matches(',')),
            };
            found.push(member);
        }
    }
    found
}

fn declaration_of_member(lines: &[&str]) -> String {
    match lines[0].contains("fn ") {
        true => declaration(lines),
        false => lines[0].trim().trim_end_matches(',').to_owned(),
    }
}

/// Returns a type that a macro defines by a list of values.
fn from_macro(lines: &[&str], name: &str) -> Option<Item> {
    let Some(at) = lines.iter().position(|line| *line == format!("    {name} {{")) else {
        return from_table(lines, name);
    };
    let start = lines[..at].iter().rposition(|line| line.ends_with("! {"))?;
    let wanted = |line: &&&str| line.starts_with("        ") && !line.trim().starts_with(['/', '#']);
    let values = lines[at + 1..].iter().take_while(|line| **line != "    }").filter(wanted);
    let signature = format!("{} {name}", lines[start].trim_end_matches(" {"));
    let members = values.map(|line| line.trim().trim_end_matches(',').to_owned()).collect();
    Some(Item { kind: "macro".into(), name: name.to_owned(), is_hidden: false, signature, members })
}

/// Returns an enum of commands that the verb table defines, with its rows.
fn from_table(lines: &[&str], name: &str) -> Option<Item> {
    let heads = (0..lines.len()).filter(|&at| {
        let is_block = lines[at].ends_with(&format!(" {name} {{"));
        is_block && lines[at].starts_with(char::is_uppercase)
    });
    let rows: Vec<&str> = heads
        .flat_map(|at| lines[at + 1..].iter().take_while(|line| !line.starts_with('}')))
        .copied()
        .collect();
    let is_row = |line: &str| {
        let begins =
            |indent: &str, c: fn(char) -> bool| line.strip_prefix(indent).is_some_and(|l| l.starts_with(c));
        begins("    ", char::is_uppercase) || begins("        ", |c| c == '|')
    };
    // A variant with many fields takes several lines.
    let whole = |at: usize| match rows[at].ends_with('{') {
        true => {
            let end = rows[at..].iter().position(|line| line.starts_with("    }")).unwrap_or(0);
            rows[at..=at + end].iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
        }
        false => rows[at].to_owned(),
    };
    let starts = (0..rows.len()).filter(|&at| is_row(rows[at]));
    let members: Vec<String> = starts.map(|at| variant_of_row(&whole(at)).to_owned()).collect();
    let (kind, signature) = ("macro".to_owned(), format!("language! {name}"));
    (!members.is_empty()).then(|| Item { kind, name: name.to_owned(), is_hidden: false, signature, members })
}

/// Returns a row of the verb table up to its function or its text: the verb, and the variant with its
/// fields.
fn variant_of_row(row: &str) -> &str {
    let ends = [" = fn ", " = job ", ": \""].iter().filter_map(|end| row.find(end)).min();
    row[..ends.unwrap_or(row.len())].trim().trim_end_matches(": [").trim_end_matches(':')
}

/// Returns the implementations in a source: the type's name, and the trait or the methods.
pub fn impls(text: &str) -> Vec<(String, Vec<String>)> {
    let lines = lines_of(text);
    let mut found = Vec::new();
    for at in (0..lines.len()).filter(|&at| lines[at].starts_with("impl")) {
        let head = declaration(&lines[at..]);
        let (of_trait, subject) = match head.rsplit_once(" for ") {
            Some((_, subject)) => (true, subject),
            None => (false, head.trim_start_matches("impl").trim_start()),
        };
        // Behind the generic parameters of an inherent implementation.
        let subject = match (of_trait, subject.strip_prefix('<')) {
            (false, Some(rest)) => rest.split_once("> ").map_or(rest, |(_, subject)| subject),
            _ => subject,
        };
        let name = subject[..end_of_name(subject)].to_owned();
        found.push(match of_trait {
            true => (name, vec![head]),
            false => (name, members(&lines[at..], |line| line.starts_with("pub ") && !is_crate(line))),
        });
    }
    found
}

/// Returns whether an item is for the crate alone.
fn is_crate(line: &str) -> bool {
    line.starts_with("pub(")
}

/// Returns the paths that a module re-exports, each with the name that it has there.
pub fn uses_of(text: &str) -> Vec<(Vec<String>, String)> {
    let lines = lines_of(text);
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        if !line.starts_with("pub use ") || at > 0 && lines[at - 1] == "#[doc(hidden)]" {
            continue;
        }
        let end = lines[at..].iter().position(|line| line.ends_with(';')).expect("a use ends");
        let joined = lines[at..=at + end].iter().map(|line| line.trim()).collect::<String>();
        let tree = joined.trim_start_matches("pub use ").trim_end_matches(';');
        expand(tree, &[], &mut found);
    }
    found
}

/// Adds the paths of a use tree behind `before`.
fn expand(tree: &str, before: &[String], found: &mut Vec<(Vec<String>, String)>) {
    if let Some((head, group)) = tree.split_once("::{") {
        let head: Vec<String> = before.iter().cloned().chain(head.split("::").map(str::to_owned)).collect();
        let group = group.strip_suffix('}').expect("a group ends");
        let (mut depth, mut start) = (0, 0);
        for (at, c) in group.char_indices().chain([(group.len(), ',')]) {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    let part = group[start..at].trim();
                    if !part.is_empty() {
                        expand(part, &head, found);
                    }
                    start = at + 1;
                }
                _ => {}
            }
        }
        return;
    }
    let (path, name) = tree.split_once(" as ").unwrap_or((tree, ""));
    let path: Vec<String> = before.iter().cloned().chain(path.split("::").map(str::to_owned)).collect();
    let name = if name.is_empty() { path.last().expect("a name").clone() } else { name.to_owned() };
    found.push((path, name));
}

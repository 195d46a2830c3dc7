//! The public interface: every item that a program can name without a hidden module, as it is
//! written, in `api/listing.txt`. A change of it fails here until it is accepted with `BLESS=1`, so
//! that it does not grow unseen.
//!
//! The listing is read from the sources, whose layout rustfmt fixes. Items of all features are in
//! it, on every system.

mod items;

use items::{Item, item_at, items_of, uses_of};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The sources of the crate by their paths below `src`, with `/` between folders.
type Sources = BTreeMap<String, String>;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn sources() -> Sources {
    fn read(folder: &Path, found: &mut Sources) {
        for path in fs::read_dir(folder).expect("src is readable").map(|e| e.expect("an entry").path()) {
            if path.is_dir() {
                read(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let name = path.strip_prefix(root().join("src")).expect("below src");
                let name = name.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/");
                found.insert(name, fs::read_to_string(&path).expect("text"));
            }
        }
    }
    let mut found = Sources::new();
    read(&root().join("src"), &mut found);
    found
}

/// The listing in the making.
struct Listing<'s> {
    sources: &'s Sources,
    lines: BTreeSet<String>,
    /// Public path of each definition (its file and name) that is listed already.
    listed: BTreeMap<(String, String), String>,
}

impl Listing<'_> {
    /// Returns the file of a module, whose path counts from the crate's root.
    fn file_of(&self, module: &[String]) -> Option<String> {
        let path = module.join("/");
        let names = match module {
            [] => vec!["lib.rs".to_owned()],
            _ => vec![format!("{path}.rs"), format!("{path}/mod.rs")],
        };
        names.into_iter().find(|name| self.sources.contains_key(name))
    }

    /// Lists the public items of a module under the path `shown`.
    fn module(&mut self, module: &[String], shown: &str) {
        let file = self.file_of(module).unwrap_or_else(|| panic!("no file of the module {shown}"));
        let text = &self.sources[&file];
        let mut inner = Vec::new();
        for item in items_of(text) {
            match &item {
                Item { is_hidden: true, .. } => {}
                Item { kind, name, .. } if kind == "mod" => inner.push(name.clone()),
                Item { name, .. } => self.item(module, &file, name, &format!("{shown}::{name}")),
            }
        }
        for (path, name) in uses_of(text) {
            self.reexport(module, &path, &format!("{shown}::{name}"));
        }
        for name in inner {
            let path: Vec<String> = module.iter().cloned().chain([name.clone()]).collect();
            self.module(&path, &format!("{shown}::{name}"));
        }
    }

    /// Lists what a `pub use` in `module` names.
    fn reexport(&mut self, module: &[String], path: &[String], shown: &str) {
        let full: Vec<String> = match path[0].as_str() {
            "crate" => path[1..].to_vec(),
            "super" => module.iter().take(module.len() - 1).cloned().chain(path[1..].to_vec()).collect(),
            "self" => module.iter().cloned().chain(path[1..].to_vec()).collect(),
            _ => module.iter().cloned().chain(path.to_vec()).collect(),
        };
        let (name, parent) = full.split_last().expect("a path");
        match self.file_of(parent) {
            _ if path.len() == 1 => drop(self.lines.insert(format!("{shown} = {}", path[0]))),
            Some(file) => self.item(parent, &file, name, shown),
            None => drop(self.lines.insert(format!("{shown} = {}", path.join("::")))),
        }
    }

    /// Lists an item of a file with its fields, variants, methods and traits, or follows the `use`
    /// that brings it there.
    fn item(&mut self, module: &[String], file: &str, name: &str, shown: &str) {
        let Some(item) = item_at(&self.sources[file], name) else {
            let brought = uses_of(&self.sources[file]).into_iter().find(|(_, n)| n == name);
            let (path, _) = brought.unwrap_or_else(|| panic!("{shown}: {file} has no {name}"));
            return self.reexport(module, &path, shown);
        };
        if let Some(first) = self.listed.get(&(file.to_owned(), name.to_owned())) {
            self.lines.insert(format!("{shown} = {first}"));
            return;
        }
        self.listed.insert((file.to_owned(), name.to_owned()), shown.to_owned());
        self.lines.insert(format!("{shown}: {}", item.signature));
        self.lines.extend(item.members.iter().map(|member| format!("{shown}: . {member}")));
        if item.has_impls() {
            self.impls(file, name, shown);
        }
    }

    /// Lists methods and traits of a type that `file` defines.
    fn impls(&mut self, file: &str, name: &str, shown: &str) {
        for (other, text) in self.sources {
            let is_namesake = || other != file && items::defines(text, name);
            let is_test = other.split('/').any(|part| part.starts_with("tests"));
            if is_test || !text.contains(name) || is_namesake() {
                continue;
            }
            let found = items::impls_of(text, name);
            let found = found.into_iter().filter(|line| !self.is_of_a_crate_trait(line));
            let lines: Vec<String> = found.map(|line| format!("{shown}: {line}")).collect();
            self.lines.extend(lines);
        }
    }

    /// Returns whether a line implements a trait that is for the crate alone.
    fn is_of_a_crate_trait(&self, line: &str) -> bool {
        let Some(name) = line.strip_prefix("impl ").and_then(|line| line.split([' ', '<']).next()) else {
            return false;
        };
        let declaration = format!("pub(crate) trait {name} ");
        self.sources.values().any(|text| text.lines().any(|line| line.starts_with(&declaration)))
    }
}

/// Returns the listing, a line for each item.
fn listing(sources: &Sources) -> Vec<String> {
    let mut listing = Listing { sources, lines: BTreeSet::new(), listed: BTreeMap::new() };
    listing.module(&[], "fbptr");
    listing.lines.into_iter().collect()
}

#[test]
fn the_public_interface_is_the_one_that_is_checked_in() {
    let path = root().join("tests/cli/api/listing.txt");
    let found = listing(&sources());
    if std::env::var_os("BLESS").is_some_and(|v| v == "1") {
        fs::write(&path, found.join("\n") + "\n").expect("a writable file");
        panic!("{}: rewritten; this run fails, run again without BLESS", path.display());
    }
    let expected = fs::read_to_string(&path).unwrap_or_default();
    let expected: BTreeSet<&str> = expected.lines().collect();
    let found: BTreeSet<&str> = found.iter().map(String::as_str).collect();
    let more = found.difference(&expected).map(|line| format!("+ {line}"));
    let less = expected.difference(&found).map(|line| format!("- {line}"));
    let changes: Vec<String> = more.chain(less).collect();
    assert!(
        changes.is_empty(),
        "the public interface has changed; accept it with BLESS=1 cargo test --test cli api\n{}",
        changes.join("\n")
    );
    assert!(found.len() > 300, "only {} items: the sources are no longer read", found.len());
}

#[test]
fn every_kind_of_item_is_listed_and_nothing_hidden_is() {
    let files = [
        (
            "lib.rs",
            "pub mod a;\n#[doc(hidden)]\npub mod b;\nmod c;\npub use a::Thing;\npub use c::{Ask, deep::Deep, run as go};\npub use glam;\n",
        ),
        (
            "a/mod.rs",
            "mod thing;\nmod words;\npub use thing::Thing;\npub use words::Word;\npub(crate) fn own() {}\n\
             pub const MAX: u32 = 3;\npub fn f(\n    x: u32,\n) -> u32 {\n    x\n}\n#[cfg(test)]\nmod tests {\n    pub fn t() {}\n}\n",
        ),
        (
            "a/thing.rs",
            "/// Doc.\n#[derive(Clone, Debug)]\npub struct Thing {\n    /// Doc.\n    pub x: u32,\n    y: u32,\n}\n\n\
             impl Thing {\n    pub fn new() -> Thing {\n        Thing { x: 0, y: 0 }\n    }\n    fn own(&self) {}\n}\n\n\
             impl From<u32> for Thing {\n    fn from(x: u32) -> Self {\n        Thing { x, y: 0 }\n    }\n}\n\n\
             pub(crate) trait Own {\n    fn m(&self);\n}\n\nimpl Own for Thing {\n    fn m(&self) {}\n}\n",
        ),
        (
            "a/words.rs",
            "keywords! {\n    /// Doc.\n    Word {\n        /// Doc.\n        One = \"one\",\n    }\n}\n",
        ),
        (
            "c/table.rs",
            "rows! {\nGroup Text Ask {\n    A One { x: [u8; 2], y[\"y z\"]: u32 } = fn one\n        | Two(x: u32) = fn two -> Line: [\n        \"A x\": \"asks\",\n    ] eg \"A\";\n    B Three: \"tells\" eg \"B\";\n}\n}\n",
        ),
        ("b.rs", "pub struct Hidden;\npub fn hidden() {}\n"),
        ("c/mod.rs", "mod table;\npub use table::Ask;\npub mod deep;\npub fn run() {}\npub fn other() {}\n"),
        (
            "c/deep.rs",
            "pub enum Deep {\n    /// Doc.\n    A,\n    B { n: u8 },\n}\npub trait T {\n    fn m(&self);\n}\n",
        ),
    ];
    let sources: Sources = files.map(|(name, text)| (name.to_owned(), text.to_owned())).into();
    let expected = [
        "fbptr::Ask: . A One { x: [u8; 2], y[\"y z\"]: u32 }",
        "fbptr::Ask: . B Three",
        "fbptr::Ask: . | Two(x: u32)",
        "fbptr::Ask: language! Ask",
        "fbptr::Deep: . A",
        "fbptr::Deep: . B { n: u8 }",
        "fbptr::Deep: pub enum Deep",
        "fbptr::Thing: #[derive(Clone, Debug)] pub struct Thing",
        "fbptr::Thing: . pub x: u32",
        "fbptr::Thing: impl From<u32> for Thing",
        "fbptr::Thing: pub fn new() -> Thing",
        "fbptr::a::MAX: pub const MAX: u32 = 3",
        "fbptr::a::Thing = fbptr::Thing",
        "fbptr::a::Word: . One = \"one\"",
        "fbptr::a::Word: keywords! Word",
        "fbptr::a::f: pub fn f(x: u32) -> u32",
        "fbptr::glam = glam",
        "fbptr::go: pub fn run()",
    ];
    assert_eq!(listing(&sources), expected);
}

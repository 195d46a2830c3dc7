//! The public interfaces: every item that a program can name without a hidden module, as it is
//! written, of the facade in `api/listing.txt`, of each other crate in `api/CRATE.txt`. A change of one
//! fails here until it is accepted with `BLESS=1`, so that none grows unseen.
//!
//! The listing is read from the sources, whose layout rustfmt fixes. Items of all features are in
//! it, on every system.

mod items;

use items::{Item, item_at, items_of, uses_of};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The sources of all crates by their paths: those of the facade below `src`, those of another crate
/// below its name; with `/` between folders.
type Sources = BTreeMap<String, String>;

/// The crates beside the facade, as code names them.
const CRATES: [&str; 8] = [
    "fbptr_command",
    "fbptr_core",
    "fbptr_desktop",
    "fbptr_engine",
    "fbptr_formats",
    "fbptr_lab",
    "fbptr_server",
    "fbptr_truth",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn sources() -> Sources {
    fn read(top: &Path, folder: &Path, place: &str, found: &mut Sources) {
        for path in fs::read_dir(folder).expect("a readable folder").map(|e| e.expect("an entry").path()) {
            if path.is_dir() {
                read(top, &path, place, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let name = path.strip_prefix(top).expect("below src");
                let name = name.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/");
                let name = if name == "lib.rs" && !place.is_empty() { "mod.rs".to_owned() } else { name };
                found.insert(format!("{place}{name}"), fs::read_to_string(&path).expect("text"));
            }
        }
    }
    let mut found = Sources::new();
    read(&root().join("src"), &root().join("src"), "", &mut found);
    for name in CRATES {
        let src = root().join("crates").join(name.trim_start_matches("fbptr_")).join("src");
        read(&src, &src, &format!("{name}/"), &mut found);
    }
    found
}

/// A source's name, the types that it defines, and its implementations, each with the type's name.
struct Implementing<'s> {
    file: &'s str,
    defined: BTreeSet<&'s str>,
    impls: Vec<(String, Vec<String>)>,
}

/// The listing in the making.
struct Listing<'s> {
    sources: &'s Sources,
    /// Names of the traits that are for a crate alone.
    crate_traits: BTreeSet<&'s str>,
    /// Each source but the tests.
    implementing: Vec<Implementing<'s>>,
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
        // The crate that the module belongs to: none for the facade.
        let own = module.iter().take(1).filter(|name| CRATES.contains(&name.as_str()));
        let full: Vec<String> = match path[0].as_str() {
            name if CRATES.contains(&name) => path.to_vec(),
            "crate" => own.cloned().chain(path[1..].to_vec()).collect(),
            "super" => module.iter().take(module.len() - 1).cloned().chain(path[1..].to_vec()).collect(),
            "self" => module.iter().cloned().chain(path[1..].to_vec()).collect(),
            _ => module.iter().cloned().chain(path.to_vec()).collect(),
        };
        let (name, parent) = full.split_last().expect("a path");
        match self.file_of(parent) {
            _ if self.file_of(&full).is_some() => self.module(&full, shown),
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
        for Implementing { file: other, defined, impls } in &self.implementing {
            if *other != file && defined.contains(name) {
                continue;
            }
            let found = impls.iter().filter(|(subject, _)| subject == name).flat_map(|(_, lines)| lines);
            let found = found.filter(|line| !self.is_of_a_crate_trait(line));
            self.lines.extend(found.map(|line| format!("{shown}: {line}")).collect::<Vec<_>>());
        }
    }

    /// Returns whether a line implements a trait that is for the crate alone.
    fn is_of_a_crate_trait(&self, line: &str) -> bool {
        let name = line.strip_prefix("impl ").and_then(|line| line.split([' ', '<']).next());
        name.is_some_and(|name| self.crate_traits.contains(name))
    }
}

/// Returns the listing of a crate, a line for each item; of the facade if it has no name.
fn listing(sources: &Sources, name: Option<&str>) -> Vec<String> {
    let traits = sources.values().flat_map(|text| text.lines().filter_map(items::crate_trait));
    let tested = sources.iter().filter(|(name, _)| !name.split('/').any(|part| part.starts_with("tests")));
    let mut listing = Listing {
        sources,
        crate_traits: traits.collect(),
        implementing: tested
            .map(|(file, text)| Implementing {
                file,
                defined: items::defined(text),
                impls: items::impls(text),
            })
            .collect(),
        lines: BTreeSet::new(),
        listed: BTreeMap::new(),
    };
    let module: Vec<String> = name.map(str::to_owned).into_iter().collect();
    listing.module(&module, name.unwrap_or("fbptr"));
    listing.lines.into_iter().collect()
}

/// Compares the listing of a crate with the one that is checked in. Returns the differences; with
/// `BLESS=1` it is written first.
fn changes(sources: &Sources, name: Option<&str>, is_blessed: bool) -> Vec<String> {
    let path = root().join("tests/cli/api").join(name.unwrap_or("listing")).with_extension("txt");
    let found = listing(sources, name);
    let expected = fs::read_to_string(&path).unwrap_or_default();
    if is_blessed {
        fs::write(&path, found.join("\n") + "\n").expect("a writable file");
    }
    let expected: BTreeSet<&str> = expected.lines().collect();
    let found: BTreeSet<&str> = found.iter().map(String::as_str).collect();
    assert!(found.len() > 20, "only {} items of {name:?}: the sources are no longer read", found.len());
    let more = found.difference(&expected).map(|line| format!("+ {line}"));
    let less = expected.difference(&found).map(|line| format!("- {line}"));
    more.chain(less).collect()
}

#[test]
fn the_public_interfaces_are_those_that_are_checked_in() {
    let is_blessed = std::env::var_os("BLESS").is_some_and(|v| v == "1");
    let all = [None].into_iter().chain(CRATES.map(Some));
    let sources = sources();
    let changes: Vec<String> = all.flat_map(|name| changes(&sources, name, is_blessed)).collect();
    assert!(
        changes.is_empty(),
        "the public interface has changed; accept it with BLESS=1 cargo test --test cli api\n{}",
        changes.join("\n")
    );
    assert!(!is_blessed, "the listings are as they were; run again without BLESS");
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
    assert_eq!(listing(&sources, None), expected);
}

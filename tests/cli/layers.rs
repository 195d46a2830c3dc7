//! The allowed imports that Cargo cannot say: between the parts of a crate, and between the parts of
//! `pipeline` and `eye` (the modules one level below). An import that is not listed fails with its
//! file and line, a listed one that nothing uses fails too, and the lists have no cycle. Test code
//! may import anything. Also checked: the tests are few programs, because each is linked with the
//! whole.

mod lists;
mod reader;

use lists::{CIRCLES, Edges, PLACES};
use reader::{Import, imports, reexports};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A source of a crate.
struct Source {
    /// Its path below `crates`.
    file: PathBuf,
    text: String,
}

impl Source {
    /// Returns the module's path, which begins with its crate.
    fn module(&self) -> Vec<String> {
        let parts = self.file.with_extension("");
        let parts = parts.iter().map(|part| part.to_string_lossy().into_owned());
        parts.filter(|part| !["src", "mod", "lib"].contains(&part.as_str())).collect()
    }

    fn is_test(&self) -> bool {
        self.module().iter().any(|part| part.starts_with("tests") || part == "truth_scenes")
    }
}

/// Returns the sources of the crates.
fn sources() -> Vec<Source> {
    fn read(root: &Path, dir: &Path, found: &mut Vec<Source>) {
        for path in fs::read_dir(dir).expect("a readable folder").map(|e| e.expect("entry").path()) {
            if path.is_dir() {
                read(root, &path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let file = path.strip_prefix(root).expect("under crates").to_owned();
                found.push(Source { file, text: fs::read_to_string(&path).expect("readable") });
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    let mut found = Vec::new();
    for name in fs::read_dir(&root).expect("crates is readable").map(|e| e.expect("entry").path()) {
        read(&root, &name.join("src"), &mut found);
    }
    found
}

/// A place whose parts have a list.
struct Place {
    path: Vec<String>,
    edges: Edges,
    /// Its parts, and the names that its root re-exports, each with its part.
    parts: BTreeSet<String>,
    reexports: BTreeMap<String, String>,
}

impl Place {
    fn new(path: &[&str], edges: Edges, sources: &[Source]) -> Place {
        let path: Vec<String> = path.iter().map(|name| (*name).to_owned()).collect();
        let depth = path.len();
        let inside: Vec<&Source> = sources.iter().filter(|s| s.module().starts_with(&path)).collect();
        let parts: BTreeSet<String> = inside.iter().filter_map(|s| s.module().get(depth).cloned()).collect();
        let root = inside.iter().find(|s| s.module().len() == depth).map_or("", |s| &s.text);
        let named = parts.iter().cloned().chain(["fbptr_engine".to_owned()]).collect();
        let reexports = reexports(root, &named).into_iter().collect();
        Place { path, edges, parts, reexports }
    }

    /// Returns the part that a path names; `None` outside of this place, and for what its root has from
    /// another crate. An item of the root itself
    /// counts as the part `(root)`, which no list allows.
    fn part_of(&self, path: &[String]) -> Option<String> {
        let inside = path.strip_prefix(self.path.as_slice())?;
        let own = "(root)".to_owned();
        let part = match inside.first() {
            Some(part) if self.parts.contains(part) => part.clone(),
            Some(item) => self.reexports.get(item).cloned().unwrap_or(own),
            None => own,
        };
        (part != "fbptr_engine").then_some(part)
    }

    fn name(&self, part: &str) -> String {
        format!("{}::{part}", self.path.join("::"))
    }
}

/// Compares the imports with the lists. Returns the complaints, each with its file and line, and
/// the number of imports between parts.
fn compare(sources: &[Source], places: &[(&[&str], Edges)]) -> (Vec<String>, usize) {
    let (mut complaints, mut used, mut seen) = (Vec::new(), BTreeSet::new(), 0);
    let places: Vec<Place> = places.iter().map(|(path, edges)| Place::new(path, edges, sources)).collect();
    for source in sources.iter().filter(|s| !s.is_test()) {
        let module = source.module();
        for Import { line, path } in imports(&source.text, &module) {
            for place in &places {
                let inside = module.strip_prefix(place.path.as_slice()).and_then(|inside| inside.first());
                let (Some(from), Some(to)) = (inside, place.part_of(&path)) else { continue };
                if *from == to {
                    continue;
                }
                seen += 1;
                let is_listed =
                    |(name, allowed): &(&str, &[&str])| name == from && allowed.contains(&to.as_str());
                if place.edges.iter().any(is_listed) {
                    used.insert(format!("{} imports {}", place.name(from), place.name(&to)));
                } else {
                    let at = format!("crates/{}:{line}", source.file.display());
                    complaints.push(format!("{at}: {} imports {}", place.name(from), place.name(&to)));
                }
            }
        }
    }
    for place in &places {
        for (from, allowed) in place.edges {
            let all = allowed.iter().map(|to| format!("{} imports {}", place.name(from), place.name(to)));
            complaints.extend(all.filter(|edge| !used.contains(edge)).map(|edge| format!("unused: {edge}")));
        }
    }
    (complaints, seen)
}

/// Returns a cycle of a list, if there is one.
fn cycle(list: Edges) -> Option<Vec<String>> {
    fn visit<'e>(
        name: &'e str,
        list: Edges,
        path: &mut Vec<&'e str>,
        done: &mut BTreeSet<&'e str>,
    ) -> Option<Vec<String>> {
        if let Some(start) = path.iter().position(|p| *p == name) {
            return Some(path[start..].iter().chain([&name]).map(|p| (*p).to_owned()).collect());
        }
        if !done.insert(name) {
            return None;
        }
        path.push(name);
        let next = list.iter().filter(|(from, _)| *from == name).flat_map(|(_, to)| *to);
        let found = next.copied().find_map(|next| visit(next, list, path, done));
        path.pop();
        found
    }
    let mut done = BTreeSet::new();
    list.iter().find_map(|(name, _)| visit(name, list, &mut Vec::new(), &mut done))
}

#[test]
fn every_import_is_listed_and_every_listed_one_is_used() {
    let (complaints, seen) = compare(&sources(), PLACES);
    assert!(seen > 800, "the test found only {seen} imports: it no longer reads them");
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// Returns what a file imports, itself or by others.
fn reach<'a>(
    edges: &BTreeMap<&'a [String], BTreeSet<&'a [String]>>,
    from: &'a [String],
) -> BTreeSet<&'a [String]> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(at) = open.pop() {
        open.extend(edges.get(at).into_iter().flatten().copied().filter(|to| found.insert(*to)));
    }
    found
}

/// Returns the groups of files that import each other in a circle, the files of a group in order. A
/// module and what it contains, and the crates' roots, do not count.
fn circles(sources: &[Source]) -> BTreeSet<String> {
    let files: BTreeMap<Vec<String>, &Source> =
        sources.iter().filter(|s| !s.is_test() && s.module().len() > 1).map(|s| (s.module(), s)).collect();
    let mut edges: BTreeMap<&[String], BTreeSet<&[String]>> = BTreeMap::new();
    for (module, source) in &files {
        for Import { path, .. } in imports(&source.text, module) {
            let target = (2..=path.len()).rev().find_map(|n| files.get_key_value(&path[..n]));
            let Some((target, _)) = target else { continue };
            if !target.starts_with(module) && !module.starts_with(target) {
                edges.entry(module).or_default().insert(target);
            }
        }
    }
    let reached: BTreeMap<&[String], BTreeSet<&[String]>> =
        edges.keys().map(|at| (*at, reach(&edges, at))).collect();
    let meet = |a: &[String], b: &[String]| reached.get(a).is_some_and(|found| found.contains(b));
    let group = |at: &[String]| {
        let all = reached.keys().filter(|to| **to == at || meet(at, to) && meet(to, at));
        all.map(|module| module.join("::")).collect::<Vec<_>>()
    };
    reached.keys().filter(|at| meet(at, at)).map(|at| group(at).join(" ")).collect()
}

#[test]
fn files_that_import_each_other_are_named_with_their_reason() {
    let found = circles(&sources());
    let named: BTreeSet<String> = CIRCLES.iter().map(|(files, _)| files.join(" ")).collect();
    let new: Vec<&String> = found.difference(&named).collect();
    let gone: Vec<&String> = named.difference(&found).collect();
    assert!(new.is_empty() && gone.is_empty(), "not named: {new:#?}\nno circle any more: {gone:#?}");
    assert!(CIRCLES.iter().all(|(_, reason)| reason.len() > 20));
    let source = |file: &str, text: &str| Source { file: file.into(), text: text.to_owned() };
    let sources = [
        source("core/src/lib.rs", "pub mod a;"),
        source("core/src/a.rs", "use crate::b::X;\nuse crate::c;"),
        source("core/src/b/mod.rs", "mod deep;\nuse crate::a;"),
        source("core/src/b/deep.rs", "use super::Y;"),
        source("core/src/c.rs", "use crate::b::deep;"),
    ];
    assert_eq!(circles(&sources), BTreeSet::from(["core::a core::b".to_owned()]));
}

#[test]
fn the_lists_have_no_cycle() {
    for (path, list) in PLACES {
        assert_eq!(cycle(list), None, "{path:?}");
    }
    assert_eq!(cycle(&[("a", &["b"]), ("b", &["c"]), ("c", &["a"])]).map(|c| c.len()), Some(4));
    assert_eq!(cycle(&[("a", &["b", "c"]), ("b", &["c"])]), None);
}

#[test]
fn imports_that_are_not_listed_are_found() {
    let source = |file: &str, text: &str| Source { file: file.into(), text: text.to_owned() };
    let sources = [
        source("core/src/lib.rs", "pub mod eye;\npub mod truth;\npub use truth::TEXT;"),
        source(
            "core/src/eye/mod.rs",
            "mod pose;\nmod scene;\npub use scene::{Scene, Facet as F};\npub fn own() {}",
        ),
        source("core/src/eye/pose.rs", "use super::Scene;\n\npub(super) fn f() { super::own() }\n"),
        source(
            "core/src/eye/scene/mod.rs",
            "// use crate::truth;\nuse super::super::eye::pose::{self, Pose};\nuse crate::TEXT;",
        ),
        source(
            "core/src/eye/scene/deep.rs",
            "#[cfg(test)]\nmod tests {\n    use crate::eye::pose;\n}\nuse super::X;",
        ),
        source("core/src/truth.rs", "pub const TEXT: &str = \"crate::cli\";"),
        source("lab/src/cli.rs", "use crate::{\n    eye::{self, Scene},\n    truth,\n};"),
    ];
    let places: &[(&[&str], Edges)] =
        &[(&["core"], &[("truth", &["eye"])]), (&["core", "eye"], &[("scene", &["pose"])])];
    let (complaints, seen) = compare(&sources, places);
    let expected = [
        "crates/core/src/eye/pose.rs:1: core::eye::pose imports core::eye::scene",
        "crates/core/src/eye/pose.rs:3: core::eye::pose imports core::eye::(root)",
        "crates/core/src/eye/scene/mod.rs:3: core::eye imports core::truth",
        "unused: core::truth imports core::eye",
    ];
    assert_eq!((complaints, seen), (expected.map(str::to_owned).to_vec(), 5));
}

#[test]
fn the_integration_tests_are_at_most_eight_programs() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let entries = fs::read_dir(&tests).expect("tests is readable").map(|e| e.expect("entry").path());
    // Files and folders that Cargo takes for test programs.
    let programs: Vec<PathBuf> =
        entries.filter(|p| p.extension().is_some_and(|e| e == "rs") || p.join("main.rs").is_file()).collect();
    assert!(programs.len() > 3, "the test found only {programs:?}: it no longer sees them");
    assert!(programs.len() <= 8, "a new test is a module of one of the others: {programs:#?}");
}

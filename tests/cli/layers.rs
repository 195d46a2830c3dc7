//! The allowed imports: between the rooms of the crate, and between the parts (the modules one level
//! below) of `eye`, `pipeline` and `server`. An import that is not listed fails with its file and
//! line, a listed one that nothing uses fails too, and the lists have no cycle. Test code may import
//! anything. Also checked: the tests are few programs, because each is linked with the whole crate.

mod lists;
mod reader;

use lists::{EYE, Edges, OBSERVERS, PIPELINE, ROOMS, SERVER};
use reader::{Import, imports, reexports};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A source of the crate.
struct Source {
    /// Its path below `src`.
    file: PathBuf,
    text: String,
}

impl Source {
    /// Returns the module's path from the crate's root on.
    fn module(&self) -> Vec<String> {
        let parts = self.file.with_extension("");
        let parts = parts.iter().map(|part| part.to_string_lossy().into_owned());
        parts.filter(|part| part != "mod" && part != "lib").collect()
    }

    fn is_test(&self) -> bool {
        self.module().iter().any(|part| part == "tests")
    }
}

/// Returns the sources of the crate, but the program's.
fn sources() -> Vec<Source> {
    fn read(root: &Path, dir: &Path, found: &mut Vec<Source>) {
        for path in fs::read_dir(dir).expect("src is readable").map(|e| e.expect("entry").path()) {
            if path.is_dir() {
                read(root, &path, found);
            } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("main.rs") {
                let file = path.strip_prefix(root).expect("under src").to_owned();
                found.push(Source { file, text: fs::read_to_string(&path).expect("readable") });
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    read(&root, &root, &mut found);
    found
}

/// A room whose parts have a list.
struct Room {
    name: &'static str,
    edges: Edges,
    /// Its parts, and the names that its root re-exports, each with its part.
    parts: BTreeSet<String>,
    reexports: BTreeMap<String, String>,
}

impl Room {
    fn new(name: &'static str, edges: Edges, sources: &[Source]) -> Room {
        let in_room = || sources.iter().filter(|s| s.module().first().is_some_and(|room| room == name));
        let parts: BTreeSet<String> = in_room().filter_map(|s| s.module().get(1).cloned()).collect();
        let root = in_room().find(|s| s.module().len() == 1).map_or("", |s| &s.text);
        let reexports = reexports(root, &parts).into_iter().collect();
        Room { name, edges, parts, reexports }
    }

    /// Returns the part that a path of this room names. An item of the root itself counts as the
    /// part `(root)`, which no list allows.
    fn part_of(&self, path: &[String]) -> String {
        let own = "(root)".to_owned();
        match path.get(1) {
            Some(part) if self.parts.contains(part) => part.clone(),
            Some(item) => self.reexports.get(item).cloned().unwrap_or(own),
            None => own,
        }
    }
}

/// An import between two rooms, or between two parts of a room.
struct Edge {
    /// The room; empty between rooms.
    room: &'static str,
    list: Edges,
    from: String,
    to: String,
}

/// Returns the edge that an import makes; `None` within a part, in a room's root, and within rooms
/// without a list.
fn edge(module: &[String], path: &[String], rooms: Edges, parts: &[Room]) -> Option<Edge> {
    let target = path.first()?;
    if *target != module[0] {
        return Some(Edge { room: "", list: rooms, from: module.join("::"), to: target.clone() });
    }
    let room = parts.iter().find(|room| room.name == target)?;
    let (from, to) = (module.get(1)?.clone(), room.part_of(path));
    (from != to).then_some(Edge { room: room.name, list: room.edges, from, to })
}

/// Compares the imports with the lists. Returns the complaints, each with its file and line, and
/// the number of imports between rooms or parts.
fn compare(sources: &[Source], rooms: Edges, parts: &[(&'static str, Edges)]) -> (Vec<String>, usize) {
    let (mut complaints, mut used, mut seen) = (Vec::new(), BTreeSet::new(), 0);
    let parts: Vec<Room> = parts.iter().map(|(name, edges)| Room::new(name, edges, sources)).collect();
    for source in sources.iter().filter(|s| !s.is_test() && !s.module().is_empty()) {
        let module = source.module();
        for Import { line, path } in imports(&source.text, &module) {
            let Some(Edge { room, list, from, to }) = edge(&module, &path, rooms, &parts) else { continue };
            seen += 1;
            let covers = |name: &str| from == name || from.starts_with(&format!("{name}::"));
            let entry = list.iter().find(|(name, allowed)| covers(name) && allowed.contains(&to.as_str()));
            match entry {
                Some((name, _)) => {
                    used.insert((room, *name, to));
                }
                None => {
                    let place = format!("src/{}:{line}", source.file.display());
                    complaints.push(format!("{place}: {} imports {}", full(room, &from), full(room, &to)));
                }
            }
        }
    }
    for (room, list) in parts.iter().map(|room| (room.name, room.edges)).chain([("", rooms)]) {
        for (name, allowed) in list {
            let unused = allowed.iter().filter(|to| !used.contains(&(room, *name, (**to).to_owned())));
            complaints
                .extend(unused.map(|to| format!("unused: {} imports {}", full(room, name), full(room, to))));
        }
    }
    (complaints, seen)
}

/// Returns the name of a room, or of a part with its room.
fn full(room: &str, name: &str) -> String {
    if room.is_empty() { name.to_owned() } else { format!("{room}::{name}") }
}

/// Returns a cycle of a list, if there is one; entries of parts count for their room.
fn cycle(list: Edges) -> Option<Vec<String>> {
    let mut edges: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (name, allowed) in list {
        edges.entry(name.split("::").next().unwrap_or(name)).or_default().extend(*allowed);
    }
    fn visit<'e>(
        name: &'e str,
        edges: &BTreeMap<&'e str, BTreeSet<&'e str>>,
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
        let next = edges.get(name).into_iter().flatten();
        let found = next.copied().find_map(|next| visit(next, edges, path, done));
        path.pop();
        found
    }
    let mut done = BTreeSet::new();
    edges.keys().copied().find_map(|name| visit(name, &edges, &mut Vec::new(), &mut done))
}

#[test]
fn every_import_is_listed_and_every_listed_one_is_used() {
    let (complaints, seen) =
        compare(&sources(), ROOMS, &[("eye", EYE), ("pipeline", PIPELINE), ("server", SERVER)]);
    assert!(seen > 1000, "the test found only {seen} imports: it no longer reads them");
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn the_lists_have_no_cycle() {
    for list in [ROOMS, EYE, PIPELINE, SERVER] {
        assert_eq!(cycle(list), None);
    }
    assert_eq!(cycle(&[("a", &["b"]), ("b::x", &["c"]), ("c", &["a"])]).map(|c| c.len()), Some(4));
    assert_eq!(cycle(&[("a", &["b", "c"]), ("b", &["c"])]), None);
}

/// Returns everything that a part imports, itself or by others.
fn reached(list: Edges, from: &str) -> BTreeSet<&str> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(name) = open.pop() {
        let imports = list.iter().filter(|(part, _)| *part == name).flat_map(|(_, to)| *to);
        open.extend(imports.filter(|to| found.insert(**to)));
    }
    found
}

#[test]
fn observers_import_the_engine_and_it_imports_none_of_them() {
    let of_engine = reached(SERVER, "engine");
    for observer in OBSERVERS {
        assert!(!of_engine.contains(observer), "engine reaches {observer}: {of_engine:?}");
        assert!(reached(SERVER, observer).contains("engine"), "{observer} observes nothing");
    }
    // Every implementation of the trait is in the list.
    for source in sources().iter().filter(|s| !s.is_test() && s.text.contains(" Observer for ")) {
        let module = source.module();
        let part = module.get(1).map(String::as_str).unwrap_or_default();
        assert!(module[0] == "server" && OBSERVERS.contains(&part), "{}", source.file.display());
    }
    let list: Edges = &[("a", &["b"]), ("b", &["c"]), ("d", &["a"])];
    assert_eq!(reached(list, "a"), BTreeSet::from(["b", "c"]));
}

#[test]
fn imports_that_are_not_listed_are_found() {
    let source = |file: &str, text: &str| Source { file: file.into(), text: text.to_owned() };
    let sources = [
        source("eye/mod.rs", "mod pose;\nmod scene;\npub use scene::{Scene, Facet as F};\npub fn own() {}"),
        source("eye/pose.rs", "use super::Scene;\n\npub(super) fn f() { super::own() }\n"),
        source("eye/scene/mod.rs", "// use crate::truth;\nuse super::super::eye::pose::{self, Pose};"),
        source("eye/scene/deep.rs", "#[cfg(test)]\nmod tests {\n    use crate::eye::pose;\n}\nuse super::X;"),
        source("truth.rs", "pub const TEXT: &str = \"crate::cli\";"),
        source("cli.rs", "use crate::{\n    eye::{self, Scene},\n    truth,\n};"),
    ];
    let rooms: Edges = &[("cli", &["eye"]), ("eye::pose", &["cli"])];
    let parts: Edges = &[("scene", &["pose"])];
    let (complaints, seen) = compare(&sources, rooms, &[("eye", parts)]);
    let expected = [
        "src/eye/pose.rs:1: eye::pose imports eye::scene",
        "src/eye/pose.rs:3: eye::pose imports eye::(root)",
        "src/cli.rs:1: cli imports truth",
        "unused: eye::pose imports cli",
    ];
    assert_eq!((complaints, seen), (expected.map(str::to_owned).to_vec(), 7));
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

//! `fbptr grade --calls`: a program of the course's framework whose own functions are graded.
//!
//! Students of the first course write `PutPixel`, `DrawLine` and `DrawTriangle`, and call them from a
//! function `MyGlDraw` with figures of their own choice. So that the figures of a sheet are drawn, a
//! copy of the folder is compiled in which `MyGlDraw` reads standard input in place of its own body,
//! and calls the same functions. All else is the program's: its memory, window and main.
//!
//! In: a folder of sources. Out: a copy of it with that change, and for each figure the function that
//! is called. Right is: the copy draws what the student's functions draw, and nothing else does.

mod driver;
mod source;

use driver::{Call, FIGURES, calls};
use source::Declared;
use std::ffi::OsStr;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// The function that the framework calls.
const ENTRY: &str = "MyGlDraw";
/// Folders of folders, files and bytes that are copied at most.
const DEPTH: u32 = 8;
const FILES: usize = 20_000;
const BYTES: u64 = 512 << 20;

/// A copy whose functions are called.
#[derive(Debug)]
pub struct Called {
    calls: Vec<Call>,
}

impl Called {
    /// Returns a line for each figure: the function that is called, or that there is none.
    pub fn text(&self) -> String {
        let line = |verb: &str| match self.calls.iter().find(|call| call.verb == verb) {
            Some(call) => format!("  {verb:<5} {}\n", call.shown),
            None => format!("  {verb:<5} no function is found\n"),
        };
        FIGURES.iter().map(|figure| line(figure.verb)).collect()
    }

    /// Returns the verbs of a stream for which there is no function.
    pub fn missing(&self, stream: &str) -> Vec<&'static str> {
        let is_used = |verb: &str| stream.lines().any(|line| line.split_whitespace().next() == Some(verb));
        let has = |verb: &str| self.calls.iter().any(|call| call.verb == verb);
        FIGURES.iter().map(|figure| figure.verb).filter(|verb| is_used(verb) && !has(verb)).collect()
    }

    /// Returns the first function that a stream needs and that takes no colour.
    pub fn colorless(&self, stream: &str) -> Option<&str> {
        let mut verbs = stream.lines().filter_map(|line| line.split_whitespace().next());
        verbs.find_map(|verb| {
            let call = self.calls.iter().find(|call| call.verb == verb && !call.takes_color)?;
            Some(call.shown.as_str())
        })
    }
}

/// Returns a stream in white alone; `None` if a figure has several colours.
pub fn in_white(stream: &str) -> Option<String> {
    let mut text = String::new();
    for line in stream.lines() {
        let mut words: Vec<&str> = line.split_whitespace().collect();
        if let Some(figure) = FIGURES.iter().find(|figure| words.first() == Some(&figure.verb)) {
            let first = 1 + 2 * figure.points;
            if words.len() > first + 1 {
                return None;
            }
            words.truncate(first);
            words.push("ffffff");
        }
        text += &words.join(" ");
        text.push('\n');
    }
    Some(text)
}

/// Copies a folder to `copy` and makes its functions be called.
///
/// # Errors
/// Why the program cannot be graded so.
pub fn prepare(folder: &Path, copy: &Path) -> Result<Called, String> {
    let mut sources = Vec::new();
    let mut left = (FILES, BYTES);
    copy_folder(folder, copy, DEPTH, &mut left, &mut sources)?;
    let mut declared = Declared::default();
    let mut entry = None;
    for path in &sources {
        let bytes = fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let own = Declared::read(&bytes);
        let body = own.functions.iter().find(|f| f.name == ENTRY).and_then(|f| f.body);
        // A `main` beside it tells the program from tests of it.
        if let Some(body) = body
            && (entry.is_none() || own.functions.iter().any(|f| f.name == "main"))
        {
            entry = Some((path.clone(), bytes, body));
        }
        declared.functions.extend(own.functions);
        declared.records.extend(own.records);
        declared.aliases.extend(own.aliases);
    }
    let Some((path, bytes, body)) = entry else {
        return Err(format!("{}: --calls: no function {ENTRY} is defined", folder.display()));
    };
    let is_cpp = path.extension() != Some(OsStr::new("c"));
    let calls = calls(&declared, is_cpp);
    if calls.is_empty() {
        return Err(format!("{}: --calls: no function that draws is understood", folder.display()));
    }
    let mut changed = bytes[..body].to_vec();
    changed.extend(b" { void fbptr_figures(void); fbptr_figures(); return; } ");
    changed.extend(&bytes[body..]);
    changed.extend(reader(&calls).as_bytes());
    fs::write(&path, changed).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(Called { calls })
}

/// Returns the code that reads figures and calls functions.
fn reader(calls: &[Call]) -> String {
    let mut text = include_str!("reader.c").to_owned();
    for call in calls {
        let _ = write!(
            text,
            "static void fbptr_{}(const double *fbptr_p, const unsigned *fbptr_c) {{\n    (void)fbptr_c;\n{}}}\n",
            call.verb, call.code
        );
    }
    text += "void fbptr_figures(void) {\n    static int is_done = 0;\n    char line[1024];\n    \
             if (is_done) return;\n    is_done = 1;\n    \
             while (fgets(line, sizeof line, stdin)) {\n        double p[6] = { 0 };\n        \
             unsigned c[3] = { 0 };\n        char word[16];\n        int used = 0;\n        \
             if (sscanf(line, \"%15s%n\", word, &used) != 1) continue;\n";
    for figure in FIGURES.iter().filter(|figure| calls.iter().any(|call| call.verb == figure.verb)) {
        let (verb, points) = (figure.verb, figure.points);
        let _ = write!(
            text,
            "        if (strcmp(word, \"{verb}\") == 0) {{\n            const char *at = line + used;\n            \
             int i, n = 0;\n            \
             for (i = 0; i < {}; i++, at += n) if (sscanf(at, \"%lf%n\", &p[i], &n) != 1) break;\n            \
             for (i = 0; i < {points}; i++, at += n) {{\n                \
             if (sscanf(at, \"%x%n\", &c[i], &n) != 1) {{ c[i] = c[0]; n = 0; }}\n            }}\n            \
             fbptr_{verb}(p, c);\n        }}\n",
            2 * points
        );
    }
    text + "    }\n}\n"
}

/// Copies a folder's files but compiled ones, and collects its sources.
fn copy_folder(
    from: &Path,
    to: &Path,
    depth: u32,
    left: &mut (usize, u64),
    sources: &mut Vec<PathBuf>,
) -> Result<(), String> {
    let failed = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    fs::create_dir_all(to).map_err(|e| failed(to, e))?;
    let entries = fs::read_dir(from).map_err(|e| failed(from, e))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let Some(name) = path.file_name() else { continue };
        let Ok(meta) = path.symlink_metadata() else { continue };
        let target = to.join(name);
        if name.as_encoded_bytes().starts_with(b".") {
            continue;
        }
        if meta.is_dir() && depth > 0 {
            copy_folder(&path, &target, depth - 1, left, sources)?;
        }
        let ending = path.extension().and_then(OsStr::to_str).unwrap_or("").to_ascii_lowercase();
        // An object that is newer than its source would not be compiled.
        if !meta.is_file() || matches!(ending.as_str(), "o" | "a" | "obj" | "so") || is_program(&path) {
            continue;
        }
        if left.0 == 0 || left.1 < meta.len() {
            return Err(format!("{}: --calls: the folder is too large", from.display()));
        }
        *left = (left.0 - 1, left.1 - meta.len());
        fs::write(&target, fs::read(&path).map_err(|e| failed(&path, e))?).map_err(|e| failed(&target, e))?;
        let is_small = meta.len() < 1 << 20;
        if is_small && matches!(ending.as_str(), "c" | "cpp" | "cc" | "cxx" | "h" | "hpp") && is_own(&target)
        {
            sources.push(target);
        }
    }
    Ok(())
}

/// Returns whether a file is a program that was compiled.
fn is_program(path: &Path) -> bool {
    use std::io::Read;
    let mut first = [0; 4];
    fs::File::open(path).and_then(|mut file| file.read_exact(&mut first)).is_ok() && first == *b"\x7fELF"
}

/// Returns whether a source is not of a library that travels with the program.
fn is_own(path: &Path) -> bool {
    let text = path.to_string_lossy().to_ascii_lowercase();
    !["/glm", "/eigen"].iter().any(|part| text.contains(part))
}

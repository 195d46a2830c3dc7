//! `fbptr grade --calls`: a program of the course's framework whose own functions are graded.
//!
//! Students of the first course write `PutPixel`, `DrawLine` and `DrawTriangle`, and call them from a
//! function `MyGlDraw` with figures of their own choice. So that the figures of a sheet are drawn, a
//! copy of the folder is compiled in which `MyGlDraw` reads the figures from a file in place of its own
//! body, and calls the same functions, each time that it is called. All else is the program's: its
//! memory, window and main.
//!
//! In: a folder of sources. Out: a copy of it with that change, and for each figure the function that
//! is called. Right is: the copy draws what the student's functions draw, and nothing else does; a
//! program that never calls `MyGlDraw`, or does not return from it, is found by marks that it leaves.

mod driver;
mod source;

use crate::memory::parse_color;
use driver::{Call, FIGURES, calls};
use source::Declared;
use std::ffi::OsStr;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

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

    /// Returns the verbs of a plain stream for which there is no function, each once.
    pub fn missing<'s>(&self, stream: &'s str) -> Vec<&'s str> {
        let mut missing: Vec<&str> = Vec::new();
        for verb in stream.lines().filter_map(|line| line.split(' ').next()) {
            if !self.calls.iter().any(|call| call.verb == verb) && !missing.contains(&verb) {
                missing.push(verb);
            }
        }
        missing
    }

    /// Lets a command read the figures of a file.
    pub fn read_by(command: &mut Command, figures: &Path) {
        command.env("FBPTR_FIGURES", figures).env("FBPTR_MARKS", marks(figures));
    }

    /// Returns why the figures of a file were not drawn, if they were not.
    pub fn fault(figures: &Path) -> Option<String> {
        let marks = fs::read_to_string(marks(figures)).unwrap_or_default();
        match (marks.contains("called"), marks.contains("returned")) {
            (false, _) => Some(format!("{ENTRY} was not called, so no figure of the sheet was drawn")),
            (true, false) => {
                Some(format!("{ENTRY} did not return: a function that draws has no end, or ends the program"))
            }
            (true, true) => None,
        }
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

/// Returns the file in which a program notes that it has read the figures of a file.
fn marks(figures: &Path) -> PathBuf {
    figures.with_extension("marks")
}

/// Returns the figures of a stream as the copy reads them: verbs in capitals, colours as six hex
/// digits; what sets the frame or ends it is left out.
pub fn plain(stream: &str) -> String {
    let mut text = String::new();
    for line in stream.lines() {
        let mut words = line.split_whitespace();
        let verb = words.next().unwrap_or("").to_ascii_uppercase();
        if verb.is_empty() || verb.starts_with('#') || ["SIZE", "AUTO", "CLEAR", "PRESENT"].contains(&&*verb)
        {
            continue;
        }
        let points = FIGURES.iter().find(|figure| figure.verb == verb).map_or(0, |figure| figure.points);
        text += &verb;
        for (at, word) in words.enumerate() {
            let color = if at < 2 * points { None } else { parse_color(word.as_bytes()) };
            let _ = match color {
                Some([r, g, b, _]) => write!(text, " {r:02x}{g:02x}{b:02x}"),
                None => write!(text, " {word}"),
            };
        }
        text.push('\n');
    }
    text
}

/// Returns a plain stream in white alone; `None` if a figure has several colours.
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
/// The reason for which the program cannot be graded so.
pub fn prepare(folder: &Path, copy: &Path) -> Result<Called, String> {
    let mut sources = Vec::new();
    let mut left = (FILES, BYTES);
    copy_folder(folder, copy, DEPTH, &mut left, &mut sources)?;
    sources.retain(|path| is_own(path.strip_prefix(copy).unwrap_or(path)));
    let mut declared = Declared::default();
    let mut entries = Vec::new();
    for path in &sources {
        let bytes = fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let own = Declared::read(&bytes);
        let bodies = own.functions.iter().filter(|f| f.name == ENTRY).filter_map(|f| f.body);
        let bodies: Vec<usize> = bodies.collect();
        if !bodies.is_empty() {
            // A `main` beside it tells the program from tests of it.
            let is_main = own.functions.iter().any(|f| f.name == "main");
            entries.push(Entry { path: path.clone(), bytes, bodies, is_main });
        }
        declared.functions.extend(own.functions);
        declared.records.extend(own.records);
        declared.aliases.extend(own.aliases);
    }
    // A function that is only declared is not written yet.
    let written: Vec<String> =
        declared.functions.iter().filter(|f| f.body.is_some()).map(|f| f.name.clone()).collect();
    declared.functions.retain(|f| written.contains(&f.name));
    let Some(first) = entries.iter().find(|entry| entry.is_main).or(entries.first()) else {
        return Err(format!("{}: --calls: no function {ENTRY} is defined", folder.display()));
    };
    let shown = calls(&declared, first.is_cpp());
    if shown.is_empty() {
        return Err(format!("{}: --calls: no function that draws is understood", folder.display()));
    }
    // Which of several is compiled is the program's own choice.
    for entry in &entries {
        let changed = entry.changed(&calls(&declared, entry.is_cpp()));
        fs::write(&entry.path, changed).map_err(|e| format!("{}: {e}", entry.path.display()))?;
    }
    Ok(Called { calls: shown })
}

/// A source that defines the function that the framework calls.
struct Entry {
    path: PathBuf,
    bytes: Vec<u8>,
    /// Places behind the opening braces of its definitions.
    bodies: Vec<usize>,
    is_main: bool,
}

impl Entry {
    fn is_cpp(&self) -> bool {
        self.path.extension() != Some(OsStr::new("c"))
    }

    /// Returns the source with the reader in place of each definition's own statements.
    fn changed(&self, calls: &[Call]) -> Vec<u8> {
        let mark = self.bytes.strip_prefix(b"\xef\xbb\xbf").map_or(0, |_| 3);
        let mut changed = self.bytes[..mark].to_vec();
        changed.extend(b"static void fbptr_figures(void);\n");
        let mut from = mark;
        for body in &self.bodies {
            changed.extend(&self.bytes[from..*body]);
            changed.extend(b" { fbptr_figures(); return; } ");
            from = *body;
        }
        changed.extend(&self.bytes[from..]);
        changed.extend(reader(calls).as_bytes());
        changed
    }
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
    text += "static void fbptr_figures(void) {\n    static int fbptr_times = 0;\n    char fbptr_line[1024];\n    \
             const char *fbptr_name = getenv(\"FBPTR_FIGURES\");\n    \
             FILE *fbptr_file = fbptr_name ? fopen(fbptr_name, \"r\") : 0;\n    \
             if (fbptr_file == 0) return;\n    if (fbptr_times == 0) fbptr_mark(\"called\");\n    \
             while (fgets(fbptr_line, sizeof fbptr_line, fbptr_file)) {\n        \
             double fbptr_p[6] = { 0, 0, 0, 0, 0, 0 };\n        unsigned fbptr_c[3] = { 0, 0, 0 };\n        \
             char fbptr_word[16];\n        int fbptr_at = 0, fbptr_i, fbptr_n = 0;\n        \
             if (sscanf(fbptr_line, \"%15s%n\", fbptr_word, &fbptr_at) != 1) continue;\n";
    for call in calls {
        let points = FIGURES.iter().find(|figure| figure.verb == call.verb).map_or(0, |figure| figure.points);
        let _ = write!(
            text,
            "        if (strcmp(fbptr_word, \"{verb}\") == 0) {{\n            \
             for (fbptr_i = 0; fbptr_i < {numbers}; fbptr_i++, fbptr_at += fbptr_n) {{\n                \
             if (sscanf(fbptr_line + fbptr_at, \"%lf%n\", &fbptr_p[fbptr_i], &fbptr_n) != 1) break;\n            }}\n            \
             for (fbptr_i = 0; fbptr_i < {points}; fbptr_i++, fbptr_at += fbptr_n) {{\n                \
             if (sscanf(fbptr_line + fbptr_at, \"%x%n\", &fbptr_c[fbptr_i], &fbptr_n) == 1) continue;\n                \
             fbptr_c[fbptr_i] = fbptr_c[0];\n                fbptr_n = 0;\n            }}\n            \
             fbptr_{verb}(fbptr_p, fbptr_c);\n        }}\n",
            verb = call.verb,
            numbers = 2 * points
        );
    }
    text + "    }\n    fclose(fbptr_file);\n    if (fbptr_times++ == 0) fbptr_mark(\"returned\");\n    \
            (void)fbptr_whole;\n}\n#endif\n"
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
        if is_small && matches!(ending.as_str(), "c" | "cpp" | "cc" | "cxx" | "h" | "hpp") {
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

/// Returns whether a source, by its path in the program's folder, is not of a library that travels with
/// the program.
fn is_own(path: &Path) -> bool {
    let folders = path.parent().into_iter().flat_map(Path::components);
    let mut names = folders.map(|part| part.as_os_str().to_string_lossy().to_ascii_lowercase());
    !names.any(|name| name == "glm" || name.starts_with("glm-") || name.starts_with("eigen"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_read_in_any_notation() {
        let stream = "# two pixels\nSIZE 64 48\n\npx 1 2 red\n PX 3 4 #0f0\nLINE 1 2 3 4 ff ff8000ff\nCIRCLE 1 2 3 red\n";
        let plain = plain(stream);
        assert_eq!(plain, "PX 1 2 ff0000\nPX 3 4 00ff00\nLINE 1 2 3 4 ffffff ff8000\nCIRCLE 1 2 3 ff0000\n");
        let called = Called { calls: Vec::new() };
        assert_eq!(called.missing(&plain), ["PX", "LINE", "CIRCLE"]);
    }

    #[test]
    fn every_definition_is_changed_and_each_once() {
        let folder = std::env::temp_dir().join(format!("fbptr-calls-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        let [from, to] = ["from", "to"].map(|name| folder.join(name));
        fs::create_dir_all(from.join("glm")).unwrap();
        let header = "void MyGlDraw(void);\nvoid PutPixel(int x, int y) { }\nvoid DrawLine(int a, int b, int c, int d);\n\
                      #if 0\nvoid MyGlDraw(void) { }\n#endif\nvoid MyGlDraw(void) { PutPixel(1, 2); }\n";
        fs::write(from.join("glMain.cpp"), header).unwrap();
        fs::write(from.join("old.c"), "\u{feff}void MyGlDraw() { }\n").unwrap();
        fs::write(from.join("glm/mygl.h"), "void MyGlDraw() { }\n").unwrap();
        let called = prepare(&from, &to).unwrap();
        assert!(called.text().contains("LINE  no function is found"), "{}", called.text());
        let count = |name: &str| {
            let text = fs::read_to_string(to.join(name)).unwrap();
            let places = text.matches("{ fbptr_figures(); return; }").count();
            (places, text.matches("static void fbptr_figures(void) {").count())
        };
        assert_eq!((count("glMain.cpp"), count("old.c"), count("glm/mygl.h")), ((2, 1), (1, 1), (0, 0)));
        assert!(fs::read_to_string(to.join("old.c")).unwrap().starts_with("\u{feff}static void"));
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn marks_tell_whether_the_figures_were_drawn() {
        let figures = std::env::temp_dir().join(format!("fbptr-figures-{}", std::process::id()));
        let fault = |text: &str| {
            fs::write(marks(&figures), text).unwrap();
            Called::fault(&figures).unwrap_or_default()
        };
        assert!(fault("").contains("was not called"));
        assert!(fault("called\n").contains("did not return"));
        assert_eq!(fault("called\nreturned\n"), "");
        fs::remove_file(marks(&figures)).unwrap();
    }
}

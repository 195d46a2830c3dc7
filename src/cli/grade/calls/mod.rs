//! `fbptr grade --calls`: a program of the course's framework whose own functions are graded.
//!
//! Students of the first course write `PutPixel`, `DrawLine` and `DrawTriangle`, and call them from a
//! function `MyGlDraw` with figures of their own choice. So that the figures of a sheet are drawn, a
//! copy of the folder is compiled in which `MyGlDraw` reads the figures from a file in place of its own
//! body, and calls the same functions, each time that it is called. All else is the program's: its
//! memory, window and main.
//!
//! In: a folder of sources. Out: a copy of it with that change, and for each figure the function that
//! is called, or why there is none. Right is: the copy draws what the student's functions draw, and
//! nothing else does; a program that never calls `MyGlDraw`, or does not return from it, is found by
//! marks that it leaves.

mod copy;
mod driver;
mod names;
mod source;
mod text;
mod writer;

use super::compiled::{Fault, Refusal, is_error};
use crate::memory::parse_color;
use copy::{copy_folder, is_own};
use driver::{Call, call};
use names::FIGURES;
use source::Declared;
use std::ffi::OsStr;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The function that the framework calls.
const ENTRY: &str = "MyGlDraw";
/// Beginning of the names of the parts that call a function, in the compiler's errors.
const PART: &str = "fbptr_call_";

/// Functions that are called, and figures that have none.
#[derive(Clone, Debug, Default)]
pub struct Called {
    calls: Vec<Call>,
    /// Figures without a function, and why.
    lost: Vec<(&'static str, String)>,
}

impl Called {
    /// Returns a line for each figure: the function that is called, or why there is none.
    pub fn text(&self) -> String {
        let line = |verb: &str| match self.calls.iter().find(|call| call.verb == verb) {
            Some(call) => format!("  {verb:<5} {}\n", call.shown),
            None => format!("  {verb:<5} {}\n", self.why(verb)),
        };
        FIGURES.iter().map(|figure| line(figure.verb)).collect()
    }

    fn why(&self, verb: &str) -> String {
        let lost = self.lost.iter().find(|(other, _)| *other == verb);
        lost.map_or_else(|| format!("no function for {verb} is found"), |(_, why)| why.clone())
    }

    /// Returns why a plain stream has figures that cannot be drawn.
    pub fn missing(&self, stream: &str) -> Option<String> {
        let mut missing: Vec<&str> = Vec::new();
        for verb in stream.lines().filter_map(|line| line.split(' ').next()) {
            if !self.calls.iter().any(|call| call.verb == verb) && !missing.contains(&verb) {
                missing.push(verb);
            }
        }
        let why: Vec<String> = missing.iter().map(|verb| self.why(verb)).collect();
        (!why.is_empty()).then(|| why.join("; "))
    }

    /// Returns the figures that have a function.
    pub fn verbs(&self) -> Vec<&'static str> {
        self.calls.iter().map(|call| call.verb).collect()
    }

    /// Takes a figure's function away; `{}` in the reason stands for it.
    pub fn lose(&mut self, verb: &'static str, why: String) {
        let lost: Vec<Call> = self.calls.extract_if(.., |call| call.verb == verb).collect();
        self.lost.extend(lost.iter().map(|call| (verb, why.replace("{}", &call.shown))));
    }

    /// Returns the figures whose call is wrong by a compiler's messages, and the first error of each.
    pub fn blamed(&self, messages: &str) -> Vec<(&'static str, String)> {
        let first = |call: &Call| {
            let part = format!("{PART}{}:", call.verb);
            let missing = ["(", "'"].map(|end| format!("undefined reference to `{}{end}", call.function));
            let is_own = |line: &&str| {
                is_error(line) && (line.contains(&part) || missing.iter().any(|text| line.contains(text)))
            };
            let line = messages.lines().find(is_own)?;
            let at = ["error: ", "undefined reference"].iter().find_map(|word| line.find(word)).unwrap_or(0);
            Some((call.verb, line[at..].to_owned()))
        };
        self.calls.iter().filter_map(first).collect()
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

    /// Returns a plain stream with rounded coordinates in the figures whose functions take whole
    /// numbers; `None` if nothing changes.
    pub fn in_whole(&self, stream: &str) -> Option<String> {
        let is_whole = |verb: &str| self.calls.iter().any(|call| call.verb == verb && call.takes_whole);
        let whole = with_coordinates(stream, &|verb, value| match is_whole(verb) {
            true => (value + 0.5).floor(),
            false => value,
        });
        (with_coordinates(stream, &|_, value| value) != whole).then_some(whole)
    }
}

/// Returns a plain stream whose filled triangles have their corners at the centres of pixels.
pub fn at_centres(stream: &str) -> String {
    with_coordinates(stream, &|verb, value| if verb == "FILL" { value + 0.5 } else { value })
}

/// Returns a plain stream with changed coordinates.
fn with_coordinates(stream: &str, change: &dyn Fn(&str, f64) -> f64) -> String {
    let mut text = String::new();
    for line in stream.lines() {
        let verb = line.split(' ').next().unwrap_or("");
        let points = FIGURES.iter().find(|figure| figure.verb == verb).map_or(0, |figure| figure.points);
        for (at, word) in line.split(' ').enumerate() {
            let is_place = (1..=2 * points).contains(&at);
            let _ = match word.parse::<f64>().ok().filter(|value| is_place && value.is_finite()) {
                Some(value) => write!(text, " {}", change(verb, value)),
                None => write!(text, "{}{word}", if at == 0 { "" } else { " " }),
            };
        }
        text.push('\n');
    }
    text
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

/// A copy of a program, whose sources are written again with fewer calls if some do not compile.
pub struct Prepared {
    entries: Vec<(Entry, Vec<Call>)>,
    pub called: Called,
}

impl Prepared {
    /// Writes the sources with all calls that are left.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self) -> Result<(), String> {
        let verbs = self.called.verbs();
        self.write_those(&|call| verbs.contains(&call.verb))
    }

    /// Writes the sources with one call, or none.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn only(&self, verb: Option<&str>) -> Result<(), String> {
        self.write_those(&|call| Some(call.verb) == verb)
    }

    fn write_those(&self, is_kept: &dyn Fn(&Call) -> bool) -> Result<(), String> {
        for (entry, calls) in &self.entries {
            let kept: Vec<&Call> = calls.iter().filter(|call| is_kept(call)).collect();
            let write = fs::write(&entry.path, entry.changed(&kept));
            write.map_err(|e| format!("{}: {e}", entry.path.display()))?;
        }
        Ok(())
    }
}

/// Copies a folder to `copy` and makes its functions be called, where the copy is written.
///
/// # Errors
/// The reason why the program cannot be graded so.
pub fn prepare(folder: &Path, copy: &Path) -> Result<Prepared, Refusal> {
    let sources = copy_folder(folder, copy).map_err(Refusal::Use)?;
    let mut files = Vec::new();
    for path in sources.into_iter().filter(|path| is_own(path.strip_prefix(copy).unwrap_or(path))) {
        let bytes = fs::read(&path).map_err(|e| Refusal::Use(format!("{}: {e}", path.display())))?;
        let own = Declared::read(&bytes);
        files.push((path, bytes, own));
    }
    let entries = files.iter().filter_map(|(path, bytes, own)| {
        let bodies = own.functions.iter().filter(|f| f.name == ENTRY).filter_map(|f| f.body);
        let bodies: Vec<usize> = bodies.collect();
        // A `main` beside it tells the program from tests of it.
        let is_main = own.functions.iter().any(|f| f.name == "main");
        (!bodies.is_empty()).then(|| Entry { path: path.clone(), bytes: bytes.clone(), bodies, is_main })
    });
    let mut entries: Vec<Entry> = entries.collect();
    entries.sort_by_key(|entry| !entry.is_main);
    let mut all: Vec<(Entry, Called)> = Vec::new();
    for entry in entries {
        let (declared, mut called) = (seen_by(&entry, &files), Called::default());
        for figure in &FIGURES {
            match call(&declared, figure, entry.is_cpp()) {
                Ok(call) => called.calls.push(call),
                Err(why) => called.lost.push((figure.verb, why)),
            }
        }
        all.push((entry, called));
    }
    // Which of several is compiled is the program's own choice: the first is told.
    let Some(called) = all.first().map(|(_, called)| called.clone()) else {
        if let Some((path, ..)) = files.iter().find(|(_, bytes, _)| has_body(bytes)) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            return Err(Refusal::Use(format!("{name} defines {ENTRY} in a way that is not understood")));
        }
        let text = format!("no function {ENTRY} is defined, which the framework calls");
        return Err(Refusal::Fault(Fault { text, errors: Vec::new() }));
    };
    let entries = all.into_iter().map(|(entry, called)| (entry, called.calls)).collect();
    Ok(Prepared { entries, called })
}

/// Returns whether the entry has a body somewhere in a source, whatever stands around it.
fn has_body(source: &[u8]) -> bool {
    let tokens = text::tokens(source);
    (0..tokens.len()).any(|at| {
        let mut rest = tokens[at..].iter();
        rest.next().is_some_and(|token| token.text == ENTRY)
            && rest.next().is_some_and(|token| token.text == "(")
            && rest.by_ref().any(|token| token.text == ")")
            && rest.find(|token| !token.is_word()).is_some_and(|token| token.text == "{")
    })
}

/// Returns what all sources declare, as a file sees it.
fn seen_by(entry: &Entry, files: &[(PathBuf, Vec<u8>, Declared)]) -> Declared {
    let mut all = Declared::default();
    for (path, _, own) in files {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        let is_included = entry.bytes.windows(name.len().max(1)).any(|part| part == name);
        let is_seen = *path == entry.path || is_header(path) || is_included;
        let functions = own.functions.iter().cloned();
        all.functions.extend(functions.map(|f| source::Function { is_static: f.is_static && !is_seen, ..f }));
        all.records.extend(own.records.iter().cloned());
        all.aliases.extend(own.aliases.iter().cloned());
        all.is_scaled |= own.is_scaled;
    }
    // A function that is only declared is not written yet.
    let written: Vec<String> =
        all.functions.iter().filter(|f| f.body.is_some()).map(|f| f.name.clone()).collect();
    all.functions.retain(|f| written.contains(&f.name));
    all
}

fn is_header(path: &Path) -> bool {
    matches!(path.extension().and_then(OsStr::to_str), Some("h" | "hpp" | "H"))
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
    fn changed(&self, calls: &[&Call]) -> Vec<u8> {
        let mark = self.bytes.strip_prefix(b"\xef\xbb\xbf").map_or(0, |_| 3);
        let mut changed = self.bytes[..mark].to_vec();
        // The program's lines keep their numbers.
        changed.extend(b"static void fbptr_figures(void);\n#line 1\n");
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
fn reader(calls: &[&Call]) -> String {
    let mut text = format!("\n#line 1 \"fbptr_reader\"\n{}", include_str!("reader.c"));
    for call in calls {
        let _ = write!(
            text,
            "#line 1 \"{PART}{verb}\"\nstatic void fbptr_{verb}(const double *fbptr_p, const unsigned *fbptr_c) {{\n    \
             (void)fbptr_c;\n{}}}\n",
            call.code,
            verb = call.verb
        );
    }
    text += "#line 1 \"fbptr_reader\"\nstatic void fbptr_figures(void) {\n    static int fbptr_times = 0;\n    char fbptr_line[1024];\n    \
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_read_in_any_notation() {
        let stream = "# two pixels\nSIZE 64 48\n\npx 1 2 red\n PX 3 4 #0f0\nLINE 1 2 3 4 ff ff8000ff\nCIRCLE 1 2 3 red\n";
        let plain = plain(stream);
        assert_eq!(plain, "PX 1 2 ff0000\nPX 3 4 00ff00\nLINE 1 2 3 4 ffffff ff8000\nCIRCLE 1 2 3 ff0000\n");
        let lost = vec![("LINE", "a reason".to_owned())];
        let missing = Called { calls: Vec::new(), lost }.missing(&plain).unwrap();
        assert_eq!(missing, "no function for PX is found; a reason; no function for CIRCLE is found");
    }

    #[test]
    fn a_body_is_told_from_a_declaration() {
        let is_body = |source: &str| has_body(source.as_bytes());
        assert!(is_body(
            "#ifdef A\nint f() {\n#else\nint g() {\n#endif\n}\nvoid MyGlDraw(void) noexcept\n{ }"
        ));
        assert!(!is_body("void MyGlDraw(void); int main() { MyGlDraw(); }"));
        assert!(!is_body("// void MyGlDraw() { }\nif (MyGlDraw) { }"));
    }

    #[test]
    fn corners_are_rounded_where_a_function_takes_whole_numbers() {
        let declared = Declared::read(
            b"void FillTriangle(int x0, int y0, int x1, int y1, int x2, int y2) {}\
                                        void PutPixel(float x, float y) {}",
        );
        let calls = FIGURES.iter().filter_map(|figure| call(&declared, figure, true).ok()).collect();
        let called = Called { calls, lost: Vec::new() };
        let stream = "PX 0.25 1\nFILL -0.5 1.25 2.5 3 4 5.75 ff0000\n";
        let whole = called.in_whole(stream).unwrap();
        assert_eq!(whole, "PX 0.25 1\nFILL 0 1 3 3 4 6 ff0000\n");
        assert_eq!(at_centres(&whole), "PX 0.25 1\nFILL 0.5 1.5 3.5 3.5 4.5 6.5 ff0000\n");
        assert_eq!(called.in_whole(&whole), None);
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
        let prepared = prepare(&from, &to).unwrap_or_else(|e| panic!("{e:?}"));
        prepared.write().unwrap();
        let called = &prepared.called;
        assert!(called.text().contains("LINE  no function for LINE is found"), "{}", called.text());
        let count = |name: &str| {
            let text = fs::read_to_string(to.join(name)).unwrap();
            let places = text.matches("{ fbptr_figures(); return; }").count();
            (places, text.matches("static void fbptr_figures(void) {").count())
        };
        assert_eq!((count("glMain.cpp"), count("old.c"), count("glm/mygl.h")), ((1, 1), (1, 1), (0, 0)));
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

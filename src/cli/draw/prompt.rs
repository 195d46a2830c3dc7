//! The prompt: a line editor with history, completion of verbs, keywords, names and files, and the
//! rest of the command's form as a hint.

use super::line::OWN_WORDS;
use super::terminal::Terminal;
use crate::command::{Form, ParameterKind, Verb};
use rustyline::completion::Completer;
use rustyline::error::ReadlineError;
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::history::MemHistory;
use rustyline::validate::Validator;
use rustyline::{CompletionType, Config, Context, Editor, Helper};
use std::borrow::Cow;
use std::collections::VecDeque;
use std::sync::Arc;

/// The line editor.
pub(super) struct Prompt {
    editor: Editor<Assistant, MemHistory>,
    terminal: Arc<Terminal>,
    /// Lines that were pasted behind the one that was returned.
    pasted: VecDeque<String>,
}

/// A line that was read, or the end.
pub(super) enum Typed {
    /// A line without its end.
    Line(String),
    /// Ctrl-C: the line is dropped.
    Dropped,
    /// Ctrl-D, or the end of a file.
    End,
}

impl Prompt {
    /// Creates the editor.
    ///
    /// # Errors
    /// A message if the terminal cannot be set up.
    pub fn new(terminal: Arc<Terminal>) -> Result<Prompt, String> {
        let config = Config::builder().completion_type(CompletionType::List).auto_add_history(true).build();
        let mut editor = Editor::with_history(config, MemHistory::new()).map_err(|e| e.to_string())?;
        editor.set_helper(Some(Assistant::default()));
        Ok(Prompt { editor, terminal, pasted: VecDeque::new() })
    }

    /// Sets the names that can be completed.
    pub fn set_names(&mut self, names: Vec<String>) {
        if let Some(assistant) = self.editor.helper_mut() {
            assistant.names = names;
        }
    }

    /// Reads a line. Of several that are pasted at once each call returns one.
    ///
    /// # Errors
    /// A message if standard input cannot be read.
    pub fn read(&mut self, prompt: &str) -> Result<Typed, String> {
        if let Some(line) = self.pasted.pop_front() {
            return Ok(Typed::Line(line));
        }
        self.ask(prompt)
    }

    /// Reads a line that is typed after this moment: pasted lines stay for later.
    ///
    /// # Errors
    /// A message if standard input cannot be read.
    pub fn ask(&mut self, prompt: &str) -> Result<Typed, String> {
        match self.terminal.while_reading(|| self.editor.readline(prompt)) {
            Ok(text) => {
                // A terminal that marks what is pasted gives all of its lines as one.
                let mut lines = text.lines().map(str::to_owned);
                let first = lines.next().unwrap_or_default();
                self.pasted.extend(lines);
                Ok(Typed::Line(first))
            }
            Err(ReadlineError::Interrupted) => Ok(Typed::Dropped),
            Err(ReadlineError::Eof) => Ok(Typed::End),
            Err(e) => Err(format!("standard input: {e}")),
        }
    }
}

/// Completions and hints.
#[derive(Default)]
struct Assistant {
    names: Vec<String>,
}

impl Helper for Assistant {}
impl Validator for Assistant {}

impl Highlighter for Assistant {
    fn highlight_hint<'h>(&self, hint: &'h str) -> Cow<'h, str> {
        Cow::Owned(format!("\x1b[2m{hint}\x1b[0m"))
    }
}

impl Hinter for Assistant {
    type Hint = String;

    fn hint(&self, line: &str, pos: usize, _: &Context<'_>) -> Option<String> {
        if pos < line.len() { None } else { hint(line) }
    }
}

impl Completer for Assistant {
    type Candidate = String;

    fn complete(&self, line: &str, pos: usize, _: &Context<'_>) -> rustyline::Result<(usize, Vec<String>)> {
        Ok(complete(&line[..pos], &self.names))
    }
}

/// Returns the rest of the form of a command of which a part is typed.
fn hint(line: &str) -> Option<String> {
    let mut words = line.split_whitespace();
    let verb = Verb::find(words.next()?.as_bytes())?;
    let typed: Vec<&str> = words.collect();
    let rest = verb.forms.iter().find_map(|form| rest_of(form, &typed))?;
    let gap = if line.ends_with(char::is_whitespace) { "" } else { " " };
    (!rest.is_empty()).then(|| format!("{gap}{rest}"))
}

/// Returns the words of a form that follow those that are typed; `None` if they do not fit it.
fn rest_of(form: &Form, typed: &[&str]) -> Option<String> {
    let mut words = form.syntax.split(' ').skip(1);
    for typed in typed {
        let word = words.next()?;
        let is_keyword = word.bytes().all(|b| b.is_ascii_uppercase());
        if is_keyword && !word.eq_ignore_ascii_case(typed) {
            return None;
        }
    }
    Some(words.collect::<Vec<_>>().join(" "))
}

/// Returns where the last word of a line begins, and the words that may stand there.
fn complete(line: &str, names: &[String]) -> (usize, Vec<String>) {
    if let Some(at) = line.find("< ") {
        let begun = &line[at + 2..];
        return (at + 2, files(begun));
    }
    let start = line.rfind(char::is_whitespace).map_or(0, |at| at + 1);
    let begun = &line[start..];
    let candidates: Vec<String> = match line[..start].split_whitespace().next() {
        None => {
            let own = OWN_WORDS.iter().map(|(form, _)| form.split(' ').next().unwrap_or(form).to_owned());
            Verb::all().iter().map(|verb| verb.name.to_owned()).chain(own).collect()
        }
        Some(word) if word.eq_ignore_ascii_case("save") || word.eq_ignore_ascii_case("snap") => {
            return (start, files(begun));
        }
        Some(word) if word.eq_ignore_ascii_case("help") => {
            let topics = ["pixels", "memory", "2-D", "3-D", "control", "colour", "all"];
            let verbs = Verb::all().iter().map(|verb| verb.name);
            verbs.chain(topics).map(str::to_owned).collect()
        }
        Some(word) => Verb::find(word.as_bytes()).map_or_else(Vec::new, |verb| words_of(verb, names)),
    };
    let fits = |word: &String| word.get(..begun.len()).is_some_and(|s| s.eq_ignore_ascii_case(begun));
    let mut fitting: Vec<String> = candidates.into_iter().filter(fits).collect();
    fitting.sort_unstable();
    fitting.dedup();
    (start, fitting)
}

/// Returns the keywords of a verb, and the names if it takes any.
fn words_of(verb: &Verb, names: &[String]) -> Vec<String> {
    let mut words = Vec::new();
    for parameter in verb.parameters {
        match parameter.kind {
            ParameterKind::Keyword(keywords) => words.extend(keywords.iter().map(|k| (*k).to_owned())),
            ParameterKind::Flag(flag) => words.push(flag.to_owned()),
            ParameterKind::Name => words.extend(names.iter().cloned()),
            _ => {}
        }
    }
    let keywords = verb.forms.iter().flat_map(|form| form.syntax.split(' ').skip(1));
    words.extend(keywords.filter(|w| w.bytes().all(|b| b.is_ascii_uppercase())).map(str::to_owned));
    words
}

/// Returns the files and folders whose paths begin with `begun`.
fn files(begun: &str) -> Vec<String> {
    let (folder, prefix) = begun.rsplit_once('/').map_or(("", begun), |(folder, name)| (folder, name));
    let place = match folder {
        "" if begun.starts_with('/') => "/",
        "" => ".",
        folder => folder,
    };
    let Ok(entries) = std::fs::read_dir(place) else { return Vec::new() };
    let mut found: Vec<String> = entries
        .flatten()
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let is_meant = name.starts_with(prefix) && (prefix.starts_with('.') || !name.starts_with('.'));
            let end = if entry.path().is_dir() { "/" } else { "" };
            is_meant.then(|| format!("{}{name}{end}", &begun[..begun.len() - prefix.len()]))
        })
        .collect();
    found.sort_unstable();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hints_are_the_rest_of_the_form() {
        assert_eq!(hint("CIRCLE").as_deref(), Some(" cx cy r c"));
        assert_eq!(hint("LINE 0 0 ").as_deref(), Some("x1 y1 c0 [c1]"));
        assert_eq!(hint("line 0 0 9 9").as_deref(), Some(" c0 [c1]"));
        assert_eq!(hint("MESH pot SPHERE").as_deref(), Some(" [r]"));
        assert_eq!(hint("MESH pot NOTHING "), None);
        assert_eq!(hint("LINE 0 0 9 9 red gold"), None);
        assert_eq!(hint("NOPE "), None);
        assert_eq!(hint(""), None);
    }

    #[test]
    fn words_are_completed_by_their_place() {
        let names = ["pot".to_owned(), "stone".to_owned()];
        assert_eq!(complete("fillc", &names), (0, vec!["FILLCIRCLE".to_owned()]));
        assert_eq!(complete("und", &names), (0, vec!["undo".to_owned()]));
        assert_eq!(complete("DRAW p", &names), (5, vec!["pot".to_owned()]));
        assert_eq!(complete("SHADE ph", &names), (6, vec!["phong".to_owned()]));
        assert_eq!(complete("MESH pot TEA", &names), (9, vec!["TEAPOT".to_owned()]));
        assert_eq!(complete("help FILLP", &names), (5, vec!["FILLPOLY".to_owned()]));
        assert_eq!(complete("NOPE p", &names), (5, Vec::new()));
    }

    #[test]
    fn files_are_completed() {
        let folder = std::env::temp_dir().join(format!("fbptr-prompt-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("inner")).unwrap();
        std::fs::write(folder.join("stone.png"), b"").unwrap();
        let begun = format!("{}/", folder.display());
        assert_eq!(complete(&format!("TEX t < {begun}st"), &[]), (8, vec![format!("{begun}stone.png")]));
        assert_eq!(complete(&format!("save {begun}in"), &[]), (5, vec![format!("{begun}inner/")]));
        std::fs::remove_dir_all(folder).unwrap();
    }
}

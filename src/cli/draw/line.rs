//! A typed line: a command of the language, or a word to the prompt itself.
//!
//! The prompt's own words (`undo`, `save FILE`, ...) are no verbs of the language, which a test
//! holds. A command may end in `< FILE`: the file's bytes are its payload, and nobody counts them.

use crate::command::{Encoding, Payload, Verb};

/// Words to the prompt itself: what is typed, and what it does.
pub(super) const OWN_WORDS: [(&str, &str); 8] = [
    ("help [WORD]", "lists the commands, or explains one or a topic (3-D, colour)"),
    ("undo [N]", "takes back the last command, or the last N"),
    ("redo [N]", "does again what was taken back"),
    ("step [N]", "draws the last command again by pixels, with their numbers"),
    ("list", "shows the commands so far"),
    ("save FILE", "writes them as a stream, which `fbptr play FILE` draws again"),
    ("snap FILE", "writes the picture: .png, .ppm or .raw"),
    ("quit", "ends; so does Ctrl-D"),
];

/// Meaning of a typed line.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Typed<'a> {
    /// Nothing, or a comment.
    Nothing,
    /// `help`, of one verb or of all.
    Help(Option<&'a str>),
    /// `undo`, of so many commands.
    Undo(usize),
    /// `redo`, of so many commands.
    Redo(usize),
    /// `step`, by so many pixels.
    Step(usize),
    /// `list`.
    List,
    /// `save FILE`.
    Save(&'a str),
    /// `snap FILE`.
    Snap(&'a str),
    /// `quit`.
    Quit,
    /// A command of the language.
    Command(CommandLine<'a>),
}

/// Command of the language as it was typed.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct CommandLine<'a> {
    /// Words, without `< FILE`.
    pub words: &'a str,
    /// Payload of the command.
    pub payload: TypedPayload<'a>,
}

/// Source of a typed command's payload.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum TypedPayload<'a> {
    /// There is none.
    None,
    /// The bytes of a file.
    File(&'a str),
    /// So many bytes, which are typed on the next lines.
    Typed(usize),
}

/// Returns the meaning of a line.
///
/// # Errors
/// A message if a word to the prompt lacks its argument or has one too many, or if the line is a
/// command that cannot be typed.
pub(super) fn parse(line: &str) -> Result<Typed<'_>, String> {
    let line = line.trim();
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    let alone = |typed| match rest {
        "" => Ok(typed),
        _ => Err(format!("{word} takes nothing more, not {rest:?}")),
    };
    let file = || match rest {
        "" => Err(format!("{word} what? A file's name is expected")),
        _ => Ok(rest),
    };
    match word.to_ascii_lowercase().as_str() {
        "" => Ok(Typed::Nothing),
        comment if comment.starts_with('#') && !is_color(comment) => Ok(Typed::Nothing),
        "help" if rest.is_empty() => Ok(Typed::Help(None)),
        "help" => Ok(Typed::Help(Some(rest))),
        "undo" => Ok(Typed::Undo(count(word, rest)?)),
        "redo" => Ok(Typed::Redo(count(word, rest)?)),
        "step" => Ok(Typed::Step(count(word, rest)?)),
        "list" => alone(Typed::List),
        "save" => file().map(Typed::Save),
        // The verb SNAP asks for a folder of the server's, which the prompt does not have.
        "snap" if rest != ":" => file().map(Typed::Snap),
        "quit" | "exit" => alone(Typed::Quit),
        _ => command(line, word).map(Typed::Command),
    }
}

/// Returns whether a word that begins with `#` is a colour.
fn is_color(word: &str) -> bool {
    matches!(word.len(), 4 | 7 | 9) && word[1..].bytes().all(|b| b.is_ascii_hexdigit())
}

/// Parses the count of `undo` and `redo`.
fn count(word: &str, text: &str) -> Result<usize, String> {
    match text {
        "" => Ok(1),
        _ => text.parse().map_err(|_| format!("{word} how many? A whole number is expected, not {text:?}")),
    }
}

/// Parses a command of the language, whose first word is `word`.
fn command<'a>(line: &'a str, word: &str) -> Result<CommandLine<'a>, String> {
    let mut verbs = Verb::all().iter();
    if let Some(binary) = verbs.find(|v| v.encoding == Encoding::Binary && starts_with(word, v.name)) {
        return Err(format!("{} is followed by bytes, which cannot be typed here", binary.name));
    }
    let takes_payload = Verb::find(word.as_bytes()).is_none_or(|verb| verb.payload != Payload::Never);
    if !takes_payload {
        return Ok(CommandLine { words: line, payload: TypedPayload::None });
    }
    if let Some((words, file)) = line.rsplit_once(" < ") {
        return Ok(CommandLine { words: words.trim_end(), payload: TypedPayload::File(file.trim()) });
    }
    let last = line.rsplit(char::is_whitespace).next().unwrap_or_default();
    let announced = last.strip_prefix(':').and_then(|digits| digits.parse().ok());
    let payload = announced.map_or(TypedPayload::None, TypedPayload::Typed);
    Ok(CommandLine { words: line, payload })
}

/// Returns whether a word begins with a verb's name, in any case of letters.
fn starts_with(word: &str, name: &str) -> bool {
    word.get(..name.len()).is_some_and(|start| start.eq_ignore_ascii_case(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command<'a>(words: &'a str, payload: TypedPayload<'a>) -> Result<Typed<'a>, String> {
        Ok(Typed::Command(CommandLine { words, payload }))
    }

    #[test]
    fn the_prompts_own_words_are_no_verbs() {
        let common = ["HELP", "SNAP", "QUIT"];
        for (form, _) in OWN_WORDS {
            let word = form.split(' ').next().unwrap().to_ascii_uppercase();
            assert!(common.contains(&word.as_str()) || Verb::index_of(&word).is_none(), "{word}");
        }
    }

    #[test]
    fn words_to_the_prompt_are_told_from_commands() {
        assert_eq!(parse("  "), Ok(Typed::Nothing));
        assert_eq!(parse("# a note"), Ok(Typed::Nothing));
        assert_eq!(parse("UNDO"), Ok(Typed::Undo(1)));
        assert_eq!(parse("undo 3"), Ok(Typed::Undo(3)));
        assert_eq!(parse("redo 2"), Ok(Typed::Redo(2)));
        assert_eq!(parse("step"), Ok(Typed::Step(1)));
        assert_eq!(parse("help line"), Ok(Typed::Help(Some("line"))));
        assert_eq!(parse("save my picture.fbs"), Ok(Typed::Save("my picture.fbs")));
        assert_eq!(parse("snap a.png"), Ok(Typed::Snap("a.png")));
        assert_eq!(parse("Quit"), Ok(Typed::Quit));
        assert_eq!(parse("LINE 0 0 9 9 red"), command("LINE 0 0 9 9 red", TypedPayload::None));
        for wrong in ["undo x", "undo -1", "save", "snap", "list all", "quit now"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn payloads_come_from_files_or_the_next_lines() {
        assert_eq!(parse("TEX t < my stone.png"), command("TEX t", TypedPayload::File("my stone.png")));
        assert_eq!(parse("text 1 2 red :5"), command("text 1 2 red :5", TypedPayload::Typed(5)));
        // Whatever is announced to an unknown verb is skipped by the decoder: it has to be there.
        assert_eq!(parse("NOPE :5"), command("NOPE :5", TypedPayload::Typed(5)));
        assert_eq!(parse("LINE 0 < 3"), command("LINE 0 < 3", TypedPayload::None));
        assert_eq!(parse("TEX t < "), command("TEX t <", TypedPayload::None));
        assert!(parse("PBxxyyrgba").is_err() && parse("pxmulti").is_err());
    }
}

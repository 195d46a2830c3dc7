//! Invalid arguments: the parser's message in the program's style, and the command that was
//! probably meant.

use super::{Status, say_as_program};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::path::Path;

/// Reports invalid arguments, or prints the requested help or version. Returns the exit status.
pub(super) fn ended(error: &clap::Error) -> Status {
    if !error.use_stderr() {
        // Standard output may be closed.
        let _ = error.print();
        return Status::Success;
    }
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        let _ = error.print();
        return Status::BadArguments;
    }
    let subcommand = match (error.kind(), error.get(ContextKind::InvalidSubcommand)) {
        (ErrorKind::InvalidSubcommand, Some(ContextValue::String(word))) => Some(word.as_str()),
        _ => None,
    };
    match subcommand.and_then(|word| file_hint(word, Path::new(word).is_file())) {
        Some(hint) => say_as_program(hint),
        None => {
            let text = error.render().to_string();
            say_as_program(text.strip_prefix("error: ").unwrap_or(&text).trim_end());
        }
    }
    Status::BadArguments
}

/// Returns a hint if a file name was given in place of a subcommand; `None` for other words.
fn file_hint(word: &str, is_there: bool) -> Option<String> {
    let ending = Path::new(word).extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let command = match ending.as_deref() {
        Some("obj" | "x3d" | "x3dz" | "json") => {
            format!(
                "`fbptr view {word}` shows it, `fbptr render {word} -o picture.png` makes a picture of it"
            )
        }
        Some("fbs") => format!("`fbptr play {word}` plays it"),
        _ if is_there => {
            format!("`fbptr play {word}` plays a stream of commands, `fbptr view FILE` shows a scene")
        }
        _ => return None,
    };
    Some(format!("{word} is no command; {command}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_in_place_of_a_command_have_their_own() {
        assert!(
            file_hint("model.obj", false)
                .is_some_and(|hint| hint.contains("`fbptr view model.obj` shows it"))
        );
        assert!(
            file_hint("a/tour.FBS", false)
                .is_some_and(|hint| hint.contains("`fbptr play a/tour.FBS` plays it"))
        );
        assert!(file_hint("recording", true).is_some());
        assert_eq!(file_hint("servee", false), None);
    }
}

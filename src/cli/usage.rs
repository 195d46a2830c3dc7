//! Invalid arguments: the parser's message in the program's style, and the command that was
//! probably meant.

use super::magic::{self, Content};
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
    // What an unreadable file contains is unknown.
    let content = |path: &Path| path.is_file().then(|| magic::of_path(path).ok().flatten());
    match subcommand.and_then(|word| file_hint(word, content(Path::new(word)))) {
        Some(hint) => say_as_program(hint),
        None => {
            let text = error.render().to_string();
            say_as_program(text.strip_prefix("error: ").unwrap_or(&text).trim_end());
        }
    }
    Status::BadArguments
}

/// Returns a hint if a file name was given in place of a subcommand; `None` for other words. `found`
/// is what the file contains, if there is one.
fn file_hint(word: &str, found: Option<Option<Content>>) -> Option<String> {
    let shows = || {
        format!("`fbptr view {word}` shows it, `fbptr render {word} -o picture.png` makes a picture of it")
    };
    let ending = Path::new(word).extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let command = match (found, ending.as_deref()) {
        (Some(Some(Content::Other(what))), _) => return Some(format!("{word} is no command; it is {what}")),
        (Some(Some(_)), _) => shows(),
        (_, Some("fbs")) => format!("`fbptr play {word}` plays it"),
        (_, Some("obj" | "x3d" | "x3dz" | "x3dv" | "wrl" | "json" | "gltf" | "glb" | "stl" | "ply")) => {
            shows()
        }
        (Some(None), _) => {
            format!("`fbptr play {word}` plays a stream of commands, `fbptr view FILE` shows a scene")
        }
        (None, _) => return None,
    };
    Some(format!("{word} is no command; {command}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::MeshFormat;

    #[test]
    fn files_in_place_of_a_command_have_their_own() {
        assert!(
            file_hint("model.obj", None).is_some_and(|hint| hint.contains("`fbptr view model.obj` shows it"))
        );
        assert!(
            file_hint("a/tour.FBS", None)
                .is_some_and(|hint| hint.contains("`fbptr play a/tour.FBS` plays it"))
        );
        assert!(
            file_hint("recording", Some(None)).is_some_and(|hint| hint.contains("`fbptr play recording`"))
        );
        assert_eq!(file_hint("servee", None), None);
        // The content comes before the name.
        for content in [Content::Gltf, Content::X3d, Content::Mesh(MeshFormat::Ply)] {
            let hint = file_hint("recording.fbs", Some(Some(content)));
            assert!(hint.is_some_and(|hint| hint.contains("`fbptr view recording.fbs` shows it")));
        }
        let picture = file_hint("a.obj", Some(Some(Content::Other("a PNG picture"))));
        assert_eq!(picture.as_deref(), Some("a.obj is no command; it is a PNG picture"));
        assert!(file_hint("box.glb", None).is_some_and(|hint| hint.contains("`fbptr view box.glb`")));
    }
}

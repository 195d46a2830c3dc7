//! Names of meshes, textures, scenes, files and tags.

use super::{Argument, TextArgument, expect_left};
use crate::args::{Args, ParseError, is_name};
use crate::commands::{Command, FileKind, SnapTarget};
use crate::encode::{EncodeError, LineWriter};
use crate::verb::{Arity, ParameterKind};
use fbptr_core::error::{Code, Fault};

/// Checks that a text can stand in a line as a name.
fn check_name(name: &str) -> Result<(), Fault> {
    match is_name(name) {
        true => Ok(()),
        false => {
            Err(Fault::new(Code::Args, "a name is printable text without blanks, with no colon before more")
                .got(name))
        }
    }
}

/// The reserved name of the frame among canvases.
const FRAME: &str = "FRAME";

/// Appends a name, or the keyword that stands for none; a name that reads as the keyword has no text.
fn write_name_or(
    keyword: &str,
    name: Option<&str>,
    refused: &'static str,
    line: &mut LineWriter<'_>,
) -> Result<(), EncodeError> {
    match name {
        Some(name) if name.eq_ignore_ascii_case(keyword) => return line.no_text(refused),
        name => line.word(name.unwrap_or(keyword)),
    }
    Ok(())
}

/// Reads a name, `None` for the keyword.
fn read_name_or(keyword: &str, args: &mut Args<'_>) -> Result<Option<String>, ParseError> {
    Ok(if args.take_keyword(keyword) { None } else { Some(args.name()?) })
}

impl Argument for String {
    type Value = String;
    const KIND: ParameterKind = ParameterKind::Name;
    const WORDS: Arity = Arity::ONE;

    fn check_names(name: &String) -> Result<(), Fault> {
        check_name(name)
    }

    fn write(name: &String, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.word(name);
        Ok(())
    }
}

impl TextArgument for String {
    fn read(args: &mut Args<'_>) -> Result<String, ParseError> {
        args.name()
    }
}

/// The name of a texture, `None` for `OFF`.
pub struct TextureName;

impl Argument for TextureName {
    type Value = Option<String>;
    const KIND: ParameterKind = ParameterKind::Name;
    const WORDS: Arity = Arity::ONE;

    fn check_names(name: &Option<String>) -> Result<(), Fault> {
        name.as_ref().map_or(Ok(()), String::check_names)
    }

    fn write(name: &Option<String>, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        write_name_or("OFF", name.as_deref(), "a texture called OFF", line)
    }
}

impl TextArgument for TextureName {
    fn read(args: &mut Args<'_>) -> Result<Option<String>, ParseError> {
        read_name_or("off", args)
    }
}

/// The name of a canvas; `FRAME` is the frame's.
pub struct CanvasName;

impl Argument for CanvasName {
    type Value = String;
    const KIND: ParameterKind = ParameterKind::Name;
    const WORDS: Arity = Arity::ONE;

    fn check_sizes(name: &String) -> Result<(), Fault> {
        match name.eq_ignore_ascii_case(FRAME) {
            true => Err(Fault::new(Code::Args, "FRAME is the frame, and no canvas").got(name.clone())),
            false => Ok(()),
        }
    }

    fn check_names(name: &String) -> Result<(), Fault> {
        String::check_names(name)
    }

    fn write(name: &String, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        String::write(name, line)
    }
}

impl TextArgument for CanvasName {
    fn read(args: &mut Args<'_>) -> Result<String, ParseError> {
        args.name()
    }
}

/// The canvas that is drawn on, `None` for `FRAME`.
pub struct TargetName;

impl Argument for TargetName {
    type Value = Option<String>;
    const KIND: ParameterKind = ParameterKind::Name;
    const WORDS: Arity = Arity::ONE;

    fn check_names(name: &Option<String>) -> Result<(), Fault> {
        name.as_ref().map_or(Ok(()), String::check_names)
    }

    fn write(name: &Option<String>, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        write_name_or(FRAME, name.as_deref(), "a canvas called FRAME", line)
    }
}

impl TextArgument for TargetName {
    fn read(args: &mut Args<'_>) -> Result<Option<String>, ParseError> {
        read_name_or(FRAME, args)
    }
}

impl Argument for SnapTarget {
    type Value = SnapTarget;
    const KIND: ParameterKind = ParameterKind::Name;
    const WORDS: Arity = Arity::ONE;

    fn check_names(target: &SnapTarget) -> Result<(), Fault> {
        match target {
            SnapTarget::File(name) => check_name(name),
            SnapTarget::Connection => Ok(()),
        }
    }

    fn write(target: &SnapTarget, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        match target {
            SnapTarget::Connection => line.word(":"),
            SnapTarget::File(name) if name == ":" => return line.no_text("a file called :"),
            SnapTarget::File(name) => line.word(name),
        }
        Ok(())
    }
}

impl TextArgument for SnapTarget {
    fn read(args: &mut Args<'_>) -> Result<SnapTarget, ParseError> {
        let name = args.name()?;
        Ok(if name == ":" { SnapTarget::Connection } else { SnapTarget::File(name) })
    }
}

/// The name under which `LOAD` keeps a file; empty, and no word, for a scene.
pub struct LoadName;

impl Argument for LoadName {
    type Value = String;
    const KIND: ParameterKind = ParameterKind::Words;
    const WORDS: Arity = Arity::ZERO.or(Arity::ONE);

    /// Appends nothing: see [`write_load`].
    fn write(_: &String, _: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        Ok(())
    }
}

impl TextArgument for LoadName {
    /// Reads by the word before, which names the kind of file.
    fn read(args: &mut Args<'_>) -> Result<String, ParseError> {
        if args.last().eq_ignore_ascii_case(b"scene") {
            expect_left(args, &[1], "SCENE")?;
            return Ok(String::new());
        }
        expect_left(args, &[2], "a named file")?;
        args.name()
    }
}

/// Checks the names of `LOAD`: a scene has none but its path.
pub(crate) fn load_names(command: &Command) -> Result<(), Fault> {
    match command {
        Command::Load { kind: FileKind::Scene, path, .. } => check_name(path),
        Command::Load { name, path, .. } => check_name(name).and_then(|()| check_name(path)),
        _ => Ok(()),
    }
}

/// Appends the arguments of `LOAD`: the kind of the file, the name that it is given, its path.
pub(crate) fn write_load(command: &Command, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
    let Command::Load { kind, name, path } = command else { return Ok(()) };
    FileKind::write(kind, line)?;
    if *kind != FileKind::Scene {
        line.word(name);
    } else if !name.is_empty() {
        return line.no_text("a scene's name");
    }
    line.word(path);
    Ok(())
}

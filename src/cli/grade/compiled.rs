//! A student's folder as a program: compiled under limits, with the calls that compile.
//!
//! In: a folder of sources. Out: the program, or its [`Fault`], which costs all items; a call of one
//! function that does not compile costs the items that need it. Right is: whatever the sources are,
//! they cost points and no run: only a machine without a compiler, or a folder that is not read, is a
//! wrong use.

use super::super::mygl::build::{BuildError, Built, Compiled, build};
use super::calls::{self, Called, Prepared};
use super::watch::{self, End, Limits, Said};
use std::io;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Limits of make and of each compiler.
const COMPILING: Limits = Limits {
    time: Duration::from_secs(120),
    memory: 4 << 30,
    processes: 256,
    output: 1 << 16,
    ends_by_output: false,
    said: Said::First,
};
/// Lines of errors that are shown.
const SHOWN: usize = 6;

/// Reason for which a program has no points at all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    pub text: String,
    /// The compiler's first errors.
    pub errors: Vec<String>,
}

/// Reason for which there is no program.
#[derive(Debug)]
pub enum Refusal {
    /// The use is wrong, or the machine lacks something.
    Use(String),
    Fault(Fault),
}

/// Compiles the sources of a folder.
///
/// # Errors
/// The reason why there is no program.
pub fn compile(folder: &Path) -> Result<Built, Refusal> {
    build(folder, &mut limited).map_err(|error| refusal(error, folder))
}

/// Copies a folder so that its functions are called, and compiles the copy.
///
/// # Errors
/// The reason why there is no program.
pub fn compile_calls(folder: &Path, copy: &Path) -> Result<(Called, Built), Refusal> {
    let mut prepared = calls::prepare(folder, copy)?;
    loop {
        let messages = match prepared.write().map(|()| build(copy, &mut limited)) {
            Err(e) => return Err(Refusal::Use(e)),
            Ok(Ok(built)) => return Ok((prepared.called, built)),
            Ok(Err(BuildError::Program { messages, .. })) if !watch::is_over() => messages,
            Ok(Err(error)) => return Err(refusal(error, copy)),
        };
        let blamed = prepared.called.blamed(&messages);
        match blamed.is_empty() {
            true => alone(&mut prepared, copy)?,
            false => blamed.into_iter().for_each(|(verb, line)| {
                let line = plain(&line, copy);
                prepared.called.lose(verb, format!("the call of {{}} does not compile: {line}"));
            }),
        }
    }
}

/// Tries each call alone, and loses those that do not compile.
fn alone(prepared: &mut Prepared, copy: &Path) -> Result<(), Refusal> {
    let mut tried = prepared.called.clone();
    let all: Vec<&'static str> = tried.verbs();
    let attempt = |verb: Option<&'static str>| {
        prepared.only(verb).map_err(Refusal::Use)?;
        build(copy, &mut limited).map(|_| ()).map_err(|error| refusal(error, copy))
    };
    // Without any call all errors are the program's own.
    attempt(None)?;
    let mut is_lost = false;
    for verb in &all {
        if let Err(refused) = attempt(Some(verb)) {
            let Refusal::Fault(fault) = refused else { return Err(refused) };
            let text = fault.text.trim_start_matches(NO_PROGRAM);
            tried.lose(verb, format!("the call of {{}} does not compile: {text}"));
            is_lost = true;
        }
    }
    if !is_lost {
        let text = format!("{NO_PROGRAM}its functions cannot be called together");
        return Err(Refusal::Fault(Fault { text, errors: Vec::new() }));
    }
    prepared.called = tried;
    Ok(())
}

const NO_PROGRAM: &str = "the program does not compile: ";

/// Runs make or a compiler under limits, with messages in English.
fn limited(command: &mut Command) -> io::Result<Compiled> {
    command.stdin(Stdio::null()).env("LC_ALL", "C");
    let watched = watch::run(command, COMPILING)?;
    let ended = match watched.end {
        End::Exited(_) => None,
        End::Time => Some(format!("no end within {:?}", COMPILING.time)),
        End::Memory => Some("more than 4 GiB of memory".to_owned()),
        End::Processes => Some(format!("more than {} processes", COMPILING.processes)),
        End::Output | End::Signal => Some("ended".to_owned()),
    };
    let is_good = matches!(watched.end, End::Exited(status) if status.success());
    Ok(Compiled { is_good, ended, messages: String::from_utf8_lossy(&watched.stderr).into_owned() })
}

fn refusal(error: BuildError, folder: &Path) -> Refusal {
    match error {
        BuildError::Machine(text) => Refusal::Use(text),
        BuildError::Program { step, messages } => {
            let lines: Vec<&str> = messages.lines().filter(|line| is_error(line)).collect();
            let first = lines.first().map_or_else(|| plain(&step, folder), |line| plain(line, folder));
            let errors = lines.iter().take(SHOWN).map(|line| plain(line, folder)).collect();
            Refusal::Fault(Fault { text: format!("{NO_PROGRAM}{first}"), errors })
        }
    }
}

/// Returns whether a line of a compiler, linker or make is an error of its own.
pub fn is_error(line: &str) -> bool {
    ["error:", "undefined reference to", "multiple definition of", "cannot find -l", "*** "]
        .iter()
        .any(|word| line.contains(word))
        && !line.contains("ld returned")
}

/// Returns a line without the path of the folder.
fn plain(line: &str, folder: &Path) -> String {
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    line.replace(&format!("{}/", folder.display()), "").trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_error_is_the_programs_and_without_the_folders_path() {
        let messages = "In file included from /tmp:\n/tmp/a.cpp: In function 'int main()':\n/tmp/a.cpp:3:5: error: 'x' \
                        was not declared\n/tmp/a.cpp:9:1: error: other\nld: error: ld returned 1 exit status\n";
        let program = |messages: &str| BuildError::Program {
            step: "cc: the program does not compile".to_owned(),
            messages: messages.to_owned(),
        };
        let Refusal::Fault(fault) = refusal(program(messages), Path::new("/tmp")) else { panic!() };
        assert_eq!(fault.text, "the program does not compile: a.cpp:3:5: error: 'x' was not declared");
        assert_eq!(fault.errors.len(), 2);
        let Refusal::Fault(fault) = refusal(program("nothing"), Path::new("/tmp")) else { panic!() };
        assert_eq!(fault.text, "the program does not compile: cc: the program does not compile");
    }
}

//! Running a program for one item of a sheet: the command, its folder, and what came of it.
//!
//! In: an item and the program's words. Out: a picture or numbers, or in words why there are none.
//! A program is run by `fbptr run`, by itself, or by the Python framework, under the item's limits.

use super::super::run::{is_glut_program, remove_left_by};
use super::calls::{Called, plain};
use super::sheet::{By, Input, Item, Wanted};
use super::watch::{self, End, Limits, Said, Watched};
use crate::memory::{SharedFile, VideoMemory};
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// Time that `fbptr run` has beyond the program's own.
const RUN_ENDS: Duration = Duration::from_secs(8);
/// This program.
const OWN: &str = "/proc/self/exe";
/// Processes that a program may have.
const PROCESSES: usize = 64;
/// Bytes of a stream or of numbers that are read.
const OUTPUT: usize = 64 << 20;

/// The program, and how it is run.
pub struct Program {
    pub words: Vec<OsString>,
    /// The folder that it runs in, if that is another one.
    pub folder: Option<PathBuf>,
    pub by: Option<By>,
    pub python: OsString,
    /// Its functions, if they are called in place of its own figures.
    pub called: Option<Called>,
}

/// Outcome of a run.
pub enum Made {
    Picture(Box<VideoMemory>),
    /// A stream, which is drawn as the exact picture is.
    Stream(PathBuf),
    Numbers(Vec<f64>),
}

/// A run: what came of it, or why nothing did, and what the program said.
pub struct Ran {
    pub made: Result<Made, String>,
    /// Last lines of standard error.
    pub said: Vec<String>,
}

impl Program {
    /// Returns the way of an item's picture.
    fn by(&self, item: &Item) -> By {
        match (item.by, &item.exact) {
            (By::Renderizador, _) => By::Renderizador,
            (_, Wanted::Numbers(_)) => By::Stdout,
            (by, _) => self.by.unwrap_or(match self.names_memory() {
                true => By::Memory,
                false => by,
            }),
        }
    }

    fn names_memory(&self) -> bool {
        self.words.iter().any(|word| word.to_string_lossy().contains("{memory}"))
    }

    /// Runs the program for an item. `folder` is the item's own; `scene` is the exact picture's
    /// file.
    pub fn run(&self, item: &Item, folder: &Path, scene: Option<&Path>) -> Ran {
        let by = self.by(item);
        match self.start(item, by, folder, scene) {
            Ok(watched) => {
                let fault = self.called.as_ref().and_then(|_| Called::fault(&folder.join("input")));
                let text = String::from_utf8_lossy(&watched.stderr).into_owned();
                let said: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).collect();
                let said =
                    said[said.len().saturating_sub(6)..].iter().map(|line| (*line).to_owned()).collect();
                // What ended it comes first.
                let made = made(item, by, folder, &watched);
                Ran { made: made.and_then(|made| fault.map_or(Ok(made), Err)), said }
            }
            Err(message) => Ran { made: Err(message), said: Vec::new() },
        }
    }

    fn start(&self, item: &Item, by: By, folder: &Path, scene: Option<&Path>) -> Result<Watched, String> {
        let failed = |e: std::io::Error| format!("{}: {e}", self.name());
        let memory = folder.join("memory");
        if by == By::Memory || self.names_memory() {
            drop(SharedFile::open(&memory, item.size.into(), true).map_err(|e| e.to_string())?);
        }
        let input = folder.join("input");
        let text = match (&item.input, &item.exact) {
            (Input::Exact, Wanted::Text(text)) | (Input::Text(text), _) => text.as_str(),
            (Input::Exact, _) => "",
        };
        let text = match (&self.called, &item.exact) {
            (Some(_), Wanted::Text(text)) => plain(text),
            _ => text.to_owned(),
        };
        fs::write(&input, text).map_err(failed)?;
        let words = self.words_for(item, folder);
        let mut command = match by {
            By::Run => under_run(item, Some(folder), &words),
            // It finds GLUT there.
            By::Stdout | By::Memory if is_glut_program(Path::new(&words[0])) => under_run(item, None, &words),
            By::Renderizador => self.renderizador(item, folder, scene.unwrap_or(Path::new(""))),
            By::Stdout | By::Memory => {
                let mut command = Command::new(&words[0]);
                command.args(&words[1..]);
                command
            }
        };
        match self.called {
            // The program may wait for a key, which is not to be a figure.
            Some(_) => {
                Called::read_by(&mut command, &input);
                command.stdin(Stdio::null());
            }
            None => _ = command.stdin(Stdio::from(File::open(&input).map_err(failed)?)),
        }
        if let (Some(folder), false) = (&self.folder, by == By::Renderizador) {
            command.current_dir(folder);
        }
        let is_run = command.get_program() == OWN;
        let is_read = by == By::Stdout;
        let limits = Limits {
            time: item.time + if is_run { RUN_ENDS } else { Duration::ZERO },
            memory: item.memory,
            processes: PROCESSES,
            output: if is_read { OUTPUT } else { 1 << 16 },
            ends_by_output: is_read,
            said: Said::Last,
        };
        let watched = watch::run(&mut command, limits).map_err(failed)?;
        if is_run {
            // A run that is ended by force leaves it.
            remove_left_by(watched.pid);
        }
        Ok(watched)
    }

    fn name(&self) -> String {
        self.words.first().map_or(String::new(), |word| word.display().to_string())
    }

    /// Returns the program's words and the item's, with names in place of what stands for them.
    fn words_for(&self, item: &Item, folder: &Path) -> Vec<OsString> {
        let size = item.size;
        let places = [
            ("{memory}", folder.join("memory").display().to_string()),
            ("{folder}", folder.display().to_string()),
            ("{item}", item.name.clone()),
            ("{width}", size.width.to_string()),
            ("{height}", size.height.to_string()),
        ];
        let filled = |word: &OsStr| match word.to_str() {
            Some(text) if text.contains('{') => {
                places.iter().fold(text.to_owned(), |text, (name, value)| text.replace(name, value)).into()
            }
            _ => word.to_owned(),
        };
        let own = self.words.iter().map(|word| filled(word));
        own.chain(item.arguments.iter().map(|word| filled(word.as_ref()))).collect()
    }

    fn renderizador(&self, item: &Item, folder: &Path, scene: &Path) -> Command {
        let mut command = Command::new(&self.python);
        command.args(["-m", "fbptr.course.renderizador"]).arg(scene).arg("-i").arg(&self.words[0]);
        command.arg("--size").arg(item.size.to_string()).arg("-o").arg(folder.join("mine.png"));
        command.arg("--frames").arg(item.frames.to_string());
        // Nothing is written into the student's folder.
        command.env("PYTHONDONTWRITEBYTECODE", "1");
        command
    }
}

/// Returns the command that runs a program by `fbptr run`, and writes its picture into a folder.
fn under_run(item: &Item, folder: Option<&Path>, words: &[OsString]) -> Command {
    let mut command = Command::new(OWN);
    command.args(["run", "--headless", "--limit"]).arg(format!("{}ms", item.time.as_millis()));
    // The frame is as large as the window of GLUT.
    if !is_glut_program(Path::new(&words[0])) {
        command.arg("--size").arg(item.size.to_string());
    }
    if let Some(folder) = folder {
        command.args(["--after", &item.after, "--snap"]).arg(folder.join("mine.png"));
    }
    command.arg("--").args(words);
    command
}

/// Returns what came of a run that has ended.
fn made(item: &Item, by: By, folder: &Path, watched: &Watched) -> Result<Made, String> {
    let status = match watched.end {
        End::Time => {
            return Err(format!("the program did not end within {:?}", item.time));
        }
        End::Memory => return Err(format!("the program had more than {} of memory", bytes(item.memory))),
        End::Processes => return Err(format!("the program had more than {PROCESSES} processes")),
        End::Output => return Err(format!("the program printed more than {}", bytes(OUTPUT as u64))),
        End::Signal => return Err("the run was ended".to_owned()),
        End::Exited(status) => status,
    };
    let signal = status
        .signal()
        .or_else(|| status.code().filter(|code| (129..160).contains(code)).map(|code| code - 128));
    if let Some(signal) = signal {
        return Err(format!("the program crashed: {}", name_of_signal(signal)));
    }
    let code = status.code().unwrap_or(0);
    match by {
        By::Run | By::Renderizador => {
            let path = folder.join("mine.png");
            match (by, code) {
                (By::Run, 126 | 127) => Err("the program cannot be run".to_owned()),
                (By::Renderizador, 1..) => Err(format!("the program ended with status {code}")),
                _ => picture(&path)
                    .map_err(|_| format!("there is no picture; the program ended with status {code}")),
            }
        }
        By::Memory => {
            let mut shared = SharedFile::open(&folder.join("memory"), item.size.into(), true)
                .map_err(|e| e.to_string())?;
            let mut memory =
                VideoMemory::new(item.size.width, item.size.height).map_err(|e| e.to_string())?;
            shared.load_into(&mut memory);
            Ok(Made::Picture(Box::new(memory)))
        }
        By::Stdout if matches!(item.exact, Wanted::Numbers(_)) => Ok(Made::Numbers(numbers(&watched.stdout))),
        By::Stdout if watched.stdout.iter().all(u8::is_ascii_whitespace) => {
            Err(format!("the program printed nothing; it ended with status {code}"))
        }
        By::Stdout => {
            let path = folder.join("mine.fbs");
            fs::write(&path, &watched.stdout).map_err(|e| e.to_string())?;
            Ok(Made::Stream(path))
        }
    }
}

fn picture(path: &Path) -> Result<Made, String> {
    let bytes = crate::save::read_input(path, 1 << 30).map_err(|e| e.to_string())?;
    let memory = crate::save::read_picture(path, &bytes, None).map_err(|e| e.to_string())?;
    Ok(Made::Picture(Box::new(memory)))
}

/// Returns the numbers of a text; words between them are skipped.
fn numbers(text: &[u8]) -> Vec<f64> {
    let text = String::from_utf8_lossy(text);
    let words = text.split(|c: char| c.is_whitespace() || "[](),;|".contains(c));
    // Words as `inf` and `nan` are numbers, and wrong ones.
    words.filter(|word| !word.is_empty()).filter_map(|word| word.parse().ok()).collect()
}

fn bytes(count: u64) -> String {
    match count {
        _ if count.is_multiple_of(1 << 30) => format!("{} GiB", count >> 30),
        _ if count.is_multiple_of(1 << 20) => format!("{} MiB", count >> 20),
        _ => format!("{count} bytes"),
    }
}

fn name_of_signal(signal: i32) -> String {
    let name = match signal {
        4 => "an illegal instruction (SIGILL)",
        6 => "it aborted (SIGABRT)",
        7 => "a bus error (SIGBUS)",
        8 => "a division by zero or the like (SIGFPE)",
        9 => "it was killed (SIGKILL)",
        11 => "an access outside of its memory (SIGSEGV)",
        15 => "it was ended (SIGTERM)",
        _ => return format!("signal {signal}"),
    };
    name.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_between_words_and_brackets() {
        assert_eq!(numbers(b"view:\n[1, 0.5;-2e-1]\n(3) w = nonsense"), [1.0, 0.5, -0.2, 3.0]);
        assert!(numbers(b"nan")[0].is_nan() && numbers(b"").is_empty() && numbers(b"\xff\xfe1").is_empty());
    }
}

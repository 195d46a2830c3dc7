//! Compiling a program of GLUT: by its Makefile, or all of its C and C++ files together.
//!
//! In: a folder, and a function that runs make and each compiler. Out: a program, or why there is
//! none: the fault of the machine, which has no compiler, is told from the program's own.

use super::super::run::is_glut_program;
use super::config;
use std::ffi::OsStr;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

/// Folders of folders that are looked into.
const DEPTH: u32 = 3;
/// Beginnings of the names of folders whose files are not parts of a program; headers are looked for
/// in them and beside them.
const SKIPPED: [&str; 6] = ["glm", "eigen", "build", "cmake", "doc", "test"];
/// Folder of Eigen's headers, where the system has them.
const EIGEN: &str = "/usr/include/eigen3";

/// A program that was compiled.
pub struct Built {
    program: PathBuf,
    /// The folder that it is in, if that is removed with it.
    folder: Option<PathBuf>,
}

impl Built {
    /// Returns the program's path.
    pub fn program(&self) -> &Path {
        &self.program
    }
}

impl Drop for Built {
    fn drop(&mut self) {
        if let Some(folder) = &self.folder {
            let _ = fs::remove_dir_all(folder);
        }
    }
}

/// End of make or of a compiler.
#[derive(Debug, Default)]
pub struct Compiled {
    pub is_good: bool,
    /// Reason for which it was ended, if it was.
    pub ended: Option<String>,
    /// Its messages, where they are collected.
    pub messages: String,
}

/// Way to run make and a compiler.
pub type Compile<'a> = &'a mut dyn FnMut(&mut Command) -> io::Result<Compiled>;

/// Reason for which there is no program.
#[derive(Debug)]
pub enum BuildError {
    /// Nothing could be tried.
    Machine(String),
    /// The program does not compile: the last step in words, and the messages of all.
    Program { step: String, messages: String },
}

impl BuildError {
    fn program(step: String) -> BuildError {
        BuildError::Program { step, messages: String::new() }
    }

    /// Adds the messages of what was tried before.
    fn after(self, before: &str) -> BuildError {
        match self {
            BuildError::Program { step, messages } => {
                BuildError::Program { step, messages: format!("{messages}{before}") }
            }
            BuildError::Machine(_) => self,
        }
    }
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BuildError::Machine(text) | BuildError::Program { step: text, .. } => f.write_str(text),
        }
    }
}

/// Compiles with messages as they come, to the end.
///
/// # Errors
/// If the compiler is not started.
pub fn compile(command: &mut Command) -> io::Result<Compiled> {
    Ok(Compiled { is_good: command.status()?.success(), ..Compiled::default() })
}

/// Compiles the program of a folder.
///
/// # Errors
/// The reason why there is none.
pub fn build(folder: &Path, compile: Compile<'_>) -> Result<Built, BuildError> {
    let machine = |e: io::Error| BuildError::Machine(format!("{}: {e}", folder.display()));
    let folder = folder.canonicalize().map_err(machine)?;
    let support = config::folder().map_err(BuildError::Machine)?;
    let has_makefile = ["Makefile", "makefile", "GNUmakefile"].iter().any(|name| folder.join(name).is_file());
    let mut before = String::new();
    if has_makefile {
        match by_makefile(&folder, &support, compile) {
            Ok(built) => return Ok(built),
            // What a Makefile for another machine does not do is tried without it.
            Err(error) => {
                super::super::say_as_program(format_args!("{error}: trying without the Makefile"));
                if let BuildError::Program { messages, .. } = error {
                    before = messages;
                }
            }
        }
    }
    by_files(&folder, &support, compile).map_err(|error| error.after(&before))
}

fn by_makefile(folder: &Path, support: &Path, compile: Compile<'_>) -> Result<Built, BuildError> {
    let mut make = Command::new("make");
    make.arg("-C").arg(folder).stdout(std::io::stderr());
    for (name, part) in [("CPATH", "include"), ("LIBRARY_PATH", "lib")] {
        let others = std::env::var_os(name).unwrap_or_default();
        let paths = std::iter::once(support.join(part)).chain(std::env::split_paths(&others));
        make.env(name, std::env::join_paths(paths.filter(|path| *path != *"")).unwrap_or_default());
    }
    run(&mut make, compile)?;
    let mut newest: Option<(SystemTime, PathBuf)> = None;
    walk(folder, DEPTH, &mut |path| {
        let time = fs::metadata(path).and_then(|meta| meta.modified());
        if path.is_file()
            && let Ok(time) = time.as_ref().copied()
            && newest.as_ref().is_none_or(|(other, _)| time > *other)
            && is_glut_program(path)
        {
            newest = Some((time, path.to_owned()));
        }
    });
    match newest {
        Some((_, program)) => Ok(Built { program, folder: None }),
        None => Err(BuildError::program(format!("{}: make has built no program of GLUT", folder.display()))),
    }
}

fn by_files(folder: &Path, support: &Path, compile: Compile<'_>) -> Result<Built, BuildError> {
    let (mut c, mut cpp, mut includes) = (Vec::new(), Vec::new(), vec![folder.to_owned()]);
    walk(folder, DEPTH, &mut |path| {
        if path.is_dir() {
            includes.extend([path.parent().unwrap_or(folder), path].map(Path::to_owned));
            return;
        }
        let folder_of = path.parent().unwrap_or(folder);
        let (list, entry) = match path.extension().and_then(OsStr::to_str) {
            Some("c") => (&mut c, path),
            Some("cpp" | "cc" | "cxx" | "C") => (&mut cpp, path),
            Some("h" | "hpp") => (&mut includes, folder_of),
            _ => return,
        };
        if !list.iter().any(|other: &PathBuf| other == entry) {
            list.push(entry.to_owned());
        }
    });
    if c.is_empty() && cpp.is_empty() {
        let step = format!("{}: there are no C or C++ files", folder.display());
        return Err(BuildError::program(step));
    }
    includes.push(EIGEN.into());
    keep_one_main(&mut c, &mut cpp);
    let out = std::env::temp_dir().join(format!("fbptr-mygl-{}", std::process::id()));
    fs::create_dir_all(&out).map_err(|e| BuildError::Machine(format!("{}: {e}", out.display())))?;
    let built = Built { program: out.join("program"), folder: Some(out.clone()) };
    let mut objects = Vec::new();
    // As older compilers have it, variables that several files define are one, and each header of C++
    // brings the C library's.
    let kinds: [(_, _, &[&str]); 2] = [
        ("cc", &c, &["-fcommon"]),
        ("c++", &cpp, &["-fpermissive", "-include", "cstdlib", "-include", "cstring"]),
    ];
    for (compiler, files, options) in kinds {
        for file in files.iter() {
            let object = out.join(format!("{}.o", objects.len()));
            let mut command = Command::new(compiler);
            command.args(["-g", "-O1", "-w", "-c"]).args(options).arg(file).arg("-o").arg(&object);
            command.arg("-I").arg(support.join("include"));
            includes.iter().for_each(|path| _ = command.arg("-I").arg(path));
            run(&mut command, compile)?;
            objects.push(object);
        }
    }
    let mut link = Command::new(if cpp.is_empty() { "cc" } else { "c++" });
    link.args(&objects).arg("-o").arg(built.program()).arg("-L").arg(support.join("lib"));
    // A program that uses none of GLUT is not one of GLUT.
    run(link.args(["-Wl,--as-needed", "-lglut", "-lGLU", "-lGL", "-lm"]), compile)?;
    Ok(built)
}

/// Leaves out all files but one that have a `main`: the one of this name is kept, or the first.
fn keep_one_main(c: &mut Vec<PathBuf>, cpp: &mut Vec<PathBuf>) {
    let has_main = |path: &PathBuf| {
        let text = fs::read(path).unwrap_or_default();
        let text = String::from_utf8_lossy(&text).into_owned();
        text.split_whitespace().collect::<Vec<_>>().join(" ").contains("int main(")
            || text.contains("int main (")
    };
    let mains: Vec<PathBuf> = cpp.iter().chain(c.iter()).filter(|path| has_main(path)).cloned().collect();
    let is_named = |path: &&PathBuf| path.file_stem().is_some_and(|stem| stem == "main");
    let Some(kept) = mains.iter().find(is_named).or(mains.first()) else { return };
    [c, cpp].into_iter().for_each(|list| list.retain(|path| path == kept || !mains.contains(path)));
}

fn run(command: &mut Command, compile: Compile<'_>) -> Result<(), BuildError> {
    let name = command.get_program().to_string_lossy().into_owned();
    match compile(command) {
        Ok(Compiled { is_good: true, .. }) => Ok(()),
        Ok(Compiled { ended, messages, .. }) => {
            let why = ended.unwrap_or_else(|| "the program does not compile".to_owned());
            Err(BuildError::Program { step: format!("{name}: {why}"), messages })
        }
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            Err(BuildError::Machine(format!("{name} is not installed")))
        }
        Err(e) => Err(BuildError::Machine(format!("{name}: {e}"))),
    }
}

/// Calls `each` for the files of a folder and of those in it, in the order of their names, and for
/// the folders that are skipped.
fn walk(folder: &Path, depth: u32, each: &mut dyn FnMut(&Path)) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let name = path.file_name().and_then(OsStr::to_str).unwrap_or("");
        let kind = path.symlink_metadata().map(|meta| meta.file_type());
        match kind {
            Ok(kind) if kind.is_dir() && !name.starts_with('.') => {
                let name = name.to_ascii_lowercase();
                match SKIPPED.iter().any(|skipped| name.starts_with(skipped)) {
                    true => each(&path),
                    false if depth > 0 => walk(&path, depth - 1, each),
                    false => {}
                }
            }
            Ok(kind) if kind.is_file() => each(&path),
            _ => {}
        }
    }
}

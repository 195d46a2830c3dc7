//! Compiling a program of GLUT: by its Makefile, or all of its C and C++ files together.

use super::super::run::is_glut_program;
use super::config;
use rustix::process::{Pid, Signal, kill_process_group};
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant, SystemTime};

/// Time between two looks at a program that has a limit.
const LOOK: Duration = Duration::from_millis(20);
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

/// Compiles the program of a folder; make and each compiler run for at most `limit`, if one is given.
///
/// # Errors
/// Why it does not compile, after the compiler's own messages.
pub fn build(folder: &Path, limit: Option<Duration>) -> Result<Built, String> {
    let folder = folder.canonicalize().map_err(|e| format!("{}: {e}", folder.display()))?;
    let support = config::folder()?;
    let has_makefile = ["Makefile", "makefile", "GNUmakefile"].iter().any(|name| folder.join(name).is_file());
    if has_makefile {
        match by_makefile(&folder, &support, limit) {
            Ok(built) => return Ok(built),
            // What a Makefile for another machine does not do is tried without it.
            Err(message) => {
                super::super::say_as_program(format_args!("{message}: trying without the Makefile"))
            }
        }
    }
    by_files(&folder, &support, limit)
}

fn by_makefile(folder: &Path, support: &Path, limit: Option<Duration>) -> Result<Built, String> {
    let mut make = Command::new("make");
    make.arg("-C").arg(folder).stdout(std::io::stderr());
    for (name, part) in [("CPATH", "include"), ("LIBRARY_PATH", "lib")] {
        let others = std::env::var_os(name).unwrap_or_default();
        let paths = std::iter::once(support.join(part)).chain(std::env::split_paths(&others));
        make.env(name, std::env::join_paths(paths.filter(|path| *path != *"")).unwrap_or_default());
    }
    let status = status_of(&mut make, limit).map_err(|e| format!("make: {e}"))?;
    if !status.success() {
        return Err(format!("make: {status}"));
    }
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
        None => Err(format!("{}: make has built no program of GLUT", folder.display())),
    }
}

fn by_files(folder: &Path, support: &Path, limit: Option<Duration>) -> Result<Built, String> {
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
        return Err(format!("{}: there are no C or C++ files", folder.display()));
    }
    includes.push(EIGEN.into());
    keep_one_main(&mut c, &mut cpp);
    let out = std::env::temp_dir().join(format!("fbptr-mygl-{}", std::process::id()));
    fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
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
            run(&mut command, limit)?;
            objects.push(object);
        }
    }
    let mut link = Command::new(if cpp.is_empty() { "cc" } else { "c++" });
    link.args(&objects).arg("-o").arg(built.program()).arg("-L").arg(support.join("lib"));
    run(link.args(["-lglut", "-lGLU", "-lGL", "-lm"]), limit)?;
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

/// Runs a command to its end, or to the limit, at which it and what it has started are ended.
fn status_of(command: &mut Command, limit: Option<Duration>) -> io::Result<ExitStatus> {
    let Some(limit) = limit else { return command.status() };
    let mut child = command.stdin(Stdio::null()).process_group(0).spawn()?;
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if started.elapsed() > limit {
            let _ = kill_process_group(Pid::from_child(&child), Signal::KILL);
            child.wait()?;
            return Err(io::Error::new(io::ErrorKind::TimedOut, format!("no end within {limit:?}")));
        }
        std::thread::sleep(LOOK);
    }
}

fn run(command: &mut Command, limit: Option<Duration>) -> Result<(), String> {
    let name = command.get_program().to_string_lossy().into_owned();
    match status_of(command, limit) {
        Ok(status) if status.success() => Ok(()),
        Ok(_) => Err(format!("{name}: the program does not compile")),
        Err(e) => Err(format!("{name}: {e}")),
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

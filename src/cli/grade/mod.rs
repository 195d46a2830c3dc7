//! `fbptr grade`: a program's points for the items of a sheet, each beside its exact picture.
//!
//! In: a sheet and a program. Out: points and, in the words of `fbptr compare`, what is wrong, as
//! text, as JSON and as a page. A program that crashes, hangs or prints nonsense loses its item, not
//! the run; nothing of it is left. Exit status: 0 for all points, 1 for fewer, 2 if the sheet or the
//! use is wrong.

#[cfg(fbptr_preload)]
mod builtin;
#[cfg(fbptr_preload)]
mod calls;
#[cfg(fbptr_preload)]
mod compiled;
#[cfg(fbptr_preload)]
mod judge;
#[cfg(fbptr_preload)]
mod program;
#[cfg(fbptr_preload)]
mod python;
#[cfg(fbptr_preload)]
mod result;
#[cfg(fbptr_preload)]
mod sheet;
#[cfg(all(test, fbptr_preload))]
mod tests;
#[cfg(fbptr_preload)]
mod watch;

use super::{Status, say_as_program};
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;

/// Grade a program by a sheet: its points for each item, and what is wrong with the others.
#[derive(Debug, Args)]
pub struct Grade {
    /// The sheet: a file, or the name of one that --list shows
    #[arg(value_name = "SHEET", required_unless_present = "list")]
    sheet: Option<String>,
    /// Print the names of the sheets that come with fbptr
    #[arg(long)]
    list: bool,
    /// Print the sheet, which says what the program reads and draws
    #[arg(long)]
    show: bool,
    /// Grade this item alone; may be given again
    #[arg(long, value_name = "NAME")]
    item: Vec<String>,
    /// The way by which the program gives its picture: run (the framebuffer device, or GLUT), stdout
    /// (a stream of commands), memory (the shared file that {memory} stands for), renderizador
    /// [default: the sheet's; memory if {memory} is among the program's words]
    #[arg(long, value_name = "run|stdout|memory|renderizador", value_parser = ["run", "stdout", "memory", "renderizador"])]
    by: Option<String>,
    /// Draw the sheet's figures by the functions PutPixel, DrawLine and DrawTriangle of a folder whose
    /// framework calls MyGlDraw
    #[arg(long)]
    calls: bool,
    /// The interpreter of Python programs that a sheet runs by the Python framework
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: OsString,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    /// Write a page for the student: the points, and the wrong pixels magnified
    #[arg(long, value_name = "OUT.html")]
    page: Option<PathBuf>,
    /// The program and its arguments, or a folder of C or C++ sources that is compiled first, after --
    #[arg(last = true, value_name = "PROGRAM ARGS")]
    program: Vec<OsString>,
}

impl Grade {
    /// Grades, and returns the exit status.
    pub(super) fn run(self) -> Status {
        #[cfg(fbptr_preload)]
        match self.graded() {
            Ok(Some(true)) => Status::Success,
            Ok(Some(false)) => Status::Failed,
            Ok(None) => Status::Interrupted,
            Err(message) => {
                say_as_program(message);
                Status::BadArguments
            }
        }
        #[cfg(not(fbptr_preload))]
        {
            let Grade { sheet, list, show, item, by, calls, python, json, page, program } = self;
            let _ = (sheet, list, show, item, by, calls, python, json, page, program);
            say_as_program("grade: programs are run on Linux with the GNU C library only");
            Status::BadArguments
        }
    }
}

#[cfg(fbptr_preload)]
mod steps {
    use super::super::mygl::build::Built;
    use super::super::run::find;
    use super::super::{check_folder, output, say_as_program};
    use super::compiled::{Refusal, compile, compile_calls};
    use super::judge::{Graded, Right};
    use super::program::Program;
    use super::result::Report;
    use super::sheet::{By, Item, Sheet};
    use super::watch::{is_over, watch_signals};
    use super::{Grade, builtin, python};
    use clap::ValueEnum;
    use std::fs;
    use std::path::{Path, PathBuf};

    /// Largest sheet.
    const MAX_SHEET_BYTES: u64 = 16 << 20;

    /// A folder for the items' files, which is removed at the end.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new() -> Result<Scratch, String> {
            let path = std::env::temp_dir().join(format!("fbptr-grade-{}", std::process::id()));
            // A folder of this name is one that an earlier run has left.
            let _ = fs::remove_dir_all(&path);
            fs::create_dir(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            Ok(Scratch(path))
        }

        /// Returns the folder of a copy of the program.
        fn copy(&self) -> PathBuf {
            self.0.join("program")
        }

        /// Makes the folder of an item.
        fn folder(&self, number: usize) -> Result<PathBuf, String> {
            let path = self.0.join(number.to_string());
            fs::create_dir(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            Ok(path)
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    impl Grade {
        /// Grades, and returns whether all points were reached; `None` if a signal ended it.
        pub(super) fn graded(self) -> Result<Option<bool>, String> {
            if self.list {
                output::print(builtin::list());
                return Ok(Some(true));
            }
            let name = self.sheet.as_deref().unwrap_or("");
            let (text, beside) = read(name)?;
            let sheet = Sheet::parse(&text).map_err(|e| format!("{name}:{}: {}", e.line, e.message))?;
            if self.show {
                output::print(text);
                return Ok(Some(true));
            }
            if let Some(page) = &self.page {
                check_folder(page)?;
            }
            let items = self.chosen(&sheet)?;
            watch_signals()?;
            let scratch = Scratch::new()?;
            let mut rights = Vec::new();
            for (number, item) in items.iter().enumerate() {
                let folder = scratch.folder(number)?;
                let wrong = |e| format!("{name}:{}: item {}: {e}", item.line, item.name);
                rights.push((*item, Right::read(item, &beside, &folder).map_err(wrong)?, folder));
            }
            let program = match self.program(&items, &scratch) {
                Ok(program) => Ok(program),
                Err(Refusal::Fault(fault)) => {
                    fault.errors.iter().for_each(say_as_program);
                    Err(fault)
                }
                Err(Refusal::Use(_)) if is_over() => return Ok(None),
                Err(Refusal::Use(message)) => return Err(message),
            };
            let mut report = Report { sheet: &sheet, items: Vec::new() };
            if !self.json {
                output::print(format!("{}\n", sheet.title));
            }
            for (item, right, folder) in &rights {
                let graded = match &program {
                    Ok((program, _)) => right.grade(item, program, folder),
                    Err(fault) => Graded::lost(item, fault.text.clone()),
                };
                if is_over() {
                    return Ok(None);
                }
                if !self.json {
                    output::print(Report::line(&graded));
                }
                report.items.push(graded);
            }
            match self.json {
                true => output::print(format!("{}\n", report.json())),
                false => output::print(report.sum()),
            }
            if let Some(page) = &self.page {
                let html = report.page();
                let write = |out: &mut dyn std::io::Write| out.write_all(html.as_bytes());
                crate::save::replace(page, write).map_err(|e| e.to_string())?;
            }
            Ok(Some(report.is_full()))
        }

        /// Returns the items that are asked for.
        fn chosen<'a>(&self, sheet: &'a Sheet) -> Result<Vec<&'a Item>, String> {
            let names: Vec<&str> = sheet.items.iter().map(|item| item.name.as_str()).collect();
            if let Some(other) = self.item.iter().find(|name| !names.contains(&name.as_str())) {
                return Err(format!("--item {other}: the sheet's items are {}", names.join(", ")));
            }
            let is_chosen = |item: &&Item| self.item.is_empty() || self.item.contains(&item.name);
            Ok(sheet.items.iter().filter(is_chosen).collect())
        }

        /// Finds the program, and compiles it where it is a folder.
        fn program(&self, items: &[&Item], scratch: &Scratch) -> Result<(Program, Option<Built>), Refusal> {
            let by = self.by.as_deref().and_then(|name| By::from_str(name, false).ok());
            let wrong = |message: String| Refusal::Use(message);
            let mut words = self.program.clone();
            let Some(first) = words.first() else {
                let text = "a program is expected after --, as in fbptr grade T1 -- ./student";
                return Err(wrong(text.to_owned()));
            };
            let mut folder = fs::canonicalize(first).ok().filter(|path| path.is_dir());
            let is_framework = items.iter().any(|item| item.by == By::Renderizador);
            let (mut built, mut called) = (None, None);
            match (&folder, is_framework) {
                (_, true) if self.calls => {
                    return Err(wrong("--calls: this sheet is for programs in Python".to_owned()));
                }
                (Some(path), true) => {
                    let is_picture = |file: &(String, String)| file.0.ends_with(".png");
                    let has_textures = items.iter().any(|item| item.files.iter().any(is_picture));
                    python::check(&self.python, has_textures).map_err(wrong)?;
                    words[0] = path.into();
                }
                (None, true) => {
                    let text = format!("{}: a folder with the student's gl.py is expected", first.display());
                    return Err(wrong(text));
                }
                (None, false) if self.calls => {
                    return Err(wrong("--calls: a folder of C or C++ sources is expected".to_owned()));
                }
                (Some(path), false) => {
                    let made = match self.calls {
                        false => compile(path)?,
                        true => {
                            let (functions, made) = compile_calls(path, &scratch.copy())?;
                            folder = Some(scratch.copy());
                            let text = functions.text();
                            say_as_program(format_args!(
                                "the sheet's figures are drawn by\n{}",
                                text.trim_end()
                            ));
                            called = Some(functions);
                            made
                        }
                    };
                    words[0] = made.program().into();
                    built = Some(made);
                }
                // What `run` does not serve may do without it.
                (None, false) => match find(&words) {
                    Ok(path) => words[0] = std::path::absolute(&path).unwrap_or(path).into(),
                    Err(refusal) if refusal.status == 127 => return Err(wrong(refusal.message)),
                    Err(_) => {}
                },
            }
            let folder = folder.filter(|_| built.is_some());
            Ok((Program { words, folder, by, python: self.python.clone(), called }, built))
        }
    }

    /// Returns a sheet's text, and the folder that its files are beside.
    fn read(name: &str) -> Result<(String, PathBuf), String> {
        let path = Path::new(name);
        if let (Some(text), false) = (builtin::named(name), path.is_file()) {
            return Ok((text.to_owned(), PathBuf::from(".")));
        }
        if !path.exists() {
            return Err(format!(
                "{name}: there is no such sheet; fbptr grade --list names those that come with it"
            ));
        }
        let bytes = crate::save::read_input(path, MAX_SHEET_BYTES).map_err(|e| format!("{name}: {e}"))?;
        let text = String::from_utf8(bytes).map_err(|e| format!("{name}: {e}"))?;
        // As some editors begin a text.
        let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
        Ok((text, path.parent().map_or(PathBuf::new(), Path::to_owned)))
    }
}

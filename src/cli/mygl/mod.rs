//! `fbptr mygl`: compiles a program of GLUT that shows a memory of its own, and runs it as
//! `fbptr run` does.
//!
//! In: a folder with a Makefile, or with C and C++ files in it, in `src/` and in the folders beside
//! them. Out: the run's exit status; 1 if it does not compile. A program without a Makefile is built
//! in a folder of its own, which is removed at the end; a Makefile writes where it does elsewhere.

#[cfg(fbptr_preload)]
pub(super) mod build;
pub mod config;

use super::Status;
use super::run::Run;
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;

/// Compile a program that shows a memory of its own by GLUT, and run it: no GL, no X server.
#[derive(Debug, Args)]
pub struct Mygl {
    /// The folder of the program
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    #[command(flatten)]
    run: Run,
    /// The program's own arguments, after --
    #[arg(last = true, value_name = "ARGS")]
    words: Vec<OsString>,
}

impl Mygl {
    /// Compiles the program, and runs it to its end, in its folder.
    pub(super) fn run(self) -> Status {
        #[cfg(fbptr_preload)]
        {
            let built = match build::build(&self.folder, &mut build::compile) {
                Ok(built) => built,
                Err(error) => {
                    super::say_as_program(error);
                    return Status::Failed;
                }
            };
            self.run.run_in(&self.folder, built.program().into(), self.words)
        }
        #[cfg(not(fbptr_preload))]
        {
            let Mygl { folder, run, words } = self;
            run.run_in(&folder, OsString::new(), words)
        }
    }
}

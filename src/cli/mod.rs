//! The command line: one file for each subcommand. Arguments come in, an exit status goes out;
//! drawing is done by the other modules.
//!
//! Exit status: 0 for success, 1 if a command or a file failed, 2 if the arguments are invalid, 130
//! if a signal ended `play`; that of `run` is the status of the program that it runs. Replies go to
//! stdout, everything else to stderr. A closed pipe causes no panic, and ends a program that has
//! nothing else to do; a full disk is a failure.

mod args;
mod batch;
mod bench;
mod black_picture;
mod bytes;
mod compare;
mod draw;
mod expect;
mod eye;
mod frame_clock;
mod grade;
mod help;
mod interval;
mod magic;
mod main_thread;
mod mesh_args;
mod movie;
mod mygl;
mod output;
mod picture_args;
mod play;
mod playground;
mod progress;
mod record_gate;
mod render;
mod render_args;
mod render_output;
mod replies;
mod report;
mod run;
mod scene_file;
mod send;
mod serve;
mod signals;
mod snap;
mod table;
mod tour;
mod trace;
mod usage;
mod view;
#[cfg_attr(not(feature = "web"), path = "no_view_web.rs")]
mod view_web;
#[cfg_attr(not(feature = "web"), path = "no_web.rs")]
mod web;

use clap::{FromArgMatches, Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

pub use args::size::FrameSize;

/// An emulated video memory that programs draw into by commands.
#[derive(Debug, Parser)]
#[command(name = "fbptr", version, about, long_about = None)]
pub struct Cli {
    /// Subcommand [default: tour]
    #[command(subcommand)]
    command: Option<Task>,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// See from one pixel to four dimensions in short steps; without a command as well
    Tour(tour::Tour),
    /// Play a stream of commands, in a window or without one
    Play(play::Play),
    /// Type commands and see them drawn: a prompt beside the window
    Draw(draw::Draw),
    /// Time fixed workloads, each held to its truth first
    Bench(bench::Bench),
    /// Measure every stage's alternatives for speed and error
    Report(report::ReportArgs),
    /// Serve a video memory to other programs, in a window or without one
    Serve(serve::Serve),
    /// Run a program that draws on /dev/fb0 or shows a picture by GLUT, in a window or without one
    Run(run::RunProgram),
    /// Compile a program that shows a memory of its own by GLUT, and run it
    Mygl(mygl::Mygl),
    /// Print the options that compile a program of GLUT without GL
    Config(mygl::config::Config),
    /// Render a scene file to a picture, or to a movie
    Render(render::Render),
    /// Compare a picture with the exact one, and say what is wrong with each wrong pixel
    Compare(compare::Compare),
    /// Grade a program by a sheet of an assignment, each item beside its exact picture
    Grade(grade::Grade),
    /// Verify frames that were drawn in parts, and join them
    Batch(batch::Batch),
    /// Look at a mesh, a scene or a stream from everywhere
    View(view::ViewArgs),
    /// Take a picture of a running server
    Snap(snap::Snap),
    /// Send a stream to a running server, and print its replies
    Send(send::Send),
    /// Draw in a browser, with the engine in the page
    Playground(playground::Playground),
    /// See a scene of N dimensions on a screen of M
    Eye(eye::Eye),
    /// Print the manual as man pages
    Man(help::Man),
    /// Print the completions of a shell
    Completions(help::Completions),
}

/// Outcome of the program, which becomes its exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Status {
    Success,
    Failed,
    BadArguments,
    /// Ended by a signal.
    Interrupted,
    /// The status of a program that was run.
    Program(u8),
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    #[cfg(fbptr_preload)]
    if let Some(status) = run::started() {
        return status.into();
    }
    let parsed = help::command().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => return usage::ended(&error).into(),
    };
    let status = match cli.command.unwrap_or_else(|| Task::Tour(tour::Tour::default())) {
        Task::Tour(tour) => tour.run(),
        Task::Play(play) => main_thread::beside(|| output::ended(play.run())),
        Task::Draw(draw) => main_thread::beside(|| output::ended(draw.run())),
        Task::Bench(bench) => bench.run(),
        Task::Report(report) => report.run(),
        Task::Serve(serve) => main_thread::beside(|| output::ended(serve.run())),
        Task::Run(run) => main_thread::beside(|| output::ended(run.run())),
        Task::Mygl(mygl) => main_thread::beside(|| output::ended(mygl.run())),
        Task::Config(config) => config.run(),
        Task::Render(render) => render.run(),
        Task::Compare(compare) => compare.run(),
        Task::Grade(grade) => grade.run(),
        Task::Batch(batch) => batch.run(),
        Task::View(view) => view.run(),
        Task::Snap(snap) => snap.run(),
        Task::Send(send) => send.run(),
        Task::Playground(playground) => playground.run(),
        Task::Eye(eye) => eye.run(),
        Task::Man(man) => man.run(),
        Task::Completions(completions) => completions.run(),
    };
    output::ended(status).into()
}

/// Checks that the folder of a file to be written exists.
fn check_folder(path: &std::path::Path) -> Result<(), String> {
    match crate::save::missing_folder(path) {
        Some(folder) => Err(format!("{}: there is no folder {}", path.display(), folder.display())),
        None => Ok(()),
    }
}

/// Checks that a picture can be written: its name's extension, and that its folder exists.
fn check_picture(path: &std::path::Path) -> Result<(), String> {
    crate::save::SnapshotFormat::of_path(path).map_err(|e| e.to_string())?;
    check_folder(path)
}

/// Prints a line on stderr. Errors of writing are ignored.
pub(crate) fn say(line: &str) {
    progress::clear_line();
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Prints a message on stderr, after the program's name.
pub(crate) fn say_as_program(message: impl std::fmt::Display) {
    say(&format!("fbptr: {message}"));
}

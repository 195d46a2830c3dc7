//! `fbptr run`: runs a program that draws on the Linux framebuffer device, with an emulated one; or
//! one that shows a picture by GLUT, on the same device.
//!
//! Exit status: the program's own, 128 + n if signal n ended it; with `--expect` 0 for an equal and
//! 1 for a different picture, and 1 if a file could not be written; 0 if `--after` ended the
//! program; 2 for invalid arguments, 126 for a program that cannot be served, 127 for one that is
//! not there.

#[cfg(fbptr_preload)]
mod after;
#[cfg(fbptr_preload)]
pub(super) mod family;
#[cfg(fbptr_preload)]
mod glut;
#[cfg(fbptr_preload)]
mod input;
#[cfg(fbptr_preload)]
mod picture;
#[cfg(fbptr_preload)]
mod program;
#[cfg(fbptr_preload)]
mod replay;
#[cfg(fbptr_preload)]
mod session;
#[cfg(fbptr_preload)]
mod spawn;
#[cfg(fbptr_preload)]
mod told;

use super::args::crt::CrtArgs;
use super::expect::ExpectArgs;
use super::movie::MovieArgs;
use super::web::WebArgs;
use super::{FrameSize, Status, say_as_program};
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;

#[cfg(fbptr_preload)]
pub(super) use after::{After, time_of};
#[cfg(fbptr_preload)]
pub(super) use spawn::{find, started};

/// Run a program that draws on /dev/fb0.
#[derive(Debug, Args)]
pub struct RunProgram {
    #[command(flatten)]
    run: Run,
    /// The program and its arguments, after --
    #[arg(last = true, required = true, value_name = "PROGRAM ARGS")]
    program: Vec<OsString>,
}

/// How a program is run.
#[derive(Debug, Args)]
pub struct Run {
    /// The frame's size, and the largest mode of the framebuffer
    #[arg(long, value_name = "WxH")]
    size: Option<FrameSize>,
    /// Pixel format of the framebuffer until the program sets another: bgrx, rgba, bgra, rgbx,
    /// xrgb, xbgr, argb, abgr, bgr24, rgb24, rgb565, bgr565, rgb555, bgr555, pal8, gray8, pal4,
    /// pal2, mono
    #[arg(long, value_name = "FORMAT", default_value = "bgrx")]
    format: String,
    /// Bytes of a row of the framebuffer, where that is more than its pixels need: a program that
    /// computes the length itself draws a slanted picture, as on hardware with padded rows
    #[arg(long, value_name = "BYTES", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1 << 24))]
    line_length: u32,
    /// Vertical blanks a second
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1000))]
    hz: u32,
    /// Open no window
    #[arg(long)]
    headless: bool,
    /// Take the picture and end the program after a time (2s, 500ms), at the N-th frame that
    /// differs from the one before (30), or when the picture has not changed for a time (still for
    /// 500ms, still:TIME)
    #[arg(long, value_name = "TIME|N|still")]
    after: Option<String>,
    /// End the program after this time at the latest: the picture is taken as it then is, and the
    /// status is 124 [default: 60s with --after still, else none]
    #[arg(long, value_name = "TIME")]
    limit: Option<String>,
    /// Write the frame as it stands at the end: .png, .ppm or .raw
    #[arg(long, value_name = "OUT")]
    snap: Option<PathBuf>,
    #[command(flatten)]
    expect: ExpectArgs,
    /// Replay input from a file of lines TIME EVENT: key down|up NAME, press NAME, type TEXT, mouse X Y BUTTONS, wheel
    /// DX DY. Times count from the program's first opening of the framebuffer, as in 1.5s press
    /// left
    #[arg(long, value_name = "FILE")]
    keys: Option<PathBuf>,
    /// Type a text once the program's picture has been still for half a second
    #[arg(long = "type", value_name = "TEXT")]
    text: Option<String>,
    /// Listen on a TCP address for clients of the protocol, any number of times; :PORT or PORT is
    /// loopback
    #[arg(long, value_name = "ADDR")]
    serve: Vec<String>,
    /// Let --serve and --web take addresses that other machines reach
    #[arg(long)]
    allow_remote: bool,
    /// Keep the fourth byte of 32-bit pixels as the picture's alpha; without it, pictures of formats
    /// that do not say otherwise, and of programs of GLUT, are opaque
    #[arg(long)]
    alpha: bool,
    /// The program is one that starts another one which is linked with GLUT, as a debugger or make
    /// does; by default the program itself is looked at
    #[arg(long)]
    glut: bool,
    /// Leave what the program started in a session of its own (daemons) alive at the end; by
    /// default nothing of a run outlives it
    #[arg(long)]
    leave_daemons: bool,
    /// Say which requests of the program the device does not have
    #[arg(long)]
    verbose: bool,
    #[command(flatten)]
    web: WebArgs,
    #[command(flatten)]
    crt: CrtArgs,
    #[command(flatten)]
    movie: MovieArgs,
    /// The program and its arguments
    #[arg(skip)]
    #[cfg_attr(not(fbptr_preload), expect(dead_code, reason = "no program runs"))]
    program: Vec<OsString>,
    /// The folder that it runs in, if that is another one
    #[arg(skip)]
    #[cfg_attr(not(fbptr_preload), expect(dead_code, reason = "no program runs"))]
    folder: Option<PathBuf>,
}

/// Reason for which nothing is run, and the exit status.
#[derive(Debug)]
#[cfg_attr(not(fbptr_preload), expect(dead_code, reason = "there is no program to refuse"))]
pub(super) struct Refusal {
    pub status: u8,
    pub message: String,
}

impl RunProgram {
    /// Runs the program to its end.
    pub(super) fn run(self) -> Status {
        Run { program: self.program, ..self.run }.start()
    }
}

/// Returns whether a file is a program that is linked with GLUT.
#[cfg(fbptr_preload)]
pub(super) fn is_glut_program(path: &std::path::Path) -> bool {
    !glut::names(path).is_empty()
}

/// Removes the folder of links that a run leaves if it is ended by force.
#[cfg(fbptr_preload)]
pub(super) fn remove_left_by(pid: u32) {
    glut::remove_left_by(pid);
}

impl Run {
    /// Runs a program in a folder to its end. Pictures and other files are named from the folder
    /// that `fbptr` was started in.
    pub(super) fn run_in(self, folder: &std::path::Path, program: OsString, words: Vec<OsString>) -> Status {
        let program = std::iter::once(program).chain(words).collect();
        Run { program, folder: Some(folder.to_owned()), ..self }.start()
    }

    fn start(self) -> Status {
        #[cfg(fbptr_preload)]
        match session::run(&self) {
            Ok(status) => status,
            Err(Refusal { status, message }) => {
                say_as_program(message);
                Status::Program(status)
            }
        }
        #[cfg(not(fbptr_preload))]
        {
            say_as_program("run: the framebuffer device is emulated on Linux with the GNU C library only");
            Status::Program(126)
        }
    }
}

//! Starting the program: in a session of its own, whose terminal is a pseudo terminal, with the
//! preload library.
//!
//! `fbptr` starts itself under another name ([`STARTER`]), and makes the session there: between
//! `fork` and `exec` only the standard library's own code runs.

use super::super::{Status, say_as_program};
use super::program;
use crate::fbdev::Device;
use rustix::process::{
    Pid, Signal, ioctl_tiocsctty, kill_process, kill_process_group, set_parent_process_death_signal, setsid,
};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};
use std::ffi::{OsStr, OsString};
use std::fs::{File, OpenOptions};
use std::io::{self, IsTerminal, Read};
use std::os::unix::ffi::OsStringExt;
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

/// Name under which `fbptr` starts itself.
const STARTER: &str = "fbptr-run-starter";
/// Environment variable that names the preload library to the starter.
const LIBRARY: &str = "FBPTR_RUN_LIBRARY";
/// Size of a character of the console in pixels.
const CELL: [u32; 2] = [8, 16];

/// The pseudo terminal that is the program's console.
#[derive(Debug)]
pub struct Terminal {
    master: File,
    /// Keeps the terminal when the program has none of its descriptors open.
    _slave: File,
    path: PathBuf,
}

impl Terminal {
    /// Opens a pseudo terminal with as many characters as the frame has room for. Its output is
    /// read and dropped: the program's picture is its framebuffer.
    ///
    /// # Errors
    /// If the system has none.
    pub fn open(size: (u32, u32)) -> io::Result<Terminal> {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let path = PathBuf::from(OsString::from_vec(ptsname(&master, Vec::new())?.into_bytes()));
        let slave = open_terminal(&path, rustix::fs::OFlags::NOCTTY)?;
        let cells = |pixels: u32, cell: u32| (pixels / cell).clamp(1, 999) as u16;
        let (ws_col, ws_row) = (cells(size.0, CELL[0]), cells(size.1, CELL[1]));
        let pixels = |n: u32| n.min(u16::MAX.into()) as u16;
        let (ws_xpixel, ws_ypixel) = (pixels(size.0), pixels(size.1));
        tcsetwinsize(&master, Winsize { ws_row, ws_col, ws_xpixel, ws_ypixel })?;
        let master = File::from(master);
        let mut output = master.try_clone()?;
        std::thread::Builder::new().name("console".into()).spawn(move || {
            let mut dropped = [0; 4096];
            while output.read(&mut dropped).is_ok_and(|n| n > 0) {}
        })?;
        Ok(Terminal { master, _slave: slave, path })
    }

    /// Returns the side that the program's input is written to.
    pub fn master(&self) -> &File {
        &self.master
    }

    /// Returns the path of the terminal.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the number of the terminal, as in `/dev/pts/NUMBER`.
    pub fn number(&self) -> Option<u32> {
        self.path.file_name()?.to_str()?.parse().ok()
    }
}

fn open_terminal(path: &Path, flags: rustix::fs::OFlags) -> io::Result<File> {
    OpenOptions::new().read(true).write(true).custom_flags(flags.bits() as i32).open(path)
}

/// Starts a program. To be called on the main thread: the program ends with the thread that has
/// started it.
///
/// # Errors
/// If the system refuses.
pub fn spawn(program: &Path, words: &[OsString], device: &Device, terminal: &Path) -> io::Result<Child> {
    let (name, value) = device.environment()?;
    let mut command = Command::new("/proc/self/exe");
    command.arg0(STARTER).arg(terminal).arg(program).args(words);
    command.env(name, value).env(LIBRARY, device.library_path());
    command.spawn()
}

/// Runs the program, if this process is the starter, and returns its status.
pub fn started() -> Option<Status> {
    let mut words = std::env::args_os();
    if words.next()? != STARTER {
        return None;
    }
    let (terminal, program, name) = (words.next()?, words.next()?, words.next()?);
    match start(terminal.as_ref(), program.as_ref(), &name, words.collect()) {
        Ok(status) => Some(status_of(status)),
        Err(error) => {
            say_as_program(format_args!("{}: {error}", program.display()));
            Some(Status::Program(if error.kind() == io::ErrorKind::NotFound { 127 } else { 126 }))
        }
    }
}

/// Makes the session, starts the program in it, and waits for its end. The starter leads the
/// session, as a shell does on a console: a program that gives its terminal up, as SDL does, would
/// end itself by that if it did.
fn start(terminal: &Path, program: &Path, name: &OsStr, words: Vec<OsString>) -> io::Result<ExitStatus> {
    // If `fbptr` ends, whatever its reason, the session's end is a hang-up for the program.
    set_parent_process_death_signal(Some(Signal::KILL))?;
    setsid()?;
    let console = open_terminal(terminal, rustix::fs::OFlags::empty())?;
    ioctl_tiocsctty(&console)?;
    // Signals to the whole group are for the program; handlers do not outlive `exec`.
    ctrlc::set_handler(|| ()).map_err(io::Error::other)?;
    let mut command = Command::new(program);
    command.arg0(name).args(words);
    if io::stdin().is_terminal() {
        command.stdin(Stdio::from(console));
    }
    let library = std::env::var_os(LIBRARY).unwrap_or_default();
    let preloaded = match std::env::var_os("LD_PRELOAD").filter(|others| !others.is_empty()) {
        Some(others) => [library, others].join(OsStr::new(":")),
        None => library,
    };
    command.env("LD_PRELOAD", preloaded).env_remove(LIBRARY).spawn()?.wait()
}

/// Returns the exit status that stands for a program's, as shells have it.
pub fn status_of(status: ExitStatus) -> Status {
    match (status.code(), status.signal()) {
        (Some(code), _) => Status::Program(code as u8),
        (None, signal) => Status::Program((128 + signal.unwrap_or(0)) as u8),
    }
}

/// Sends a signal to the program and its children, or to the starter before it has a group.
pub fn end_program(pid: Pid, signal: Signal) {
    if kill_process_group(pid, signal).is_err() {
        let _ = kill_process(pid, signal);
    }
}

/// Finds the program that the arguments name.
pub fn find(words: &[OsString]) -> Result<PathBuf, super::Refusal> {
    program::find(words.first().map_or(OsStr::new(""), |name| name))
}

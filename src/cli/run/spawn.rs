//! Starting the program: in a session of its own, whose terminal is a pseudo terminal, with the
//! preload library; and its end, with all that it has started.
//!
//! `fbptr` starts itself under another name ([`STARTER`]), and makes the session there: between
//! `fork` and `exec` only the standard library's own code runs.

use super::super::{Status, say_as_program};
use super::family::{self, Members, MemoryFile};
use super::glut::{self, Libraries};
use super::program;
use crate::fbdev::{Device, ENVIRONMENT, TERMINALS};
use crossbeam_channel::{Receiver, bounded};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::process::{Pid, WaitOptions, getpid, ioctl_tiocsctty, set_child_subreaper, setsid, wait};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};
use std::ffi::{OsStr, OsString};
use std::fs::{File, OpenOptions};
use std::io::{self, IsTerminal, PipeReader, PipeWriter, Read};
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStringExt;
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Name under which `fbptr` starts itself.
const STARTER: &str = "fbptr-run-starter";
/// Environment variable that names the preload library to the starter.
const LIBRARY: &str = "FBPTR_RUN_LIBRARY";
/// Environment variable that names a folder which the starter removes at the end.
const FOLDER: &str = "FBPTR_RUN_FOLDER";
/// Word that tells the starter to leave daemons alive.
const LEAVE: &str = "leave-daemons";
/// Time between two looks at children that draw after the program's own end.
const LOOK: Duration = Duration::from_millis(20);
/// Time that children have to open the framebuffer after the program's own end, if nobody has before.
const OPENS_WITHIN: Duration = Duration::from_secs(5);
/// Size of a character of the console in pixels.
const CELL: [u32; 2] = [8, 16];

/// A pseudo terminal that stands for a virtual terminal.
#[derive(Debug)]
struct Terminal {
    master: File,
    /// Keeps the terminal when the program has none of its descriptors open.
    _slave: File,
    path: PathBuf,
}

impl Terminal {
    fn open(size: Winsize) -> io::Result<Terminal> {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let path = PathBuf::from(OsString::from_vec(ptsname(&master, Vec::new())?.into_bytes()));
        let slave = open_terminal(&path, rustix::fs::OFlags::NOCTTY)?;
        tcsetwinsize(&master, size)?;
        Ok(Terminal { master: master.into(), _slave: slave, path })
    }
}

/// The program's virtual terminals. The first one is its controlling terminal.
#[derive(Clone, Debug)]
pub struct Terminals {
    all: Arc<[Terminal]>,
    active: Arc<AtomicUsize>,
}

impl Terminals {
    /// Opens pseudo terminals with as many characters as the frame has room for. Their output is
    /// read and dropped: the program's picture is its framebuffer.
    ///
    /// # Errors
    /// If the system has none.
    pub fn open(size: (u32, u32)) -> io::Result<Terminals> {
        let cells = |pixels: u32, cell: u32| (pixels / cell).clamp(1, 999) as u16;
        let (ws_col, ws_row) = (cells(size.0, CELL[0]), cells(size.1, CELL[1]));
        let pixels = |n: u32| n.min(u16::MAX.into()) as u16;
        let (ws_xpixel, ws_ypixel) = (pixels(size.0), pixels(size.1));
        let size = Winsize { ws_row, ws_col, ws_xpixel, ws_ypixel };
        let all = (0..TERMINALS).map(|_| Terminal::open(size)).collect::<io::Result<Arc<[_]>>>()?;
        let read = all.clone();
        std::thread::Builder::new().name("console".into()).spawn(move || drop_output(&read))?;
        Ok(Terminals { all, active: Arc::default() })
    }

    /// Makes a virtual terminal, from 1, the one that has the keyboard: the first one, if a program
    /// has written another number than there is.
    pub fn activate(&self, number: u32) {
        let index = (number as usize).wrapping_sub(1);
        self.active.store(if index < TERMINALS { index } else { 0 }, Ordering::Relaxed);
    }

    /// Returns the side of the active terminal that the program's input is written to.
    pub fn master(&self) -> &File {
        &self.all[self.active.load(Ordering::Relaxed)].master
    }

    /// Returns the path of the controlling terminal.
    pub fn path(&self) -> &Path {
        &self.all[0].path
    }

    /// Returns the numbers of the terminals, as in `/dev/pts/NUMBER`.
    pub fn numbers(&self) -> impl Iterator<Item = Option<u32>> {
        self.all.iter().map(|terminal| terminal.path.file_name()?.to_str()?.parse().ok())
    }
}

/// Reads what is written to the terminals until that fails.
fn drop_output(terminals: &[Terminal]) {
    let mut dropped = [0; 4096];
    loop {
        let mut ready: Vec<PollFd> =
            terminals.iter().map(|terminal| PollFd::new(&terminal.master, PollFlags::IN)).collect();
        match poll(&mut ready, None) {
            Err(Errno::INTR) => continue,
            Err(_) => return,
            Ok(_) => {}
        }
        for (terminal, state) in terminals.iter().zip(&ready) {
            if !state.revents().is_empty() && (&terminal.master).read(&mut dropped).is_err() {
                return;
            }
        }
    }
}

fn open_terminal(path: &Path, flags: rustix::fs::OFlags) -> io::Result<File> {
    OpenOptions::new().read(true).write(true).custom_flags(flags.bits() as i32).open(path)
}

/// A program that was started, and the end of a pipe by which it is ended.
#[derive(Debug)]
pub struct Started {
    /// The starter.
    pub child: Child,
    /// Tells the starter by its end, however that comes, to end the run.
    pub leash: Leash,
}

/// A pipe that nothing is written to: the starter reads its end.
#[derive(Debug)]
pub struct Leash {
    _writer: PipeWriter,
    /// The starter opens this side by its path.
    reader: PipeReader,
}

/// Returns the value of a variable that lists paths, with another one before it.
fn before(first: impl Into<OsString>, variable: &str) -> OsString {
    match std::env::var_os(variable).filter(|others| !others.is_empty()) {
        Some(others) => [first.into(), others].join(OsStr::new(":")),
        None => first.into(),
    }
}

/// Starts a program, in a folder, whose loader looks into that of `libraries` first; `leaves_daemons` if processes that made a session of their own are not ended
/// with it.
///
/// # Errors
/// If the system refuses.
pub fn spawn(
    program: &Path,
    words: &[OsString],
    device: &Device,
    terminal: &Path,
    libraries: Option<&Libraries>,
    folder: Option<&Path>,
    leaves_daemons: bool,
) -> io::Result<Started> {
    let (name, value) = device.environment()?;
    let (reader, writer) = io::pipe()?;
    let leash = Leash { _writer: writer, reader };
    // If a program kills the starter, its orphans are ours.
    set_child_subreaper(Some(getpid()))?;
    let mut command = Command::new("/proc/self/exe");
    command.arg0(STARTER).arg(terminal).arg(leash.path());
    command.arg(if leaves_daemons { LEAVE } else { "" }).arg(program).args(words);
    command.env(name, value).env(LIBRARY, device.library_path());
    folder.iter().for_each(|folder| _ = command.current_dir(folder));
    if let Some(libraries) = libraries {
        command
            .env(FOLDER, libraries.path())
            .env("LD_LIBRARY_PATH", before(libraries.path(), "LD_LIBRARY_PATH"));
    }
    Ok(Started { child: command.spawn()?, leash })
}

impl Leash {
    fn path(&self) -> String {
        format!("/proc/{}/fd/{}", std::process::id(), self.reader.as_raw_fd())
    }
}

/// Runs the program, if this process is the starter, and returns its status.
pub fn started() -> Option<Status> {
    let mut words = std::env::args_os();
    if words.next()? != STARTER {
        return None;
    }
    let (terminal, leash, leaves) = (words.next()?, words.next()?, words.next()?);
    let (program, name) = (words.next()?, words.next()?);
    let mut command = Command::new(&program);
    command.arg0(name).args(words);
    match start(terminal.as_ref(), leash.as_ref(), leaves == LEAVE, command) {
        Ok(status) => Some(status_of(status)),
        Err(error) => {
            say_as_program(format_args!("{}: {error}", program.display()));
            Some(Status::Program(if error.kind() == io::ErrorKind::NotFound { 127 } else { 126 }))
        }
    }
}

/// Makes the session, starts the program in it, and attends it to its end. The starter leads the
/// session, as a shell does on a console: a program that gives its terminal up, as SDL does, would
/// end itself by that if it did.
fn start(
    terminal: &Path,
    leash: &Path,
    leaves_daemons: bool,
    mut command: Command,
) -> io::Result<ExitStatus> {
    let leash = File::open(leash).map_err(|e| io::Error::other(format!("fbptr has ended: {e}")))?;
    setsid()?;
    set_child_subreaper(Some(getpid()))?;
    let console = open_terminal(terminal, rustix::fs::OFlags::empty())?;
    ioctl_tiocsctty(&console)?;
    // Signals to the whole group are for the program; handlers do not outlive `exec`.
    ctrlc::set_handler(|| ()).map_err(io::Error::other)?;
    if io::stdin().is_terminal() {
        command.stdin(Stdio::from(console));
    }
    let library = std::env::var_os(LIBRARY).unwrap_or_default();
    let preloaded = before(library, "LD_PRELOAD");
    let child = command.env("LD_PRELOAD", preloaded).env_remove(LIBRARY).env_remove(FOLDER).spawn();
    let members = if leaves_daemons { Members::Session(getpid()) } else { Members::All };
    let status = child.and_then(|child| attend(Pid::from_child(&child), leash, members));
    if let Some(folder) = std::env::var_os(FOLDER) {
        glut::remove(folder.as_ref());
    }
    status
}

/// Processes that the starter waits for.
enum Event {
    /// The program has ended.
    Exited(ExitStatus),
    /// The run is to end.
    Ordered,
}

/// Attends the program to its end, or until it is to be ended. A program whose children draw on, as
/// `fbi -T 1` does, has not ended before they have. Returns the program's own status once nothing
/// of the run is left.
fn attend(program: Pid, leash: File, members: Members) -> io::Result<ExitStatus> {
    let memory = std::env::var(ENVIRONMENT).ok().and_then(|value| MemoryFile::from_environment(&value));
    let is_drawing = |ended: Instant| {
        let left = family::below(members);
        let may_draw = |memory: MemoryFile| !memory.was_opened() && ended.elapsed() < OPENS_WITHIN;
        !left.is_empty()
            && memory.is_some_and(|memory| {
                left.iter().any(|process| memory.is_held_by(process)) || may_draw(memory)
            })
    };
    let events = watch(program, leash)?;
    let (mut status, mut ended) = (None, Instant::now());
    loop {
        let event = match status {
            None => events.recv().ok(),
            Some(_) => events.recv_timeout(LOOK).ok(),
        };
        match event {
            Some(Event::Exited(exit)) => (status, ended) = (Some(exit), Instant::now()),
            Some(Event::Ordered) => break,
            None => {}
        }
        if !is_drawing(ended) {
            break;
        }
    }
    let left = family::end(members);
    if !left.is_empty() {
        let pids: Vec<String> = left.iter().map(|process| process.pid.to_string()).collect();
        say_as_program(format_args!("processes that cannot be ended are left: {}", pids.join(", ")));
    }
    let exit = |event| match event {
        Event::Exited(exit) => Some(exit),
        Event::Ordered => None,
    };
    let mut later = std::iter::from_fn(|| events.recv_timeout(family::PATIENCE).ok());
    status.or_else(|| later.find_map(exit)).ok_or_else(|| io::Error::other("it cannot be ended"))
}

/// Starts the threads that tell when the program has ended, and when the run is to end.
fn watch(program: Pid, mut leash: File) -> io::Result<Receiver<Event>> {
    let (told, events) = bounded(2);
    let orders = told.clone();
    std::thread::Builder::new().name("leash".into()).spawn(move || {
        // Nothing is ever written: this returns at the pipe's end.
        let _ = leash.read(&mut [0]);
        let _ = orders.send(Event::Ordered);
    })?;
    std::thread::Builder::new().name("children".into()).spawn(move || {
        loop {
            match wait(WaitOptions::empty()) {
                Ok(Some((pid, status))) if pid == program => {
                    let _ = told.send(Event::Exited(ExitStatus::from_raw(status.as_raw())));
                }
                // An orphan that has ended.
                Ok(_) | Err(Errno::INTR) => {}
                Err(_) => return,
            }
        }
    })?;
    Ok(events)
}

/// Returns the exit status that stands for a program's, as shells have it.
pub fn status_of(status: ExitStatus) -> Status {
    match (status.code(), status.signal()) {
        (Some(code), _) => Status::Program(code as u8),
        (None, signal) => Status::Program((128 + signal.unwrap_or(0)) as u8),
    }
}

/// Finds the program that the arguments name.
pub fn find(words: &[OsString]) -> Result<PathBuf, super::Refusal> {
    program::find(words.first().map_or(OsStr::new(""), |name| name))
}

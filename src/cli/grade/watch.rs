//! A program under limits: its end, what it printed, and nothing of it left.
//!
//! In: a command, and limits of time, memory, processes and output. Out: a [`Watched`]. All that the
//! command starts is looked at some times a second: the memory of its own that it has (no shared
//! memory, as the framebuffer's is), and the number of its processes. Processes of `fbptr` itself,
//! which run the program, do not count. Right is: whatever the program does, the call returns soon
//! after the limit, and no process of it is left.

use super::super::run::family::{self, Members, Process};
use super::super::signals;
use rustix::process::{WaitOptions, getpid, set_child_subreaper, wait};
use std::collections::VecDeque;
use std::fs;
use std::io::{self, Read};
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(20);
/// Time that `fbptr run` has to end in order once its program is gone.
const ORDER: Duration = Duration::from_secs(3);
/// Bytes of standard error that are kept.
const KEPT_FIRST: usize = 1 << 18;
const KEPT_LAST: usize = 4096;

/// Limits of a program.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub time: Duration,
    /// Bytes of memory of its own, over all of its processes.
    pub memory: u64,
    pub processes: usize,
    /// Bytes of standard output that are kept; more end the program if `ends_by_output`.
    pub output: usize,
    pub ends_by_output: bool,
    /// Standard error that is kept.
    pub said: Said,
}

/// Part of standard error that is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Said {
    /// The first bytes: a compiler's first error explains the others.
    First,
    /// The last bytes: why a program has ended.
    Last,
}

/// End of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    Exited(ExitStatus),
    Time,
    Memory,
    Processes,
    Output,
    /// This process is to end.
    Signal,
}

/// Set when a signal has asked this process to end.
static IS_OVER: AtomicBool = AtomicBool::new(false);

/// Lets SIGINT and SIGTERM end the program that is run, and then this process in order.
///
/// # Errors
/// If the system lets no handler be set.
pub fn watch_signals() -> Result<(), String> {
    signals::watch(|| IS_OVER.store(true, Ordering::Release))
}

/// Returns whether this process is to end.
pub fn is_over() -> bool {
    IS_OVER.load(Ordering::Acquire)
}

/// Output that a program left.
#[derive(Debug)]
pub struct Watched {
    /// Number of the process that was run.
    pub pid: u32,
    pub end: End,
    pub stdout: Vec<u8>,
    /// The first or last bytes of standard error.
    pub stderr: Vec<u8>,
}

/// Runs a command to its end or to a limit.
///
/// # Errors
/// If the system does not start it.
pub fn run(command: &mut Command, limits: Limits) -> io::Result<Watched> {
    // What the program leaves behind is then below this process.
    set_child_subreaper(Some(getpid()))?;
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).process_group(0);
    let mut child = command.spawn()?;
    let printed = Arc::new(AtomicU64::new(0));
    let stdout = collect(child.stdout.take(), limits.output, true, printed.clone());
    let is_first = limits.said == Said::First;
    let kept = if is_first { KEPT_FIRST } else { KEPT_LAST };
    let stderr = collect(child.stderr.take(), kept, is_first, Arc::default());
    let look = Look::new();
    let started = Instant::now();
    let end = loop {
        if let Some(status) = child.try_wait()? {
            break End::Exited(status);
        }
        let is_full = printed.load(Ordering::Relaxed) > limits.output as u64;
        if started.elapsed() > limits.time {
            break End::Time;
        }
        if is_over() {
            break End::Signal;
        }
        if is_full && limits.ends_by_output {
            break End::Output;
        }
        if let Some(end) = look.over(limits) {
            break end;
        }
        std::thread::sleep(LOOK);
    };
    if !matches!(end, End::Exited(_)) {
        look.end(&mut child);
    }
    family::kill(Members::All);
    // Its orphans that have ended are this process's.
    let _ = child.wait();
    while let Ok(Some(_)) = wait(WaitOptions::NOHANG) {}
    let take = |bytes: Receiver<Vec<u8>>| bytes.recv_timeout(ORDER).unwrap_or_default();
    Ok(Watched { pid: child.id(), end, stdout: take(stdout), stderr: take(stderr) })
}

/// Reads a pipe to its end on a thread of its own, and keeps its first or last bytes.
fn collect(
    pipe: Option<impl Read + Send + 'static>,
    kept: usize,
    is_first: bool,
    count: Arc<AtomicU64>,
) -> Receiver<Vec<u8>> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let (mut bytes, mut buffer) = (VecDeque::new(), vec![0; 1 << 16]);
        let Some(mut pipe) = pipe else { return };
        while let Ok(len @ 1..) = pipe.read(&mut buffer) {
            count.fetch_add(len as u64, Ordering::Relaxed);
            let room = if is_first { kept - bytes.len().min(kept) } else { len };
            bytes.extend(&buffer[..len.min(room)]);
            if !is_first && bytes.len() > kept {
                bytes.drain(..bytes.len() - kept);
            }
        }
        let _ = sender.send(bytes.into());
    });
    receiver
}

/// Looks at the processes of a program.
struct Look {
    own: Option<PathBuf>,
}

impl Look {
    fn new() -> Look {
        Look { own: fs::read_link("/proc/self/exe").ok() }
    }

    /// Returns the program's processes.
    fn processes(&self) -> Vec<Process> {
        let is_own = |process: &Process| {
            self.own.is_some() && fs::read_link(format!("/proc/{}/exe", process.pid)).ok() == self.own
        };
        let mut found = family::below(Members::All);
        found.retain(|process| !is_own(process));
        found
    }

    /// Returns the limit that the program is over.
    fn over(&self, limits: Limits) -> Option<End> {
        let processes = self.processes();
        if processes.len() > limits.processes {
            return Some(End::Processes);
        }
        let bytes: u64 = processes.iter().map(own_memory).sum();
        (bytes > limits.memory).then_some(End::Memory)
    }

    /// Ends the program; what runs it has time to end in order.
    fn end(&self, child: &mut Child) {
        let begun = Instant::now();
        while begun.elapsed() < ORDER && matches!(child.try_wait(), Ok(None)) {
            let left = self.processes();
            family::kill_groups(&left);
            std::thread::sleep(if left.is_empty() { LOOK } else { Duration::ZERO });
        }
    }
}

/// Returns the bytes of memory that a process shares with no file and no other process's memory.
fn own_memory(process: &Process) -> u64 {
    let text = fs::read_to_string(format!("/proc/{}/status", process.pid)).unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("RssAnon:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kilobytes.unwrap_or(0) * 1024
}

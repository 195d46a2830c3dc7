//! The processes of a run: all that the program has started, whatever their group or session.
//!
//! A process that takes over its descendants' orphans (`PR_SET_CHILD_SUBREAPER`) has all of them
//! below itself in the tree of `/proc/PID/stat`. The starter is one, and `fbptr` another, which
//! ends what is left if a program kills the starter.

use crate::fbdev::OPENS_AT;
use rustix::process::{Pid, Signal, getpgrp, kill_process, kill_process_group};
use std::collections::{HashMap, HashSet};
use std::fs;
use std::os::unix::fs::{FileExt, MetadataExt};
use std::time::{Duration, Instant};

/// Time that a process has after SIGTERM before SIGKILL, and after SIGKILL before it is given up.
pub const PATIENCE: Duration = Duration::from_secs(2);
/// Time between two looks at the processes that are to end.
const LOOK: Duration = Duration::from_millis(10);

/// A process as `/proc` has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Process {
    pub pid: Pid,
    parent: Option<Pid>,
    group: Option<Pid>,
    /// The process that leads its session.
    session: Option<Pid>,
}

/// Processes that a run ends.
#[derive(Clone, Copy, Debug)]
pub enum Members {
    /// All below this process.
    All,
    /// Those of this session alone: daemons are left.
    Session(Pid),
}

impl Members {
    fn contains(self, process: &Process) -> bool {
        match self {
            Members::All => true,
            Members::Session(leader) => process.session == Some(leader),
        }
    }
}

/// Returns the members below this process that have not ended.
pub fn below(members: Members) -> Vec<Process> {
    let mut found = descendants(rustix::process::getpid(), &processes());
    found.retain(|process| members.contains(process));
    found
}

/// Returns all processes that have not ended.
fn processes() -> Vec<Process> {
    let Ok(entries) = fs::read_dir("/proc") else { return Vec::new() };
    let of = |name: &str| {
        let pid = Pid::from_raw(name.parse().ok()?)?;
        process(pid, &fs::read_to_string(format!("/proc/{name}/stat")).ok()?)
    };
    entries.filter_map(|entry| of(entry.ok()?.file_name().to_str()?)).collect()
}

/// Reads a process's line `PID (NAME) STATE PARENT GROUP SESSION ...`; `None` if it has ended. The
/// name may have spaces and brackets in it.
fn process(pid: Pid, line: &str) -> Option<Process> {
    let mut words = line.rsplit_once(')')?.1.split_ascii_whitespace();
    if matches!(words.next()?, "Z" | "X") {
        return None;
    }
    let mut number = |skipped: usize| Some(Pid::from_raw(words.nth(skipped)?.parse().ok()?));
    Some(Process { pid, parent: number(0)?, group: number(0)?, session: number(0)? })
}

/// Returns the processes below `root`.
fn descendants(root: Pid, all: &[Process]) -> Vec<Process> {
    let mut children: HashMap<Option<Pid>, Vec<Process>> = HashMap::new();
    all.iter().for_each(|process| children.entry(process.parent).or_default().push(*process));
    let mut found: Vec<Process> = Vec::new();
    let mut parents = vec![root];
    while let Some(parent) = parents.pop() {
        // A list that was read while processes came and went might have a circle: none is taken twice.
        let new = children.remove(&Some(parent)).unwrap_or_default();
        parents.extend(new.iter().map(|child| child.pid));
        found.extend(new);
    }
    found
}

/// Ends the members below this process: SIGTERM, and SIGKILL for what is left after [`PATIENCE`].
/// Returns those that could not be ended.
pub fn end(members: Members) -> Vec<Process> {
    let (started, mut asked) = (Instant::now(), HashSet::new());
    loop {
        let left = below(members);
        let time = started.elapsed();
        if left.is_empty() || time >= 2 * PATIENCE {
            return left;
        }
        for Process { pid, .. } in left {
            // A signal fails for a process that has just ended, and for one of other rights, which
            // is left at the end.
            if time >= PATIENCE {
                let _ = kill_process(pid, Signal::KILL);
            } else if asked.insert(pid) {
                let _ = kill_process(pid, Signal::TERM);
                // One that is stopped goes on, and sees the signal.
                let _ = kill_process(pid, Signal::CONT);
            }
        }
        std::thread::sleep(LOOK);
    }
}

/// Kills processes with their groups, unless that is this process's own: a group is killed at once,
/// so that processes which start others faster than they are found end, too.
pub fn kill_groups(processes: &[Process]) {
    let own = Some(getpgrp());
    let groups: HashSet<Pid> = processes.iter().filter_map(|p| p.group.filter(|_| p.group != own)).collect();
    // A signal fails for what has just ended.
    groups.into_iter().for_each(|group| _ = kill_process_group(group, Signal::KILL));
    processes.iter().for_each(|process| _ = kill_process(process.pid, Signal::KILL));
}

/// Kills the members below this process, without asking them, until there are none; gives up after
/// twice [`PATIENCE`].
pub fn kill(members: Members) {
    let started = Instant::now();
    loop {
        let left = below(members);
        if left.is_empty() || started.elapsed() >= 2 * PATIENCE {
            return;
        }
        kill_groups(&left);
    }
}

/// The device's memory as a file.
#[derive(Clone, Copy, Debug)]
pub struct MemoryFile {
    /// The process of `fbptr` and its descriptor of the control page.
    control: [u64; 2],
    device: u64,
    inode: u64,
}

impl MemoryFile {
    /// Reads the value of the environment variable by which programs find the device:
    /// `PID/CONTROL/MEMORY/DEVICE/INODE`.
    pub fn from_environment(value: &str) -> Option<MemoryFile> {
        let numbers: Vec<u64> = value.split('/').map(str::parse).collect::<Result<_, _>>().ok()?;
        let [pid, control, _, device, inode] = numbers[..] else { return None };
        Some(MemoryFile { control: [pid, control], device, inode })
    }

    /// Returns whether any program has opened the device so far.
    pub fn was_opened(&self) -> bool {
        let mut opens = [0; 4];
        let [pid, control] = self.control;
        let page = fs::File::open(format!("/proc/{pid}/fd/{control}"));
        page.and_then(|page| page.read_exact_at(&mut opens, OPENS_AT as u64)).is_ok() && opens != [0; 4]
    }

    /// Returns whether a process has the memory open or mapped.
    pub fn is_held_by(&self, process: &Process) -> bool {
        let folder = format!("/proc/{}", process.pid);
        let maps = fs::read(format!("{folder}/maps")).unwrap_or_default();
        let is_mapped = String::from_utf8_lossy(&maps).lines().any(|line| {
            let inode = line.split_ascii_whitespace().nth(4).and_then(|word| word.parse::<u64>().ok());
            inode == Some(self.inode) && line.contains("/memfd:fbptr-fb0")
        });
        let is_memory = |file: &fs::Metadata| (file.dev(), file.ino()) == (self.device, self.inode);
        let mut files = fs::read_dir(format!("{folder}/fd")).into_iter().flatten().flatten();
        is_mapped || files.any(|file| fs::metadata(file.path()).is_ok_and(|file| is_memory(&file)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_a_process_is_read_behind_its_name() {
        let pid = Pid::from_raw(7).unwrap();
        let read = |line: &str| process(pid, line);
        let found = read("7 (a) b (c) S 5 6 4 0 -1").unwrap();
        assert_eq!((found.parent, found.session), (Pid::from_raw(5), Pid::from_raw(4)));
        assert_eq!(read("7 (a) Z 5 6 4"), None);
        for broken in ["", "7 (a", "7 (a)", "7 (a) S", "7 (a) S x 1 2", "7 (a) S 1 2"] {
            assert_eq!(read(broken), None, "{broken}");
        }
    }

    #[test]
    fn descendants_are_found_over_generations_and_circles_end() {
        let of = |pid, parent| Process {
            pid: Pid::from_raw(pid).unwrap(),
            parent: Pid::from_raw(parent),
            group: None,
            session: Pid::from_raw(pid),
        };
        let all = [of(5, 3), of(3, 2), of(4, 2), of(9, 1), of(2, 1), of(10, 11), of(11, 10)];
        let pids = |root: i32| {
            let mut found: Vec<i32> = descendants(Pid::from_raw(root).unwrap(), &all)
                .iter()
                .map(|p| p.pid.as_raw_nonzero().get())
                .collect();
            found.sort_unstable();
            found
        };
        assert_eq!(pids(2), [3, 4, 5]);
        assert!(pids(9).is_empty());
        assert_eq!(pids(10), [10, 11]);
    }

    #[test]
    fn the_memory_that_a_process_holds_is_seen_open_and_mapped() {
        let own = Process { pid: rustix::process::getpid(), parent: None, group: None, session: None };
        let file = fs::File::open("/proc/self/exe").unwrap();
        let meta = file.metadata().unwrap();
        let memory = MemoryFile::from_environment(&format!("1/2/3/{}/{}", meta.dev(), meta.ino())).unwrap();
        assert!(memory.is_held_by(&own));
        assert!(!MemoryFile { inode: 1, ..memory }.is_held_by(&own));
        assert!(MemoryFile::from_environment("1/2/3/4").is_none());
    }
}

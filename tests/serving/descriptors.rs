//! Connections for which the system has no file descriptor receive an error, and new ones are
//! served when there is one again.

#![cfg(unix)]

use crate::folder::Folder;
use crate::process::{Process, fbptr, text};
use crate::support::Wire;
use rustix::net::{AddressFamily, SocketAddrUnix, SocketType, bind, connect, listen, socket};
use std::io::{BufRead, BufReader, Read};
use std::net::SocketAddr;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longer than any step of these tests takes; a wait beyond it means a hang.
const HANGS: Duration = Duration::from_secs(30);

/// Starts a server whose limit of open files is set by `ulimit` with these arguments.
fn limited(ulimit: &str) -> Process {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit {ulimit}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_fbptr")]);
    Process::spawn(command, &["--listen", "127.0.0.1:0"])
}

/// Sends `SIZE` and returns the reply line, also that of a refused client.
fn size(wire: &mut Wire) -> String {
    wire.ask("SIZE\n")
}

/// Connects, sends nothing, and returns the first line received.
fn told(address: SocketAddr) -> String {
    let mut told = String::new();
    BufReader::new(Wire::connect(address).0).read_line(&mut told).unwrap();
    told
}

/// Waits until a client is served.
fn until_served(address: SocketAddr) {
    let until = Instant::now() + HANGS;
    loop {
        let mut wire = Wire::connect(address);
        // A refused client may be disconnected before it has sent anything.
        let _ = std::io::Write::write_all(&mut wire.0, b"SIZE\nQUIT\n");
        let mut reply = String::new();
        if wire.0.read_to_string(&mut reply).is_ok() && reply == "SIZE 640 480\n" {
            return;
        }
        assert!(Instant::now() < until, "nobody is let in: {reply}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn connections_beyond_the_descriptors_are_refused_and_the_others_go_on() {
    let mut process = limited("-n 64");
    let warning = process.says();
    let most: usize =
        (|| warning.strip_prefix("fbptr: warning: no more than ")?.split(' ').next()?.parse().ok())()
            .unwrap_or_else(|| panic!("{warning}"));
    assert!(warning.ends_with("in place of 1024: the limit of open files is 64 (ulimit -n)"), "{warning}");
    // One descriptor per connection: with three, less than a third of this would be left.
    assert!((16..64).contains(&most), "{warning}");
    let address = process.address();
    let mut inside: Vec<Wire> = (0..most).map(|_| Wire::connect(address)).collect();
    inside.iter_mut().for_each(|wire| assert_eq!(size(wire), "SIZE 640 480\n"));
    for _ in 0..40 {
        assert!(told(address).starts_with("ERR 0 0 EQUOTA CONNECT: "));
    }
    assert_eq!(process.says(), format!("fbptr: refused a connection: {most} are there, which is the limit"));
    inside.iter_mut().for_each(|wire| assert_eq!(size(wire), "SIZE 640 480\n"));
    inside.truncate(most / 2);
    until_served(address);
    inside.iter_mut().for_each(|wire| assert_eq!(size(wire), "SIZE 640 480\n"));
    assert_eq!(process.ends_after("TERM"), Some(0));
}

#[test]
fn the_soft_limit_is_raised_to_what_the_connections_need() {
    let mut process = limited("-S -n 64");
    let address = process.address();
    let mut inside: Vec<Wire> = (0..200).map(|_| Wire::connect(address)).collect();
    inside.iter_mut().for_each(|wire| assert_eq!(size(wire), "SIZE 640 480\n"));
    assert_eq!(process.ends_after("TERM"), Some(0));
}

/// Returns the number that the next descriptor of a process would get.
#[cfg(target_os = "linux")]
fn next_descriptor(process: &Process) -> u64 {
    let is_open = |n: &u64| std::fs::symlink_metadata(format!("/proc/{}/fd/{n}", process.id())).is_ok();
    (0..).find(|n| !is_open(n)).unwrap()
}

#[test]
#[cfg(target_os = "linux")]
fn without_any_descriptor_clients_are_accepted_refused_and_served_again_later() {
    use rustix::process::{Pid, Resource, Rlimit, prlimit};
    let mut process = Process::start(&["--listen", "127.0.0.1:0"]);
    let address = process.address();
    let mut inside: Vec<Wire> = (0..12).map(|_| Wire::connect(address)).collect();
    inside.iter_mut().for_each(|wire| assert_eq!(size(wire), "SIZE 640 480\n"));
    let pid = Pid::from_raw(process.id() as i32);
    let none = Rlimit { current: Some(next_descriptor(&process)), maximum: None };
    let before = prlimit(pid, Resource::Nofile, Rlimit { maximum: hard_limit(), ..none }).unwrap();
    // A thread blocked in `accept` has its descriptor already: the first client may be served.
    let _first = Wire::connect(address);
    for _ in 0..20 {
        assert_eq!(told(address), "ERR 0 0 EQUOTA CONNECT: the server has no descriptor left for it\n");
    }
    let line = process.says();
    assert!(line.starts_with("fbptr: refused a connection on tcp 127.0.0.1:"), "{line}");
    inside.iter_mut().for_each(|wire| assert_eq!(size(wire), "SIZE 640 480\n"));
    prlimit(pid, Resource::Nofile, before).unwrap();
    until_served(address);
    assert_eq!(process.ends_after("TERM"), Some(0));
}

/// Returns the hard limit of this process, which its children inherit.
#[cfg(target_os = "linux")]
fn hard_limit() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::Nofile).maximum
}

#[test]
#[cfg(target_os = "linux")]
fn a_live_socket_with_a_full_backlog_does_not_stop_the_start() {
    let folder = Folder::new("backlog");
    let path = folder.join("s");
    let address = SocketAddrUnix::new(&path).unwrap();
    let unix = || socket(AddressFamily::UNIX, SocketType::STREAM, None).unwrap();
    let server = unix();
    bind(&server, &address).unwrap();
    listen(&server, 0).unwrap();
    let clients: Vec<_> = std::iter::repeat_with(unix)
        .take_while(|client| {
            rustix::io::ioctl_fionbio(client, true).unwrap();
            connect(client, &address).is_ok()
        })
        .collect();
    assert!(!clients.is_empty());
    let mut child =
        fbptr().args(["serve", "--headless", "--unix", text(&path)]).stderr(Stdio::piped()).spawn().unwrap();
    let until = Instant::now() + HANGS;
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if Instant::now() > until {
            child.kill().unwrap();
            panic!("the start hangs");
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert_eq!(status.code(), Some(2));
    assert!(said.contains("another server answers there"), "{said}");
    assert!(path.exists(), "the live server keeps its socket");
}

//! The server program: signals, socket files, the shared file, recordings, small clients.

#![cfg(unix)]

use crate::folder::Folder;
use crate::support::Wire;
use crate::tools;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::SocketAddr;
use std::os::unix::fs::{FileExt, PermissionsExt};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use std::time::{Duration, Instant};

pub fn fbptr() -> Command {
    Command::new(env!("CARGO_BIN_EXE_fbptr"))
}

/// `fbptr serve` as a process that is killed when the test ends.
pub struct Process {
    child: Child,
    stderr: BufReader<ChildStderr>,
}

impl Process {
    pub fn start(arguments: &[&str]) -> Process {
        Process::spawn(fbptr(), arguments)
    }

    /// [`Process::start`] by a command that runs the program with the arguments that it is given.
    pub fn spawn(mut command: Command, arguments: &[&str]) -> Process {
        let mut child = command
            .args(["serve", "--headless"])
            .args(arguments)
            .stdin(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let stderr = BufReader::new(child.stderr.take().unwrap());
        Process { child, stderr }
    }

    /// Returns the next line of its standard error.
    pub fn says(&mut self) -> String {
        let mut line = String::new();
        self.stderr.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    }

    /// Reads the line that names the TCP address it listens on.
    pub fn address(&mut self) -> SocketAddr {
        let line = self.says();
        line.strip_prefix("fbptr: listening on tcp ").unwrap_or_else(|| panic!("{line}")).parse().unwrap()
    }

    pub fn id(&self) -> u32 {
        self.child.id()
    }

    fn signal(&self, name: &str) {
        let pid = self.child.id().to_string();
        assert!(Command::new("sh").args(["-c", "kill -s $0 $1", name, &pid]).status().unwrap().success());
    }

    /// Returns the exit status, as [`Process::ends_after`], and the rest of its standard error.
    fn ends_after_saying(mut self, signal: &str) -> (Option<i32>, String) {
        let mut said = String::new();
        let status = self.wait_after(signal);
        self.stderr.read_to_string(&mut said).unwrap();
        (status, said)
    }

    /// Sends a signal and returns the exit status, which must come within ten seconds.
    pub fn ends_after(mut self, signal: &str) -> Option<i32> {
        self.wait_after(signal)
    }

    fn wait_after(&mut self, signal: &str) -> Option<i32> {
        let begun = Instant::now();
        self.signal(signal);
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.code();
            }
            assert!(begun.elapsed() < Duration::from_secs(10), "still there ten seconds after {signal}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

pub fn play(recording: &Path, out: &Path) -> Output {
    let arguments = ["play", text(recording), "--headless", "--snap", text(out)];
    fbptr().args(arguments).output().unwrap()
}

#[test]
fn a_signal_ends_it_in_order_whatever_its_clients_do() {
    let folder = Folder::new("signals");
    for signal in ["TERM", "INT"] {
        let (socket, snap) = (folder.join("socket"), folder.join("end.raw"));
        let arguments = ["--listen", ":0", "--unix", text(&socket), "--size", "40x30", "--snap", text(&snap)];
        let mut process = Process::start(&arguments);
        let address = process.address();
        assert_eq!(process.says(), format!("fbptr: listening on unix {}", socket.display()));
        // One client floods, one never reads, one is in the middle of a payload, one is idle.
        let flood = std::thread::spawn(move || {
            let mut wire = Wire::connect(address);
            while wire.0.write_all(&b"PX 3 3 ff0000\n".repeat(1000)).is_ok() {}
        });
        let mut mute = Wire::connect(address);
        mute.0.set_write_timeout(Some(Duration::from_millis(100))).unwrap();
        while mute.0.write_all(&b"READ 0 0 40 30\n".repeat(1000)).is_ok() {}
        let mut half = Wire::connect(address);
        half.send(b"BLIT 0 0 2 2 :16\n0123");
        let mut polite = UnixStream::connect(&socket).unwrap();
        polite.write_all(b"PX 5 5 00ff00\nPX 5 5\n").unwrap();
        let mut reply = [0; 14];
        polite.read_exact(&mut reply).unwrap();
        assert_eq!(process.ends_after(signal), Some(0), "{signal}");
        flood.join().unwrap();
        let frame = std::fs::read(&snap).unwrap();
        assert_eq!(frame[(40 * 5 + 5) * 4..][..4], [0, 255, 0, 255], "the snapshot is written");
        assert_eq!(frame[..4], [0, 0, 0, 255], "and half a command is not in it");
        assert!(!socket.exists(), "the socket file goes at the end");
        std::fs::remove_file(&snap).unwrap();
    }
}

#[test]
fn replies_to_what_was_received_come_before_the_end() {
    let mut process = Process::start(&["--listen", ":0", "--size", "40x30"]);
    let mut wire = Wire::connect(process.address());
    let many = 2000;
    assert_eq!(wire.ask("SYNC first\n"), "SYNC first\n");
    wire.send("CRC\n".repeat(many).as_bytes());
    std::thread::sleep(Duration::from_millis(100));
    let reader = std::thread::spawn(move || wire.rest());
    assert_eq!(process.ends_after("TERM"), Some(0));
    assert_eq!(reader.join().unwrap().len(), many * "CRC 12345678\n".len());
}

#[test]
fn a_dead_socket_is_replaced_and_nothing_else_is() {
    let folder = Folder::new("unix");
    let socket = folder.join("s");
    let mut process = Process::start(&["--unix", text(&socket)]);
    assert!(process.says().ends_with(text(&socket)));
    assert_eq!(std::fs::metadata(&socket).unwrap().permissions().mode() & 0o777, 0o600);
    let second = fbptr().args(["serve", "--headless", "--unix", text(&socket)]).output().unwrap();
    assert_eq!(second.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&second.stderr).contains("another server answers there"));
    process.child.kill().unwrap();
    process.child.wait().unwrap();
    assert!(socket.exists(), "a killed server leaves its socket");
    let mut process = Process::start(&["--unix", text(&socket)]);
    assert!(process.says().ends_with(text(&socket)));
    let mut client = UnixStream::connect(&socket).unwrap();
    client.write_all(b"SIZE\nQUIT\n").unwrap();
    let mut reply = String::new();
    client.read_to_string(&mut reply).unwrap();
    assert_eq!(reply, "SIZE 640 480\n");
    assert_eq!(process.ends_after("TERM"), Some(0));
    let letter = folder.join("letter");
    std::fs::write(&letter, "dear friend").unwrap();
    let refused = fbptr().args(["serve", "--headless", "--unix", text(&letter)]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert_eq!(std::fs::read(&letter).unwrap(), b"dear friend");
}

#[test]
fn arguments_that_are_no_use_have_status_2_before_anything_starts() {
    let folder = Folder::new("arguments");
    let foreign = folder.join("foreign");
    std::fs::write(&foreign, "not a video memory").unwrap();
    let cases: [&[&str]; 8] = [
        &["--size", "0x5"],
        &["--size", "32768x32768"],
        &["--size", "1000x1000", "--max-frame", "100"],
        &["--listen", "0.0.0.0:0"],
        &["--listen", "nonsense:port"],
        &["--shm", text(&foreign)],
        &["--snap-dir", "/nowhere/at/all"],
        &["--snap", "picture.xyz"],
    ];
    for arguments in cases {
        let out = fbptr().args(["serve", "--headless", "--listen", ":0"]).args(arguments).output().unwrap();
        assert_eq!(out.status.code(), Some(2), "{arguments:?}");
        assert!(!out.stderr.is_empty() && out.stdout.is_empty(), "{arguments:?}");
    }
    assert_eq!(std::fs::read(&foreign).unwrap(), b"not a video memory");
    let mut open = Process::start(&["--listen", "0.0.0.0:0", "--allow-remote"]);
    assert!(open.says().starts_with("fbptr: warning: 0.0.0.0:0 can be reached from other machines"));
}

#[test]
fn standard_input_alone_is_served_to_its_end() {
    let mut child = fbptr()
        .args(["serve", "--headless", "--stdin", "--size", "10x6"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(b"PX 1 1 ff0000\nPX 1 1\nLINE 1\nSIZE\n").unwrap();
    let out = child.wait_with_output().unwrap();
    assert_eq!(out.status.code(), Some(0));
    let replies = String::from_utf8(out.stdout).unwrap();
    assert!(
        replies.starts_with("PX 1 1 ff0000\nERR 3 21 EARGS LINE: ") && replies.ends_with("\nSIZE 10 6\n"),
        "{replies}"
    );
}

#[test]
fn a_recording_plays_to_the_same_memory() {
    let folder = Folder::new("record");
    let (recording, end, replay) = (folder.join("r"), folder.join("end.raw"), folder.join("replay.raw"));
    let shm = folder.join("fb");
    let arguments = [
        "--listen",
        ":0",
        "--size",
        "50x60",
        "--record",
        text(&recording),
        "--snap",
        text(&end),
        "--shm",
        text(&shm),
    ];
    let mut process = Process::start(&arguments);
    let address = process.address();
    let mut wires: Vec<Wire> = (0..5).map(|_| Wire::connect(address)).collect();
    for round in 0..40 {
        for (i, wire) in wires.iter_mut().enumerate() {
            let x = round + i;
            match i {
                0 => wire.send(format!("OFFSET {i} {round}\nPX {x} 1 ff{round:02x}00\n").as_bytes()),
                1 => wire.send(&[b"PB".as_slice(), &[x as u8, 0, round as u8, 0, 1, 2, 3, 200]].concat()),
                2 => wire.send(format!("BLEND over\nLINE 0 {round} 49 {x} 00ff0040\nNONSENSE\n").as_bytes()),
                3 => wire.send(b"MESH m BOX\nROTATE 0 1 0 .1\nDRAW m\nBLIT 40 2 1 1 :4\nabcd"),
                _ => wire.send(b"TEXT 9 9 ffffff :3\na\nbPX 1 1\nSYNC x\n"),
            }
        }
    }
    let foreign = std::fs::OpenOptions::new().write(true).open(&shm).unwrap();
    foreign.write_all_at(b"wxyzwxyz", 4096 + 50 * 55 * 4).unwrap();
    for wire in &mut wires {
        wire.send(b"SYNC end\n");
    }
    std::thread::sleep(Duration::from_millis(120));
    for wire in wires {
        let replies = String::from_utf8_lossy(&wire.rest()).into_owned();
        assert!(replies.ends_with("SYNC end\n"), "{replies}");
    }
    assert_eq!(process.ends_after("TERM"), Some(0));
    let out = play(&recording, &replay);
    assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
    let (end, replay) = (std::fs::read(&end).unwrap(), std::fs::read(&replay).unwrap());
    assert_eq!(end[50 * 55 * 4..][..8], *b"wxyzwxyz");
    assert!(end == replay, "{} bytes differ", end.iter().zip(&replay).filter(|(a, b)| a != b).count());
}

#[test]
fn small_clients_send_and_take_pictures() {
    let folder = Folder::new("clients");
    let socket = folder.join("s");
    let mut process = Process::start(&["--listen", ":0", "--unix", text(&socket), "--size", "20x10"]);
    let address = process.address().to_string();
    process.says();
    let stream = folder.join("stream");
    std::fs::write(&stream, "PX 2 3 ff8000\nPX 2 3\nSYNC done\n").unwrap();
    for place in [address.as_str(), text(&socket)] {
        let out = fbptr().args(["send", place, text(&stream)]).output().unwrap();
        assert_eq!((out.status.code(), out.stdout.as_slice()), (Some(0), &b"PX 2 3 ff8000\nSYNC done\n"[..]));
        let picture = folder.join("p.raw");
        assert!(fbptr().args(["snap", place, text(&picture)]).status().unwrap().success());
        let bytes = std::fs::read(&picture).unwrap();
        assert_eq!((bytes.len(), &bytes[(20 * 3 + 2) * 4..][..4]), (800, &[255, 128, 0, 255][..]));
    }
    // Errors come for verbs of Pixelflut, too, with their places in the file; a word of its own in the
    // bytes of a reply is none.
    std::fs::write(&stream, "PX 0 0 45525220\nLNIE 1234\nREAD 0 0 1 1\nPX 1\n").unwrap();
    let out = fbptr().args(["send", &address, text(&stream)]).output().unwrap();
    assert_eq!(out.status.code(), Some(1));
    let said = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(said.starts_with("ERR 2 16 EVERB LNIE: ") && said.contains("ERR 4 39 EARGS PX: "), "{said}");
    std::fs::write(&stream, b"\x89PNG\r\n\x1a\n\0").unwrap();
    let out = fbptr().args(["send", &address, text(&stream)]).output().unwrap();
    assert_eq!(out.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&out.stderr).ends_with(": a PNG picture; expected a stream of commands\n")
    );
    if let (Some(folder), Some(name)) = (socket.parent(), socket.file_name()) {
        let picture = text(&folder.join("q.raw")).to_owned();
        let mut snap = fbptr();
        let by_name = snap.args(["snap", name.to_str().unwrap(), &picture]).current_dir(folder);
        assert!(by_name.status().unwrap().success(), "a socket in the current folder");
    }
    std::fs::write(&stream, "LINE 1\n").unwrap();
    assert_eq!(fbptr().args(["send", &address, text(&stream)]).output().unwrap().status.code(), Some(1));
    assert_eq!(fbptr().args(["send", &address, "no such file"]).output().unwrap().status.code(), Some(2));
    assert_eq!(fbptr().args(["snap", &address, "x.xyz"]).output().unwrap().status.code(), Some(2));
    assert_eq!(process.ends_after("TERM"), Some(0));
    assert_eq!(fbptr().args(["snap", &address, text(&stream)]).output().unwrap().status.code(), Some(2));
    let gone = fbptr().args(["send", &address, text(&stream)]).output().unwrap();
    assert_eq!(gone.status.code(), Some(1), "nobody listens any more");
}

/// Another program that uses the shared file: it relies on the documented layout alone.
const FOREIGN_PROGRAM: &str = r#"
import mmap, socket, struct, sys, time
path, port = sys.argv[1], int(sys.argv[2])
f = open(path, "r+b")
m = mmap.mmap(f.fileno(), 0)
magic, version, header, width, height, stride, form = struct.unpack_from("<8s6I", m, 0)
assert (magic, version, header, form) == (b"FBPTRSHM", 1, 4096, 1), m[:64]
assert stride == width * 4 and len(m) == header + stride * height
text = dict(line.split("=", 1) for line in m[256:4096].split(b"\0")[0].decode("ascii").splitlines())
assert int(text["width"]) == width and int(text["stride"]) == stride, text
at = lambda x, y: header + (width * y + x) * 4
s = socket.create_connection(("127.0.0.1", port))
r = s.makefile("rb")
def ask(line):
    s.sendall(line.encode() + b"\n")
    return r.readline().decode().strip()
# The server's drawing is in the file before the reply that follows it.
for i in range(300):
    assert ask("PX %d 3 %06x\nSYNC %d" % (i % width, i, i)) == "SYNC %d" % i
    got = m[at(i % width, 3):at(i % width, 3) + 3]
    assert got == struct.pack(">I", i)[1:], (i, got)
# Foreign writes are seen at once with the bell, and within 50 ms without.
for i in range(100):
    m[at(5, 5):at(6, 5)] = bytes([i, 1, 2, 255])
    bell, = struct.unpack_from("<Q", m, 40)
    struct.pack_into("<Q", m, 40, bell + 1)
    assert ask("PX 5 5") == "PX 5 5 %02x0102" % i
for i in range(10):
    m[at(6, 5):at(7, 5)] = bytes([i, 9, 9, 255])
    time.sleep(0.05)
    assert ask("PX 6 5") == "PX 6 5 %02x0909" % i
# Writes to pixels that the server does not draw are never lost, while it draws all around them.
s.sendall(b"".join(b"FILLRECT 0 0 %d 8 %06x\n" % (width - 1, n * 99991 % 0xffffff) for n in range(3000)))
for i in range(200):
    for y in range(8):
        m[at(width - 1, y):at(width - 1, y) + 4] = bytes([i, y, 7, 255])
    time.sleep(0.0005)
assert ask("SYNC end") == "SYNC end"
time.sleep(0.06)
for y in range(8):
    assert ask("PX %d %d" % (width - 1, y)) == "PX %d %d c7%02x07" % (width - 1, y, y)
    assert m[at(width - 1, y):at(width - 1, y) + 4] == bytes([199, y, 7, 255])
assert ask("PRESENT wait").startswith("FRAME ")
frame, = struct.unpack_from("<Q", m, 32)
assert frame == 1, frame
print("fine")
"#;

#[test]
fn another_program_maps_the_shared_file() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    let folder = Folder::new("shm");
    let shm = folder.join("fb");
    let mut process = Process::start(&["--listen", ":0", "--size", "61x40", "--shm", text(&shm)]);
    let port = process.address().port().to_string();
    let out = Command::new("python3").args(["-c", FOREIGN_PROGRAM, text(&shm), &port]).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&out.stdout), "fine\n", "{}", String::from_utf8_lossy(&out.stderr));
    assert_eq!(process.ends_after("TERM"), Some(0));
    // A restarted server continues with the pixels; another size is refused, and without a size it
    // takes the file's.
    let mut wrong = fbptr();
    wrong
        .args(["serve", "--headless", "--listen", ":0", "--size", "60x40", "--shm", text(&shm)])
        .stderr(Stdio::null());

    assert_eq!(wrong.status().unwrap().code(), Some(2));
    let mut process = Process::start(&["--listen", ":0", "--shm", text(&shm)]);
    let mut wire = Wire::connect(process.address());
    assert_eq!(wire.ask("SIZE\n"), "SIZE 61 40\n");
    assert_eq!(wire.ask("PX 60 3\n"), "PX 60 3 c70307\n");
}

#[test]
fn a_signal_in_the_middle_of_a_big_drawing_ends_the_server_in_order() {
    let folder = Folder::new("abandon");
    for state in ["SHADE wire", "HIDE painter\nDEPTH u16", "MATERIAL white black black 1 black 0.5"] {
        let (recording, snap) = (folder.join("r"), folder.join("end.raw"));
        let arguments =
            ["--listen", ":0", "--size", "1280x720", "--record", text(&recording), "--snap", text(&snap)];
        let mut process = Process::start(&arguments);
        let mut wire = Wire::connect(process.address());
        // Each draw takes a good part of a second, so that the signal comes in the middle of one.
        let scene = format!("{state}\nLOOKAT 0 0 6 0 0 0 0 1 0\nMESH m KNOT 900 240\nSYNC made\n");
        assert_eq!(wire.ask(&scene), "SYNC made\n");
        wire.send("DRAW m\n".repeat(200).as_bytes());
        std::thread::sleep(Duration::from_millis(200));
        let (status, said) = process.ends_after_saying("TERM");
        assert_eq!(status, Some(0), "{state}: {said}");
        assert!(said.contains("fbptr: ended in the middle of DRAW: "), "{state}: {said}");
        let recording = std::fs::read(&recording).unwrap();
        let is_recorded = |line: &[u8]| recording.windows(line.len()).any(|w| w == line);
        assert!(is_recorded(b"MESH m KNOT 900 240\n"), "{state}");
        assert_eq!(std::fs::metadata(&snap).unwrap().len(), 1280 * 720 * 4, "{state}");
    }
}

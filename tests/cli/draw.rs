//! Tests of `fbptr draw`: lines typed at the prompt, taken back, saved, completed.

use super::tools;
use crate::folder::Folder;
use std::io::Write;
use std::process::{Command, Output, Stdio};

impl Folder {
    fn fbptr(&self, arguments: &[&str], input: &str) -> Output {
        let mut child = Command::new(env!("CARGO_BIN_EXE_fbptr"))
            .args(arguments)
            .current_dir(&self.0)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
        child.wait_with_output().unwrap()
    }

    fn draw(&self, input: &str) -> Output {
        self.fbptr(&["draw", "--headless", "--size", "64x48"], input)
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.0.join(name)).unwrap()
    }
}

fn out(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap()
}

/// Lines of each kind of state that a command may change.
const LINES: &str = "CLEAR navy\nDEPTH u24\nLIGHT 0 DIR 0 -1 -1 1 1 1\nBLEND over\nFILLCIRCLE 30 20 15 ff000080\n\
                     MESH @pot TEAPOT 3\nMESH ball SPHERE\nSHADE gouraud\nLOOKAT 0 1 6 0 0 0 0 1 0\n\
                     DRAW ball\nDRAW @pot\n";

#[test]
fn what_is_taken_back_leaves_no_trace() {
    let folder = Folder::new("undo");
    let kept = LINES.lines().count();
    let more = "DEPTH u16\nMESH @pot BOX\nCLEAR red\nDRAW @pot\nFREE @pot\nMESH ball CONE\nDRAW ball\n";
    let undone =
        folder.draw(&format!("{LINES}{more}undo {}\nsnap a.png\nsave a.fbs\nCRC\n", more.lines().count()));
    let plain = folder.draw(&format!("{LINES}snap b.png\nCRC\n"));
    assert_eq!(undone.status.code(), Some(0), "{}", out(&undone));
    assert_eq!(out(&undone).lines().last(), out(&plain).lines().last());
    assert_eq!(folder.read("a.png"), folder.read("b.png"));
    let saved = String::from_utf8(folder.read("a.fbs")).unwrap();
    // With the size, which a player takes from there.
    assert_eq!(saved.lines().filter(|line| !line.starts_with('#')).count(), kept + 1, "{saved}");
    let played = folder.fbptr(&["play", "a.fbs", "--headless", "--snap", "c.png"], "");
    assert_eq!(played.status.code(), Some(0), "{}", String::from_utf8_lossy(&played.stderr));
    assert_eq!(folder.read("c.png"), folder.read("b.png"));
}

#[test]
fn help_explains_a_verb_and_names_the_one_that_was_meant() {
    let folder = Folder::new("help");
    let asked = folder.draw("help circle\nhelp undo\nhelp lien\n");
    let said = out(&asked).to_owned() + &String::from_utf8_lossy(&asked.stderr);
    for expected in
        ["CIRCLE cx cy r c: ", "Example:\nCIRCLE 32 24 20 white\n", "undo [N]: ", "did you mean LINE?"]
    {
        assert!(said.contains(expected), "{expected}: {said}");
    }
}

#[test]
fn the_last_command_is_stepped_through_and_stays() {
    let folder = Folder::new("step");
    let stepped = folder.draw("CLEAR navy\nBLEND over\nLINE 2 5 12 8 ffd70080\nstep 4\n\n\nCRC\nlist\n");
    let plain = folder.draw("CLEAR navy\nBLEND over\nLINE 2 5 12 8 ffd70080\nCRC\nlist\n");
    assert_eq!(stepped.status.code(), Some(0), "{}", out(&stepped));
    let (steps, rest): (Vec<&str>, Vec<&str>) =
        out(&stepped).lines().partition(|line| line.contains(" of 11: "));
    assert_eq!(steps.len(), 11);
    assert_eq!(steps[0].trim(), "1 of 11: (2, 5)  step 0, d -4");
    assert_eq!(rest, out(&plain).lines().collect::<Vec<_>>());
    // One that is left early is drawn to its end; one that draws nothing is refused.
    let left = folder.draw("CLEAR navy\nBLEND over\nLINE 2 5 12 8 ffd70080\nstep\nq\nCRC\nlist\n");
    assert_eq!(out(&left).lines().skip(1).collect::<Vec<_>>(), rest);
    let nothing = folder.draw("step\nTRANSLATE 1 0 0\nstep\n");
    assert_eq!(out(&nothing), "there is nothing to step through\nTRANSLATE 1 0 0 has changed no pixel\n");
}

#[test]
fn what_is_done_again_is_as_it_was() {
    let folder = Folder::new("redo");
    let redone = folder.draw(&format!("{LINES}undo 4\nredo 2\nredo\nredo\nCRC\nlist\n"));
    let plain = folder.draw(&format!("{LINES}CRC\nlist\n"));
    assert_eq!(out(&redone), out(&plain));
    // A new command ends what could be done again.
    let ended = folder.draw("PX 1 1 ff0000\nundo\nPX 2 2 ff0000\nredo\n");
    assert_eq!(out(&ended), "there is nothing to redo\n");
    assert_eq!(ended.status.code(), Some(1));
}

#[test]
fn refused_commands_and_questions_are_not_kept() {
    let folder = Folder::new("refused");
    let output = folder.draw("LNIE 1 2\nPX 3 4 00ff00\nPX 3 4\nCRC 0 0 1 1\nLINE 1 2\nlist\n");
    let lines: Vec<&str> = out(&output).lines().collect();
    assert!(lines[0].starts_with("EVERB LNIE: ") && lines[0].contains("did you mean LINE?"), "{lines:?}");
    assert_eq!(lines[1], "PX 3 4 00ff00");
    assert!(lines[2].starts_with("CRC ") && lines[3].starts_with("EARGS LINE: "), "{lines:?}");
    assert_eq!(lines[4..], ["PX 3 4 00ff00"]);
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn payloads_are_typed_or_come_from_files() {
    let folder = Folder::new("payload");
    std::fs::write(folder.0.join("one face.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let output = folder.draw(
        "TEXT 2 2 white :5\nhello\nTEXT 2 20 white :7\ntwo\nmor\nMESH m OBJ < one face.obj\nsave a.fbs\nTEXT 1 1 red :3\nlonger\nTEX t < none.png\nTEXT 1 1 red :9\nshort\n",
    );
    let lines: Vec<&str> = out(&output).lines().collect();
    assert_eq!(lines.len(), 3, "{lines:?}");
    assert!(
        lines[0].contains("has 6 bytes")
            && lines[1].contains("none.png")
            && lines[2].contains("lacks 4 bytes")
    );
    let saved = String::from_utf8(folder.read("a.fbs")).unwrap();
    assert!(
        saved.contains("TEXT 2 20 white :7\ntwo\nmor\n") && saved.contains("MESH m OBJ :32\nv 0 0 0\n"),
        "{saved}"
    );
}

#[test]
fn a_file_of_others_is_kept_and_a_closed_connection_opens_again() {
    let folder = Folder::new("files");
    std::fs::write(folder.0.join("mine.fbs"), "precious").unwrap();
    let output =
        folder.draw("PX 1 1 ff0000\nsave mine.fbs\nERRORS close\nNOPE\nPX 1 1\nsave new.fbs\nsave new.fbs\n");
    let lines: Vec<&str> = out(&output).lines().collect();
    assert!(lines[0].contains("mine.fbs exists"), "{lines:?}");
    assert!(lines[1].contains("closed by this command"), "{lines:?}");
    assert_eq!(lines[2..], ["PX 1 1 ff0000"]);
    assert_eq!(folder.read("mine.fbs"), b"precious");
    assert!(folder.read("new.fbs").ends_with(b"PX 1 1 ff0000\nERRORS close\n"));
}

#[test]
fn a_stream_is_gone_on_with() {
    let folder = Folder::new("file");
    std::fs::write(folder.0.join("a.fbs"), "PX 1 1 ff0000\nTEXT 2 2 white :2\nhi\n").unwrap();
    let output = folder.fbptr(&["draw", "a.fbs", "--headless", "--size", "64x48"], "PX 1 1\nundo\nPX 1 1\n");
    assert_eq!(out(&output), "PX 1 1 ff0000\nPX 1 1 000000\n");
    std::fs::write(folder.0.join("b.fbs"), "# small\n\nSIZE 20 10\nPX 1 1 ff0000\n").unwrap();
    let output = folder.fbptr(&["draw", "b.fbs", "--headless"], "SIZE\nPX 1 1\nsave c.fbs\n");
    assert_eq!(out(&output), "SIZE 20 10\nPX 1 1 ff0000\n");
    assert!(folder.read("c.fbs").ends_with(b"SIZE 20 10\n# small\n\nPX 1 1 ff0000\n"));
}

/// Types into a terminal, and prints what appears there.
const TERMINAL: &str = r#"
import os, pty, select, sys, time
pid, fd = pty.fork()
if pid == 0:
    os.environ["TERM"] = "xterm"
    os.execv(sys.argv[1], [sys.argv[1], "draw", "--headless", "--size", "64x48"])
seen = b""
def until(text):
    global seen
    end = time.monotonic() + 60
    while text not in seen:
        if time.monotonic() > end: sys.exit("no %r in %r" % (text, seen))
        if select.select([fd], [], [], 1)[0]:
            try: seen += os.read(fd, 4096)
            except OSError: break
    seen = seen[seen.find(text) + len(text):]
until(b"fbptr> ")
os.write(fd, b"FILLC\t 30 20 5 ")
until(b"FILLCIRCLE 30 20 5 ")
until(b"\x1b[2mc\x1b[0m")
os.write(fd, b"tomato\r")
until(b"fbptr> ")
os.write(fd, b"PX 30 20\r")
until(b"PX 30 20 ff6347")
until(b"fbptr> ")
os.write(fd, b"\x1b[A\x1b[A\r")
until(b"FILLCIRCLE 30 20 5 tomato")
until(b"fbptr> ")
# Lines typed ahead, then lines pasted at once, of which four are a payload and the last is not ended.
os.write(fd, b"PX 1 1 red\rPX 1 1\rPX 2 2 lime\rPX 2 2\r")
until(b"PX 1 1 ff0000")
until(b"PX 2 2 00ff00")
until(b"fbptr> ")
os.write(fd, b"\x1b[200~MESH tri OBJ :32\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nFILLRECT 0 0 9 9 blue\nPX 3 3\x1b[201~\r")
until(b"PX 3 3 0000ff")
until(b"fbptr> ")
os.write(fd, b"nonsense\x03")
until(b"fbptr> ")
os.write(fd, b"\x04")
_, status = os.waitpid(pid, 0)
sys.exit(os.waitstatus_to_exitcode(status))
"#;

#[test]
#[cfg(unix)]
fn the_line_editor_completes_hints_and_remembers() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    let output =
        Command::new("python3").args(["-c", TERMINAL, env!("CARGO_BIN_EXE_fbptr")]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Ends the prompt by a signal, and prints whether the terminal's echo is as it was.
const SIGNALLED: &str = r#"
import os, pty, select, signal, subprocess, sys, termios, time
master, slave = pty.openpty()
before = termios.tcgetattr(slave)
words = [sys.argv[1], "draw", "--headless", "--size", "64x48", "--snap", sys.argv[3]]
child = subprocess.Popen(words, stdin=slave, stdout=slave, stderr=slave, env={**os.environ, "TERM": "xterm"})
seen, end = b"", time.monotonic() + 60
def until(text):
    global seen
    while text not in seen:
        if time.monotonic() > end: sys.exit("no %r in %r" % (text, seen))
        if select.select([master], [], [], 1)[0]:
            seen += os.read(master, 4096)
    seen = seen[seen.find(text) + len(text):]
until(b"fbptr> ")
os.write(master, b"PX 1 1 red\rPX 1 1\r")
until(b"PX 1 1 ff0000")
until(b"fbptr> ")
while termios.tcgetattr(slave) == before:
    if time.monotonic() > end: sys.exit("the line editor never changed the terminal")
    time.sleep(0.01)
child.send_signal(getattr(signal, sys.argv[2]))
status = child.wait(60)
after = termios.tcgetattr(slave)
print(status, after == before, bool(after[3] & termios.ECHO))
"#;

#[test]
#[cfg(unix)]
fn a_signal_gives_the_terminal_its_echo_back_and_writes_the_picture() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    let folder = Folder::new("signalled");
    for signal in ["SIGTERM", "SIGHUP"] {
        let snap = folder.0.join(format!("{signal}.png"));
        let mut command = Command::new("python3");
        command.args(["-c", SIGNALLED, env!("CARGO_BIN_EXE_fbptr"), signal]).arg(&snap);
        let output = command.output().unwrap();
        assert_eq!(out(&output), "0 True True\n", "{signal}: {}", String::from_utf8_lossy(&output.stderr));
        let picture = fbptr::save::golden::read_png(&snap).unwrap();
        assert_eq!(picture.get_pixel(1, 1).unwrap(), [255, 0, 0, 255]);
    }
}

#[test]
fn a_file_that_is_gone_on_with_ends_at_its_end() {
    let folder = Folder::new("file");
    let mut red = [255, 0, 0, 255].repeat(8 * 6);
    for (text, code, said) in [
        ("SIZE 8 6\nCLEAR red", 0, ""),
        ("CLEAR red\nQUIT\nCLEAR blue\n", 0, ""),
        ("SIZE 8 6\nCLEAR red\nTEXT 0 0 white :5\nhel", 1, "fbptr: s.fbs:3: EPROTO TEXT: "),
        ("SIZE 8 6\nCLEAR red\nNOPE 1\n", 1, "fbptr: s.fbs:3: EVERB NOPE: "),
    ] {
        std::fs::write(folder.0.join("s.fbs"), text).unwrap();
        let drawn = folder.fbptr(&["draw", "s.fbs", "--headless", "--size", "8x6", "--snap", "o.raw"], "");
        let found = String::from_utf8_lossy(&drawn.stderr);
        assert_eq!(drawn.status.code(), Some(code), "{text}: {found}");
        assert!(found.starts_with(said) && (said.is_empty() == found.is_empty()), "{text}: {found}");
        assert!(folder.read("o.raw") == red, "{text}");
    }
    // What was refused in the file does not hide the rest of it from `save` and `undo`.
    let saved =
        folder.fbptr(&["draw", "s.fbs", "--headless"], "PX 1 1 0000ff\nsave t.fbs\nundo\nsnap u.raw\n");
    assert_eq!(saved.status.code(), Some(1));
    let played = folder.fbptr(&["play", "t.fbs", "--headless", "--snap", "t.raw"], "");
    assert!(String::from_utf8_lossy(&played.stderr).contains("EVERB NOPE"));
    assert!(folder.read("u.raw") == red);
    red[(8 + 1) * 4..][..4].copy_from_slice(&[0, 0, 255, 255]);
    assert!(folder.read("t.raw") == red);
    std::fs::write(folder.0.join("r.fbs"), "#!fbptr-record 2 8x6\n#!end 0\n").unwrap();
    std::fs::write(folder.0.join("m.obj"), "v 0 0 0\nf 1 1 1\n").unwrap();
    for (file, said) in [
        ("r.fbs", "fbptr: r.fbs: a recording"),
        ("m.obj", "fbptr: m.obj: an OBJ model"),
        (".", "fbptr: .: is a folder"),
    ] {
        let refused = folder.fbptr(&["draw", file, "--headless"], "");
        let found = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{found}");
        assert!(found.starts_with(said), "{found}");
    }
}

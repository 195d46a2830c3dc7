//! Movies survive the end of the program: a killed recorder leaves a file that decodes up to the
//! last frame it took.

use crate::folder::Folder;
use image::AnimationDecoder;
use image::codecs::gif::GifDecoder;
use image::codecs::png::PngDecoder;
use std::io::{Cursor, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A process that is killed when the test ends.
struct Guard(Child);

impl Drop for Guard {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn fbptr(folder: &Folder, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbptr"));
    command.args(arguments).current_dir(&folder.0).stdin(Stdio::null()).stderr(Stdio::null());
    command
}

/// Returns the frames of a GIF or an APNG as RGBA, or `None` if the file does not exist yet.
fn frames(path: &Path) -> Option<Vec<Vec<u8>>> {
    let bytes = std::fs::read(path).ok()?;
    let frames = match path.extension().is_some_and(|e| e == "gif") {
        true => GifDecoder::new(Cursor::new(bytes)).expect("a GIF").into_frames().collect_frames(),
        false => {
            let decoder = PngDecoder::new(Cursor::new(bytes)).expect("a PNG");
            decoder.apng().expect("an APNG").into_frames().collect_frames()
        }
    };
    let frames = frames.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Some(frames.into_iter().map(|f| f.into_buffer().into_raw()).collect())
}

/// Returns the number of complete frames of a y4m stream.
fn y4m_frames(bytes: &[u8], width: usize, height: usize) -> usize {
    let header = bytes.iter().position(|&b| b == b'\n').expect("a header") + 1;
    assert!(bytes.starts_with(b"YUV4MPEG2 "));
    let frame = 6 + width * height * 3;
    let whole = (bytes.len() - header) / frame;
    for i in 0..whole {
        assert_eq!(&bytes[header + i * frame..][..6], b"FRAME\n", "frame {i}");
    }
    whole
}

/// Returns a stream of ten different pictures, each presented.
fn stream() -> String {
    (0..10)
        .map(|i| format!("CLEAR\nFILLRECT {} {} 9 9 ff{:02x}00\nPRESENT\n", i * 5, i * 3, i * 20))
        .collect()
}

#[test]
fn every_present_is_a_frame() {
    let folder = Folder::new("presents");
    std::fs::write(folder.0.join("s.fbs"), stream()).expect("written");
    for name in ["a.gif", "a.apng"] {
        let arguments =
            ["play", "s.fbs", "--headless", "--size", "64x48", "--movie", name, "--snap", "end.png"];
        assert!(fbptr(&folder, &arguments).status().expect("it runs").success());
        let shown = frames(&folder.0.join(name)).expect("a movie");
        assert_eq!(shown.len(), 10, "{name}");
        let end = image::open(folder.0.join("end.png")).expect("a picture").to_rgba8();
        assert!(shown[9] == end.into_raw(), "{name}: the last frame is the picture at the end");
    }
    // To a pipe: the movie goes to standard output, and replies do not.
    std::fs::write(folder.0.join("asks.fbs"), format!("SIZE\n{}", stream())).expect("written");
    let arguments = ["play", "asks.fbs", "--headless", "--size", "64x48", "--movie", "-"];
    let output = fbptr(&folder, &arguments).output().expect("it runs");
    assert!(output.status.success());
    assert_eq!(y4m_frames(&output.stdout, 64, 48), 10);
}

#[test]
fn a_stream_that_is_sent_slowly_is_filmed_by_the_clock() {
    let folder = Folder::new("live");
    let arguments = ["play", "-", "--headless", "--size", "64x48", "--movie", "a.apng", "--movie-fps", "50"];
    let mut player = Guard(fbptr(&folder, &arguments).stdin(Stdio::piped()).spawn().expect("it runs"));
    let mut stdin = player.0.stdin.take().expect("piped");
    for i in 0..4 {
        stdin.write_all(format!("FILLRECT {} 0 8 48 00ff00\n", i * 16).as_bytes()).expect("written");
        std::thread::sleep(Duration::from_millis(120));
    }
    drop(stdin);
    assert!(player.0.wait().expect("it ends").success());
    assert!(frames(&folder.0.join("a.apng")).expect("a movie").len() >= 4);
}

/// Kills a recorder once it has some frames; its file must decode to at least that many. Returns
/// their number.
fn kill_in_the_middle(folder: &Folder, mut recorder: Guard, name: &str, patience: Duration) -> usize {
    let path = folder.0.join(name);
    let begun = Instant::now();
    while std::fs::metadata(&path).map_or(0, |m| m.len()) < 2000 {
        assert!(begun.elapsed() < Duration::from_secs(60), "{name} never grew");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(patience);
    recorder.0.kill().expect("killed");
    recorder.0.wait().expect("gone");
    let left = frames(&path).expect("a movie");
    // A server's first frame shows memory that was never drawn into.
    for (i, frame) in left.iter().enumerate().skip(1) {
        assert!(frame.chunks(4).any(|p| p[..3] != [0; 3]), "{name}: frame {i} is empty");
    }
    left.len()
}

const SPINNING: &str = r#"<?xml version="1.0"?><X3D version="3.3" profile="Interchange"><Scene>
<Viewpoint position="0 0 4"/><TimeSensor DEF="T" cycleInterval="4" loop="true"/>
<OrientationInterpolator DEF="O" key="0 .5 1" keyValue="1 1 0 0 1 1 0 3.14 1 1 0 6.28"/>
<Transform DEF="X"><Shape><Appearance><Material diffuseColor="1 .5 .2"/></Appearance><Box/></Shape></Transform>
<ROUTE fromNode="T" fromField="fraction_changed" toNode="O" toField="set_fraction"/>
<ROUTE fromNode="O" fromField="value_changed" toNode="X" toField="set_rotation"/></Scene></X3D>"#;

#[test]
fn a_renderer_that_is_killed_leaves_a_movie_that_decodes() {
    let folder = Folder::new("killed");
    std::fs::write(folder.0.join("spin.x3d"), SPINNING).expect("written");
    let mut most = 0;
    for (i, name) in ["a.gif", "b.apng", "c.gif", "d.apng", "e.gif", "f.apng"].into_iter().enumerate() {
        let arguments = ["render", "spin.x3d", "-o", name, "--size", "160x120", "--frames", "100000"];
        let recorder = Guard(fbptr(&folder, &arguments).spawn().expect("it runs"));
        let patience = Duration::from_millis(40 + 37 * i as u64);
        most = most.max(kill_in_the_middle(&folder, recorder, name, patience));
    }
    assert!(most > 1, "the recorders were killed before they recorded anything");
}

#[test]
fn the_next_recording_removes_what_a_killed_one_left_half_written() {
    let folder = Folder::new("leftovers");
    std::fs::write(folder.0.join("spin.x3d"), SPINNING).expect("written");
    let render = |name: &str, frames: &str| {
        fbptr(&folder, &["render", "spin.x3d", "-o", name, "--size", "160x120", "--frames", frames])
    };
    for i in 0..5 {
        let mut recorder = Guard(render("killed.png", "100000").spawn().expect("it runs"));
        let begun = Instant::now();
        while !folder.0.join("killed-0000.png").exists() {
            assert!(begun.elapsed() < Duration::from_secs(60), "no picture came");
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(3 * i));
        recorder.0.kill().expect("killed");
        recorder.0.wait().expect("gone");
    }
    let hidden = || {
        let names = std::fs::read_dir(&folder.0).expect("a folder").map(|e| e.expect("entry").file_name());
        names.filter(|n| n.to_string_lossy().starts_with('.')).collect::<Vec<_>>()
    };
    // One is made here, since a kill does not always hit while a file is being written.
    std::fs::write(folder.0.join(".fbptr-1-7.tmp"), "half a picture").expect("written");
    assert!(!hidden().is_empty());
    assert!(render("next.png", "2").status().expect("it runs").success());
    assert_eq!(hidden(), Vec::<std::ffi::OsString>::new());
    std::fs::write(folder.0.join(".fbptr-1-7.tmp"), "half a picture").expect("written");
    assert!(render("next.gif", "2").status().expect("it runs").success());
    assert_eq!(hidden(), Vec::<std::ffi::OsString>::new());
    std::fs::write(folder.0.join(".fbptr-1-7.tmp"), "half a picture").expect("written");
    assert!(
        fbptr(&folder, &["play", "-", "--headless", "--snap-dir", "."]).status().expect("it runs").success()
    );
    assert_eq!(hidden(), Vec::<std::ffi::OsString>::new());
}

#[test]
fn a_server_that_is_killed_leaves_a_movie_that_decodes() {
    let folder = Folder::new("server");
    for name in ["a.gif", "b.apng"] {
        let arguments =
            ["serve", "--stdin", "--headless", "--size", "160x120", "--movie", name, "--movie-fps", "50"];
        let mut child = fbptr(&folder, &arguments).stdin(Stdio::piped()).spawn().expect("it runs");
        let mut stdin = child.stdin.take().expect("piped");
        let recorder = Guard(child);
        let writer = std::thread::spawn(move || {
            for i in 0u32.. {
                let line = format!(
                    "FILLCIRCLE {} {} 30 {:06x}\n",
                    i * 7 % 160,
                    i * 3 % 120,
                    ((i * 4001) & 0xff_ffff) | 0x40
                );
                if stdin.write_all(line.as_bytes()).is_err() {
                    return;
                }
                std::thread::sleep(Duration::from_millis(3));
            }
        });
        assert!(kill_in_the_middle(&folder, recorder, name, Duration::from_millis(300)) > 1);
        writer.join().expect("the writer ends");
    }
}

#[test]
fn render_writes_all_kinds_of_movies_and_a_pipe_that_closes_is_no_failure() {
    let folder = Folder::new("kinds");
    std::fs::write(folder.0.join("spin.x3d"), SPINNING).expect("written");
    let render = |out: &str, more: &[&str]| {
        let arguments =
            [&["render", "spin.x3d", "-o", out, "--size", "64x48", "--frames", "5"], more].concat();
        fbptr(&folder, &arguments).stdout(Stdio::piped()).output().expect("it runs")
    };
    for name in ["a.gif", "a.apng", "a.y4m", "p.png"] {
        assert!(render(name, &[]).status.success(), "{name}");
    }
    let apng = frames(&folder.0.join("a.apng")).expect("a movie");
    assert_eq!((apng.len(), frames(&folder.0.join("a.gif")).expect("a movie").len()), (5, 5));
    for (i, frame) in apng.iter().enumerate() {
        let png = image::open(folder.0.join(format!("p-{i:04}.png"))).expect("a picture").to_rgba8();
        assert!(png.into_raw() == *frame, "an APNG's frames are the pictures, byte for byte: {i}");
    }
    let y4m = std::fs::read(folder.0.join("a.y4m")).expect("a stream");
    assert_eq!((y4m_frames(&y4m, 64, 48), render("-", &[]).stdout == y4m), (5, true));
    for (out, more) in [("a.gif", &["--fps", "60"][..]), ("a.mp4", &[]), ("-", &["--explain"])] {
        assert_eq!(render(out, more).status.code(), Some(2), "{out} {more:?}");
    }
    let arguments = ["render", "spin.x3d", "-o", "-", "--size", "64x48", "--frames", "100000"];
    let mut endless = Guard(fbptr(&folder, &arguments).stdout(Stdio::piped()).spawn().expect("it runs"));
    let mut head = [0; 20_000];
    endless.0.stdout.take().expect("piped").read_exact(&mut head).expect("two frames");
    assert!(endless.0.wait().expect("it ends").success());
    assert_eq!(y4m_frames(&head, 64, 48), 2);
}

//! Programs of Debian's packages on the device; each is skipped where it is not installed.

use super::{picture_of, run, text};
use crate::folder::Folder;
use crate::tools;
use fbptr::memory::VideoMemory;
use std::process::Command;

#[test]
fn fbset_sees_and_sets_modes() {
    if !tools::are_there(&["fbset"]) {
        return;
    }
    let said = |arguments: &[&str]| {
        let output = run(&["--size", "320x200", "--", "fbset"]).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        text(&output.stdout)
    };
    let shown = said(&["-i"]);
    assert!(shown.contains("geometry 320 200 320 200 32"), "{shown}");
    assert!(shown.contains("Name        : fbptr"), "{shown}");
    let script = "fbset -depth 16 -vyres 400 && fbset";
    let output = run(&["--size", "320x200", "--", "sh", "-c", script]).output().unwrap();
    assert!(text(&output.stdout).contains("geometry 320 200 320 400 16"), "{output:?}");
}

#[test]
fn fbcat_reads_the_picture_that_another_program_wrote() {
    if !tools::are_there(&["fbcat"]) {
        return;
    }
    let folder = Folder::new("run-fbcat");
    let out = folder.join("out.ppm");
    let script = format!("head -c 4000 /dev/urandom > /dev/fb0; fbcat > {}", out.display());
    let (output, picture) = picture_of(&folder, &["--size", "40x20"], &["sh", "-c", &script]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let bytes = std::fs::read(out).unwrap();
    let pixels = bytes[bytes.len() - 40 * 20 * 3..].as_chunks::<3>().0;
    let ours = picture.bytes().as_chunks::<4>().0;
    assert!(ours.iter().zip(pixels).all(|(a, b)| a[..3] == b[..]));
    assert!(ours.iter().filter(|p| **p != VideoMemory::CLEAR).count() > 700);
}

/// Runs ffmpeg, and returns what it writes to standard output.
fn ffmpeg(arguments: &[&str]) -> Vec<u8> {
    Command::new("ffmpeg").args(["-v", "error", "-nostdin"]).args(arguments).output().unwrap().stdout
}

#[test]
fn a_frame_of_ffmpeg_arrives_byte_for_byte() {
    if !tools::are_there(&["ffmpeg"]) {
        return;
    }
    let folder = Folder::new("run-ffmpeg");
    let source = ["-f", "lavfi", "-i", "testsrc=size=160x120:rate=1", "-frames:v", "1"];
    let expected = ffmpeg(&[&source[..], &["-pix_fmt", "rgba", "-f", "rawvideo", "-"]].concat());
    assert_eq!(expected.len(), 160 * 120 * 4);
    for (format, pixels) in [("rgba", "rgba"), ("bgrx", "bgra")] {
        let mut words = vec!["ffmpeg", "-v", "error", "-nostdin"];
        words.extend(source);
        words.extend(["-pix_fmt", pixels, "-f", "fbdev", "/dev/fb0"]);
        let (output, picture) = picture_of(&folder, &["--size", "160x120", "--format", format], &words);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        assert!(picture.bytes() == expected, "{format}: the frame is another one");
    }
    let mut words = vec!["ffmpeg", "-v", "error", "-nostdin"];
    words.extend(source);
    words.extend(["-pix_fmt", "rgb565le", "-f", "fbdev", "/dev/fb0"]);
    let (output, picture) = picture_of(&folder, &["--size", "160x120", "--format", "rgb565"], &words);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let high = ffmpeg(&[&source[..], &["-pix_fmt", "rgb565le", "-f", "rawvideo", "-"]].concat());
    let wide = |v: u16, at: u32, bits: u32| {
        let v = u32::from(v) >> at & ((1 << bits) - 1);
        (v << (8 - bits) | v >> (2 * bits - 8)) as u8
    };
    for (found, half) in picture.bytes().as_chunks::<4>().0.iter().zip(high.as_chunks::<2>().0) {
        let v = u16::from_le_bytes(*half);
        assert_eq!(*found, [wide(v, 11, 5), wide(v, 5, 6), wide(v, 0, 5), 255]);
    }
}

/// Writes a picture of four coloured quarters, and returns its path.
fn quarters(folder: &Folder) -> String {
    let path = folder.join("quarters.png");
    let mut memory = VideoMemory::new(160, 120).unwrap();
    for y in 0..120 {
        for x in 0..160 {
            let color =
                [[200, 0, 0], [0, 200, 0], [0, 0, 200], [200, 200, 0]][(x / 80 + y / 60 * 2) as usize];
            memory.put_pixel(x, y, [color[0], color[1], color[2], 255]);
        }
    }
    fbptr::save::to_path(&memory, &path).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Returns which of red, green, blue and yellow a pixel is, where it is one of them.
fn color_at(picture: &VideoMemory, x: i32, y: i32) -> &'static str {
    match picture.get_pixel(x, y).unwrap().map(|v| v > 120) {
        [true, false, false, _] => "red",
        [false, true, false, _] => "green",
        [false, false, true, _] => "blue",
        [true, true, false, _] => "yellow",
        _ => "another",
    }
}

#[test]
fn fim_shows_a_picture_and_quits_by_a_replayed_key() {
    if !tools::are_there(&["fim"]) {
        return;
    }
    let folder = Folder::new("run-fim");
    let picture = quarters(&folder);
    let words = ["fim", "-q", "-o", "fb", &picture];
    let options = ["--size", "160x120", "--after", "still:2s"];
    let (output, shown) = picture_of(&folder, &options, &words);
    let corners = [(30, 30), (130, 30), (30, 80), (130, 80)].map(|(x, y)| color_at(&shown, x, y));
    assert_eq!(corners, ["red", "green", "blue", "yellow"], "{output:?}");
}

#[test]
fn mplayer_shows_a_picture() {
    if !tools::are_there(&["mplayer"]) {
        return;
    }
    let folder = Folder::new("run-mplayer");
    let picture = quarters(&folder);
    // One frame for 50 seconds: in a loop mplayer clears the screen again and again.
    let words =
        ["mplayer", "-really-quiet", "-nosound", "-vo", "fbdev2", "-fps", "0.02", &format!("mf://{picture}")];
    let options = ["--size", "160x120", "--after", "still:2s"];
    let (output, shown) = picture_of(&folder, &options, &words);
    let corners = [(30, 30), (130, 30), (30, 90), (130, 90)].map(|(x, y)| color_at(&shown, x, y));
    assert_eq!(corners, ["red", "green", "blue", "yellow"], "{output:?}");
}

#[test]
fn links_is_driven_by_replayed_keys() {
    if !tools::are_there(&["links2"]) {
        return;
    }
    let folder = Folder::new("run-links");
    let second = folder.join("second.html");
    std::fs::write(&second, "<body bgcolor='#00c800'><h1>Second</h1></body>").unwrap();
    let first = folder.join("first.html");
    let link = format!("<body bgcolor='#c80000'><a href='{}'>the second page</a></body>", second.display());
    std::fs::write(&first, link).unwrap();
    // links asks its standard input for the console.
    let script = format!("exec links2 -g -driver fb file://{} < /dev/tty", first.display());
    let keys = folder.join("keys.txt");
    let shown = |lines: &str| {
        std::fs::write(&keys, lines).unwrap();
        let options = ["--size", "320x240", "--after", "still:2s", "--keys", keys.to_str().unwrap()];
        let (output, shown) = picture_of(&folder, &options, &["sh", "-c", &script]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        color_at(&shown, 200, 200)
    };
    assert_eq!(shown(""), "red");
    // The arrow key chooses the first link, and enter follows it.
    assert_eq!(shown("4s press down\n5s press enter\n"), "green");
}

/// Returns whether Python has PyQt5.
fn has_pyqt() -> bool {
    let found = Command::new("/usr/bin/python3").args(["-c", "import PyQt5.QtWidgets"]).output();
    let found = found.is_ok_and(|output| output.status.success());
    if !found {
        tools::skip("/usr/bin/python3 has no PyQt5");
    }
    found
}

#[test]
fn qt_draws_by_its_linuxfb_platform() {
    if !has_pyqt() {
        return;
    }
    let folder = Folder::new("run-qt");
    let script = "
from PyQt5.QtWidgets import QApplication, QWidget
app = QApplication(['test', '-platform', 'linuxfb:fb=/dev/fb0'])
window = QWidget()
window.setStyleSheet('background: rgb(200, 0, 0)')
window.showFullScreen()
app.exec_()
";
    let options = ["--size", "160x120", "--after", "still:2s"];
    let (output, shown) = picture_of(&folder, &options, &["/usr/bin/python3", "-c", script]);
    assert_eq!(color_at(&shown, 80, 100), "red", "{output:?}");
}

#[test]
fn qt_gets_keys_and_the_pointers_place_by_the_plugins_of_the_docs() {
    if !has_pyqt() {
        return;
    }
    let docs = include_str!("../../../docs/run.md");
    let line = docs.lines().find_map(|line| line.strip_prefix("export QT_QPA_GENERIC_PLUGINS="));
    let folder = Folder::new("run-qt-input");
    let keys = folder.join("keys.txt");
    let events = "2s mouse 100 50 0\n2500ms mouse 100 50 1\n3s mouse 100 50 0\n";
    std::fs::write(&keys, events).unwrap();
    let script = "
from PyQt5.QtWidgets import QApplication, QWidget
class Window(QWidget):
    def mousePressEvent(self, event):
        print(event.x(), event.y(), event.button(), flush=True)
    def keyPressEvent(self, event):
        print(repr(event.text()), flush=True)
        app.quit()
app = QApplication(['test', '-platform', 'linuxfb:fb=/dev/fb0'])
window = Window()
window.showFullScreen()
app.exec_()
";
    let mut command = run(&["--size", "160x120", "--keys", keys.to_str().unwrap(), "--type", "q", "--"]);
    command.env("QT_QPA_GENERIC_PLUGINS", line.expect("the docs name the plugins"));
    let output = command.args(["/usr/bin/python3", "-c", script]).output().unwrap();
    assert_eq!(text(&output.stdout), "100 50 1\n'q'\n", "{output:?}");
}

#[test]
fn an_sdl_program_draws_by_fbcon_and_gets_its_keys() {
    let has_sdl = Command::new("python3")
        .args(["-c", "import ctypes; ctypes.CDLL('libSDL-1.2.so.0')"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !has_sdl {
        return tools::skip("there is no python3, or no libSDL-1.2.so.0");
    }
    let folder = Folder::new("run-sdl");
    let script = "
import ctypes, time
sdl = ctypes.CDLL('libSDL-1.2.so.0')
sdl.SDL_SetVideoMode.restype = ctypes.c_void_p
assert sdl.SDL_Init(0x20) == 0, ctypes.cast(sdl.SDL_GetError(), ctypes.c_char_p).value
surface = ctypes.c_void_p(sdl.SDL_SetVideoMode(640, 480, 32, 0))
sdl.SDL_FillRect(surface, None, 0xc80000)
sdl.SDL_Flip(surface)
event = ctypes.create_string_buffer(64)
while event[0] != b'\\2' or event.raw[8:9] != b'q':
    if not sdl.SDL_PollEvent(event):
        time.sleep(0.01)
print('quit by', event.raw[8:9].decode())
import os
os._exit(3)
";
    let snap = folder.join("snap.png");
    let mut command =
        run(&["--size", "640x480", "--type", "q", "--verbose", "--snap", snap.to_str().unwrap()]);
    command.env("SDL_VIDEODRIVER", "fbcon").args(["--", "python3", "-c", script]);
    let output = command.output().unwrap();
    assert_eq!((text(&output.stdout).as_str(), output.status.code()), ("quit by q\n", Some(3)), "{output:?}");
    let shown = fbptr::save::golden::read_png(&snap).unwrap();
    assert_eq!(color_at(&shown, 80, 60), "red");
}

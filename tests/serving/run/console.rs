//! The console as programs of virtual terminals see it, and programs that want one.

use super::{compiled, picture_of, run, text};
use crate::folder::Folder;
use crate::tools;
use fbptr::memory::VideoMemory;

#[test]
fn the_console_passes_for_a_virtual_terminal() {
    let folder = Folder::new("run-console");
    let Some(program) = compiled(&folder, "console_numbers.c", &[]) else { return };
    let output = run(&["--size", "64x48", "--"]).arg(program).output().unwrap();
    let numbers: Vec<String> = text(&output.stdout)
        .lines()
        .map(|line| line.split_once(" fstat ").unwrap_or_default().1.to_owned())
        .collect();
    let expected = [
        "5:0 stat 5:0 ttyname /dev/tty1",
        "4:0 stat 4:0 ttyname /dev/tty0",
        "4:1 stat 4:1 ttyname /dev/tty1",
        "5:1 stat 5:1 ttyname /dev/console",
    ];
    assert_eq!(numbers, expected, "{output:?}");
}

#[test]
fn a_descriptor_of_the_console_is_known_wherever_it_comes_to() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    let script = "
import os, subprocess
for name in ('tty0', 'tty1', 'tty7', 'tty63', 'console'):
    fd = os.open('/dev/' + name, os.O_RDWR)
    moved = os.dup(fd)
    same = os.path.samestat(os.stat('/dev/' + name), os.fstat(moved))
    link = os.readlink(f'/proc/self/fd/{moved}')
    again = os.ttyname(os.open(f'/proc/self/fd/{fd}', os.O_RDWR))
    child = subprocess.run(['tty'], stdin=fd, capture_output=True).stdout.decode().strip()
    print(os.ttyname(fd), same, link, again, child)
";
    let output = run(&["--", "python3", "-c", script]).output().unwrap();
    let expected: String = ["tty0", "tty1", "tty7", "tty63", "console"]
        .map(|name| format!("/dev/{name} True /dev/{name} /dev/{name} /dev/{name}\n"))
        .concat();
    assert_eq!(text(&output.stdout), expected, "{output:?}");
}

#[test]
fn requests_of_virtual_terminals_are_served_on_the_standard_descriptors() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    // Standard output is a pipe. Standard input is /dev/null until it is asked for a terminal.
    let script = "
import fcntl, os, struct, sys
print(repr(sys.stdin.read()))
for fd in (0, 1, 2):
    print(struct.unpack('3H', fcntl.ioctl(fd, 0x5603, bytes(6)))[0])
print(os.ttyname(0), os.isatty(0), os.isatty(1))
try:
    print(fcntl.ioctl(os.open('/dev/null', os.O_RDWR), 0x5603, bytes(6)))
except OSError as error:
    print(error.errno)
";
    let output = run(&["--", "python3", "-c", script]).output().unwrap();
    assert_eq!(text(&output.stdout), "''\n1\n1\n1\n/dev/tty1 True False\n25\n", "{output:?}");
}

#[test]
fn the_active_virtual_terminal_has_the_keyboard() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    let folder = Folder::new("run-active-terminal");
    let keys = folder.join("keys.txt");
    std::fs::write(&keys, "1s type a\n3s type b\n").unwrap();
    let script = "
import fcntl, os, tty
first, second = (os.open(f'/dev/tty{n}', os.O_RDWR) for n in (1, 2))
tty.setraw(first), tty.setraw(second)
fb = open('/dev/fb0', 'r+b')
print(os.read(first, 9))
fcntl.ioctl(first, 0x5606, 2)
print(os.read(second, 9), os.fstat(os.open('/dev/tty0', os.O_RDWR)).st_rdev)
";
    let output = run(&["--keys", keys.to_str().unwrap(), "--", "python3", "-c", script]).output().unwrap();
    assert_eq!(text(&output.stdout), "b'a'\nb'b' 1024\n", "{output:?}");
}

#[test]
fn rows_with_padding_show_the_same_picture() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    let folder = Folder::new("run-padding");
    let script = "
import fcntl, mmap, struct, sys
fb = open('/dev/fb0', 'r+b')
fix = fcntl.ioctl(fb, 0x4602, bytes(80))
line, length = struct.unpack_from('I', fix, 48)[0], struct.unpack_from('I', fix, 24)[0]
pixels = mmap.mmap(fb.fileno(), length)
for y in range(24):
    for x in range(32):
        pixels[line * y + 4 * x : line * y + 4 * x + 4] = bytes((x, y, x ^ y, 255))
print(line, open('/sys/class/graphics/fb0/stride').read().strip(), length >= 3 * 24 * line)
";
    let program = ["python3", "-c", script];
    let shown = |options: &[&str]| {
        let (output, picture) = picture_of(&folder, &[&["--size", "32x24"], options].concat(), &program);
        (text(&output.stdout), picture.bytes().to_vec())
    };
    let (said, plain) = shown(&[]);
    assert_eq!(said, "128 128 True\n");
    for (format, length, expected) in [("bgrx", "190", 192), ("bgrx", "4096", 4096), ("bgrx", "100", 128)] {
        let (said, picture) = shown(&["--format", format, "--line-length", length]);
        assert_eq!(said, format!("{expected} {expected} True\n"));
        assert!(picture == plain, "{length}: another picture");
    }
    // Where video memory itself is the copy, rows without padding are taken as they are.
    let (_, rgba) = shown(&["--format", "rgba"]);
    assert!(shown(&["--format", "rgba", "--line-length", "256"]).1 == rgba);
}

/// Runs a program that draws on the console for some seconds, and returns its picture. A cursor that
/// blinks is never still.
fn shown(name: &str, program: &[&str]) -> VideoMemory {
    let folder = Folder::new(name);
    let (output, picture) = picture_of(&folder, &["--size", "640x480", "--after", "5s"], program);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let drawn = picture.bytes().as_chunks::<4>().0.iter().filter(|p| **p != VideoMemory::CLEAR).count();
    assert!(drawn > 100, "{program:?}: {drawn} pixels: {output:?}");
    picture
}

#[test]
fn terminals_of_the_framebuffer_run_without_a_terminal() {
    if tools::are_there(&["fbterm"]) {
        shown("run-fbterm", &["fbterm", "--", "sh", "-c", "echo drawn by fbterm; sleep 60"]);
    }
    if tools::are_there(&["zhcon"]) {
        // It asks its standard output for a terminal.
        shown("run-zhcon", &["sh", "-c", "exec zhcon > /dev/tty"]);
    }
}

#[test]
fn a_viewer_whose_parent_ends_is_waited_for() {
    if !tools::are_there(&["fbi"]) {
        return;
    }
    let folder = Folder::new("run-fbi");
    let path = folder.join("red.ppm");
    std::fs::write(&path, [&b"P6\n320 240\n255\n"[..], &[200, 0, 0].repeat(320 * 240)].concat()).unwrap();
    for options in [&["-noverbose"][..], &["-T", "1", "-noverbose"]] {
        let program = [&["fbi"], options, &[path.to_str().unwrap()]].concat();
        let picture = shown("run-fbi-shown", &program);
        assert_eq!(picture.get_pixel(320, 240).unwrap(), [200, 0, 0, 255], "{options:?}");
    }
}

#[test]
fn w3m_shows_a_picture_on_the_console() {
    let display = "/usr/lib/w3m/w3mimgdisplay";
    if !std::path::Path::new(display).is_file() {
        return tools::skip("there is no w3mimgdisplay");
    }
    let folder = Folder::new("run-w3m");
    // Where it runs with a group of its own, the system lets no library be preloaded.
    let copy = folder.join("w3mimgdisplay");
    std::fs::copy(display, &copy).unwrap();
    std::fs::set_permissions(&copy, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let path = folder.join("red.ppm");
    std::fs::write(&path, [&b"P6\n80 60\n255\n"[..], &[200, 0, 0].repeat(80 * 60)].concat()).unwrap();
    let script = format!(
        "export W3M_TTY=$(tty); (echo '0;1;10;10;80;60;;;;;{}'; echo '4;'; echo '3;'; sleep 60) | {}",
        path.display(),
        copy.display()
    );
    let picture = shown("run-w3m-shown", &["sh", "-c", &script]);
    assert!(picture.get_pixel(50, 40).unwrap()[0] > 150);
}

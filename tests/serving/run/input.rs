//! Keyboard and mouse of a run: replayed input on the console and on the input devices.

use super::{run, text};
use crate::folder::Folder;
use crate::tools;

/// Runs a Python program with a replay; it opens the framebuffer first, from which times count.
fn replayed(options: &[&str], keys: &str, script: &str) -> Option<String> {
    if !tools::are_there(&["python3"]) {
        return None;
    }
    let folder = Folder::new(&format!("run-input-{}", keys.len() + script.len()));
    let file = folder.join("keys.txt");
    std::fs::write(&file, keys).unwrap();
    let mut command = run(options);
    let script = format!("import os, struct, fcntl\nfb = open('/dev/fb0', 'r+b', buffering=0)\n{script}");
    command.arg("--keys").arg(&file).args(["--size", "64x48", "--", "python3", "-c", &script]);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    Some(text(&output.stdout))
}

#[test]
fn the_console_gets_characters_and_the_sequences_of_keys() {
    let script = "
import tty
console = os.open('/dev/tty', os.O_RDWR)
tty.setraw(console)
got = b''
while not got.endswith(b'.'):
    got += os.read(console, 100)
print(got)
";
    let keys = "1s press left\n1200ms type Hi\n1400ms press enter\n1500ms press f1\n1600ms press period\n";
    let Some(found) = replayed(&[], keys, script) else { return };
    assert_eq!(found, "b'\\x1b[DHi\\r\\x1b[[A.'\n");
}

#[test]
fn a_text_is_typed_into_the_console_once_the_picture_is_still() {
    let script = "
os.write(fb.fileno(), b'drawn')
console = open('/dev/tty0')
print(console.readline())
";
    let Some(found) = replayed(&["--type", "hello, World!\n"], "", script) else { return };
    assert_eq!(found, "hello, World!\n\n");
}

#[test]
fn event_devices_and_the_mouse_carry_keys_and_pointer() {
    let script = "
key, pointer, mice = (os.open('/dev/input/' + n, os.O_RDWR) for n in ('event0', 'event1', 'mice'))
name = fcntl.ioctl(key, 0x81004506, bytes(256)).split(b'\\0')[0]
bits = fcntl.ioctl(pointer, 0x80604520, bytes(96))
size = struct.unpack('6i', fcntl.ioctl(pointer, 0x80184541, bytes(24)))
print(name, bits[0], size, oct(os.stat('/dev/input/mice').st_mode), os.fstat(key).st_rdev)
def events(fd, count):
    got = b''
    while len(got) < 24 * count:
        got += os.read(fd, 24 * 16)
    return [struct.unpack('HHi', got[i + 16 : i + 24]) for i in range(0, len(got), 24)]
print(events(key, 4))
print(events(pointer, 5))
print(list(os.read(mice, 3)), list(os.read(mice, 3)))
";
    let keys = "2s press a\n2100ms mouse 5 7 0\n2200ms mouse 5 7 1\n";
    let Some(found) = replayed(&[], keys, script) else { return };
    let expected = "b'fbptr keyboard' 15 (0, 0, 47, 0, 0, 0) 0o20660 3392
[(1, 30, 1), (0, 0, 0), (1, 30, 0), (0, 0, 0)]
[(3, 0, 5), (3, 1, 7), (0, 0, 0), (1, 272, 1), (0, 0, 0)]
[40, 5, 249] [9, 0, 0]
";
    assert_eq!(found, expected);
}

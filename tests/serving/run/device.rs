//! The device as programs see it, and its picture.

use super::{compiled, picture_of, run, text};
use crate::folder::Folder;
use crate::support::Wire;
use crate::tools;
use fbptr::memory::VideoMemory;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

const CALLS: &str = include_str!("calls.txt");

#[test]
fn the_program_of_every_tutorial_draws_its_rectangle_and_keeps_its_status() {
    let folder = Folder::new("run-tutorial");
    let Some(program) = compiled(&folder, "tutorial.c", &[]) else { return };
    let (output, picture) = picture_of(&folder, &["--size", "64x48"], &[program.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(7), "{output:?}");
    assert_eq!(text(&output.stdout), "64x48, 32bpp\n");
    for y in 0..48u8 {
        for x in 0..64u8 {
            let is_inside = (10..40).contains(&x) && (10..30).contains(&y);
            let expected = if is_inside { [200 - y, 15 + x, 100, 255] } else { VideoMemory::CLEAR };
            assert_eq!(picture.get_pixel(x.into(), y.into()).unwrap(), expected, "{x},{y}");
        }
    }
}

#[test]
fn every_call_answers_as_the_kernels_device_does() {
    let folder = Folder::new("run-calls");
    let Some(program) = compiled(&folder, "calls.c", &[]) else { return };
    let output = run(&["--size", "64x64", "--verbose", "--"]).arg(&program).output().unwrap();
    assert_eq!(text(&output.stdout), CALLS, "{}", text(&output.stderr));
    assert_eq!(output.status.code(), Some(0));
    let said = text(&output.stderr);
    assert!(said.contains("fbptr: /dev/fb0: unknown request 0x46ff: EINVAL\n"), "{said}");
    assert!(said.contains("fbptr: the console: unknown request 0x4bff: EINVAL\n"), "{said}");
}

#[test]
fn several_processes_of_a_shell_share_one_device() {
    let folder = Folder::new("run-shell");
    let script = "head -c 1280 /dev/zero | tr '\\0' '\\377' > /dev/fb0
        (dd if=/dev/zero of=/dev/fb0 bs=4 count=1 conv=notrunc 2>/dev/null)
        exec cat /sys/class/graphics/fb0/stride";
    let (output, picture) = picture_of(&folder, &["--size", "40x20"], &["sh", "-c", script]);
    assert_eq!((text(&output.stdout).as_str(), output.status.code()), ("160\n", Some(0)), "{output:?}");
    let pixels = picture.bytes().as_chunks::<4>().0;
    assert_eq!(pixels[0], [0, 0, 0, 255]);
    assert!(pixels[1..320].iter().all(|p| *p == [255; 4]));
    assert!(pixels[320..].iter().all(|p| *p == [0, 0, 0, 255]));
}

#[test]
fn the_device_is_copied_as_a_file_is() {
    let folder = Folder::new("run-copy");
    let copy = folder.join("copy.raw").display().to_string();
    let script = format!(
        "printf 'abcdefgh' > /dev/fb0; cp /dev/fb0 {copy} || exit 3; head -c 4 {copy} > {copy}.4; cp {copy}.4 /dev/fb0"
    );
    let (output, picture) = picture_of(&folder, &["--size", "32x16"], &["sh", "-c", &script]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let bytes = std::fs::read(&copy).unwrap();
    assert_eq!((&bytes[..8], bytes.len()), (&b"abcdefgh"[..], 8192), "three screens, in whole pages");
    assert_eq!(picture.get_pixel(1, 0).unwrap(), [b'g', b'f', b'e', 255]);
    if !tools::are_there(&["python3"]) {
        return;
    }
    let script = "
import os
for path in ('/dev/fb0', '/dev/input/event0', '/dev/input/event1', '/dev/input/mice'):
    by_path, by_descriptor = os.stat(path), os.fstat(os.open(path, os.O_RDWR))
    print(path, os.path.samestat(by_path, by_descriptor), by_path.st_rdev == by_descriptor.st_rdev)
";
    let output = run(&["--", "python3", "-c", script]).output().unwrap();
    let said = text(&output.stdout);
    assert!(said.lines().count() == 4 && said.lines().all(|line| line.ends_with(" True True")), "{said}");
}

#[test]
fn programs_that_clear_their_environment_keep_the_device() {
    let folder = Folder::new("run-exec");
    let Some(program) = compiled(&folder, "exec.c", &[]) else { return };
    let (output, picture) = picture_of(&folder, &["--size", "16x8"], &[program.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert_eq!(picture.get_pixel(0, 0).unwrap(), [3, 2, 1, 255]);
    let words = ["env", "-i", "/bin/sh", "-c", "printf '\\001' > /dev/fb0; /usr/bin/env"];
    let (output, picture) = picture_of(&folder, &["--size", "16x8"], &words);
    assert_eq!(picture.get_pixel(0, 0).unwrap(), [0, 0, 1, 255], "{output:?}");
    assert!(!text(&output.stdout).contains("PATH=/usr"), "the rest is cleared: {output:?}");
}

#[test]
fn python_maps_the_device() {
    if !tools::are_there(&["python3"]) {
        return;
    }
    let folder = Folder::new("run-python");
    let script = "
import fcntl, mmap, os, struct
fd = os.open('/dev/fb0', os.O_RDWR)
var = struct.unpack('40I', fcntl.ioctl(fd, 0x4600, bytes(160)))
fb = mmap.mmap(fd, var[0] * var[1] * 4)
for y in range(var[1]):
    fb[y * var[0] * 4 : y * var[0] * 4 + 4] = bytes((y, 2 * y, 3 * y, 0))
print(oct(os.stat('/dev/fb0').st_mode), os.path.exists('/dev/fb0'))
";
    let (output, picture) = picture_of(&folder, &["--size", "32x24"], &["python3", "-c", script]);
    assert_eq!(text(&output.stdout), "0o20660 True\n", "{output:?}");
    for y in 0..24u8 {
        assert_eq!(picture.get_pixel(0, y.into()).unwrap(), [3 * y, 2 * y, y, 255]);
        assert_eq!(picture.get_pixel(1, y.into()).unwrap(), [0, 0, 0, 255]);
    }
}

#[test]
fn a_format_of_the_command_line_is_the_devices_own() {
    let folder = Folder::new("run-formats");
    for (format, bytes, expected) in [
        ("rgba", "\\001\\002\\003\\004", [1, 2, 3, 4]),
        ("bgrx", "\\001\\002\\003\\004", [3, 2, 1, 255]),
        ("rgb565", "\\000\\370", [255, 0, 0, 255]),
        ("rgb24", "\\001\\002\\003", [1, 2, 3, 255]),
        ("gray8", "\\200", [128, 128, 128, 255]),
        ("mono", "\\001", [255, 255, 255, 255]),
    ] {
        let script = format!("printf '{bytes}' > /dev/fb0");
        let (_, picture) =
            picture_of(&folder, &["--size", "16x8", "--format", format], &["sh", "-c", &script]);
        assert_eq!(picture.get_pixel(0, 0).unwrap(), expected, "{format}");
        assert_eq!(picture.get_pixel(8, 0).unwrap()[..3], [0; 3], "{format}");
    }
}

#[test]
fn clients_of_the_protocol_see_the_program_and_draw_beside_it() {
    let script = "printf '\\011\\012\\013' > /dev/fb0; read line";
    let mut child = run(&["--size", "16x8", "--serve", "127.0.0.1:0", "--", "sh", "-c", script])
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    stderr.read_line(&mut line).unwrap();
    let address = line.trim_end().strip_prefix("fbptr: listening on tcp ").expect(&line).parse().unwrap();
    let mut wire = Wire::connect(address);
    // Many seconds: more than that, and it hangs.
    let started = std::time::Instant::now();
    while wire.ask("PX 0 0\n") != "PX 0 0 0b0a09\n" {
        assert!(started.elapsed().as_secs() < 60, "the program's pixel does not appear");
    }
    assert_eq!(wire.ask("PX 3 4 ff0000\nPX 3 4\n"), "PX 3 4 ff0000\n");
    drop(child.stdin.take());
    assert_eq!(child.wait().unwrap().code(), Some(1), "the status of read at the end of its input");
}

#[test]
fn signals_shorten_no_wait_for_the_picture() {
    let folder = Folder::new("run-signals");
    let Some(program) = compiled(&folder, "signals.c", &[]) else { return };
    let output = run(&["--size", "64x48", "--hz", "10", "--"]).arg(&program).output().unwrap();
    assert_eq!(text(&output.stdout), "failed 0 early 0, many signals: 1\n", "{output:?}");
}

#[test]
fn page_flips_never_show_a_mixed_frame() {
    let folder = Folder::new("run-flips");
    let Some(program) = compiled(&folder, "flips.c", &[]) else { return };
    let movie = folder.join("flips.y4m");
    let mut command = run(&["--size", "64x48", "--hz", "1000", "--movie-fps", "1000"]);
    let output = command.arg("--movie").arg(&movie).arg("--").arg(&program).arg("1000").output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let bytes = std::fs::read(&movie).unwrap();
    let head = bytes.iter().position(|b| *b == b'\n').unwrap() + 1;
    let is_444 = text(&bytes[..head]).contains("C444");
    let frame = 6 + 64 * 48 * 3 / if is_444 { 1 } else { 2 };
    let mut colors = std::collections::HashSet::new();
    let mut count = 0;
    for frame in bytes[head..].chunks(frame) {
        let luma = &frame[6..6 + 64 * 48];
        assert!(luma.iter().all(|y| *y == luma[0]), "frame {count} is mixed");
        colors.insert(luma[0]);
        count += 1;
    }
    // Fewer where the machine is busy; the program flips 1,000 times, and waits each time.
    assert!(count > 50 && colors.len() > 20, "{count} frames of {} colours", colors.len());
}

//! The device's places in the file system: ways to them, folders, and files that are written.

use super::{compiled, picture_of, run, text};
use crate::folder::Folder;
use crate::tools;

const PATHS: &str = include_str!("paths.txt");

#[test]
fn every_way_that_leads_to_the_device_leads_to_the_emulated_one() {
    let folder = Folder::new("run-paths");
    let Some(program) = compiled(&folder, "paths.c", &[]) else { return };
    let output = run(&["--size", "64x64", "--"]).arg(&program).arg(folder.join("")).output().unwrap();
    assert_eq!(text(&output.stdout), PATHS, "{}", text(&output.stderr));
    assert_eq!(output.status.code(), Some(0));
}

/// Runs a script of a shell, and returns what it says.
fn said(shell: &str, script: &str) -> String {
    let output = run(&["--size", "64x48", "--", shell, "-c", script]).output().unwrap();
    text(&output.stdout) + &text(&output.stderr)
}

#[test]
fn a_shell_lists_the_device_and_goes_into_its_folders() {
    let script = "cd /sys/class/graphics/fb0 && cat stride bits_per_pixel && pwd
        cat /sys/class/graphics/fb*/virtual_size
        echo /dev/fb* /dev/input/*
        for file in *; do test -r $file || echo no $file; done
        ls -la /dev/input > /dev/null || echo no list
        ls -d /dev/fb0; test -c /dev/fb0 && test -d /dev/input && test -w pan && echo well
        mkdir /dev/fb0 2>/dev/null || echo no folder";
    let expected = "256\n32\n/sys/class/graphics/fb0\n64,48\n\
        /dev/fb0 /dev/input/event0 /dev/input/event1 /dev/input/mice\n/dev/fb0\nwell\n";
    for shell in ["sh", "bash"].into_iter().filter(|shell| tools::are_there(&[shell])) {
        let said = said(shell, script);
        assert!(said.starts_with(expected), "{shell}: {said}");
    }
}

#[test]
fn files_of_the_device_are_written_as_the_kernels_are() {
    // dash writes by a call that the library sees, bash and a stream by one that it does not.
    let script = "cd /sys/class/graphics/fb0
        echo 16 > bits_per_pixel; cat bits_per_pixel stride
        echo 64,96 > virtual_size; cat virtual_size
        echo 0,48 > pan; cat pan
        echo U:32x24p-60 > mode; cat mode pan
        echo 0x20 > bits_per_pixel; cat bits_per_pixel
        cat /sys/class/graphics/fb0/blank | wc -c; (echo 1 > name) 2>/dev/null || echo read only";
    let expected = "16\n128\n64,96\n0,48\nU:32x24p-60\n0,0\n32\n0\nread only\n";
    for shell in ["sh", "bash"].into_iter().filter(|shell| tools::are_there(&[shell])) {
        assert_eq!(said(shell, script), expected, "{shell}");
    }
    if !tools::are_there(&["python3"]) {
        return;
    }
    let script = "
import os, subprocess
folder = '/sys/class/graphics/fb0/'
def put(name, text):
    fd = os.open(folder + name, os.O_WRONLY)
    try:
        return os.write(fd, text)
    except OSError as error:
        return error.errno
    finally:
        os.close(fd)
print(put('bits_per_pixel', b'17'), put('bits_per_pixel', b'99'), put('virtual_size', b'1'), put('pan', b'0,1\\n'))
print(put('mode', b'nonsense'), put('mode', b'U:65x48p-60\\n'), put('rotate', b'1'), put('state', b'0'))
print(put('virtual_size', b'64,144'), put('pan', b'0,96'), put('pan', b'0,97'), sorted(os.listdir(folder))[:3])
print(open(folder + 'bits_per_pixel').read(), os.stat(folder + 'pan').st_mode & 0o777)
";
    let expected = "2 22 22 22\n22 22 22 1\n6 4 22 ['bits_per_pixel', 'blank', 'console']\n24\n 420\n";
    let output = run(&["--size", "64x48", "--", "python3", "-c", script]).output().unwrap();
    assert_eq!(text(&output.stdout), expected, "{output:?}");
}

#[test]
fn blanking_by_a_file_shows_black_and_a_file_may_be_written_again() {
    let folder = Folder::new("run-blank");
    let script = |last: &str| {
        format!(
            "printf '\\377\\377\\377' > /dev/fb0
            exec 3> /sys/class/graphics/fb0/blank; echo 1 >&3; echo 0 >&3; echo 4 >&3; {last}
            cat /sys/class/graphics/fb0/name > /dev/null"
        )
    };
    for (last, expected) in [("true", 0), ("echo 0 >&3", 255)] {
        for shell in ["sh", "bash"].into_iter().filter(|shell| tools::are_there(&[shell])) {
            let (_, picture) = picture_of(&folder, &["--size", "16x8"], &[shell, "-c", &script(last)]);
            assert_eq!(picture.get_pixel(0, 0).unwrap()[0], expected, "{shell}: {last}");
        }
    }
}

#[test]
fn programs_that_a_script_starts_and_no_library_reaches_are_told() {
    let folder = Folder::new("run-nested");
    let Some(program) = compiled(&folder, "tutorial.c", &["-static"]) else { return };
    let program = program.to_str().unwrap();
    let script = format!("{program}; {program}; env -i {program}; echo after");
    let output = run(&["--size", "64x48", "--", "sh", "-c", &script]).output().unwrap();
    let said = text(&output.stderr);
    let told: Vec<&str> = said.lines().filter(|line| line.starts_with("fbptr: ")).collect();
    assert_eq!(told.len(), 1, "once: {said}");
    assert!(told[0].starts_with(&format!("fbptr: {program}: is statically linked")), "{said}");
    assert_eq!(text(&output.stdout), "after\n");
}

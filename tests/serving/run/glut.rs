//! Programs that show a memory of their own by GLUT: compiled by `fbptr config` and `fbptr mygl`,
//! and run without GL, an X server or a graphics card. The programs of `glut/` are written for these
//! tests, each in the style of programs of courses.

use super::{picture_of, run, text};
use crate::folder::Folder;
use crate::tools;
use fbptr::memory::VideoMemory;
use fbptr::save::golden::read_png;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Returns the path of a program's source.
fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/serving/run/glut").join(name)
}

/// Returns `fbptr` with a cache of its own in the folder.
fn fbptr(folder: &Folder) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbptr"));
    command.env("XDG_CACHE_HOME", folder.join("cache")).env("XDG_RUNTIME_DIR", folder.join("links"));
    command.stdin(Stdio::null()).env_remove("BLESS").env_remove("LD_PRELOAD").env_remove("DISPLAY");
    std::fs::create_dir_all(folder.join("links")).unwrap();
    command
}

/// Compiles a program with the options of `fbptr config`, or returns `None` without a compiler.
fn compiled(folder: &Folder, name: &str) -> Option<String> {
    let compiler = if name.ends_with(".c") { "cc" } else { "c++" };
    if !tools::are_there(&[compiler]) {
        return None;
    }
    let config = fbptr(folder).args(["config", "--cflags", "--libs"]).output().unwrap();
    assert!(config.status.success(), "{config:?}");
    let options = text(&config.stdout);
    let program = folder.join("student");
    let mut command = Command::new(compiler);
    command.arg("-o").arg(&program).arg(source(name)).args(options.split_whitespace());
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    Some(program.display().to_string())
}

/// Runs a program until its picture is still.
fn still(folder: &Folder, options: &[&str], program: &[&str]) -> (Output, VideoMemory) {
    let options = [&["--after", "still:300ms"], options].concat();
    picture_of(folder, &options, program)
}

fn is_down_picture(picture: &VideoMemory, (width, height): (u32, u32), alpha: u8) {
    assert_eq!((picture.width(), picture.height()), (width, height));
    for y in 0..height {
        for x in 0..width {
            let expected = [x % 256, y % 256, (x + 2 * y) % 256].map(|v| v as u8);
            let found = picture.get_pixel(x as i32, y as i32).unwrap();
            assert_eq!(found, [expected[0], expected[1], expected[2], alpha], "{x},{y}");
        }
    }
}

#[test]
fn a_textured_memory_is_the_picture_pixel_for_pixel_and_opaque() {
    let folder = Folder::new("glut-down");
    let Some(program) = compiled(&folder, "down.cpp") else { return };
    let (output, picture) = still(&folder, &[], &[&program]);
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
    is_down_picture(&picture, (512, 512), 255);
    let (_, picture) = still(&folder, &["--alpha"], &[&program]);
    is_down_picture(&picture, (512, 512), 0);
    // A larger frame has the window in its middle, enlarged.
    let (_, picture) = still(&folder, &["--size", "1040x1024"], &[&program]);
    assert_eq!(picture.get_pixel(8 + 2 * 100, 2 * 7).unwrap(), [100, 7, 114, 255]);
}

#[test]
fn the_memory_is_lit_as_soon_as_it_is_stored_to() {
    let folder = Folder::new("glut-pause");
    let Some(program) = compiled(&folder, "down.cpp") else { return };
    let (_, picture) = still(&folder, &[], &[&program, "pause", "40"]);
    let lit = picture.bytes().as_chunks::<4>().0.iter().filter(|p| p[..3] == [255, 200, 100]).count();
    assert_eq!(lit, 40);
}

#[test]
fn the_picture_of_after_is_whole_where_each_frame_is_cleared_and_drawn() {
    let folder = Folder::new("glut-slow");
    let Some(program) = compiled(&folder, "down.cpp") else { return };
    for after in ["300ms", "410ms", "523ms"] {
        let (output, picture) =
            picture_of(&folder, &["--after", after], &[&program, "slow", "0", "200", "100"]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        is_down_picture(&picture, (200, 100), 255);
    }
}

#[test]
fn stores_outside_of_the_memory_are_counted_and_change_nothing() {
    let folder = Folder::new("glut-outside");
    let Some(program) = compiled(&folder, "down.cpp") else { return };
    let rest = "stored outside the video memory; the first at";
    for (words, size, expected) in [
        (&["behind", "5"][..], (512, 512), format!("20 bytes {rest} FBptr[1048576], x = 0, y = 512")),
        (&["before"], (512, 512), format!("4 bytes {rest} FBptr[-4], x = 511, y = -1")),
        (&["wide"], (512, 512), format!("8 bytes {rest} FBptr[1048584], x = 2, y = 512")),
        // The memory's last page is not full: what is not zero in its rest counts.
        (&["behind", "2", "100", "75"], (100, 75), format!("6 bytes {rest} FBptr[30000], x = 0, y = 75")),
    ] {
        let (output, picture) = still(&folder, &[], &[&[program.as_str()], words].concat());
        is_down_picture(&picture, size, 255);
        let said = text(&output.stderr);
        if cfg!(target_arch = "x86_64") || words.len() == 4 {
            assert_eq!(said, format!("fbptr: {expected}\n"), "{words:?}");
        } else {
            assert!(said.contains("at least 1 byte stored outside"), "{words:?}: {said}");
        }
    }
}

#[test]
fn mygl_compiles_old_frameworks_with_headers_beside_them_and_y_up() {
    let folder = Folder::new("glut-up");
    if !tools::are_there(&["cc"]) {
        return;
    }
    let snap = folder.join("snap.png");
    let mut command = fbptr(&folder);
    command.arg("mygl").arg(source("up")).args(["--headless", "--after", "still:300ms", "--snap"]).arg(&snap);
    let output = command.output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
    let picture = read_png(&snap).unwrap();
    assert_eq!((picture.width(), picture.height()), (320, 240));
    for y in 0..240 {
        for x in 0..320 {
            let up = 239 - y;
            let expected = [if x == up && x < 200 { 255 } else { 0 }, if up == 0 { 128 } else { 0 }, 0, 255];
            assert_eq!(picture.get_pixel(x, y).unwrap(), expected, "{x},{y}");
        }
    }
    // Nothing is left of it: no folder of links, none of objects.
    assert_eq!(std::fs::read_dir(folder.join("links")).unwrap().count(), 0);
}

#[test]
fn makefiles_find_headers_and_libraries_by_the_environment() {
    let folder = Folder::new("glut-make");
    if !tools::are_there(&["make", "g++"]) {
        return;
    }
    let copy = folder.join("copy");
    std::fs::create_dir(&copy).unwrap();
    for name in ["Makefile", "down.cpp"] {
        std::fs::copy(source(name), copy.join(name)).unwrap();
    }
    let snap = folder.join("snap.png");
    let mut command = fbptr(&folder);
    command.arg("mygl").arg(&copy).args(["--headless", "--after", "still:300ms", "--snap"]).arg(&snap);
    let output = command.args(["--", "behind", "5"]).output().unwrap();
    assert!(text(&output.stderr).contains("fbptr: 20 bytes stored outside"), "{output:?}");
    is_down_picture(&read_png(&snap).unwrap(), (512, 512), 255);
    // The same by hand, and run by a shell, which is not linked with GLUT itself.
    std::fs::remove_file(copy.join("student")).unwrap();
    let env = fbptr(&folder).args(["config", "--env"]).output().unwrap();
    let script = format!("{}\nmake -s -C '{}'", text(&env.stdout), copy.display());
    assert!(Command::new("sh").args(["-c", &script]).status().unwrap().success());
    let student = copy.join("student").display().to_string();
    let (_, picture) = still(&folder, &["--glut"], &["sh", "-c", &format!("{student}; true")]);
    is_down_picture(&picture, (512, 512), 255);
}

#[test]
fn callbacks_come_with_what_keys_and_pointer_do() {
    let folder = Folder::new("glut-callbacks");
    let Some(program) = compiled(&folder, "pixels.c") else { return };
    let keys = folder.join("keys.txt");
    let events = [
        "press a",
        "key down leftshift",
        "press b",
        "press left",
        "key up leftshift",
        "press f11",
        "mouse 10 20 0",
        "mouse 10 20 1",
        "mouse 30 40 1",
        "mouse 30 40 0",
        "wheel 0 1",
        "press escape",
    ];
    let lines: Vec<String> =
        events.iter().enumerate().map(|(i, event)| format!("{}ms {event}\n", 200 + 80 * i)).collect();
    std::fs::write(&keys, lines.concat()).unwrap();
    let (output, picture) = picture_of(&folder, &["--keys", keys.to_str().unwrap()], &[&program]);
    let expected = "reshape 120 80\ntimer 7 1\nkey 97 0 0\nkey up 97\nkey 66 0 0\nkey up 66\nspecial 100 with 1\n\
        special 11 with 0\npassive 10 20\nmouse 0 0 10 20\nmotion 30 40\nmouse 0 1 30 40\nmouse 3 0 30 40\n\
        mouse 3 1 30 40\nkey 27 30 40\n";
    assert_eq!((text(&output.stdout).as_str(), output.status.code()), (expected, Some(3)), "{output:?}");
    for y in 0..80 {
        for x in 0..120 {
            let expected = [2 * x as u8, 3 * (79 - y) as u8, 7, 255];
            assert_eq!(picture.get_pixel(x, y).unwrap(), expected, "{x},{y}");
        }
    }
}

#[test]
fn an_allocation_of_three_bytes_a_pixel_is_the_memory_with_its_first_row_below() {
    let folder = Folder::new("glut-rgb");
    let Some(program) = compiled(&folder, "pixels.c") else { return };
    let (_, picture) = still(&folder, &[], &[&program, "own"]);
    for y in 0..80 {
        for x in 0..120 {
            let expected = if y == 79 { [9, x as u8, 0, 255] } else { [0, 0, 0, 255] };
            assert_eq!(picture.get_pixel(x, y).unwrap(), expected, "{x},{y}");
        }
    }
}

#[test]
fn parts_of_the_window_are_copied_and_drawing_with_opengl_is_told() {
    let folder = Folder::new("glut-parts");
    let Some(program) = compiled(&folder, "parts.c") else { return };
    let (output, picture) = still(&folder, &[], &[&program]);
    for y in 0..40 {
        for x in 0..60 {
            let up = 39 - y;
            let expected = match (x, up) {
                (4..=35, 4..=35) => [16 * ((x - 4) / 2) as u8, 16 * ((35 - up) / 2) as u8, 0, 255],
                (40..=41, 0..=2) => [255, 128, 0, 255],
                (42..=43, 0..=2) => [0, 255, 0, 255],
                (50, 39) => [100, 100, 100, 255],
                _ => [0, 0, 255, 255],
            };
            assert_eq!(picture.get_pixel(x, y).unwrap(), expected, "{x},{y}");
        }
    }
    let why = "draws with OpenGL itself, which is not served: one picture is, by glDrawPixels or on a textured \
               rectangle";
    assert_eq!(text(&output.stderr), format!("fbptr: glBegin: {why}\nfbptr: glCallList: {why}\n"));
}

#[test]
fn a_program_that_ends_before_its_window_keeps_its_status() {
    let folder = Folder::new("glut-early");
    let Some(program) = compiled(&folder, "down.cpp") else { return };
    // A size of nothing leaves the window as it is by default; a shell ends with its own status.
    let output = run(&["--glut", "--", "sh", "-c", "exit 5"]).output().unwrap();
    assert_eq!(output.status.code(), Some(5), "{output:?}");
    let output = run(&["--after", "300ms", "--", &program, "draw", "0", "9999", "1"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

const SHEET: &str = "\
title: figures
size: 64x48
input: exact
item: points
points: 2
exact:
    PX 3 4 ff8000
    PX 60 40 00ff10
item: lines
exact:
    LINE 2 5 50 5 ff0000
item: ramp
exact:
    LINE 2 5 50 5 ff0000 0000ff
item: triangle
points: 3
partly: 30%
exact:
    TRI 10 10 30 12 5 20 00ffff
item: fill
exact:
    FILL 10 10 30 12 5 20 00ffff
";

/// Grades a folder's own functions.
fn called(name: &str) -> Option<(String, String)> {
    graded(SHEET, &["--calls"], &source(name))
}

/// Grades a folder by a sheet, of which not all points are reached.
fn graded(sheet: &str, options: &[&str], program: &Path) -> Option<(String, String)> {
    let folder = Folder::new("grade-folder");
    if !tools::are_there(&["cc", "c++", "make"]) {
        return None;
    }
    let path = folder.join("a.sheet");
    std::fs::write(&path, sheet).unwrap();
    let mut command = fbptr(&folder);
    command.arg("grade").arg(&path).args(options).arg("--").arg(program);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    Some((text(&output.stdout), text(&output.stderr)))
}

#[test]
fn grade_calls_functions_whatever_records_their_points_and_colours_are_in() {
    let Some((result, said)) = called("called") else { return };
    assert!(said.contains("LINE  draw_line(Dot from, Dot to, bool fill)"), "{said}");
    assert!(said.contains("FILL  no function for FILL is found"), "{said}");
    for line in [
        "2 of 2     points: right",
        "1 of 1     lines: right",
        "0 of 1     ramp: ",
        "% right: ",
        "no function for FILL",
    ] {
        assert!(result.contains(line), "{line}: {result}");
    }
    assert!(said.contains("DrawTriangle(int a[], int b[], int c[], std::vector<int> color)"), "{said}");
}

#[test]
fn grade_calls_functions_without_colours_and_judges_what_is_lit() {
    let Some((result, said)) = called("called_c") else { return };
    assert!(said.contains("PX    putPixel(struct point *p, octet r, octet g, octet b, octet a)"), "{said}");
    for line in [
        "2 of 2     points: right",
        "1 of 1     lines: right",
        "drawLine(int a, int b, int c, int d) takes no",
    ] {
        assert!(result.contains(line), "{line}: {result}");
    }
}

/// The figures of [`SHEET`] with a colour for each corner, and filled ones at fractions of a pixel.
const COLORS: &str = "\
title: colours
size: 64x48
input: exact
tolerance: 1
item: points
exact:
    PX 3 4 ff8000
    PX 60 40 00ff10
item: ramp
exact:
    LINE 50 5 2 30 ff0000 0000ff
item: triangle
exact:
    TRI 10 10 30 12 5 20 00ffff ff0000 00ff00
item: fill
exact:
    FILL 10.25 10.4 30 12 4.6 20.25 00ffff
";

#[test]
fn grade_calls_functions_in_many_notations_and_says_which_it_cannot_call() {
    let Some((result, said)) = graded(COLORS, &["--calls"], &source("notations")) else { return };
    for line in [
        "PX    PutPixel(int linha, int coluna, unsigned int cor) [cor: 0xAABBGGRR]",
        "LINE  DrawLine(Ponto de, Ponto ate, Cor cores[]) [colours from 0 to 1]",
        "TRI   DrawTriangle(Vertice a, Vertice b, Vertice c, Cor ca, Cor cb, Cor cc) [",
        "FILL  no function for FILL is understood: FillTriangle(",
    ] {
        assert!(said.contains(line), "{line}: {said}");
    }
    for item in ["points", "ramp", "triangle"] {
        assert!(result.contains(&format!("    1 of 1     {item}: right\n")), "{item}: {result}{said}");
    }
    assert!(result.contains("it is static in another file, so it cannot be called"), "{result}");
}

#[test]
fn a_call_that_does_not_compile_costs_its_items_and_whole_corners_are_rounded() {
    let Some((result, said)) = graded(COLORS, &["--calls"], &source("broken")) else { return };
    assert!(result.contains("1 of 1     points: right\n"), "{result}{said}");
    let lost = "0 of 1     ramp: the call of DrawLine(Ponto p, Ponto q, Cor c) does not compile: undefined reference";
    assert!(result.contains(lost), "{result}{said}");
    assert!(result.contains("triangle: no function for TRI is found"), "{result}{said}");
    assert!(result.contains("1 of 1     fill: with rounded corners: right\n"), "{result}{said}");
}

#[test]
fn a_program_that_does_not_compile_has_no_points_and_its_first_error() {
    let folder = Folder::new("grade-no-program");
    let source = folder.join("student one");
    std::fs::create_dir(&source).unwrap();
    std::fs::write(source.join("main.c"), "int main(void) {\n    return nothing;\n}\nvoid MyGlDraw() {}\n")
        .unwrap();
    // A Makefile that asks is not answered.
    std::fs::write(source.join("Makefile"), "all:\n\t@read answer && cc main.c\n").unwrap();
    for options in [&[][..], &["--calls"]] {
        let Some((result, _)) = graded(COLORS, options, &source) else { return };
        let first = "does not compile: main.c:2:12: error: 'nothing' undeclared";
        assert_eq!(result.matches(first).count(), 4, "{result}");
        assert!(result.ends_with("\n0 of 4 points\n"), "{result}");
    }
    let Some((json, _)) = graded(COLORS, &["--json"], &source) else { return };
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(json["items"][3]["text"].as_str().unwrap().contains("'nothing' undeclared"), "{json}");
    let empty = folder.join("empty");
    std::fs::create_dir(&empty).unwrap();
    let Some((result, _)) = graded(COLORS, &["--calls"], &empty) else { return };
    assert!(result.contains("0 of 1     points: no function MyGlDraw is defined"), "{result}");
}

//! Runs every demo as a reader would: headless, some frames, a snapshot. The picture must equal the
//! stored one.

use fbptr::memory::VideoMemory;
use fbptr::save::golden::{self, Mode, Tolerance, assert_golden};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Limit of a program's run time; one that hangs is killed and fails.
const PATIENCE: Duration = Duration::from_secs(60);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the folder of the demos' programs, after building them with the profile of this test.
fn programs() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        // The path is target/PROFILE/deps/this-test.
        let own = std::env::current_exe().expect("this program has a file");
        let profile = own.ancestors().nth(2).expect("target/PROFILE");
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--quiet", "--locked", "--examples", "--target-dir"]);
        cargo.arg(profile.parent().expect("target")).current_dir(root());
        match profile.file_name().and_then(|n| n.to_str()) {
            Some("debug") => {}
            Some(name) => drop(cargo.args(["--profile", name])),
            None => panic!("{} is no folder of a profile", profile.display()),
        }
        if !cfg!(feature = "window") {
            cargo.args(["--no-default-features", "--features", "cli"]);
        }
        assert!(cargo.status().expect("cargo runs").success(), "the demos do not build");
        profile.join("examples")
    })
}

/// Runs a program to its end, or kills it when it takes too long.
fn run(program: &Path, arguments: &[&str]) -> Output {
    let mut child = Command::new(program)
        .args(arguments)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|e| panic!("{}: {e}", program.display()));
    let started = Instant::now();
    while child.try_wait().expect("a child can be asked").is_none() {
        if started.elapsed() > PATIENCE {
            let _ = child.kill();
            panic!("{} {arguments:?} did not end", program.display());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().expect("its output can be read")
}

/// Returns the last of `frames` frames of a demo.
fn picture(demo: &str, frames: &str) -> VideoMemory {
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("demo-{demo}-{frames}.png"));
    let _ = std::fs::remove_file(&file);
    let name = file.to_str().expect("a name of UTF-8");
    let output = run(&programs().join(demo), &["--headless", "--frames", frames, "--snap", name]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.is_empty(), "{demo}: {} {errors}", output.status);
    golden::read_png(&file).unwrap_or_else(|e| panic!("{demo}: {e}"))
}

/// Returns the path of a picture of the docs. `BLESS=1 cargo test --test cli demos` rewrites them
/// all.
fn gallery_file(name: &str) -> PathBuf {
    root().join("docs/pictures").join(format!("{name}.png"))
}

/// The gallery: every demo, and the number of frames after which its picture is taken.
const GALLERY: [(&str, &str); 25] = [
    ("memory_map", "1"),
    ("lines", "1"),
    ("triangles", "1"),
    ("bresenham", "13"),
    ("wire_cube", "30"),
    ("frustum", "5"),
    ("gouraud_teapot", "1"),
    ("phong_teapot", "1"),
    ("zbuffer", "30"),
    ("painter", "5"),
    ("depth_precision", "1"),
    ("affine_texture", "5"),
    ("transparency", "5"),
    ("pixelflut_wall", "5"),
    ("tcp_client", "5"),
    ("plotter", "60"),
    ("flatland", "5"),
    ("tesseract", "12"),
    ("line_room", "280"),
    ("pong", "60"),
    ("snake", "90"),
    ("paint", "1"),
    ("fountain", "120"),
    ("plasma", "60"),
    ("raycaster", "1"),
];

#[test]
fn the_gallery_is_what_the_demos_draw_today() {
    let check = |(demo, frames): (&str, &str)| {
        golden::check(&picture(demo, frames), gallery_file(demo), Tolerance::EXACT, Mode::from_env())
    };
    let failures: Vec<String> =
        GALLERY.into_iter().filter_map(|d| check(d).err()).map(|e| e.to_string()).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_demo_is_in_the_gallery_and_every_picture_is_of_something_that_is_tested() {
    let names = |folder: &str, ending: &str| -> Vec<String> {
        let entries = std::fs::read_dir(root().join(folder)).expect("readable");
        let names = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned());
        let mut names: Vec<String> = names.filter_map(|n| Some(n.strip_suffix(ending)?.to_owned())).collect();
        names.sort();
        names
    };
    let mut demos: Vec<String> = GALLERY.iter().map(|(name, _)| (*name).to_owned()).collect();
    demos.sort();
    assert_eq!(names("demos", ".rs"), demos);
    demos.extend(STREAMS.map(str::to_owned));
    demos.push("tour".to_owned());
    demos.sort();
    assert_eq!(names("docs/pictures", ".png"), demos);
    let page = std::fs::read_to_string(root().join("docs/gallery.md")).expect("there is a page");
    for name in demos {
        assert!(page.contains(&format!("(pictures/{name}.png)")), "docs/gallery.md does not show {name}");
    }
    for (name, frames) in GALLERY {
        let command = format!("cargo run --release --example {name} -- --headless --frames {frames}");
        assert!(page.contains(&command), "docs/gallery.md does not say {command:?}");
    }
}

/// Streams of the gallery that are one picture.
const STREAMS: [&str; 2] = ["projections", "view_volume"];

#[test]
fn the_streams_of_the_gallery_draw_its_pictures_without_a_word() {
    let page = std::fs::read_to_string(root().join("docs/gallery.md")).expect("there is a page");
    for name in STREAMS {
        let (picture, output) = play(&root().join(format!("demos/{name}.fbs")), name);
        assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
        assert_golden(&picture, gallery_file(name), Tolerance::EXACT);
        let command = format!("cargo run --release -- play demos/{name}.fbs --headless --snap {name}.png");
        assert!(page.contains(&command), "docs/gallery.md does not say {command:?}");
    }
}

/// Pictures of the viewer's page: their names, and the commands.
const OF_THE_VIEWER: [(&str, &str); 3] = [
    ("model", "render suzanne --studio -o model.png"),
    (
        "split_depth",
        "view suzanne --headless --studio on --size 960x720 --split depth --snap split_depth.png",
    ),
    ("cell24", "view cell24 --headless --studio on --size 640x480 --frames 60 --snap cell24.png"),
];

#[test]
fn the_viewers_pictures_are_what_the_commands_beside_them_draw() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("viewer-pictures");
    std::fs::create_dir_all(&folder).expect("a folder");
    let page = std::fs::read_to_string(root().join("docs/viewer.md")).expect("there is a page");
    let check = |(name, command): (&str, &str)| {
        let line = format!("fbptr {command}");
        assert!(page.contains(&format!("\n    {line}\n")), "docs/viewer.md does not say {line:?}");
        let arguments: Vec<&str> = line.split(' ').skip(1).collect();
        let output = Command::new(env!("CARGO_BIN_EXE_fbptr"))
            .args(arguments)
            .current_dir(&folder)
            .output()
            .expect("it starts");
        assert!(output.status.success(), "{line}: {output:?}");
        let drawn = golden::read_png(&folder.join(format!("{name}.png"))).expect("a picture");
        let kept = gallery_file(&format!("viewer/{name}"));
        golden::check(&drawn, kept, Tolerance::EXACT, Mode::from_env())
    };
    let failures: Vec<String> =
        OF_THE_VIEWER.into_iter().filter_map(|p| check(p).err()).map(|e| e.to_string()).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn what_moves_moves_and_what_is_still_is_still() {
    let demos = [
        ("wire_cube", true),
        ("phong_teapot", true),
        ("tcp_client", true),
        ("flatland", true),
        ("tesseract", true),
        ("line_room", true),
        ("zbuffer", true),
        ("bresenham", true),
        ("frustum", true),
        ("affine_texture", true),
        ("painter", true),
        ("transparency", true),
        ("pixelflut_wall", true),
        ("plotter", true),
        ("lines", false),
        ("depth_precision", false),
    ];
    for (demo, moves) in demos {
        let (first, second) = (picture(demo, "1"), picture(demo, "2"));
        let difference = golden::compare(&first, &second, 0).expect("one size");
        assert_eq!(difference.pixels > 0, moves, "{demo}: {difference:?}");
    }
}

#[test]
fn without_a_display_a_demo_says_so_and_goes_on() {
    let output = run(&programs().join("wire_cube"), &["--frames", "2"]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.contains("going on headless"), "{} {errors}", output.status);
    let output = run(&programs().join("wire_cube"), &[]);
    assert!(output.status.success(), "without a number of frames it ends as well");
    let output = run(&programs().join("lines"), &["--frames", "many"]);
    assert_eq!(output.status.code(), Some(2));
    let output = run(&programs().join("lines"), &["--headless", "--snap", "no/such/folder/a.png"]);
    assert_eq!(output.status.code(), Some(1));
}

/// Plays a stream headless and returns its last frame and its output.
fn play(stream: &Path, name: &str) -> (VideoMemory, Output) {
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
    let (stream, snap) = (stream.to_str().expect("UTF-8"), file.to_str().expect("UTF-8"));
    let program = Path::new(env!("CARGO_BIN_EXE_fbptr"));
    let output = run(program, &["play", stream, "--headless", "--snap", snap]);
    (golden::read_png(&file).unwrap_or_else(|e| panic!("{name}: {e}")), output)
}

#[test]
fn the_readmes_first_command_makes_the_movie_at_its_top() {
    let page = std::fs::read_to_string(root().join("README.md")).expect("there is a page");
    let command = page.lines().find_map(|l| l.strip_prefix("cargo run --release ")).expect("a command");
    let words: Vec<&str> = command.split('#').next().expect("words").split_whitespace().collect();
    assert!(words.is_empty(), "the first command has no arguments: {command}");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("readme-tour");
    std::fs::create_dir_all(&folder).expect("a folder");
    let output = Command::new(env!("CARGO_BIN_EXE_fbptr"))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .current_dir(&folder)
        .output()
        .expect("it starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.contains("saved tour.png and tour.gif"), "{errors}");
    let last = golden::read_png(&folder.join("tour.png")).expect("a picture");
    assert_eq!([last.width(), last.height()], [960, 540]);
    let made = std::fs::read(folder.join("tour.gif")).expect("a movie");
    assert!(made.len() < 2_000_000, "{} bytes", made.len());
    let file = root().join("docs/pictures/tour.gif");
    let is_shown = std::fs::read(&file).is_ok_and(|shown| shown == made);
    if !is_shown && std::env::var_os("BLESS").is_some() {
        std::fs::write(&file, &made).expect("writable");
    }
    // As everywhere, the run that accepts a new picture fails.
    assert!(is_shown, "docs/pictures/tour.gif was not what the tour draws; BLESS=1 replaces it");
}

#[test]
fn the_pages_numbers_of_a_pixel_are_those_that_the_trace_prints() {
    let page = std::fs::read_to_string(root().join("docs/trace.md")).expect("there is a page");
    let shown = page.split("```text\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a block");
    let stream = root().join("demos/ball.fbs");
    let arguments = ["--headless", "--size", "64x48", "--trace", "36,20"];
    let output = Command::new(env!("CARGO_BIN_EXE_fbptr")).arg("play").arg(stream).args(arguments).output();
    let output = output.expect("it starts");
    let printed = String::from_utf8_lossy(&output.stdout);
    let mut lines = printed.lines();
    for line in shown.lines() {
        assert!(lines.any(|printed| printed == line), "not printed, or not in this order: {line}");
    }
    assert!(output.status.success() && shown.lines().count() > 8);
}

#[test]
fn the_tour_goes_from_one_pixel_to_the_phong_teapot() {
    let tour = root().join("demos/tour.fbs");
    let (last, output) = play(&tour, "tour");
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let crc = format!("CRC {:08x}\n", fbptr::save::crc32(&last));
    assert_eq!(String::from_utf8_lossy(&output.stdout), crc);
    assert_golden(&last, gallery_file("tour"), Tolerance::EXACT);

    // Each step by itself shows something, and something other than the step before.
    let text = std::fs::read_to_string(&tour).expect("readable");
    let ends: Vec<usize> = text.match_indices("\nPRESENT\n").map(|(at, end)| at + end.len()).collect();
    assert_eq!(ends.len(), 9);
    let mut before = VideoMemory::new(480, 360).expect("a frame");
    for (step, end) in (1..).zip(ends) {
        let part = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("tour-{step}.fbs"));
        std::fs::write(&part, &text[..end]).expect("writable");
        let (frame, output) = play(&part, &format!("tour-{step}"));
        assert!(output.status.success(), "step {step}: {output:?}");
        let changed = golden::compare(&before, &frame, 0).expect("one size").pixels;
        assert!(changed > 100, "step {step} changes {changed} pixels");
        before = frame;
    }
    assert_eq!(before.bytes(), last.bytes());
}

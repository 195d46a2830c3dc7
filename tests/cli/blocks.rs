//! The shell blocks of the pages run as they are printed.
//!
//! Right is: every line of every `sh` block, except those that [`EXCUSES`] names with a reason, ends
//! with status 0 within a time limit where the files that it names are there, and the pictures and
//! movies that it writes have the checksums in `blocks.txt` (`BLESS=1` accepts new ones). The page's
//! own port is replaced by a free one. Console sessions of protocol.md, Python and Rust blocks have
//! tests of their own (`tests/serving/shell.rs`, `python/tests/test_readme.py`, doc tests).

use crate::folder::Folder;
use crate::tools;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Parts of lines that are not run, each with its reason.
const EXCUSES: &[(&str, &str)] = &[
    ("cargo ", "CI calls it, or it takes minutes"),
    (".ci/run", "calls this test"),
    (".ci/nightly", "fuzzes for minutes, and calls other tests"),
    ("BLESS=1", "changes what tests compare with"),
    ("pip install", "needs a registry; .ci/python does it"),
    ("sudo ", "changes the machine"),
    ("docker ", "needs a daemon of its own"),
    ("ffmpeg ", "another program's pictures"),
    ("x11vnc ", "another program's server"),
    ("serve ...", "the dots stand for the reader's options"),
    ("--listen 0.0.0.0", "listens beyond this machine"),
    ("HOST ", "stands for the reader's machine"),
    ("http://127.0.0.1:9100", "the metrics of a server whose line has dots"),
    ("fbptr serve --shm /tmp/fb", "opens a window and runs until it is closed"),
    ("cd clients/templates", "builds in the tree; tests of the templates do it elsewhere"),
    ("./main /tmp/fb", "draws on the server of such a line"),
    ("fbptr serve --headless --size 640x480 --shm", "for x11vnc in the next line"),
    ("links2 ", "another program; docs/run.md tells what it needs"),
    ("linuxfb", "a Qt program"),
    ("QT_QPA", "for a Qt program"),
    ("fbptr report", "takes minutes; tests/cli/report.rs runs it on small pictures"),
    ("fbptr eye --bench", "takes minutes"),
    ("--frames 1000", "takes minutes; tests/cli/batch.rs runs it with fewer frames"),
    ("batch ", "follows such a line"),
    ("demos/fb/plasma.c", "runs until its window is closed; tests/serving/run draws the demos"),
    ("demos/fb/pong.py", "runs until its window is closed"),
    ("--crt -- python3", "runs until its window is closed"),
    ("fbptr mygl student  ", "runs until its window is closed; the next line does not"),
    ("fbptr run -- ./a.out", "runs until its window is closed; tests/serving/run/glut.rs"),
    ("config --env", "the same with a Makefile of the reader's; tests/serving/run/glut.rs"),
    ("--glut -- gdb", "waits for the debugger's user"),
    ("#SBATCH", "a scheduler's line"),
    ("-- ./my-gui --fullscreen", "opens a window and ends with it; the same program runs in the other lines"),
    ("--keys tests/", "a file of the reader's"),
    ("--type ", "types to a program of the reader's; tests/serving/run/input.rs"),
    ("fbptr.course", "needs the Python package; python/tests/test_course.py"),
    ("fbptr grade ", "needs a program of the reader's; tests/cli/grade.rs"),
    ("secret", "the rest of the line before"),
    ("\" --after still", "the rest of the line before"),
];

/// Seconds after which a line has failed.
const SECONDS: &str = "120";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the lines of a page's `sh` blocks, by block; a line that ends in `\` goes on in the next.
fn blocks(page: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(root().join(page)).expect("a page");
    let parts = text.split("\n```sh\n").skip(1);
    let block = |part: &str| {
        let body = part.split("\n```").next().unwrap_or_default().replace("\\\n", " ");
        body.lines().filter(|line| !line.trim().is_empty()).map(str::to_owned).collect()
    };
    parts.map(block).collect()
}

/// Returns the pages of a folder.
fn pages_of(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(root().join(folder)).expect("a folder");
    let names = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned());
    names.filter(|name| name.ends_with(".md")).map(|name| format!("{folder}/{name}")).collect()
}

fn excuse(line: &str) -> Option<&'static str> {
    EXCUSES.iter().find(|(part, _)| line.contains(part)).map(|(part, _)| *part)
}

/// Makes the files that the lines name: a scene, a stream, a program that draws on /dev/fb0.
fn prepare(folder: &Path) {
    let copy = |from: &str, to: &str| {
        let target = folder.join(to);
        std::fs::create_dir_all(target.parent().expect("a folder")).expect("a folder");
        std::fs::copy(root().join(from), target).unwrap_or_else(|e| panic!("{from}: {e}"));
    };
    copy("crates/formats/data/cornell.x3d", "scene.x3d");
    copy("tests/data/meshes/assimp/box.obj", "model.obj");
    for file in std::fs::read_dir(root().join("demos")).expect("demos") {
        let name = file.expect("an entry").file_name().into_string().expect("UTF-8");
        if name.ends_with(".fbs") {
            copy(&format!("demos/{name}"), &format!("demos/{name}"));
        }
    }
    for name in ["fb.py", "text_mode.py"] {
        copy(&format!("demos/fb/{name}"), &format!("demos/fb/{name}"));
    }
    for font in ["crates/core/src/draw2d/cp437.txt", "crates/core/src/draw2d/font8x8.txt"] {
        copy(font, font);
    }
    for name in ["include/mygl.h", "src/main.c", "src/mygl.c"] {
        copy(&format!("tests/serving/run/glut/up/{name}"), &format!("student/{name}"));
    }
    std::fs::write(folder.join("picture.fbs"), "CIRCLE 32 24 20 gold\n").expect("writable");
    let gui = "#!/usr/bin/env python3\nwith open('/dev/fb0', 'r+b') as fb: fb.write(b'\\x40\\x80\\xff\\xff' * 4000)\n\
               import time; time.sleep(3)\n";
    for name in ["my-gui", "draws-and-ends"] {
        let text = if name == "my-gui" { gui } else { gui.split("import").next().expect("a part") };
        std::fs::write(folder.join(name), text).expect("writable");
        let run = Command::new("chmod").arg("+x").arg(folder.join(name)).status().expect("chmod");
        assert!(run.success());
    }
}

/// Returns a port that was free a moment ago.
fn free_port() -> u16 {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    listener.local_addr().expect("an address").port()
}

/// Returns the checksums of the pictures and movies of a folder, by name.
fn pictures(folder: &Path) -> Vec<(String, u32)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder").map(|e| e.expect("an entry").path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else if entry.extension().is_some_and(|e| ["png", "gif", "apng", "ppm"].iter().any(|k| e == *k))
            {
                let bytes = std::fs::read(&entry).expect("readable");
                // The pixels of a PNG, whose bytes depend on the version of a library.
                let pixels =
                    fbptr::save::golden::read_png(&entry).map(|picture| fbptr::save::crc32(&picture));
                found.push((entry.display().to_string(), pixels.unwrap_or_else(|_| crc32fast::hash(&bytes))));
            }
        }
    }
    found.sort();
    found
}

/// Runs one block in a folder of its own. Returns its pictures as lines, and what went wrong.
fn run(page: &str, number: usize, lines: &[&str]) -> (String, Option<String>) {
    let own = Folder::new("blocks");
    let folder: &Path = own.as_ref();
    prepare(folder);
    let bin = Path::new(env!("CARGO_BIN_EXE_fbptr")).parent().expect("a folder");
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap_or_default());
    // A server of the block's own ends with it; it needs a moment before the next line.
    let port = free_port().to_string();
    let lines = lines.iter().map(|line| line.replace("1234", &port));
    let listen =
        |line: &str| line.replace("fbptr serve", &format!("fbptr serve --headless --listen :{port}"));
    let steps = lines.map(|line| match line.split(" #").next().unwrap_or_default().trim_end() {
        server if server.contains("fbptr serve") => format!("{}\nserver=$!\nsleep 1\n", listen(server)),
        // The picture that was expected has a checksum, too.
        line if line.contains("fbptr run") => line.replace("--expect", "--snap x.png --expect") + "\n",
        line => line.to_owned() + "\n",
    });
    let script: String = steps.collect();
    std::fs::create_dir_all(folder.join("shots")).expect("a folder");
    for [size, golden] in [["640x480", "start.png"], ["480x272", "shots/start.png"]] {
        let made = Command::new(bin.join("fbptr"))
            .args(["run", "--headless", "--size", size, "--snap", golden, "--", "./draws-and-ends"])
            .current_dir(folder)
            .output();
        assert!(made.is_ok_and(|made| made.status.success()), "the picture to compare with");
    }
    let whole = format!("set -e\ntrap 'test -z \"$server\" || kill $server' EXIT\n{script}");
    let output = Command::new("timeout")
        .args([SECONDS, "sh", "-c", &whole])
        .env("PATH", path)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("BLESS")
        .env("XDG_CACHE_HOME", folder.join("cache"))
        .stdin(std::process::Stdio::null())
        .current_dir(folder)
        .output()
        .expect("timeout and sh");
    let mut text = String::new();
    for (file, crc) in pictures(folder) {
        // Made before the block, to compare with.
        if file.ends_with("start.png") {
            continue;
        }
        let name = Path::new(&file).strip_prefix(folder).expect("inside").display().to_string();
        let _ = writeln!(text, "{page} {number} {name} {crc:08x}");
    }
    let problem = (!output.status.success()).then(|| {
        format!(
            "{page}, block {number}: {}\n{}\n{script}",
            output.status,
            String::from_utf8_lossy(&output.stderr)
        )
    });
    (text, problem)
}

#[test]
fn every_shell_block_runs_as_it_is_printed() {
    if !tools::are_there(&["sh", "timeout", "python3", "nc", "cc"]) {
        return tools::skip("the blocks need sh, timeout, python3, nc and cc");
    }
    let mut pages: Vec<String> =
        ["docs", "docs/course", "docs/curso"].into_iter().flat_map(pages_of).collect();
    pages.extend(["README.md", "CONTRIBUTING.md", "python/README.md"].map(str::to_owned));
    pages.sort();
    let (mut made, mut problems, mut ran) = (String::new(), Vec::new(), 0);
    let mut used = BTreeSet::new();
    for page in &pages {
        for (number, block) in (1..).zip(blocks(page)) {
            used.extend(block.iter().filter_map(|line| excuse(line)));
            let lines: Vec<&str> =
                block.iter().map(String::as_str).filter(|line| excuse(line).is_none()).collect();
            if lines.is_empty() {
                continue;
            }
            ran += lines.len();
            let (pictures, problem) = run(page, number, &lines);
            made.push_str(&pictures);
            problems.extend(problem);
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    assert!(ran >= 15, "only {ran} lines ran");
    let unused: Vec<&str> =
        EXCUSES.iter().map(|(part, _)| *part).filter(|part| !used.contains(part)).collect();
    assert!(unused.is_empty(), "no line needs these excuses: {unused:?}");
    compare(&made);
}

#[test]
fn the_readmes_client_draws_on_a_server() {
    if !tools::are_there(&["sh", "timeout", "python3"]) {
        return;
    }
    let text = std::fs::read_to_string(root().join("README.md")).expect("a page");
    let mut programs = text.split("```python\n").skip(1).filter_map(|rest| rest.split("```").next());
    let program = programs.find(|program| program.contains("from fbptr import Client")).expect("a block");
    let own = Folder::new("client");
    let folder: &Path = own.as_ref();
    let port = free_port().to_string();
    let clients = root().join("clients/python").display().to_string();
    let program = program.replace("1234", &port).replace("clients/python", &clients);
    std::fs::write(folder.join("client.py"), program).expect("writable");
    let script = format!(
        "set -e\ntrap 'kill $server' EXIT\n\"$0\" serve --headless --size 640x480 --listen :{port} &\nserver=$!\nsleep 1\n\
         python3 client.py"
    );
    let output = Command::new("timeout")
        .args([SECONDS, "sh", "-c", &script, env!("CARGO_BIN_EXE_fbptr")])
        .current_dir(folder)
        .output()
        .expect("timeout and sh");
    assert!(output.status.success(), "{output:?}");
    let picture = fbptr::save::golden::read_png(&folder.join("picture.png")).expect("a picture");
    assert_eq!(picture.get_pixel(0, 0), Ok([255, 0, 0, 255]));
    assert_eq!(picture.get_pixel(639, 479), Ok([255, 255, 0, 255]));
}

/// Compares the checksums with those of the golden file.
fn compare(made: &str) {
    let golden: PathBuf = root().join("tests/cli/blocks.txt");
    let kept = std::fs::read_to_string(&golden).unwrap_or_default();
    if kept != made && std::env::var_os("BLESS").is_some() {
        std::fs::write(&golden, made).expect("writable");
    }
    assert_eq!(kept, made, "BLESS=1 accepts the new pictures; look at them first");
}

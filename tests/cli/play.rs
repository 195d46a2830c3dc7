//! Tests of `fbptr play` and `fbptr render` on the command line: exit status, messages, files.

use crate::folder::Folder;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn fbptr(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbptr"));
    command.args(arguments);
    command
}

pub fn run(arguments: &[&str], input: &[u8]) -> Output {
    let mut child =
        fbptr(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let input = input.to_vec();
    let writer = std::thread::spawn(move || {
        // The program may have ended before it read everything.
        let _ = stdin.write_all(&input);
    });
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    output
}

pub fn out(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap()
}

pub fn err(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).unwrap()
}

impl Folder {
    pub fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).unwrap();
        path.to_str().unwrap().to_owned()
    }

    pub fn path(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }
}

#[test]
fn a_scene_reads_above_its_folder_where_a_root_allows_it() {
    let folder = Folder::new("root");
    std::fs::create_dir_all(folder.path("a/scenes")).unwrap();
    folder.file("a/box.x3d", "<Scene><Shape><Box/></Shape></Scene>");
    folder.file("a/look.mtl", "newmtl red\nKd 1 0 0\n");
    let scene = folder
        .file("a/scenes/s.x3d", "<Scene><Inline url='../box.x3d'/><Inline url='../../../up.x3d'/></Scene>");
    let mesh =
        folder.file("a/scenes/m.obj", "mtllib ../look.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
    let (picture, root) = (folder.path("p.ppm"), folder.path("a"));
    let lit = || std::fs::read(&picture).unwrap()[15..].iter().filter(|b| **b != 0).count();
    let without = run(&["render", &scene, "-o", &picture, "--size", "64x48"], b"");
    assert!(without.status.success());
    assert!(
        err(&without).contains("s.x3d:1:8: warning: Inline [\"../box.x3d\"] lies outside of the folder"),
        "{}",
        err(&without)
    );
    assert!(
        err(&without).contains(&format!("fbptr: --root DIR lets {scene} read files above its own folder"))
    );
    assert_eq!(lit(), 0);
    let with = run(&["render", &scene, "-o", &picture, "--size", "64x48", "--root", &root], b"");
    assert!(with.status.success() && lit() > 300, "{}", err(&with));
    assert!(!err(&with).contains("box.x3d") && err(&with).contains("up.x3d"), "{}", err(&with));
    let with = run(&["render", &mesh, "-o", &picture, "--size", "64x48", "--root", &root], b"");
    assert!(with.status.success() && err(&with).is_empty(), "{}", err(&with));
    let view =
        run(&["view", &scene, "--headless", "--snap", &picture, "--size", "64x48", "--root", &root], b"");
    assert!(view.status.success() && lit() > 300, "{}", err(&view));
    let elsewhere = folder.path("b");
    std::fs::create_dir_all(&elsewhere).unwrap();
    let wrong = run(&["render", &scene, "-o", &picture, "--root", &elsewhere], b"");
    assert_eq!(wrong.status.code(), Some(2));
    assert!(err(&wrong).contains("does not lie in it"), "{}", err(&wrong));
}

#[test]
fn a_stream_from_standard_input_answers_on_stdout() {
    let script = b"PX 1 1 ff0000\nLINE 0 0 9 5 00ff00\nCRC\n";
    let played = run(&["play", "-", "--headless", "--size", "10x6"], script);
    assert_eq!((played.status.code(), err(&played)), (Some(0), ""));
    // LINE 0 0 9 5 worked out by hand: one pixel per column, rows 0 1 1 2 2 3 3 4 4 5, ties along
    // the major axis.
    let mut frame = [[0, 0, 0, 255u8]; 60];
    frame[10 + 1] = [255, 0, 0, 255];
    for (x, y) in [0, 1, 1, 2, 2, 3, 3, 4, 4, 5].into_iter().enumerate() {
        frame[y * 10 + x] = [0, 255, 0, 255];
    }
    assert_eq!(out(&played), format!("CRC {:08x}\n", crc32fast::hash(frame.as_flattened())));
}

#[test]
fn a_refused_command_is_said_with_its_line_and_the_rest_is_drawn() {
    let folder = Folder::new("refused");
    let script = b"PX 1 1 ff0000\nLINE 0 0 nine 5 00ff00\nPX 2 1 0000ff\nPX 2 1\n";
    let played = run(&["play", "-", "--headless", "--size", "10x6"], script);
    assert_eq!((played.status.code(), out(&played)), (Some(1), "PX 2 1 0000ff\n"));
    assert!(
        err(&played).starts_with("fbptr: -:2: ENUM LINE: ") && err(&played).ends_with(", got \"nine\"\n"),
        "{}",
        err(&played)
    );
    let file = folder.file("a b.fbs", script);
    let played = run(&["play", &file, "--headless", "--size", "10x6"], b"");
    assert_eq!(played.status.code(), Some(1));
    assert!(err(&played).starts_with(&format!("fbptr: {file}:2: ENUM LINE: ")), "{}", err(&played));
    // `ERRORS count` makes no difference here, `ERRORS close` does.
    let played = run(&["play", "--headless"], b"ERRORS count\nNOPE\nSIZE\n");
    assert_eq!((played.status.code(), out(&played)), (Some(1), "SIZE 640 480\n"));
    assert!(err(&played).starts_with("fbptr: -:2: EVERB NOPE: "), "{}", err(&played));
    let played = run(&["play", "--headless"], b"ERRORS close\nNOPE\nSIZE\n");
    assert_eq!((played.status.code(), out(&played)), (Some(1), ""));
}

#[test]
fn only_a_regular_file_may_end_without_its_last_lf() {
    let folder = Folder::new("lf");
    let file = folder.file("s", "SIZE\nSIZE");
    let played = run(&["play", &file, "--headless", "--size", "3x2"], b"");
    assert_eq!((played.status.code(), out(&played)), (Some(0), "SIZE 3 2\nSIZE 3 2\n"));
    let played = run(&["play", "-", "--headless", "--size", "3x2"], b"SIZE\nSIZE");
    assert_eq!((played.status.code(), out(&played)), (Some(1), "SIZE 3 2\n"));
    assert!(err(&played).starts_with("fbptr: -:2: EPROTO SIZE: "), "{}", err(&played));
    let file = folder.file("half", "BLIT 0 0 1 1 :4\nab");
    let played = run(&["play", &file, "--headless"], b"");
    assert_eq!(played.status.code(), Some(1), "half a payload is no command anywhere");
}

#[test]
fn bad_arguments_have_status_2() {
    let folder = Folder::new("arguments");
    let there = folder.file("s", "SIZE\n");
    let nowhere = folder.path("nowhere");
    let cases: [&[&str]; 7] = [
        &["play", &nowhere, "--headless"],
        &["play", &folder.path(""), "--headless"],
        &["play", &there, "--headless", "--size", "0x0"],
        &["play", &there, "--headless", "--size", "99999x99999"],
        &["play", &there, "--headless", "--snap", "picture.xyz"],
        &["play", &there, "--nonsense"],
        &["nonsense"],
    ];
    for arguments in cases {
        let played = run(arguments, b"");
        assert_eq!((played.status.code(), out(&played)), (Some(2), ""), "{arguments:?}");
        assert!(!err(&played).is_empty());
    }
    assert!(err(&run(cases[0], b"")).contains(&nowhere));
}

#[test]
fn snapshots_and_depth_are_written_at_the_end() {
    let folder = Folder::new("snap");
    let (raw, png, pfm) = (folder.path("a.raw"), folder.path("a.png"), folder.path("a.pfm"));
    let script = b"CLEAR 102030\nMESH b BOX\nDRAW b\nDEPTHAT 16 12\nCRC\n";
    let arguments = ["play", "-", "--headless", "--size", "32x24", "--snap", &raw, "--depth-out", &pfm];
    let played = run(&arguments, script);
    assert_eq!(played.status.code(), Some(0), "{}", err(&played));
    let bytes = std::fs::read(&raw).unwrap();
    let [depth, crc] = out(&played).lines().collect::<Vec<_>>()[..] else { panic!("{}", out(&played)) };
    assert_eq!(crc, format!("CRC {:08x}", crc32fast::hash(&bytes)));
    let depths = std::fs::read(&pfm).unwrap();
    let header = b"Pf\n32 24\n-1.0\n";
    assert!(depths.starts_with(header));
    // Rows bottom-up: row 12 from the top is row 11 from below.
    let at = header.len() + (11 * 32 + 16) * 4;
    let z = f32::from_le_bytes(depths[at..at + 4].try_into().unwrap());
    let asked: f64 = depth.strip_prefix("DEPTHAT 16 12 ").unwrap().parse().unwrap();
    assert!((f64::from(z) - asked).abs() < 1e-7 && z < 1.0, "{z} and {asked}");
    assert_eq!(depths[header.len()..header.len() + 4], 1f32.to_le_bytes(), "1 where nothing was drawn");
    assert!(run(&["play", "-", "--headless", "--size", "4x4", "--snap", &png], b"").status.success());
    assert!(std::fs::read(&png).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn quit_ends_the_stream_and_queries_keep_their_order() {
    let played =
        run(&["play", "--headless", "--size", "4x3"], b"SYNC 1\nPX 0 0 ff0000\nPX 0 0\nQUIT\nSYNC 2\nNOPE\n");
    assert_eq!((played.status.code(), out(&played), err(&played)), (Some(0), "SYNC 1\nPX 0 0 ff0000\n", ""));
}

#[cfg(unix)]
#[test]
fn a_pipe_that_nobody_reads_panics_nowhere() {
    for (arguments, script) in [
        (&["play", "--headless"][..], b"CRC\n".repeat(20_000)),
        (&["play", "--headless"], b"NOPE\n".repeat(20_000)),
        (&["serve", "--headless", "--stdin"], b"CRC\n".repeat(20_000)),
        (&["--help"], Vec::new()),
    ] {
        let mut child = fbptr(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Both outputs are closed before the program writes anything.
        drop((child.stdout.take(), child.stderr.take()));
        let mut stdin = child.stdin.take().unwrap();
        let _ = stdin.write_all(&script);
        drop(stdin);
        let status = child.wait().unwrap();
        assert!(matches!(status.code(), Some(0 | 1)), "{arguments:?}: {status}");
    }
}

#[test]
fn a_played_stream_may_load_and_save_in_its_folders_alone() {
    let folder = Folder::new("folders");
    folder.file("tri.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let script = b"LOAD MESH t tri.obj\nDRAW t\nPICK 8 8\nSNAP s.raw\n";
    let root = folder.path("");
    let played =
        run(&["play", "--headless", "--size", "16x16", "--load-dir", &root, "--snap-dir", &root], script);
    assert_eq!(played.status.code(), Some(0), "{}", err(&played));
    assert!(out(&played).starts_with("PICK 8 8 t 0\nSNAP s.raw 16 16 "), "{}", out(&played));
    assert!(Path::new(&folder.path("s.raw")).exists());
    let played = run(&["play", "--headless"], script);
    assert_eq!(err(&played).matches("EPERM").count(), 2, "{}", err(&played));
}

#[test]
fn a_scene_is_rendered_and_explained_and_a_broken_one_is_placed() {
    let folder = Folder::new("render");
    let picture = folder.path("p.raw");
    let obj = folder.file("tri.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let x3d = folder.file(
        "s.x3d",
        "<X3D><Scene><Shape><Appearance><Material diffuseColor='1 0 0'/></Appearance><Box/></Shape></Scene></X3D>",
    );
    for scene in [&obj, &x3d] {
        let rendered = run(&["render", scene, "-o", &picture, "--size", "20x20", "--explain"], b"");
        assert_eq!(rendered.status.code(), Some(0), "{}", err(&rendered));
        let bytes = std::fs::read(&picture).unwrap();
        assert!(bytes[(20 * 10 + 10) * 4] > 50, "something red or grey is in the middle");
        assert!(out(&rendered).starts_with("plan: "), "{}", out(&rendered));
    }
    let flat = folder.path("flat.png");
    let frames =
        run(&["render", &x3d, "-o", &flat, "--size", "8x8", "--frames", "2", "--shade", "flat"], b"");
    assert_eq!(frames.status.code(), Some(0), "{}", err(&frames));
    assert!(
        Path::new(&folder.path("flat-0000.png")).exists()
            && Path::new(&folder.path("flat-0001.png")).exists()
    );
    let broken = folder.file("broken.x3d", "<X3D>\n<Scene>\n<Shape>\n</Scene></X3D>");
    let refused = run(&["render", &broken, "-o", &picture], b"");
    assert_eq!(refused.status.code(), Some(1));
    assert!(err(&refused).starts_with(&format!("fbptr: {broken}:4:")), "{}", err(&refused));
    for arguments in [
        &["render", &folder.path("none.x3d"), "-o", &picture][..],
        &["render", &obj, "-o", "p.xyz"],
        &["render", &picture, "-o", &picture],
        &["render", &x3d, "-o", &picture, "--near", "5", "--far", "2"],
        &["render", &x3d, "-o", &picture, "--near", "nan"],
    ] {
        assert_eq!(run(arguments, b"").status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn a_background_is_given_by_name_or_in_hex() {
    for color in ["tomato", "ff6347", "#FF6347", "ff6347ff"] {
        let output = run(
            &["play", "-", "--headless", "--size", "4x3", "--background", color],
            b"PX 3 2\nPX 0 0 rebeccapurple\nPX 0 0\n",
        );
        assert_eq!(out(&output), "PX 3 2 ff6347\nPX 0 0 663399\n", "{color}: {}", err(&output));
    }
    let output = run(&["play", "-", "--headless", "--background", "reddish"], b"");
    assert_eq!(output.status.code(), Some(2));
    assert!(err(&output).contains("CSS name"), "{}", err(&output));
    // Behind a mesh, too.
    let folder = Folder::new("background");
    let obj = folder.file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let picture = folder.path("a.ppm");
    let output = run(&["render", &obj, "-o", &picture, "--size", "8x8", "--background", "gold"], b"");
    assert!(output.status.success(), "{}", err(&output));
    let ppm = std::fs::read(&picture).unwrap();
    assert_eq!(ppm[ppm.len() - 3..], [255, 215, 0]);
}

#[test]
fn a_trace_ends_in_the_bytes_of_the_picture() {
    let folder = Folder::new("trace");
    let obj = folder.file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n");
    let picture = folder.path("a.raw");
    let traced = run(&["render", &obj, "-o", &picture, "--size", "20x20", "--trace", "9,10"], b"");
    assert!(traced.status.success(), "{}", err(&traced));
    let bytes = std::fs::read(&picture).unwrap();
    let offset = (20 * 10 + 9) * 4;
    let [r, g, b, a] = bytes[offset..][..4] else { panic!("{} bytes", bytes.len()) };
    assert_ne!([r, g, b], [0; 3], "the pixel is on the triangle");
    let last = format!("bytes       {r} {g} {b} {a} = #{r:02x}{g:02x}{b:02x} at FBptr[{offset}]");
    assert!(out(&traced).contains(&last), "{last}\n{}", out(&traced));
    // The second triangle faces away; there is no third.
    let away = run(&["render", &obj, "--size", "20x20", "--trace", "1"], b"");
    assert!(away.status.success() && out(&away).contains("left out by CULL"), "{}", out(&away));
    for (probe, status, word) in [("2", 1, "below 2"), ("0,0", 1, "no triangle"), ("x", 2, "--trace")] {
        let refused = run(&["render", &obj, "--size", "20x20", "--trace", probe], b"");
        assert_eq!(refused.status.code(), Some(status), "{probe}: {}", err(&refused));
        assert!(err(&refused).contains(word), "{probe}: {}", err(&refused));
    }
}

#[test]
fn numbers_below_zero_and_names_for_depth_are_refused_by_what_they_are() {
    let folder = Folder::new("refusals");
    let obj = folder.file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (arguments, word) in [
        (["render", &obj, "-o", "a.png", "--near", "-1"], "--near"),
        (["render", &obj, "-o", "a.png", "--max-error", "-1"], "--max-error"),
        (["render", &obj, "-o", "a.png", "--depth-out", "a.txt"], ".pfm"),
        (["play", "-", "--headless", "--paused", "--depth-out", "a.txt"], ".pfm"),
    ] {
        let refused = run(&arguments, b"CRC\n");
        assert_eq!((refused.status.code(), out(&refused)), (Some(2), ""), "{}", err(&refused));
        assert!(err(&refused).contains(word) && !err(&refused).contains("unexpected"), "{}", err(&refused));
    }
}

#[test]
fn a_bench_may_have_another_size() {
    let row =
        run(&["bench", "W5_gouraud70k", "--size", "64x48", "--frames", "1", "--threads", "1", "--json"], b"");
    assert_eq!(row.status.code(), Some(0), "{}", err(&row));
    assert!(out(&row).contains(r#""wl":"W5_gouraud70k""#) && out(&row).contains("med_ms"), "{}", out(&row));
    for (size, word) in [("0x48", "a size is"), ("64", "a size is"), ("32768x32768", "limit")] {
        let refused = run(&["bench", "W5_gouraud70k", "--size", size], b"");
        assert_eq!((refused.status.code(), out(&refused)), (Some(2), ""), "{size}: {}", err(&refused));
        assert!(err(&refused).contains(word), "{size}: {}", err(&refused));
    }
}

#[test]
fn the_program_describes_itself() {
    let said = |arguments: &[&str]| {
        let output = run(arguments, b"");
        assert_eq!((output.status.code(), err(&output)), (Some(0), ""), "{arguments:?}");
        out(&output).to_owned()
    };
    assert_eq!(said(&["--version"]), concat!("fbptr ", env!("CARGO_PKG_VERSION"), "\n"));
    let verbs =
        ["play", "bench", "report", "serve", "render", "view", "snap", "send", "eye", "man", "completions"];
    let folder = Folder::new("man");
    let pages = folder.path("pages");
    assert_eq!(said(&["man", "--out", &pages]), "");
    let page = |name: &str| std::fs::read_to_string(Path::new(&pages).join(name)).unwrap();
    assert_eq!(said(&["man"]), page("fbptr.1"));
    let (help, whole) = (said(&["--help"]), page("fbptr.1"));
    assert!(whole.contains("\n.TH fbptr 1 ") && whole.contains("\n.SH EXAMPLES"), "{whole}");
    for verb in verbs {
        assert!(help.lines().any(|l| l.starts_with(&format!("  {verb} "))), "{verb}: {help}");
        assert!(whole.contains(&format!("fbptr\\-{verb}(1)")), "{verb}: {whole}");
        let (text, own) = (page(&format!("fbptr-{verb}.1")), said(&[verb, "--help"]));
        assert!(text.contains(&format!("\n.TH fbptr-{verb} 1 ")), "{text}");
        for heading in [".SH SYNOPSIS", ".SH OPTIONS", ".SH EXAMPLES"] {
            assert!(text.contains(&format!("\n{heading}\n")), "{verb}: {heading}: {text}");
        }
        assert!(own.contains("\nUsage: fbptr ") && own.contains("\nExamples:\n"), "{verb}: {own}");
    }
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = said(&["completions", shell]);
        for word in verbs.iter().chain(&["headless", "trace"]) {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_a_full_disk_does_not_take_is_a_failure() {
    let folder = Folder::new("full");
    let mesh = folder.file("m.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let stream = folder.file("s", "HELP\nCRC\n");
    for arguments in [
        &["play", &stream, "--headless"][..],
        &["render", &mesh, "--trace", "0"],
        &["render", &mesh, "--trace", "0", "--explain", "-o", &folder.path("m.png")],
        &["eye", "--make", "tesseract"],
        &["man"],
        &["completions", "zsh"],
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let ended = fbptr(arguments).stdin(Stdio::null()).stdout(full).output().unwrap();
        let said = err(&ended);
        assert_eq!(ended.status.code(), Some(1), "{arguments:?}: {said}");
        let lost = said.lines().filter(|l| l.starts_with("fbptr: standard output: ")).count();
        assert_eq!(lost, 1, "{arguments:?}: {said}");
    }
}

#[test]
fn a_mistake_is_answered_with_what_to_do_next() {
    let folder = Folder::new("next");
    let mesh = folder.file("m.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let scene = folder.file("n.json", "{\"dim\": 4, \"objects\": []}\n");
    let stream = folder.file("s.fbs", "SIZE\n");
    let nowhere = folder.path("no.sock");
    let picture = folder.path("o.png");
    for (arguments, status, next) in [
        (&["play", &mesh, "--headless"][..], 2, "an OBJ model, which `fbptr view`".to_owned()),
        (&["play", &scene, "--headless"], 1, format!("fbptr view {scene}")),
        (&["send", &stream], 2, format!("fbptr send :1234 {stream}")),
        (&["send", &nowhere, &stream], 1, "fbptr serve".to_owned()),
        (&["snap", &nowhere, &picture], 1, "fbptr serve".to_owned()),
        (&["report", "--out", &stream], 1, format!("cannot make {stream}")),
    ] {
        let ended = run(arguments, b"");
        assert_eq!((ended.status.code(), out(&ended)), (Some(status), ""), "{arguments:?}");
        assert!(err(&ended).contains(&next), "{arguments:?}: {}", err(&ended));
    }
    // A command stream with such a name is played without a remark.
    let played = run(&["play", &folder.file("s.obj", "SIZE\n"), "--headless", "--size", "3x2"], b"");
    assert_eq!((played.status.code(), out(&played), err(&played)), (Some(0), "SIZE 3 2\n", ""));
}

#[test]
fn a_stream_is_traced_to_what_is_seen_in_the_end() {
    // Two quads, the nearer one drawn first: the second draw must not be taken for the visible one.
    let quad = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";
    let stream = format!(
        "MESH quad obj :{}\n{quad}LOOKAT 0 0 5 0 0 0 0 1 0\n\
         MATERIAL 0 0 0 0 0 0 0 0 0 1 1 0 0\nDRAW quad\n\
         TRANSLATE 0 0 -1\nMATERIAL 0 0 0 0 0 0 0 0 0 1 0 1 0\nDRAW quad\nPX 10 10\n",
        quad.len()
    );
    let stream = stream.as_bytes();
    let seen = run(&["play", "-", "--headless", "--size", "20x20", "--trace", "10,10"], stream);
    assert!(seen.status.success(), "{} {}", out(&seen), err(&seen));
    assert!(out(&seen).starts_with("PX 10 10 ff0000\n"), "{}", out(&seen));
    assert!(out(&seen).contains("255 0 0 255 = #ff0000 at FBptr[840]"), "{}", out(&seen));
    // The hidden one is found by its number: triangles are counted through all draws.
    let hidden = run(&["play", "-", "--headless", "--size", "20x20", "--trace", "3@10,10"], stream);
    assert!(out(&hidden).contains("triangle 1 of object 0 \"quad\""), "{}", out(&hidden));
    assert!(out(&hidden).contains("0 255 0 255 = #00ff00"), "{}", out(&hidden));
    let nothing = run(&["play", "-", "--headless", "--size", "20x20", "--trace", "4"], stream);
    assert!(err(&nothing).contains("--trace"), "{}", err(&nothing));
    assert_eq!(nothing.status.code(), Some(1));
}

/// A wedge that looks different from every side.
const WEDGE: &str = "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 .5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

#[test]
fn frames_of_a_scene_without_an_animation_are_one_turn() {
    let folder = Folder::new("turntable");
    let wedge = folder.file("wedge.obj", WEDGE);
    let turned = folder.path("turn.raw");
    let rendered = run(&["render", &wedge, "-o", &turned, "--size", "32x24", "--frames", "4"], b"");
    assert_eq!(rendered.status.code(), Some(0), "{}", err(&rendered));
    let said = format!("fbptr: {wedge} has no animation: the 4 frames are one turn\n");
    assert_eq!(err(&rendered), said);
    let frames: Vec<Vec<u8>> =
        (0..4).map(|i| std::fs::read(folder.path(&format!("turn-{i:04}.raw"))).unwrap()).collect();
    for i in 0..4 {
        assert!(frames[i].iter().any(|b| ![0, 255].contains(b)), "frame {i} shows something");
        assert!(frames[..i].iter().all(|other| *other != frames[i]), "frame {i} is another side");
    }
    let one = folder.path("one.raw");
    let rendered = run(&["render", &wedge, "-o", &one, "--size", "32x24", "--frames", "1"], b"");
    assert_eq!((rendered.status.code(), err(&rendered)), (Some(0), ""));
}

#[test]
fn what_was_probably_meant_is_said() {
    let folder = Folder::new("meant");
    let (model, stream) = (folder.file("model.obj", WEDGE), folder.file("tour.fbs", "SIZE\n"));
    let box_file = folder.file("box", "ply\nformat ascii 1.0\n");
    for (arguments, wanted) in [
        (&[model.as_str()][..], format!("`fbptr view {model}` shows it")),
        (&[stream.as_str()], format!("`fbptr play {stream}` plays it")),
        (&["serv"], "'serve'".to_owned()),
        (&["serve", "--siez", "4x3"], "'--size'".to_owned()),
        (&[box_file.as_str()], format!("`fbptr view {box_file}` shows it")),
        (&["serve", "--listen", "nonsense:port"], "an address is HOST:PORT".to_owned()),
    ] {
        let output = run(arguments, b"");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let said = err(&output);
        assert!(said.starts_with("fbptr: ") && said.contains(&wanted), "{arguments:?}: {said}");
    }
    assert_eq!(run(&["--help"], b"").status.code(), Some(0));
    let played = run(&["play", "-", "--headless"], b"LIEN 0 0 1 1 ff0000\n");
    assert_eq!(err(&played), "fbptr: -:1: EVERB LIEN: unknown verb (did you mean LINE?), got \"LIEN\"\n");
}

#[test]
fn files_of_other_formats_are_named_in_one_line() {
    let folder = Folder::new("magic");
    let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\n1 2\n3 4\n";
    for (name, bytes, what) in [
        ("p.png", &png[..], "a PNG picture"),
        ("p.obj", png, "a PNG picture"),
        ("m.glb", b"BLENDER-v300", "a Blender file"),
        ("m.fbx", b"Kaydara FBX Binary  \0", "an FBX model"),
    ] {
        let file = folder.file(name, bytes);
        let out = folder.path("o.raw");
        for arguments in [
            &["play", &file, "--headless"][..],
            &["view", &file, "--headless"],
            &["render", &file, "-o", &out],
        ] {
            let refused = run(arguments, b"");
            let said = err(&refused);
            assert_eq!(refused.status.code(), Some(2), "{arguments:?}: {said}");
            assert_eq!(said.lines().count(), 1, "{arguments:?}: {said}");
            assert!(said.starts_with(&format!("fbptr: {file}: {what}; expected ")), "{said}");
        }
        let refused = run(&["play", "-", "--headless"], bytes);
        assert_eq!(err(&refused), format!("fbptr: -: {what}; expected a stream of commands\n"));
        assert_eq!(refused.status.code(), Some(1), "{name}");
    }
}

#[test]
fn meshes_without_normals_are_smooth_and_seen_from_both_sides() {
    let folder = Folder::new("smooth");
    let drawn = |command: &str, file: &str, arguments: &[&str]| {
        let out = folder.path("o.raw");
        let to_file: &[&str] =
            if command == "view" { &["--headless", "--snap", &out] } else { &["-o", &out] };
        let all = [&[command, file, "--size", "40x40"], to_file, arguments].concat();
        let output = run(&all, b"");
        assert_eq!((output.status.code(), err(&output)), (Some(0), ""), "{all:?}");
        std::fs::read(&out).unwrap()
    };
    // Two squares that lean against each other, each with its own positions: a seam only if indices
    // decide.
    let roof = folder.file(
        "roof.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 1 0\nv 1 1 0\nv 1 1.87 -0.5\nv 0 1.87 -0.5\nf 1 2 3 4\nf 5 6 7 8\n",
    );
    for command in ["render", "view"] {
        let smooth = drawn(command, &roof, &[]);
        let seams = drawn(command, &roof, &["--smooth", "indices"]);
        assert!(smooth == drawn(command, &roof, &["--smooth", "60deg"]), "{command}");
        assert!(smooth != seams, "{command}");
        assert!(seams == drawn(command, &roof, &["--smooth", "0deg", "--cull", "back"]), "{command}");
    }
    // Two squares side by side that face opposite ways.
    let both = folder.file(
        "both.obj",
        "v -3 -1 0\nv -1 -1 0\nv -1 1 0\nv -3 1 0\nv 1 -1 0\nv 3 -1 0\nv 3 1 0\nv 1 1 0\nf 1 2 3 4\nf 8 7 6 5\n",
    );
    let lit = |picture: &[u8]| picture.chunks(4).filter(|p| p[0] > 100).count();
    for command in ["render", "view"] {
        let [all, fronts, backs] = [&[][..], &["--cull", "back"], &["--cull", "front"]]
            .map(|cull| lit(&drawn(command, &both, cull)));
        assert!(fronts > 40 && backs > 40, "{command}: {fronts} and {backs}");
        assert_eq!(all, fronts + backs, "{command}");
    }
    // A file of points and lines alone is drawn.
    let lines = folder.file("lines.obj", "v -1 -1 0\nv 1 1 0\nv 1 -1 0\nl 1 2\nl -3 3\np 1 2 3\n");
    assert!(drawn("render", &lines, &[]).chunks(4).filter(|p| p[0] > 0).count() > 40);
    let x3d = folder.file("s.x3d", "<Scene><Shape><Box/></Shape></Scene>");
    let out = folder.path("o.raw");
    for arguments in [["--smooth", "60"], ["--smooth", "60deg"], ["--cull", "both"]] {
        let refused = run(&[&["render", &x3d, "-o", &out][..], &arguments].concat(), b"");
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}");
    }
}

//! Tests of recordings and their replay: complete, cut short, damaged, with files, and on disks and
//! pipes that accept nothing.

use super::writer::Patience;
use super::*;
use crate::Stats;
use crate::replay::Replay;
use crate::{Audience, Budget, Engine, Notice, Output, Stream, StreamState};
use fbptr_core::memory::MemoryUse;
use fbptr_formats::load::SandboxDir;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

#[derive(Clone, Default)]
struct WrittenBytes(Arc<Mutex<Vec<u8>>>);

impl Write for WrittenBytes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Runs a script on an engine that records. Returns the memory at its end, the totals and the
/// recording.
fn record(mut engine: Engine, script: &[u8], pieces: usize) -> (Vec<u8>, Stats, Vec<u8>) {
    let bytes_written = WrittenBytes::default();
    let (width, height) = (engine.memory().width(), engine.memory().height());
    engine.attach(Recorder::new(Box::new(bytes_written.clone()), width, height).unwrap());
    let mut stream = Stream::new(&engine, 7, Audience::Owner);
    let mut out = Output::default();
    for piece in script.chunks(pieces) {
        let _ = stream.feed(&mut engine, piece, &mut out, Budget::NONE);
    }
    out.notices.retain(|notice| !matches!(notice, Notice::Remark { .. }));
    assert_eq!(out.notices, [], "the script is in order");
    engine.close(stream.session_mut());
    engine.end();
    assert_eq!(failure(&engine), None);
    let recording = bytes_written.0.lock().unwrap().clone();
    (engine.memory().bytes().to_vec(), engine.totals(), recording)
}

/// Returns the reason for which the recording has ended early, if it has.
fn failure(engine: &Engine) -> Option<String> {
    engine.observer::<Recorder>().and_then(Recorder::failure)
}

/// Replays a recording on `engine`. Returns the memory and totals at its end, and the notices.
fn replay(mut engine: Engine, recording: &[u8]) -> (Vec<u8>, Stats, Vec<Notice>) {
    let (mut replay, mut out) = (Replay::new(), Output::default());
    let _ = replay.feed(&mut engine, recording, &mut out, Budget::NONE);
    replay.finish(&mut engine, &mut out);
    out.notices.retain(|notice| !matches!(notice, Notice::Remark { .. }));
    (engine.memory().bytes().to_vec(), engine.totals(), out.notices)
}

/// Runs a test that draws textured faces: without optimization a draw has more locals than a test's
/// stack holds.
fn on_a_large_stack(test: impl FnOnce() + Send + 'static) {
    let thread = std::thread::Builder::new().stack_size(64 << 20).spawn(test).unwrap();
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
}

/// A folder that is removed after the test.
struct TestFolder(PathBuf);

impl TestFolder {
    fn new(name: &str) -> TestFolder {
        let path = std::env::temp_dir().join(format!("fbptr-record-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        TestFolder(path)
    }

    fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.0.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }
}

impl Drop for TestFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_recording_of_two_connections_plays_to_the_same_memory_however_it_is_cut() {
    let bytes_written = WrittenBytes::default();
    let mut engine = Engine::new(40, 30).unwrap();
    engine.attach(Recorder::new(Box::new(bytes_written.clone()), 40, 30).unwrap());
    let mut streams = [1, 2].map(|id| Stream::new(&engine, id, Audience::Connection));
    let mut out = Output::default();
    let scripts: [&[u8]; 2] = [
        b"OFFSET 5 5\nPX 1 1 ff0000\nBLEND over\nPX 2 1 ff000080\nLINE 0 0 1\nFOO\nMESH m BOX\nSNAP :\n",
        b"PX 1 1 00ff00\nPB\x03\x00\x04\x00abcdTEXT 3 9 ffff00 :3\na\nbLINE 0 29 39 0 ffffff\nPX 1 1 zz\nDRAW m\n",
    ];
    for i in 0..200 {
        for (stream, script) in streams.iter_mut().zip(scripts) {
            let piece = script.iter().skip(i).take(1).copied().collect::<Vec<u8>>();
            let _ = stream.feed(&mut engine, &piece, &mut out, Budget::NONE);
        }
    }
    engine.close(streams[0].session_mut());
    let want = engine.memory().bytes().to_vec();
    drop(engine);
    let recording = bytes_written.0.lock().unwrap().clone();
    assert!(recording.starts_with(b"#!fbptr-record 2 40x30\n#@ "));
    for cut in 1..recording.len() {
        let (mut engine, mut replay) = (Engine::new(40, 30).unwrap(), Replay::new());
        let mut out = Output::default();
        for piece in recording.chunks(cut) {
            assert_eq!(
                replay.feed(&mut engine, piece, &mut out, Budget::NONE),
                (piece.len(), StreamState::Ready)
            );
        }
        replay.finish(&mut engine, &mut out);
        assert_eq!(out.notices, [], "refused commands are not in a recording");
        assert!(engine.memory().bytes() == want, "pieces of {cut}");
    }
}

#[test]
fn surfaces_titles_and_pauses_are_recorded() {
    let script = b"TITLE a title :3\nCANVAS c 20 10\nTARGET c\nCLEAR 00000000\nFILLCIRCLE 9 5 4 tomato\n\
        CLIP 3 3 30 20\nPRINT 1 1 white clipped\nTARGET FRAME\nCLEAR navy\nSTAMP c 2 2 00000000\n\
        TEXTSIZE 2\nPRINT 0 9 #ff0 x :9\nBEZIER 0 0 9 30 20 -9 39 29 3 lime\nPX 1 1 red\nPX 9 9 red\n";
    let engine = || Engine::new(40, 30).unwrap();
    let (want, totals, recording) = record(engine(), script, 7);
    let (bytes, replayed, notices) = replay(engine(), &recording);
    assert_eq!(notices, []);
    assert!(bytes == want, "the replay's bytes");
    assert_eq!(replayed.pixels, totals.pixels);
    let text = String::from_utf8_lossy(&recording);
    assert!(text.contains("TITLE a title :3") && text.contains("STAMP c 2 2 00000000"), "{text}");
}

#[test]
fn a_broken_recording_is_refused_with_its_line() {
    let (mut engine, mut replay) = (Engine::new(4, 3).unwrap(), Replay::new());
    let mut out = Output::default();
    let bytes = b"#!fbptr-record 1 4x3\n#@ 1 0.0 5\nSIZE\n\nPX 1 1 ff0000\n";
    assert_eq!(replay.feed(&mut engine, bytes, &mut out, Budget::NONE), (bytes.len(), StreamState::Ended));
    let [Notice::Refused(refused)] = &out.notices[..] else { panic!("{:?}", out.notices) };
    assert_eq!(refused.place.line, 5);
}

#[test]
fn floods_of_pixels_replay_to_the_same_bytes_and_counts() {
    let mut script = String::new();
    let mut state = 5_u32;
    let mut next = |n: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) % n
    };
    let offsets =
        ["0 0", "3 -2", "-7 9", "65530 0", "-65536 4", "2147483647 2147483647", "-2147483648 0", "0 0"];
    for (i, offset) in offsets.iter().enumerate() {
        script += &format!("OFFSET {offset}\nBLEND {}\n", if i % 2 == 1 { "over" } else { "replace" });
        for _ in 0..2500 {
            let [x, y] = [next(70), next(40)].map(|c| if next(50) == 0 { c + 65_490 } else { c });
            script += &format!("PX {x} {y} {:08x}\n", next(1 << 24) << 8 | next(256));
        }
        script += "PX -1 +5 ff0000\nLINE 0 0 20 9 ffffff80\n";
    }
    for pieces in [usize::MAX, 100_000, 1_003] {
        let (memory, totals, recording) = record(Engine::new(64, 32).unwrap(), script.as_bytes(), pieces);
        let (replayed, replayed_totals, notices) = replay(Engine::new(64, 32).unwrap(), &recording);
        assert_eq!(notices, []);
        assert!(memory == replayed, "pieces of {pieces}");
        assert_eq!(replayed_totals, Stats { bytes: replayed_totals.bytes, ..totals });
        assert!(totals.clipped > 5000 && totals.pixels > 5000, "{totals:?}");
        assert!(recording.len() < script.len(), "{} bytes for {}", recording.len(), script.len());
    }
}

/// A folder with meshes, scenes and pictures that refer to each other.
fn folder_of_files(name: &str) -> TestFolder {
    let folder = TestFolder::new(name);
    let mut picture = Vec::new();
    let texels = [255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 0, 255];
    image::ImageEncoder::write_image(
        image::codecs::png::PngEncoder::new(&mut picture),
        &texels,
        2,
        2,
        image::ExtendedColorType::Rgba8,
    )
    .unwrap();
    folder.put("sub/texels.png", &picture);
    folder.put("sub/paint.mtl", "newmtl p\nKd 1 1 1\nKa 1 1 1\nmap_Kd texels.png\n");
    let corners = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
    folder.put("sub/m.obj", format!("mtllib paint.mtl\nusemtl p\n{corners}f 1/1 2/2 3/3\n"));
    let shape = "<Shape><Appearance><Material emissiveColor='0 1 0'/><ImageTexture url='\"texels.png\"'/></Appearance>\
                 <Box size='3 3 3'/></Shape>";
    folder.put("sub/part.x3d", format!("<X3D><Scene>{shape}</Scene></X3D>"));
    folder.put("whole.x3d", "<X3D><Scene><Inline url='\"absent.x3d\" \"sub/part.x3d\"'/></Scene></X3D>");
    let mut tga = Vec::new();
    image::ImageEncoder::write_image(
        image::codecs::tga::TgaEncoder::new(&mut tga),
        &texels,
        2,
        2,
        image::ExtendedColorType::Rgba8,
    )
    .unwrap();
    folder.put("only-its-name-tells.tga", &tga);
    folder
}

fn with_folder(folder: &Path) -> Engine {
    let mut engine = Engine::new(80, 60).unwrap();
    engine.set_load_dir(SandboxDir::open(folder).unwrap());
    engine
}

const VIEW: &str = "AMBIENT white\nLOOKAT 0 0 6 0 0 0 0 1 0\nPERSPECTIVE 1 .1 100\nVIEWPORT 0 0 40 60\n";

fn script_with_files() -> String {
    let scene = "<X3D><Scene><Inline url='\"whole.x3d\"'/></Scene></X3D>";
    let object = "mtllib sub/paint.mtl\nusemtl p\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    format!(
        "{VIEW}LOAD MESH m sub/m.obj\nDRAW m\nLOAD TEX t only-its-name-tells.tga\nTEXTURE t\nMESH b BOX\nDRAW b\n\
         TEXTURE OFF\nTRANSLATE 1 1 0\nMESH n OBJ :{}\n{object}DRAW n\nVIEWPORT 40 0 40 60\n\
         SCENE X3D :{}\n{scene}DRAWSCENE\nVIEWPORT 20 30 40 30\nLOAD SCENE whole.x3d\nDRAWSCENE\n",
        object.len(),
        scene.len(),
    )
}

#[test]
fn files_that_commands_read_are_in_the_recording() {
    on_a_large_stack(|| {
        let folder = folder_of_files("files");
        let script = script_with_files();
        let (memory, totals, recording) = record(with_folder(&folder.0), script.as_bytes(), usize::MAX);
        let mut colors: Vec<&[u8]> = memory.chunks(4).collect();
        colors.sort_unstable();
        colors.dedup();
        assert!(colors.len() > 8, "the textures are seen: {} colours", colors.len());
        // Without a folder, and with a folder whose files of the same names differ.
        let other = TestFolder::new("other-files");
        other.put("absent.x3d", "<X3D><Scene/></X3D>");
        other.put("sub/texels.png", "no picture");
        for engine in [Engine::new(80, 60).unwrap(), with_folder(&other.0)] {
            let (replayed, replayed_totals, notices) = replay(engine, &recording);
            assert_eq!(notices, []);
            assert!(replayed == memory, "the replay looks different");
            assert_eq!(replayed_totals.commands, totals.commands);
        }
        // The result is the same however the recording is split.
        for cut in [1, 7, 64] {
            let (mut engine, mut replay) = (Engine::new(80, 60).unwrap(), Replay::new());
            let mut out = Output::default();
            for piece in recording.chunks(cut) {
                let _ = replay.feed(&mut engine, piece, &mut out, Budget::NONE);
            }
            replay.finish(&mut engine, &mut out);
            out.notices.retain(|notice| !matches!(notice, Notice::Remark { .. }));
            assert!(out.notices.is_empty() && engine.memory().bytes() == memory, "pieces of {cut}");
        }
    });
}

#[test]
fn a_file_that_is_read_often_stands_once_in_the_recording() {
    let folder = TestFolder::new("once");
    let object = format!("# {}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "x".repeat(100_000));
    folder.put("a.obj", &object);
    folder.put("b.obj", &object);
    let script = "LOAD MESH m a.obj\nLOAD MESH m b.obj\n".repeat(20);
    let (_, totals, recording) = record(with_folder(&folder.0), script.as_bytes(), usize::MAX);
    assert!(recording.len() < 110_000, "{} bytes", recording.len());
    let (_, replayed, notices) = replay(Engine::new(80, 60).unwrap(), &recording);
    assert_eq!((replayed.commands, notices), (totals.commands, vec![]));
}

#[test]
fn recordings_of_version_1_read_the_folder_and_need_no_end() {
    on_a_large_stack(|| {
        let folder = folder_of_files("version-1");
        let script = format!("{VIEW}LOAD MESH m sub/m.obj\nDRAW m\n");
        let recording = format!("#!fbptr-record 1 80x60\n#@ 1 0.1 {}\n{script}\n", script.len());
        let (memory, ..) = record(with_folder(&folder.0), script.as_bytes(), usize::MAX);
        let (replayed, _, notices) = replay(with_folder(&folder.0), recording.as_bytes());
        assert_eq!(notices, []);
        assert!(replayed == memory);
        let (_, _, notices) = replay(Engine::new(80, 60).unwrap(), recording.as_bytes());
        assert_eq!(notices.len(), 2, "without the folder there is no mesh: {notices:?}");
        let (_, _, notices) = replay(Engine::new(8, 6).unwrap(), b"#!fbptr-record 3 8x6\n");
        assert!(matches!(&notices[..], [Notice::Refused(c)] if c.fault.message.contains("version 1 or 2")));
    });
}

#[test]
fn a_recording_that_ends_early_says_so_wherever_it_ends() {
    let folder = folder_of_files("early");
    let mut script = format!("PX 1 1 ff0000\n{}PX 2 2 00ff00\n", script_with_files());
    // Without the draws, the commands that read files remain, and run many times faster.
    for draw in ["DRAW m\n", "DRAW b\n", "DRAW n\n", "DRAWSCENE\n"] {
        script = script.replace(draw, "");
    }
    let (memory, _, recording) = record(with_folder(&folder.0), script.as_bytes(), usize::MAX);
    let whole = replay(Engine::new(80, 60).unwrap(), &recording);
    assert_eq!((whole.0, whole.2), (memory, vec![]));
    let first_line = recording.iter().position(|b| *b == b'\n').unwrap() + 1;
    let end = recording.len() - 1;
    for cut in (first_line..end).step_by(7).chain([end - 20, end]) {
        let (_, _, notices) = replay(Engine::new(80, 60).unwrap(), &recording[..cut]);
        let is_told = |n: &Notice| matches!(n, Notice::Refused(c) if c.fault.message.contains("ends early"));
        assert!(notices.last().is_some_and(is_told), "cut at {cut} of {end}: {notices:?}");
    }
}

#[test]
fn files_that_are_none_end_the_replay() {
    for files in ["1 1\n", "1 1 -\na", "x 1 1\nab", "1 5 1\nab", "1 1 99999999999999999999\nab", "no line"] {
        let recording = format!("#!fbptr-record 2 4x3\n#@ 1 0.0 files {}\n{files}\n", files.len());
        let (_, _, notices) = replay(Engine::new(4, 3).unwrap(), recording.as_bytes());
        let [Notice::Refused(refused)] = &notices[..] else { panic!("{files:?}: {notices:?}") };
        assert_eq!(refused.fault.code, fbptr_core::error::Code::Proto, "{files:?}");
    }
}

#[test]
fn recordings_with_wrong_bytes_end_in_order() {
    let folder = folder_of_files("wrong-bytes");
    let script = "PX 1 1 ff0000\nLOAD MESH m sub/m.obj\nMESH b BOX\nPX 2 2 00ff00\nQUIT\n";
    let (.., recording) = record(with_folder(&folder.0), script.as_bytes(), usize::MAX);
    let mut state = 3_u32;
    let mut next = |n: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % n
    };
    let mut refused = 0;
    for _ in 0..3000 {
        let mut wrong = recording.clone();
        for _ in 0..=next(3) {
            let at = next(wrong.len());
            match next(3) {
                0 => wrong[at] = next(256) as u8,
                1 => drop(wrong.remove(at)),
                _ => wrong[at] = b"0123456789 -\n#"[next(14)],
            }
        }
        refused += usize::from(!replay(Engine::new(8, 6).unwrap(), &wrong).2.is_empty());
    }
    assert!((1000..3000).contains(&refused), "{refused} of 3000 were refused");
}

fn ask(engine: &mut Engine, request: &[u8]) -> String {
    let mut stream = Stream::new(engine, 9, Audience::Owner);
    let mut out = Output::default();
    let _ = stream.feed(engine, request, &mut out, Budget::NONE);
    String::from_utf8(out.replies).unwrap()
}

/// A disk that is full from the second write on.
struct FullDisk(WrittenBytes, usize);

impl Write for FullDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.1 += 1;
        if self.1 > 1 { Err(io::ErrorKind::StorageFull.into()) } else { self.0.write(bytes) }
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_told_at_once_and_the_commands_go_on() {
    let (bytes_written, (sender, receiver)) = (WrittenBytes::default(), mpsc::channel());
    let mut engine = Engine::new(8, 6).unwrap();
    let on_failure: super::writer::OnFailure = Box::new(move |e: &io::Error| sender.send(e.kind()).unwrap());
    let disk = Box::new(FullDisk(bytes_written.clone(), 0));
    engine.attach(Recorder::start(disk, Patience::FILE, Some(on_failure), 8, 6).unwrap());
    assert!(ask(&mut engine, b"STATS\n").contains(" record=ok "));
    ask(&mut engine, b"PX 1 1 ff0000\n");
    engine.tick(std::time::Instant::now() + Duration::from_secs(1));
    assert_eq!(receiver.recv_timeout(Duration::from_secs(30)), Ok(io::ErrorKind::StorageFull));
    let figures = " record=failed record_bytes=21 record_queue=0";
    assert!(ask(&mut engine, b"STATS\n").contains(figures));
    engine.tick(std::time::Instant::now());
    assert!(failure(&engine).is_some());
    // The recorder has been dropped; its counters are still reported.
    assert!(ask(&mut engine, b"STATS\n").contains(figures));
    assert_eq!(ask(&mut engine, b"PX 2 2 00ff00\nPX 2 2\n"), "PX 2 2 00ff00\n");
    engine.end();
    assert_eq!(bytes_written.0.lock().unwrap().as_slice(), b"#!fbptr-record 2 8x6\n");
}

#[test]
fn a_command_without_text_ends_the_recording_unless_it_was_refused() {
    use crate::Session;
    use fbptr_command::{Command, Figure};
    let mut engine = Engine::new(8, 6).unwrap();
    let bytes_written = WrittenBytes::default();
    engine.attach(Recorder::new(Box::new(bytes_written.clone()), 8, 6).unwrap());
    let (mut session, mut replies) = (Session::new(1, Audience::Owner), Vec::new());
    let name = "n".repeat(5000);
    let refused = engine.run(&mut session, Command::Draw { name }, &mut replies);
    assert_eq!(refused.unwrap_err().code, fbptr_core::error::Code::NoEnt);
    let pixel = Command::Pixel { x: 1, y: 1, color: [1, 2, 3, 255] };
    let _ = engine.run(&mut session, pixel.clone(), &mut replies).unwrap();
    engine.tick(std::time::Instant::now());
    assert_eq!(failure(&engine), None);
    let long = Command::Figure(Figure::Poly { color: [9; 4], points: vec![[1, 1]; 5000] });
    let _ = engine.run(&mut session, long, &mut replies).unwrap();
    let _ = engine.run(&mut session, pixel, &mut replies).unwrap();
    engine.tick(std::time::Instant::now());
    assert_eq!(failure(&engine).as_deref(), Some("a command was run that has no text"));
}

/// A pipe whose reader takes nothing until the other end of the channel is dropped.
struct Stalled(WrittenBytes, mpsc::Receiver<()>);

impl Write for Stalled {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Blocks until the other side is dropped.
        let _ = self.1.recv();
        self.0.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_pipe_that_nobody_drains_ends_the_recording_and_holds_nobody_up() {
    let (bytes_written, (sender, receiver), (drain, room)) =
        (WrittenBytes::default(), mpsc::channel(), mpsc::channel());
    let mut engine = Engine::new(100, 100).unwrap();
    let on_failure: super::writer::OnFailure = Box::new(move |e: &io::Error| sender.send(e.kind()).unwrap());
    let pipe = Box::new(Stalled(bytes_written.clone(), room));
    engine.attach(Recorder::start(pipe, Patience::PIPE, Some(on_failure), 100, 100).unwrap());
    let pixels: Vec<u8> = (0..40_000).map(|i| i as u8).collect();
    // The first BLIT is on the frame; the others are as long, but off it, and cost no drawing.
    let [first, flood] =
        ["0 0", "200 200"].map(|at| [format!("BLIT {at} 100 100 :40000\n").as_bytes(), &pixels].concat());
    let (over, is_over) = mpsc::channel();
    std::thread::spawn(move || {
        let mut stream = Stream::new(&engine, 1, Audience::Owner);
        let _ = stream.feed(&mut engine, &first, &mut Output::default(), Budget::NONE);
        for _ in 0..1500 {
            let _ = stream.feed(&mut engine, &flood, &mut Output::default(), Budget::NONE);
        }
        engine.tick(std::time::Instant::now());
        let failure = failure(&engine);
        let stats = ask(&mut engine, b"STATS\n");
        over.send((engine, stats, failure)).unwrap();
    });
    let (mut engine, stats, failure) =
        is_over.recv_timeout(Duration::from_secs(120)).expect("the render thread waits");
    assert!(stats.contains(" record=failed "), "{stats}");
    let held = |engine: &Engine| engine.memory_budget().used_for(MemoryUse::Records);
    assert!(held(&engine) > 30 << 20, "{} bytes are counted of those that wait", held(&engine));
    assert!(failure.is_some_and(|f| f.contains("no room was made")));
    assert_eq!(receiver.try_recv(), Ok(io::ErrorKind::TimedOut));
    // The reader continues: it gets the recording from its beginning, and no end mark.
    drop(drain);
    let until = std::time::Instant::now() + Duration::from_secs(30);
    while bytes_written.0.lock().unwrap().len() < 32 << 20 {
        assert!(std::time::Instant::now() < until, "what was queued does not come");
        std::thread::sleep(Duration::from_millis(10));
    }
    // Once the writer has ended, nothing is queued and nothing is reserved.
    while held(&engine) > 0 {
        assert!(std::time::Instant::now() < until, "{} bytes stay counted", held(&engine));
        std::thread::sleep(Duration::from_millis(10));
        engine.tick(std::time::Instant::now());
    }
    assert!(ask(&mut engine, b"STATS\n").contains(" memory_records=0 "));
    let recording = bytes_written.0.lock().unwrap().clone();
    let (memory, _, notices) = replay(Engine::new(100, 100).unwrap(), &recording);
    assert!(memory == pixels, "the beginning of what was drawn");
    assert!(matches!(notices.last(), Some(Notice::Refused(c)) if c.fault.message.contains("ends early")));
}

#[cfg(unix)]
#[test]
fn a_recording_that_is_being_written_is_not_emptied_by_another() {
    let folder = TestFolder::new("lock");
    let path = folder.0.join("r");
    let mut first = RecordFile::open(&path).unwrap();
    first.file.write_all(b"ours").unwrap();
    let refused = RecordFile::open(&path).unwrap_err();
    assert!(refused.to_string().contains("another process records into it"), "{refused}");
    assert_eq!(std::fs::read(&path).unwrap(), b"ours");
    drop(first);
    drop(RecordFile::open(&path).unwrap());
    assert_eq!(std::fs::read(&path).unwrap(), b"");
    let pipe = folder.0.join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let (over, is_over) = mpsc::channel();
    std::thread::spawn(move || over.send(RecordFile::open(&pipe).map(drop)).unwrap());
    let refused = is_over.recv_timeout(Duration::from_secs(30)).expect("the opening waits").unwrap_err();
    assert!(refused.to_string().contains("a pipe that nobody reads"), "{refused}");
}

#[test]
fn a_replay_draws_what_a_request_with_a_defect_left() {
    on_a_large_stack(|| {
        let bytes_written = WrittenBytes::default();
        let mut engine = Engine::new(24, 16).unwrap();
        engine.attach(Recorder::new(Box::new(bytes_written.clone()), 24, 16).unwrap());
        let mut stream = Stream::new(&engine, 7, Audience::Connection);
        let mut feed = |engine: &mut Engine, defect: Option<&'static str>, script: &[u8]| {
            engine.wanted_defect = defect;
            let _ = stream.feed(engine, script, &mut Output::default(), Budget::NONE);
        };
        let scene = b"AMBIENT 1 1 1\nMESH m BOX 3 3 3\nLOOKAT 0 0 5 0 0 0 0 1 0\n";
        feed(&mut engine, None, scene);
        feed(&mut engine, Some("DRAW"), b"DRAW m\n");
        feed(&mut engine, Some("PX"), b"PX 1 1 ff0000\nPX 2 2 00ff00\n");
        // The depths of the draw with the defect would hide this one.
        feed(&mut engine, None, b"MATERIAL red red red 1\nSCALE 0.5 0.5 0.5\nDRAW m\nSYNC a\n");
        engine.end();
        let live = engine.memory().bytes().to_vec();
        assert!(live.chunks(4).any(|pixel| pixel == [255, 0, 0, 255]), "the last draw is seen");
        let recording = bytes_written.0.lock().unwrap().clone();
        let (replayed, _, notices) = replay(Engine::new(24, 16).unwrap(), &recording);
        assert_eq!(notices, []);
        assert!(live == replayed, "the replay differs");
    });
}

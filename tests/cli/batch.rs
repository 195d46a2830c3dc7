//! Batches: frames that several processes draw are those of one, and whatever ends a process in the
//! middle, the same command goes on from there.

use crate::folder::Folder;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

impl Folder {
    /// Returns the files of a subfolder by name, without the manifests.
    fn pictures(&self, name: &str) -> BTreeMap<String, Vec<u8>> {
        let files = std::fs::read_dir(self.0.join(name)).expect("a folder").map(|e| e.expect("an entry"));
        let files = files.filter(|e| !e.file_name().to_string_lossy().ends_with(".jsonl"));
        let read =
            |e: std::fs::DirEntry| (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap());
        files.map(read).collect()
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }
}

fn command(folder: &Folder, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbptr"));
    command.args(line.split_whitespace()).current_dir(&folder.0).stdin(Stdio::null());
    command
}

fn fbptr(folder: &Folder, line: &str) -> Output {
    command(folder, line).output().expect("it runs")
}

/// Runs a command that must succeed.
fn ok(folder: &Folder, line: &str) -> String {
    let output = fbptr(folder, line);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{line}: {errors}");
    String::from_utf8(output.stdout).expect("text")
}

/// Runs a command that must end with a status, and returns what it prints and says.
fn ends(folder: &Folder, line: &str, status: i32) -> String {
    let output = fbptr(folder, line);
    let text =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{line}: {text}");
    text
}

/// A sphere that moves from left to right in two seconds, seen from 5; the far plane comes from 21
/// nearer by 8 a second.
const MOVING: &str = r#"<X3D profile="Interchange" version="4.0"><Scene>
  <Viewpoint DEF="Eye" position="0 0 5" nearDistance="1" farDistance="21"/>
  <Transform DEF="Ball"><Shape><Appearance><Material diffuseColor="1 0.5 0"/></Appearance><Sphere/></Shape></Transform>
  <TimeSensor DEF="Clock" cycleInterval="2" loop="true"/>
  <PositionInterpolator DEF="Path" key="0 1" keyValue="-2 0 0  2 0 0"/>
  <ScalarInterpolator DEF="Far" key="0 1" keyValue="21 5"/>
  <ROUTE fromNode="Clock" fromField="fraction_changed" toNode="Path" toField="set_fraction"/>
  <ROUTE fromNode="Clock" fromField="fraction_changed" toNode="Far" toField="set_fraction"/>
  <ROUTE fromNode="Path" fromField="value_changed" toNode="Ball" toField="translation"/>
  <ROUTE fromNode="Far" fromField="value_changed" toNode="Eye" toField="farDistance"/>
</Scene></X3D>"#;

const TRIANGLE: &str = "v 0 0 0\nv 2 0 0\nv 0 1 1\nf 1 2 3\n";

/// Writes an animated scene, a mesh and a tesseract.
fn scenes(folder: &Folder) {
    std::fs::write(folder.0.join("moving.x3d"), MOVING).expect("written");
    std::fs::write(folder.0.join("mesh.obj"), TRIANGLE).expect("written");
    let tesseract = ok(folder, "eye --make tesseract --pixels 24x16");
    std::fs::write(folder.0.join("t.json"), tesseract).expect("written");
}

#[test]
fn frames_of_shards_are_those_of_one_run_and_join_to_its_movie() {
    let folder = Folder::new("same");
    scenes(&folder);
    let kinds = [
        ("moving.x3d", "png", "--fps 4 --size 32x24"),
        ("mesh.obj", "ppm", "--size 32x24 --depth-out"),
        ("t.json", "raw", "--turn 0,3,360 --turn 1,2,180"),
    ];
    for (scene, ending, options) in kinds {
        let common = |place: &str| match options.strip_suffix("--depth-out") {
            Some(rest) => {
                format!("render {scene} --frames 7 {rest} --depth-out {place}/d.pfm -o {place}/f.{ending}")
            }
            None => format!("render {scene} --frames 7 {options} -o {place}/f.{ending}"),
        };
        let [one, parts] = [format!("one-{ending}"), format!("parts-{ending}")];
        std::fs::create_dir(folder.0.join(&one)).expect("made");
        ok(&folder, &common(&one));
        ok(&folder, &format!("{} --shard 1/2", common(&parts)));
        let text = ends(&folder, &format!("batch check {parts}"), 1);
        assert!(text.contains("3 of 7 frames") && text.contains("missing: 0, 2, 4, 6\n"), "{text}");
        ends(&folder, &format!("batch movie {parts} -o no.gif"), 1);
        // A range and a shard may overlap: what is there is not drawn again.
        ok(&folder, &format!("{} --first 0 --last 2", common(&parts)));
        ok(&folder, &format!("{} --shard 0/2", common(&parts)));
        let text = ok(&folder, &format!("batch check {parts} --merge"));
        assert!(text.starts_with("7 of 7 frames"), "{text}");
        let frames = folder.pictures(&parts);
        assert_eq!(frames, folder.pictures(&one), "{scene}");
        let different: std::collections::BTreeSet<_> = frames.values().collect();
        assert_eq!(different.len(), frames.len(), "{scene}: every frame is another picture");
        // The merged manifest stands for the others.
        for name in ["frames-1-of-2.jsonl", "frames-0-to-2.jsonl", "frames-0-of-2.jsonl"] {
            std::fs::remove_file(folder.0.join(&parts).join(name)).expect(name);
        }
        let movies = if ending == "raw" { ["gif", "y4m"] } else { ["apng", "y4m"] };
        for movie in movies {
            let line = common("x").replace("--depth-out x/d.pfm ", "");
            let line = line.replace(&format!("x/f.{ending}"), &format!("whole.{movie}"));
            ok(&folder, &line);
            ok(&folder, &format!("batch movie {parts} -o joined.{movie}"));
            let [whole, joined] =
                ["whole", "joined"].map(|n| std::fs::read(folder.0.join(format!("{n}.{movie}"))));
            assert!(whole.unwrap() == joined.unwrap(), "{scene}: {movie}");
        }
    }
    assert!(!folder.0.join("no.gif").exists(), "an incomplete batch makes no movie");
}

#[test]
fn a_run_goes_on_where_the_last_one_was_ended_and_draws_only_what_is_missing() {
    let folder = Folder::new("resume");
    scenes(&folder);
    let line = "render mesh.obj --frames 8 --size 32x24 -o out/f.png --shard 0/1";
    ok(&folder, line);
    let before = folder.pictures("out");
    let manifest = folder.text("out/frames-0-of-1.jsonl");
    let first: Value = serde_json::from_str(manifest.lines().next().unwrap()).expect("a record");
    assert_eq!((&first["frame"], &first["of"]), (&Value::from(0), &Value::from(8)));
    assert_eq!(first["version"], env!("CARGO_PKG_VERSION"));
    assert!(!first["host"].as_str().unwrap().is_empty() && first["time"].as_str().unwrap().ends_with('Z'));
    let picture = image::load_from_memory(&before["f-0000.png"]).expect("a picture").into_rgba8();
    let crc = format!("{:08x}", crc32fast::hash(picture.as_raw()));
    assert_eq!(first["crc"], crc, "the CRC of the pixels, in any format");

    // Frame 1 is gone, 2 damaged, 5 without its line, the last line is torn.
    std::fs::remove_file(folder.0.join("out/f-0001.png")).unwrap();
    std::fs::write(folder.0.join("out/f-0002.png"), "damaged").unwrap();
    let lines: Vec<&str> = manifest.lines().collect();
    let kept = [&lines[..5], &lines[6..7]].concat().join("\n");
    let torn = &lines[7][..lines[7].len() / 2];
    std::fs::write(folder.0.join("out/frames-0-of-1.jsonl"), format!("{kept}\n{torn}")).unwrap();
    let text = ends(&folder, "batch check out", 1);
    assert!(text.contains("missing: 1, 5, 7\n") && text.contains("2 (f-0002.png: expected"), "{text}");
    let modified =
        |name: &str| std::fs::metadata(folder.0.join("out").join(name)).unwrap().modified().unwrap();
    let untouched = modified("f-0003.png");
    let said = ends(&folder, line, 0);
    assert!(said.contains("4 of 8 frames are there already"), "{said}");
    assert_eq!(modified("f-0003.png"), untouched, "what is there is not drawn again");
    assert_eq!(folder.pictures("out"), before);
    ok(&folder, "batch check out");
    let manifest = folder.text("out/frames-0-of-1.jsonl");
    assert_eq!(manifest.lines().count(), 10);
    assert!(manifest.lines().all(|line| serde_json::from_str::<Value>(line).is_ok()), "no torn line is left");

    // Another scene under the same name is drawn anew; so are frames of another version.
    std::fs::write(folder.0.join("mesh.obj"), TRIANGLE.replace("0 1 1", "0 1.5 1")).unwrap();
    let said = ends(&folder, line, 0);
    assert!(!said.contains("there already") && folder.pictures("out") != before, "{said}");
    let version = format!("\"version\":\"{}\"", env!("CARGO_PKG_VERSION"));
    let manifest = folder.text("out/frames-0-of-1.jsonl");
    let older = manifest.lines().last().unwrap().replace(&version, "\"version\":\"0.0.1\"");
    let others: Vec<&str> = manifest.lines().filter(|line| !line.contains("\"frame\":7,")).collect();
    std::fs::write(folder.0.join("out/frames-0-of-1.jsonl"), format!("{}\n{older}\n", others.join("\n")))
        .unwrap();
    let said = ends(&folder, line, 0);
    assert!(said.contains("7 of 8 frames"), "{said}");
    // A second batch in the folder would mix with the first.
    let said = ends(&folder, "render mesh.obj --frames 8 -o out/g.png --shard 0/1", 2);
    assert!(said.contains("one batch a folder"), "{said}");
}

#[test]
fn two_processes_do_not_draw_one_shard() {
    let folder = Folder::new("lock");
    scenes(&folder);
    // The lock that a process holds while it draws.
    std::fs::create_dir(folder.0.join("out")).unwrap();
    let manifest = std::fs::File::create(folder.0.join("out/frames-0-of-2.jsonl")).unwrap();
    manifest.lock().expect("a lock");
    let line = "render mesh.obj --frames 4 --size 32x24 -o out/f.png --shard";
    let said = ends(&folder, &format!("{line} 0/2"), 1);
    assert!(said.contains("another process draws these frames"), "{said}");
    assert!(folder.pictures("out").is_empty());
    ok(&folder, &format!("{line} 1/2"));
    drop(manifest);
    ok(&folder, &format!("{line} 0/2"));
    ok(&folder, "batch check out");
}

#[test]
fn killed_in_the_middle_again_and_again_all_frames_are_there_in_the_end() {
    let folder = Folder::new("kill");
    scenes(&folder);
    let line = "render moving.x3d --frames 40 --fps 20 --size 320x240 -o out/f.png --shard 0/1";
    for kill in 1..=3 {
        let mut child = command(&folder, line).stderr(Stdio::null()).spawn().expect("it runs");
        let begun = Instant::now();
        let drawn = || std::fs::read(folder.0.join("out/frames-0-of-1.jsonl")).map_or(0, |b| b.len());
        let before = drawn();
        while drawn() < before + 600 && child.try_wait().expect("a child").is_none() {
            assert!(begun.elapsed() < Duration::from_secs(60), "no frame in run {kill}");
            std::thread::sleep(Duration::from_millis(1));
        }
        let _ = child.kill();
        let _ = child.wait();
    }
    ok(&folder, line);
    ok(&folder, "batch check out");
    std::fs::create_dir(folder.0.join("one")).unwrap();
    ok(&folder, &line.replace("out/", "one/").replace(" --shard 0/1", ""));
    assert_eq!(folder.pictures("out"), folder.pictures("one"), "and nothing half-written is left");
}

#[test]
fn a_frame_that_the_scene_refuses_is_named_and_the_others_are_drawn() {
    let folder = Folder::new("refused");
    scenes(&folder);
    // From frame 37 on, at 1.85 s, the far plane is nearer than the near one.
    let line = "render moving.x3d --frames 41 --fps 20 --size 32x24 --near 6.3 -o out/f.png --shard 0/1";
    let said = ends(&folder, line, 1);
    assert!(said.contains("frame 37: camera"), "{said}");
    assert!(said.contains("4 frames were refused: 37-40; all others are there"), "{said}");
    assert_eq!(folder.pictures("out").len(), 37);
    let text = ends(&folder, "batch check out", 1);
    assert!(text.contains("missing: 37-40\n"), "{text}");
}

#[test]
fn on_a_full_disk_nothing_is_half_written_and_the_same_command_goes_on() {
    let folder = Folder::new("full");
    scenes(&folder);
    // Files may not grow beyond 1 KiB: first the manifest fails, then a picture.
    let limited = |line: &str| {
        let line = format!("trap '' XFSZ; ulimit -f 1; exec {} {line}", env!("CARGO_BIN_EXE_fbptr"));
        Command::new("bash").args(["-c", &line]).current_dir(&folder.0).output().expect("bash")
    };
    let lines = [
        ("out", "render mesh.obj --frames 9 --size 12x10 -o out/f.raw --shard 0/1", 1..8),
        ("big", "render mesh.obj --frames 9 --size 32x24 -o big/f.raw --shard 0/1", 0..1),
    ];
    for (out, line, expected) in lines {
        let output = limited(line);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("File too large") && said.contains("the same command goes on"), "{said}");
        let manifest = folder.text(&format!("{out}/frames-0-of-1.jsonl"));
        assert!(expected.contains(&manifest.lines().count()), "{manifest}");
        assert!(manifest.is_empty() || manifest.ends_with('\n'), "no torn line: {manifest}");
        let names: Vec<String> = folder.pictures(out).into_keys().collect();
        assert!(names.iter().all(|name| name.starts_with("f-")), "no temporary file: {names:?}");
        ok(&folder, line);
        ok(&folder, &format!("batch check {out}"));
        assert_eq!(folder.pictures(out).len(), 9);
    }
}

#[test]
fn a_batch_of_the_most_frames_is_checked_without_counting_to_them() {
    let folder = Folder::new("most");
    scenes(&folder);
    let most = u32::MAX;
    ok(&folder, &format!("render mesh.obj --frames {most} --size 12x10 -o out/f.raw --first 7 --last 8"));
    ok(&folder, &format!("render mesh.obj --frames {most} --size 12x10 -o out/f.raw --first {}", most - 1));
    std::fs::remove_file(folder.0.join("out/f-0008.raw")).unwrap();
    let text = ends(&folder, "batch check out", 1);
    assert!(text.starts_with("2 of 4294967295 frames"), "{text}");
    assert!(text.contains("missing: 0-6, 8-4294967293\n"), "{text}");
}

#[test]
fn arguments_of_parts_that_make_no_sense_are_refused() {
    let folder = Folder::new("arguments");
    scenes(&folder);
    for (line, expected) in [
        ("render mesh.obj -o f.png --shard 0/2", "--frames"),
        ("render mesh.obj -o f.png --frames 4 --shard 2/2", "0/4"),
        ("render mesh.obj -o f.png --frames 4 --first 4", "found 4 to 3"),
        ("render mesh.obj -o f.png --frames 4 --last 4", "found 0 to 4"),
        ("render mesh.obj -o f.gif --frames 4 --shard 0/2", "batch movie"),
        ("render mesh.obj -o f.png --frames 4 --turn 0,1,90", "N-dimensional"),
        ("render t.json -o f.png --frames 4 --turn 0,4,90", "from 0 to 3"),
        ("render mesh.obj -o a/f.png --depth-out b/d.pfm --frames 4 --shard 0/2", "one folder"),
        ("batch check .", "without a record"),
        ("batch check nowhere", "there is no such folder"),
        ("batch movie . -o a.png", ".gif"),
    ] {
        let said = ends(&folder, line, 2);
        assert!(said.contains(expected), "{line}: {said}");
    }
    let left = |path: &Path| std::fs::read_dir(path).unwrap().count();
    assert_eq!(left(&folder.0), 3, "nothing was made but the scenes");
}

/// Makes a pipe without a reader.
#[cfg(unix)]
fn pipe(folder: &Folder, name: &str) {
    let made = Command::new("mkfifo").arg(folder.0.join(name)).status().expect("mkfifo");
    assert!(made.success());
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_named_and_passed_over_by_the_check() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new("irregular");
    scenes(&folder);
    ok(&folder, "render mesh.obj --frames 6 --size 32x24 -o out/f.png --shard 0/1");
    pipe(&folder, "out/frames-3-of-9.jsonl");
    symlink("frames-0-of-1.jsonl", folder.0.join("out/frames-4-of-9.jsonl")).unwrap();
    let text = ends(&folder, "batch check out", 0);
    for (name, kind) in [("frames-3-of-9.jsonl", "a pipe"), ("frames-4-of-9.jsonl", "a symbolic link")] {
        assert!(text.contains(&format!("{name}: expected a regular file, found {kind}: left out")), "{text}");
    }
    for (frame, target) in [(1, None), (2, Some("/dev/zero")), (3, Some("f-0000.png"))] {
        let name = format!("out/f-{frame:04}.png");
        std::fs::remove_file(folder.0.join(&name)).unwrap();
        match target {
            None => pipe(&folder, &name),
            Some(target) => symlink(target, folder.0.join(&name)).unwrap(),
        }
    }
    let text = ends(&folder, "batch check out", 1);
    assert!(text.starts_with("3 of 6 frames"), "{text}");
    assert!(text.contains("1 (f-0001.png: expected a regular file, found a pipe)"), "{text}");
    assert!(text.contains("2 (f-0002.png: expected a regular file, found a symbolic link)"), "{text}");
    // The same command draws them anew, in the place of what stands there.
    ok(&folder, "render mesh.obj --frames 6 --size 32x24 -o out/f.png --shard 0/1");
    assert!(ok(&folder, "batch check out").starts_with("6 of 6 frames"));
}

#[test]
fn a_changed_crc_of_a_manifest_is_seen() {
    let folder = Folder::new("crc");
    scenes(&folder);
    for (ending, is_seen) in [("png", true), ("raw", true), ("ppm", false)] {
        ok(&folder, &format!("render mesh.obj --frames 3 --size 32x24 -o {ending}/f.{ending} --shard 0/1"));
        let path = folder.0.join(ending).join("frames-0-of-1.jsonl");
        let text = std::fs::read_to_string(&path).unwrap();
        let crc = text.split("\"crc\":\"").nth(1).unwrap()[..8].to_owned();
        let other = format!("{:08x}", !u32::from_str_radix(&crc, 16).unwrap());
        std::fs::write(&path, text.replacen(&crc, &other, 1)).unwrap();
        // A format without alpha cannot tell which pixels were written.
        let text = ends(&folder, &format!("batch check {ending}"), i32::from(is_seen));
        let told = format!("expected pixels with crc {other}, found {crc}");
        assert_eq!(text.contains(&told), is_seen, "{ending}: {text}");
    }
}

#[cfg(unix)]
#[test]
fn outputs_replace_a_link_and_leave_what_it_leads_to() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new("links");
    scenes(&folder);
    std::fs::create_dir(folder.0.join("out")).unwrap();
    let lines = [
        ("f-0001.png", "render mesh.obj --frames 3 --size 32x24 -o out/f.png"),
        ("d-0000.pfm", "render mesh.obj --frames 3 --size 32x24 -o out/f.png --depth-out out/d.pfm"),
        ("one.png", "render mesh.obj --size 32x24 -o out/one.png"),
        ("m.gif", "render mesh.obj --frames 3 --size 32x24 -o out/m.gif"),
        ("m.y4m", "render mesh.obj --frames 3 --size 32x24 -o out/m.y4m"),
        ("snap.png", "play - --headless --snap out/snap.png"),
        ("frames.jsonl", "batch check out --merge"),
    ];
    for (name, line) in lines {
        std::fs::write(folder.0.join("theirs"), "theirs").unwrap();
        symlink("../theirs", folder.0.join("out").join(name)).unwrap();
        if name == "frames.jsonl" {
            ok(&folder, "render mesh.obj --frames 3 --size 32x24 -o out/f.png --shard 0/1");
        }
        ok(&folder, line);
        assert_eq!(folder.text("theirs"), "theirs", "{line}");
        let meta = std::fs::symlink_metadata(folder.0.join("out").join(name)).unwrap();
        assert!(meta.is_file() && meta.len() > 0, "{line}: {meta:?}");
    }
    // A manifest behind a link is not written to.
    std::fs::remove_file(folder.0.join("out/frames-0-of-1.jsonl")).unwrap();
    symlink("../theirs", folder.0.join("out/frames-0-of-1.jsonl")).unwrap();
    let text = ends(&folder, "render mesh.obj --frames 3 --size 32x24 -o out/f.png --shard 0/1", 1);
    assert!(text.contains("frames-0-of-1.jsonl: expected a regular file, found a symbolic link"), "{text}");
    assert_eq!(folder.text("theirs"), "theirs");
}

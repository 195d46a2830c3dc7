//! Tests of both sides of a shared file: the foreign side uses plain reads and writes.

use super::*;
use crate::error::Code;
use std::os::unix::fs::FileExt;

struct Folder(PathBuf);
impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("fbptr-shm-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir(&path).unwrap();
        Folder(path)
    }
}
impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn outside(path: &Path) -> File {
    OpenOptions::new().read(true).write(true).open(path).unwrap()
}

fn pixel(file: &File, at: u64) -> [u8; 4] {
    let mut p = [0; 4];
    file.read_exact_at(&mut p, 4096 + at * 4).unwrap();
    p
}

#[test]
fn both_sides_write_and_nothing_is_lost() {
    let folder = Folder::new("both");
    let path = folder.0.join("fb");
    let (w, h) = (1021, 7);
    let mut shared = SharedFile::open(&path, (w, h), true).unwrap();
    let mut memory = VideoMemory::new(w, h).unwrap();
    shared.load_into(&mut memory);
    let foreign = outside(&path);
    assert_eq!(pixel(&foreign, 0), VideoMemory::CLEAR);
    // The foreign side writes one pixel in each row, the last of the frame included; the server
    // writes others in the same rows.
    for y in 0..h as u64 {
        foreign.write_all_at(&[y as u8, 1, 2, 3], 4096 + (y * w as u64 + (w as u64 - 1)) * 4).unwrap();
        memory.put_pixel(y as i32, y as i32, [50, 60, 70, 80]);
    }
    let rows = memory.take_damage();
    shared.give_out(&memory, rows).unwrap();
    let mut seen = Vec::new();
    shared.take_in(&mut memory, |i| seen.push(i)).unwrap();
    assert_eq!(seen, (1..=h as usize).map(|y| y * w as usize - 1).collect::<Vec<_>>());
    for y in 0..h as i32 {
        assert_eq!(memory.get_pixel(w as i32 - 1, y).unwrap(), [y as u8, 1, 2, 3]);
        assert_eq!(pixel(&foreign, (y as u64) * w as u64 + y as u64), [50, 60, 70, 80]);
        assert_eq!(pixel(&foreign, (y as u64 + 1) * w as u64 - 1), [y as u8, 1, 2, 3]);
    }
    assert_eq!(memory.take_damage(), 0..h);
    shared.take_in(&mut memory, |i| panic!("pixel {i} seen twice")).unwrap();
}

#[test]
fn a_pixel_that_both_wrote_is_one_of_the_two_on_both_sides() {
    let folder = Folder::new("clash");
    let path = folder.0.join("fb");
    let mut shared = SharedFile::open(&path, (4, 1), true).unwrap();
    let mut memory = VideoMemory::new(4, 1).unwrap();
    let foreign = outside(&path);
    foreign.write_all_at(&[9; 4], 4096 + 8).unwrap();
    memory.put_pixel(2, 0, [5; 4]);
    shared.take_in(&mut memory, |_| ()).unwrap();
    shared.give_out(&memory, 0..1).unwrap();
    assert_eq!(memory.get_pixel(2, 0).unwrap(), pixel(&foreign, 2));
}

#[test]
fn it_survives_a_restart_and_refuses_what_is_not_its_own() {
    let folder = Folder::new("restart");
    let path = folder.0.join("fb");
    let mut shared = SharedFile::open(&path, (5, 3), true).unwrap();
    let mut memory = VideoMemory::new(5, 3).unwrap();
    memory.put_pixel(4, 2, [1, 2, 3, 4]);
    shared.give_out(&memory, 0..3).unwrap();
    assert!(matches!(SharedFile::open(&path, (5, 3), true), Err(SharedError::InUse { .. })));
    drop(shared);
    assert!(matches!(SharedFile::open(&path, (6, 3), true), Err(SharedError::NotOurs { .. })));
    let mut again = SharedFile::open(&path, (640, 480), false).unwrap();
    assert_eq!((again.width(), again.height()), (5, 3), "the file's own size");
    let mut memory = VideoMemory::new(5, 3).unwrap();
    again.load_into(&mut memory);
    assert_eq!(memory.get_pixel(4, 2).unwrap(), [1, 2, 3, 4]);

    let letter = folder.0.join("letter");
    let cases: [&[u8]; 4] = [b"", b"dear friend", &[0; 5000], b"FBPTRSHM and then nothing of the sort"];
    for text in cases {
        std::fs::write(&letter, text).unwrap();
        assert!(matches!(SharedFile::open(&letter, (5, 3), true), Err(SharedError::NotOurs { .. })));
        assert_eq!(std::fs::read(&letter).unwrap(), text, "left as it was");
    }
    // Its own file with one number of the header changed, or of another length.
    let good = std::fs::read(&path).unwrap();
    for (at, expected) in [
        (8, "version 1"),
        (12, "header bytes 4096"),
        (16, "a size and its stride"),
        (20, "4176 bytes"),
        (24, "a size and its stride"),
        (28, "format 1"),
    ] {
        let mut changed = good.clone();
        changed[at] += 1;
        std::fs::write(&letter, &changed).unwrap();
        let e = SharedFile::open(&letter, (5, 3), false).unwrap_err();
        assert!(e.to_string().contains(expected) && e.code() == Code::Format, "{at}: {e}");
    }
    std::fs::write(&letter, [&good[..], b"x"].concat()).unwrap();
    let e = SharedFile::open(&letter, (5, 3), false).unwrap_err();
    assert!(e.to_string().contains("4156 bytes"), "{e}");
    std::os::unix::fs::symlink(&path, folder.0.join("link")).unwrap();
    for other in [folder.0.join("link"), folder.0.clone(), "/dev/null".into()] {
        let e = SharedFile::open(&other, (5, 3), true).unwrap_err();
        assert!(matches!(e, SharedError::NotOurs { .. }), "{e}");
    }
}

#[test]
fn the_header_says_what_the_layout_promises() {
    let folder = Folder::new("header");
    let path = folder.0.join("fb");
    let shared = SharedFile::open(&path, (300, 200), true).unwrap();
    shared.set_frame(77);
    let bytes = std::fs::read(&path).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(&bytes[..8], b"FBPTRSHM");
    assert_eq!([8, 12, 16, 20, 24, 28].map(word), [1, 4096, 300, 200, 1200, 1]);
    assert_eq!((word(32), word(36), word(48)), (77, 0, std::process::id()));
    assert_eq!(bytes.len(), 4096 + 300 * 200 * 4);
    // The map ends where the file does.
    let read = |at: usize| shared.map.word_at(at).load(Relaxed);
    let word = |at: usize| std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| read(at))).ok();
    assert_eq!(word(bytes.len() - 4), Some(u32::from_ne_bytes(VideoMemory::CLEAR)));
    assert_eq!(word(bytes.len()), None, "beyond the end");
    let text = std::str::from_utf8(&bytes[256..4096]).unwrap().split('\0').next().unwrap();
    assert!(text.starts_with("frame=00000000000000000077\ndoorbell=00000000000000000000\nmagic=FBPTRSHM\n"));
    assert!(text.contains("\nwidth=300\nheight=200\nstride=1200\n"), "{text}");
    outside(&path).write_all_at(&5u64.to_le_bytes(), 40).unwrap();
    assert_eq!(shared.doorbell(), 5);
}

#[test]
fn a_file_truncated_by_others_is_an_error_and_changes_nothing() {
    let folder = Folder::new("cut");
    for bytes in [0, 10, 4096, 4096 + 2000 * 4 + 100, 4096 + 2000 * 16 - 1] {
        let path = folder.0.join("fb");
        let _ = std::fs::remove_file(&path);
        let mut shared = SharedFile::open(&path, (2000, 4), true).unwrap();
        let mut memory = VideoMemory::new(2000, 4).unwrap();
        memory.clear([1, 2, 3, 4]);
        shared.give_out(&memory, 0..4).unwrap();
        outside(&path).set_len(bytes).unwrap();
        let told = shared.take_in(&mut memory, |i| panic!("nobody wrote pixel {i}")).unwrap_err();
        assert_eq!(
            told.to_string(),
            format!("{}: another program truncated it from 36096 to {bytes} bytes", path.display())
        );
        memory.clear([5; 4]);
        assert!(matches!(shared.give_out(&memory, 0..4), Err(SharedError::Truncated { .. })));
        shared.set_frame(9);
        assert_eq!(memory.get_pixel(1999, 3).unwrap(), [5; 4]);
        drop(shared);
        assert_eq!(std::fs::metadata(&path).unwrap().len(), bytes, "it is left as it is");
    }
}

#[test]
fn an_access_to_a_page_that_is_gone_ends_nobody() {
    let folder = Folder::new("gone");
    let path = folder.0.join("fb");
    let (shared, other) = (
        SharedFile::open(&path, (2000, 4), true).unwrap(),
        SharedFile::open(&folder.0.join("other"), (2000, 4), true).unwrap(),
    );
    // No check comes between the truncation and the access: a check beforehand cannot see this
    // case.
    outside(&path).set_len(0).unwrap();
    shared.word(7999).store(1, Relaxed);
    assert_eq!((shared.word(0).load(Relaxed), shared.word(7999).load(Relaxed)), (0, 1));
    assert!(shared.map.is_truncated() && !other.map.is_truncated());
    // The length is right again, but the stored words are lost.
    outside(&path).set_len(36_096).unwrap();
    let told = shared.check().unwrap_err();
    assert!(matches!(told, SharedError::Truncated { found: 36_096, .. }));
    assert!(
        told.to_string().ends_with(
            "truncated it for a time: its 36096 bytes are there again, and what was in them is lost"
        )
    );
    other.check().unwrap();
    assert_eq!(other.word(7999).load(Relaxed).to_ne_bytes(), VideoMemory::CLEAR);
}

#[test]
fn truncations_at_any_moment_are_found_and_taken_for_nothing_else() {
    let folder = Folder::new("moments");
    for round in 0..60 {
        let path = folder.0.join("fb");
        let _ = std::fs::remove_file(&path);
        let mut shared = SharedFile::open(&path, (1000, 100), true).unwrap();
        let mut memory = VideoMemory::new(1000, 100).unwrap();
        let foreign = outside(&path);
        let cutter = std::thread::spawn(move || {
            std::thread::sleep(std::time::Duration::from_micros(50 * round));
            foreign.set_len(4096 * (round % 90)).unwrap();
        });
        let mut color = 1;
        let error = loop {
            color = color % 250 + 1;
            memory.clear([color; 4]);
            let result = shared
                .give_out(&memory, 0..100)
                .and_then(|()| shared.take_in(&mut memory, |i| panic!("nobody wrote pixel {i}")));
            match result {
                Ok(()) => {}
                Err(e) => break e,
            }
        };
        cutter.join().unwrap();
        assert!(matches!(error, SharedError::Truncated { .. }), "{error}");
        assert!(memory.bytes().iter().all(|b| *b == color), "what we drew is ours still");
    }
}

#[test]
fn what_is_no_regular_file_is_named() {
    let folder = Folder::new("kinds");
    let link = folder.0.join("link");
    std::os::unix::fs::symlink("nowhere", &link).unwrap();
    let kinds = [&link, &folder.0, Path::new("/dev/null")]
        .map(|path: &Path| kind_of(&std::fs::symlink_metadata(path).unwrap()));
    assert_eq!(kinds, ["a symbolic link", "a folder", "a device or pipe"]);
}

//! Snapshots: a file holds what was in memory, is never half written, and a golden test can fail.

use fbptr::error::Code;
use fbptr::memory::{DepthFormat, DepthMemory, VideoMemory};
use fbptr::save::golden::{self, GoldenError, Mode, Tolerance};
use fbptr::save::{self, SaveError};
use std::fs;
use std::io;
use std::path::PathBuf;

/// Returns a new folder for this test alone, under Cargo's temporary folder.
fn folder(name: &str) -> PathBuf {
    let dir = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("save-{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&dir);
    fs::create_dir_all(&dir).unwrap();
    dir
}

fn frame() -> VideoMemory {
    let mut m = VideoMemory::new(3, 2).unwrap();
    for (i, byte) in m.bytes_mut().iter_mut().enumerate() {
        *byte = (i * 37 % 256) as u8;
    }
    m
}

#[test]
fn every_format_holds_the_pixels() {
    let dir = folder("formats");
    let m = frame();
    for ending in ["png", "PNG", "ppm", "raw"] {
        save::to_path(&m, &dir.join(format!("a.{ending}"))).unwrap();
    }
    assert_eq!(fs::read(dir.join("a.raw")).unwrap(), m.bytes());
    let rgb: Vec<u8> = m.bytes().chunks(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    assert_eq!(fs::read(dir.join("a.ppm")).unwrap(), [b"P6\n3 2\n255\n", &rgb[..]].concat());
    let back = golden::read_png(&dir.join("a.png")).unwrap();
    assert_eq!((back.width(), back.height(), back.bytes()), (3, 2, m.bytes()));
    assert_eq!(save::crc32(&m), crc32fast::hash(&fs::read(dir.join("a.raw")).unwrap()));
    for name in ["a", "a.gif", "a.png.bak", ".png"] {
        let error = save::to_path(&m, &dir.join(name)).unwrap_err();
        assert!(matches!(error, SaveError::UnknownEnding { .. }), "{name}: {error}");
    }
    assert_eq!(fs::read_dir(&dir).unwrap().count(), 4, "nothing else is left in the folder");
}

#[test]
fn depth_is_bottom_up_little_endian_and_one_where_nothing_was_drawn() {
    for format in DepthFormat::ALL {
        let mut depth = DepthMemory::new(2, 2, format);
        depth.set_word(0, format.encode(0.25, 0.75));
        let mut out = Vec::new();
        save::pfm(&depth, &mut out).unwrap();
        let (head, body) = out.split_at(b"Pf\n2 2\n-1.0\n".len());
        assert_eq!(head, b"Pf\n2 2\n-1.0\n");
        let z: Vec<f32> = body.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        assert_eq!((z[0], z[1], z[3]), (1.0, 1.0, 1.0), "{format:?}: the bottom row comes first");
        assert!((z[2] - 0.25).abs() < 1e-5);
    }
    let error = save::depth_to_path(&DepthMemory::new(1, 1, DepthFormat::F32), "d.png".as_ref()).unwrap_err();
    assert_eq!(
        (error.code(), error.to_string()),
        (Code::Args, "d.png: expected a name that ends in .pfm".into())
    );
}

#[test]
fn a_failed_write_leaves_the_old_file_and_nothing_else() {
    let dir = folder("atomic");
    let path = dir.join("old.raw");
    fs::write(&path, b"old").unwrap();
    let error = save::atomically(&path, |out| {
        out.write_all(&vec![1; 1 << 20])?;
        Err(io::Error::other("the disk is gone"))
    })
    .unwrap_err();
    assert!(error.to_string().contains("the disk is gone"), "{error}");
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
    save::atomically(&path, |out| out.write_all(b"new")).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert_eq!(save::to_path(&frame(), &dir.join("no/such/a.png")).unwrap_err().code(), Code::NoEnt);
    fs::create_dir(dir.join("d.png")).unwrap();
    assert!(save::to_path(&frame(), &dir.join("d.png")).is_err(), "a folder is not replaced");
    assert_eq!(fs::read_dir(&dir).unwrap().count(), 2);
}

#[cfg(unix)]
#[test]
fn links_are_replaced_and_devices_are_not() {
    let dir = folder("links");
    fs::write(dir.join("real.raw"), b"old").unwrap();
    std::os::unix::fs::symlink("real.raw", dir.join("link.raw")).unwrap();
    save::to_path(&frame(), &dir.join("link.raw")).unwrap();
    assert_eq!(fs::read(dir.join("real.raw")).unwrap(), b"old");
    assert!(fs::symlink_metadata(dir.join("link.raw")).unwrap().is_file());
    assert_eq!(fs::read(dir.join("link.raw")).unwrap(), frame().bytes());
    save::atomically("/dev/null".as_ref(), |out| out.write_all(b"gone")).unwrap();
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn a_golden_test_can_fail_and_says_by_how_much() {
    let dir = folder("golden");
    let golden_path = dir.join("new/picture.png");
    let (actual, diff) = (dir.join("new/picture.actual.png"), dir.join("new/picture.diff.png"));
    let m = frame();
    let check = |m: &VideoMemory, t, mode| golden::check(m, &golden_path, t, mode);

    // Blessing fails that run; the next one passes.
    let error = check(&m, Tolerance::EXACT, Mode::Bless).unwrap_err();
    assert_eq!(error, GoldenError::Blessed { golden: golden_path.clone(), crc: save::crc32(&m) });
    check(&m, Tolerance::EXACT, Mode::Compare).unwrap();

    // Two pixels change, one by 9 in red, one by 3 in alpha.
    let mut changed = m.clone();
    changed.bytes_mut()[4] -= 9;
    changed.bytes_mut()[23] -= 3;
    let error = check(&changed, Tolerance { per_channel: 2, pixels: 1 }, Mode::Compare).unwrap_err();
    let GoldenError::Differs { difference, .. } = &error else { panic!("{error}") };
    assert_eq!(*difference, golden::Difference { pixels: 2, max: 9, first: Some((1, 0)) });
    let text = error.to_string();
    assert!(text.contains("2 pixels differ by more than 2 (1 may), at most by 9, first at (1, 0)"), "{text}");
    assert_eq!(golden::read_png(&actual).unwrap().bytes(), changed.bytes());
    let diff_picture = golden::read_png(&diff).unwrap();
    assert_eq!(diff_picture.get_pixel(1, 0), Ok([255, 0, 0, 255]));
    assert_eq!(diff_picture.get_pixel(2, 1), Ok([85, 85, 85, 255]));
    assert_eq!(diff_picture.get_pixel(0, 0), Ok([0, 0, 0, 255]));

    // Within the tolerance it passes, and the leftover files are removed.
    check(&changed, Tolerance { per_channel: 2, pixels: 2 }, Mode::Compare).unwrap();
    assert!(!actual.exists() && !diff.exists());
    check(&changed, Tolerance { per_channel: 9, pixels: 0 }, Mode::Compare).unwrap();

    let wide = VideoMemory::new(4, 2).unwrap();
    let error = check(&wide, Tolerance { per_channel: 255, pixels: 9 }, Mode::Compare).unwrap_err();
    assert!(error.to_string().contains("the golden file is 3x2, the frame 4x2"), "{error}");
    assert!(actual.exists() && !diff.exists());

    fs::write(&golden_path, b"not a png").unwrap();
    assert!(matches!(check(&m, Tolerance::EXACT, Mode::Compare), Err(GoldenError::Unreadable { .. })));
    fs::remove_file(&golden_path).unwrap();
    assert!(matches!(check(&m, Tolerance::EXACT, Mode::Compare), Err(GoldenError::Missing { .. })));
    assert!(actual.exists() && !golden_path.exists(), "a missing golden file is never made unasked");
}

#[test]
fn a_golden_file_that_claims_a_huge_picture_is_refused_before_it_is_unpacked() {
    let path = folder("huge").join("huge.png");
    save::to_path(&frame(), &path).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    for at in [16, 20] {
        bytes[at..at + 4].copy_from_slice(&20_000_u32.to_be_bytes());
    }
    let crc = crc32fast::hash(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    fs::write(&path, bytes).unwrap();
    let error = golden::read_png(&path).unwrap_err().to_string();
    assert!(error.ends_with("Memory limit exceeded"), "{error}");
}

#[test]
#[should_panic(expected = "no golden file")]
fn the_assertion_panics() {
    // With BLESS=1 it panics too, for another reason; this test is about the normal run.
    golden::assert_golden(&frame(), folder("panics").join("none.png"), Tolerance::EXACT);
}

#[test]
fn a_golden_file_without_its_folder_says_what_to_do_and_makes_nothing() {
    let inside = folder("without").join("not").join("there");
    let error = golden::check(&frame(), inside.join("a.png"), Tolerance::EXACT, Mode::Compare).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("mkdir -p") && text.contains("BLESS=1"), "{text}");
    assert!(!inside.exists());
    let blessed = golden::check(&frame(), inside.join("a.png"), Tolerance::EXACT, Mode::Bless);
    assert!(matches!(blessed, Err(golden::GoldenError::Blessed { .. })));
    golden::check(&frame(), inside.join("a.png"), Tolerance::EXACT, Mode::Compare).unwrap();
}

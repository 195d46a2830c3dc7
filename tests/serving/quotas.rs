//! Limits and permissions: each refusal has its code, and a refused command has no effect.

use crate::folder::Folder;
use crate::support::{Serving, Wire};
use fbptr::load::SandboxDir;
use fbptr::server::{Engine, Limits};

#[test]
fn one_connection_too_many_is_told_and_closed() {
    let serving = Serving::limited(8, 8, Limits { connections: 3, ..Limits::default() });
    let mut inside: Vec<Wire> = (0..3).map(|_| serving.connect()).collect();
    for wire in &mut inside {
        assert_eq!(wire.ask("SIZE\n"), "SIZE 8 8\n");
    }
    for _ in 0..5 {
        let told = String::from_utf8(serving.talk(b"SIZE\n")).unwrap();
        assert!(told.starts_with("ERR 0 0 EQUOTA CONNECT: "), "{told}");
        assert_eq!(told.lines().count(), 1);
    }
    for wire in &mut inside {
        assert_eq!(wire.ask("SIZE\n"), "SIZE 8 8\n", "those inside do not notice");
    }
    inside.pop();
    let until = std::time::Instant::now() + std::time::Duration::from_secs(10);
    while serving.talk(b"SIZE\n") != b"SIZE 8 8\n" {
        assert!(std::time::Instant::now() < until, "the place of one that left is not given again");
    }
}

#[test]
fn payloads_over_the_limit_are_refused_at_the_header_and_skipped() {
    let serving = Serving::limited(8, 8, Limits { payload_bytes: 100, ..Limits::default() });
    let mut request = b"BLIT 0 0 5 6 :120\n".to_vec();
    request.extend_from_slice(&[b'\n'; 120]);
    request.extend_from_slice(b"SYNC a\n");
    let got = String::from_utf8(serving.talk(&request)).unwrap();
    assert!(got.starts_with("ERR 1 0 ETOOBIG BLIT: ") && got.ends_with("\nSYNC a\n"), "{got}");
    let got = serving.say("SYNC a\nBLIT 0 0 1 1 :99999999999999999999999\nSYNC b\n");
    assert!(got.starts_with("SYNC a\nERR 2 7 EPROTO BLIT: ") && got.lines().count() == 2, "{got}");
}

#[test]
fn names_resources_and_matrices_have_quotas() {
    let limits =
        Limits { names: 3, resource_bytes: 1 << 20, matrix_stack: 4, lights: 2, ..Limits::default() };
    let serving = Serving::limited(8, 8, limits);
    let got =
        serving.say("MESH a BOX\nMESH b BOX\nMESH c BOX\nMESH d BOX\nMESH a SPHERE\nFREE b\nMESH d BOX\n");
    assert!(got.starts_with("ERR 4 33 EQUOTA MESH: ") && got.lines().count() == 1, "{got}");
    let got = serving.say("MESH big KNOT 1000 100\nDRAW big\n");
    assert!(got.contains("EQUOTA MESH") && got.contains("ENOENT DRAW"), "{got}");
    let got = serving.say(&("PUSH\n".repeat(5) + "POP\nPOP\nPOP\nPOP\nPOP\n"));
    let codes: Vec<&str> = got.lines().filter_map(|l| l.split(' ').nth(3)).collect();
    assert_eq!(codes, ["EQUOTA", "ERANGE"], "{got}");
    assert!(serving.say("LIGHT 1 OFF\nLIGHT 2 OFF\n").starts_with("ERR 2 12 ERANGE LIGHT: "));
    // Shared names have a quota of their own.
    let got = serving.say("MESH @a BOX\nMESH @b BOX\nMESH @c BOX\nMESH @d BOX\nMESH x BOX\n");
    assert!(got.starts_with("ERR 4 36 EQUOTA MESH: ") && got.lines().count() == 1, "{got}");
}

#[test]
fn a_reply_longer_than_a_client_may_have_waiting_is_refused() {
    let serving = Serving::limited(100, 100, Limits { reply_bytes: 1000, ..Limits::default() });
    let got = serving.say("READ 0 0 100 100\nPEEK 0 1000\nREAD 0 0 10 10\n");
    let lines: Vec<&str> = got.split('\n').collect();
    assert!(
        lines[0].starts_with("ERR 1 0 EQUOTA READ: ") && lines[1].starts_with("ERR 2 17 EQUOTA PEEK: "),
        "{got}"
    );
    assert_eq!(lines[2], "READ 0 0 10 10 :400");
}

#[test]
fn a_frame_that_cannot_be_had_is_refused_before_anything_starts() {
    assert!(Engine::with_limits(1000, 1000, Limits { frame_bytes: 3_999_999, ..Limits::default() }).is_err());
    assert!(Engine::new(32_768, 32_768).is_err());
    assert!(Engine::new(0, 1).is_err());
}

#[test]
fn files_are_touched_inside_their_folders_only() {
    let base = Folder::new("paths");
    for folder in ["snaps", "loads", "loads/sub"] {
        std::fs::create_dir(base.join(folder)).unwrap();
    }
    std::fs::write(base.join("secret.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::copy(base.join("secret.obj"), base.join("loads/sub/mine.obj")).unwrap();
    std::fs::write(base.join("loads/huge.obj"), vec![b'\n'; 5000]).unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(base.join("secret.obj"), base.join("loads/link.obj")).unwrap();
        std::os::unix::fs::symlink(&base, base.join("snaps/out")).unwrap();
    }
    let mut engine = Engine::with_limits(8, 8, Limits { payload_bytes: 4000, ..Limits::default() }).unwrap();
    engine.set_snap_dir(SandboxDir::open(&base.join("snaps")).unwrap());
    engine.set_load_dir(SandboxDir::open(&base.join("loads")).unwrap());
    let serving = Serving::with(engine);
    let secret = base.join("secret.obj").display().to_string();
    let refused = [
        "LOAD MESH m ../secret.obj\n".to_owned(),
        format!("LOAD MESH m {secret}\n"),
        "LOAD MESH m sub/../../secret.obj\n".into(),
        "LOAD MESH m sub\n".into(),
        "LOAD TEX t /dev/zero\n".into(),
        "LOAD SCENE ../x.x3d\n".into(),
        "SNAP ../a.png\n".into(),
        "SNAP /tmp/a.png\n".into(),
        "SNAP a/../../b.png\n".into(),
        "LOAD MESH m link.obj\n".into(),
        "SNAP out/a.png\n".into(),
    ];
    for request in refused.iter().filter(|r| cfg!(unix) || !(r.contains("link") || r.contains("out/"))) {
        let got = serving.say(request);
        assert_eq!(got.split(' ').nth(3), Some("EPERM"), "{request:?}: {got}");
    }
    assert_eq!(serving.say("LOAD MESH m none.obj\n").split(' ').nth(3), Some("ENOENT"));
    assert_eq!(serving.say("LOAD MESH m huge.obj\n").split(' ').nth(3), Some("ETOOBIG"));
    assert_eq!(serving.say("SNAP a.txt\n").split(' ').nth(3), Some("EARGS"));
    let nul = serving.talk(b"SNAP a\0.png\n");
    assert!(nul.starts_with(b"ERR 1 0 E"), "{:?}", String::from_utf8_lossy(&nul));
    let got = serving.say(concat!(
        "LIGHT 0 DIR 0 0 -1 1 1 1\nLOAD MESH m sub/mine.obj\nDRAW m\nPX 1 1 ff0000\n",
        "SNAP a.png\nSNAP a.raw\nCRC\n"
    ));
    let lines: Vec<&str> = got.lines().collect();
    let crc = lines[2].strip_prefix("CRC ").unwrap();
    assert_eq!(lines[..2], [format!("SNAP a.png 8 8 {crc}"), format!("SNAP a.raw 8 8 {crc}")]);
    assert_eq!(std::fs::read(base.join("snaps/a.raw")).unwrap(), serving.memory().bytes());
    let mut there: Vec<_> =
        std::fs::read_dir(base.join("snaps")).unwrap().map(|e| e.unwrap().file_name()).collect();
    there.sort();
    there.retain(|n| n != "out");
    assert_eq!(there, ["a.png", "a.raw"], "nothing else was made");
    assert!(!base.join("a.png").exists() && !base.join("b.png").exists());
}

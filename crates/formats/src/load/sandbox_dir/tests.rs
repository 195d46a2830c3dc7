//! Names that lead out of the folder, and folders that are swapped meanwhile.

use super::*;
use std::os::unix::fs::symlink;

#[test]
fn a_folder_that_is_exchanged_for_a_link_while_a_file_is_written_leads_nowhere_else() {
    let base = std::env::temp_dir().join(format!("fbptr-exchanged-{}", std::process::id()));
    let _ = fs::remove_dir_all(&base);
    fs::create_dir_all(base.join("in/sub/deep")).unwrap();
    fs::create_dir_all(base.join("elsewhere/deep")).unwrap();
    fs::write(base.join("elsewhere/deep/a"), "theirs").unwrap();
    let folder = SandboxDir::open(&base.join("in")).unwrap();
    folder.write("sub/deep/a", |out| out.write_all(b"old")).unwrap();
    let exchange = |out: &mut dyn Write| {
        fs::rename(base.join("in/sub"), base.join("in/moved"))?;
        symlink(base.join("elsewhere"), base.join("in/sub"))?;
        out.write_all(b"ours")
    };
    folder.write("sub/deep/a", exchange).unwrap();
    let names =
        |at: &str| fs::read_dir(base.join(at)).unwrap().map(|e| e.unwrap().file_name()).collect::<Vec<_>>();
    assert_eq!(fs::read(base.join("elsewhere/deep/a")).unwrap(), b"theirs");
    assert_eq!(fs::read(base.join("in/moved/deep/a")).unwrap(), b"ours");
    assert_eq!((names("elsewhere/deep").len(), names("in/moved/deep").len()), (1, 1), "nothing is left over");
    let refused = folder.write("sub/deep/a", |_| panic!("it is not opened")).unwrap_err();
    assert_eq!(refused.code(), Code::Perm);
    let failed = folder.write("b", |_| Err(io::Error::other("no"))).unwrap_err();
    assert!(matches!(failed, SandboxError::Io { .. }) && names("in").len() == 2);
    fs::remove_dir_all(&base).unwrap();
}

#[test]
fn only_plain_files_inside_are_read_or_written() {
    let base = std::env::temp_dir().join(format!("fbptr-folder-{}", std::process::id()));
    let _ = fs::remove_dir_all(&base);
    fs::create_dir_all(base.join("in/sub")).unwrap();
    fs::write(base.join("secret"), "secret").unwrap();
    fs::write(base.join("in/a"), "abc").unwrap();
    fs::write(base.join("in/sub/b"), "b").unwrap();
    symlink(base.join("secret"), base.join("in/link")).unwrap();
    symlink(&base, base.join("in/out")).unwrap();
    symlink("sub", base.join("in/alias")).unwrap();
    let folder = SandboxDir::open(&base.join("in")).unwrap();

    assert_eq!(folder.read("a", 3).unwrap(), b"abc");
    assert_eq!(folder.read("./sub/b", 3).unwrap(), b"b");
    assert_eq!(folder.read("a", 2).unwrap_err().code(), Code::TooBig);
    assert_eq!(folder.read("none", 9).unwrap_err().code(), Code::NoEnt);
    assert_eq!(folder.read("none/none", 9).unwrap_err().code(), Code::NoEnt);
    let secret = base.join("secret").to_string_lossy().into_owned();
    let refused = [
        "../secret",
        "sub/../../secret",
        "sub/../a",
        "..",
        ".",
        "",
        "/",
        "/etc/passwd",
        &secret,
        "link",
        "out/secret",
        "alias/b",
        "sub",
        "a/",
        "a\0",
        "\\a",
        "a/b",
        "sub/.",
    ];
    for name in refused {
        assert_eq!(folder.read(name, 99).unwrap_err().code(), Code::Perm, "{name:?}");
        assert_eq!(folder.path_to_write(name).unwrap_err().code(), Code::Perm, "{name:?}");
    }
    assert_eq!(folder.path_to_write("sub/new").unwrap(), folder.root().join("sub/new"));
    assert_eq!(folder.path_to_write("a").unwrap(), folder.root().join("a"));
    assert_eq!(folder.path_to_write("nowhere/new").unwrap_err().code(), Code::NoEnt);
    assert!(SandboxDir::open(Path::new("/dev/null")).is_err());
    fs::remove_dir_all(&base).unwrap();
}

#[test]
fn a_folder_that_becomes_a_link_while_it_is_walked_leads_nowhere() {
    let base = std::env::temp_dir().join(format!("fbptr-folder-swap-{}", std::process::id()));
    let _ = fs::remove_dir_all(&base);
    fs::create_dir_all(base.join("in/sub")).unwrap();
    fs::create_dir_all(base.join("out")).unwrap();
    fs::write(base.join("in/sub/a"), "mine").unwrap();
    fs::write(base.join("out/a"), "secret").unwrap();
    symlink(base.join("out"), base.join("in/link")).unwrap();
    let folder = SandboxDir::open(&base.join("in")).unwrap();
    // The state when the swap comes after the first check.
    let opened = |name: &str| open::plain_file(folder.root(), Path::new(name));
    assert!(matches!(opened("link/a"), Err(open::OpenError::Link)));
    assert!(opened("sub/a").is_ok());
    let is_over = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_over.load(std::sync::atomic::Ordering::Relaxed) {
                let (sub, link, kept) = (base.join("in/sub"), base.join("in/link"), base.join("in/kept"));
                let _ = fs::rename(&sub, &kept).and_then(|()| fs::rename(&link, &sub));
                let _ = fs::rename(&sub, &link).and_then(|()| fs::rename(&kept, &sub));
            }
        });
        for _ in 0..3000 {
            if let Ok(bytes) = folder.read("sub/a", 99) {
                assert_eq!(bytes, b"mine");
            }
        }
        is_over.store(true, std::sync::atomic::Ordering::Relaxed);
    });
    fs::remove_dir_all(&base).unwrap();
}

#[test]
fn devices_are_refused_without_being_opened() {
    let folder = SandboxDir::open(Path::new("/dev")).unwrap();
    assert_eq!(folder.read("zero", 10).unwrap_err().code(), Code::Perm);
    assert_eq!(folder.path_to_write("null").unwrap_err().code(), Code::Perm);
}

fn make_pipe(path: &Path) {
    assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
}

/// Runs `task` on a thread of its own; returns whether it ended before a timeout.
fn ends(task: impl FnOnce() + Send + 'static) -> bool {
    let (over, is_over) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        task();
        over.send(()).unwrap();
    });
    is_over.recv_timeout(std::time::Duration::from_secs(30)).is_ok()
}

#[test]
fn what_is_no_plain_file_when_it_is_opened_is_refused_without_waiting() {
    let base = std::env::temp_dir().join(format!("fbptr-folder-kinds-{}", std::process::id()));
    let _ = fs::remove_dir_all(&base);
    fs::create_dir_all(base.join("folder")).unwrap();
    make_pipe(&base.join("pipe"));
    let _socket = std::os::unix::net::UnixListener::bind(base.join("socket")).unwrap();
    symlink("file", base.join("link")).unwrap();
    fs::write(base.join("file"), "abc").unwrap();
    let root = base.clone();
    // Without the first check, which a swap evades.
    let task = move || {
        for name in ["pipe", "socket", "folder"] {
            let refused = open::plain_file(&root, Path::new(name)).unwrap_err();
            assert!(matches!(refused, open::OpenError::NotPlain), "{name}: {refused:?}");
        }
        assert!(matches!(open::plain_file(&root, Path::new("link")), Err(open::OpenError::Link)));
        let refused = open::plain_file(Path::new("/dev"), Path::new("null")).unwrap_err();
        assert!(matches!(refused, open::OpenError::NotPlain), "{refused:?}");
        assert!(open::plain_file(&root, Path::new("file")).is_ok());
    };
    assert!(ends(task), "an opening waits");
    fs::remove_dir_all(&base).unwrap();
}

#[test]
fn a_file_that_is_exchanged_for_a_pipe_while_it_is_read_holds_nobody_up() {
    let base = std::env::temp_dir().join(format!("fbptr-folder-pipe-{}", std::process::id()));
    let _ = fs::remove_dir_all(&base);
    fs::create_dir_all(&base).unwrap();
    fs::write(base.join("kept"), "abc").unwrap();
    make_pipe(&base.join("pipe"));
    let folder = SandboxDir::open(&base).unwrap();
    let task = move || {
        let root = folder.root().to_owned();
        let is_over = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        let seen = is_over.clone();
        let exchange = std::thread::spawn(move || {
            let [a, pipe, kept] = ["a", "pipe", "kept"].map(|name| root.join(name));
            while !seen.load(std::sync::atomic::Ordering::Relaxed) {
                let _ = fs::rename(&kept, &a).and_then(|()| fs::rename(&a, &kept));
                let _ = fs::rename(&pipe, &a).and_then(|()| fs::rename(&a, &pipe));
            }
        });
        for _ in 0..20_000 {
            match folder.read("a", 99) {
                Ok(bytes) => assert_eq!(bytes, b"abc"),
                Err(e) => assert!(matches!(e.code(), Code::Perm | Code::NoEnt), "{e}"),
            }
        }
        is_over.store(true, std::sync::atomic::Ordering::Relaxed);
        exchange.join().unwrap();
    };
    assert!(ends(task), "a read waits for a pipe");
    fs::remove_dir_all(&base).unwrap();
}

#[test]
fn a_quota_counts_what_was_written_through_it_and_is_still_there() {
    let base = std::env::temp_dir().join(format!("fbptr-folder-quota-{}", std::process::id()));
    let _ = fs::remove_dir_all(&base);
    fs::create_dir_all(&base).unwrap();
    fs::write(base.join("theirs"), [0; 50_000]).unwrap();
    let folder = QuotaDir::new(SandboxDir::open(&base).unwrap(), 3 * 4096);
    let write = |name: &str, bytes: usize| {
        // Written in pieces, as encoders do.
        folder.write(name, |out| (0..bytes).try_for_each(|i| out.write_all(&[i as u8])))
    };
    write("a", 4097).unwrap();
    assert_eq!(folder.used_bytes(), 8192);
    write("b", 1).unwrap();
    let refused = write("c", 1).unwrap_err();
    assert_eq!(refused, SandboxError::Quota { name: "c".into(), used: 12_288, limit: 12_288 });
    assert_eq!(refused.code(), Code::Quota);
    assert!(!base.join("c").exists() && fs::read_dir(&base).unwrap().count() == 3, "nothing is left over");
    // A file's room is available to its successor, whatever the spelling of its name, and to no
    // other file.
    write("./a", 8192).unwrap();
    assert_eq!(write("a", 8193).unwrap_err().code(), Code::Quota);
    assert_eq!((fs::metadata(base.join("a")).unwrap().len(), folder.used_bytes()), (8192, 12_288));
    // A write that failed for another reason takes no room.
    let failed = folder.write("b", |_| Err(io::Error::other("no"))).unwrap_err();
    assert!(matches!(failed, SandboxError::Io { .. }) && folder.used_bytes() == 12_288);
    // Files removed by others make room.
    fs::remove_file(base.join("a")).unwrap();
    write("c", 5000).unwrap();
    assert_eq!(folder.used_bytes(), 12_288);
    fs::remove_dir_all(&base).unwrap();
}

//! Names that lead out of the folder, and folders that are exchanged meanwhile.

use super::*;
use std::os::unix::fs::symlink;

#[test]
fn a_folder_that_is_exchanged_for_a_link_while_a_file_is_written_leads_nowhere_else() {
    let base = std::env::temp_dir().join(format!("fbptr-exchanged-{}", std::process::id()));
    let _ = fs::remove_dir_all(&base);
    fs::create_dir_all(base.join("in/sub/deep")).unwrap();
    fs::create_dir_all(base.join("elsewhere/deep")).unwrap();
    fs::write(base.join("elsewhere/deep/a"), "theirs").unwrap();
    let folder = Folder::open(&base.join("in")).unwrap();
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
    assert!(matches!(failed, FolderError::Io { .. }) && names("in").len() == 2);
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
    let folder = Folder::open(&base.join("in")).unwrap();

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
    assert!(Folder::open(Path::new("/dev/null")).is_err());
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
    let folder = Folder::open(&base.join("in")).unwrap();
    // What the last check sees when the swap comes after the first ones.
    let path = base.join("in/link/a");
    assert!(!folder.holds(&File::open(&path).unwrap(), &path));
    let path = base.join("in/sub/a");
    assert!(folder.holds(&File::open(&path).unwrap(), &path));
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
    let folder = Folder::open(Path::new("/dev")).unwrap();
    assert_eq!(folder.read("zero", 10).unwrap_err().code(), Code::Perm);
    assert_eq!(folder.path_to_write("null").unwrap_err().code(), Code::Perm);
}

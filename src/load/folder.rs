//! A folder that strangers may name files in: the rule of LOAD, SNAP and of what files refer to.
//!
//! In: names from a stream or a file. Out: the file's bytes, or a path to write, or why not. A name is relative, has no
//! `..`, meets no symbolic link on its way, and stands for a plain file: everything else is refused before it is opened.

use crate::error::{Code, Fault};
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Component, Path, PathBuf};
#[cfg(unix)]
use std::sync::atomic::{AtomicU64, Ordering};

/// Makes temporary files' names differ.
#[cfg(unix)]
static NEXT_TEMPORARY: AtomicU64 = AtomicU64::new(0);

/// Why a name was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FolderError {
    /// The name is no relative path of plain steps.
    #[error("a file's name is relative, without \"..\", inside the folder: {name:?} is not")]
    BadName {
        /// The name.
        name: String,
    },
    /// A step of the name is a symbolic link.
    #[error("{name:?} goes through a symbolic link")]
    Link {
        /// The name.
        name: String,
    },
    /// The name stands for something that is no plain file.
    #[error("{name:?} is no plain file")]
    NotPlain {
        /// The name.
        name: String,
    },
    /// There is no such file, or no folder for it.
    #[error("{name:?} is not there")]
    Missing {
        /// The name.
        name: String,
    },
    /// The file is over the limit.
    #[error("{name:?} has {found} bytes, and the limit is {limit}")]
    TooLarge {
        /// The name.
        name: String,
        /// Bytes that it has.
        found: u64,
        /// Bytes that it may have.
        limit: u64,
    },
    /// There is no room left to write it.
    #[error("{name:?}: there is no room left")]
    Full {
        /// The name.
        name: String,
    },
    /// The system refused.
    #[error("{name:?}: {reason}")]
    Io {
        /// The name.
        name: String,
        /// The system's words.
        reason: String,
    },
}

impl FolderError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            FolderError::Missing { .. } => Code::NoEnt,
            FolderError::TooLarge { .. } => Code::TooBig,
            FolderError::Full { .. } => Code::Quota,
            _ => Code::Perm,
        }
    }
}

impl From<FolderError> for Fault {
    fn from(e: FolderError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

/// A folder inside which files may be read or written by name.
#[derive(Clone, Debug)]
pub struct Folder {
    root: PathBuf,
}

impl Folder {
    /// The folder at `root`.
    ///
    /// # Errors
    /// When there is no folder.
    pub fn open(root: &Path) -> io::Result<Folder> {
        let root = fs::canonicalize(root)?;
        match root.is_dir() {
            true => Ok(Folder { root }),
            false => Err(io::Error::new(io::ErrorKind::NotADirectory, "not a folder")),
        }
    }

    /// Where it is.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The bytes of the file `name`, at most `limit` of them.
    ///
    /// # Errors
    /// See [`FolderError`].
    pub fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, FolderError> {
        let path = self.walk(name)?;
        let meta = fs::symlink_metadata(&path).map_err(|e| from_io(name, &e))?;
        check_plain(name, &meta)?;
        let mut file = File::open(&path).map_err(|e| from_io(name, &e))?;
        let opened = file.metadata().map_err(|e| from_io(name, &e))?;
        check_plain(name, &opened)?;
        if !is_same_file(&meta, &opened) || !self.holds(&file, &path) {
            // It, or a folder on the way, was exchanged between the look and the opening.
            return Err(FolderError::Link { name: name.into() });
        }
        let too_large = |found| FolderError::TooLarge { name: name.into(), found, limit };
        if opened.len() > limit {
            return Err(too_large(opened.len()));
        }
        let mut bytes = Vec::new();
        // A file that grows while it is read ends at the limit too.
        let mut reader = (&mut file).take(limit.saturating_add(1));
        reader.read_to_end(&mut bytes).map_err(|e| from_io(name, &e))?;
        match bytes.len() as u64 <= limit {
            true => Ok(bytes),
            false => Err(too_large(bytes.len() as u64)),
        }
    }

    /// Whether an opened file lies in the folder, wherever its path leads by now.
    fn holds(&self, file: &File, path: &Path) -> bool {
        #[cfg(target_os = "linux")]
        {
            use std::os::fd::AsRawFd;
            if let Ok(real) = fs::read_link(format!("/proc/self/fd/{}", file.as_raw_fd())) {
                return real.starts_with(&self.root);
            }
        }
        let _ = file;
        fs::canonicalize(path).is_ok_and(|real| real.starts_with(&self.root))
    }

    /// The path under which the file `name` may be written: a plain file that is there, or none.
    ///
    /// # Errors
    /// See [`FolderError`].
    pub fn path_to_write(&self, name: &str) -> Result<PathBuf, FolderError> {
        let path = self.walk(name)?;
        match fs::symlink_metadata(&path) {
            Ok(meta) => check_plain(name, &meta).map(|()| path),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(path),
            Err(e) => Err(from_io(name, &e)),
        }
    }

    /// Writes the file `name`, which changes only when all of it is written. Folders on the way are opened one from the
    /// other and never by path, so that one that is exchanged for a link meanwhile leads nowhere else.
    ///
    /// # Errors
    /// See [`FolderError`].
    #[cfg(unix)]
    pub fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), FolderError> {
        use rustix::fs::{AtFlags, Mode, OFlags, open, openat, renameat, unlinkat};
        // Says what is wrong with a name that is not meant well; what counts is what is opened below.
        let path = self.path_to_write(name)?;
        let failed = |e: rustix::io::Errno| match e {
            rustix::io::Errno::LOOP | rustix::io::Errno::NOTDIR => FolderError::Link { name: name.into() },
            e => from_io(name, &e.into()),
        };
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let mut folder = open(&self.root, flags, Mode::empty()).map_err(failed)?;
        let inside = path.strip_prefix(&self.root).unwrap_or(&path);
        for step in inside.parent().into_iter().flat_map(Path::components) {
            folder = openat(&folder, step.as_os_str(), flags, Mode::empty()).map_err(failed)?;
        }
        let target = inside.file_name().unwrap_or_default();
        let (temporary, file) = loop {
            // Short, so that a name near the system's limit still finds room.
            let number = NEXT_TEMPORARY.fetch_add(1, Ordering::Relaxed);
            let temporary = format!(".fbptr-{}-w{number}.tmp", std::process::id());
            let new = OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::CLOEXEC;
            match openat(&folder, &*temporary, new, Mode::from_raw_mode(0o666)) {
                Err(rustix::io::Errno::EXIST) => {}
                file => break (temporary, File::from(file.map_err(failed)?)),
            }
        };
        let mut out = io::BufWriter::with_capacity(1 << 16, file);
        let written = fill(&mut out)
            .and_then(|()| out.into_inner().map(drop).map_err(io::IntoInnerError::into_error))
            .and_then(|()| Ok(renameat(&folder, &*temporary, &folder, target)?));
        written.map_err(|e| {
            // The error that counts is the first one; the leftover is removed if it can be.
            let _ = unlinkat(&folder, &*temporary, AtFlags::empty());
            from_io(name, &e)
        })
    }

    /// Writes the file `name`, which changes only when all of it is written.
    ///
    /// # Errors
    /// See [`FolderError`].
    #[cfg(not(unix))]
    pub fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), FolderError> {
        let path = self.path_to_write(name)?;
        let failed = |e: crate::save::SaveError| FolderError::Io { name: name.into(), reason: e.to_string() };
        crate::save::atomically(&path, fill).map_err(failed)
    }

    /// The path of `name`, all of its folders there and none of them a link. Its last step is not looked at.
    fn walk(&self, name: &str) -> Result<PathBuf, FolderError> {
        let bad_name = || FolderError::BadName { name: name.into() };
        if name.contains(['\0', '\\']) || name.ends_with('/') || name.ends_with("/.") {
            return Err(bad_name());
        }
        let mut steps = Vec::new();
        for component in Path::new(name).components() {
            match component {
                Component::Normal(step) => steps.push(step),
                Component::CurDir => {}
                _ => return Err(bad_name()),
            }
        }
        let last = steps.pop().ok_or_else(bad_name)?;
        let mut path = self.root.clone();
        for step in steps {
            path.push(step);
            let meta = fs::symlink_metadata(&path).map_err(|e| from_io(name, &e))?;
            if meta.is_symlink() {
                return Err(FolderError::Link { name: name.into() });
            }
            if !meta.is_dir() {
                return Err(FolderError::NotPlain { name: name.into() });
            }
        }
        path.push(last);
        Ok(path)
    }
}

fn check_plain(name: &str, meta: &fs::Metadata) -> Result<(), FolderError> {
    match () {
        () if meta.is_symlink() => Err(FolderError::Link { name: name.into() }),
        () if !meta.is_file() => Err(FolderError::NotPlain { name: name.into() }),
        () => Ok(()),
    }
}

#[cfg(unix)]
fn is_same_file(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_same_file(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    a.len() == b.len() && a.modified().ok() == b.modified().ok()
}

fn from_io(name: &str, e: &io::Error) -> FolderError {
    match e.kind() {
        io::ErrorKind::NotFound => FolderError::Missing { name: name.into() },
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => FolderError::Full { name: name.into() },
        _ => FolderError::Io { name: name.into(), reason: e.to_string() },
    }
}

#[cfg(all(test, unix))]
mod tests {
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
        let names = |at: &str| {
            fs::read_dir(base.join(at)).unwrap().map(|e| e.unwrap().file_name()).collect::<Vec<_>>()
        };
        assert_eq!(fs::read(base.join("elsewhere/deep/a")).unwrap(), b"theirs");
        assert_eq!(fs::read(base.join("in/moved/deep/a")).unwrap(), b"ours");
        assert_eq!(
            (names("elsewhere/deep").len(), names("in/moved/deep").len()),
            (1, 1),
            "nothing is left over"
        );
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
}

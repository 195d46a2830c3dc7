//! A folder that strangers may name files in: the rule of LOAD, SNAP and of what files refer to.
//!
//! In: names from a stream or a file. Out: the file's bytes, or a path to write, or why not. A name is relative, has no
//! `..`, meets no symbolic link on its way, and stands for a plain file: everything else is refused before it is opened.
//! One that is exchanged between that look and the opening is refused after: no opening waits, and what counts is what was
//! opened. [`QuotaDir`] bounds what is written.

mod open;
mod put;
mod quota;
#[cfg(all(test, unix))]
mod tests;

pub use quota::QuotaDir;

use crate::error::{Code, Fault};
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Component, Path, PathBuf};

/// Why a name was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SandboxError {
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
    /// The files written into the folder would take more than they may.
    #[error(
        "{name:?}: the files that SNAP wrote take {used} of {limit} bytes, and there is no room for this one"
    )]
    Quota {
        /// The name.
        name: String,
        /// Bytes that are taken.
        used: u64,
        /// Bytes that may be taken.
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

impl SandboxError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            SandboxError::Missing { .. } => Code::NoEnt,
            SandboxError::TooLarge { .. } => Code::TooBig,
            SandboxError::Full { .. } | SandboxError::Quota { .. } => Code::Quota,
            _ => Code::Perm,
        }
    }
}

impl From<SandboxError> for Fault {
    fn from(e: SandboxError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

/// A folder inside which files may be read or written by name.
#[derive(Clone, Debug)]
pub struct SandboxDir {
    root: PathBuf,
}

impl SandboxDir {
    /// The folder at `root`.
    ///
    /// # Errors
    /// When there is no folder.
    pub fn open(root: &Path) -> io::Result<SandboxDir> {
        let root = fs::canonicalize(root)?;
        match root.is_dir() {
            true => Ok(SandboxDir { root }),
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
    /// See [`SandboxError`].
    pub fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, SandboxError> {
        // Says what is wrong with a name that is not meant well; what counts is what is opened after.
        let path = self.resolve(name)?;
        let meta = fs::symlink_metadata(&path).map_err(|e| from_io(name, &e))?;
        check_plain(name, &meta)?;
        let mut file = open::plain_file(&self.root, self.inside(&path)).map_err(|e| e.named(name))?;
        let opened = file.metadata().map_err(|e| from_io(name, &e))?;
        let too_large = |found| SandboxError::TooLarge { name: name.into(), found, limit };
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

    /// A path that was walked, as seen from the folder.
    fn inside<'a>(&self, path: &'a Path) -> &'a Path {
        path.strip_prefix(&self.root).unwrap_or(path)
    }

    /// The path under which the file `name` may be written: a plain file that is there, or none.
    ///
    /// # Errors
    /// See [`SandboxError`].
    pub fn path_to_write(&self, name: &str) -> Result<PathBuf, SandboxError> {
        let path = self.resolve(name)?;
        match fs::symlink_metadata(&path) {
            Ok(meta) => check_plain(name, &meta).map(|()| path),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(path),
            Err(e) => Err(from_io(name, &e)),
        }
    }

    /// Writes the file `name`, which changes only when all of it is written. Where the system can, folders on the way are
    /// opened one from the other and never by path, so that one that is exchanged for a link meanwhile leads nowhere else.
    ///
    /// # Errors
    /// See [`SandboxError`].
    pub fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), SandboxError> {
        // Says what is wrong with a name that is not meant well; what counts is what is opened after.
        let path = self.path_to_write(name)?;
        put::put(&self.root, self.inside(&path), fill).map_err(|e| e.named(name))
    }

    /// The path of `name`, all of its folders there and none of them a link. Its last step is not looked at.
    fn resolve(&self, name: &str) -> Result<PathBuf, SandboxError> {
        let bad_name = || SandboxError::BadName { name: name.into() };
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
                return Err(SandboxError::Link { name: name.into() });
            }
            if !meta.is_dir() {
                return Err(SandboxError::NotPlain { name: name.into() });
            }
        }
        path.push(last);
        Ok(path)
    }
}

fn check_plain(name: &str, meta: &fs::Metadata) -> Result<(), SandboxError> {
    match () {
        () if meta.is_symlink() => Err(SandboxError::Link { name: name.into() }),
        () if !meta.is_file() => Err(SandboxError::NotPlain { name: name.into() }),
        () => Ok(()),
    }
}

fn from_io(name: &str, e: &io::Error) -> SandboxError {
    match e.kind() {
        io::ErrorKind::NotFound => SandboxError::Missing { name: name.into() },
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => SandboxError::Full { name: name.into() },
        _ => SandboxError::Io { name: name.into(), reason: e.to_string() },
    }
}

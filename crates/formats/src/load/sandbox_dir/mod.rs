//! A folder in which untrusted names may be opened: used by LOAD, SNAP and for files that other
//! files refer to.
//!
//! In: names from a stream or a file. Out: the file's bytes, a path to write, or an error. A valid
//! name is relative, has no `..`, passes no symbolic link, and refers to a regular file: everything
//! else is refused before it is opened. A path that is swapped between this check and the opening
//! is refused afterwards: the opened file is checked again, and opening never blocks. [`QuotaDir`]
//! limits the bytes written.

mod open;
mod put;
mod quota;
#[cfg(all(test, unix))]
mod tests;

pub use quota::QuotaDir;

use fbptr_core::error::{Code, Fault};
use std::fmt;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Component, Path, PathBuf};

/// Reason why a name was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SandboxError {
    /// The name is not a relative path of plain components.
    BadName {
        /// Name as given.
        name: String,
    },
    /// A component of the name is a symbolic link.
    Link {
        /// Name as given.
        name: String,
    },
    /// The name refers to something other than a regular file.
    NotPlain {
        /// Name as given.
        name: String,
    },
    /// There is no such file, or no folder for it.
    Missing {
        /// Name as given.
        name: String,
    },
    /// The file is larger than the limit.
    TooLarge {
        /// Name as given.
        name: String,
        /// Size of the file in bytes.
        found: u64,
        /// Largest size allowed, in bytes.
        limit: u64,
    },
    /// The files written into the folder would exceed the quota.
    Quota {
        /// Name as given.
        name: String,
        /// Bytes in use.
        used: u64,
        /// Bytes allowed in total.
        limit: u64,
    },
    /// The disk is full.
    Full {
        /// Name as given.
        name: String,
    },
    /// The operating system reported another error.
    Io {
        /// Name as given.
        name: String,
        /// Message of the operating system.
        reason: String,
    },
}

impl fmt::Display for SandboxError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SandboxError::BadName { name } => {
                write!(f, "a file's name is relative, without \"..\", inside the folder: {name:?} is not")
            }
            SandboxError::Link { name } => write!(f, "{name:?} goes through a symbolic link"),
            SandboxError::NotPlain { name } => write!(f, "{name:?} is no plain file"),
            SandboxError::Missing { name } => write!(f, "{name:?} is not there"),
            SandboxError::TooLarge { name, found, limit } => {
                write!(f, "{name:?} has {found} bytes, and the limit is {limit}")
            }
            SandboxError::Quota { name, used, limit } => {
                write!(f, "{name:?}: the files that SNAP wrote take {used} of {limit} bytes, ")?;
                f.write_str("and there is no room for this one")
            }
            SandboxError::Full { name } => write!(f, "{name:?}: there is no room left"),
            SandboxError::Io { name, reason } => write!(f, "{name:?}: {reason}"),
        }
    }
}

impl std::error::Error for SandboxError {}

impl SandboxError {
    /// Returns the protocol's code for this error.
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

/// A folder in which files may be read and written by untrusted names.
#[derive(Clone, Debug)]
pub struct SandboxDir {
    root: PathBuf,
}

impl SandboxDir {
    /// Opens the folder at `root`.
    ///
    /// # Errors If `root` does not exist or is not a folder.
    pub fn open(root: &Path) -> io::Result<SandboxDir> {
        let root = fs::canonicalize(root)?;
        match root.is_dir() {
            true => Ok(SandboxDir { root }),
            false => Err(io::Error::new(io::ErrorKind::NotADirectory, "not a folder")),
        }
    }

    /// Returns the canonical path of the folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Reads the file `name`, of at most `limit` bytes.
    ///
    /// # Errors
    /// See [`SandboxError`].
    pub fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, SandboxError> {
        // Finds the precise reason for a bad name; the check that counts is made on the opened
        // file.
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
        // A file that grows while it is read is cut off at the limit, too.
        let mut reader = (&mut file).take(limit.saturating_add(1));
        reader.read_to_end(&mut bytes).map_err(|e| from_io(name, &e))?;
        match bytes.len() as u64 <= limit {
            true => Ok(bytes),
            false => Err(too_large(bytes.len() as u64)),
        }
    }

    /// Returns the name of a file that differs from `name` in the case of letters alone: in each
    /// folder the first by name, of those that are not spelled like it. `None` if there is none, or
    /// `name` is not the name of a file inside.
    pub fn other_case(&self, name: &str) -> Option<String> {
        /// Most entries of a folder that are looked at.
        const MOST: usize = 10_000;
        let mut path = self.root.clone();
        let mut found = Vec::new();
        for component in Path::new(name).components() {
            let step = match component {
                Component::Normal(step) => step.to_str()?,
                Component::CurDir => continue,
                _ => return None,
            };
            let next = match fs::symlink_metadata(path.join(step)) {
                Ok(meta) if meta.is_symlink() => return None,
                Ok(_) => step.to_owned(),
                Err(_) => {
                    let lower = step.to_lowercase();
                    let entries = fs::read_dir(&path).ok()?.take(MOST).filter_map(Result::ok);
                    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
                    names.filter(|name| name.to_lowercase() == lower).min()?
                }
            };
            path.push(&next);
            found.push(next);
        }
        let found = found.join("/");
        (found != name && !found.is_empty()).then_some(found)
    }

    /// Returns a resolved path relative to the folder.
    fn inside<'a>(&self, path: &'a Path) -> &'a Path {
        path.strip_prefix(&self.root).unwrap_or(path)
    }

    /// Returns the path under which `name` may be written: of a regular file, or of none.
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

    /// Writes the file `name`, atomically: it changes only when all of it is written. On Unix each
    /// folder on the way is opened relative to the one before, never by path, so that a folder
    /// swapped for a link meanwhile leads nowhere else.
    ///
    /// # Errors
    /// See [`SandboxError`].
    pub fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), SandboxError> {
        // Finds the precise reason for a bad name; the check that counts is made when the folders
        // are opened.
        let path = self.path_to_write(name)?;
        put::put(&self.root, self.inside(&path), fill).map_err(|e| e.named(name))
    }

    /// Returns the path of `name` after a check that its folders exist and are no links. The last
    /// component is not checked.
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

/// Checks that `meta` is that of a regular file.
fn check_plain(name: &str, meta: &fs::Metadata) -> Result<(), SandboxError> {
    match () {
        () if meta.is_symlink() => Err(SandboxError::Link { name: name.into() }),
        () if !meta.is_file() => Err(SandboxError::NotPlain { name: name.into() }),
        () => Ok(()),
    }
}

/// Converts an error of the operating system, for the file called `name`.
fn from_io(name: &str, e: &io::Error) -> SandboxError {
    match e.kind() {
        io::ErrorKind::NotFound => SandboxError::Missing { name: name.into() },
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => SandboxError::Full { name: name.into() },
        _ => SandboxError::Io { name: name.into(), reason: e.to_string() },
    }
}

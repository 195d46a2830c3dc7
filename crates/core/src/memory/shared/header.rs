//! Header of the shared file, and the errors of opening one.

use crate::error::{Code, Fault};
use crate::memory::MAX_SIDE;
use std::error::Error;
use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::PathBuf;

/// Size of the header in bytes; the pixels follow it.
pub const SHARED_HEADER_BYTES: usize = 4096;
/// First eight bytes of a shared file.
pub const SHARED_MAGIC: [u8; 8] = *b"FBPTRSHM";

/// Error of opening or using a shared file.
#[derive(Debug)]
pub enum SharedError {
    /// The file exists and is not a shared video memory of the expected size. It is left unchanged.
    NotOurs {
        /// Path of the file.
        path: PathBuf,
        /// Property that a shared file has.
        expected: String,
        /// Property found instead.
        found: String,
    },
    /// The file system has no room for the file.
    NoRoom {
        /// Path of the file.
        path: PathBuf,
        /// Size of the file in bytes.
        bytes: u64,
    },
    /// Another program made the file shorter.
    Truncated {
        /// Path of the file.
        path: PathBuf,
        /// Expected size in bytes.
        expected: u64,
        /// Size found in bytes.
        found: u64,
    },
    /// Another server has locked the file.
    InUse {
        /// Path of the file.
        path: PathBuf,
    },
    /// The system refused an operation.
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
}

impl fmt::Display for SharedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SharedError::NotOurs { path, expected, found } => {
                let path = path.display();
                write!(f, "{path} is not a shared video memory of this server: ")?;
                write!(f, "expected {expected}, found {found}")
            }
            SharedError::NoRoom { path, bytes } => {
                write!(f, "{}: no room for the file's {bytes} bytes", path.display())
            }
            SharedError::Truncated { path, expected, found } if found >= expected => {
                let path = path.display();
                write!(f, "{path}: another program truncated it for a time: its {expected} bytes are ")?;
                write!(f, "there again, and what was in them is lost")
            }
            SharedError::Truncated { path, expected, found } => {
                let path = path.display();
                write!(f, "{path}: another program truncated it from {expected} to {found} bytes")
            }
            SharedError::InUse { path } => write!(f, "{} is in use by another server", path.display()),
            SharedError::Io { path, source } => write!(f, "{}: {source}", path.display()),
        }
    }
}

impl Error for SharedError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            SharedError::Io { source, .. } => Some(source),
            _ => None,
        }
    }
}

impl SharedError {
    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            SharedError::NotOurs { .. } => Code::Format,
            SharedError::NoRoom { .. } => Code::Quota,
            SharedError::Truncated { .. } => Code::Perm,
            SharedError::InUse { .. } | SharedError::Io { .. } => Code::Perm,
        }
    }
}

impl From<SharedError> for Fault {
    fn from(e: SharedError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

/// Names the kind of a file that is not a regular one.
pub(super) fn kind_of(meta: &std::fs::Metadata) -> &'static str {
    match () {
        () if meta.is_symlink() => "a symbolic link",
        () if meta.is_dir() => "a folder",
        () => "a device or pipe",
    }
}

/// Reads and checks a header. Returns the width and height in pixels, or the expected and the found
/// property.
pub(super) fn read_header(file: &mut File) -> io::Result<Result<(u32, u32), (String, String)>> {
    let len = file.metadata()?.len();
    let refuse = |expected: &str, found: String| Ok(Err((expected.to_owned(), found)));
    if len < SHARED_HEADER_BYTES as u64 {
        return refuse("a header of 4096 bytes", format!("{len} bytes"));
    }
    let mut header = [0; 64];
    file.read_exact(&mut header)?;
    if header[..8] != SHARED_MAGIC {
        return refuse("the magic FBPTRSHM", format!("\"{}\"", header[..8].escape_ascii()));
    }
    let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| header[at + i]));
    let (width, height) = (word(16), word(20));
    let checks = [("version", word(8), 1), ("header bytes", word(12), 4096), ("format", word(28), 1)];
    for (what, found, expected) in checks {
        if found != expected {
            return refuse(&format!("{what} {expected}"), found.to_string());
        }
    }
    let side = 1..=MAX_SIDE;
    if !side.contains(&width) || !side.contains(&height) || word(24) != width * 4 {
        return refuse("a size and its stride", format!("{width}x{height}, stride {}", word(24)));
    }
    let expected = SHARED_HEADER_BYTES as u64 + width as u64 * height as u64 * 4;
    match len == expected {
        true => Ok(Ok((width, height))),
        false => refuse(&format!("{expected} bytes"), format!("{len} bytes")),
    }
}

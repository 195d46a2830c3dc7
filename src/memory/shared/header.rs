//! What makes a file a shared one: its header, and why one is refused.

use crate::error::Code;
use crate::memory::MAX_SIDE;
use std::fs::File;
use std::io::{self, Read};
use std::path::PathBuf;

/// Bytes before the pixels.
pub const SHARED_HEADER_BYTES: usize = 4096;
/// The first eight bytes of a shared file.
pub const SHARED_MAGIC: [u8; 8] = *b"FBPTRSHM";

/// Why a shared file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SharedError {
    /// The file is there, and is not a shared video memory that fits. It is left as it is.
    #[error("{} is not a shared video memory of this server: expected {expected}, found {found}", path.display())]
    NotOurs {
        /// The file.
        path: PathBuf,
        /// What a shared file has.
        expected: String,
        /// What this one has.
        found: String,
    },
    /// The file system has no room for the file.
    #[error("{}: no room for the file's {bytes} bytes", path.display())]
    NoRoom {
        /// The file.
        path: PathBuf,
        /// Bytes that it takes.
        bytes: u64,
    },
    /// Another program made the file shorter.
    #[error("{}: another program truncated it from {expected} to {found} bytes", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Bytes that it had.
        expected: u64,
        /// Bytes that it has.
        found: u64,
    },
    /// Another server has it.
    #[error("{} is in use by another server", path.display())]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl SharedError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            SharedError::NotOurs { .. } => Code::Format,
            SharedError::NoRoom { .. } => Code::Quota,
            SharedError::Truncated { .. } => Code::Perm,
            SharedError::InUse { .. } | SharedError::Io { .. } => Code::Perm,
        }
    }
}

/// What stands where a plain file should.
pub(super) fn kind_of(meta: &std::fs::Metadata) -> &'static str {
    match () {
        () if meta.is_symlink() => "a symbolic link",
        () if meta.is_dir() => "a folder",
        () => "a device or pipe",
    }
}

/// Checks a header: width and height, or what was expected and what was found.
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

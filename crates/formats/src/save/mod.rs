//! File output: snapshots (png, ppm, raw), movies (GIF, APNG, y4m, numbered PNGs), depth as PFM,
//! and the comparison of snapshots in tests.
//!
//! In: a [`VideoMemory`](fbptr_core::memory::VideoMemory) or a
//! [`DepthMemory`](fbptr_core::memory::DepthMemory), row 0 at the top. Out: bytes to any writer, or a
//! file that is replaced atomically. The same picture gives the same file.

mod atomic;
mod formats;
pub mod golden;
mod movie;
mod read;
mod read_file;
mod rgba;
mod temporary;

pub use atomic::begin;
pub use atomic::is_link;
pub use atomic::{atomically, replace};
pub use formats::{SnapshotFormat, check_depth_path, crc32, depth_to_path, pfm, png, ppm, raw, to_path};
pub use movie::{MOVIE_ENDINGS, Movie, MovieFormat, numbered_path};
#[doc(hidden)]
pub use read::{read_frame, read_picture};
pub use read_file::read_input;
pub use read_file::{open_regular, read_regular};
pub(crate) use rgba::rgba8;
#[cfg(unix)]
pub(crate) use temporary::{hold, temporary_name};
pub use temporary::{remove_leftovers_beside, remove_leftovers_in};

use fbptr_core::error::Code;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Returns the folder of a file to be written, if it does not exist.
#[doc(hidden)]
pub fn missing_folder(path: &Path) -> Option<&Path> {
    path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir())
}

/// Reason why a picture was not written.
#[derive(Clone, Debug, PartialEq)]
pub enum SaveError {
    /// The extension of the file name stands for no format.
    UnknownEnding {
        /// Path as given.
        path: PathBuf,
        /// Valid extensions.
        expected: &'static str,
    },
    /// The movie format does not support this frame rate.
    Rate {
        /// Path as given.
        path: PathBuf,
        /// Lowest rate, in frames per second.
        least: f64,
        /// Highest rate, in frames per second.
        most: f64,
        /// Requested rate, in frames per second.
        found: f64,
    },
    /// The operating system reported an error.
    Io {
        /// The file, or `-` for a writer without a name.
        path: PathBuf,
        /// Kind of the error.
        kind: io::ErrorKind,
        /// Message of the operating system.
        reason: String,
    },
}

impl fmt::Display for SaveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SaveError::UnknownEnding { path, expected } => {
                write!(f, "{}: expected a name that ends in {expected}", path.display())
            }
            SaveError::Rate { path, least, most, found } => {
                let path = path.display();
                write!(f, "{path}: expected {least} to {most} frames a second, found {found}")
            }
            SaveError::Io { path, reason, .. } => write!(f, "{}: {reason}", path.display()),
        }
    }
}

impl std::error::Error for SaveError {}

impl SaveError {
    fn io(path: &Path, error: &io::Error) -> Self {
        SaveError::Io { path: path.to_owned(), kind: error.kind(), reason: error.to_string() }
    }

    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            SaveError::UnknownEnding { .. } => Code::Args,
            SaveError::Rate { .. } => Code::Range,
            SaveError::Io { kind: io::ErrorKind::NotFound, .. } => Code::NoEnt,
            SaveError::Io { kind: io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded, .. } => {
                Code::Quota
            }
            SaveError::Io { .. } => Code::Perm,
        }
    }
}

//! PIXELS OUT to files: snapshots (png, ppm, raw), movies (GIF, APNG, y4m, numbered PNGs), depth as PFM, and the comparison
//! of snapshots in tests.
//!
//! In: a [`VideoMemory`](crate::memory::VideoMemory) or a [`DepthMemory`](crate::memory::DepthMemory), row 0 at the top.
//! Out: bytes to any writer, or a file that is there whole or not at all. The same picture gives the same file.

mod atomic;
mod formats;
pub mod golden;
mod movie;
mod temporary;

pub use atomic::atomically;
pub use formats::{SnapshotFormat, check_depth_path, crc32, depth_to_path, pfm, png, ppm, raw, to_path};
pub use movie::{MOVIE_ENDINGS, Movie, MovieFormat, numbered_path};
#[cfg(unix)]
pub(crate) use temporary::{hold, temporary_name};
pub use temporary::{remove_leftovers_beside, remove_leftovers_in};

use crate::error::Code;
use std::io;
use std::path::{Path, PathBuf};

/// Why a picture was not written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SaveError {
    /// The file name's ending names no format.
    #[error("{}: expected a name that ends in {expected}", .path.display())]
    UnknownEnding {
        /// The name.
        path: PathBuf,
        /// The endings there are.
        expected: &'static str,
    },
    /// So many frames a second make no movie of this format.
    #[error("{}: expected {least} to {most} frames a second, found {found}", .path.display())]
    Rate {
        /// The name.
        path: PathBuf,
        /// The least there can be.
        least: f64,
        /// The most.
        most: f64,
        /// What was asked for.
        found: f64,
    },
    /// The system refused.
    #[error("{}: {reason}", .path.display())]
    Io {
        /// The file, or `-` for a writer without a name.
        path: PathBuf,
        /// What kind of refusal.
        kind: io::ErrorKind,
        /// The system's words.
        reason: String,
    },
}

impl SaveError {
    fn io(path: &Path, error: &io::Error) -> Self {
        SaveError::Io { path: path.to_owned(), kind: error.kind(), reason: error.to_string() }
    }

    /// The protocol's code for this error.
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

//! Files in: OBJ, MTL, X3D and pictures become scene data. Bad files are refused with file, line and reason.
//!
//! In: the bytes of a file, its name for messages, and a function that finds the files it refers to. Out: scene data
//! in object space, or a [`LoadError`]; what could be skipped is a [`LoadWarning`]. No parser opens a file: the
//! caller reads, and decides which names may be read; [`Folder`] is how it keeps strangers inside a folder.

mod error;
mod folder;

pub use folder::{Folder, FolderError};
pub use error::{LoadError, LoadErrorKind, LoadWarning, Place};

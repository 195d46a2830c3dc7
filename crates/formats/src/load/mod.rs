//! File loading: OBJ, MTL, STL, PLY, glTF, X3D and pictures to scene data.
//!
//! In: the bytes of a file, its name for messages, and a function that returns the files it refers
//! to. Out: scene data in object space, or a [`LoadError`] with file, line and reason; a
//! [`LoadWarning`] for each part that was skipped. No parser opens a file: the caller reads it, and
//! decides which names may be read; [`SandboxDir`] restricts untrusted names to a folder.

mod context;
mod defects;
mod error;
pub mod gltf;
mod gzip;
mod memory;
mod mesh;
pub mod obj;
mod physical;
pub mod ply;
mod png_rows;
mod polled;
mod sandbox_dir;
mod side_files;
mod smooth;
pub mod stl;
pub mod texture;
mod url;
pub mod x3d;

pub use context::{LoadContext, path_inside};
pub use error::{FilePosition, LoadError, LoadErrorKind, LoadWarning};
pub use memory::LoadMemory;
pub use mesh::{LoadedMesh, MeshFormat, Smoothing};
pub use sandbox_dir::{QuotaDir, SandboxDir, SandboxError};

/// Runs a third-party decoder and returns the message of a panic in it as an error.
///
/// A last resort: our own checks come first and refuse every input that is known to make a decoder
/// panic.
fn never_panicking<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode)).map_err(|panic| {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        format!("its decoder gave up ({})", text.unwrap_or("without a word"))
    })
}

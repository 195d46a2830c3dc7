//! Files in: OBJ, MTL, X3D and pictures become scene data. Bad files are refused with file, line and reason.
//!
//! In: the bytes of a file, its name for messages, and a function that finds the files it refers
//! to. Out: scene data in object space, or a [`LoadError`]; what could be skipped is a
//! [`LoadWarning`]. No parser opens a file: the caller reads, and decides which names may be read;
//! [`SandboxDir`] is how it keeps strangers inside a folder.

mod context;
mod error;
mod gzip;
mod memory;
pub mod obj;
mod polled;
mod sandbox_dir;
pub mod texture;
pub mod x3d;

pub use context::{LoadContext, path_inside};
pub use error::{FilePosition, LoadError, LoadErrorKind, LoadWarning};
pub use memory::LoadMemory;
pub use sandbox_dir::{QuotaDir, SandboxDir, SandboxError};

/// Runs a decoder that is not ours; a panic in it becomes the reason of a refusal.
///
/// The last net: our own checks come first, so that this one catches nothing we know of.
fn never_panicking<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode)).map_err(|panic| {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        format!("its decoder gave up ({})", text.unwrap_or("without a word"))
    })
}

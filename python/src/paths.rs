//! Paths of files as Python programs give them.

use pyo3::prelude::*;
use std::ops::Deref;
use std::path::{Path, PathBuf};

/// A path: text, bytes, or an object with `__fspath__`. A path that the file system cannot have, as
/// one with half of a surrogate pair, raises the exception that `open` raises for it.
pub struct FilePath(PathBuf);

impl Deref for FilePath {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl<'py> FromPyObject<'py> for FilePath {
    fn extract_bound(item: &Bound<'py, PyAny>) -> PyResult<Self> {
        let os = item.py().import("os")?;
        #[cfg(unix)]
        {
            use std::os::unix::ffi::OsStringExt;
            let bytes: Vec<u8> = os.call_method1("fsencode", (item,))?.extract()?;
            Ok(FilePath(std::ffi::OsString::from_vec(bytes).into()))
        }
        #[cfg(not(unix))]
        {
            let text: String = os.call_method1("fsdecode", (item,))?.extract()?;
            Ok(FilePath(text.into()))
        }
    }
}

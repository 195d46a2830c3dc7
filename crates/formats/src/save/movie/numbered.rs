//! Numbered PNG files, one per frame.

use super::FrameWriter;
use crate::save::{png, replace};
use fbptr_core::memory::VideoMemory;
use std::io;
use std::path::{Path, PathBuf};

/// Writer of PNG files with numbers before their extension, each written atomically.
pub(super) struct Numbered {
    path: PathBuf,
    next: u64,
}

impl Numbered {
    pub fn new(path: PathBuf) -> Self {
        Numbered { path, next: 0 }
    }
}

impl FrameWriter for Numbered {
    fn frame(&mut self, memory: &VideoMemory) -> io::Result<()> {
        let path = numbered_path(&self.path, self.next);
        replace(&path, |out| png(memory, out)).map_err(io::Error::other)?;
        self.next += 1;
        Ok(())
    }
}

/// Returns the file name of picture `number` of a series: `name-0007.png`.
pub fn numbered_path(path: &Path, number: u64) -> PathBuf {
    let mut name = path.file_stem().map(|s| s.to_os_string()).unwrap_or_default();
    name.push(format!("-{number:04}"));
    if let Some(ending) = path.extension() {
        name.push(".");
        name.push(ending);
    }
    path.with_file_name(name)
}

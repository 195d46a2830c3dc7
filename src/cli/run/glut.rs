//! Programs that are linked with GLUT: which libraries they ask for, and a folder in which the
//! loader finds these.
//!
//! The folder has a symbolic link for each name to the preload library, which is loaded already: the
//! loader knows it by its inode, and there is one of it. It is removed by the starter, or by `fbptr`
//! if that is gone.

use crate::fbdev::elf;
use std::fs;
use std::fs::File;
use std::io;
use std::os::unix::fs::{FileExt, symlink};
use std::path::{Path, PathBuf};

/// Beginnings of the names of libraries that the preload library stands for.
const STEMS: [&str; 5] = ["libglut.so", "libfreeglut.so", "libGL.so", "libGLU.so", "libOpenGL.so"];
/// Names that libraries of the program may ask for.
const USUAL: [&str; 5] = ["libglut.so.3", "libglut.so.3.12", "libGL.so.1", "libGLU.so.1", "libOpenGL.so.0"];

/// Returns the names by which a program asks for GLUT and OpenGL; none if it is not linked with
/// GLUT.
pub fn names(program: &Path) -> Vec<String> {
    let Ok(file) = File::open(program) else { return Vec::new() };
    let read = |at: u64, bytes: &mut [u8]| file.read_exact_at(bytes, at).is_ok();
    let mut needed = Vec::new();
    elf::each_needed(read, |name| needed.push(String::from_utf8_lossy(name).into_owned()));
    let is_glut = |name: &String| STEMS[..2].iter().any(|stem| name.starts_with(stem));
    if !needed.iter().any(is_glut) {
        return Vec::new();
    }
    let mut names: Vec<String> =
        needed.into_iter().filter(|name| STEMS.iter().any(|stem| name.starts_with(stem))).collect();
    names.extend(usual());
    names
}

/// Returns the names by which most programs ask for them.
pub fn usual() -> impl Iterator<Item = String> {
    USUAL.into_iter().map(str::to_owned)
}

/// Returns the path of the folder of links of a process.
fn folder_of(pid: u32) -> PathBuf {
    let base = std::env::var_os("XDG_RUNTIME_DIR").map_or_else(std::env::temp_dir, PathBuf::from);
    let base = if base.is_dir() { base } else { std::env::temp_dir() };
    base.join(format!("fbptr-run-{pid}"))
}

/// Removes the folder of links of a process that was ended by force.
pub fn remove_left_by(pid: u32) {
    remove(&folder_of(pid));
}

/// A folder of links, which is removed at the end.
#[derive(Debug)]
pub struct Libraries {
    path: PathBuf,
}

impl Libraries {
    /// Makes the folder.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn new(names: &[String], library: &str) -> io::Result<Libraries> {
        let path = folder_of(std::process::id());
        // A folder of this name is one that an earlier run has left.
        remove(&path);
        fs::create_dir(&path)?;
        let libraries = Libraries { path };
        for name in names {
            match symlink(library, libraries.path.join(name)) {
                Err(e) if e.kind() != io::ErrorKind::AlreadyExists => return Err(e),
                _ => {}
            }
        }
        Ok(libraries)
    }

    /// Returns the folder's path.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Libraries {
    fn drop(&mut self) {
        remove(&self.path);
    }
}

/// Removes a folder of links, and nothing else.
pub fn remove(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_type().is_ok_and(|kind| kind.is_symlink()) {
            // What cannot be removed is left.
            let _ = fs::remove_file(entry.path());
        }
    }
    let _ = fs::remove_dir(folder);
}

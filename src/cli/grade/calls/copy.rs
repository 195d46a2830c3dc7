//! A copy of a program's folder, so that nothing of it is changed.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders of folders, files and bytes that are copied at most.
const DEPTH: u32 = 8;
const FILES: usize = 20_000;
const BYTES: u64 = 512 << 20;

/// Copies a folder's files but compiled ones, and returns the sources.
///
/// # Errors
/// If a file is not read or written, or if there are too many.
pub fn copy_folder(from: &Path, to: &Path) -> Result<Vec<PathBuf>, String> {
    let mut sources = Vec::new();
    copy_at(from, to, DEPTH, &mut (FILES, BYTES), &mut sources)?;
    Ok(sources)
}

fn copy_at(
    from: &Path,
    to: &Path,
    depth: u32,
    left: &mut (usize, u64),
    sources: &mut Vec<PathBuf>,
) -> Result<(), String> {
    let failed = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    fs::create_dir_all(to).map_err(|e| failed(to, e))?;
    let entries = fs::read_dir(from).map_err(|e| failed(from, e))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let Some(name) = path.file_name() else { continue };
        let Ok(meta) = path.symlink_metadata() else { continue };
        let target = to.join(name);
        if name.as_encoded_bytes().starts_with(b".") {
            continue;
        }
        if meta.is_dir() && depth > 0 {
            copy_at(&path, &target, depth - 1, left, sources)?;
        }
        let ending = path.extension().and_then(OsStr::to_str).unwrap_or("").to_ascii_lowercase();
        // An object that is newer than its source would not be compiled.
        if !meta.is_file() || matches!(ending.as_str(), "o" | "a" | "obj" | "so") || is_program(&path) {
            continue;
        }
        if left.0 == 0 || left.1 < meta.len() {
            return Err(format!("{}: --calls: the folder is too large", from.display()));
        }
        *left = (left.0 - 1, left.1 - meta.len());
        fs::write(&target, fs::read(&path).map_err(|e| failed(&path, e))?).map_err(|e| failed(&target, e))?;
        let is_small = meta.len() < 1 << 20;
        if is_small && matches!(ending.as_str(), "c" | "cpp" | "cc" | "cxx" | "h" | "hpp") {
            sources.push(target);
        }
    }
    Ok(())
}

/// Returns whether a file is a program that was compiled.
fn is_program(path: &Path) -> bool {
    use std::io::Read;
    let mut first = [0; 4];
    fs::File::open(path).and_then(|mut file| file.read_exact(&mut first)).is_ok() && first == *b"\x7fELF"
}

/// Returns whether a source, by its path in the program's folder, is not of a library that travels with
/// the program.
pub fn is_own(path: &Path) -> bool {
    let folders = path.parent().into_iter().flat_map(Path::components);
    let mut names = folders.map(|part| part.as_os_str().to_string_lossy().to_ascii_lowercase());
    !names.any(|name| name == "glm" || name.starts_with("glm-") || name.starts_with("eigen"))
}

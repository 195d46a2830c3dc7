//! What a load gets from its caller beside the file's bytes.

use super::LoadMemory;

/// What a file that is loaded may refer to, and what it may take.
pub struct LoadContext<'a> {
    /// The file's folder inside the root that `opener` reads from, with `/` at its end; empty for
    /// the root itself. `..` in names may climb to the root and no further.
    pub folder: &'a str,
    /// Finds a file by its name inside the root (`/` between folders; never absolute, never with
    /// `..`); `None` where there is no such file, or where it may not be read.
    pub opener: &'a mut dyn FnMut(&str) -> Option<Vec<u8>>,
    /// Asked before memory is taken.
    pub memory: &'a mut LoadMemory,
}

/// `folder` (with `/` at its end unless empty) and `name` joined, with `.` and `..` worked out;
/// `None` when that is no name inside the root.
pub fn path_inside(folder: &str, name: &str) -> Option<String> {
    if name.is_empty() || name.starts_with(['/', '\\']) || name.contains('\0') {
        return None;
    }
    let mut parts: Vec<&str> = folder.split('/').filter(|p| !p.is_empty()).collect();
    for part in name.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            part => parts.push(part),
        }
    }
    let is_folder = name.ends_with(['/', '\\']) || parts.is_empty();
    (!is_folder).then(|| parts.join("/"))
}

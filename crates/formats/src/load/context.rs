//! Context of a load: everything a parser gets from its caller except the file's bytes.

use super::LoadMemory;

/// Access to other files, and memory limits, of one load.
pub struct LoadContext<'a> {
    /// Folder of the file, relative to the root that `opener` reads from, with a final `/`; empty
    /// for the root itself. `..` in names may climb to the root and no further.
    pub folder: &'a str,
    /// Function that returns the bytes of a file by its name relative to the root (`/` between
    /// folders; never absolute, never with `..`); `None` if there is no such file, or it may not be
    /// read.
    pub opener: &'a mut dyn FnMut(&str) -> Option<Vec<u8>>,
    /// Limits; memory is reserved here before it is allocated.
    pub memory: &'a mut LoadMemory,
}

/// Joins `folder` (with a final `/` unless empty) and `name`, and resolves `.` and `..`. Returns
/// `None` if the result is not the name of a file inside the root.
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

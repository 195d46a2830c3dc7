//! Files that a mesh refers to by name: MTL files and textures.
//!
//! In: a name as an exporter wrote it, and the function that reads files beside the mesh. Out: the
//! file's bytes, and a note if it was not found under this very name. A `\` parts folders as `/` does.
//! An absolute path, of a drive or of the root, is one of another machine: its ends are tried beside
//! the mesh, the longest first.

use super::obj::SideFiles;
use super::url::ends_of_absolute;
use super::{LoadError, LoadMemory, texture};
use fbptr_core::error::Code;
use fbptr_core::scene::Texture;

/// A file beside a mesh.
pub(super) struct SideFile {
    pub(super) bytes: Vec<u8>,
    /// Its name, with `/` between folders.
    pub(super) name: String,
    /// The way it was found, for a warning.
    pub(super) note: Option<String>,
}

/// Reads the file that `name` means.
pub(super) fn find(side_files: &mut SideFiles<'_>, name: &str) -> Option<SideFile> {
    if let Some(bytes) = side_files(name) {
        return Some(SideFile { bytes, name: name.to_owned(), note: None });
    }
    if name.contains('\\')
        && let plain = name.replace('\\', "/")
        && let Some(bytes) = side_files(&plain)
    {
        return Some(SideFile { bytes, name: plain, note: None });
    }
    ends_of_absolute(name).into_iter().find_map(|end| {
        let bytes = side_files(&end)?;
        Some(SideFile { bytes, note: Some(elsewhere(name, &end)), name: end })
    })
}

/// Returns the note that a path of another machine was found here.
pub(super) fn elsewhere(name: &str, found: &str) -> String {
    format!(
        "the path {:?} is of another machine: {found:?} is read",
        name.chars().take(80).collect::<String>()
    )
}

/// A texture, or the reason why there is none; and what was done to find it.
pub(super) struct Picture {
    pub(super) texture: Result<Texture, String>,
    pub(super) note: Option<String>,
}

/// Reads the first picture that one of these names means; `folder` is that of the mesh, for
/// messages.
///
/// # Errors
/// If `memory` has no room or is cancelled.
pub(super) fn picture(
    names: &[String],
    side_files: &mut SideFiles<'_>,
    folder: &str,
    memory: &mut LoadMemory,
) -> Result<Picture, LoadError> {
    let Some(file) = names.iter().find_map(|name| find(side_files, name)) else {
        return Ok(Picture { texture: Err("cannot be found".into()), note: None });
    };
    let shown = format!("{folder}{}", file.name);
    let texture = match texture::decode_within(&file.bytes, &shown, memory) {
        Ok(texture) => Ok(texture),
        Err(error) if error.code() == Code::Quota => return Err(error),
        Err(error) => Err(format!("cannot be read ({})", error.kind)),
    };
    Ok(Picture { texture, note: file.note })
}

/// Returns the folders in front of a file's name, with the last separator.
pub(super) fn folder_of(name: &str) -> &str {
    name.rfind(['/', '\\']).map_or("", |end| &name[..=end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_of_another_machine_is_looked_for_by_its_ends() {
        let found = |name: &str, there: &str| {
            let mut asked = Vec::new();
            let file = find(
                &mut |name| {
                    asked.push(name.to_owned());
                    (name == there).then(|| b"x".to_vec())
                },
                name,
            );
            (file.map(|f| (f.name, f.note.is_some())), asked)
        };
        for (name, there, is_noted) in [
            ("a b.png", "a b.png", false),
            ("t\\a.png", "t/a.png", false),
            ("C:\\work\\t\\a.png", "t/a.png", true),
            ("c:/scans/a.png", "a.png", true),
            ("/home/me/t/a.png", "t/a.png", true),
            ("\\\\server\\share\\a.png", "a.png", true),
            ("file:///C:/scans/a%20b.png", "a b.png", true),
        ] {
            assert_eq!(found(name, there).0, Some((there.to_owned(), is_noted)), "{name}");
        }
        // One that leads out of the folder is none of them, and a plain name has no other ends.
        for name in ["../a.png", "t/a.png", "..\\t\\a.png"] {
            assert_eq!(found(name, "a.png").0, None, "{name}");
        }
        assert!(found("C:\\..\\..\\a.png", "").1.iter().skip(2).all(|asked| !asked.contains("..")));
    }
}

//! The MTL files that an OBJ file names.
//!
//! In: the names, as often as the file repeats them. Out: the materials of all of them. A file is
//! read once, whatever name leads to it, and its text is let go before the next one is read: the
//! costs are those of the files, not of their mentions.

use super::mtl::{self, FileMaterial};
use super::{SideFiles, cost, decoded};
use crate::load::side_files::{SideFile, find, folder_of};
use crate::load::{FilePosition, LoadError, LoadMemory, LoadWarning};
use fbptr_core::memory::Reservation;
use std::collections::{HashMap, HashSet};

/// A material, and the folder of its MTL file as named by `mtllib`.
pub(super) struct Found {
    pub(super) material: FileMaterial,
    pub(super) folder: String,
}

/// The materials of all MTL files, with the memory that is reserved for them.
#[derive(Default)]
pub(super) struct Libraries {
    /// Materials by name; of two with the same name the first counts.
    pub(super) materials: HashMap<String, Found>,
    /// Names that were looked for, and the files that were read.
    asked: HashSet<String>,
    read: HashSet<String>,
    held: Vec<Reservation>,
}

/// Reads all MTL files that `mtllib` names, in the order of their first mention.
pub(super) fn read_libraries(
    libraries: &[(String, u32)],
    side_files: &mut SideFiles<'_>,
    file_name: &str,
    warnings: &mut Vec<LoadWarning>,
    memory: &LoadMemory,
) -> Result<Libraries, LoadError> {
    let mut all = Libraries::default();
    for (names, line) in libraries {
        if !all.asked.insert(names.clone()) {
            continue;
        }
        let place = FilePosition::line(file_name, *line);
        // Either one name that contains blanks, or several names.
        if let Some(file) = find(side_files, names) {
            all.add(file, &place, warnings, memory)?;
            continue;
        }
        for name in names.split_whitespace() {
            // One name alone has been looked for already.
            let is_new = name != names && all.asked.insert(name.to_owned());
            match if is_new { find(side_files, name) } else { None } {
                Some(file) => all.add(file, &place, warnings, memory)?,
                None if is_new || name == names => {
                    let message = format!("material file {name:?} cannot be found: it is left out");
                    warnings.push(LoadWarning { place: place.clone(), message });
                }
                None => {}
            }
        }
    }
    Ok(all)
}

impl Libraries {
    /// Adds the materials of a file, unless it was read before under another name.
    fn add(
        &mut self,
        file: SideFile,
        place: &FilePosition,
        warnings: &mut Vec<LoadWarning>,
        memory: &LoadMemory,
    ) -> Result<(), LoadError> {
        let SideFile { bytes, name, note } = file;
        warnings.extend(note.map(|message| LoadWarning { place: place.clone(), message }));
        if !self.read.insert(plain(&name)) {
            return Ok(());
        }
        let shown = format!("{}{name}", folder_of(&place.file));
        let refused = |kind| LoadError::new(FilePosition::file(&*shown), kind);
        self.held.push(memory.work(cost::mtl_bytes(&bytes)).map_err(refused)?);
        let (text, _decoded) = decoded(&bytes, memory).map_err(refused)?;
        let (materials, mut its_warnings) = mtl::parse(&text, &shown, memory)?;
        warnings.append(&mut its_warnings);
        for material in materials {
            let found = Found { material, folder: folder_of(&name).to_owned() };
            self.materials.entry(found.material.material.name.clone()).or_insert(found);
        }
        Ok(())
    }
}

/// Returns a path without the folders that lead nowhere, and with `/` between the others.
fn plain(name: &str) -> String {
    let folders: Vec<&str> = name.split(['/', '\\']).filter(|part| !matches!(*part, "" | ".")).collect();
    folders.join("/")
}

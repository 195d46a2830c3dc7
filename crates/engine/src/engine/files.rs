//! Files that commands read: those of the load folder or, in a replay, those that the recording
//! contains.
//!
//! In: names that a command or a file gives. Out: contents, within the limits of one file and of
//! all files together. The files are kept for the observers, if any of them wants contents.

use super::Engine;
use crate::Session;
use crate::read_files::{FileHasher, FileSet, ReadFile};
use crate::session::FileAccess;
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::{MemoryUse, Reservation};
use fbptr_formats::load::{FilePosition, LoadWarning, SandboxDir, SandboxError};
use std::sync::Arc;

/// Source of files.
enum FileSource {
    LoadFolder(Option<SandboxDir>),
    Recording(Arc<FileSet>),
}

/// Reads the files of one command.
pub(crate) struct FileReader {
    source: FileSource,
    /// Limits in bytes of one file, and of all files that other files name; and the latter's bytes
    /// so far.
    max_file_bytes: u64,
    max_side_bytes: u64,
    side_bytes: u64,
    /// Warnings about names in another case of letters.
    other_cases: Vec<LoadWarning>,
    /// Files read so far, and the hasher, if they are kept.
    read: Vec<ReadFile>,
    hasher: Option<FileHasher>,
    /// The memory budget's reservation for all of them, as long as the reader exists.
    held: Reservation,
}

impl Engine {
    /// Creates the reader for the next command of `session` that reads files.
    pub(super) fn file_reader(&self, session: &mut Session) -> FileReader {
        let source = match &mut session.file_access {
            FileAccess::LoadFolder => FileSource::LoadFolder(self.resources.load_dir.clone()),
            FileAccess::Recording(files) => FileSource::Recording(std::mem::take(files)),
        };
        FileReader {
            source,
            max_file_bytes: self.quotas.limits.payload_bytes,
            max_side_bytes: self.quotas.limits.resource_bytes,
            side_bytes: 0,
            other_cases: Vec::new(),
            read: Vec::new(),
            hasher: self.wants_contents().then(|| self.resources.file_hasher.clone()),
            held: self.quotas.budget.empty(MemoryUse::Payloads),
        }
    }
}

impl FileReader {
    /// Refuses a command that names a file if there is no source of files.
    ///
    /// # Errors
    /// `EPERM` without a folder.
    pub fn check_source(&self, path: &str) -> Result<(), Fault> {
        if let FileSource::LoadFolder(None) = self.source {
            let message = "files are loaded from the folder of --load-dir, and none is given";
            return Err(Fault::new(Code::Perm, message).got(path));
        }
        Ok(())
    }

    /// Returns whether reading may block on a disk.
    pub fn may_wait(&self) -> bool {
        matches!(self.source, FileSource::LoadFolder(Some(_)))
    }

    /// Reads the file that a command names.
    ///
    /// # Errors
    /// `EPERM` without a folder; otherwise see [`SandboxError`].
    pub fn read(&mut self, path: &str) -> Result<Vec<u8>, Fault> {
        self.check_source(path)?;
        self.read_up_to(path, self.max_file_bytes, path)
    }

    /// Reads a file that another file names; `beside` is the folder of that file. Where there is none
    /// of this name, the one in another case of letters is read, with a warning. Returns `None` if it
    /// cannot be read.
    pub fn read_beside(&mut self, beside: &str, name: &str) -> Option<Vec<u8>> {
        let path = match beside {
            "" => name.to_owned(),
            beside => format!("{beside}/{name}"),
        };
        let limit = self.max_file_bytes.min(self.max_side_bytes.saturating_sub(self.side_bytes));
        let bytes = self.read_up_to(&path, limit, &path).ok().or_else(|| {
            let FileSource::LoadFolder(Some(folder)) = &self.source else { return None };
            let other = folder.other_case(&path)?;
            let message = format!("there is no {path:?}: {other:?} is read");
            let bytes = self.read_up_to(&other, limit, &path).ok()?;
            self.other_cases.push(LoadWarning { place: FilePosition::file(name), message });
            Some(bytes)
        })?;
        self.side_bytes += bytes.len() as u64;
        Some(bytes)
    }

    /// Takes the warnings about names in another case of letters.
    pub fn take_warnings(&mut self) -> Vec<LoadWarning> {
        std::mem::take(&mut self.other_cases)
    }

    /// Reads a file of at most `limit` bytes, after reserving memory for it: twice its size if it
    /// is kept, under the name `kept_as`.
    fn read_up_to(&mut self, path: &str, limit: u64, kept_as: &str) -> Result<Vec<u8>, Fault> {
        let copies = if self.hasher.is_some() { 2 } else { 1 };
        let mut room = self.held.budget().reserve_up_to(MemoryUse::Payloads, limit.saturating_mul(copies));
        let most = limit.min(room.bytes() / copies);
        let bytes = match self.read_within(path, most, kept_as) {
            Ok(bytes) => bytes,
            // The file is within its limit, but there is not enough memory for it.
            Err(SandboxError::TooLarge { found, .. }) if found <= limit => {
                room.shrink_to(0);
                room.try_grow(found.saturating_mul(copies))?;
                self.read_within(path, found, kept_as)?
            }
            Err(error) => return Err(error.into()),
        };
        room.shrink_to(0);
        self.held.set(self.held.bytes() + bytes.len() as u64 * copies);
        Ok(bytes)
    }

    fn read_within(&mut self, path: &str, limit: u64, kept_as: &str) -> Result<Vec<u8>, SandboxError> {
        // A file that changes meanwhile stays the same for the whole command, and for its replay.
        if let Some(file) = self.read.iter().find(|file| file.path == kept_as) {
            return within(path, &file.bytes, limit);
        }
        let missing = || SandboxError::Missing { name: path.into() };
        let bytes = match &self.source {
            FileSource::LoadFolder(folder) => folder.as_ref().ok_or_else(missing)?.read(path, limit)?,
            FileSource::Recording(files) => within(path, files.get(path).ok_or_else(missing)?, limit)?,
        };
        if let Some(hasher) = &self.hasher {
            let fingerprint = hasher.fingerprint(&bytes);
            self.read.push(ReadFile {
                path: kept_as.to_owned(),
                bytes: bytes.as_slice().into(),
                fingerprint,
            });
        }
        Ok(bytes)
    }

    /// Returns the files that were kept.
    pub fn into_read(self) -> Vec<ReadFile> {
        self.read
    }
}

fn within(path: &str, bytes: &[u8], limit: u64) -> Result<Vec<u8>, SandboxError> {
    match bytes.len() as u64 <= limit {
        true => Ok(bytes.to_vec()),
        false => Err(SandboxError::TooLarge { name: path.into(), found: bytes.len() as u64, limit }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Audience;

    #[test]
    fn a_side_file_in_another_case_is_read_with_a_warning_and_a_named_one_is_not() {
        let folder = std::env::temp_dir().join(format!("fbptr-cases-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("Maps")).unwrap();
        std::fs::write(folder.join("Maps/Wood.PNG"), b"wood").unwrap();
        let mut engine = Engine::new(8, 6).unwrap();
        engine.set_load_dir(SandboxDir::open(&folder).unwrap());
        let mut files = engine.file_reader(&mut Session::new(1, Audience::Connection));
        assert_eq!(files.read_beside("", "maps/wood.png").as_deref(), Some(&b"wood"[..]));
        let warnings = files.take_warnings();
        assert!(warnings.len() == 1 && warnings[0].message.contains("Maps/Wood.PNG"), "{warnings:?}");
        assert!(files.read_beside("", "maps/stone.png").is_none() && files.take_warnings().is_empty());
        assert!(files.read("maps/wood.png").is_err(), "a command names its file exactly");
        std::fs::remove_dir_all(folder).unwrap();
    }
}

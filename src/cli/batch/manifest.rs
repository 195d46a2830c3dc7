//! The manifests of a batch: `frames-i-of-n.jsonl` of shard i, `frames-A-to-B.jsonl` of a range
//! without a shard, and `frames.jsonl`, the merged one; a record a line.
//!
//! Promise: one process writes a manifest, by the system's file lock. A line is appended after its
//! frame's file is in place, so a killed run leaves at most a frame without its line, or a torn
//! last line; both are drawn again. A failed append is undone.

use super::record::Record;
use crate::save;
use std::fmt;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Limits of the size of a manifest, and of a frame's file.
const MAX_MANIFEST_BYTES: u64 = 1 << 30;
pub const MAX_FRAME_BYTES: u64 = 4 << 30;

/// Name of the merged manifest.
pub const MERGED: &str = "frames.jsonl";

/// Reason why a manifest cannot be written.
#[derive(Debug)]
pub enum ManifestError {
    /// Another process writes it.
    Busy(PathBuf),
    /// The operating system reported an error.
    Io(PathBuf, io::Error),
}

impl fmt::Display for ManifestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ManifestError::Busy(path) => {
                write!(f, "{}: another process draws these frames", path.display())
            }
            ManifestError::Io(path, e) => write!(f, "{}: {e}", path.display()),
        }
    }
}

impl std::error::Error for ManifestError {}

/// A manifest that this process writes.
#[derive(Debug)]
pub struct Manifest {
    path: PathBuf,
    /// Holds the lock until it is closed.
    file: File,
    /// Length of its complete lines.
    length: u64,
}

impl Manifest {
    /// Opens or creates a manifest, locks it and removes a torn last line.
    pub fn open(path: PathBuf) -> Result<Manifest, ManifestError> {
        let io = |e: io::Error| ManifestError::Io(path.clone(), e);
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let mut file = save::open_regular(&path, &mut options).map_err(io)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Err(ManifestError::Busy(path)),
            // A file system without locks: two runs of one shard then draw the same frames twice.
            Err(TryLockError::Error(_)) | Ok(()) => {}
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(io)?;
        let length = bytes.iter().rposition(|&b| b == b'\n').map_or(0, |at| at + 1) as u64;
        if length < bytes.len() as u64 {
            file.set_len(length).map_err(io)?;
        }
        file.seek(SeekFrom::Start(length)).map_err(io)?;
        Ok(Manifest { path, file, length })
    }

    /// Appends a record. If that fails the manifest stays as it was.
    pub fn append(&mut self, record: &Record) -> Result<(), ManifestError> {
        let line = record.to_line();
        self.file.write_all(line.as_bytes()).map_err(|e| {
            // The write's error is reported; a torn line that stays is removed by the next run.
            let _ = self.file.set_len(self.length);
            let _ = self.file.seek(SeekFrom::Start(self.length));
            ManifestError::Io(self.path.clone(), e)
        })?;
        self.length += line.len() as u64;
        Ok(())
    }
}

/// The records of a folder, of all its manifests.
#[derive(Debug, Default)]
pub struct Records {
    /// The records: by manifest in the order of names, then by line.
    pub list: Vec<Record>,
    /// Number of manifests.
    pub manifests: usize,
    /// Places of lines that are no records, but for torn last ones.
    pub strange: Vec<String>,
    /// Entries of a manifest's name that are no regular files, in words.
    pub passed_over: Vec<String>,
}

impl Records {
    /// Reads all manifests of a folder; one that does not exist has none.
    pub fn read(folder: &Path) -> Result<Records, ManifestError> {
        let at = |path: &Path, e: io::Error| ManifestError::Io(path.to_owned(), e);
        let entries = match fs::read_dir(folder) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Records::default()),
            entries => entries.map_err(|e| at(folder, e))?,
        };
        let mut paths = Vec::new();
        for entry in entries {
            let entry = entry.map_err(|e| at(folder, e))?;
            if entry.file_name().to_str().is_some_and(is_manifest) {
                paths.push(entry.path());
            }
        }
        paths.sort_unstable();
        let mut records = Records::default();
        for path in paths {
            let bytes = match save::read_regular(&path, MAX_MANIFEST_BYTES) {
                Ok(bytes) => bytes,
                Err(e) if e.kind() == io::ErrorKind::InvalidInput => {
                    records.passed_over.push(format!("{}: {e}", path.display()));
                    continue;
                }
                Err(e) => return Err(at(&path, e)),
            };
            records.manifests += 1;
            let lines = bytes.split_inclusive(|&b| b == b'\n').enumerate();
            for (i, line) in lines.filter(|(_, line)| line.ends_with(b"\n")) {
                match std::str::from_utf8(line).ok().and_then(Record::from_line) {
                    Some(record) => records.list.push(record),
                    None => records.strange.push(format!("{}:{}", path.display(), i + 1)),
                }
            }
        }
        Ok(records)
    }
}

/// Returns whether a file of this name is a manifest.
fn is_manifest(name: &str) -> bool {
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let middle = name.strip_prefix("frames-").and_then(|rest| rest.strip_suffix(".jsonl"));
    let parts = middle.and_then(|m| m.split_once("-of-").or_else(|| m.split_once("-to-")));
    name == MERGED || parts.is_some_and(|(a, b)| is_number(a) && is_number(b))
}

/// Result of comparing a frame's files with their record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileState {
    /// All files are as they were written.
    Whole,
    /// A file does not exist.
    Absent,
    /// A file differs, in these words.
    Differs(String),
}

/// Compares the files of a record with it, and the pixels of its picture with the record's own CRC.
/// A PNG whose bytes differ but whose pixels do not, as after a recompression, is whole.
pub fn verify(folder: &Path, record: &Record) -> FileState {
    let mut is_picture = true;
    for file in &record.files {
        let path = folder.join(&file.name);
        let bytes = match save::read_regular(&path, MAX_FRAME_BYTES) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return FileState::Absent,
            Err(e) => return FileState::Differs(format!("{}: {e}", file.name)),
        };
        let crc = crc32fast::hash(&bytes);
        let is_same = (bytes.len() as u64, crc) == (file.bytes, file.crc);
        let pixels = if is_picture { pixels_crc(&path, &bytes, record) } else { None };
        if is_same && let Some(pixels) = pixels.filter(|pixels| *pixels != record.crc) {
            return FileState::Differs(format!(
                "{}: expected pixels with crc {:08x}, found {pixels:08x}",
                file.name, record.crc
            ));
        }
        let is_png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        if !(is_same || is_png && pixels == Some(record.crc)) {
            let (found, expected) = (bytes.len(), file.bytes);
            return FileState::Differs(format!(
                "{}: expected {expected} bytes with crc {:08x}, found {found} with {crc:08x}",
                file.name, file.crc
            ));
        }
        is_picture = false;
    }
    FileState::Whole
}

/// Returns the CRC of a picture's pixels; `None` if it cannot be read, or its format has lost their
/// alpha.
fn pixels_crc(path: &Path, bytes: &[u8], record: &Record) -> Option<u32> {
    if save::SnapshotFormat::of_path(path).ok()? == save::SnapshotFormat::Ppm {
        return None;
    }
    save::read_frame(path, bytes, record.size).ok().map(|memory| save::crc32(&memory))
}

#[cfg(test)]
mod tests {
    use super::super::record::FileRecord;
    use super::*;
    use crate::memory::VideoMemory;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("fbptr-manifest-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn record(frame: u32) -> Record {
        Record {
            frame,
            of: 9,
            crc: 1,
            files: vec![FileRecord {
                name: format!("a-{frame}.raw"),
                bytes: 3,
                crc: crc32fast::hash(b"abc"),
            }],
            size: [1, 1],
            fps: 25.0,
            seconds: 0.0,
            time: String::new(),
            host: String::new(),
            version: String::new(),
            recipe: 0,
        }
    }

    #[test]
    fn a_torn_last_line_is_removed_and_a_strange_one_is_named() {
        let folder = folder("torn");
        let path = folder.join("frames-0-of-2.jsonl");
        let mut manifest = Manifest::open(path.clone()).unwrap();
        manifest.append(&record(0)).unwrap();
        assert!(matches!(Manifest::open(path.clone()), Err(ManifestError::Busy(_))), "one writer");
        drop(manifest);
        let whole = fs::read(&path).unwrap();
        let mut torn = b"no record\n".to_vec();
        torn.extend_from_slice(&whole);
        torn.extend_from_slice(&whole[..whole.len() / 2]);
        fs::write(&path, &torn).unwrap();
        let read = |folder: &Path| Records::read(folder).unwrap();
        assert_eq!(read(&folder).list, [record(0)]);
        assert_eq!(read(&folder).strange, [format!("{}:1", path.display())]);
        let mut manifest = Manifest::open(path.clone()).unwrap();
        manifest.append(&record(2)).unwrap();
        assert_eq!(read(&folder).list, [record(0), record(2)]);
        fs::write(folder.join("frames-x-of-2.jsonl"), "of another program\n").unwrap();
        assert_eq!(read(&folder).manifests, 1);
        assert_eq!(read(&folder.join("nowhere")).manifests, 0);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn files_are_whole_absent_or_different() {
        let folder = folder("files");
        assert_eq!(verify(&folder, &record(3)), FileState::Absent);
        fs::write(folder.join("a-3.raw"), "abc").unwrap();
        assert_eq!(verify(&folder, &record(3)), FileState::Whole);
        fs::write(folder.join("a-3.raw"), "abd").unwrap();
        assert!(matches!(verify(&folder, &record(3)), FileState::Differs(_)));
        // A PNG of the same pixels in other bytes.
        let mut memory = VideoMemory::new(2, 1).unwrap();
        memory.put_pixel(1, 0, [1, 2, 3, 4]);
        let files = vec![FileRecord { name: "b.png".into(), bytes: 1, crc: 0 }];
        let png = Record { files, size: [2, 1], crc: crate::save::crc32(&memory), ..record(4) };
        crate::save::to_path(&memory, &folder.join("b.png")).unwrap();
        assert_eq!(verify(&folder, &png), FileState::Whole);
        assert!(matches!(verify(&folder, &Record { crc: 0, ..png }), FileState::Differs(_)));
        fs::remove_dir_all(&folder).unwrap();
    }
}

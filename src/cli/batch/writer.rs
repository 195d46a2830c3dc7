//! The frames of one process of a batch: which are missing, and the record of each that is drawn.
//!
//! Promise: a frame counts as drawn if a manifest of the folder has its record, of the same scene,
//! arguments and version, and its files are what the record says. A file appears whole, by a
//! temporary name, and before its record.

use super::manifest::{FileState, Manifest, Records, verify};
use super::record::{FileRecord, Record, host, iso_utc};
use super::shard::ShardArgs;
use crate::cli::scene_file::SceneError;
use crate::save::{self, SaveError};
use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

/// Description of a batch.
pub struct BatchPlan<'a> {
    /// Name of the pictures, before their numbers.
    pub out: &'a Path,
    /// Name of the depth files, if they are written.
    pub depth_out: Option<&'a Path>,
    /// Frames of this process.
    pub shard: ShardArgs,
    /// Number of frames of the animation.
    pub count: u32,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Frames a second.
    pub fps: f64,
    /// Checksum of the scene's files and of the arguments that change a frame.
    pub recipe: u32,
}

/// Writer of the records of one process.
pub struct BatchWriter {
    manifest: Manifest,
    /// Frames that are to be drawn, in order.
    missing: Vec<u32>,
    /// Number of frames that were there.
    there: usize,
    /// A record without what differs from frame to frame.
    template: Record,
    begun: Instant,
    written: usize,
}

impl BatchWriter {
    /// Creates the folder if it is not there, locks the manifest and finds the missing frames.
    pub fn open(plan: &BatchPlan) -> Result<BatchWriter, SceneError> {
        let refused = |e: super::manifest::ManifestError| SceneError::Refused(e.to_string());
        let folder = folder_of(plan.out);
        if plan.depth_out.is_some_and(|depth| folder_of(depth) != folder) {
            let message = "--depth-out: the files of a batch are in one folder";
            return Err(SceneError::NoFile(message.to_owned()));
        }
        std::fs::create_dir_all(&folder)
            .map_err(|e| SceneError::NoFile(format!("{}: {e}", folder.display())))?;
        save::remove_leftovers_in(&folder);
        let manifest = Manifest::open(folder.join(plan.shard.manifest_name(plan.count))).map_err(refused)?;
        let records = Records::read(&folder).map_err(refused)?;
        let template = Record {
            frame: 0,
            of: plan.count,
            crc: 0,
            files: Vec::new(),
            size: plan.size,
            fps: plan.fps,
            seconds: 0.0,
            time: String::new(),
            host: host(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            recipe: plan.recipe,
        };
        let there = frames_there(plan, &folder, &records, &template)?;
        let (there, missing): (Vec<u32>, Vec<u32>) =
            plan.shard.frames(plan.count).partition(|frame| there.contains(frame));
        let there = there.len();
        Ok(BatchWriter { manifest, missing, there, template, begun: Instant::now(), written: 0 })
    }

    /// Returns the frames that are to be drawn.
    pub fn missing(&self) -> Vec<u32> {
        self.missing.clone()
    }

    /// Returns the number of frames that were drawn before.
    pub fn there(&self) -> usize {
        self.there
    }

    /// Starts the clock of a frame.
    pub fn begin(&mut self) {
        self.begun = Instant::now();
    }

    /// Records a frame whose files are in place.
    pub fn record(&mut self, frame: u32, crc: u32, files: Vec<FileRecord>) -> Result<(), SceneError> {
        let record = Record {
            frame,
            crc,
            files,
            seconds: self.begun.elapsed().as_secs_f64(),
            time: iso_utc(SystemTime::now()),
            ..self.template.clone()
        };
        self.manifest.append(&record).map_err(|e| self.interrupted(e.to_string()))?;
        self.written += 1;
        Ok(())
    }

    /// Returns the error that ends a run, with what there is already.
    pub fn interrupted(&self, message: String) -> SceneError {
        let (there, all) = (self.there + self.written, self.there + self.missing.len());
        SceneError::Refused(format!("{message}; {there} of {all} frames are there, the same command goes on"))
    }
}

/// Returns the folder that a file is in.
fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Returns the frames of this process that are drawn already.
fn frames_there(
    plan: &BatchPlan,
    folder: &Path,
    records: &Records,
    template: &Record,
) -> Result<BTreeSet<u32>, SceneError> {
    let name = |path: &Path, frame: u32| {
        save::numbered_path(path, frame.into()).file_name().map(|n| n.to_string_lossy().into_owned())
    };
    if let Some(other) =
        records.list.iter().find(|r| name(plan.out, r.frame).as_ref() != Some(&r.files[0].name))
    {
        let other = &other.files[0].name;
        return Err(SceneError::NoFile(format!(
            "{}: expected no other batch, found the frame {other}: one batch a folder",
            folder.display()
        )));
    }
    let mine: BTreeSet<u32> = plan.shard.frames(plan.count).collect();
    let files = 1 + usize::from(plan.depth_out.is_some());
    let is_mine = |record: &&Record| {
        mine.contains(&record.frame)
            && record.identity() == template.identity()
            && record.files.len() == files
            && record.files.get(1).map(|file| &file.name)
                == plan.depth_out.and_then(|path| name(path, record.frame)).as_ref()
    };
    let mut there = BTreeSet::new();
    for record in records.list.iter().filter(is_mine) {
        if !there.contains(&record.frame) && verify(folder, record) == FileState::Whole {
            there.insert(record.frame);
        }
    }
    Ok(there)
}

/// Writes a file atomically, and returns its record. A name that is the user's own may be that of a
/// pipe or a device.
pub fn written_file(
    path: &Path,
    is_named: bool,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<FileRecord, SaveError> {
    let mut record = FileRecord { name: String::new(), bytes: 0, crc: 0 };
    let put = |out: &mut dyn Write| {
        let mut out = Counted { out, bytes: 0, crc: crc32fast::Hasher::new() };
        write(&mut out)?;
        (record.bytes, record.crc) = (out.bytes, out.crc.finalize());
        Ok(())
    };
    if is_named { save::atomically(path, put) } else { save::replace(path, put) }?;
    record.name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(record)
}

/// A writer that counts and checksums what passes.
struct Counted<'a> {
    out: &'a mut dyn Write,
    bytes: u64,
    crc: crc32fast::Hasher,
}

impl Write for Counted<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.bytes += count as u64;
        self.crc.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_file_is_recorded_with_its_length_and_crc() {
        let folder = std::env::temp_dir().join(format!("fbptr-written-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.raw");
        let record =
            written_file(&path, true, |out| out.write_all(b"123").and_then(|()| out.write_all(b"456789")));
        // The check value of CRC-32/ISO-HDLC.
        let expected = FileRecord { name: "a.raw".into(), bytes: 9, crc: 0xcbf4_3926 };
        assert_eq!(record.unwrap(), expected);
        let failed = written_file(&path, true, |out| {
            out.write_all(b"half")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"123456789", "a failed write leaves the old file");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "and no temporary one");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

//! `fbptr batch check`: every frame's files against the records of all manifests.

use super::manifest::{FileState, MERGED, Records, verify};
use super::record::Record;
use super::{ranges, ranges_text};
use crate::cli::progress::Progress;
use crate::cli::scene_file::SceneError;
use crate::cli::{Status, output, say_as_program};
use crate::save;
use clap::Args;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Verify the frames of a folder.
#[derive(Debug, Args)]
pub struct Check {
    /// The folder of the frames
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// If all is right, write one manifest of all frames in order, frames.jsonl
    #[arg(long)]
    merge: bool,
}

impl Check {
    /// Prints what there is and what is not. Returns the exit status.
    pub fn run(&self) -> Result<Status, SceneError> {
        let checked = Checked::read(&self.folder)?;
        output::print(checked.to_string());
        if !checked.is_right() {
            return Ok(Status::Failed);
        }
        if self.merge {
            let path = self.folder.join(MERGED);
            let lines: String = checked.whole.values().map(Record::to_line).collect();
            save::replace(&path, |out| out.write_all(lines.as_bytes()))
                .map_err(|e| SceneError::Refused(e.to_string()))?;
        }
        Ok(Status::Success)
    }
}

/// The frames of a folder, compared with their records.
pub struct Checked {
    /// Records of the frames whose files are as they were written, by number.
    pub whole: BTreeMap<u32, Record>,
    /// The newest record: it tells the number of frames, the scene, the arguments and the version.
    pub newest: Record,
    /// Frames without a record or without a file, as ranges: a batch may say that it has any number.
    missing: Vec<[u32; 2]>,
    /// Frames whose records are of another scene, other arguments or another version.
    foreign: Vec<u32>,
    /// Files that differ from their records, in words.
    differing: Vec<String>,
    /// Frames that were recorded with two different pictures, in words.
    disputed: Vec<String>,
}

impl Checked {
    /// Reads all manifests of a folder, and every file that they name.
    pub fn read(folder: &Path) -> Result<Checked, SceneError> {
        if !folder.is_dir() {
            return Err(SceneError::NoFile(format!("{}: there is no such folder", folder.display())));
        }
        let records = Records::read(folder).map_err(|e| SceneError::Refused(e.to_string()))?;
        let place = folder.display();
        for line in &records.strange {
            say_as_program(format_args!("{line}: expected the record of a frame: left out"));
        }
        for line in &records.passed_over {
            say_as_program(format_args!("{line}: left out"));
        }
        let newest = records.list.iter().max_by(|a, b| a.time.cmp(&b.time)).cloned();
        let Some(newest) = newest else {
            let expected = "expected the manifests of frames, as in frames-0-of-4.jsonl";
            return Err(SceneError::NoFile(format!(
                "{place}: {expected}, found {} without a record",
                records.manifests
            )));
        };
        let mut by_frame: BTreeMap<u32, Vec<&Record>> = BTreeMap::new();
        for record in records.list.iter().filter(|r| r.frame < newest.of) {
            by_frame.entry(record.frame).or_default().push(record);
        }
        let mut checked = Checked {
            whole: BTreeMap::new(),
            newest,
            missing: Vec::new(),
            foreign: Vec::new(),
            differing: Vec::new(),
            disputed: Vec::new(),
        };
        let mut progress = Progress::new("frames", checked.newest.of.into());
        let mut next = 0;
        for (&frame, records) in &by_frame {
            checked.miss(next, frame);
            checked.check(folder, frame, records);
            progress.advance(u64::from(frame - next) + 1);
            next = frame + 1;
        }
        checked.miss(next, checked.newest.of);
        progress.advance((checked.newest.of - next).into());
        Ok(checked)
    }

    /// Notes that the frames from `first` to before `end` are missing.
    fn miss(&mut self, first: u32, end: u32) {
        match self.missing.last_mut() {
            _ if first == end => {}
            Some([_, last]) if last.checked_add(1) == Some(first) => *last = end - 1,
            _ => self.missing.push([first, end - 1]),
        }
    }

    /// Compares one frame with its records.
    fn check(&mut self, folder: &Path, frame: u32, records: &[&Record]) {
        let identity = self.newest.identity();
        let own: Vec<&Record> = records.iter().copied().filter(|r| r.identity() == identity).collect();
        let Some((last, others)) = own.split_last() else {
            self.foreign.push(frame);
            return;
        };
        if let Some(other) = others.iter().find(|other| other.crc != last.crc) {
            self.disputed.push(format!(
                "{frame} ({:08x} on {}, {:08x} on {})",
                other.crc, other.host, last.crc, last.host
            ));
            return;
        }
        // Any record will do: a frame may have been drawn again after its file was lost.
        let mut state = FileState::Absent;
        for record in own.iter().rev() {
            state = verify(folder, record);
            if state == FileState::Whole {
                self.whole.insert(frame, (*record).clone());
                return;
            }
        }
        match state {
            FileState::Differs(words) => self.differing.push(format!("{frame} ({words})")),
            _ => self.miss(frame, frame + 1),
        }
    }

    /// Returns whether every frame is whole.
    pub fn is_right(&self) -> bool {
        self.whole.len() as u64 == u64::from(self.newest.of)
    }
}

impl std::fmt::Display for Checked {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Record { of, size: [width, height], version, .. } = &self.newest;
        let whole = self.whole.len();
        writeln!(f, "{whole} of {of} frames of {width}x{height} pixels are whole, of version {version}")?;
        let mut hosts: BTreeMap<&str, (usize, f64)> = BTreeMap::new();
        for record in self.whole.values() {
            let (frames, seconds) = hosts.entry(&record.host).or_default();
            *frames += 1;
            *seconds += record.seconds;
        }
        for (host, (frames, seconds)) in hosts {
            writeln!(f, "{host}: {frames} frames in {seconds:.1} s")?;
        }
        let lists = [
            ("missing", ranges_text(&self.missing)),
            ("of another scene, other arguments or another version", ranges(&self.foreign)),
            ("differing from their records", self.differing.join(", ")),
            ("drawn twice with different pixels", self.disputed.join(", ")),
        ];
        for (what, list) in lists.iter().filter(|(_, list)| !list.is_empty()) {
            writeln!(f, "{what}: {list}")?;
        }
        Ok(())
    }
}

//! `fbptr report`: speed against error, of a user's pictures or of every stage, or the hard cases, as
//! tables and as a page.

mod decisions;

use super::mesh_args::MeshArgs;
use super::picture_args::PictureArgs;
use super::render_args::RenderArgs;
use super::scene_file::SceneError;
use super::{Status, output, say_as_program};
use crate::measure::{Effort, Report, Section, hard, peers_of, run, write};
use crate::scene::MaxError;
use clap::Args;
use decisions::Asked;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Compare speed and error: of the settings for your own picture, or of every stage; as report.md, .json, .html and .svg
#[derive(Debug, Args)]
pub(super) struct ReportArgs {
    /// The folder to write into; without one the tables go to standard output
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Smaller subjects and shorter times: under a minute
    #[arg(long)]
    quick: bool,
    /// The hard cases instead: promise, measure, verdict, one row each
    #[arg(long)]
    hard: bool,
    /// Only this picture: each setting's time and error, and which to use. A scene or mesh, a built-in model, an
    /// N-dimensional scene, or a stream, of which it is the last frame; again for further files
    #[arg(long, value_name = "FILE", conflicts_with = "hard")]
    scene: Vec<PathBuf>,
    /// With --scene: an error budget to compare; again for more. The largest is what may be recommended [default: 1, 4 and 16;
    /// 4 may be recommended]
    #[arg(long, value_name = "E[,S]", requires = "scene", allow_negative_numbers = true)]
    max_error: Vec<MaxError>,
    /// With --scene: let a stream's LOAD read files from this folder
    #[arg(long, value_name = "DIR", requires = "scene")]
    load_dir: Option<PathBuf>,
    /// Also other programs on the workloads W1 to W5, from the peers.json that benches/peers/run.sh writes
    #[arg(long, value_name = "FILE", conflicts_with = "hard")]
    peers: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    meshes: MeshArgs,
    #[command(flatten)]
    drawing: RenderArgs,
}

impl ReportArgs {
    pub fn run(&self) -> Status {
        // Fails before minutes of measuring, not after.
        if let Some(folder) = &self.out
            && !make(folder)
        {
            return Status::Failed;
        }
        if let Err(message) = self.picture.check() {
            return SceneError::NoFile(message).say();
        }
        if !self.quick && !self.hard && self.scene.is_empty() {
            say_as_program("every stage is measured, for several minutes; --quick takes less than one");
        }
        let mut progress = |title: &str| say_as_program(format_args!("measuring: {title}"));
        let (files, broken) = if self.hard {
            let rows = hard(&mut progress);
            let failed = rows.iter().filter(|r| !r.passed);
            let broken: Vec<String> = failed.map(|r| format!("{}: {}", r.case, r.measured)).collect();
            (vec![("hard.md".to_owned(), write::hard_markdown(&rows).into_bytes())], broken)
        } else {
            let (simd, threads) = self.drawing.level_and_threads();
            let effort = if self.quick { Effort::QUICK } else { Effort::FULL };
            // One thread unless told otherwise: what the machine's cores add is a table of its own.
            let effort = effort.drawn_by(simd, threads.unwrap_or(1));
            let peers = match self.peers() {
                Ok(peers) => peers,
                Err(error) => return error.say(),
            };
            let mut report = match self.report(effort, &mut progress) {
                Ok(report) => report,
                Err(error) => return error.say(),
            };
            report.sections.extend(peers);
            let machine = machine(&self.command());
            let json = format!("{:#}\n", write::json(&report, &machine));
            let texts = [
                ("report.md", write::markdown(&report, &machine)),
                ("report.json", json),
                ("report.html", write::html(&report, &machine)),
                ("report.svg", write::contact_sheet(&report, &machine)),
            ];
            let mut files: Vec<(String, Vec<u8>)> =
                texts.into_iter().map(|(name, text)| (name.to_owned(), text.into_bytes())).collect();
            files.extend(write::decision_pictures(&report));
            (files, report.broken_bounds())
        };
        let written = match &self.out {
            Some(folder) => save_all(folder, &files),
            None => {
                output::print(&files[0].1);
                true
            }
        };
        for line in &broken {
            say_as_program(format_args!("outside its bound: {line}"));
        }
        if written && broken.is_empty() { Status::Success } else { Status::Failed }
    }
}

impl ReportArgs {
    /// Returns the command, with the names of its files alone.
    fn command(&self) -> String {
        let (simd, threads) = self.drawing.level_and_threads();
        let quick = if self.quick { " --quick" } else { "" };
        let simd = simd.map_or(String::new(), |level| format!(" --simd {}", level.as_str()));
        let threads = threads.map_or(String::new(), |threads| format!(" --threads {threads}"));
        let named = |option: &str, path: &PathBuf| {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
            format!(" --{option} {}", name.unwrap_or_default())
        };
        let scenes: String = self.scene.iter().map(|path| named("scene", path)).collect();
        let peers = self.peers.as_ref().map_or(String::new(), |path| named("peers", path));
        let size = self.picture.size.map_or(String::new(), |size| format!(" --size {size}"));
        let budgets: String = self.max_error.iter().map(|e| format!(" --max-error {e}")).collect();
        format!("fbptr report{quick}{simd}{threads}{scenes}{size}{budgets}{peers}")
    }

    /// Reads the section of other programs, if there is one.
    fn peers(&self) -> Result<Option<Section>, SceneError> {
        let read = |path: &PathBuf| {
            let bytes = crate::save::read_input(path, 64 << 20).map_err(|e| e.to_string());
            let text = bytes.and_then(|bytes| String::from_utf8(bytes).map_err(|e| e.to_string()));
            let no_file = |e: String| SceneError::NoFile(format!("{}: {e}", path.display()));
            text.and_then(|text| peers_of(&text)).map_err(no_file)
        };
        self.peers.as_ref().map(read).transpose()
    }

    /// Measures the pictures of the command line, or else everything.
    fn report(&self, effort: Effort, progress: &mut dyn FnMut(&str)) -> Result<Report, SceneError> {
        if self.scene.is_empty() {
            return Ok(run(effort, progress));
        }
        let asked = Asked {
            picture: &self.picture,
            meshes: &self.meshes,
            drawing: &self.drawing,
            budgets: &self.max_error,
            load_dir: self.load_dir.as_deref(),
        };
        let decide = |path: &PathBuf| {
            progress(&path.display().to_string());
            asked.decide(&effort, path)
        };
        let decisions = self.scene.iter().map(decide).collect::<Result<_, _>>()?;
        Ok(Report { effort, decisions, sections: Vec::new(), scaling: Vec::new() })
    }
}

/// Creates the folder; returns whether it exists.
fn make(folder: &Path) -> bool {
    std::fs::create_dir_all(folder)
        .inspect_err(|error| say_as_program(format_args!("cannot make {}: {error}", folder.display())))
        .is_ok()
}

/// Writes all files into the folder; returns whether all were written.
fn save_all(folder: &Path, files: &[(String, Vec<u8>)]) -> bool {
    for (name, text) in files {
        let path = folder.join(name);
        if let Err(error) = crate::save::replace(&path, |out| out.write_all(text)) {
            say_as_program(format_args!("cannot write {}: {error}", path.display()));
            return false;
        }
        say_as_program(format_args!("wrote {}", path.display()));
    }
    true
}

/// Returns processor, cores, build, date and command, in one line.
pub(super) fn machine(command: &str) -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|l| l.strip_prefix("model name")?.split_once(": "));
    let processor = model.map_or(std::env::consts::ARCH, |(_, name)| name);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let build = if cfg!(debug_assertions) { "debug build" } else { "release build" };
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (year, month, day) = date(seconds / 86_400);
    let version = env!("CARGO_PKG_VERSION");
    format!(
        "{processor}, {cores} threads, fbptr {version} ({build}), {year}-{month:02}-{day:02}, `{command}`"
    )
}

/// Converts a number of days since 1970-01-01 to year, month and day, by counting years and months.
fn date(mut days: u64) -> (u64, u64, u64) {
    let is_leap = |y: u64| y.is_multiple_of(4) && (!y.is_multiple_of(100) || y.is_multiple_of(400));
    let mut year = 1970;
    while days >= 365 + u64::from(is_leap(year)) {
        days -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let lengths = [31, 28 + u64::from(is_leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let mut month = 0;
    while days >= lengths[month] {
        days -= lengths[month];
        month += 1;
    }
    (year, month as u64 + 1, days + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_become_dates() {
        assert_eq!(date(0), (1970, 1, 1));
        assert_eq!(date(19_782), (2024, 2, 29));
        assert_eq!(date(19_783), (2024, 3, 1));
        assert_eq!(date(20_819), (2027, 1, 1));
    }
}

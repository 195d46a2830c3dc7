//! `fbptr report`: speed against error, or the hard cases, as tables and as a page.

use super::mesh_args::MeshArgs;
use super::render_args::RenderArgs;
use super::scene_file::{self, ReadOptions, SceneError, SceneFile};
use super::{Status, output, say_as_program};
use crate::animation::{Animation, FrameOptions};
use crate::measure::{Effort, Section, UserScene, hard, peers_of, pictures_of, run, write};
use crate::memory::MemoryBudget;
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Measures every stage's alternatives for speed and error, and writes report.md, .json, .html and .svg
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
    /// Only the table of whole pictures, for this scene or mesh file in three dimensions; again for further files
    #[arg(long, value_name = "FILE", conflicts_with = "hard")]
    scene: Vec<PathBuf>,
    /// Also other programs on the workloads W1 to W5, from the peers.json that benches/peers/run.sh writes
    #[arg(long, value_name = "FILE", conflicts_with = "hard")]
    peers: Option<PathBuf>,
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
        if !self.quick && !self.hard && self.scene.is_empty() {
            say_as_program("every stage is measured, for several minutes; --quick takes less than one");
        }
        let mut progress = |title: &str| say_as_program(format_args!("measuring: {title}"));
        let (files, broken) = if self.hard {
            let rows = hard(&mut progress);
            let failed = rows.iter().filter(|r| !r.passed);
            let broken: Vec<String> = failed.map(|r| format!("{}: {}", r.case, r.measured)).collect();
            (vec![("hard.md", write::hard_markdown(&rows))], broken)
        } else {
            let (simd, threads) = self.drawing.level_and_threads();
            let effort = if self.quick { Effort::QUICK } else { Effort::FULL };
            // One thread unless told otherwise: what the machine's cores add is a table of its own.
            let effort = effort.drawn_by(simd, threads.unwrap_or(1));
            let peers = match self.peers() {
                Ok(peers) => peers,
                Err(error) => return error.say(),
            };
            let mut report = match self.scenes() {
                Ok(scenes) if scenes.is_empty() => run(effort, &mut progress),
                Ok(scenes) => pictures_of(effort, scenes, &mut progress),
                Err(error) => return error.say(),
            };
            report.sections.extend(peers);
            let machine = machine(&self.command());
            let json = format!("{:#}\n", write::json(&report, &machine));
            let files = vec![
                ("report.md", write::markdown(&report, &machine)),
                ("report.json", json),
                ("report.html", write::html(&report, &machine)),
                ("report.svg", write::contact_sheet(&report, &machine)),
            ];
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
        format!("fbptr report{quick}{simd}{threads}{scenes}{peers}")
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

    /// Reads the scenes of the command line, each as `fbptr render` draws its first picture.
    fn scenes(&self) -> Result<Vec<UserScene>, SceneError> {
        let budget = MemoryBudget::unlimited();
        let read = |path: &PathBuf| {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            let file =
                scene_file::read(path, ReadOptions { root: None, meshes: &self.meshes }, &budget)?.file;
            if matches!(file, SceneFile::Eye(_)) {
                let message = format!("{name}: an N-dimensional scene; `fbptr eye --bench` measures those");
                return Err(SceneError::NoFile(message));
            }
            let no_file = |e: String| SceneError::NoFile(format!("{name}: {e}"));
            let options = FrameOptions { cull: self.meshes.cull, ..FrameOptions::default() };
            let animation =
                Animation::new(file, name.clone(), options).map_err(|e| no_file(e.to_string()))?;
            let mut scene = animation.scene(0).map_err(|e| no_file(e.to_string()))?;
            let options = animation.scene_options();
            scene.camera.get_or_insert(options.camera);
            Ok(UserScene { name, scene, shade: options.shade, order: options.transparency })
        };
        self.scene.iter().map(read).collect()
    }
}

/// Creates the folder; returns whether it exists.
fn make(folder: &Path) -> bool {
    std::fs::create_dir_all(folder)
        .inspect_err(|error| say_as_program(format_args!("cannot make {}: {error}", folder.display())))
        .is_ok()
}

/// Writes all files into the folder; returns whether all were written.
fn save_all(folder: &Path, files: &[(&str, String)]) -> bool {
    for (name, text) in files {
        let path = folder.join(name);
        if let Err(error) = crate::save::replace(&path, |out| out.write_all(text.as_bytes())) {
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

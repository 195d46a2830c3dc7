//! `fbptr bench`: the fixed workloads, each checked against its exact picture and then timed.

use super::render_args::RenderArgs;
use super::{FrameSize, Status, output, say_as_program};
use crate::measure::bench::{self, Air, BenchOptions, Row, Size, Workload};
use crate::memory::DepthFormat;
use crate::save;
use crate::server::Limits;
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Holds fixed workloads to the truth, then times them: W1 to W5 in three dimensions, W6 lines, W7 pixels, S1 to S7 other scenes
#[derive(Debug, Args)]
pub(super) struct Bench {
    /// Which: W1 to W7, S1 to S7, `scenes` for all of those, whole names, as W4_tex_nearest, or built-in models, as teapot [default: W1 to W7]
    #[arg(value_name = "WORKLOAD", value_parser = workloads)]
    workloads: Vec<Named>,
    /// Frames to time, fewer where they take longer than 6 seconds
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..))]
    frames: u16,
    /// The frame's size; S5 has sizes of its own, scaled down with a smaller one
    #[arg(long, value_name = "WxH", default_value = "1920x1080")]
    size: FrameSize,
    /// Format of stored depths: u16, u24, u32, f32 or reversed
    #[arg(long, value_name = "FORMAT", value_parser = depth_format, default_value = "f32")]
    depth: Depth,
    /// Draw W1 to W5 and S1 to S7 in fog
    #[arg(long)]
    fog: bool,
    /// One JSON object a line instead of a table
    #[arg(long)]
    json: bool,
    /// Write the meshes, the texture and the truth's pictures into this folder, for other programs, and time nothing
    #[arg(long, value_name = "DIR")]
    export: Option<PathBuf>,
    #[command(flatten)]
    drawing: RenderArgs,
}

/// The workloads of one argument.
#[derive(Clone, Debug)]
struct Named(Vec<Workload>);

/// A depth format by its keyword in the command language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Depth(DepthFormat);

impl std::fmt::Display for Depth {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0.as_str())
    }
}

fn depth_format(name: &str) -> Result<Depth, String> {
    let found = DepthFormat::ALL.into_iter().find(|f| name.eq_ignore_ascii_case(f.as_str()));
    found.map(Depth).ok_or_else(|| "expected u16, u24, u32, f32 or reversed".to_owned())
}

fn workloads(name: &str) -> Result<Named, String> {
    match Workload::named(name) {
        none if none.is_empty() => {
            let names = Workload::ALL.map(Workload::name).join(", ");
            Err(format!(
                "expected W1 to W7, S1 to S7, scenes, a built-in model of three dimensions, or one of {names}"
            ))
        }
        some => Ok(Named(some)),
    }
}

impl Bench {
    pub fn run(&self) -> Status {
        let mut chosen: Vec<Workload> = self.workloads.iter().flat_map(|n| n.0.iter().copied()).collect();
        if chosen.is_empty() {
            chosen.extend(&Workload::ALL[..Workload::OF_PEERS]);
        }
        if let Err(error) = Limits::default().check_frame(self.size.width, self.size.height) {
            say_as_program(error.message);
            return Status::BadArguments;
        }
        let options = BenchOptions {
            render: self.drawing.options(),
            depth_format: self.depth.0,
            air: if self.fog { Air::Fog } else { Air::Clear },
            size: Size { width: self.size.width, height: self.size.height, ..Size::FULL },
            frames: self.frames.into(),
            budget: Duration::from_secs(6),
        };
        if let Some(folder) = &self.export {
            return export(folder, &chosen, &options);
        }
        if !self.json {
            output::print(format!("{HEADER}\n"));
        }
        let mut status = Status::Success;
        for workload in chosen {
            match bench::run(workload, &options) {
                Ok(row) if self.json => output::print(row.json() + "\n"),
                Ok(row) => output::print(table_line(&row) + "\n"),
                Err(refusal) => {
                    say_as_program(refusal);
                    status = Status::Failed;
                }
            }
        }
        status
    }
}

const HEADER: &str = "workload           threads  simd      median ms     min ms     p99 ms  frames  max error  pixels off  beside";

fn table_line(row: &Row) -> String {
    let twin = row.twin.as_ref().map_or(String::new(), |t| {
        let name = t.name.replace('_', " ");
        format!("{:.2} times the {name}'s speed ({:.3} ms)", t.median_ms / row.median_ms, t.median_ms)
    });
    let scaling = row.scaling.as_ref().map_or(String::new(), |g| {
        let exponent = g.exponent.map_or(String::new(), |b| format!(", exponent {b:.2}"));
        let steps: Vec<String> = g.steps.iter().map(|(x, ms)| format!("{x}: {ms:.2}")).collect();
        format!("ms by {}: {}{exponent}", g.what, steps.join(", "))
    });
    let line = format!(
        "{:<18} {:>7}  {:<8} {:>10.3} {:>10.3} {:>10.3} {:>7} {:>6}/255 {:>11}  {twin}{scaling}",
        row.workload.name(),
        row.threads,
        row.simd,
        row.median_ms,
        row.min_ms,
        row.p99_ms,
        row.frames,
        row.check.max_error_steps,
        row.check.pixels_off,
    );
    line.trim_end().to_owned()
}

/// Writes the workloads' data and exact pictures into `folder`.
fn export(folder: &Path, chosen: &[Workload], options: &BenchOptions) -> Status {
    if let Err(error) = std::fs::create_dir_all(folder) {
        say_as_program(format_args!("cannot make {}: {error}", folder.display()));
        return Status::Failed;
    }
    for (name, bytes) in bench::export(options) {
        let path = folder.join(name);
        if let Err(error) = crate::save::replace(&path, |out| out.write_all(&bytes)) {
            say_as_program(format_args!("cannot write {}: {error}", path.display()));
            return Status::Failed;
        }
    }
    for &workload in chosen {
        let path = folder.join(workload.name()).with_extension("ppm");
        if let Err(error) = save::to_path(&bench::truth_picture(workload, options), &path) {
            say_as_program(error);
            return Status::Failed;
        }
    }
    Status::Success
}

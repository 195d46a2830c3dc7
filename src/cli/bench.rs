//! `fbptr bench`: the fixed workloads, each checked against its exact picture and then timed.

use super::render_args::RenderArgs;
use super::{FrameSize, Status, output, say_as_program};
use crate::measure::bench::{
    self, Air, BenchOptions, PlaneOptions, PlaneRow, PlaneWork, Row, Size, Workload,
};
use crate::memory::DepthFormat;
use crate::pipeline::RenderOptions;
use crate::save;
use crate::server::Limits;
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Holds fixed workloads to the truth, then times them: W1 to W5 in three dimensions, W6 lines, W7 pixels, S1 to S7 other scenes, 2d streams of figures
#[derive(Debug, Args)]
pub(super) struct Bench {
    /// Which: W1 to W7, S1 to S7, `scenes` for all of those, `2d` for figures in two dimensions, whole names, as W4_tex_nearest, or built-in models, as teapot [default: W1 to W7]
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
    /// Simulate W1 to W5 and S1 to S7 on these numbers of cores, from the time of each piece of a frame on one core
    #[arg(long, value_name = "N,N..", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=1024))]
    cores: Vec<u16>,
    /// One JSON object a line instead of a table
    #[arg(long)]
    json: bool,
    /// Write the meshes, the texture, streams of figures and the truth's pictures into this folder, for other programs, and time nothing
    #[arg(long, value_name = "DIR")]
    export: Option<PathBuf>,
    #[command(flatten)]
    drawing: RenderArgs,
}

/// The workloads of one argument, of space and of the plane.
#[derive(Clone, Debug)]
struct Named(Vec<Workload>, Vec<PlaneWork>);

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
    match (Workload::named(name), PlaneWork::named(name)) {
        (none, no_figures) if none.is_empty() && no_figures.is_empty() => {
            let plane = PlaneWork::ALL.map(PlaneWork::name);
            let names: Vec<_> = Workload::ALL.map(Workload::name).into_iter().chain(plane).collect();
            let names = names.join(", ");
            Err(format!(
                "expected W1 to W7, S1 to S7, scenes, 2d, a built-in model of three dimensions, or one of {names}"
            ))
        }
        (space, plane) => Ok(Named(space, plane)),
    }
}

impl Bench {
    pub fn run(&self) -> Status {
        let mut chosen: Vec<Workload> = self.workloads.iter().flat_map(|n| n.0.iter().copied()).collect();
        let figures: Vec<PlaneWork> = self.workloads.iter().flat_map(|n| n.1.iter().copied()).collect();
        if chosen.is_empty() && figures.is_empty() {
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
            return export(folder, &chosen, &figures, &options);
        }
        if !self.cores.is_empty() {
            return self.run_on_cores(&chosen, &options);
        }
        if !self.json && !chosen.is_empty() {
            output::print(format!("{HEADER}\n"));
        }
        let mut status = self.run_plane(&figures, &options);
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

impl Bench {
    /// Simulates the workloads of space on other numbers of cores.
    fn run_on_cores(&self, chosen: &[Workload], options: &BenchOptions) -> Status {
        let mut status = Status::Success;
        let cores: Vec<usize> = self.cores.iter().map(|&n| n.into()).collect();
        for &workload in chosen.iter().filter(|workload| workload.is_shared()) {
            match bench::run_on_cores(workload, options, &cores) {
                Ok(row) if self.json => output::print(row.json() + "\n"),
                Ok(row) => output::print(format!("{row}\n")),
                Err(refusal) => {
                    say_as_program(refusal);
                    status = Status::Failed;
                }
            }
        }
        status
    }

    /// Runs the workloads of the plane, on one thread and on all unless a number is given.
    fn run_plane(&self, figures: &[PlaneWork], options: &BenchOptions) -> Status {
        let mut status = Status::Success;
        if !self.json && !figures.is_empty() {
            output::print(format!("{PLANE_HEADER}\n"));
        }
        let one_thread = RenderOptions { pool: None, ..options.render.clone() };
        let threads = match (self.drawing.level_and_threads().1.is_some(), &options.render.pool) {
            (false, Some(_)) => vec![one_thread, options.render.clone()],
            _ => vec![options.render.clone()],
        };
        for &work in figures {
            let truth = bench::plane_truth(work, options.size);
            for render in &threads {
                let options = PlaneOptions {
                    render: render.clone(),
                    size: options.size,
                    frames: options.frames,
                    budget: options.budget,
                };
                match bench::run_plane(work, &options, &truth) {
                    Ok(row) if self.json => output::print(row.json() + "\n"),
                    Ok(row) => output::print(plane_line(&row)),
                    Err(refusal) => {
                        say_as_program(format_args!("{}: {refusal}", work.name()));
                        status = Status::Failed;
                    }
                }
            }
        }
        status
    }
}

const PLANE_HEADER: &str = "workload                 threads  figures  median ms     min ms  ns/figure  ns/pixel  of copying  max error";

fn plane_line(row: &PlaneRow) -> String {
    format!(
        "{:<24} {:>7} {:>8} {:>10.3} {:>10.3} {:>10.1} {:>9.3} {:>9.1} % {:>6}/255\n",
        row.work.name(),
        row.threads,
        row.figures,
        row.median_ms,
        row.min_ms,
        row.ns_per_figure(),
        row.ns_per_pixel(),
        row.copy_share() * 100.0,
        row.max_error_steps,
    )
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
fn export(folder: &Path, chosen: &[Workload], figures: &[PlaneWork], options: &BenchOptions) -> Status {
    if let Err(error) = std::fs::create_dir_all(folder) {
        say_as_program(format_args!("cannot make {}: {error}", folder.display()));
        return Status::Failed;
    }
    let streams =
        figures.iter().map(|work| (format!("{}.fbs", work.name()), bench::plane_stream(*work, options.size)));
    let meshes = if chosen.is_empty() { Vec::new() } else { bench::export(options) };
    let meshes = meshes.into_iter().map(|(name, bytes)| (name.to_owned(), bytes));
    for (name, bytes) in meshes.chain(streams) {
        let path = folder.join(name);
        if let Err(error) = crate::save::replace(&path, |out| out.write_all(&bytes)) {
            say_as_program(format_args!("cannot write {}: {error}", path.display()));
            return Status::Failed;
        }
    }
    let space = chosen.iter().map(|w| (w.name(), bench::truth_picture(*w, options)));
    let plane = figures.iter().map(|w| (w.name(), bench::plane_truth(*w, options.size).0));
    for (name, picture) in space.chain(plane) {
        let path = folder.join(name).with_extension("ppm");
        if let Err(error) = save::to_path(&picture, &path) {
            say_as_program(error);
            return Status::Failed;
        }
    }
    Status::Success
}
